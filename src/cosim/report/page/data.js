/** From the page's document to numbers. */

/** Base 64 to bytes. @param {string} text */
export function bytes(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}

/** Deflated bytes in base 64, inflated. @param {string} text @returns {Promise<ArrayBuffer>} */
export async function inflated(text) {
  const stream = new Blob([bytes(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/**
 * A recorded run: time and one column a signal.
 * @typedef {{t: Float64Array, names: string[], units: string[], columns: Map<string, Float32Array|Float64Array>, group: number}} Run
 */

/** @param {any} signals @returns {Promise<Run>} */
export async function run(signals) {
  const t = new Float64Array(await inflated(signals.t));
  const all = await Promise.all(signals.columns.map(async (text) => new Float32Array(await inflated(text))));
  const columns = new Map(signals.names.map((name, k) => [name, all[k]]));
  return { t, names: signals.names, units: signals.units, columns, group: signals.group };
}

/** Place of the last time that is not after `time`. @param {ArrayLike<number>} t @param {number} time */
export function placeOf(t, time) {
  let low = 0;
  let high = t.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (t[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** The value of a column at a time, by straight lines. @param {Run} run @param {string} name @param {number} time */
export function valueAt(run, name, time) {
  const column = run.columns.get(name);
  if (!column || !column.length) return 0;
  const k = placeOf(run.t, time);
  if (k + 1 >= column.length) return column[column.length - 1];
  const span = run.t[k + 1] - run.t[k];
  const share = span > 0 ? Math.min(1, Math.max(0, (time - run.t[k]) / span)) : 0;
  return column[k] + share * (column[k + 1] - column[k]);
}

/** A way or an angle: a signal of it by name, or a number, its constant rate. @param {Run} run @param {string|number|null} key @param {number} time */
export function wayAt(run, key, time) {
  if (typeof key === "number") return key * (time - run.t[0]);
  return key ? valueAt(run, key, time) : 0;
}

/** Numbers for people: six digits. @param {number|null|undefined} x */
export function shown(x) {
  if (x === null || x === undefined || Number.isNaN(x)) return "–";
  const size = Math.abs(x);
  const text = size !== 0 && (size < 1e-4 || size >= 1e9) ? x.toExponential(3) : Number(x.toPrecision(6)).toString();
  return text.replaceAll("-", "−");
}
