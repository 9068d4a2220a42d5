// SPDX-License-Identifier: MIT
// The usable region of a trimmed surface: its loops as polylines in (u, v), and a mask of what lies
// inside. What lies inside a loop is cut away, or, when the loop is reversed, kept and all else cut
// away. Runs in the worker.
import { Vector4 } from './three.module.min.js';
import * as NURBS from './NURBSUtils.js';

const MASK = 1024; // pixels a side
const STEPS = 64; // a span of a curve

function splinePoints({ degree, knotvector, control_points: inner, weights: beside }) {
  const points = Array.isArray(inner) ? inner : inner.points;
  const weights = (Array.isArray(inner) ? null : inner.weights) || beside;
  const control = points.map(([u, v], k) => new Vector4(u, v, 0, weights ? weights[k] : 1));
  const places = [];
  for (let span = degree; span < points.length; span++) {
    const [low, high] = [knotvector[span], knotvector[span + 1]];
    for (let step = 0; high > low && step <= STEPS; step++) {
      const t = low + ((high - low) * step) / STEPS;
      const point = NURBS.calcBSplinePoint(degree, knotvector, control, t);
      places.push([point.x / point.w, point.y / point.w]);
    }
  }
  return places;
}

function curvePoints(curve) {
  if (curve.data) return curve.data.flatMap(curvePoints);
  return curve.points ? curve.points : splinePoints(curve);
}

/** [{keep, points: [[u, v], ...]}] of a surface, closed. */
export function loopsOf({ trims }) {
  const list = Array.isArray(trims) ? trims : trims?.data || [];
  return list.map((trim) => {
    const points = curvePoints(trim);
    return { keep: Boolean(trim.reversed), points: [...points, points[0]] };
  });
}

/** A square of bytes over the domain, 255 where the surface is; null without loops. */
export function maskOf(loops, [u0, u1, v0, v1]) {
  if (!loops.length) return null;
  const context = new OffscreenCanvas(MASK, MASK).getContext('2d');
  const keeping = loops.filter((loop) => loop.keep);
  const fill = (loop, colour) => {
    context.fillStyle = colour;
    context.beginPath();
    for (const [u, v] of loop.points)
      context.lineTo((MASK * (u - u0)) / (u1 - u0), (MASK * (v - v0)) / (v1 - v0));
    context.fill('evenodd');
  };
  context.fillStyle = keeping.length ? 'black' : 'white';
  context.fillRect(0, 0, MASK, MASK);
  for (const loop of keeping) fill(loop, 'white');
  for (const loop of loops) if (!loop.keep) fill(loop, 'black');
  const { data } = context.getImageData(0, 0, MASK, MASK);
  return new Uint8Array(MASK * MASK).map((_, k) => data[4 * k]);
}
