/** The moving vehicle on its track, with what plays it. */
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Vehicle } from "./bodies.js";
import { Section } from "./section.js";
import { shown, wayAt } from "./data.js";
import { element } from "./dom.js";
import { Track } from "./track.js";

const SLEEPERS = 0.65; // m between them
const USUAL = 0.7475; // m, half the distance of the running lines that all sizes here are for

export class Moving {
  /** @param {any} scene @param {import("./data.js").Run} run @param {(time: number) => void} onTime */
  constructor(scene, run, onTime) {
    this.scene = scene;
    this.run = run;
    this.onTime = onTime;
    this.start = run.t[0];
    this.stop = run.t[run.t.length - 1];
    this.time = this.start;
    this.exaggeration = 1;
    this.build();
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, preserveDrawingBuffer: true });
    this.world = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(40, 16 / 9, 0.005, 2000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.render());
    this.world.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 2.2));
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(30, -40, 60);
    this.world.add(sun);
    this.scale = scene.track.half_gauge / USUAL;
    this.lay();
    this.ghost = null;
    new ResizeObserver(() => this.resize()).observe(this.stage);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.paint());
    this.paint();
    this.look("outside");
    this.go(this.start);
  }

  /** The track as far as the run has come, and the vehicle on it. */
  lay() {
    const { scene, run } = this;
    this.track = new Track(
      Float64Array.from(run.t, (time) => wayAt(run, scene.track.distance, time)),
      run.columns.get(scene.track.curvature) ?? [],
      this.scale,
    );
    for (const old of [this.bed, this.vehicle?.group]) if (old) this.drop(old);
    this.bed = rails(this.track, scene.track.half_gauge, this.scale);
    this.vehicle = new Vehicle(scene, run, this.track, false);
    this.world.add(this.bed, this.vehicle.group);
    this.laid = { rows: run.t.length, span: run.t[run.t.length - 1] - run.t[0] };
  }

  /** @param {THREE.Object3D} group */
  drop(group) {
    this.world.remove(group);
    group.traverse((part) => {
      const mesh = /** @type {any} */ (part);
      mesh.geometry?.dispose();
      mesh.material?.dispose();
    });
  }

  /** The run has become longer: whoever was at its end goes on there. @param {boolean} last */
  grown(last) {
    const { t } = this.run;
    const atEnd = this.time >= this.stop;
    const span = t[t.length - 1] - t[0];
    if (last || t.length < this.laid.rows || span > 1.05 * this.laid.span) this.lay();
    this.stop = t[t.length - 1];
    this.scrub.max = String(this.stop);
    this.scrub.step = String(span / 2000 || 1);
    this.go(atEnd && !this.playing ? this.stop : this.time);
  }

  build() {
    this.canvas = element("canvas", { role: "img", "aria-label": "The vehicle on its track. The plots below show the same run in numbers.", tabindex: "0" });
    this.stage = element("div", { class: "stage" }, this.canvas);
    this.button = element("button", { type: "button", class: "main", onclick: () => this.play(!this.playing) }, "Play");
    this.scrub = element("input", { type: "range", min: this.start, max: this.stop, step: (this.stop - this.start) / 2000 || 1, value: this.start, "aria-label": "time", oninput: () => this.go(Number(this.scrub.value)) });
    this.clock = element("output", {});
    const pick = (label, options, onchange) => element("label", {}, `${label} `, element("select", { onchange: (event) => onchange(event.target.value) }, ...options.map(([value, text]) => element("option", { value }, text))));
    this.element = element(
      "div",
      {},
      this.stage,
      element("div", { class: "play" }, this.button, this.scrub, this.clock),
      element(
        "div",
        { class: "play" },
        pick("speed", [["1", "as it was"], ["0.25", "a quarter"], ["0.05", "a twentieth"], ["4", "four times"]], (value) => (this.rate = Number(value))),
        pick("camera", [["outside", "beside"], ["following", "behind"], ["driver", "driver's"], ["above", "above"], ["gear", "at the front wheels"]], (value) => this.look(value)),
        pick("small motions", [["1", "as they are"], ["10", "10 times"], ["30", "30 times"]], (value) => {
          this.exaggeration = Number(value);
          this.go(this.time);
        }),
      ),
    );
    this.contact = this.scene.profiles?.wheel && this.scene.forces.length ? new Section(this.scene, this.run) : null;
    if (this.contact) this.element.append(this.contact.element);
    this.rate = 1;
    this.playing = false;
  }

  paint() {
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.world.background = new THREE.Color(dark ? 0x181c22 : 0xeef1f4);
    this.render();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  /** Where the camera stands, in the track frame of what it looks at: forward, left, up. @param {string} view */
  look(view) {
    this.view = view;
    const { place, target } = this.eyes();
    this.camera.position.copy(place);
    this.controls.target.copy(target);
    this.controls.update();
    this.render();
  }

  eyes() {
    const s = wayAt(this.run, this.scene.track.distance, this.time);
    const half = Math.max(...this.scene.bodies.map((body) => Math.abs(body.offset))) / this.scale;
    const far = Math.max(1, half / 3.5); // of long vehicles
    const views = { outside: [[5 * far, -13 * far, 5 * far], [0, 0, 1]], following: [[-16, 3, 4.5], [0, 0, 1.2]], driver: [[half + 1.5, 0, 2.4], [half + 12, 0, 1]], above: [[0, -0.01, 20 * far], [0, 0, 0]], gear: [[half + 2.4, -2.6, 1.1], [half, 0, 0.35]] };
    const [from, to] = (views[this.view] ?? views.outside).map((place) => place.map((x) => x * this.scale));
    const world = ([forward, left, up]) => {
      const at = this.track.at(s + (this.view === "driver" ? forward : 0));
      const ahead = this.view === "driver" ? 0 : forward;
      return new THREE.Vector3(at.x + ahead * Math.cos(at.heading) - left * Math.sin(at.heading), at.y + ahead * Math.sin(at.heading) + left * Math.cos(at.heading), up);
    };
    return { place: world(from), target: world(to) };
  }

  /** @param {number} time */
  go(time) {
    const before = this.eyes();
    this.time = Math.min(this.stop, Math.max(this.start, time));
    const now = this.eyes();
    if (this.view === "driver") {
      this.camera.position.copy(now.place);
      this.controls.target.copy(now.target);
    } else {
      const step = now.target.clone().sub(before.target);
      this.camera.position.add(step);
      this.controls.target.add(step);
    }
    this.camera.lookAt(this.controls.target);
    this.vehicle.place(this.time, this.exaggeration);
    this.contact?.place(this.time);
    this.ghost?.place(Math.min(this.time, this.ghost.run.t[this.ghost.run.t.length - 1]), this.exaggeration);
    this.scrub.value = String(this.time);
    const s = wayAt(this.run, this.scene.track.distance, this.time);
    this.clock.textContent = `t = ${this.time.toFixed(2)} s, s = ${shown(Number(s.toFixed(1)))} m`;
    this.render();
  }

  render() {
    this.renderer.render(this.world, this.camera);
  }

  /** @param {boolean} on */
  play(on) {
    this.playing = on;
    this.button.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (this.time >= this.stop) this.go(this.start);
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      this.go(this.time + ((now - last) / 1000) * this.rate);
      last = now;
      this.onTime(this.time);
      if (this.time >= this.stop) this.play(false);
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  /** A run of the page beside the stored one, as a ghost. @param {import("./data.js").Run|null} run */
  overlay(run) {
    if (this.ghost) this.world.remove(this.ghost.group);
    this.ghost = run ? new Vehicle(this.scene, run, this.track, true) : null;
    if (this.ghost) this.world.add(this.ghost.group);
    this.go(this.time);
  }
}

/** Rails and sleepers. @param {Track} track @param {number} half half the gauge, m @param {number} scale of everything */
function rails(track, half, scale) {
  const group = new THREE.Group();
  const [from, to] = track.span;
  const n = Math.min(1200, Math.ceil((to - from) / (0.5 * scale)));
  const steel = new THREE.MeshStandardMaterial({ color: 0x7d858f, roughness: 0.4, metalness: 0.5 });
  for (const side of [half, -half]) {
    const points = Array.from({ length: n + 1 }, (_, k) => {
      const at = track.at(from + ((to - from) * k) / n);
      return new THREE.Vector3(at.x - side * Math.sin(at.heading), at.y + side * Math.cos(at.heading), -0.05 * scale);
    });
    group.add(new THREE.Mesh(new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), n, 0.05 * scale, 6), steel));
  }
  const count = Math.min(2000, Math.floor((to - from) / (SLEEPERS * scale)));
  const sleepers = new THREE.InstancedMesh(new THREE.BoxGeometry(0.22 * scale, 2.4 * scale, 0.1 * scale), new THREE.MeshStandardMaterial({ color: 0x8c8173, roughness: 1 }), count);
  const place = new THREE.Object3D();
  for (let k = 0; k < count; k++) {
    const at = track.at(from + k * SLEEPERS * scale);
    place.position.set(at.x, at.y, -0.16 * scale);
    place.rotation.set(0, 0, at.heading);
    place.updateMatrix();
    sleepers.setMatrixAt(k, place.matrix);
  }
  group.add(sleepers);
  return group;
}
