/** Elements of the page. Text is always text: no name of a signal or a file can become markup. */

/**
 * @param {string} tag
 * @param {Object<string, any>} [attributes] `on...` are listeners, others attributes; false and null leave one out
 * @param {...(Node|string|null|undefined|false)} children
 * @returns {any}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value === true ? "" : String(value));
  }
  for (const child of children) if (child !== null && child !== undefined && child !== false) made.append(child);
  return made;
}

/** A part of the page with a heading. @param {string} id @param {string} title @param {...any} children */
export function section(id, title, ...children) {
  return element("section", { id, "aria-labelledby": `${id}-title` }, element("h2", { id: `${id}-title` }, title), ...children);
}

/** A table with one heading row. @param {string} caption @param {string[]} head @param {any[][]} rows @param {number[]} [numeric] */
export function table(caption, head, rows, numeric = []) {
  const cell = (kind, value, k) => element(kind, { class: numeric.includes(k) ? "number" : null, scope: kind === "th" ? "col" : null }, value);
  return element(
    "div",
    { class: "wide", tabindex: "0", role: "region", "aria-label": caption },
    element(
      "table",
      {},
      element("caption", {}, caption),
      element("thead", {}, element("tr", {}, ...head.map((value, k) => cell("th", value, k)))),
      element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map((value, k) => cell("td", value, k))))),
    ),
  );
}

const SVG = "http://www.w3.org/2000/svg";

/** An element of a drawing. @param {string} tag @param {Object<string, any>} attributes @param {...(Node|string)} children */
export function drawn(tag, attributes, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.append(...children);
  return made;
}
