/** The system as a drawing and as a list: components and what is exchanged between them. */
import { drawn, element } from "./dom.js";

const WIDTH = 190;
const HEIGHT = 52;
const GAP = 70;

/** @param {{components: {name: string, source: string}[], connections: {start: string[], end: string[]}[]}} system */
export function graph(system) {
  const names = system.components.map((component) => component.name);
  const pairs = new Map();
  for (const { start, end } of system.connections) {
    const key = [start[0], end[0]].join("\u0000");
    pairs.set(key, [...(pairs.get(key) ?? []), `${start[1]} → ${end[1]}`]);
  }
  const list = element(
    "ul",
    { class: "exchange" },
    ...[...pairs].map(([key, what]) => {
      const [from, to] = key.split("\u0000");
      return element("li", {}, element("strong", {}, `${from} → ${to}`), `: ${what.join(", ")}`);
    }),
  );
  if (names.length > 12) return element("div", {}, element("p", {}, `${names.length} components`), list);
  const columns = Math.min(3, names.length);
  const place = names.map((_, k) => [20 + (k % columns) * (WIDTH + GAP), 20 + Math.floor(k / columns) * (HEIGHT + GAP)]);
  const width = 40 + columns * WIDTH + (columns - 1) * GAP;
  const height = 40 + Math.ceil(names.length / columns) * (HEIGHT + GAP) - GAP;
  const picture = drawn("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", class: "graph" });
  picture.append(drawn("title", {}, `System graph: ${names.join(", ")}`), arrowhead());
  for (const key of pairs.keys()) {
    const [from, to] = key.split("\u0000").map((name) => names.indexOf(name));
    if (from >= 0 && to >= 0 && from !== to) picture.append(arrow(place[from], place[to], from < to));
  }
  system.components.forEach((component, k) => {
    const [x, y] = place[k];
    picture.append(
      drawn("rect", { x, y, width: WIDTH, height: HEIGHT, rx: 8, class: "node" }),
      drawn("text", { x: x + 12, y: y + 22, class: "name" }, component.name),
      drawn("text", { x: x + 12, y: y + 40, class: "source" }, short(component.source)),
    );
  });
  return element("div", {}, picture, list);
}

/** @param {string} source */
const short = (source) => (source.length > 26 ? `…${source.slice(-25)}` : source);

function arrowhead() {
  const marker = drawn("marker", { id: "arrowhead", viewBox: "0 0 10 10", refX: 9, refY: 5, markerWidth: 7, markerHeight: 7, orient: "auto" });
  marker.append(drawn("path", { d: "M0 0 10 5 0 10z", class: "head" }));
  const defs = drawn("defs", {});
  defs.append(marker);
  return defs;
}

/** From border to border, a little to one side, so that both directions are seen. @param {number[]} from @param {number[]} to @param {boolean} forth */
function arrow(from, to, forth) {
  const side = forth ? -8 : 8;
  const a = [from[0] + WIDTH / 2, from[1] + HEIGHT / 2];
  const b = [to[0] + WIDTH / 2, to[1] + HEIGHT / 2];
  const level = from[1] === to[1];
  const right = b[0] > a[0];
  const down = b[1] > a[1];
  const start = level ? [a[0] + (right ? WIDTH / 2 : -WIDTH / 2), a[1] + side] : [a[0] + side, a[1] + (down ? HEIGHT / 2 : -HEIGHT / 2)];
  const end = level ? [b[0] + (right ? -WIDTH / 2 : WIDTH / 2), b[1] + side] : [b[0] + side, b[1] + (down ? -HEIGHT / 2 : HEIGHT / 2)];
  return drawn("path", { d: `M${start} L${end}`, class: "wire", "marker-end": "url(#arrowhead)" });
}
