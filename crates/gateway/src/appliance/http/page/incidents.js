// Incidents and events: searched, exported, and each incident by itself.

import { recording, recordingOf, recordings } from "./recordings.js";
import { QUANTITIES, cylinder, cylinderShort, element, millimetres as mm, say, sentence, transducer, utc } from "./words.js";

const KINDS = ["incident", "act", "start", "stop", "reload", "refused", "bus_opened", "bus_lost", "controller", "nmt", "timing", "device", "clock", "doubt", "lost"];
const LEVELS = ["yellow", "orange", "red", "black"];
const SUSPECTS = { c1: "C1", c2: "C2", undecided: "C1 or C2", process: "neither transducer" };
const PAGE = 50;

export class Incidents {
  constructor(place) {
    this.place = place;
    const option = (value, text) => element("option", { value }, text);
    this.text = element("input", { type: "search", maxlength: 200, placeholder: "frozen C2" });
    this.kind = element("select", {}, option("", "everything"), ...KINDS.map((kind) => option(kind, kind.replace("_", " "))));
    this.level = element("select", {}, option("", "any level"), ...LEVELS.map((level) => option(level, `${level} or worse`)));
    this.cylinder = element("select", {}, option("", "all"));
    const label = (text, node) => element("label", {}, text, node);
    this.form = element("form", { class: "search", role: "search" },
      label("Words", this.text), label("What", this.kind), label("Level", this.level), label("Cylinder", this.cylinder),
      element("button", { type: "submit" }, "Search"));
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.search();
    });
    this.note = element("p", { role: "status" });
    this.list = element("ul", { class: "incidents" });
    this.more = element("button", { type: "button", hidden: true }, "Older ones");
    this.more.addEventListener("click", () => this.search(this.next));
    this.csv = element("a", { download: true }, "CSV");
    this.jsonl = element("a", { download: true }, "lines of JSON");
    this.found = element("div", {}, this.form,
      element("p", { class: "quiet" }, "All that is found, as a file: ", this.csv, " ", this.jsonl),
      this.note, this.list, this.more);
    this.single = element("article", { hidden: true });
    place.replaceChildren(element("h2", {}, "Incidents and events"), this.found, this.single);
  }

  build(limits) {
    this.cylinder.append(...limits.map((_, index) => element("option", { value: index + 1 }, cylinderShort(index + 1))));
  }

  /** Shows the incident of that number in the store, or the search. */
  async open(id) {
    this.found.hidden = id != null;
    this.single.hidden = id == null;
    if (id == null) return this.search();
    const [answer, recorded] = await Promise.all([fetch(`/api/incidents/${id}`), recordings()]);
    this.single.replaceChildren(...(answer.ok ? page(await answer.json(), recorded)
      : [element("p", {}, await answer.text()), element("p", {}, element("a", { href: "#incidents" }, "All incidents and events"))]));
  }

  query() {
    const query = new URLSearchParams();
    for (const [name, node] of [["text", this.text], ["kind", this.kind], ["level", this.level], ["cylinder", this.cylinder]]) {
      if (node.value) query.set(name, node.value);
    }
    return query;
  }

  async search(before) {
    const query = this.query();
    this.csv.href = `/api/export/events.csv?${query}`;
    this.jsonl.href = `/api/export/events.jsonl?${query}`;
    query.set("limit", PAGE);
    if (before != null) query.set("before", before);
    const answer = await fetch(`/api/events?${query}`);
    if (!answer.ok) {
      this.list.replaceChildren();
      this.more.hidden = true;
      return say(this.note, await answer.text());
    }
    const { entries, next } = await answer.json();
    const rows = entries.map(row);
    if (before == null) this.list.replaceChildren(...rows);
    else this.list.append(...rows);
    say(this.note, this.list.children.length === 0 ? "Nothing is found." : "");
    this.next = next;
    this.more.hidden = next == null;
  }
}

function row(entry) {
  const incident = entry.kind === "incident";
  const id = incident ? entry.id : entry.about;
  return element("li", {},
    element("span", { class: `level ${(incident && entry.level) || ""}` }, incident ? entry.level : entry.kind.replace("_", " ")), " ",
    element("time", {}, utc(entry.at_s)), " ",
    id != null ? element("a", { href: `#incidents/${id}` }, entry.text) : entry.text,
    incident && entry.ending ? element("span", { class: "quiet" }, ` ${entry.ending}`) : null);
}

/** Whom an incident is about. */
function suspect(it) {
  const which = ["c1", "c2"].indexOf(it.suspect) + 1;
  return which > 0 && it.cylinder != null ? transducer(it.cylinder, which) : SUSPECTS[it.suspect] ?? it.suspect;
}

/** The page of one incident. */
function page(it, { folder, recordings: all }) {
  const facts = [
    ["Cylinder", it.cylinder == null ? "the machine" : cylinderShort(it.cylinder)], ["Suspect", suspect(it)],
    ["Suspect named", it.named_s == null ? "–" : `${utc(it.named_s)}${it.named_by_its_end ? ", when the fault ended" : ""}`], ["Level reached", it.level],
    ["Begin", utc(it.begin_s)], ["Onset", utc(it.onset_s)],
    ["End", it.end_s == null ? "it is open" : `${utc(it.end_s)}, ${it.ending}`],
    ["Size", mm(it.size_m)], ["Largest", it.quantity ? `${QUANTITIES[it.quantity] ?? it.quantity} ${mm(it.peak_m)} of ${mm(it.limit_m)}` : "–"],
    ...(it.now_m == null ? [] : [["Now", `${QUANTITIES[it.quantity] ?? it.quantity} ${mm(it.now_m)}`]]),
    ["Detectors", it.detectors],
  ];
  const own = recordingOf(it, all);
  const frames = own ? recording(own)
    : folder === null ? "not recorded: [recorder] of the configuration has no folder"
    : "there is no recording yet, or it gave way to newer ones";
  const list = (title, rows) => (rows.length ? [element("h3", {}, title), element("ul", {}, ...rows.map((text) => element("li", {}, text)))] : []);
  return [
    element("p", {}, element("a", { href: "#incidents" }, "All incidents and events"),
      ...(it.cylinder == null ? [] : [" · ", element("a", { href: `#trends/${it.cylinder}` }, `Trends of ${cylinder(it.cylinder)}`)])),
    element("h3", {}, it.text),
    element("p", {}, sentence(it.evidence)), element("p", {}, sentence(it.course)), element("p", {}, element("strong", {}, it.advice)),
    element("dl", { class: "facts" }, ...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]),
      element("dt", {}, "Frames"), element("dd", {}, frames)),
    ...list("Acts", it.acts.map((act) => `${utc(act.at_s)} ${act.kind} by ${act.who}${act.note ? `: ${act.note}` : ""}${act.until_s == null ? "" : `, until ${utc(act.until_s)}`}`)),
    ...list("Course", it.revisions.map((revision) => `${utc(revision.at_s)} ${revision.progress}: ${revision.text}`)),
    ...list("Warnings", it.warnings.map((warning) => `${utc(warning.at_s)} ${warning.detector} ${warning.state}: ${warning.suspect}${warning.by ? ` by ${warning.by}` : ""}`)),
  ];
}
