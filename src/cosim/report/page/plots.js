/** Time histories: one chart a signal, one cursor for all, the run in the page over the stored one. */
import uPlot from "uplot";
import { element } from "./dom.js";
import { placeOf, shown } from "./data.js";

const OTHERS = ["--line-other-1", "--line-other-2", "--line-other-3", "--line-other-4"];
const HEIGHT = 170;
const MOST = 8;

/** @param {string} name */
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Whether a column changes. @param {ArrayLike<number>} column */
const changes = (column) => {
  for (let k = 1; k < column.length; k++) if (column[k] !== column[0]) return true;
  return false;
};

export class Plots {
  /**
   * @param {import("./data.js").Run} stored
   * @param {{prefer: string[], called: string, distance: string|null, others: {name: string, run: import("./data.js").Run}[], onTime: (time: number) => void}} options
   */
  constructor(stored, options) {
    this.stored = stored;
    this.options = options;
    /** @type {import("./data.js").Run|null} */
    this.here = null;
    this.charts = new Map();
    this.over = "time";
    this.sync = uPlot.sync("run");
    const moving = stored.names.filter((name) => changes(stored.columns.get(name) ?? []));
    const first = [...options.prefer.filter((name) => moving.includes(name)), ...moving].slice(0, 4);
    this.list = element("div", { class: "signals", role: "group", "aria-label": "signals to draw" });
    this.filter = element("input", { type: "search", placeholder: "find a signal", "aria-label": "find a signal", oninput: () => this.offer() });
    this.axis = element("select", { "aria-label": "horizontal axis", onchange: () => this.along(this.axis.value) });
    this.axis.append(element("option", { value: "time" }, "over time"));
    if (options.distance) this.axis.append(element("option", { value: options.distance }, "over distance"));
    this.note = element("p", { class: "quiet" }, this.thinning());
    this.area = element("div", { class: "charts" });
    this.element = element(
      "div",
      {},
      element("div", { class: "tools" }, this.filter, this.axis, element("button", { type: "button", onclick: () => this.wide() }, "whole run")),
      this.list,
      this.area,
      this.note,
    );
    this.chosen = new Set(first);
    this.offer();
    for (const name of first) this.draw(name);
    new ResizeObserver(() => this.resize()).observe(this.area);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
  }

  thinning() {
    const { group, t } = this.stored;
    if (group === 0) return `${t.length} rows so far, of long runs fewer than there are. Drag to look closer, double-click for the whole run, click to go there.`;
    if (group === 1) return `${t.length} recorded rows. Drag to look closer, double-click for the whole run, click to go there.`;
    return `Thinned: every two points hold the least and the greatest of ${group} recorded rows, so no peak is lost. Drag to look closer, double-click for the whole run, click to go there.`;
  }

  /** The signals that can be drawn, with those that are. */
  offer() {
    const wanted = this.filter.value.trim().toLowerCase();
    const names = this.stored.names.filter((name) => this.chosen.has(name) || name.toLowerCase().includes(wanted));
    const box = (name) =>
      element(
        "label",
        {},
        element("input", { type: "checkbox", checked: this.chosen.has(name), onchange: (event) => this.choose(name, event.target.checked) }),
        name,
      );
    this.list.replaceChildren(...names.slice(0, 200).map(box));
  }

  /** @param {string} name @param {boolean} wanted */
  choose(name, wanted) {
    if (wanted && this.chosen.size >= MOST) {
      const [oldest] = this.chosen;
      this.chosen.delete(oldest);
      this.remove(oldest);
    }
    if (wanted) this.chosen.add(name);
    else this.chosen.delete(name);
    if (wanted) this.draw(name);
    else this.remove(name);
    this.offer();
  }

  /** @param {string} name */
  remove(name) {
    const chart = this.charts.get(name);
    chart?.plot.destroy();
    chart?.place.remove();
    this.charts.delete(name);
  }

  /** What stands on the horizontal axis of a run. @param {import("./data.js").Run} run */
  across(run) {
    return this.over === "time" ? run.t : (run.columns.get(this.over) ?? run.t);
  }

  /** The runs that hold a signal, each with what it is called and its colour. @param {string} name */
  lines(name) {
    const { others } = this.options;
    const over = others.map(({ name: called, run }, k) => ({ called, run, ink: OTHERS[k % OTHERS.length] }));
    const first = { called: over.length || this.here ? this.options.called : name, run: this.stored, ink: "--line-stored" };
    const here = this.here ? [{ called: "in this page", run: this.here, ink: "--line-here" }] : [];
    return [first, ...over, ...here].filter(({ run }) => run.columns.has(name));
  }

  /** All runs on one axis. @param {string} name */
  data(name) {
    const tables = this.lines(name).map(({ run }) => [Array.from(this.across(run)), Array.from(run.columns.get(name) ?? [])]);
    return tables.length === 1 ? tables[0] : uPlot.join(/** @type {any} */ (tables));
  }

  /** @param {string} name */
  draw(name) {
    const unit = this.stored.units[this.stored.names.indexOf(name)];
    const ink = colour("--ink");
    const grid = { stroke: colour("--grid"), width: 1 };
    const axis = { stroke: ink, grid, ticks: grid, font: "12px system-ui, sans-serif" };
    const series = this.lines(name).map(({ called, ink }) => ({ label: called, stroke: colour(ink), width: 1.5, spanGaps: true }));
    const options = {
      width: Math.max(280, this.area.clientWidth || 600),
      height: HEIGHT,
      scales: { x: { time: false } },
      series: [{ label: this.over === "time" ? "t" : "s" }, ...series],
      axes: [axis, { ...axis, size: 64, values: (_, ticks) => ticks.map((x) => shown(x)) }],
      cursor: { sync: { key: "run", setSeries: false }, drag: { x: true, y: false } },
      hooks: {
        setScale: [(plot, key) => key === "x" && this.follow(plot)],
        setCursor: [(plot) => plot.cursor.event && this.point(plot)],
      },
      legend: { show: true, live: true },
    };
    const title = `${name}${unit ? ` in ${unit}` : ""}`;
    const place = element("figure", { class: "chart", "aria-label": title }, element("figcaption", {}, title));
    this.area.append(place);
    const plot = new uPlot(/** @type {any} */ (options), /** @type {any} */ (this.data(name)), place);
    plot.over.addEventListener("click", () => this.point(plot));
    this.charts.set(name, { plot, place });
  }

  /** All charts show the same stretch. @param {uPlot} from */
  follow(from) {
    if (this.following) return;
    this.following = true;
    const { min, max } = from.scales.x;
    for (const { plot } of this.charts.values()) if (plot !== from && min !== null) plot.setScale("x", { min, max });
    this.following = false;
  }

  /** The time under the cursor is that of the moving vehicle. @param {uPlot} plot */
  point(plot) {
    const left = plot.cursor.left ?? -1;
    if (left < 0 || this.pointing) return;
    const x = plot.posToVal(left, "x");
    this.options.onTime(this.over === "time" ? x : this.stored.t[placeOf(this.across(this.stored), x)]);
  }

  /** The cursor at a time. @param {number} time */
  show(time) {
    const [chart] = this.charts.values();
    if (!chart) return;
    const x = this.over === "time" ? time : this.across(this.stored)[placeOf(this.stored.t, time)];
    this.pointing = true;
    chart.plot.setCursor({ left: chart.plot.valToPos(x, "x"), top: 10 });
    this.pointing = false;
  }

  /** @param {string} over */
  along(over) {
    this.over = over;
    this.redraw();
  }

  wide() {
    for (const { plot } of this.charts.values()) plot.setData(plot.data, true);
  }

  /** The stored run has become longer. */
  grown() {
    for (const [name, { plot }] of this.charts) {
      const [before] = plot.data;
      const whole = plot.scales.x.max === undefined || plot.scales.x.max === null || plot.scales.x.max >= before[before.length - 1];
      plot.setData(/** @type {any} */ (this.data(name)), whole);
    }
    this.note.textContent = this.thinning();
  }

  resize() {
    const width = Math.max(280, this.area.clientWidth);
    for (const { plot } of this.charts.values()) if (Math.abs(plot.width - width) > 1) plot.setSize({ width, height: HEIGHT });
  }

  redraw() {
    for (const name of [...this.charts.keys()]) this.remove(name);
    for (const name of this.chosen) this.draw(name);
  }

  /** Draw a run of the page over the stored one. @param {import("./data.js").Run|null} here */
  overlay(here) {
    this.here = here;
    this.redraw();
  }
}
