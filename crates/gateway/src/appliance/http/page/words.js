// Elements, symbols and numbers, as every view shows them.

/** An element `tag` with attributes and children; texts are texts, never markup. */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === true) node.setAttribute(name, "");
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child != null));
  return node;
}

/** Sets the text of `node` only where it differs, so that nothing is redrawn or read out for nothing. */
export function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

const SVG = "http://www.w3.org/2000/svg";

// Shapes and signs in the categories of NAMUR NE 107, so that no state is told by its colour alone.
const SHAPES = {
  failure: { path: "M12 1.5a10.5 10.5 0 1 0 0 21 10.5 10.5 0 0 0 0-21z", sign: "M7.5 7.5l9 9m0-9l-9 9" },
  check_function: { path: "M1.5 3h21L12 22.5z", sign: "M12 6.5v6m0 3v.5" },
  out_of_specification: { path: "M12 1.5L22.5 21h-21z", sign: "M9.6 10.4a2.4 2.4 0 1 1 3.4 2.2c-.7.4-1 .8-1 1.6m0 2.8v.4" },
  maintenance_required: { path: "M12 1l11 11-11 11L1 12z", sign: "M8 15.5v-6l4 4 4-4v6" },
  good: { path: "M12 1.5a10.5 10.5 0 1 0 0 21 10.5 10.5 0 0 0 0-21z", sign: "M7 12.5l3.5 3.5L17.5 8.5" },
  not_fitted: { path: "M4 11h16v2H4z", sign: "" },
  unknown: { path: "M12 2.5a9.5 9.5 0 1 0 0 19 9.5 9.5 0 0 0 0-19z", sign: "M8 12h8" },
};

function drawn(shape) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  for (const [name, d] of [["shape", shape.path], ["sign", shape.sign]]) {
    const path = document.createElementNS(SVG, "path");
    path.setAttribute("class", name);
    path.setAttribute("d", d);
    svg.append(path);
  }
  return svg;
}

/** A lamp: its symbol and a place for words. */
export function lamp() {
  const symbol = element("span", { class: "symbol" });
  const text = element("span", { class: "text" });
  return { node: element("span", { class: "lamp" }, symbol, text), symbol, text, shown: null };
}

/** Turns `lamp` to a state with words. */
export function light(lamp, state, words) {
  if (lamp.shown !== state) {
    lamp.node.className = `lamp ${state}`;
    lamp.symbol.replaceChildren(drawn(SHAPES[state] ?? SHAPES.unknown));
    lamp.shown = state;
  }
  say(lamp.text, words);
}

/** The symbol of a state by itself. */
export function symbol(state) {
  return drawn(SHAPES[state] ?? SHAPES.unknown);
}

/** Names of the machine's cylinders and transducers, from the first cylinder; none where there are none. */
let names = [];

/** Takes the names of the machine. */
export function callThem(list) {
  names = list ?? [];
}

const called = (numbered, name) => (name == null ? numbered : `${numbered} (${name})`);

/** A cylinder in a sentence: "cylinder 3", "cylinder 3 (FwdPort)". */
export function cylinder(number) {
  return called(`cylinder ${number}`, names[number - 1]?.name);
}

/** A cylinder as a heading. */
export function cylinderTitle(number) {
  return called(`Cylinder ${number}`, names[number - 1]?.name);
}

/** A cylinder where there is little room: "3", "3 FwdPort". */
export function cylinderShort(number) {
  const name = names[number - 1]?.name;
  return name == null ? String(number) : `${number} ${name}`;
}

/** Transducer 1 or 2 of a cylinder: "C1", "C1 (LT-101A)". */
export function transducer(number, which) {
  return called(`C${which}`, names[number - 1]?.[`c${which}_name`]);
}

/** `value` with so many decimals, or a dash. */
export function number(value, decimals) {
  return value == null ? "–" : value.toFixed(decimals).replace("-", "−");
}

/** Names of what is compared with limits. */
export const QUANTITIES = { r1: "R1", r2: "R2", r3: "R3", c1_c2: "C1 − C2" };

/** A length in metres, in millimetres, or a dash. */
export function millimetres(metres) {
  return metres == null ? "–" : `${number(metres * 1e3, 2)} mm`;
}

/** A time stamp in seconds, in UTC. */
export function utc(seconds) {
  return `${new Date(seconds * 1000).toISOString().slice(0, 19).replace("T", " ")} UTC`;
}

/** A time of day in UTC. */
export function timeOfDay(seconds) {
  return new Date(seconds * 1000).toISOString().slice(11, 19);
}

/** How long ago, in words. */
export function ago(seconds) {
  if (seconds < 120) return `${Math.max(0, Math.round(seconds))} s ago`;
  if (seconds < 7200) return `${Math.round(seconds / 60)} min ago`;
  if (seconds < 172800) return `${Math.round(seconds / 3600)} h ago`;
  return `${Math.round(seconds / 86400)} days ago`;
}

/** `text` as a sentence. */
export function sentence(text) {
  return text ? `${text.charAt(0).toUpperCase()}${text.slice(1)}${text.endsWith(".") ? "" : "."}` : "";
}

/** "1 alarm", "3 alarms". */
export function plural(count, word) {
  return `${count} ${word}${count === 1 ? "" : "s"}`;
}

/** Months left until maintenance, in words; empty where the stops do not name the transducer. */
export function left([expected, earliest, latest]) {
  if (expected == null) return "";
  const range = earliest != null && latest != null ? ` (${number(earliest, 0)} to ${number(latest, 0)})` : "";
  return `maintenance in ${number(expected, 0)} months${range}`;
}
