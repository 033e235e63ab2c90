// The trends of a cylinder: lengths and residuals of the last hour, and live.

import { cylinder as called, cylinderShort, cylinderTitle, element, number, say, timeOfDay } from "./words.js";

const WINDOWS = [[60, "1 min"], [600, "10 min"], [3600, "1 h"]];
const KEPT = 7300;
/** The quantities of a row of the stream, in their order: the least and the largest of each. */
const QUANTITIES = ["c1", "c2", "r1", "r2", "r3", "estimate", "sigma"];

export class Trends {
  constructor(place) {
    this.place = place;
    this.cylinder = 1;
    this.window = 600;
    this.time = [];
    this.columns = {};
    this.zoomed = null;
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
    addEventListener("resize", () => this.resize());
  }

  build(limits) {
    this.limits = limits;
    this.choices = limits.map((_, index) =>
      element("a", { href: `#trends/${index + 1}`, "aria-label": cylinderTitle(index + 1) }, cylinderShort(index + 1)));
    this.windows = WINDOWS.map(([seconds, name]) => {
      const button = element("button", { type: "button", "aria-pressed": "false" }, name);
      button.addEventListener("click", () => this.look(seconds));
      return button;
    });
    const button = (name, act) => {
      const node = element("button", { type: "button" }, name);
      node.addEventListener("click", act);
      return node;
    };
    this.freeze = element("button", { type: "button", "aria-pressed": "false" }, "Freeze");
    this.freeze.addEventListener("click", () => this.setFrozen(!this.frozen));
    this.plots = element("div", { class: "plots" });
    this.place.replaceChildren(
      element("h2", { id: "trends-title" }, "Trends"),
      element("div", { class: "tools" },
        element("div", { class: "choice", role: "group", "aria-label": "Cylinder" }, element("span", {}, "Cylinder "), ...this.choices),
        element("div", { class: "choice", role: "group", "aria-label": "Length" }, ...this.windows),
        element("div", { class: "choice", role: "group", "aria-label": "View" }, this.freeze,
          button("Zoom in", () => this.zoom(0.5)), button("Zoom out", () => this.zoom(2)),
          button("Earlier", () => this.pan(-0.5)), button("Later", () => this.pan(0.5)))),
      element("p", { class: "quiet" }, "Each point is the least and the largest value of half a second. Drag to zoom, double-click to go back. Times are UTC."),
      this.plots);
    this.figures = figures();
    this.plots.append(...this.figures.map((figure) => figure.node));
  }

  /** Shows `cylinder` from now on; its trend is fetched first. */
  async open(cylinder) {
    this.visible = true;
    const known = cylinder >= 1 && cylinder <= this.limits.length;
    this.cylinder = known ? cylinder : 1;
    this.choices.forEach((node, index) => {
      if (index + 1 === this.cylinder) node.setAttribute("aria-current", "true");
      else node.removeAttribute("aria-current");
    });
    say(document.getElementById("trends-title"), `Trends of ${called(this.cylinder)}`);
    await this.fetch();
    this.look(this.window);
  }

  close() {
    this.visible = false;
  }

  async fetch() {
    const wanted = this.cylinder;
    this.time = [];
    this.columns = Object.fromEntries(QUANTITIES.map((name) => [name, [[], []]]));
    this.fetching = true;
    const answer = await fetch(`/api/trend/${wanted}?seconds=3600`);
    const trend = answer.ok ? await answer.json() : null;
    if (wanted !== this.cylinder) return;
    this.fetching = false;
    if (!trend) return;
    this.time = trend.time;
    for (const { name, least, largest } of trend.quantities) this.columns[name] = [least, largest];
  }

  /** Takes the newest bins of all cylinders. */
  take(rows) {
    if (!this.visible || this.fetching) return;
    for (const [cylinder, time, values] of rows) {
      if (cylinder !== this.cylinder) continue;
      const last = this.time.at(-1) ?? -Infinity;
      if (time < last - 10) return this.fetch().then(() => this.redraw()); // The clock was set back.
      if (time <= last) continue;
      // Where there is nothing for longer than a few bins, nothing is drawn.
      if (time - last > 5 && last > 0) this.append(last + 0.5, []);
      this.append(time, values);
    }
    if (!this.frozen) this.redraw();
  }

  append(time, values) {
    this.time.push(time);
    QUANTITIES.forEach((name, index) => {
      this.columns[name][0].push(values[2 * index] ?? null);
      this.columns[name][1].push(values[2 * index + 1] ?? null);
    });
    if (this.time.length > KEPT) {
      this.time.shift();
      for (const name of QUANTITIES) this.columns[name].forEach((column) => column.shift());
    }
  }

  look(seconds) {
    this.window = seconds;
    this.zoomed = null;
    this.windows.forEach((node, index) => node.setAttribute("aria-pressed", String(WINDOWS[index][0] === seconds)));
    this.setFrozen(false);
  }

  setFrozen(frozen) {
    this.frozen = frozen;
    this.freeze.setAttribute("aria-pressed", String(frozen));
    say(this.freeze, frozen ? "Go on" : "Freeze");
    if (frozen) this.zoomed ??= this.range();
    else this.zoomed = null;
    this.redraw();
  }

  range() {
    if (this.zoomed) return this.zoomed;
    const end = this.time.at(-1) ?? 0;
    // A gateway that has just started has nothing older.
    const begin = Math.min(this.time[0] ?? end, end - 30);
    return [Math.max(end - this.window, begin), end];
  }

  zoom(factor) {
    const [from, to] = this.range();
    const middle = (from + to) / 2;
    const half = Math.max(1, (to - from) / 2 * factor);
    this.zoomTo([middle - half, middle + half]);
  }

  pan(share) {
    const [from, to] = this.range();
    const by = (to - from) * share;
    this.zoomTo([from + by, to + by]);
  }

  zoomTo(range) {
    this.zoomed = range;
    this.setFrozen(true);
  }

  resize() {
    if (this.visible) this.figures.forEach((figure) => figure.plot?.setSize(size(figure)));
  }

  redraw() {
    if (!this.visible) return;
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const range = this.range();
    for (const figure of this.figures) {
      const data = figure.data(this.time, this.columns, this.limits[this.cylinder - 1]);
      if (!figure.plot || figure.dark !== dark) {
        figure.plot?.destroy();
        figure.dark = dark;
        figure.plot = new uPlot(options(figure, this), data, figure.canvas);
      } else {
        figure.plot.setData(data, false);
      }
      figure.plot.setScale("x", { min: range[0], max: range[1] });
      say(figure.summary, figure.words(this.time, this.columns, range, this.limits[this.cylinder - 1]));
    }
  }
}

const MM = 1e3;

/** Least and largest of a quantity in a range of time, in its own unit. */
function extremes(time, [least, largest], [from, to]) {
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < time.length; i += 1) {
    if (time[i] < from || time[i] > to || least[i] == null) continue;
    low = Math.min(low, least[i]);
    high = Math.max(high, largest[i]);
  }
  return low > high ? null : [low, high];
}

const scaled = (column, factor) => column.map((value) => (value == null ? null : value * factor));

/** Words on a residual in a range: how large it was against its limit. */
function residual(name, key, place) {
  return (time, columns, range, limits) => {
    if (limits[place] == null) return `${name}: none, as C2 is not fitted.`;
    const found = extremes(time, columns[key], range);
    if (!found) return `${name}: none in this time.`;
    const most = Math.max(-found[0], found[1]) * MM, limit = limits[place] * MM;
    return `${name}: at most ${number(most, 2)} mm (limit ${number(limit, 2)} mm).`;
  };
}

function figures() {
  const residuals = (title, parts) => ({
    title, unit: "mm", decimals: 2,
    series: parts.map(({ name, colour }) => ({ name, colour })),
    limit: true,
    data: (time, columns, limits) => {
      const most = limits[parts[0].place];
      const line = (sign) => time.map(() => most == null ? null : sign * most * MM);
      return [time, ...parts.flatMap(({ key }) => columns[key].map((it) => scaled(it, MM))), line(1), line(-1)];
    },
    words: (...all) => parts.map(({ name, key, place }) => residual(name, key, place)(...all)).join(" "),
  });
  const list = [
    {
      title: "Length", unit: "m", decimals: 3, limit: false,
      series: [{ name: "C1", colour: "--c1" }, { name: "C2", colour: "--c2" }, { name: "virtual sensor ± 2 σ", colour: "--estimate" }],
      data: (time, { c1, c2, estimate, sigma }) => {
        const beside = (column, sign) => column.map((value, i) => (value == null ? null : value + sign * 2 * (sigma[1][i] ?? 0)));
        return [time, ...c1, ...c2, beside(estimate[0], -1), beside(estimate[1], 1)];
      },
      words: (time, { c1, c2 }, range) => ["C1", "C2"].map((name, which) => {
        const found = extremes(time, [c1, c2][which], range);
        return found ? `${name}: ${number(found[0], 3)} to ${number(found[1], 3)} m.` : `${name}: no readings.`;
      }).join(" "),
    },
    residuals("R1 and R2: each transducer against its observer", [
      { name: "R1", key: "r1", colour: "--c1", place: 0 }, { name: "R2", key: "r2", colour: "--c2", place: 1 }]),
    residuals("R3: C1 against corrected C2", [{ name: "R3", key: "r3", colour: "--r3", place: 2 }]),
  ];
  return list.map((figure) => {
    const canvas = element("div", { class: "canvas", "aria-hidden": "true" });
    const summary = element("figcaption");
    const node = element("figure", {}, element("h3", {}, `${figure.title}, ${figure.unit}`), key(figure), canvas, summary);
    return { ...figure, canvas, summary, node };
  });
}

function key(figure) {
  const entry = (name, colour, kind) => {
    const sample = element("i", { class: kind });
    sample.style.borderColor = `var(${colour})`;
    return element("li", {}, sample, name);
  };
  const entries = figure.series.map(({ name, colour }) => entry(name, colour, "line"));
  if (figure.limit) entries.push(entry("limit", "--alarm-line", "dashed"));
  return element("ul", { class: "key" }, ...entries);
}

const size = (figure) => ({ width: Math.max(260, figure.canvas.clientWidth), height: 190 });

function options(figure, trends) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const series = [{}];
  const bands = [];
  for (const { colour: name } of figure.series) {
    const line = { stroke: colour(name), width: 1, points: { show: false }, spanGaps: false };
    bands.push({ series: [series.length + 1, series.length], fill: `${colour(name)}55` });
    series.push({ ...line }, { ...line });
  }
  if (figure.limit) {
    const line = { stroke: colour("--alarm-line"), width: 1.5, dash: [6, 4], points: { show: false } };
    series.push({ ...line }, { ...line });
  }
  const axis = {
    stroke: colour("--ink"), grid: { stroke: colour("--faint"), width: 1 }, ticks: { stroke: colour("--line"), width: 1 },
    font: "12px system-ui, sans-serif",
  };
  return {
    ...size(figure), series, bands,
    legend: { show: false },
    cursor: { sync: { key: "trends" }, drag: { x: true, y: false } },
    scales: { x: { time: true } },
    tzDate: (stamp) => uPlot.tzDate(new Date(stamp * 1e3), "Etc/UTC"),
    axes: [
      { ...axis, values: (_, marks) => marks.map((mark) => timeOfDay(mark)) },
      { ...axis, size: 58, values: (_, marks) => marks.map((mark) => number(mark, figure.decimals)) },
    ],
    hooks: {
      setSelect: [(plot) => {
        if (plot.select.width > 4) {
          trends.zoomTo([plot.posToVal(plot.select.left, "x"), plot.posToVal(plot.select.left + plot.select.width, "x")]);
          plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
        }
      }],
      ready: [(plot) => plot.over.addEventListener("dblclick", () => trends.look(trends.window))],
    },
  };
}
