/** A run seen as it goes on: what the server tells, drawn; and what steers it. */
import { bytes, shown } from "./data.js";
import { element, section, table } from "./dom.js";
import { Plots } from "./plots.js";

const DRAWN_EVERY = 250; // ms between two drawings of the charts
const STATES = { waiting: "Waits for its start.", running: "Running.", paused: "Paused.", over: "The run is over; what is shown stays.", lost: "The run cannot be reached any more." };

/** A run that grows. @typedef {import("./data.js").Run} Run */
class Growing {
  /** @param {{names: string[], units: string[]}} signals */
  constructor({ names, units }) {
    this.names = names;
    this.units = units;
    this.group = 0;
    this.t = new Float64Array(0);
    this.columns = new Map(names.map((name) => [name, new Float32Array(0)]));
    this.room = [new Float64Array(1024), ...names.map(() => new Float32Array(1024))];
  }

  /** @param {any} told */
  add(told) {
    const n = told.anew ? 0 : this.t.length;
    const all = n + told.rows;
    const times = new Float64Array(bytes(told.times).buffer);
    const values = new Float32Array(bytes(told.columns).buffer);
    if (all > this.room[0].length) {
      this.room = this.room.map((old) => {
        const made = new /** @type {any} */ (old.constructor)(2 * all);
        made.set(old.subarray(0, n));
        return made;
      });
    }
    this.room[0].set(times, n);
    this.t = /** @type {any} */ (this.room[0].subarray(0, all));
    this.names.forEach((name, k) => {
      this.room[k + 1].set(values.subarray(k * told.rows, (k + 1) * told.rows), n);
      this.columns.set(name, /** @type {any} */ (this.room[k + 1].subarray(0, all)));
    });
  }
}

/** The page of a run that goes on. @param {any} report @param {HTMLElement} main */
export class Live {
  constructor(report, main) {
    this.report = report;
    this.run = new Growing(report.signals);
    this.main = main;
    this.drawn = 0;
    this.place = element("div", {});
    this.fields = this.offer();
    main.append(section("steer", "Steer it", ...this.build()), this.place, section("tune", "Change it on the way", ...this.fields));
    this.source = new EventSource("events");
    this.source.onmessage = ({ data }) => this.hear(JSON.parse(data));
    this.source.onerror = () => this.tell("lost");
  }

  build() {
    const button = (text, wish, kind = null) => element("button", { type: "button", class: kind, disabled: true, onclick: () => this.want(wish) }, text);
    this.go = button("Start", { do: "go" }, "main");
    this.pause = button("Pause", { do: "pause" });
    this.stop = button("End it", { do: "stop" });
    const { paces } = this.report.live;
    this.pace = element("select", { id: "pace", disabled: true, onchange: () => this.want({ do: "pace", value: Number(this.pace.value) }) });
    this.pace.append(...paces.map((pace) => element("option", { value: pace }, pace ? `${shown(pace)} times real time` : "as fast as it goes")));
    this.status = element("p", { role: "status", class: "status" });
    this.bar = element("progress", { max: this.report.run.stop - this.report.run.start, value: 0, "aria-label": "how far the run is" });
    this.clock = element("output", { class: "quiet" });
    this.wrong = element("p", { class: "notice", role: "alert", hidden: true });
    this.changes = element("div", { class: "changes" });
    return [
      element("div", { class: "tools" }, this.go, this.pause, this.stop, paces.length ? element("label", { for: "pace" }, "pace ", this.pace) : ""),
      this.bar,
      this.status,
      this.clock,
      this.wrong,
      this.changes,
    ];
  }

  /** What may change on the way, the components with few parameters first. */
  offer() {
    this.inputs = [];
    const groups = new Map();
    for (const v of this.report.live.parameters) groups.set(v.component, [...(groups.get(v.component) ?? []), v]);
    const sorted = [...groups].sort((a, b) => a[1].length - b[1].length);
    const fields = sorted.map(([component, all]) => element("details", { open: all.length <= 12 }, element("summary", {}, `${component} (${all.length})`), ...all.map((v) => this.field(v))));
    return fields.length ? [element("div", { class: "parameters" }, ...fields)] : [element("p", { class: "quiet" }, "No parameter of its components may change during this run.")];
  }

  /** @param {any} v */
  field(v) {
    const id = `live-${v.component}-${v.name}`;
    const set = (value) => this.want({ do: "set", component: v.component, name: v.name, value });
    const bounds = [v.min !== null && `at least ${shown(v.min)}`, v.max !== null && `at most ${shown(v.max)}`].filter(Boolean).join(", ");
    const input = v.items.length
      ? element("select", { id, disabled: true, onchange: (event) => set(Number(event.target.value)) }, ...v.items.map(([name, k]) => element("option", { value: k, selected: k === v.start }, name)))
      : element("input", { id, disabled: true, type: "number", step: v.type === "real" ? "any" : "1", value: v.start, min: v.min, max: v.max, "aria-describedby": `${id}-about`, onchange: (event) => set(event.target.valueAsNumber) });
    this.inputs.push({ v, input });
    return element(
      "div",
      { class: "field" },
      element("label", { for: id }, v.name),
      element("span"),
      element("span", { class: "value" }, input, element("span", { class: "unit" }, v.unit)),
      element("small", { id: `${id}-about` }, [v.description, bounds, `at the start: ${shown(v.start)}`].filter(Boolean).join("; ")),
    );
  }

  /** @param {any} wish */
  async want(wish) {
    let why = "";
    try {
      const answer = await fetch("do", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(wish) });
      if (!answer.ok) why = (await answer.json()).error;
    } catch {
      why = STATES.lost;
    }
    this.wrong.hidden = !why;
    this.wrong.textContent = why;
  }

  /** @param {string} state @param {any} [told] */
  tell(state, told = {}) {
    const steers = told.steers === true && state !== "over";
    this.go.textContent = state === "waiting" ? "Start" : "Go on";
    this.go.disabled = !steers || state === "running";
    this.pause.disabled = !steers || state !== "running";
    this.stop.disabled = !steers;
    this.pace.disabled = !steers;
    for (const { input } of this.inputs) input.disabled = !steers;
    const watching = told.steers === false && state !== "over" ? " You watch; whoever opened the page first steers." : "";
    const words = STATES[state] + watching;
    if (this.status.textContent !== words) this.status.textContent = words;
    this.status.dataset.state = state;
  }

  /** @param {any} told */
  hear(told) {
    this.tell(told.state, told);
    if (told.state === "over") this.source.close();
    if (document.activeElement !== this.pace) this.pace.value = String(told.pace);
    if (told.t !== null) {
      this.bar.value = told.t - this.report.run.start;
      this.clock.textContent = `t = ${told.t.toFixed(2)} s of ${shown(this.report.run.stop)} s`;
    }
    if (told.changes.length !== this.changed) {
      this.changed = told.changes.length;
      const rows = told.changes.map((one) => [shown(one.at), one.name, shown(one.value)]);
      for (const { v, input } of this.inputs) {
        const last = told.changes.findLast((one) => one.name === `${v.component}.${v.name}`);
        if (last && input !== document.activeElement) input.value = String(last.value);
      }
      this.changes.replaceChildren(rows.length ? table("Changed so far", ["from t in s", "parameter", "value"], rows, [0, 2]) : "");
    }
    if (told.rows) this.run.add(told);
    if (!this.plots && this.run.t.length > 1) this.begin();
    if (this.plots && (told.state === "over" || performance.now() - this.drawn > DRAWN_EVERY)) this.draw(told.state === "over");
  }

  /** There are signals to draw. */
  async begin() {
    const { scene, prefer } = this.report;
    const run = /** @type {any} */ (this.run);
    const distance = scene && run.names.includes(scene.track.distance) ? scene.track.distance : null;
    this.plots = new Plots(run, { prefer: prefer ?? [], distance, called: "live", others: [], onTime: (time) => this.moving?.go(time) });
    const motion = section("motion", "See it move");
    this.place.append(...(scene ? [motion] : []), section("signals", "Signals", this.plots.element));
    this.plots.redraw(); // now that it has a width
    if (!scene) return;
    try {
      const { Moving } = await import("./scene.js");
      this.moving = new Moving(scene, run, (time) => this.plots.show(time));
      motion.append(this.moving.element);
      this.moving.go(this.moving.stop); // whoever is at its end stays there
    } catch (error) {
      motion.append(element("p", { class: "notice" }, `The moving picture needs WebGL, which is not at hand (${error}). The plots below show the same run.`));
    }
  }

  /** @param {boolean} last */
  draw(last) {
    this.drawn = performance.now();
    this.plots.grown();
    this.moving?.grown(last);
  }
}
