/** One contact seen along the track: the sections of wheel and rail at true scale, where they are, and what they press. */
import { shown, valueAt } from "./data.js";
import { drawn, element } from "./dom.js";

const WIDE = 0.11; // m that the picture shows across
const HIGH = 0.075;
const NEWTON = 0.02 / 25000; // m of an arrow for a newton

export class Section {
  /** @param {any} scene @param {import("./data.js").Run} run */
  constructor(scene, run) {
    this.scene = scene;
    this.run = run;
    this.force = scene.forces[0];
    this.wheel = drawn("path", { class: "wheel" });
    this.rail = drawn("path", { class: "rail" });
    this.tread = drawn("circle", { r: 0.0012, class: "tread" });
    this.flange = drawn("circle", { r: 0.0018, class: "flange" });
    this.arrow = drawn("path", { class: "arrow" });
    this.picture = drawn("svg", { viewBox: `${-WIDE / 2} ${-HIGH * 0.62} ${WIDE} ${HIGH}`, role: "img", "aria-label": "The contact along the track" }, this.rail, this.wheel, this.arrow, this.tread, this.flange);
    this.words = element("p", { class: "quiet" });
    const pick = element("select", { onchange: (event) => this.choose(Number(event.target.value)) }, ...scene.forces.map((force, k) => element("option", { value: k }, force.name)));
    this.element = element("div", { class: "contact" }, element("label", {}, "contact ", pick), this.picture, this.words);
    this.choose(0);
  }

  /** @param {number} k */
  choose(k) {
    this.force = this.scene.forces[k];
    const mirror = this.side < 0 ? -1 : 1;
    const path = (points, closing) => `M${points.map(([y, z]) => `${-mirror * y} ${-z}`).join("L")}${closing}`;
    const { wheel, rail } = this.scene.profiles;
    this.rail.setAttribute("d", path(rail, `V0.05H${-mirror * rail[0][0]}Z`));
    this.wheel.setAttribute("d", path(wheel, `V-0.05H${-mirror * wheel[0][0]}Z`));
    if (this.time !== undefined) this.place(this.time);
  }

  /** 1 for a wheel on the left. */
  get side() {
    return Math.sign(this.force.at[1]) || 1;
  }

  /** @param {number} time s */
  place(time) {
    this.time = time;
    const body = this.scene.bodies.find(({ name }) => name === this.force.body) ?? this.scene.bodies[0];
    const value = (key) => (key ? valueAt(this.run, key, time) : 0);
    const [y, z, roll] = [value(body.lateral), value(body.vertical), value(body.roll)];
    const down = -(z + roll * this.force.at[1]);
    // seen from behind, left is on the left: what lies to the left has a negative x in the picture
    this.wheel.setAttribute("transform", `translate(${-y} ${down}) rotate(${(roll * 180) / Math.PI})`);
    const [Y, Q, flange] = [value(this.force.lateral), value(this.force.vertical), value(this.force.flange)];
    const touching = Math.abs(flange) > 1;
    const corner = this.scene.profiles.rail;
    const edge = this.side * (this.outside ? 1 : -1);
    const at = touching ? [-edge * Math.max(...corner.map(([across]) => across)) * 0.8, 0.006] : [0, 0];
    this.flange.setAttribute("visibility", touching ? "visible" : "hidden");
    this.flange.setAttribute("cx", String(at[0]));
    this.flange.setAttribute("cy", String(at[1]));
    this.tread.setAttribute("visibility", Q > 1 ? "visible" : "hidden");
    this.arrow.setAttribute("d", `M${at[0]} ${at[1]}l${edge * Y * NEWTON} ${-Q * NEWTON}`);
    this.words.textContent = `${this.force.name}: ${shown(Number((1000 * y).toPrecision(3)))} mm to the left, Q = ${shown(Number((Q / 1000).toPrecision(3)))} kN, Y = ${shown(Number((Y / 1000).toPrecision(3)))} kN${touching ? `, flange ${shown(Number((flange / 1000).toPrecision(3)))} kN` : ""}. Sections at true scale, ${1000 * WIDE} mm across, of the components' own values.`;
  }

  /** Whether flanges run outside the rails. */
  get outside() {
    for (const body of this.scene.bodies) for (const part of body.parts ?? []) for (const shape of part.shapes) if (shape.role === "wheel") return Boolean(shape.outside);
    return false;
  }
}
