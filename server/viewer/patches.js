// SPDX-License-Identifier: MIT
// Patches on the graphics card: the faces of a part, or the elements of a mesh with a field. One
// mesh, one shader; some patches are chosen, one is under the pointer.
import * as THREE from './three.module.min.js';
import * as section from './section.js';
import { textures } from './textures.js';
import { withIndex } from './scene.js';

const NOWHERE = -1;
const CHOSEN = 1; // added to a chosen patch's state
const LINES = 5000; // that are drawn while something moves, on a slow graphics card

const vertexShader = /* glsl */ `
  in float patchId;
  in vec2 field; // value, state
  flat out int id;
  flat out vec2 of;
  out vec3 seen;
  out vec3 seenNormal;
  ${section.declare}
  void main() {
    ${section.place}
    vec4 view = modelViewMatrix * vec4(position, 1.0);
    id = int(patchId);
    of = field;
    seen = view.xyz;
    seenNormal = normalMatrix * normal;
    gl_Position = projectionMatrix * view;
  }`;

const fragmentShader = /* glsl */ `
  uniform sampler2D map;
  uniform float low, high, plain;
  uniform vec3 ground, accent;
  uniform int hovered;
  flat in int id;
  flat in vec2 of;
  in vec3 seen;
  in vec3 seenNormal;
  ${section.declareCut}
  layout(location = 0) out vec4 colour;
  void main() {
    ${section.cut}
    float part = clamp((of.x - low) / (high - low), 0.0, 1.0);
    vec3 tone = mix(texture(map, vec2((part * 255.0 + 0.5) / 256.0, 0.5)).rgb, ground, plain);
    if (of.x > 1e29) tone = vec3(0.5);
    float stripe = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / 8.0));
    tone = mix(tone, accent, of.y * mix(stripe, 0.7, plain));
    float facing = abs(dot(normalize(seenNormal), normalize(seen)));
    tone *= 0.6 + 0.4 * facing;
    if (id == hovered) tone = mix(tone, vec3(1.0), 0.35);
    colour = vec4(tone, 1.0);
  }`;

const pickShader = /* glsl */ `
  flat in int id;
  ${section.declareCut}
  layout(location = 0) out vec4 colour;
  void main() {
    ${section.cut}
    int code = id + 1;
    colour = vec4(code & 255, (code >> 8) & 255, (code >> 16) & 255, (code >> 24) & 255) / 255.0;
  }`;

const attribute = (values, width) => new THREE.BufferAttribute(values, width);

export class Patches {
  /** `body` as `facets.js` makes it; `ground`, `accent`, `line`: colours as [r, g, b] of 0 to 1. */
  constructor(body, { ground, accent, line }) {
    this.body = body;
    this.chosen = new Set();
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', attribute(body.position, 3));
    geometry.setAttribute('normal', attribute(body.normal, 3));
    geometry.setAttribute('patchId', attribute(body.patch, 1));
    this.field = attribute(new Float32Array(2 * body.patch.length), 2);
    geometry.setAttribute('field', this.field);
    this.uniforms = {
      map: { value: textures.sequential },
      low: { value: 0 },
      high: { value: 1 },
      plain: { value: 1 },
      ground: { value: new THREE.Vector3(...ground) },
      accent: { value: new THREE.Vector3(...accent) },
      hovered: { value: NOWHERE },
      plane: section.plane,
    };
    const shared = {
      glslVersion: THREE.GLSL3,
      vertexShader,
      uniforms: this.uniforms,
      side: THREE.DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    };
    this.geometry = geometry;
    this.fewer = body.fewer ? withIndex(geometry, body.fewer) : geometry;
    this.mesh = new THREE.Mesh(geometry, new THREE.ShaderMaterial({ ...shared, fragmentShader }));
    this.mesh.frustumCulled = false;
    this.mesh.userData.picking = new THREE.ShaderMaterial({
      ...shared,
      fragmentShader: pickShader,
      blending: THREE.NoBlending,
    });
    this.lines = this.#makeLines(body, line);
    this.group = new THREE.Group().add(this.mesh, this.lines);
  }

  #makeLines(body, line) {
    const edges = new THREE.BufferGeometry();
    edges.setAttribute('position', attribute(body.edges, 3));
    const colour = new THREE.Color().setRGB(...line, THREE.SRGBColorSpace);
    return new THREE.LineSegments(edges, new THREE.LineBasicMaterial({ color: colour }));
  }

  /** Draws the patches with fewer triangles and lines, or all of them. */
  coarsen(on) {
    this.mesh.geometry = on ? this.fewer : this.geometry;
    this.lines.visible = !on || this.body.edgePatch.length <= 2 * LINES;
  }

  /** Colours by a value of each patch; null: they have no colours of their own. */
  setValues(values, [low, high], map) {
    this.uniforms.plain.value = values ? 0 : 1;
    if (!values) return;
    const half = low === high ? Math.abs(low) || 1 : 0;
    Object.assign(this.uniforms.low, { value: low - half });
    Object.assign(this.uniforms.high, { value: high + half });
    this.uniforms.map.value = textures[map];
    const { patch } = this.body;
    for (let k = 0; k < patch.length; k++) this.field.array[2 * k] = values[patch[k]];
    this.field.needsUpdate = true;
  }

  /** Marks the patches of a set. */
  choose(chosen) {
    this.chosen = chosen;
    const { patch } = this.body;
    for (let k = 0; k < patch.length; k++)
      this.field.array[2 * k + 1] = chosen.has(patch[k]) ? CHOSEN : 0;
    this.field.needsUpdate = true;
  }

  /** The patch that a pane shows at a place of the window; -1 beside all. */
  patchAt(stage, pane, { clientX, clientY }) {
    return stage.pick(pane, this.mesh, clientX, clientY, this.group);
  }

  hover(patch) {
    const changed = this.uniforms.hovered.value !== patch;
    this.uniforms.hovered.value = patch;
    return changed;
  }

  dispose() {
    this.group.removeFromParent();
    for (const { geometry, material } of [this.mesh, this.lines]) {
      geometry.dispose();
      material.dispose();
    }
    for (const disposable of [this.geometry, this.fewer, this.mesh.userData.picking])
      disposable.dispose();
  }
}
