/** Change a parameter and run the system again, here. */
import { inflated, shown } from "./data.js";
import { element } from "./dom.js";

const ROWS = 3000;

/** @param {number} a @param {number} b @returns {number} */
const common = (a, b) => (b ? common(b, a % b) : a);

export class Runner {
  /**
   * @param {any} report the page's document
   * @param {string} workerText
   * @param {(run: import("./data.js").Run|null, changed: string[]) => void} onRun
   */
  constructor(report, workerText, onRun) {
    this.report = report;
    this.onRun = onRun;
    this.use(report.module);
    this.values = {};
    this.workerText = workerText;
    this.element = this.build();
  }

  /** @param {any} module what runs: the stored system, or one with a variant in it */
  use(module) {
    this.module = module;
    const all = module.variables;
    const byName = Object.fromEntries(all.map((v) => [v.name, v]));
    const outputs = all.filter((v) => v.causality === "output" && v.type === "real");
    this.description = { token: module.token, outputs, inputs: [], variables: byName };
    this.order = module === this.report.module ? this.report.check.names.map((name) => outputs.findIndex((v) => v.name === name)) : [];
    this.parameters = all.filter((v) => v.causality === "parameter" && v.start !== null && v.name !== "macro_step");
  }

  /** @param {string} name of a variant, or "" for the stored one */
  async choose(name) {
    const chosen = this.report.variants.find((variant) => variant.name === name);
    if (chosen && typeof chosen.module.variables === "string") {
      chosen.module.variables = JSON.parse(new TextDecoder().decode(await inflated(chosen.module.variables)));
    }
    this.use(chosen ? chosen.module : this.report.module);
    this.variant = chosen ? name : "";
    const known = new Set(this.parameters.map((v) => v.name));
    const lost = Object.keys(this.values).filter((parameter) => !known.has(parameter));
    for (const parameter of lost) delete this.values[parameter];
    this.offer();
    this.tell(lost.length ? ` ${this.report.system.exchanged.join(", ")} has no ${lost.join(", ")} any more.` : "");
  }

  /** What differs from the stored run. @param {string} more */
  tell(more = "") {
    const n = Object.keys(this.values).length;
    const parts = [this.variant && `${this.variant} in place of the stored variant`, n && `${n} parameter${n > 1 ? "s" : ""} changed`].filter(Boolean);
    this.status.textContent = (parts.length ? `${parts.join(", ")}.` : "Unchanged: a run here must give the stored results to the last bit.") + more;
  }

  build() {
    this.status = element("p", { role: "status", class: "status" });
    this.variant = "";
    this.tell();
    this.bar = element("progress", { max: "1", value: "0", "aria-label": "progress of the run", hidden: true });
    this.go = element("button", { type: "button", class: "main", onclick: () => this.start() }, "Run it here");
    this.halt = element("button", { type: "button", disabled: true, onclick: () => this.cancel("Stopped.") }, "Stop");
    this.reset = element("button", { type: "button", onclick: () => this.back() }, "All as stored");
    this.stop = element("input", { type: "number", step: "any", min: "0", value: this.report.run.stop, id: "stop-time" });
    this.filter = element("input", { type: "search", placeholder: "find a parameter", "aria-label": "find a parameter", oninput: () => this.offer() });
    this.fields = element("div", { class: "parameters" });
    this.menu = element("select", { id: "variant", onchange: (event) => this.choose(event.target.value) });
    const { components, exchanged } = this.report.system;
    const stored = components.find((c) => exchanged.includes(c.name))?.source.split(":").at(-1) ?? "";
    this.menu.append(element("option", { value: "" }, `${stored} (stored)`), ...this.report.variants.map(({ name }) => element("option", { value: name }, name)));
    const menu = this.report.variants.length ? [element("label", { for: "variant" }, `${exchanged.join(", ")} `, this.menu)] : [];
    this.offer();
    return element(
      "div",
      {},
      element("div", { class: "tools" }, this.go, this.halt, this.reset, ...menu, element("label", { for: "stop-time" }, "until t in s ", this.stop), this.filter),
      this.bar,
      this.status,
      this.fields,
    );
  }

  /** The parameters, those first that people turn: of units that are few. */
  offer() {
    const wanted = this.filter.value.trim().toLowerCase();
    const groups = new Map();
    for (const v of this.parameters) {
      if (!`${v.name} ${v.description}`.toLowerCase().includes(wanted)) continue;
      const group = v.name.includes(".") ? v.name.slice(0, v.name.indexOf(".")) : "coupling";
      groups.set(group, [...(groups.get(group) ?? []), v]);
    }
    const sorted = [...groups].sort((a, b) => a[1].length - b[1].length);
    this.fields.replaceChildren(
      ...sorted.map(([group, members]) =>
        element("details", { open: wanted !== "" || members.length <= 12 }, element("summary", {}, `${group} (${members.length})`), ...members.map((v) => this.field(v))),
      ),
    );
    if (!sorted.length) this.fields.append(element("p", { class: "quiet" }, "No parameter has that in its name or description."));
  }

  /** @param {any} v */
  field(v) {
    const id = `p-${v.reference}-${v.type}`;
    const short = v.name.includes(".") ? v.name.slice(v.name.indexOf(".") + 1) : v.name;
    const now = this.values[v.name] ?? v.start;
    const bounds = [v.min !== null && `at least ${shown(v.min)}`, v.max !== null && `at most ${shown(v.max)}`].filter(Boolean).join(", ");
    const input = v.items.length
      ? element("select", { id, onchange: (event) => this.change(v, Number(event.target.value), row) }, ...v.items.map(([name, k]) => element("option", { value: k, selected: k === now }, name)))
      : element("input", { id, type: "number", step: v.type === "real" ? "any" : "1", value: now, min: v.min, max: v.max, "aria-describedby": `${id}-about`, onchange: (event) => this.change(v, event.target.valueAsNumber, row) });
    const about = [v.description, bounds, `stored: ${shown(v.start)}`].filter(Boolean).join("; ");
    const slider = this.slider(v, now, (value) => {
      input.value = String(value);
      this.change(v, value, row);
    });
    const row = element(
      "div",
      { class: v.name in this.values ? "field changed" : "field" },
      element("label", { for: id }, short),
      slider ?? element("span"),
      element("span", { class: "value" }, input, element("span", { class: "unit" }, v.unit)),
      element("small", { id: `${id}-about` }, about),
    );
    return row;
  }

  /** A slider over the bounds, or about the stored value where there are none. @param {any} v @param {number} now @param {(value: number) => void} onChange */
  slider(v, now, onChange) {
    if (v.type !== "real" || v.start === 0) return null;
    const low = Math.max(v.min ?? -Infinity, Math.min(0, 2 * v.start));
    const high = Math.min(v.max ?? Infinity, Math.max(0, 2 * v.start));
    if (!(high > low)) return null;
    return element("input", {
      type: "range", min: low, max: high, step: (high - low) / 200, value: now, "aria-label": v.name,
      onchange: (event) => {
        onChange(Number(Number(event.target.value).toPrecision(6)));
        this.start();
      },
    });
  }

  /** @param {any} v @param {number} value @param {HTMLElement} row */
  change(v, value, row) {
    const outside = !Number.isFinite(value) || (v.min !== null && value < v.min) || (v.max !== null && value > v.max);
    row.classList.toggle("wrong", outside);
    if (outside) {
      this.status.textContent = `${v.name} must be ${[v.min !== null && `at least ${shown(v.min)}`, v.max !== null && `at most ${shown(v.max)}`].filter(Boolean).join(" and ") || "a number"}, got ${value}.`;
      return;
    }
    if (value === v.start) delete this.values[v.name];
    else this.values[v.name] = value;
    row.classList.toggle("changed", v.name in this.values);
    this.tell();
  }

  back() {
    this.values = {};
    this.menu.value = "";
    this.variant = "";
    this.use(this.report.module);
    this.stop.value = this.report.run.stop;
    this.offer();
    this.status.textContent = "All as stored.";
    this.onRun(null, []);
  }

  async start() {
    this.cancel("");
    const module = this.module;
    const { start, step, record_every: every } = this.report.run;
    const stop = this.stop.valueAsNumber;
    const steps = Math.round((stop - start) / step);
    if (!(steps > 0)) {
      this.status.textContent = `The end must be after t = ${start} s, got ${this.stop.value}.`;
      return;
    }
    const shownEvery = every * Math.max(1, Math.ceil(steps / every / ROWS));
    const checked = this.report.check.every;
    this.unchanged = module === this.report.module && !Object.keys(this.values).length && steps === Math.round((this.report.run.stop - start) / step);
    this.worker = new Worker(URL.createObjectURL(new Blob([this.workerText], { type: "text/javascript" })));
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => this.hear({ error: event.message || "the page's worker cannot be started" });
    this.worker.postMessage({
      wasm: await inflated(module.wasm),
      run: { description: this.description, order: this.order, values: { ...module.given, ...this.values }, start, step, steps, every: common(shownEvery, checked), shown: shownEvery, checked },
    });
    this.bar.hidden = false;
    this.bar.value = 0;
    this.halt.disabled = false;
    delete this.status.dataset.reproduced;
    this.status.dataset.state = "running";
    this.status.textContent = "Running.";
  }

  /** @param {string} why */
  cancel(why) {
    this.worker?.terminate();
    this.worker = null;
    this.bar.hidden = true;
    this.halt.disabled = true;
    if (why) this.status.textContent = why;
  }

  /** @param {any} data */
  hear(data) {
    if (data.progress !== undefined) {
      this.bar.value = data.progress;
      return;
    }
    this.cancel("");
    this.status.dataset.state = data.error ? "failed" : "done";
    if (data.error) {
      this.status.textContent = `The run failed: ${data.error}`;
      return;
    }
    const names = this.description.outputs.map((v) => v.name);
    const run = { t: data.t, names, units: this.description.outputs.map((v) => v.unit), columns: new Map(names.map((name, k) => [name, data.columns[k]])), group: 1 };
    const speed = (data.t[data.t.length - 1] - data.t[0]) / data.seconds;
    const took = `${shown(Number(data.seconds.toPrecision(3)))} s, ${Math.round(speed)} times real time`;
    const end = data.ended ? ` Ended at t = ${shown(data.t[data.t.length - 1])} s: ${data.ended}.` : "";
    if (this.unchanged) {
      const same = data.fingerprint === this.report.check.fingerprint;
      this.status.textContent = same ? `Reproduced: identical, to the last bit of ${this.report.check.rows} rows (${took}).${end}` : `Not identical to the stored run (${took}): report it, please.${end}`;
      this.status.dataset.reproduced = same ? "identical" : "different";
    } else {
      this.status.textContent = `Done in ${took}.${end}`;
    }
    this.onRun(run, [...(this.variant ? [this.variant] : []), ...Object.keys(this.values)]);
  }
}
