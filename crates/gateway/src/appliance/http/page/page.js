// The page: what the gateway says, and which view is shown.

import { Alarms } from "./alarms.js";
import { Incidents } from "./incidents.js";
import { Maintenance } from "./maintenance.js";
import { Overview, incident } from "./overview.js";
import { Trends } from "./trends.js";
import { ago, callThem, plural, say, sentence, symbol, utc } from "./words.js";

const VIEWS = ["overview", "trends", "alarms", "incidents", "maintenance"];
const CONDITIONS = { ok: "good", unknown: "unknown", degraded: "out_of_specification", down: "failure" };
/** Time without an event after which nothing is known, ms. */
const SILENCE = 3000;

const at = (id) => document.getElementById(id);
const overview = new Overview(at("view-overview"));
const trends = new Trends(at("view-trends"));
const alarms = new Alarms(at("view-alarms"), at("spoken"));
const incidents = new Incidents(at("view-incidents"));
const maintenance = new Maintenance(at("view-maintenance"));
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
  if (view === "maintenance") maintenance.open();
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
  condition(now.status, `${sentence(now.reason)} ${sentence(`${bus}, ${now.mode ?? "not monitoring"}`)}${now.platform ? ` Platform ${now.platform}.` : ""}`);
  say(at("clock"), utc(now.time));
  showAlarms(now);
  maintenance.show(now);
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

/** Without events nothing is known, whatever was shown last. */
function listen() {
  const since = Date.now() - heard;
  if (heard === 0 || since < SILENCE) return;
  condition("unknown", `No connection to the gateway since ${ago(since / 1000)}: nothing below is of now.`);
  if (newest && document.body.dataset.lost !== "true") {
    const words = "unknown: no connection to the gateway";
    const unknown = (cylinder) => ({
      ...cylinder, residuals_mm: [null, null, null], estimate_m: null, sigma_mm: null,
      transducers: cylinder.transducers.map((it) => it.lamp === "not_fitted" ? it : { ...it, lamp: "unknown", words }),
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
  callThem(machine.names);
  overview.build(machine.limits_m);
  trends.build(machine.limits_m);
  incidents.build(machine.limits_m);
  maintenance.build(machine);
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
