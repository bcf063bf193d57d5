/** Bodies of a scene as meshes: what they look like, and where they stand at a time. */
import * as THREE from "three";
import { valueAt, wayAt } from "./data.js";

const LOOKS = {
  car: { color: 0x6f8fb5, opacity: 0.32 },
  frame: { color: 0x46505f },
  wheel: { color: 0x9aa3ae },
  gimbal: { color: 0xc2410c },
  rotor: { color: 0xf0b429 },
};
const GHOST = 0xfb9a5b;

/** @param {string} role @param {boolean} ghost */
function material(role, ghost) {
  const look = LOOKS[role] ?? { color: 0x888888 };
  const opacity = ghost ? 0.25 : (look.opacity ?? 1);
  return new THREE.MeshStandardMaterial({ color: ghost ? GHOST : look.color, transparent: opacity < 1, opacity, roughness: 0.65, metalness: 0.15, depthWrite: opacity >= 1 });
}

/** A box, or a disc about its y axis with a spoke that shows how it turns. @param {any} shape @param {boolean} ghost */
function mesh(shape, ghost) {
  const looks = material(shape.role, ghost);
  if (shape.size) {
    const made = new THREE.Mesh(new THREE.BoxGeometry(.../** @type {[number, number, number]} */ (shape.size)), looks);
    const [x, y, z] = shape.at ?? [0, 0, 0];
    made.position.set(x, y, z);
    return made;
  }
  const disc = new THREE.Group();
  const tread = new THREE.Mesh(new THREE.CylinderGeometry(shape.radius, shape.radius, shape.width, 40), looks);
  disc.add(tread);
  if (shape.flange) {
    const flange = new THREE.Mesh(new THREE.CylinderGeometry(shape.radius + shape.flange, shape.radius + shape.flange, 0.2 * shape.width, 40), looks);
    flange.position.y = (shape.outside ? 1 : -1) * Math.sign(shape.side || 1) * 0.6 * shape.width;
    disc.add(flange);
  }
  const spoke = new THREE.Mesh(new THREE.BoxGeometry(2 * shape.radius * 0.96, shape.width * 1.5, 0.15 * shape.radius), material("frame", ghost));
  disc.add(spoke);
  return disc;
}

export class Vehicle {
  /** @param {any} scene @param {import("./data.js").Run} run @param {import("./track.js").Track} track @param {boolean} ghost */
  constructor(scene, run, track, ghost) {
    this.scene = scene;
    this.run = run;
    this.track = track;
    this.group = new THREE.Group();
    this.bodies = scene.bodies.map((body) => {
      const group = new THREE.Group();
      for (const shape of body.shapes) group.add(mesh(shape, ghost));
      const parts = (body.parts ?? []).map((part) => {
        const turning = new THREE.Group();
        turning.position.set(.../** @type {[number, number, number]} */ (part.at));
        for (const shape of part.shapes) turning.add(mesh({ ...shape, side: part.at[1] }, ghost));
        group.add(turning);
        return { part, turning, angles: typeof part.rate === "string" ? integral(run, part.rate) : null };
      });
      this.group.add(group);
      return { body, group, parts };
    });
    this.arrows = ghost ? [] : scene.forces.map((force) => this.arrow(force));
  }

  /** @param {any} force */
  arrow(force) {
    const made = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, 0x17803d, 0.18, 0.1);
    const flange = new THREE.Mesh(new THREE.SphereGeometry(0.07, 16, 12), new THREE.MeshBasicMaterial({ color: 0xd1242f }));
    this.group.add(made, flange);
    return { force, made, flange };
  }

  /** Everything where it is at a time. @param {number} time s @param {number} times how much larger small motions are shown */
  place(time, times) {
    for (const { body, group, parts } of this.bodies) {
      const value = (key) => (body[key] ? valueAt(this.run, body[key], time) : 0) * times;
      const s = body.offset + wayAt(this.run, body.along, time);
      const at = this.track.at(s);
      const y = value("lateral");
      group.position.set(at.x - y * Math.sin(at.heading), at.y + y * Math.cos(at.heading), body.height + value("vertical"));
      group.rotation.set(value("roll"), value("pitch"), at.heading + value("yaw"), "ZXY");
      for (const { part, turning, angles } of parts) {
        const angle = angles ? angles(time) : part.angle ? valueAt(this.run, part.angle, time) : wayAt(this.run, part.rate, time);
        turning.setRotationFromAxisAngle(new THREE.Vector3(...part.axis), angle);
      }
    }
    const largest = 25000; // N, as long as 1 m
    for (const { force, made, flange } of this.arrows) {
      const { group } = this.bodies.find(({ body }) => body.name === force.body) ?? this.bodies[0];
      group.updateMatrixWorld();
      const from = group.localToWorld(new THREE.Vector3(...force.at));
      const Y = valueAt(this.run, force.lateral, time);
      const Q = valueAt(this.run, force.vertical, time);
      const side = Math.sign(force.at[1]) || 1;
      const direction = new THREE.Vector3(0, -side * Y, Q).applyAxisAngle(new THREE.Vector3(0, 0, 1), group.rotation.z);
      const size = direction.length();
      made.visible = size > 1;
      if (made.visible) {
        made.position.copy(from);
        made.setDirection(direction.clone().normalize());
        made.setLength(Math.max(0.2, size / largest), 0.18, 0.1);
      }
      flange.position.copy(from);
      flange.visible = Math.abs(valueAt(this.run, force.flange, time)) > 1;
    }
  }
}

/** The angle of a turning rate, as a function of time. @param {import("./data.js").Run} run @param {string} name */
function integral(run, name) {
  const rate = run.columns.get(name);
  const angles = new Float64Array(run.t.length);
  for (let k = 1; rate && k < angles.length; k++) angles[k] = angles[k - 1] + ((rate[k] + rate[k - 1]) / 2) * (run.t[k] - run.t[k - 1]);
  const whole = { t: run.t, columns: new Map([["angle", angles]]), names: ["angle"], units: ["rad"], group: 1 };
  return (time) => valueAt(/** @type {any} */ (whole), "angle", time);
}
