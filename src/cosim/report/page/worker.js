/** Runs the system beside the page, so that the page stays at hand. */
import { Engine, fingerprint, rows, RunFailed } from "./engine.js";

self.onmessage = async ({ data }) => {
  try {
    self.postMessage(done(await WebAssembly.compile(data.wasm), data.run));
  } catch (error) {
    const reason = error instanceof RunFailed ? error.message : `the run stopped: ${error}`;
    self.postMessage({ error: reason });
  }
};

/** A whole run: rows for drawing, and the fingerprint of the rows that are compared. @param {WebAssembly.Module} module @param {any} run */
function done(module, run) {
  const began = performance.now();
  const engine = new Engine(module, run.description);
  const n = run.description.outputs.length;
  const t = [];
  const kept = [];
  const checked = [];
  let ended = "";
  let told = began;
  for (const row of rows(engine, run)) {
    ended = row.ended;
    const last = row.n >= run.steps || ended !== "";
    if (row.n % run.shown === 0 || last) {
      t.push(row.t);
      kept.push(row.row);
    }
    if (row.n % run.checked === 0 || last) checked.push(row.row);
    if (performance.now() - told > 80) {
      told = performance.now();
      self.postMessage({ progress: row.n / run.steps });
    }
  }
  const columns = Array.from({ length: n }, (_, k) => Float64Array.from(kept, (row) => row[k]));
  const order = run.order;
  const rearranged = checked.map((row) => Float64Array.from(order, (k) => row[k]));
  return {
    t: Float64Array.from(t),
    columns,
    ended,
    said: engine.said(),
    fingerprint: fingerprint(rearranged),
    seconds: (performance.now() - began) / 1000,
  };
}
