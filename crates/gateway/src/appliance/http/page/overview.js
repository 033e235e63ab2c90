// The overview: lamps, residuals against their limits, the virtual sensor, drifts.

import { QUANTITIES, cylinderTitle, element, lamp, left, light, millimetres, number, plural, say, timeOfDay, transducer } from "./words.js";

const RESIDUALS = ["R1", "R2", "R3"];
const TRANSDUCERS = ["C1", "C2"];

export class Overview {
  constructor(place) {
    this.place = place;
    this.cards = [];
  }

  /** Builds the cards of a machine with these limits of each cylinder, m. */
  build(limits) {
    this.limits = limits;
    this.incidents = element("ul", { class: "incidents" });
    const none = element("p", { class: "none" });
    this.none = none;
    this.cards = limits.map((_, index) => card(index + 1));
    this.place.replaceChildren(
      element("h2", {}, "Incidents"), none, this.incidents,
      element("h2", {}, "Cylinders"),
      element("ul", { class: "cards" }, ...this.cards.map((card) => card.node)),
      legend(),
    );
  }

  show(overview) {
    this.tell(overview);
    overview.cylinders.forEach((cylinder, index) => {
      const card = this.cards[index];
      if (card) fill(card, cylinder, this.limits[index]);
    });
  }

  /** What stands, the worst first. */
  tell(overview) {
    const { incidents, seconds_since_frame: silence } = overview;
    const judging = overview.mode === "monitoring";
    say(this.none, incidents.length > 0 ? ""
      : judging ? "None stands, and everything is judged."
      : silence == null || silence > 1 ? "None stands. There are no frames of the machine: nothing is judged."
      : "None stands, but not everything is judged now.");
    this.none.hidden = incidents.length > 0;
    const key = JSON.stringify(incidents, (name, value) => (name === "now_m" ? undefined : value));
    if (key !== this.told) {
      this.told = key;
      this.incidents.replaceChildren(...incidents.map(incident));
    }
    incidents.forEach((it, place) => say(this.incidents.children[place].querySelector(".now"), now(it)));
  }
}

/** One incident in a line. */
export function incident(it) {
  return element("li", {},
    element("span", { class: `level ${it.level}` }, it.level), " ",
    it.cylinder == null ? it.summary : element("a", { href: `#trends/${it.cylinder}` }, it.summary), " ",
    element("span", { class: "quiet" }, `since ${timeOfDay(it.begin)} UTC, incident ${it.number}`,
      element("span", { class: "now" }, now(it))));
}

/** What the worst residual of an incident is now. */
function now({ quantity, now_m: value }) {
  return value == null ? "" : `, ${QUANTITIES[quantity] ?? quantity} is ${millimetres(value)} now`;
}

function card(number) {
  const lamps = TRANSDUCERS.map(() => lamp());
  const drifts = TRANSDUCERS.map(() => element("span", { class: "quiet drift" }));
  const bars = RESIDUALS.map((name) => bar(name));
  const estimate = element("p", { class: "estimate" });
  const rows = TRANSDUCERS.map((_, which) => element("div", { class: "transducer" },
    element("span", { class: "name" }, transducer(number, which + 1)), lamps[which].node, drifts[which]));
  const title = cylinderTitle(number);
  const node = element("li", { class: "card" },
    element("h3", {}, element("a", { href: `#trends/${number}` }, title)),
    ...rows, element("div", { class: "bars" }, ...bars.map((bar) => bar.node)), estimate);
  return { node, lamps, drifts, bars, estimate };
}

/** A residual against its limit. */
function bar(name) {
  const value = element("span", { class: "value" });
  const full = element("span", { class: "full" });
  const track = element("span", { class: "track", "aria-hidden": "true" }, full);
  return { node: element("div", { class: "bar" }, element("span", { class: "name" }, name), track, value), value, full };
}

function fill(card, cylinder, limits) {
  cylinder.transducers.forEach((it, which) => {
    light(card.lamps[which], it.lamp, it.words);
    const drift = it.drift_mm_per_month;
    const parts = drift == null ? [] : [`${number(drift, 2)} ± ${number(it.error_mm_per_month, 2)} mm a month`];
    const due = left(it.months_left);
    if (due) parts.push(due);
    say(card.drifts[which], parts.join(", "));
  });
  cylinder.residuals_mm.forEach((size, which) => {
    const bar = card.bars[which];
    bar.node.hidden = limits[which] == null;
    if (limits[which] == null) return;
    const limit = limits[which] * 1e3;
    const share = size == null ? 0 : size / limit;
    say(bar.value, size == null ? `not judged (limit ${number(limit, 2)} mm)`
      : `${number(size, 2)} of ${number(limit, 2)} mm`);
    bar.full.style.width = `${Math.min(100, 100 * share).toFixed(0)}%`;
    bar.node.classList.toggle("beyond", share >= 1);
    bar.node.classList.toggle("absent", size == null);
  });
  const { estimate_m: estimate, sigma_mm: sigma } = cylinder;
  say(card.estimate, estimate == null ? ""
    : `Virtual sensor ${number(estimate, 3)} m ± ${number(2 * sigma, 2)} mm (2 σ)`);
  card.estimate.hidden = estimate == null;
}

const CATEGORIES = [
  ["good", "good: judged, and nothing found"],
  ["failure", "failure: a warning blames it"],
  ["out_of_specification", "out of specification: it may be this one"],
  ["check_function", "check function: its device is not operational, or its frames lack what is configured"],
  ["maintenance_required", "maintenance required: it drifts"],
  ["not_fitted", "not fitted: this cylinder does not have it"],
  ["unknown", "unknown: no evidence, neither good nor bad"],
];

function legend() {
  const entry = ([state, words]) => {
    const it = lamp();
    light(it, state, words);
    return element("li", {}, it.node);
  };
  return element("details", { class: "legend" }, element("summary", {}, `What the ${plural(CATEGORIES.length, "lamp")} say (NAMUR NE 107)`),
    element("ul", {}, ...CATEGORIES.map(entry)));
}
