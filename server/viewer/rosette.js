// SPDX-License-Identifier: MIT
// The rosette over the picture: an arm from the start along 0 degrees, whose knob turns it, and an
// arrow to the side on which plies lie; and, if asked for, the cloth moved there, to see which that is.
import * as THREE from './three.module.min.js';
import { element } from './dom.js';
import { makeNormals, nodeAt } from './lattice.js';
import { disposeTree } from './marks.js';

const ARM = 90; // pixels, where the eye looks
const ARROW = 60;
const STEP_DEG = { coarse: 5, fine: 1 }; // of a key
const HEIGHT = 0.03; // of the preview over the part, as a share of its radius
const DIGITS = 6;

const add = (a, b, factor = 1) => a.map((value, k) => value + factor * b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const unit = (a) => a.map((value) => value / (Math.hypot(...a) || 1));
const rounded = (a) => a.map((value) => Number(value.toPrecision(DIGITS)) + 0);

/** A direction of the plane across `normal`, turned about it. */
export function turned(direction, normal, degrees) {
  const angle = (degrees * Math.PI) / 180;
  const along = direction.map((value) => value * Math.cos(angle));
  return add(along, cross(normal, direction), Math.sin(angle));
}

export class Rosette {
  /** `onTurn(settled)` when the form has another rosette. */
  constructor(view, form, { onTurn }) {
    Object.assign(this, { view, form, onTurn, at: null, preview: false });
    const knob = element('rosette-knob');
    knob.addEventListener('pointerdown', (event) => {
      event.stopPropagation();
      knob.setPointerCapture(event.pointerId);
      this.dragging = true;
    });
    knob.addEventListener('pointermove', (event) => this.dragging && this.#drag(event, false));
    knob.addEventListener('pointerup', (event) => {
      event.stopPropagation();
      if (this.dragging) this.#drag(event, true);
      this.dragging = false;
    });
    knob.addEventListener('keydown', (event) => {
      const sense = { ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1 }[event.key];
      if (!sense) return;
      event.preventDefault();
      event.stopPropagation();
      const step = event.shiftKey ? STEP_DEG.fine : STEP_DEG.coarse;
      this.#turn(turned(this.at.zero, this.at.normal, sense * step), true);
    });
    element('stack-other').addEventListener('change', () => this.#show());
    element('stack-preview').addEventListener('click', () => {
      this.preview = !this.preview;
      element('stack-preview').setAttribute('aria-pressed', String(this.preview));
      this.#show();
    });
  }

  /** The drape that is shown, with `start_axes` in its summary; null: none. */
  set(drape) {
    const { zero, side } = drape?.summary?.start_axes || {};
    const node = zero ? nodeAt(drape.lattice.grid, 0, 0) : -1;
    const { lattice } = drape || {};
    this.at = null;
    if (node >= 0 && Math.hypot(...zero) > 0) {
      const place = [0, 1, 2].map((k) => lattice.position[3 * node + k] + lattice.origin[k]);
      this.at = { lattice, node, place, zero, side, normal: side };
    }
    this.#show();
  }

  get #sense() {
    return element('stack-other').checked ? -1 : 1;
  }

  #pixels(place) {
    const { view } = this;
    return view.panes.solid.project(place.map((value, axis) => value - view.origin[axis]));
  }

  /** At every picture: the arm and the arrow where they are now. */
  draw() {
    const { view, at } = this;
    const shown = Boolean(
      at && view.shown.rosette && view.stage && !view.patches && view.slots.one,
    );
    for (const name of ['lines', 'knob'])
      element(`rosette-${name}`).toggleAttribute('hidden', !shown);
    if (!shown) return;
    const length = ARM / view.pixelsOfUnit;
    const ends = {
      arm: add(at.place, at.zero, length),
      side: add(at.place, at.side, (this.#sense * length * ARROW) / ARM),
    };
    const from = this.#pixels(at.place);
    for (const [name, end] of Object.entries(ends)) {
      const to = this.#pixels(end);
      const line = element(`rosette-${name}`);
      const ends = { x1: from.x, y1: from.y, x2: to.x, y2: to.y };
      for (const [key, value] of Object.entries(ends)) line.setAttribute(key, value.toFixed(1));
    }
    const { x, y } = this.#pixels(ends.arm);
    element('rosette-knob').style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
  }

  /** Turns 0 degrees to where the pointer is on the tangent plane of the start. */
  #drag({ clientX, clientY }, settled) {
    const { place, normal } = this.at;
    const { ray } = this.view.panes.solid.ray(clientX, clientY);
    const eye = add(ray.origin.toArray(), this.view.origin);
    const way = ray.direction.toArray();
    const share = dot(add(place, eye, -1), normal) / dot(way, normal);
    const towards = add(add(eye, way, share), place, -1);
    const across = add(towards, normal, -dot(towards, normal));
    if (share > 0 && Math.hypot(...across) > 0) this.#turn(unit(across), settled);
    else if (settled) this.onTurn(true);
  }

  #turn(zero, settled) {
    this.at.zero = zero;
    const kept = this.form.rosette;
    this.form.rosette = {
      ...kept,
      origin: kept?.origin ?? rounded(this.at.place),
      x: rounded(zero),
    };
    this.view.stage.redraw();
    this.onTurn(settled);
  }

  /** The cloth moved to the side of the plies, or no longer. */
  #show() {
    const { view, at } = this;
    if (!view.stage) return;
    if (this.ghost) {
      this.ghost.removeFromParent();
      disposeTree(this.ghost);
      this.ghost = null;
    }
    if (this.preview && at && view.slots.one) {
      const { position, index } = at.lattice;
      const normals = makeNormals(position, index);
      const own = normals.subarray(3 * at.node, 3 * at.node + 3);
      const sense = this.#sense * (dot(own, at.side) < 0 ? -1 : 1);
      const height = sense * HEIGHT * (view.shape?.radius ?? 1);
      const geometry = new THREE.BufferGeometry();
      for (let k = 0; k < normals.length; k += 3)
        normals.set(unit([...normals.subarray(k, k + 3)]), k);
      const moved = position.map((value, k) => value + height * normals[k]);
      geometry.setAttribute('position', new THREE.BufferAttribute(moved, 3));
      geometry.setIndex(new THREE.BufferAttribute(index, 1));
      const style = { color: 0x1c7ed6, transparent: true, opacity: 0.35, side: THREE.DoubleSide };
      this.ghost = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial(style));
      this.ghost.name = 'side';
      this.ghost.position.set(...view.slots.one.shift);
      view.panes.solid.scene.add(this.ghost);
    }
    view.stage.redraw();
  }
}
