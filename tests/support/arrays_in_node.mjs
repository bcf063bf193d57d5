// node arrays_in_node.mjs MODULE.wasm NUMBERS RESULTS NAME...: NUMBERS holds n, n first and n second arguments as doubles; the
// functions' results go to the file RESULTS.
import fs from "node:fs";

const numbers = fs.readFileSync(process.argv[3]);
const n = numbers.readDoubleLE(0), bytes = 8 * n;
const exports = new WebAssembly.Instance(new WebAssembly.Module(fs.readFileSync(process.argv[2])), {}).exports;
const first = Math.ceil(exports.__heap_base.value / 8) * 8;
exports.memory.grow(Math.ceil((first + 3 * bytes) / 65536));
const memory = Buffer.from(exports.memory.buffer);
numbers.copy(memory, first, 8);
const results = fs.openSync(process.argv[4], "w");
for (const name of process.argv.slice(5)) {
  exports[`array_${name}`](first, first + bytes, first + 2 * bytes, n);
  fs.writeSync(results, memory, first + 2 * bytes, bytes);
}
