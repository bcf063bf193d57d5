/** Bundles the page's script, the worker's and the style: node build.mjs FOLDER */
import { build } from "esbuild";

const common = { bundle: true, minify: true, target: "es2022", charset: "utf8", legalComments: "inline", logLevel: "error" };
const folder = process.argv[2];
await build({ ...common, entryPoints: ["main.js"], format: "esm", outfile: `${folder}/page.js` });
await build({ ...common, entryPoints: ["worker.js"], format: "iife", outfile: `${folder}/worker.js` });
await build({ ...common, entryPoints: ["style.css"], outfile: `${folder}/style.css` });
