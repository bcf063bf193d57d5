/** Runs a coupled system, one FMU for Co-Simulation (FMI 2.0) compiled to WebAssembly: master, components and all.
 *
 * @typedef {{name: string, reference: number, type: "real"|"integer"|"boolean"}} Variable
 * @typedef {{token: string, outputs: Variable[], inputs: Variable[], variables: Object<string, Variable>}} Interface
 * @typedef {{t: number[], values: Float64Array[], ended: string}} Recorded   values: one array a row, in the order of outputs
 */

const OK = 1; // a warning, which is the worst that is not a failure
const DISCARD = 2;
const LAST_SUCCESSFUL_TIME = 2;

export class RunFailed extends Error {}

export class Engine {
  /**
   * @param {WebAssembly.Module} module
   * @param {Interface} description
   */
  constructor(module, description) {
    this.description = description;
    this.wasm = /** @type {any} */ (new WebAssembly.Instance(module, {}).exports);
    this.wasm._initialize?.();
    const token = this.text(description.token);
    const name = this.text("run");
    this.it = this.wasm.fmi2Instantiate(name, 1, token, name, this.wasm.web_callbacks(), 0, 1);
    if (!this.it) this.fail("the system could not be set up");
    const outputs = description.outputs;
    this.references = this.array(new Uint32Array(outputs.map((v) => v.reference)));
    this.row = this.wasm.malloc(8 * outputs.length + 8);
    this.one = this.wasm.malloc(16);
  }

  /** A text in the module's memory. @param {string} text */
  text(text) {
    return this.array(new TextEncoder().encode(`${text}\0`));
  }

  /** Numbers in the module's memory. @param {Uint8Array|Uint32Array|Float64Array} numbers */
  array(numbers) {
    const place = this.wasm.malloc(numbers.byteLength + 8);
    const bytes = new Uint8Array(numbers.buffer, numbers.byteOffset, numbers.byteLength);
    new Uint8Array(this.wasm.memory.buffer, place).set(bytes);
    return place;
  }

  /** What the components have said since the last call. */
  said() {
    const memory = new Uint8Array(this.wasm.memory.buffer);
    const place = this.wasm.web_said();
    return new TextDecoder().decode(memory.subarray(place, memory.indexOf(0, place)));
  }

  /** @param {string} what @returns {never} */
  fail(what) {
    throw new RunFailed([what, this.said()].filter(Boolean).join(": "));
  }

  /** @param {number} status @param {string} what */
  check(status, what) {
    if (status > OK) this.fail(what);
  }

  /** @param {string} name @param {number} value */
  set(name, value) {
    const variable = this.description.variables[name];
    if (!variable) this.fail(`there is no parameter ${name}`);
    const view = new DataView(this.wasm.memory.buffer);
    view.setUint32(this.one, variable.reference, true);
    const real = variable.type === "real";
    if (real) view.setFloat64(this.one + 8, value, true);
    else view.setInt32(this.one + 8, value, true);
    const call = real ? this.wasm.fmi2SetReal : variable.type === "boolean" ? this.wasm.fmi2SetBoolean : this.wasm.fmi2SetInteger;
    this.check(call(this.it, this.one, 1, this.one + 8), `${name} = ${value}`);
  }

  /**
   * Begin a run.
   * @param {Object<string, number>} values parameters and start values by name
   * @param {number} start s
   * @param {number} stop s
   */
  begin(values, start, stop) {
    const wasm = this.wasm;
    for (const [name, value] of Object.entries(values)) this.set(name, value);
    this.check(wasm.fmi2SetupExperiment(this.it, 0, 0.0, start, 1, stop), "set-up");
    this.check(wasm.fmi2EnterInitializationMode(this.it), "initialization");
    this.check(wasm.fmi2ExitInitializationMode(this.it), "initialization");
  }

  /** All outputs now. @returns {Float64Array} */
  outputs() {
    const n = this.description.outputs.length;
    this.check(this.wasm.fmi2GetReal(this.it, this.references, n, this.row), "outputs");
    return new Float64Array(this.wasm.memory.buffer, this.row, n).slice();
  }

  /**
   * From t over h; returns the time reached, less than t + h where a stop condition has ended the run.
   * @param {number} t s
   * @param {number} h s
   */
  step(t, h) {
    const status = this.wasm.fmi2DoStep(this.it, t, h, 1);
    if (status === DISCARD) {
      const told = this.wasm.fmi2GetRealStatus(this.it, LAST_SUCCESSFUL_TIME, this.one) <= OK;
      return told ? new DataView(this.wasm.memory.buffer).getFloat64(this.one, true) : t;
    }
    this.check(status, `the step from t = ${t.toPrecision(6)} s`);
    return t + h;
  }
}

/**
 * A whole run in pieces, so that its caller can show how far it is, or stop it.
 * @param {Engine} engine
 * @param {{values: Object<string, number>, start: number, step: number, steps: number, every: number}} run
 *     step in s; every: macro steps between rows
 * @returns {Generator<{n: number, t: number, row: Float64Array, ended: string}>} n: macro steps done
 */
export function* rows(engine, run) {
  const { start, step, steps, every } = run;
  engine.begin(run.values, start, start + steps * step);
  yield { n: 0, t: start, row: engine.outputs(), ended: "" };
  for (let n = 0; n < steps; ) {
    const next = Math.min(n + every, steps);
    const t = start + n * step;
    const h = start + next * step - t;
    const reached = engine.step(t, h);
    const ended = reached < t + h - 0.5 * step;
    n = ended ? n + Math.round((reached - t) / step) : next;
    yield { n, t: ended ? reached : start + n * step, row: engine.outputs(), ended: ended ? engine.said() || "ended" : "" };
    if (ended) return;
  }
}

/** FNV-1a, 64 bits, of the bytes of rows of numbers, as 16 hexadecimal digits. @param {Iterable<Float64Array>} all */
export function fingerprint(all) {
  let high = 0xcbf29ce4;
  let low = 0x84222325;
  for (const row of all) {
    for (const byte of new Uint8Array(row.buffer, row.byteOffset, row.byteLength)) {
      low = (low ^ byte) >>> 0;
      const product = low * 0x1b3; // the prime is 2^40 + 0x1b3
      const carry = Math.floor(product / 0x100000000);
      high = (Math.imul(high, 0x1b3) + carry + (low << 8)) >>> 0;
      low = product >>> 0;
    }
  }
  return high.toString(16).padStart(8, "0") + low.toString(16).padStart(8, "0");
}
