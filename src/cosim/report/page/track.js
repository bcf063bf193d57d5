/** Where the track lies: its centre line from the recorded curvature over distance. */
import { placeOf } from "./data.js";

const BEFORE = 40; // times the scale, m of straight track before what was run over, and behind it

export class Track {
  /** @param {ArrayLike<number>} distance m @param {ArrayLike<number>} curvature 1/m, positive to the left @param {number} scale 1 for a track of usual gauge */
  constructor(distance, curvature, scale) {
    this.before = BEFORE * scale;
    const s = [];
    const kappa = [];
    for (let k = 0; k < distance.length; k++) {
      if (s.length && !(distance[k] > s[s.length - 1] + 0.02 * scale)) continue;
      s.push(distance[k]);
      kappa.push(curvature[k] ?? 0);
    }
    if (!s.length) {
      s.push(0);
      kappa.push(0);
    }
    this.s = s;
    this.kappa = kappa;
    this.x = [0];
    this.y = [0];
    this.heading = [0];
    for (let k = 1; k < s.length; k++) {
      const ds = s[k] - s[k - 1];
      const turn = (ds * (kappa[k] + kappa[k - 1])) / 2;
      const along = this.heading[k - 1] + turn / 2;
      this.heading.push(this.heading[k - 1] + turn);
      this.x.push(this.x[k - 1] + ds * Math.cos(along));
      this.y.push(this.y[k - 1] + ds * Math.sin(along));
    }
  }

  /** Place and heading at s; straight before the run's begin, of the last curvature behind its end. @param {number} s */
  at(s) {
    const last = this.s.length - 1;
    const k = s <= this.s[0] ? 0 : placeOf(this.s, s);
    const ds = s - this.s[k];
    const kappa = s < this.s[0] ? 0 : k < last ? this.kappa[k] + ((this.kappa[k + 1] - this.kappa[k]) * ds) / (this.s[k + 1] - this.s[k]) / 2 : this.kappa[last];
    const turn = kappa * ds;
    const along = this.heading[k] + turn / 2;
    return { x: this.x[k] + ds * Math.cos(along), y: this.y[k] + ds * Math.sin(along), heading: this.heading[k] + turn };
  }

  /** From where to where the track is drawn. */
  get span() {
    return [this.s[0] - this.before, this.s[this.s.length - 1] + this.before];
  }
}
