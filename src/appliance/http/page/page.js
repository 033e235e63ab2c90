// The page: what the gateway says, and which view is shown.

import { Alarms } from "./alarms.js";
import { Incidents } from "./incidents.js";
import { Overview, incident } from "./overview.js";
import { Recordings } from "./recordings.js";
import { Trends } from "./trends.js";
import { ago, element, left, number, plural, say, sentence, symbol, utc } from "./words.js";

const VIEWS = ["overview", "trends", "alarms", "incidents", "maintenance"];
const CONDITIONS = { ok: "good", unknown: "unknown", degraded: "out_of_specification", down: "failure" };
/** Time without an event after which nothing is known, ms. */
const SILENCE = 3000;

const at = (id) => document.getElementById(id);
const overview = new Overview(at("view-overview"));
const trends = new Trends(at("view-trends"));
const alarms = new Alarms(at("view-alarms"), at("spoken"));
const incidents = new Incidents(at("view-incidents"));
const recorded = new Recordings();
const state = element("div");
let machine = null;
let newest = null;
let heard = 0;
let levelSaid = null;

function route() {
  const [name, detail] = location.hash.slice(1).split("/");
  const view = VIEWS.includes(name) ? name : "overview";
  for (const other of VIEWS) at(`view-${other}`).hidden = other !== view;
  for (const link of document.querySelectorAll("nav a")) {
    if (link.hash === `#${view}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  document.title = `${machine.name}: ${view}`;
  if (view === "trends") trends.open(Number(detail) || trends.cylinder);
  else trends.close();
  if (view === "alarms") {
    showAlarms.read = 0;
    showAlarms(newest);
  }
  if (view === "maintenance") recorded.refresh();
  if (view === "incidents") incidents.open(detail ? Number(detail) : null);
}

/** Says how it is in the head of the page. */
function condition(state, words) {
  const node = at("condition");
  const category = CONDITIONS[state] ?? "unknown";
  if (node.dataset.state !== category) {
    node.dataset.state = category;
    node.className = `condition lamp ${category}`;
    node.querySelector(".symbol").replaceChildren(symbol(category));
  }
  say(node.querySelector(".text"), words);
}

function show(now) {
  newest = now;
  overview.show(now);
  const bus = now.bus === "open" ? (now.controller ? `controller ${now.controller}` : "bus open") : "bus closed";
  condition(now.status, `${sentence(now.reason)} ${sentence(`${bus}, ${now.mode ?? "not monitoring"}`)}`);
  say(at("clock"), utc(now.time));
  showAlarms(now);
  maintenance(now);
  const said = `${now.level}/${now.incidents.map((it) => it.number).join()}`;
  if (levelSaid !== null && said !== levelSaid) {
    say(at("spoken"), now.incidents.length ? `${plural(now.incidents.length, "incident")}. ${now.incidents[0].summary}` : "No incident stands.");
  }
  levelSaid = said;
}

/** The alarm list, of which the number waits in the menu. */
async function showAlarms(now) {
  const key = now && JSON.stringify(now.incidents);
  const fresh = key === showAlarms.key && Date.now() - showAlarms.read < 3000;
  if (!now || showAlarms.busy || fresh) return;
  showAlarms.busy = true;
  [showAlarms.key, showAlarms.read] = [key, Date.now()];
  try {
    const found = await alarms.refresh();
    if (found === null) alarms.fallback(now.incidents.map(incident));
    const waiting = found ? found.alarms.filter((it) => it.state.includes("unacknowledged")).length : now.incidents.length;
    const count = at("count");
    count.hidden = waiting === 0;
    say(count, String(waiting));
  } finally {
    showAlarms.busy = false;
  }
}

function maintenance(now) {
  const place = state;
  const rows = now.cylinders.flatMap((cylinder) => cylinder.transducers.map((it, which) => [
    `Cylinder ${cylinder.number}, C${which + 1}`, it.words, number(cylinder.dwells, 0),
    it.drift_mm_per_month == null ? "–" : `${number(it.drift_mm_per_month, 3)} ± ${number(it.error_mm_per_month, 3)}`,
    left(it.months_left) || "–",
  ]));
  const key = JSON.stringify(rows);
  if (place.dataset.key === key) return;
  place.dataset.key = key;
  const header = ["Transducer", "State", "Readings on the stop", "Drift, mm a month", "Time left"];
  place.replaceChildren(
    element("h2", {}, "Transducers"),
    table("Transducers and their drift on the stops", header, rows),
    element("h2", {}, "Gateway"),
    table("The gateway", ["What", "Value"], [
      ["Program", `tertius ${machine.version}`], ["Machine", machine.name], ["Configuration", machine.configuration],
      ["Its identity", machine.identity]]),
    element("h2", {}, "Limits, mm"),
    table("Limits", ["Cylinder", "R1", "R2", "R3", "C1 − C2"],
      machine.limits_m.map((limits, index) => [String(index + 1), ...limits.map((limit) => number(limit * 1e3, 2))])));
}

function table(name, header, rows) {
  return element("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": name },
    element("table", {},
      element("thead", {}, element("tr", {}, ...header.map((cell) => element("th", { scope: "col" }, cell)))),
      element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map((cell) => element("td", {}, cell)))))));
}

/** Without events nothing is known, whatever was shown last. */
function listen() {
  const since = Date.now() - heard;
  if (heard === 0 || since < SILENCE) return;
  condition("unknown", `No connection to the gateway since ${ago(since / 1000)}: nothing below is of now.`);
  if (newest && document.body.dataset.lost !== "true") {
    const words = "unknown: no connection to the gateway";
    const unknown = (cylinder) => ({
      ...cylinder, residuals_mm: [null, null, null], estimate_m: null, sigma_mm: null,
      transducers: cylinder.transducers.map((it) => ({ ...it, lamp: "unknown", words })),
    });
    overview.show({ ...newest, mode: null, seconds_since_frame: null, cylinders: newest.cylinders.map(unknown) });
  }
  if (document.body.dataset.lost !== "true") ask().catch(() => {});
  document.body.dataset.lost = "true";
}

/** Whoever is not logged in, or not any more, is asked to. */
async function ask() {
  const answer = await fetch("/api/machine");
  if (answer.status === 401) location.assign("/login");
  return answer;
}

/** Only who has logged in can leave: those at this computer have not. */
function offerToLeave() {
  at("leave").hidden = location.protocol !== "https:" || ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);
  at("leave").addEventListener("click", async () => {
    await fetch("/logout", { method: "POST" });
    location.assign("/login");
  });
}

function watch() {
  const events = new EventSource("/api/stream");
  events.addEventListener("overview", (event) => {
    heard = Date.now();
    document.body.dataset.lost = "false";
    const now = JSON.parse(event.data);
    if (now && now.cylinders.length !== machine.limits_m.length && now.cylinders.length > 0) return restart();
    if (now) show(now);
  });
  events.addEventListener("bins", (event) => trends.take(JSON.parse(event.data) ?? []));
  setInterval(listen, 1000);
}

/** The machine is another one than when the page was loaded. */
function restart() {
  location.reload();
}

async function start() {
  const answer = await ask();
  machine = await answer.json();
  say(at("machine"), machine.name || "Tertius");
  overview.build(machine.limits_m);
  trends.build(machine.limits_m);
  incidents.build(machine.limits_m);
  at("view-maintenance").replaceChildren(state, recorded.node);
  addEventListener("hashchange", route);
  route();
  offerToLeave();
  heard = Date.now();
  watch();
}

start().catch((error) => {
  heard = 0;
  condition("down", `The gateway does not answer (${error.message}); load the page again.`);
});
