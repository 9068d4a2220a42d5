// SPDX-License-Identifier: MIT
// A surface as triangles to show and to click on, from its JSON. Runs in the worker. This is for
// the eye alone: what is draped is the exact surface, by the service.
import { Vector3, Vector4 } from './three.module.min.js';
import * as NURBS from './NURBSUtils.js';
import { makeNormals } from './lattice.js';
import { loopsOf, maskOf } from './trims.js';

const STEPS_MAX = 96; // a side
const STEPS_A_SPAN = 40;

const refuse = (text) => {
  throw new Error(text);
};

/** The surface within what a file may hold: itself, a geomdl export, a drape request. */
export function unwrap(document) {
  const shape = document?.shape;
  if (!shape) return document;
  const data = Array.isArray(shape.data) ? shape.data : [shape.data];
  if (data.length !== 1) refuse(`The file holds ${data.length} surfaces; it must be one.`);
  return data[0];
}

/* ---- NURBS ---- */

/** Parameters from knot to knot, so that creases and ends are on the grid. */
function parameters(knots, degree, size) {
  const spans = [];
  for (let k = degree; k < size; k++)
    if (knots[k + 1] > knots[k]) spans.push([knots[k], knots[k + 1]]);
  const steps = Math.max(2, Math.min(STEPS_A_SPAN, Math.floor(STEPS_MAX / spans.length)));
  const values = [];
  for (const [low, high] of spans)
    for (let k = 0; k < steps; k++) values.push(low + ((high - low) * k) / steps);
  return [...values, knots[size]];
}

/** size_u rows of control points (x, y, z, weight), moved so that `origin` is 0. */
function controlNet(surface, points, weights, origin) {
  const rows = [];
  for (let a = 0; a < surface.size_u; a++) {
    rows.push([]);
    for (let b = 0; b < surface.size_v; b++) {
      const k = a * surface.size_v + b;
      const [x, y, z] = points[k].map((value, axis) => value - origin[axis]);
      rows[a].push(new Vector4(x, y, z, weights ? weights[k] : 1));
    }
  }
  return rows;
}

function checkNurbs(surface, points) {
  const { degree_u, degree_v, size_u, size_v, knotvector_u, knotvector_v } = surface;
  const numbers = [degree_u, degree_v, size_u, size_v].every(Number.isInteger);
  const right =
    numbers &&
    Array.isArray(points) &&
    points.every(Array.isArray) &&
    points.length === size_u * size_v &&
    knotvector_u?.length === size_u + degree_u + 1 &&
    knotvector_v?.length === size_v + degree_v + 1;
  if (!right) refuse('Its sizes do not fit together, so it cannot be shown.');
}

function gridIndex(columns, rows) {
  const index = new Uint32Array((columns - 1) * (rows - 1) * 6);
  let at = 0;
  for (let a = 0; a + 1 < columns; a++)
    for (let b = 0; b + 1 < rows; b++) {
      const k = a * rows + b;
      index.set([k, k + rows, k + rows + 1, k, k + rows + 1, k + 1], at);
      at += 6;
    }
  return index;
}

/** The four sides of a grid as pairs of vertices. */
function gridEdges(columns, rows) {
  const edges = [];
  for (let a = 0; a + 1 < columns; a++)
    for (const b of [0, rows - 1]) edges.push(a * rows + b, (a + 1) * rows + b);
  for (let b = 0; b + 1 < rows; b++)
    for (const a of [0, columns - 1]) edges.push(a * rows + b, a * rows + b + 1);
  return edges;
}

/** The points at all (u, v) of `places`, and these. */
function evaluate(surface, net, places) {
  const position = new Float32Array(places.length * 3);
  const uv = new Float32Array(places.length * 2);
  const { degree_u, degree_v, knotvector_u, knotvector_v } = surface;
  const point = new Vector3();
  places.forEach(([u, v], k) => {
    NURBS.calcSurfacePoint(degree_u, degree_v, knotvector_u, knotvector_v, net, u, v, point);
    point.toArray(position, 3 * k);
    uv.set([u, v], 2 * k);
  });
  return { position, uv };
}

/** Pairs of neighbours along the loops, whose points are numbered from `first`. */
function loopEdges(loops, first) {
  const edges = [];
  for (const { points } of loops) {
    for (let k = 0; k + 1 < points.length; k++) edges.push(first + k, first + k + 1);
    first += points.length;
  }
  return edges;
}

function nurbsShape(surface) {
  const inner = surface.control_points;
  const points = Array.isArray(inner) ? inner : inner?.points;
  const weights = (Array.isArray(inner) ? null : inner?.weights) || surface.weights;
  checkNurbs(surface, points);
  const { origin } = boundsOf(points);
  const net = controlNet(surface, points, weights, origin);
  const us = parameters(surface.knotvector_u, surface.degree_u, surface.size_u);
  const vs = parameters(surface.knotvector_v, surface.degree_v, surface.size_v);
  const domain = [us[0], us.at(-1), vs[0], vs.at(-1)];
  const loops = loopsOf(surface);
  const grid = us.flatMap((u) => vs.map((v) => [u, v]));
  const sides = loops.some((loop) => loop.keep) ? [] : gridEdges(us.length, vs.length);
  return {
    kind: 'nurbs',
    about: `NURBS, degree ${surface.degree_u} × ${surface.degree_v}, ${surface.size_u} × ${surface.size_v} control points`,
    domain,
    ...evaluate(surface, net, [...grid, ...loops.flatMap((loop) => loop.points)]),
    mask: maskOf(loops, domain),
    index: gridIndex(us.length, vs.length),
    edges: new Uint32Array([...sides, ...loopEdges(loops, grid.length)]),
    origin,
  };
}

/* ---- meshes ---- */

/** Edges that one triangle alone has. */
function openEdges(triangles) {
  const seen = new Map();
  const width = 2 ** 26;
  for (const triangle of triangles)
    for (let k = 0; k < 3; k++) {
      const a = triangle[k];
      const b = triangle[(k + 1) % 3];
      const key = Math.min(a, b) * width + Math.max(a, b);
      seen.set(key, (seen.get(key) || 0) + 1);
    }
  const edges = [];
  for (const [key, count] of seen)
    if (count === 1) edges.push(Math.floor(key / width), key % width);
  return new Uint32Array(edges);
}

function meshShape(surface) {
  const { vertices, triangles } = surface;
  if (![vertices, triangles].every((rows) => Array.isArray(rows) && rows.every(Array.isArray)))
    refuse('A mesh needs vertices and triangles, as arrays of three numbers.');
  const { origin } = boundsOf(vertices);
  const position = new Float32Array(vertices.length * 3);
  vertices.forEach((point, k) =>
    position.set(
      point.map((value, axis) => value - origin[axis]),
      3 * k,
    ),
  );
  const index = new Uint32Array(triangles.length * 3);
  triangles.forEach((triangle, k) => index.set(triangle, 3 * k));
  if (index.some((k) => k >= vertices.length))
    refuse('A triangle refers to a vertex that does not exist.');
  const about = `mesh, ${vertices.length} vertices, ${triangles.length} triangles`;
  return {
    kind: 'mesh',
    about,
    domain: null,
    position,
    uv: null,
    index,
    edges: openEdges(triangles),
    origin,
  };
}

/* ---- both ---- */

function boundsOf(points) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const point of points)
    for (let axis = 0; axis < 3; axis++) {
      if (!Number.isFinite(point[axis])) refuse('A point is not three numbers.');
      low[axis] = Math.min(low[axis], point[axis]);
      high[axis] = Math.max(high[axis], point[axis]);
    }
  return { origin: low.map((value, axis) => (value + high[axis]) / 2) };
}

/** The edges of the box around it. */
function sizeOf(position) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let k = 0; k < position.length; k++) {
    low[k % 3] = Math.min(low[k % 3], position[k]);
    high[k % 3] = Math.max(high[k % 3], position[k]);
  }
  return high.map((value, axis) => value - low[axis]);
}

/** Whether it looks like a surface at all. */
export const isSurface = (value) =>
  Boolean(value && typeof value === 'object' && ('degree_u' in value || 'vertices' in value));

/** What the page shows of the surface; throws a sentence when it cannot be shown. */
export function makeShape(surface) {
  const shape = 'vertices' in surface ? meshShape(surface) : nurbsShape(surface);
  const normal = makeNormals(shape.position, shape.index);
  const size = sizeOf(shape.position);
  return { ...shape, normal, size, radius: Math.hypot(...size) / 2 || 1 };
}
