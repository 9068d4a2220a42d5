// SPDX-License-Identifier: MIT
// A draped net on the graphics card: cells coloured by a field, yarns, outlines of locked cells and
// the marked cell, all in one mesh and one shader; the same buffers laid flat give the pattern.
import * as THREE from './three.module.min.js';
import { withIndex } from './scene.js';
import { textures } from './textures.js';
import * as section from './section.js';

const NOWHERE = 1e9;
const LEAST_COSINE = 0.05; // of a shear that is drawn

const vertexShader = /* glsl */ `
  in vec2 place;        // (i, j)
  in float slip;        // warp steps by which the next fibre's weft goes on, as slipsOf
  in vec2 field;        // value; sides of the owned cell where locked meets unlocked, + 16 if locked
  uniform vec2 spacing;
  uniform float unrolled;
  out vec2 at;
  out float slipped;
  flat out vec2 cell;
  flat out vec2 ofCell;
  out float ofNode;
  out vec3 seen;
  out vec3 seenNormal;
  flat out int vertex;
  ${section.declare}
  void main() {
    ${section.place}
    vec3 flatPlace = vec3(place * spacing, 0.0);
    vec4 view = modelViewMatrix * vec4(mix(position, flatPlace, unrolled), 1.0);
    at = place;
    slipped = slip * (1.0 - unrolled);
    cell = place;
    ofCell = field;
    ofNode = field.x;
    seen = view.xyz;
    seenNormal = normalMatrix * normal;
    vertex = gl_VertexID;
    gl_Position = projectionMatrix * view;
  }`;

const fragmentShader = /* glsl */ `
  uniform sampler2D map;
  uniform float low, high, smoothly, yarns, outlines, unrolled, coarse;
  uniform vec2 hovered, pinned;
  in vec2 at;
  in float slipped;
  flat in vec2 cell;
  flat in vec2 ofCell;
  in float ofNode;
  in vec3 seen;
  in vec3 seenNormal;
  layout(location = 0) out vec4 colour;
  ${section.declareCut}

  float stroke(float pixels, float width) {
    return 1.0 - smoothstep(width - 0.5, width + 0.5, pixels);
  }
  // Distance, in pixels, to the sides that the mask names.
  float toSides(vec4 sides, float mask) {
    vec4 wanted = step(0.5, mod(floor(mask / vec4(1.0, 2.0, 4.0, 8.0)), 2.0));
    vec4 far = mix(vec4(1e6), sides, wanted);
    return min(min(far.x, far.y), min(far.z, far.w));
  }
  void main() {
    if (unrolled < 0.5) ${section.cut}
    float value = mix(ofCell.x, ofNode, smoothly);
    float part = clamp((value - low) / (high - low), 0.0, 1.0);
    vec3 tone = texture(map, vec2((part * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    if (value > 1e29) tone = vec3(0.5);
    float facing = abs(dot(normalize(seenNormal), normalize(seen)));
    tone *= mix(0.66 + 0.34 * facing, 1.0, unrolled);

    vec2 pixel = max(fwidth(at), vec2(1e-6));
    vec2 yarn = at + vec2(slipped * (at.y - floor(at.y + 0.5)), 0.0); // weft, broken between fibres
    vec2 toLine = abs(fract(yarn + 0.5) - 0.5) / pixel;
    float room = 1.0 - smoothstep(0.12, 0.34, max(pixel.x, pixel.y));
    tone = mix(tone, vec3(0.04, 0.05, 0.08), 0.42 * yarns * room * stroke(min(toLine.x, toLine.y), 0.6));
    tone = mix(tone, vec3(1.0, 0.62, 0.2), yarns * stroke(abs(at.y) / pixel.y, 1.3));
    tone = mix(tone, vec3(0.55, 0.85, 1.0), yarns * stroke(abs(yarn.x) / pixel.x, 1.3));

    vec2 inner = at - cell;
    vec4 sides = vec4(inner.x, 1.0 - inner.x, inner.y, 1.0 - inner.y) / pixel.xxyy;
    float locked = step(16.0, ofCell.y) * outlines, outlined = locked * (1.0 - coarse);
    tone = mix(tone, vec3(0.95, 0.16, 0.22), 0.6 * outlined * room * stroke(toSides(sides, 15.0), 0.8));
    tone = mix(tone, vec3(0.95, 0.16, 0.22), outlined * stroke(toSides(sides, ofCell.y - 16.0), 2.0));
    float hatch = abs(fract((gl_FragCoord.x + gl_FragCoord.y) / 9.0) - 0.5) * 9.0; // for cells too small to outline
    tone = mix(tone, vec3(0.95, 0.16, 0.22), 0.7 * locked * max(1.0 - room, coarse) * stroke(hatch, 0.7));

    float rim = toSides(sides, 15.0);
    float isHovered = step(distance(cell, hovered), 0.5), isPinned = step(distance(cell, pinned), 0.5);
    isHovered *= 1.0 - coarse;
    isPinned *= 1.0 - coarse;
    tone = mix(tone, vec3(1.0), 0.35 * isHovered);
    tone = mix(tone, vec3(0.0), max(isHovered, isPinned) * stroke(rim, 3.5));
    tone = mix(tone, vec3(1.0), max(isHovered, isPinned) * stroke(rim, 2.0));
    colour = vec4(tone, 1.0);
  }`;

const pickShader = /* glsl */ `
  flat in int vertex;
  layout(location = 0) out vec4 colour;
  uniform float unrolled;
  ${section.declareCut}
  void main() {
    if (unrolled < 0.5) ${section.cut}
    int id = vertex + 1;
    colour = vec4(id & 255, (id >> 8) & 255, (id >> 16) & 255, (id >> 24) & 255) / 255.0;
  }`;

/** How many warp steps a fibre has slid along the one before, at each node, where weft gives way by
 *  `slide` (0: not at all, null): of its way along warp, p sin γ with p = (cos γ)^-slide, that share. */
export function slipsOf({ columns, cellOfNode }, slide, [warp, weft]) {
  if (!slide) return null;
  const ofCells = columns['cells.shear_deg'];
  const ofNodes =
    columns['nodes.shear_deg'] ?? Float32Array.from(cellOfNode, (k) => ofCells[k] ?? 0);
  return Float32Array.from(ofNodes, (degrees) => {
    const shear = (degrees * Math.PI) / 180;
    const length = Math.max(Math.cos(shear), LEAST_COSINE) ** -slide;
    return (slide * length * Math.sin(shear) * weft) / warp;
  });
}

function makeGeometry(lattice, slips) {
  const geometry = new THREE.BufferGeometry();
  geometry.setIndex(new THREE.BufferAttribute(lattice.index, 1));
  geometry.setAttribute('position', new THREE.BufferAttribute(lattice.position, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(lattice.normal, 3));
  geometry.setAttribute('place', new THREE.BufferAttribute(lattice.places, 2));
  if (slips) geometry.setAttribute('slip', new THREE.BufferAttribute(slips, 1));
  const field = new Float32Array(lattice.places.length);
  for (let node = 0; node < lattice.sides.length; node++) field[2 * node + 1] = lattice.sides[node];
  geometry.setAttribute('field', new THREE.BufferAttribute(field, 2));
  geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(), lattice.radius);
  return geometry;
}

export class Net {
  /** Without a lattice as yet: that comes with `fill`, any number of times. The shaders stay, because
   *  to make them again takes longer than to drape. */
  constructor() {
    this.uniforms = {
      map: { value: textures.sequential },
      low: { value: 0 },
      high: { value: 1 },
      smoothly: { value: 0 },
      yarns: { value: 1 },
      outlines: { value: 1 },
      hovered: { value: new THREE.Vector2(NOWHERE, NOWHERE) },
      pinned: { value: new THREE.Vector2(NOWHERE, NOWHERE) },
      spacing: { value: new THREE.Vector2(1, 1) },
      plane: section.plane,
      coarse: { value: 0 },
    };
    this.solid = this.#mesh(0);
    this.flat = this.#mesh(1);
  }

  /** Shows this lattice from now on, with no cell marked; `slide` of its weft along the fibres. */
  fill(lattice, spacing, slide = 0) {
    this.empty();
    this.lattice = lattice;
    this.geometry = makeGeometry(lattice, slipsOf(lattice, slide, spacing));
    this.fewer = lattice.coarse ? withIndex(this.geometry, lattice.coarse) : this.geometry;
    this.coarsen(false);
    this.uniforms.spacing.value.set(...spacing);
    for (const which of ['hovered', 'pinned']) this.mark(which, null);
  }

  /** The net on its surface (0) or laid flat (1), with a twin that is drawn to find cells. */
  #mesh(unrolled) {
    const uniforms = { ...this.uniforms, unrolled: { value: unrolled } };
    const shared = { glslVersion: THREE.GLSL3, vertexShader, uniforms, side: THREE.DoubleSide };
    const material = new THREE.ShaderMaterial({ ...shared, fragmentShader });
    const picking = new THREE.ShaderMaterial({
      ...shared,
      fragmentShader: pickShader,
      blending: THREE.NoBlending,
    });
    const mesh = new THREE.Mesh(undefined, material);
    mesh.frustumCulled = false;
    mesh.userData.picking = picking;
    return mesh;
  }

  /** Colours by values of cells or of nodes. */
  setField(values, ofNodes, [low, high], map) {
    const attribute = this.geometry.attributes.field;
    const { cellOfNode } = this.lattice;
    for (let node = 0; node < cellOfNode.length; node++) {
      const row = ofNodes ? node : cellOfNode[node];
      attribute.array[2 * node] = row < 0 ? 0 : values[row];
    }
    attribute.needsUpdate = true;
    const half = low === high ? Math.abs(low) || 1 : 0; // one value has the middle colour
    this.uniforms.low.value = low - half;
    this.uniforms.high.value = high + half;
    this.uniforms.smoothly.value = ofNodes ? 1 : 0;
    this.uniforms.map.value = textures[map];
  }

  /** Draws the net with fewer triangles, or all of them. */
  coarsen(on) {
    this.uniforms.coarse.value = on && this.fewer !== this.geometry ? 1 : 0;
    for (const mesh of [this.solid, this.flat]) mesh.geometry = on ? this.fewer : this.geometry;
  }

  /** Shows or hides yarns and the outlines of locked cells. */
  show({ yarns, locked }) {
    this.uniforms.yarns.value = yarns ? 1 : 0;
    this.uniforms.outlines.value = locked ? 1 : 0;
  }

  /** The cell that a pane shows at a place of the window; -1 beside the net. */
  cellAt(stage, pane, { clientX, clientY }) {
    const owner = stage.pick(pane, pane.flat ? this.flat : this.solid, clientX, clientY);
    return owner < 0 ? -1 : (this.lattice.cellOfNode[owner] ?? -1);
  }

  /** Marks the cell under the pointer, or the one that was chosen; null for none. */
  mark(which, cell) {
    const { columns } = this.lattice;
    const place =
      cell === null ? [NOWHERE, NOWHERE] : [columns['cells.i'][cell], columns['cells.j'][cell]];
    this.uniforms[which].value.set(...place);
  }

  /** Gives the memory on the graphics card back. */
  empty() {
    for (const geometry of [this.geometry, this.fewer]) geometry?.dispose();
    this.geometry = this.fewer = null;
    for (const mesh of [this.solid, this.flat]) mesh.removeFromParent();
  }
}
