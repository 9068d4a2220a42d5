// SPDX-License-Identifier: MIT
// Steered generators: knobs along warp and weft through the start, by which their curves are bent, and
// the energy that those of least energy save.
//
// A generator has the geodesic curvature k(s), a cubic B-spline with values at the middles of equal
// parts of both sides. On flat cloth k moves its place at the arc length s by y(s) = ∫ (s - t) k(t) dt
// to the left. A knob stands at the end of each part. One that is dragged by d asks for the values
// with y = d there that bend the least, and move the other knobs the least.
import { element } from './dom.js';
import { makeKnob, putKnob } from './knob.js';
import { nodeAt } from './lattice.js';

const STEPS = 64; // of the integral, a part
const HOLD = 0.1; // how much the other knobs hold, against bending
const TIGHTEST = 0.25; // of a spacing by the radius: cloth that bends tighter is refused, or locks
const DIGITS = 6;
const ARMS = [
  { arm: 'warp', step: [1, 0] },
  { arm: 'weft', step: [0, 1] },
];

const add = (a, b, factor = 1) => a.map((value, k) => value + factor * b[k]);
const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const unit = (a) => a.map((value) => value / (Math.hypot(...a) || 1));

/** The uniform cubic B-spline about 0. */
function basis(x) {
  const far = Math.abs(x);
  if (far < 1) return 2 / 3 - far ** 2 + far ** 3 / 2;
  return far < 2 ? (2 - far) ** 3 / 6 : 0;
}

/** y at the ends of `points` parts, of length 1, for each value; the last one goes on beyond. */
function movesOf(points) {
  const at = (t, m) => {
    const beyond = m === points ? basis(t - m - 0.5) + basis(t - m - 1.5) : 0;
    return basis(t - m + 0.5) + beyond;
  };
  const numbers = Array.from({ length: points }, (_, k) => k + 1);
  const move = (end, m) => {
    let sum = 0;
    for (let q = 0.5; q < end * STEPS; q++) sum += (end - q / STEPS) * at(q / STEPS, m);
    return sum / STEPS;
  };
  return numbers.map((end) => numbers.map((m) => move(end, m)));
}

/** The solution of a symmetric system that is positive definite. */
function solve(matrix, right) {
  const rows = matrix.map((row, k) => [...row, right[k]]);
  rows.forEach((pivot, c) =>
    rows.forEach((row, r) => {
      if (r === c) return;
      const factor = row[c] / pivot[c];
      for (let q = c; q < row.length; q++) row[q] -= factor * pivot[q];
    }),
  );
  return rows.map((row, k) => row.at(-1) / row[k]);
}

/** The values that move the knob `n` of `points` by 1, parts of length 1. */
export function bendingOf(points, n) {
  const moves = movesOf(points);
  const own = moves[n];
  const held = moves.filter((_, k) => k !== n);
  const matrix = own.map((_, p) =>
    own.map((_, q) => Number(p === q) + HOLD * held.reduce((sum, row) => sum + row[p] * row[q], 0)),
  );
  const values = solve(matrix, own);
  return values.map((value) => value / dot(own, values));
}

export class Steering {
  /** `onLive` while a knob is dragged, `onSettled` when the generators are others. */
  constructor(view, form, history, { onLive, onSettled }) {
    Object.assign(this, { view, form, history, onLive, onSettled });
    this.knobs = [];
    for (const id of ['generators', 'steer-points'])
      element(id).addEventListener('change', () => this.#choose());
  }

  /** Other generators are in the form. */
  load() {
    const kind = kindOf(this.form.generators);
    element('generators').querySelector('[value="other"]').hidden = kind !== 'other';
    element('generators').value = kind;
    const steered = this.form.generators?.warp?.steered ?? this.form.generators?.weft?.steered;
    if (steered?.points) element('steer-points').value = steered.points;
    element('steer').hidden = !['least_energy', 'steered'].includes(kind);
    this.#make();
  }

  /** What the select says; knobs begin with what was found, or with geodesics. */
  #choose() {
    const kind = element('generators').value;
    if (kind === 'other') return;
    this.history.note();
    const points = Math.min(
      Math.max(Math.round(Number(element('steer-points').value)) || 4, 1),
      16,
    );
    const of = {
      least_energy: () => ({ steered: { points } }),
      steered: (arm) => this.#begin(arm, points),
    };
    this.form.generators =
      of[kind] && Object.fromEntries(ARMS.map(({ arm }) => [arm, of[kind](arm)]));
    this.load();
    this.onSettled();
  }

  #begin(arm, points) {
    const found = this.summary?.steering?.generators?.[arm]?.steered;
    const kept = found ?? this.form.generators?.[arm]?.steered;
    if (kept?.values && kept.values.length === 2 * points) return { steered: kept };
    const length = this.#lengths(arm);
    const values = new Array(2 * points).fill(0);
    return { steered: { points, values, ...(length ? { length } : {}) } };
  }

  /** The lengths of both sides of a generator in the net that is shown; null without them. */
  #lengths(arm) {
    if (!this.lattice) return null;
    const axis = arm === 'warp' ? 0 : 1;
    const count = (sense) => this.#nodesOf(axis, sense).length - 1;
    const length = [count(-1), count(1)].map((steps) => steps * this.spacing[axis]);
    return length.every((one) => one > 0) ? length : null;
  }

  /** The nodes from the start along an arm. */
  #nodesOf(axis, sense) {
    const { grid } = this.lattice;
    const nodes = [];
    for (let n = 0; ; n++) {
      const place = [0, 0];
      place[axis] = sense * n;
      const node = nodeAt(grid, ...place);
      if (node < 0) return nodes;
      nodes.push(node);
    }
  }

  /** The drape that is shown, also one on the way; null: none. */
  show(drape) {
    this.lattice = drape?.lattice;
    this.spacing = drape?.spacing;
    if (!drape?.passing) this.summary = drape?.summary;
  }

  /* ---- knobs ---- */

  #make() {
    const { generators } = this.form;
    const shown = kindOf(generators) === 'steered' ? ARMS : [];
    this.knobs = shown.flatMap(({ arm }, axis) => {
      const { steered } = generators[arm];
      const points = steered.values.length / 2;
      const all = [-1, 1].flatMap((sense) =>
        Array.from({ length: points }, (_, n) => ({ arm, axis, sense, n, points })),
      );
      return steered.length ? all.map((one) => ({ ...one, knob: this.#knob(one) })) : [];
    });
    element('steer-knobs').replaceChildren(...this.knobs.map(({ knob }) => knob));
    this.view.stage?.redraw();
  }

  /** The length of a part on the knob's side. */
  #partOf({ arm, sense, points }) {
    return this.form.generators[arm].steered.length[sense < 0 ? 0 : 1] / points;
  }

  /** {place, tangent, normal} of the net at a knob; null where it does not reach. */
  #at(which) {
    if (!this.lattice) return null;
    const { axis, sense, n } = which;
    const { position, normal, origin } = this.lattice;
    const nodes = this.#nodesOf(axis, sense);
    const far = (this.#partOf(which) * (n + 1)) / this.spacing[axis];
    const k = Math.min(Math.floor(far), nodes.length - 2);
    if (k < 0) return null;
    const of = (node) => [0, 1, 2].map((x) => position[3 * node + x] + origin[x]);
    const [a, b] = [of(nodes[k]), of(nodes[k + 1])];
    const way = add(b, a, -1);
    return {
      place: add(a, way, Math.min(far - k, 1)),
      tangent: unit(way.map((value) => sense * value)),
      normal: unit([...normal.subarray(3 * nodes[k], 3 * nodes[k] + 3)]),
    };
  }

  #knob(which) {
    const { arm, sense, n, points } = which;
    let before = null;
    let from = null;
    return makeKnob(this.view, {
      label: `Point ${n + 1} of ${points} of the ${arm}, on its ${sense < 0 ? 'negative' : 'positive'} side. Drag it, or use the arrow keys.`,
      kind: `steer ${arm}`,
      begin: () => {
        before = this.history.read();
        from = this.#at(which);
      },
      move: (_, event) => {
        if (!from) return false;
        this.#bend(which, before.generators[arm].steered, this.#leftOf(from, event));
        this.onLive();
        return true;
      },
      end: (kept) => {
        if (!kept) return this.history.write(before);
        this.history.note(before);
        this.onSettled();
      },
      again: () =>
        this.knobs.find((one) => one.arm === arm && one.sense === sense && one.n === n)?.knob,
    });
  }

  /** How far to the left of where a knob stood the pointer is in the picture. */
  #leftOf({ place, tangent, normal }, { clientX, clientY }) {
    const pane = element('pane-solid').getBoundingClientRect();
    const step = this.view.shape.radius / 100;
    const beside = add(place, cross(normal, tangent), step);
    const [from, to] = [place, beside].map((one) => this.view.pixelsOfPlace(one));
    const way = [to.x - from.x, to.y - from.y];
    const towards = [clientX - pane.x - from.x, clientY - pane.y - from.y];
    return (step * dot(towards, way)) / Math.max(dot(way, way), 1); // less where it is seen from its end
  }

  /** Moves a place of a generator to the left by so much. */
  #bend(which, steered, distance) {
    const { arm, sense, n, points } = which;
    const factor = distance / this.#partOf(which) ** 2;
    const values = [...steered.values];
    const most = TIGHTEST / Math.max(...this.form.spacing);
    bendingOf(points, n).forEach((value, m) => {
      const k = sense < 0 ? points - 1 - m : points + m;
      const wanted = Math.min(Math.max(values[k] + factor * value, -most), most);
      values[k] = Number(wanted.toPrecision(DIGITS));
    });
    this.form.generators = { ...this.form.generators, [arm]: { steered: { ...steered, values } } };
  }

  /** Puts the knobs where they are in the picture. */
  draw(project, hidden) {
    element('steer-knobs').hidden = hidden || !this.lattice;
    if (element('steer-knobs').hidden) return;
    for (const which of this.knobs) {
      const at = this.#at(which);
      which.knob.hidden = !at;
      if (at) putKnob(which.knob, project(at.place));
    }
  }
}

/** Which choice of the form generators are: 'other' for those that it has no word for. */
function kindOf(generators) {
  const arms = ['warp', 'weft'].map((arm) => generators?.[arm] ?? 'geodesic');
  if (arms.every((arm) => arm === 'geodesic')) return '';
  const least = (arm) =>
    arm === 'least_energy' || (arm.steered && !(arm.steered.values ?? arm.steered[0]));
  if (arms.every(least)) return 'least_energy';
  return arms.every((arm) => arm.steered?.values) ? 'steered' : 'other';
}
