// SPDX-License-Identifier: MIT
// Triangles that belong to patches, as the graphics card takes them: the faces of a part from its
// preview, the elements of a mesh from its VTU. Each corner has its own vertex. Runs in the worker.
import { readGlb } from './glb.js';
import { readVtu } from './vtu.js';

const EDGES_MOST = 6e4; // of the elements of a mesh: more would be a grey cloth, and slow
const FEWER = 20000; // triangles, about, of a picture in motion
const KEYS = 2 ** 17; // three numbers below it make one

function boundsOf(arrays) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const values of arrays)
    for (let k = 0; k < values.length; k++) {
      if (values[k] < low[k % 3]) low[k % 3] = values[k];
      if (values[k] > high[k % 3]) high[k % 3] = values[k];
    }
  const size = high.map((value, axis) => value - low[axis]);
  const origin = low.map((value, axis) => (value + high[axis]) / 2);
  return { origin, size, radius: Math.hypot(...size) / 2 || 1 };
}

/** The number of the first vertex at the same place as each one. */
function weld(position) {
  const bits = new Uint32Array(position.buffer, position.byteOffset, position.length);
  const count = position.length / 3;
  let size = 16;
  while (size < 2 * count) size *= 2;
  const table = new Int32Array(size).fill(-1);
  const first = new Uint32Array(count);
  for (let k = 0; k < count; k++) {
    const [x, y, z] = [bits[3 * k], bits[3 * k + 1], bits[3 * k + 2]];
    let at = (Math.imul(x, 73856093) ^ Math.imul(y, 19349663) ^ Math.imul(z, 83492791)) >>> 0;
    at = (at ^ (at >>> 15)) & (size - 1);
    for (; table[at] >= 0; at = (at + 1) & (size - 1)) {
      const other = 3 * table[at];
      if (bits[other] === x && bits[other + 1] === y && bits[other + 2] === z) break;
    }
    if (table[at] < 0) table[at] = k;
    first[k] = table[at];
  }
  return first;
}

/** The edges that one triangle alone has: pairs of vertices. */
function borderOf(position, index) {
  const first = weld(position);
  const count = position.length / 3;
  const seen = new Map();
  for (let at = 0; at < index.length; at++) {
    const a = first[index[at]];
    const b = first[index[at % 3 === 2 ? at - 2 : at + 1]];
    if (a === b) continue;
    const key = Math.min(a, b) * count + Math.max(a, b);
    seen.set(key, (seen.get(key) || 0) + 1);
  }
  const border = [];
  for (const [key, times] of seen)
    if (times === 1) border.push(Math.floor(key / count), key % count);
  return border;
}

/** An empty body of that many triangles and ends of edges. */
function room(triangles, ends) {
  return {
    position: new Float32Array(9 * triangles),
    normal: new Float32Array(9 * triangles),
    patch: new Float32Array(3 * triangles),
    edges: new Float32Array(3 * ends),
    edgePatch: new Float32Array(ends),
  };
}

/** Twice the area vector of the triangle whose corners begin at p[t]. */
function areaVector(p, t) {
  const a = [p[t + 3] - p[t], p[t + 4] - p[t + 1], p[t + 5] - p[t + 2]];
  const b = [p[t + 6] - p[t], p[t + 7] - p[t + 1], p[t + 8] - p[t + 2]];
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function areaOf(p) {
  let area = 0;
  for (let t = 0; t < p.length; t += 9) area += Math.hypot(...areaVector(p, t)) / 2;
  return area;
}

/** Fewer triangles between the same vertices, for a picture in motion: all vertices in a cube become
 *  its first one, and triangles that differ are kept. The cubes are as large as it takes to be about
 *  FEWER; null where the body is not larger than two of that. */
function fewerOf({ position: p }) {
  const corners = p.length / 3;
  if (corners < 6 * FEWER) return null;
  const side = Math.sqrt((2 * areaOf(p)) / FEWER) || 1;
  const cubes = new Map(); // their numbers, in the order of their first vertices
  const first = [];
  const cubeOf = (k) => {
    const [x, y, z] = [0, 1, 2].map((axis) => Math.floor(p[3 * k + axis] / side));
    const key = (x * KEYS + y) * KEYS + z;
    let cube = cubes.get(key);
    if (cube === undefined) cubes.set(key, (cube = first.push(k) - 1));
    return cube;
  };
  const seen = new Set();
  const index = [];
  for (let k = 0; k < corners; k += 3) {
    const [a, b, c] = [cubeOf(k), cubeOf(k + 1), cubeOf(k + 2)].sort((one, two) => one - two);
    const key = (a * KEYS + b) * KEYS + c;
    if (a === b || b === c || seen.has(key)) continue;
    seen.add(key);
    index.push(first[a], first[b], first[c]);
  }
  return Uint32Array.from(index);
}

/** The faces of a part; patch numbers are those of its faces. */
export function facesOf(buffer) {
  const primitives = readGlb(buffer);
  const bounds = boundsOf(primitives.map(({ position }) => position));
  const borders = primitives.map(({ position, index }) => borderOf(position, index));
  const sum = (lists) => lists.reduce((total, { length }) => total + length, 0);
  const body = room(sum(primitives.map(({ index }) => index)) / 3, sum(borders));
  let at = 0;
  let end = 0;
  primitives.forEach(({ face, position, normal, index }, k) => {
    for (const vertex of index) {
      body.patch[at] = face;
      for (let axis = 0; axis < 3; axis++) {
        body.position[3 * at + axis] = position[3 * vertex + axis] - bounds.origin[axis];
        if (normal) body.normal[3 * at + axis] = normal[3 * vertex + axis];
      }
      at++;
    }
    for (const vertex of borders[k]) {
      body.edgePatch[end] = face;
      for (let axis = 0; axis < 3; axis++)
        body.edges[3 * end + axis] = position[3 * vertex + axis] - bounds.origin[axis];
      end++;
    }
  });
  if (primitives.some(({ normal }) => !normal)) flatNormals(body);
  const count = Math.max(...primitives.map(({ face }) => face)) + 1;
  return { ...body, ...bounds, fewer: fewerOf(body), count };
}

/** The corners of each element in turn. */
function cornersOf({ connectivity, offsets }) {
  return Array.from(offsets, (last, k) => connectivity.subarray(k ? offsets[k - 1] : 0, last));
}

/** The pairs of vertices that are sides of elements, each once; none where they are too many. */
function edgesOf(elements, count) {
  const edges = new Map();
  for (const corners of elements)
    for (let k = 0; k < corners.length && edges.size <= EDGES_MOST; k++) {
      const [a, b] = [corners[k], corners[(k + 1) % corners.length]];
      edges.set(Math.min(a, b) * count + Math.max(a, b), [a, b]);
    }
  return edges.size <= EDGES_MOST ? [...edges.values()].flat() : [];
}

/** A mesh with its columns; patch numbers are the rows of these. */
export function elementsOf(buffer) {
  const { columns, points, ...cells } = readVtu(buffer);
  const bounds = boundsOf([points]);
  const elements = cornersOf(cells);
  const triangles = elements.reduce((sum, { length }) => sum + Math.max(length - 2, 0), 0);
  const edges = edgesOf(elements, points.length / 3);
  const body = room(triangles, edges.length);
  const put = (array, at, vertex) => {
    for (let axis = 0; axis < 3; axis++)
      array[3 * at + axis] = points[3 * vertex + axis] - bounds.origin[axis];
  };
  let at = 0;
  elements.forEach((corners, patch) => {
    for (let k = 2; k < corners.length; k++)
      for (const vertex of [corners[0], corners[k - 1], corners[k]]) {
        body.patch[at] = patch;
        put(body.position, at++, vertex);
      }
  });
  edges.forEach((vertex, end) => put(body.edges, end, vertex));
  flatNormals(body);
  return { ...body, ...bounds, fewer: fewerOf(body), count: elements.length, columns };
}

/** Of each triangle its own. */
function flatNormals({ position: p, normal }) {
  for (let t = 0; t < p.length; t += 9) {
    const n = areaVector(p, t);
    for (let k = 0; k < 9; k++) normal[t + k] = n[k % 3];
  }
}

/** Whether a triangle's middle is left of a trimmed surface. */
function isLeft({ mask, uv, domain }, corners) {
  if (!mask) return true;
  const side = Math.sqrt(mask.length);
  const [u0, u1, v0, v1] = domain;
  const share = (axis) => corners.reduce((sum, k) => sum + uv[2 * k + axis], 0) / 3;
  const pixel = (value, low, high) =>
    Math.min(side - 1, Math.floor((side * (value - low)) / (high - low)));
  return mask[pixel(share(1), v0, v1) * side + pixel(share(0), u0, u1)] > 127;
}

/** A surface in tiles: each of its triangles is of the place (x, y, z of the part) nearest to it. */
export function tilesOf(shape, places) {
  const { position: p, index, normal, origin } = shape;
  const kept = [];
  for (let at = 0; at < index.length; at += 3)
    if (isLeft(shape, [index[at], index[at + 1], index[at + 2]])) kept.push(at);
  const body = room(kept.length, 0);
  const near = places.map((place) => place.map((value, axis) => value - origin[axis]));
  kept.forEach((at, t) => {
    const corners = [index[at], index[at + 1], index[at + 2]];
    const middle = [0, 1, 2].map(
      (axis) => corners.reduce((sum, k) => sum + p[3 * k + axis], 0) / 3,
    );
    let [nearest, least] = [0, Infinity];
    near.forEach((place, k) => {
      const away = Math.hypot(place[0] - middle[0], place[1] - middle[1], place[2] - middle[2]);
      if (away < least) [nearest, least] = [k, away];
    });
    corners.forEach((vertex, c) => {
      body.patch[3 * t + c] = nearest;
      for (let axis = 0; axis < 3; axis++) {
        body.position[9 * t + 3 * c + axis] = p[3 * vertex + axis];
        body.normal[9 * t + 3 * c + axis] = normal[3 * vertex + axis];
      }
    });
  });
  return { ...body, origin, size: shape.size, radius: shape.radius, count: places.length };
}

export const buffersOf = ({ position, normal, patch, edges, edgePatch, fewer, columns = {} }) =>
  [position, normal, patch, edges, edgePatch, fewer || [], ...Object.values(columns)].flatMap(
    ({ buffer }) => buffer || [],
  );

/** Some of the patches as a shape to drape on: what `makeSurface` draws. */
export function shapeOf(body, chosen, about) {
  const some = (values, of, width) => {
    const kept = [];
    for (let k = 0; k < of.length; k++)
      if (chosen.has(of[k]))
        for (let axis = 0; axis < width; axis++) kept.push(values[width * k + axis]);
    return kept;
  };
  const corners = some(body.position, body.patch, 3);
  const ends = some(body.edges, body.edgePatch, 3);
  const position = Float32Array.from([...corners, ...ends]);
  const normal = new Float32Array(position.length);
  normal.set(some(body.normal, body.patch, 3));
  const { size } = corners.length ? boundsOf([position]) : body;
  const counted = (first, count) => Uint32Array.from({ length: count }, (_, k) => first + k);
  return {
    kind: 'shell',
    about,
    domain: null,
    uv: null,
    mask: null,
    position,
    normal,
    index: counted(0, corners.length / 3),
    edges: counted(corners.length / 3, ends.length / 3),
    origin: body.origin, // whatever is chosen, so that the picture stays where it is
    size,
    radius: body.radius,
  };
}
