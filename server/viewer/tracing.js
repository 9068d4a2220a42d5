// SPDX-License-Identifier: MIT
// Lines on the part by places of the picture: what lies under a straight line from one to the next,
// and the edge that is meant by a click beside it.
import { element } from './dom.js';

const REACH = 30; // pixels from the rim within which a line begins there
const MISSED = 10; // beside the part, within which its rim is meant
const SNAP = 7; // from a fold, or an end, within which a point goes there; less than a key moves it
const STEP = 8; // pixels from one place of a line that is drawn to the next
const SLACK = 1e-3; // of the part's radius: what lies nearer to a straight line is left out
const PARTS = 16; // of an edge
const WELD = 1e-5; // of the part's radius: ends of edges nearer than that are one

export const away = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));
const rounded = (place) => place.map((x) => Number(x.toPrecision(9)));

/** The place of the line from a to b that is nearest to a point. */
function nearestOf(a, b, point) {
  const along = b.map((x, k) => x - a[k]);
  const length2 = along.reduce((sum, x) => sum + x * x, 0);
  const share = along.reduce((sum, x, k) => sum + x * (point[k] - a[k]), 0) / (length2 || 1);
  return a.map((x, k) => x + Math.min(Math.max(share, 0), 1) * along[k]);
}

/** Of segments [a, b] that next to a point: {place, segment, far}; null without any. */
function nearestEdge(segments, point) {
  let best = null;
  for (const segment of segments) {
    const place = nearestOf(...segment, point);
    const far = away(place, point);
    if (!best || far < best.far) best = { place, segment, far };
  }
  return best;
}

/** The same segments in parts so short that perspective does not matter. */
const inParts = (segments) =>
  segments.flatMap(([a, b]) => {
    const at = (share) => a.map((x, k) => x + (share / PARTS) * (b[k] - x));
    return Array.from({ length: PARTS }, (_, k) => [at(k), at(k + 1)]);
  });

/** Without points that lie on the straight lines between others, to within `slack`. */
function straightened(path, slack) {
  const kept = [path[0]];
  for (let from = 0, to = 2; to <= path.length; to++) {
    const between = path.slice(from + 1, to);
    const straight = between.every(
      (point) => to < path.length && away(point, nearestOf(path[from], path[to], point)) < slack,
    );
    if (straight) continue;
    from = to - 1;
    kept.push(path[from]);
  }
  return kept;
}

/** The edges of a shape: the `rim`, which one face has, and the `folds` between two. */
function edgesOf({ position, edges, origin, radius }) {
  const place = (n) => origin.map((x, k) => x + position[3 * n + k]);
  const key = (n) => [0, 1, 2].map((k) => Math.round(position[3 * n + k] / (WELD * radius))).join();
  const found = new Map();
  for (let k = 0; k < edges.length; k += 2) {
    const ends = [edges[k], edges[k + 1]];
    const name = ends.map(key).sort().join(' ');
    found.set(name, { segment: ends.map(place), faces: (found.get(name)?.faces ?? 0) + 1 });
  }
  const all = [...found.values()];
  const some = (isRim) => all.filter(({ faces }) => (faces === 1) === isRim);
  return {
    rim: some(true).map(({ segment }) => segment),
    folds: some(false).map(({ segment }) => segment),
  };
}

export class Tracer {
  #edges = new WeakMap(); // of shapes

  /** `view` has the picture, `form` the shape. */
  constructor(view, form) {
    Object.assign(this, { view, form });
  }

  get #edgesOfShape() {
    const { shape } = this.form;
    if (!shape) return { rim: [], folds: [] };
    if (!this.#edges.has(shape)) this.#edges.set(shape, edgesOf(shape));
    return this.#edges.get(shape);
  }

  #pixelsBetween(a, b) {
    const [from, to] = [a, b].map((place) => this.view.pixelsOfPlace(place));
    return Math.hypot(to.x - from.x, to.y - from.y);
  }

  /** The place of the rim, or of other lines on the part, that is meant by one beside it; null where
   *  none is near, or of null. `anywhere`: however far it is. */
  onRim(place, lines, anywhere = false) {
    if (!place) return null;
    const others = lines.flatMap((line) => line.slice(1).map((end, k) => [line[k], end]));
    const found = nearestEdge([...this.#edgesOfShape.rim, ...others], place);
    if (!found || !(anywhere || this.#pixelsBetween(place, found.place) < REACH)) return null;
    return this.#atEnd(found, place);
  }

  /** The place of the rim beside which a click missed the part; null where none is near. */
  missedRim({ clientX, clientY }) {
    const { x, y } = element('pane-solid').getBoundingClientRect();
    const pixels = (place) => {
      const { x, y } = this.view.pixelsOfPlace(place);
      return [x, y];
    };
    const parts = inParts(this.#edgesOfShape.rim);
    const flat = parts.map((part) => Object.assign(part.map(pixels), { part }));
    const found = nearestEdge(flat, [clientX - x, clientY - y]);
    if (!found || found.far > MISSED) return null;
    const [from, to] = found.segment;
    const share = away(found.place, from) / (away(to, from) || 1);
    const [a, b] = found.segment.part;
    return a.map((value, k) => value + share * (b[k] - value));
  }

  /** A place of an edge, or the end of that beside which somebody has clicked. */
  #atEnd({ place, segment }, clicked) {
    return segment.find((end) => this.#pixelsBetween(clicked, end) < SNAP) ?? place;
  }

  /** A place, or that of a fold between faces beside it, at best its end. */
  onFold(place) {
    const found = nearestEdge(this.#edgesOfShape.folds, place);
    if (!found || this.#pixelsBetween(place, found.place) > SNAP) return place;
    return this.#atEnd(found, place);
  }

  /** The places of the part between a and b that lie under the straight line of the picture. */
  between(a, b) {
    const box = element('pane-solid').getBoundingClientRect();
    const [from, to] = [a, b].map((place) => this.view.pixelsOfPlace(place));
    const steps = Math.ceil(Math.hypot(to.x - from.x, to.y - from.y) / STEP);
    const path = [a];
    for (let k = 1; k < steps; k++) {
      const clientX = box.x + from.x + (k / steps) * (to.x - from.x);
      const clientY = box.y + from.y + (k / steps) * (to.y - from.y);
      const place = this.view.placeAt({ clientX, clientY });
      const near = place && away(place, nearestOf(a, b, place)) < away(a, b); // else of a part before it
      if (near) path.push(place);
    }
    const slack = SLACK * (this.form.shape?.radius ?? 0);
    return straightened([...path, b], slack)
      .slice(1, -1)
      .map(rounded);
  }
}

/** A path from corner to corner, and the places between these: paths do not change, so that each is
 *  known by itself. */
export class Paths {
  #known = new WeakMap();

  constructor(tracer) {
    this.tracer = tracer;
  }

  #make(corners, legs) {
    const path = corners.flatMap((corner, k) => [corner, ...(legs[k] ?? [])]);
    this.#known.set(path, { corners, legs });
    return path;
  }

  /** Of a path that was never drawn here all points are corners. */
  cornersOf(path) {
    return this.#known.get(path)?.corners ?? path;
  }

  through(places) {
    const corners = places.map(rounded);
    const legs = corners.slice(1).map((end, k) => this.tracer.between(corners[k], end));
    return this.#make(corners, legs);
  }

  /** The path with one corner elsewhere: what lies between others stays. */
  moved(path, n, place) {
    const corners = this.cornersOf(path).map((corner, k) => (k === n ? rounded(place) : corner));
    const before = this.#known.get(path)?.legs ?? [];
    const legs = corners.slice(1).map((end, k) => {
      const kept = k !== n - 1 && k !== n;
      return kept ? (before[k] ?? []) : this.tracer.between(corners[k], end);
    });
    return this.#make(corners, legs);
  }

  /** The path without a corner. */
  without(path, n) {
    const corners = this.cornersOf(path);
    return this.through(corners.filter((_, k) => k !== n));
  }
}
