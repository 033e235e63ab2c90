// Maintenance: the transducers' drift on the stops, the gateway, its computer, and what was recorded.

import { Recordings } from "./recordings.js";
import { cylinderShort, cylinderTitle, element, lamp, left, light, number, plural, say, transducer, utc } from "./words.js";

/** How the doctor's verdicts look. */
const VERDICTS = { ok: "good", warn: "out_of_specification", fail: "failure" };
/** Most stops that are listed, the newest. */
const STOPS = 50;

export class Maintenance {
  constructor(place) {
    this.state = element("div");
    this.facts = element("div");
    this.stops = new Stops();
    this.computer = new Computer();
    this.recorded = new Recordings();
    place.replaceChildren(this.state, this.stops.node, this.facts, this.computer.node, this.recorded.node);
  }

  build(machine) {
    this.facts.replaceChildren(
      element("h2", {}, "Gateway"),
      table("The gateway", ["What", "Value"], [
        ["Program", `tertius ${machine.version}`], ["Machine", machine.name], ["Configuration", machine.configuration],
        ["Its identity", machine.identity], ["Calibration", calibration(machine)]]),
      element("h2", {}, "Limits, mm"),
      table("Limits", ["Cylinder", "R1", "R2", "R3", "C1 − C2"],
        machine.limits_m.map((limits, index) => [cylinderShort(index + 1), ...limits.map((limit) => limit == null ? "–" : number(limit * 1e3, 2))])));
    this.stops.build(machine.limits_m.length);
  }

  open() {
    this.recorded.refresh();
    this.computer.refresh();
    this.stops.refresh();
  }

  show(now) {
    const rows = now.cylinders.flatMap((cylinder) => cylinder.transducers.map((it, which) => [
      `${cylinderTitle(cylinder.number)}, ${transducer(cylinder.number, which + 1)}`, it.words, number(cylinder.dwells, 0),
      it.drift_mm_per_month == null ? "–" : `${number(it.drift_mm_per_month, 3)} ± ${number(it.error_mm_per_month, 3)}`,
      left(it.months_left) || "–",
    ]));
    const key = JSON.stringify(rows);
    if (this.key === key) return;
    this.key = key;
    const header = ["Transducer", "State", "Readings on the stop", "Drift, mm a month", "Time left"];
    this.state.replaceChildren(
      element("h2", {}, "Transducers"), table("Transducers and their drift on the stops", header, rows));
  }
}

/** What both transducers of a cylinder said on the stop, time after time. */
class Stops {
  constructor() {
    this.cylinder = element("select");
    this.cylinder.addEventListener("change", () => this.refresh());
    this.note = element("p", { role: "status" });
    this.list = element("div");
    this.node = element("section", { "aria-label": "Stops" }, element("h2", {}, "Readings on the stop"),
      element("p", { class: "choice" }, element("label", {}, "Cylinder ", this.cylinder)), this.note, this.list);
  }

  build(cylinders) {
    const numbers = Array.from({ length: cylinders }, (_, index) => index + 1);
    this.cylinder.replaceChildren(...numbers.map((it) => element("option", { value: it }, cylinderShort(it))));
  }

  async refresh() {
    const answer = await fetch(`/api/stops/${this.cylinder.value}`);
    if (!answer.ok) {
      this.list.replaceChildren();
      return say(this.note, await answer.text());
    }
    const stops = (await answer.json()).toSorted((a, b) => b.at_s - a.at_s);
    const first = stops.at(-1);
    // A cylinder with one transducer has no C2.
    const millimetres = (length) => (length == null ? "–" : number(length * 1e3, 3));
    const since = (stop, which) =>
      stop[which] == null || first[which] == null ? "–" : millimetres(stop[which] - first[which]);
    const rows = stops.slice(0, STOPS).map((stop) => [
      utc(stop.at_s), millimetres(stop.c1_m), millimetres(stop.c2_m),
      stop.c2_m == null ? "–" : millimetres(stop.c1_m - stop.c2_m), since(stop, "c1_m"), since(stop, "c2_m")]);
    const header = ["Time", "C1, mm", "C2, mm", "C1 − C2, mm", "C1 since the first, mm", "C2 since the first, mm"];
    say(this.note, first
      ? `${plural(stops.length, "reading")} since ${utc(first.at_s)}${rows.length < stops.length ? `; the last ${rows.length}:` : ":"}`
      : "The cylinder has not been on its stop for long enough since the event store was begun.");
    this.list.replaceChildren(...(first ? [table("Readings on the stop", header, rows)] : []));
  }
}

/** What the doctor finds on the gateway's computer. */
class Computer {
  constructor() {
    this.note = element("p", { class: "quiet", role: "status" });
    this.list = element("ul", { class: "findings" });
    this.node = element("section", { "aria-label": "Computer" }, element("h2", {}, "Computer"), this.note, this.list);
  }

  async refresh() {
    const answer = await fetch("/api/doctor");
    if (!answer.ok) {
      this.list.replaceChildren();
      return say(this.note, await answer.text());
    }
    const { at_s, findings } = await answer.json();
    say(this.note, `Examined at ${utc(at_s)}, without listening to the bus; tertius doctor does that, too.`);
    this.list.replaceChildren(...findings.map(finding));
  }
}

/** The calibration's identity and the age of what it was learnt from, or that there is none. */
function calibration({ calibration: identity, calibration_recorded: recorded }) {
  if (!identity) return "none: no cylinder has been calibrated";
  if (!recorded) return `${identity}, of an unknown day`;
  const days = Math.floor((Date.now() - Date.parse(`${recorded}T00:00:00Z`)) / 86_400_000);
  const age = days < 0 ? "which is to come: is the clock right?" : days === 0 ? "today" : `${plural(days, "day")} ago`;
  return `${identity}, from recordings until ${recorded}, ${age}`;
}

function finding({ verdict, subject, found, advice }) {
  const it = lamp();
  light(it, VERDICTS[verdict] ?? "unknown", `${subject}: ${found}`);
  return element("li", {}, it.node, ...(advice ? [element("p", { class: "quiet" }, advice)] : []));
}

function table(name, header, rows) {
  return element("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": name },
    element("table", {},
      element("thead", {}, element("tr", {}, ...header.map((cell) => element("th", { scope: "col" }, cell)))),
      element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map((cell) => element("td", {}, cell)))))));
}
