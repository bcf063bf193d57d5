/** The page of a run: what it was, what came of it, how it moved, and the system itself to run again. */
import { run as unpacked, shown } from "./data.js";
import { element, section, table } from "./dom.js";
import { graph } from "./graph.js";
import { Live } from "./live.js";
import { Plots } from "./plots.js";
import { Runner } from "./runner.js";

const report = JSON.parse(document.getElementById("report")?.textContent ?? "{}");
const workerText = JSON.parse(document.getElementById("worker")?.textContent ?? '""');
const main = /** @type {HTMLElement} */ (document.getElementById("main"));

head();
try {
  await fill();
} catch (error) {
  main.append(element("p", { class: "notice" }, `This part of the page could not be shown: ${error}`));
}
document.documentElement.dataset.ready = "yes";

function head() {
  const { run } = report;
  const how = run.algorithm ? [`${run.algorithm}, degree ${run.degree}`, `${run.steps} macro steps of ${shown(run.step * 1000)} ms`] : [];
  const facts = [
    ...how,
    `t = ${shown(run.start)} to ${shown(run.stop)} s`,
  ];
  document.getElementById("head")?.append(
    element("p", { class: "kicker" }, report.live ? "Co-simulation run, as it goes on" : run.status ? "Co-simulation run" : "Results of co-simulation runs"),
    element("h1", {}, report.title),
    report.description ? element("p", { class: "lead" }, report.description) : "",
    element("p", { class: "facts" }, ...facts.map((text) => element("span", {}, text)), run.status ? element("span", { class: `state ${run.status}` }, run.status === "done" ? "ran to its end" : run.ended_by || run.status) : ""),
  );
}

async function fill() {
  if (report.live) {
    new Live(report, main);
    main.append(section("system", "What runs", ...system()));
    return;
  }
  main.append(section("verdict", "What came out", ...verdicts()));
  const signals = report.signals;
  if (signals.rows > 0) {
    const stored = await unpacked(signals);
    const scene = report.scene;
    const distance = scene && stored.names.includes(scene.track.distance) ? scene.track.distance : null;
    let moving = null;
    const others = await Promise.all((report.others ?? []).map(async (other) => ({ name: other.name, run: await unpacked(other.signals) })));
    const plots = new Plots(stored, { prefer: report.prefer ?? [], distance, called: report.called || (others.length ? report.title : "stored"), others, onTime: (time) => moving?.go(time) });
    if (scene) {
      const place = section("motion", "See it move");
      main.append(place);
      try {
        const { Moving } = await import("./scene.js");
        moving = new Moving(scene, stored, (time) => plots.show(time));
        place.append(moving.element);
        if (others.length) moving.overlay(others[0].run); // as a ghost, until the page has a run of its own
      } catch (error) {
        place.append(element("p", { class: "notice" }, `The moving picture needs WebGL, which is not at hand (${error}). The plots below show the same run.`));
      }
    }
    main.append(section("signals", "Signals", plots.element));
    main.append(section("again", "Change it and run it again", ...again((here) => {
      plots.overlay(here);
      moving?.overlay(here);
    })));
  } else {
    main.append(section("signals", "Signals", element("p", { class: "notice" }, "The run recorded no rows.")));
  }
  main.append(section("system", report.system ? "What ran" : "Where it comes from", ...system()));
}

function verdicts() {
  const parts = [];
  for (const line of report.verdicts) parts.push(element("p", { class: "verdict" }, line));
  for (const line of report.notes) parts.push(element("p", { class: "notice" }, line));
  if (report.certificate.length) parts.push(element("h3", {}, "Estimated coupling error"), element("pre", { tabindex: "0" }, report.certificate.join("\n")));
  for (const { title, lines } of report.texts ?? []) parts.push(element("h3", {}, title), element("pre", { tabindex: "0" }, lines.join("\n")));
  if (report.bonds.length) {
    const rows = report.bonds.map((b) => [b.name, shown(b.residual), shown(b.exchanged), shown(b.share), shown(b.peak)]);
    parts.push(table("Energy of the coupling, by bond", ["bond", "residual in J", "exchanged in J", "share", "peak in W"], rows, [1, 2, 3, 4]));
  }
  if (!parts.length) parts.push(element("p", { class: "quiet" }, "No field of engineering has anything to say of this run, and no bond carries power."));
  return parts;
}

/** @param {(run: any) => void} onRun */
function again(onRun) {
  if (!report.module) return [element("p", { class: "notice" }, `This system does not run in a page: ${report.why_not || "it was not compiled for it"}.`)];
  if (typeof WebAssembly === "undefined") return [element("p", { class: "notice" }, "This browser has no WebAssembly, so the system cannot run here.")];
  return [
    element("p", {}, "Master and components are in this page, compiled to WebAssembly. Change what you like: the run appears over the stored one."),
    new Runner(report, workerText, onRun).element,
  ];
}

function system() {
  const copy = element("button", { type: "button", onclick: async () => {
    await navigator.clipboard?.writeText(report.command);
    copy.textContent = "Copied";
  } }, "Copy");
  const parts = [];
  if (report.system) {
    const rows = report.system.components.map((c) => [c.name, c.source, report.hashes[c.name] ? element("code", {}, report.hashes[c.name].slice(0, 16)) : "–"]);
    parts.push(graph(report.system), table("Components", ["name", "source", "SHA-256 of its FMU"], rows));
  }
  if (report.command) parts.push(element("h3", {}, "Repeat it"), element("div", { class: "command" }, element("code", { tabindex: "0" }, report.command), copy));
  if (report.module) {
    const all = report.module.variables.filter((v) => v.causality === "parameter").map((v) => [v.name, shown(Number(v.start)), v.unit, v.description]);
    parts.push(element("details", {}, element("summary", {}, `All ${all.length} parameters`), table("Parameters", ["name", "value", "unit", "meaning"], all, [1])));
  }
  parts.push(element("p", { class: "quiet" }, Object.entries(report.versions).map(([name, version]) => `${name} ${version}`).join(", ")), report.live ? "" : download());
  return parts;
}

/** The recorded signals, as far as they are in the page, as a CSV file. */
function download() {
  return element("button", { type: "button", onclick: async () => {
    const run = await unpacked(report.signals);
    const quoted = (name) => (/[",\n]/.test(name) ? `"${name.replaceAll('"', '""')}"` : name);
    const lines = [["time", ...run.names.map(quoted)].join(",")];
    for (let k = 0; k < run.t.length; k++) lines.push([run.t[k], ...run.names.map((name) => run.columns.get(name)?.[k])].join(","));
    const link = element("a", { href: URL.createObjectURL(new Blob([`${lines.join("\n")}\n`], { type: "text/csv" })), download: `${report.title}.csv` });
    link.click();
    URL.revokeObjectURL(link.href);
  } }, "Download the signals (CSV)");
}
