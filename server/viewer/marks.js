// SPDX-License-Identifier: MIT
// What is drawn over a net: crosses of the principal permeabilities, the front where the net
// stopped, and the surface itself under it. All keep their place on the screen but are moved a
// little towards the eye, or away from it, so that they lie over or under the net.
import * as THREE from './three.module.min.js';
import * as section from './section.js';
import { centresOf, nodeAt } from './lattice.js';

const CROSSES_MAX = 2500;
export const REASONS = ['boundary', 'collapsed', 'no_convergence', 'degenerate', 'extent', 'fold'];
export const REASON_TEXT = {
  boundary: 'the surface ends here',
  collapsed: 'the yarns are parallel: the spheres no longer meet on the surface',
  no_convergence: 'the solver found no node here',
  degenerate: 'the surface has no tangent plane here',
  extent: 'the extent that was asked for ends here',
  fold: 'the net would overlap itself',
};
const REASON_COLOURS = ['#9aa4b2', '#ff2d87', '#ff8c1a', '#a970ff', '#35c2ff', '#ffd60a'];

const lifted = /* glsl */ `
  uniform float lift;
  vec4 moved(vec3 place) {
    vec4 view = modelViewMatrix * vec4(place, 1.0);
    view.xyz *= 1.0 - lift / max(length(view.xyz), 1e-9);
    return projectionMatrix * view;
  }`;

const lineShaders = {
  vertexShader: `${lifted}
    in vec3 tint;
    out vec3 tone;
    uniform float size;
    void main() { tone = tint; gl_PointSize = size; gl_Position = moved(position); }`,
  fragmentShader: `
    in vec3 tone;
    uniform float rounded;
    layout(location = 0) out vec4 colour;
    void main() {
      float far = rounded * length(gl_PointCoord - 0.5);
      if (far > 0.5) discard;
      colour = vec4(far > 0.32 ? vec3(0.08) : tone, 1.0); // a rim, to be seen on any ground
    }`,
};

const surfaceShaders = {
  vertexShader: `${lifted}
    out vec3 seen;
    out vec3 seenNormal;
    out vec2 place;
    uniform vec4 domain; // of (u, v): lower ends, lengths
    ${section.declare}
    void main() {
      ${section.place}
      place = (uv - domain.xy) / domain.zw;
      seen = (modelViewMatrix * vec4(position, 1.0)).xyz;
      seenNormal = normalMatrix * normal;
      gl_Position = moved(position);
    }`,
  fragmentShader: `
    uniform vec3 tone;
    uniform sampler2D mask;
    in vec3 seen;
    in vec3 seenNormal;
    in vec2 place;
    ${section.declareCut}
    layout(location = 0) out vec4 colour;
    void main() {
      ${section.cut}
      if (texture(mask, place).r < 0.5) discard;
      float facing = abs(dot(normalize(seenNormal), normalize(seen)));
      colour = vec4(tone * (0.55 + 0.45 * facing), 1.0);
    }`,
};

function material(shaders, values) {
  const uniforms = Object.fromEntries(
    Object.entries(values).map(([key, value]) => [key, { value }]),
  );
  uniforms.plane = section.plane;
  return new THREE.ShaderMaterial({
    ...shaders,
    uniforms,
    glslVersion: THREE.GLSL3,
    side: THREE.DoubleSide,
  });
}

const lineMaterials = new Map();

/** One material for all lines of a kind: it stays, because to make its shader again takes longer
 *  than to drape. */
function lineMaterial({ lift, size = 1, rounded = 0 }) {
  const key = [lift, size, rounded].join();
  if (!lineMaterials.has(key)) {
    const style = material(lineShaders, { lift, size, rounded });
    style.userData.shared = true;
    lineMaterials.set(key, style);
  }
  return lineMaterials.get(key);
}

function geometryOf(position, tints) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(position), 3));
  geometry.setAttribute('tint', new THREE.BufferAttribute(new Float32Array(tints), 3));
  return geometry;
}

/** The components of a colour as they go to the screen. */
const tintOf = (text) => new THREE.Color().setStyle(text, THREE.LinearSRGBColorSpace).toArray();

/* ---- permeability ---- */

const corner = (p, node) => [p[3 * node], p[3 * node + 1], p[3 * node + 2]];
const add = (a, b, factor = 1) => a.map((value, k) => value + factor * b[k]);
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const unit = (a) => a.map((value) => value / (Math.hypot(...a) || 1));

/** The normal of a cell, from its diagonals. */
function normalOf({ index, position }, cell) {
  const [b, c, a, , d] = index.subarray(6 * cell, 6 * cell + 6);
  const at = (node) => corner(position, node);
  return unit(cross(add(at(c), at(a), -1), add(at(d), at(b), -1)));
}

/** Lines along the principal directions, lengths as the square roots of k1 and k2. */
export function makeCrosses(lattice, spacing) {
  const { columns } = lattice;
  const k1 = columns['cells.k1'];
  if (!k1) return null;
  const stride = Math.ceil(Math.sqrt(k1.length / CROSSES_MAX));
  const most = k1.reduce((high, value) => Math.max(high, value), 0);
  const reach = 0.48 * stride * Math.min(...spacing);
  const centres = centresOf(lattice);
  const ends = [];
  for (let cell = 0; cell < k1.length; cell++) {
    if (columns['cells.i'][cell] % stride || columns['cells.j'][cell] % stride) continue;
    const middle = corner(centres, cell);
    const normal = normalOf(lattice, cell);
    const first = ['x', 'y', 'z'].map((axis) => columns[`cells.k1_${axis}`][cell]);
    for (const [k, along] of [
      [k1[cell], first],
      [columns['cells.k2'][cell], unit(cross(normal, first))],
    ]) {
      const half = reach * Math.sqrt(k / most);
      ends.push(...add(middle, along, half), ...add(middle, along, -half));
    }
  }
  const white = new Float32Array(ends.length).fill(1);
  const style = lineMaterial({ lift: 0.6 * Math.min(...spacing) });
  return new THREE.LineSegments(geometryOf(ends, white), style);
}

/* ---- rim ---- */

const linear = (tint) => new THREE.Color().setRGB(...tint, THREE.SRGBColorSpace).toArray();

/** The edge of the cloth in the flat pattern, the lips of its cuts in their own tint; null for a net on the way, which comes without it. */
export function makeRim({ columns }, spacing, tint, lipTint) {
  const loops = columns['rim.loop'];
  if (!loops?.length) return null;
  const place = (row) => [
    columns['rim.p'][row] * spacing[0],
    columns['rim.q'][row] * spacing[1],
    0,
  ];
  const ends = [];
  const tints = [];
  let first = 0;
  for (let row = 0; row < loops.length; row++) {
    const last = loops[row + 1] !== loops[row];
    const own = linear(columns['rim.cut']?.[row] ? lipTint : tint);
    ends.push(...place(row), ...place(last ? first : row + 1));
    tints.push(...own, ...own);
    if (last) first = row + 1;
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(ends, 3));
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(tints, 3));
  const rim = new THREE.LineSegments(
    geometry,
    new THREE.LineBasicMaterial({ vertexColors: true, depthTest: false }),
  );
  rim.renderOrder = 1;
  return rim;
}

/* ---- front ---- */

/** The node nearest to a place of the front, which may lie one step beyond the net. */
function nodeBeside(grid, i, j) {
  for (const [a, b] of [
    [0, 0],
    [-1, 0],
    [1, 0],
    [0, -1],
    [0, 1],
    [-1, -1],
    [1, 1],
    [-1, 1],
    [1, -1],
  ]) {
    const node = nodeAt(grid, i + a, j + b);
    if (node >= 0) return node;
  }
  return -1;
}

/** The reason at every node beside the front: Map of node to the reason's number. */
export function frontOf({ columns, grid }) {
  const front = new Map();
  const reasons = columns['front.reason'];
  for (let row = 0; row < reasons.length; row++) {
    const node = nodeBeside(grid, columns['front.i'][row], columns['front.j'][row]);
    if (node >= 0 && !(front.get(node) > 0)) front.set(node, reasons[row]);
  }
  return front;
}

/** A dot, coloured by its reason, at every node beside the front. */
export function makeFront(lattice, front, spacing) {
  const places = [];
  const tints = [];
  for (const [node, reason] of front) {
    places.push(...corner(lattice.position, node));
    tints.push(...tintOf(REASON_COLOURS[reason]));
  }
  const size = 7 * window.devicePixelRatio;
  const style = lineMaterial({ lift: 0.5 * Math.min(...spacing), size, rounded: 1 });
  return new THREE.Points(geometryOf(places, tints), style);
}

/** Places on a body as dots, `lift` before it: [{place, chosen}]. The chosen are larger; tints are
 *  those of the others and theirs. */
export function makeDots(dots, origin, lift, tints) {
  const pointsOf = (chosen) => {
    const some = dots.filter((dot) => dot.chosen === chosen);
    const places = some.flatMap(({ place }) => place.map((value, axis) => value - origin[axis]));
    const size = (chosen ? 14 : 8) * window.devicePixelRatio;
    const style = lineMaterial({ lift, size, rounded: 1 });
    return new THREE.Points(
      geometryOf(
        places,
        some.flatMap(() => tints[Number(chosen)]),
      ),
      style,
    );
  };
  return new THREE.Group().add(pointsOf(false), pointsOf(true));
}

/** What the colours of the dots mean: of the reasons that occur. */
export function fillFrontKey(list, front) {
  const present = [...new Set(front.values())].sort();
  const items = present.map((reason) => {
    const item = document.createElement('li');
    item.textContent = `${REASONS[reason].replace('_', ' ')}: ${REASON_TEXT[REASONS[reason]]}`;
    item.style.setProperty('--dot', REASON_COLOURS[reason]);
    return item;
  });
  list.replaceChildren(...items);
}

/* ---- surface ---- */

/** What is left of a trimmed surface; one white pixel for all of it. */
function maskTexture(mask) {
  const bytes = mask || new Uint8Array([255]);
  const side = Math.sqrt(bytes.length);
  const texture = new THREE.DataTexture(bytes, side, side, THREE.RedFormat);
  texture.magFilter = texture.minFilter = THREE.LinearFilter;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

/** The surface as a quiet body with its edges; `depth` is how far it lies behind the net. */
export function makeSurface(shape, depth, tone, edgeTone) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(shape.position, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(shape.normal, 3));
  if (shape.uv) geometry.setAttribute('uv', new THREE.BufferAttribute(shape.uv, 2));
  geometry.setIndex(new THREE.BufferAttribute(shape.index, 1));
  const [u0, u1, v0, v1] = shape.domain || [0, 1, 0, 1];
  const style = material(surfaceShaders, {
    lift: -depth,
    tone: new THREE.Vector3(...tintOf(tone)),
    domain: new THREE.Vector4(u0, v0, u1 - u0, v1 - v0),
    mask: maskTexture(shape.mask),
  });
  Object.assign(style, { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 });
  const body = new THREE.Mesh(geometry, style);
  const lines = new THREE.BufferGeometry();
  lines.setAttribute('position', geometry.attributes.position);
  const tints = new Float32Array(shape.position.length);
  const tint = tintOf(edgeTone);
  for (let k = 0; k < tints.length; k++) tints[k] = tint[k % 3];
  lines.setAttribute('tint', new THREE.BufferAttribute(tints, 3));
  lines.setIndex(new THREE.BufferAttribute(shape.edges, 1));
  const edges = new THREE.LineSegments(
    lines,
    material(lineShaders, { lift: depth, size: 1, rounded: 0 }),
  );
  const group = new THREE.Group();
  group.add(body, edges);
  group.userData.body = body;
  group.userData.edges = edges;
  return group;
}

/** Moves it to another depth behind the net. */
export function sinkSurface(group, depth) {
  const { body, edges } = group.userData;
  body.material.uniforms.lift.value = -depth;
  edges.material.uniforms.lift.value = depth;
}

export function disposeTree(object) {
  object?.traverse((part) => {
    part.geometry?.dispose();
    part.material?.uniforms?.mask?.value.dispose();
    if (!part.material?.userData.shared) part.material?.dispose();
  });
}
