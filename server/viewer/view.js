// SPDX-License-Identifier: MIT
// The pictures: which net, marks and surface are in which pane, and what the pointer does there.
// Without WebGL there are no pictures, and all else works.
import { element } from './dom.js';
import { Net } from './net.js';
import { Patches } from './patches.js';
import {
  disposeTree,
  fillFrontKey,
  frontOf,
  makeCrosses,
  makeDots,
  makeFront,
  makeRim,
  makeSurface,
  sinkSurface,
} from './marks.js';
import { followPointer } from './pointer.js';
import { Stage } from './scene.js';
import { cornersOf } from './readout.js';
import { setSection } from './section.js';

const NO_WEBGL =
  'This browser has no WebGL 2, which the pictures need. Turn on hardware acceleration in its ' +
  'settings, or use another browser. Draping, numbers, charts and downloads work here all the same.';

const styleOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);

/** The same as three numbers of 0 to 1. */
const tintOf = (name) =>
  themed(name)
    .match(/[\d.]+/g)
    .slice(0, 3)
    .map((part) => Number(part) / 255);

/** The colour of a custom property as rgb(), whatever the theme. */
function themed(name) {
  const probe = element('canvas');
  probe.style.color = styleOf(name);
  return getComputedStyle(probe).color;
}

/** What patches do where nobody says. */
const NO_HANDLERS = { onTwice: () => {}, sweeps: () => false, over: false };

export class View {
  /** `onHover(hit)`, `onPick(hit)` with {slot, cell, node} or null, `onStart(place, settled)`,
   *  `onEye()` when the camera has moved, `onFrame()` when a picture was drawn. */
  constructor(handlers) {
    Object.assign(this, handlers);
    this.slots = {};
    this.nets = {};
    this.shown = {
      yarns: true,
      locked: true,
      front: false,
      crosses: false,
      surface: true,
      rosette: true,
    };
    this.placing = false;
    try {
      this.stage = new Stage(element('canvas'));
    } catch {
      this.stage = null;
      element('hint').textContent = NO_WEBGL;
      return;
    }
    this.#addPanes();
    element('canvas').addEventListener('webglcontextlost', () => {
      element('hint').textContent =
        'The graphics card stopped drawing this picture. Load the page again.';
    });
  }

  #addPanes() {
    const { stage } = this;
    const solid = stage.addPane(element('pane-solid'));
    const other = stage.addPane(element('pane-other'), { twin: solid });
    const difference = stage.addPane(element('pane-difference'), { twin: solid });
    const flat = stage.addPane(element('pane-flat'), { flat: true });
    this.panes = { solid, other, difference, flat };
    stage.onView = () => {
      this.moved = true;
      this.onEye();
    };
    stage.onCoarse = (on) => {
      for (const { net } of Object.values(this.slots)) net.coarsen(on);
      this.patches?.coarsen(on);
    };
    stage.onFrame = () => {
      this.#moveHandle();
      this.onFrame();
    };
    for (const [name, slot] of [
      ['solid', 'one'],
      ['flat', 'one'],
      ['other', 'two'],
      ['difference', 'difference'],
    ])
      this.#listen(this.panes[name], slot);
    this.#listenHandle();
  }

  /* ---- what is shown ---- */

  /** The surface under the nets; the camera goes to where all of it is seen, if it `frames`. */
  setShape(shape, frames = true) {
    this.shape = shape;
    if (!this.stage) return;
    this.origin = shape ? shape.origin : [0, 0, 0];
    this.#drawSurface();
    if (shape?.index.length && !this.patches) this.#frame(shape, frames);
    this.show(this.shown);
  }

  /** Home is where all of a body is seen; the camera goes there, if it is to. */
  #frame(body, goes) {
    for (const name of ['other', 'difference', 'solid']) this.panes[name].frame(body);
    if (goes) this.home();
  }

  #drawSurface() {
    for (const name of ['solid', 'other', 'difference']) {
      const { scene } = this.panes[name];
      const old = scene.getObjectByName('surface');
      if (old) scene.remove(old);
      disposeTree(old);
      if (!this.shape) continue;
      const tones = [themed('--surface'), themed('--edge')];
      const surface = makeSurface(this.shape, this.#depth(), ...tones);
      surface.name = 'surface';
      surface.visible = this.shown.surface;
      scene.add(surface);
    }
  }

  /** How far the surface lies behind the net, which is made of chords. */
  #depth() {
    const step = Math.max(...(this.slots.one?.spacing || [0]));
    return 0.3 * step + 0.004 * this.shape.radius;
  }

  #sinkSurface() {
    for (const name of ['solid', 'other', 'difference']) {
      const surface = this.panes[name].scene.getObjectByName('surface');
      if (surface) sinkSurface(surface, this.#depth());
    }
  }

  /** Shows the patches of a body in 3D, in place of the net and, unless they lie `over` that, of the
   *  surface; null: these again, seen from
   *  home unless somebody has turned the picture. Its `onPick` and `onHover` get a patch, -1 for none,
   *  `onTwice` that of a double click; `onGone()` when others take their place; `frames`: the camera
   *  goes to where all is seen. While `sweeps()`, dragging picks instead of turning. */
  setPatches(body, { frames = false, ...handlers } = {}) {
    if (!this.stage) return;
    const before = this.patches;
    this.patches = null;
    before?.dispose();
    disposeTree(this.dots);
    before?.onGone();
    element('chip').hidden = true;
    this.panes.solid.controls.enabled = true;
    if (body) {
      const tints = {
        ground: tintOf('--surface'),
        accent: tintOf('--chosen'),
        line: tintOf('--edge'),
      };
      this.patches = Object.assign(new Patches(body, tints), NO_HANDLERS, handlers);
      if (frames) {
        this.origin = body.origin;
        this.#frame(body, true);
      }
      const { group } = this.patches;
      group.position.set(...body.origin.map((value, axis) => value - this.origin[axis]));
      this.panes.solid.scene.add(group);
    } else if (before && this.shape?.index.length) {
      this.#frame(this.shape, !this.moved);
    }
    this.show(this.shown);
  }

  /** Dots on the patches: [{place, chosen}]. */
  setDots(dots) {
    if (!this.patches) return;
    const { group, body } = this.patches;
    if (this.dots) group.remove(this.dots);
    disposeTree(this.dots);
    const tints = ['--panel', '--chosen'].map(tintOf);
    this.dots = makeDots(dots, body.origin, 0.01 * this.shape.radius, tints);
    group.add(this.dots);
    this.stage.redraw();
  }

  #patchAt(event) {
    return this.patches.patchAt(this.stage, this.panes.solid, event);
  }

  /** After a change of light and dark. */
  retint() {
    if (!this.stage) return;
    this.#drawSurface();
    this.stage.redraw();
  }

  /** Puts a net into a slot: 'one', 'two' or 'difference'; null empties it. */
  setNet(slot, drape) {
    if (!this.stage) return;
    this.#empty(slot);
    if (!drape) return;
    const { lattice, spacing, slide } = drape;
    const net = (this.nets[slot] ||= new Net());
    net.fill(lattice, spacing, slide);
    const pane = this.panes[{ one: 'solid', two: 'other', difference: 'difference' }[slot]];
    const entry = { net, lattice, spacing, pane, front: frontOf(lattice), marks: {} };
    this.slots[slot] = entry;
    if (!this.shape && slot === 'one') {
      this.origin = lattice.origin;
      this.#frame(lattice, true);
    }
    entry.shift = lattice.origin.map((value, axis) => value - this.origin[axis]);
    this.#add(entry, net.solid);
    if (slot === 'one') this.panes.flat.scene.add(net.flat);
    if (slot !== 'difference') this.#setFlat(entry, slot);
    this.#sinkSurface();
    this.show(this.shown);
  }

  #add({ pane, shift }, object) {
    object.position.set(...shift);
    pane.scene.add(object);
  }

  /** Shows or hides what is drawn over a net; made when it is first wanted. */
  #showMark(entry, name, on, make) {
    const { marks } = entry;
    if (on && marks[name] === undefined) {
      marks[name] = make(entry);
      if (marks[name]) this.#add(entry, marks[name]);
    }
    if (marks[name]) marks[name].visible = on;
  }

  /** The rim of the flat pattern, over that of another drape; all of both is to be seen. */
  #setFlat(entry, slot) {
    const { flat } = this.panes;
    entry.rim = makeRim(
      entry.lattice,
      entry.spacing,
      tintOf(slot === 'one' ? '--text' : '--chosen'),
      tintOf('--bad'),
    );
    if (entry.rim) flat.scene.add(entry.rim);
    const boxes = ['one', 'two']
      .filter((name) => this.slots[name])
      .map((name) => {
        const { lattice, spacing } = this.slots[name];
        const { imin, imax, jmin, jmax } = lattice.grid;
        return [imin * spacing[0], jmin * spacing[1], -imax * spacing[0], -jmax * spacing[1]];
      });
    const [left, low, right, high] = [0, 1, 2, 3].map((k) =>
      Math.min(...boxes.map((box) => box[k])),
    );
    const half = [(-right - left) / 2 || 1, (-high - low) / 2 || 1];
    if (flat.half.join() !== half.join())
      flat.frameFlat(half, [(left - right) / 2, (low - high) / 2]);
  }

  #empty(slot) {
    const entry = this.slots[slot];
    if (!entry) return;
    for (const mark of Object.values(entry.marks)) {
      mark?.removeFromParent();
      disposeTree(mark);
    }
    entry.rim?.removeFromParent();
    disposeTree(entry.rim);
    entry.net.empty();
    delete this.slots[slot];
    this.stage.redraw();
  }

  setField(slot, values, ofNodes, range, map) {
    this.slots[slot]?.net.setField(values, ofNodes, range, map);
    this.stage?.redraw();
  }

  /** Shows and hides {yarns, locked, front, crosses, surface, rosette}. */
  show(shown) {
    this.shown = shown;
    if (!this.stage) return;
    for (const [slot, entry] of Object.entries(this.slots)) {
      entry.net.show(shown);
      const { lattice, front, spacing } = entry;
      this.#showMark(entry, 'front', shown.front, () => makeFront(lattice, front, spacing));
      if (slot !== 'difference')
        this.#showMark(entry, 'crosses', shown.crosses, () => makeCrosses(lattice, spacing));
    }
    if (shown.front) fillFrontKey(element('front-key'), this.slots.one?.front || new Map());
    element('front-key').hidden = !shown.front || !this.slots.one;
    for (const name of ['solid', 'other', 'difference']) {
      const surface = this.panes[name].scene.getObjectByName('surface');
      const hidden = name === 'solid' && this.patches && !this.patches.over;
      if (surface) surface.visible = shown.surface && !hidden;
    }
    this.#cover();
    this.stage.redraw();
  }

  /** Patches are shown in place of the net and of what lies over it. */
  #cover() {
    const { net, marks } = this.slots.one || {};
    if (!net) return;
    net.solid.visible = !this.patches;
    for (const mark of Object.values(marks)) if (mark && this.patches) mark.visible = false;
  }

  /** 'solid', 'both', 'flat' or 'compare'. */
  arrange(name) {
    element('panes').dataset.view = name;
    for (const id of ['pane-other', 'pane-difference']) element(id).hidden = name !== 'compare';
    if (!this.stage) return;
    if (!this.moved) this.home();
    this.stage.redraw();
  }

  /** Another net will follow soon: the picture of this one may be coarse. */
  passing() {
    this.stage?.move();
  }

  /** Marks a cell of the main net as 'hovered' or 'pinned', and the cell of the same i and j in
   *  the others. */
  mark(which, place, cellAt) {
    for (const { net, lattice } of Object.values(this.slots)) {
      const cell = place ? cellAt(lattice, ...place) : -1;
      net.mark(which, cell >= 0 ? cell : null);
    }
    this.stage?.redraw();
  }

  /** Cuts the pictures in 3D at `share` of the part along an axis; '' shows all. */
  cut(axis, share) {
    if (!this.stage || !this.shape) return;
    setSection(axis, share, this.shape.size);
    this.stage.redraw();
  }

  /** The pixels of a unit of length in the picture, and of a node of the main net. */
  get pixelsOfUnit() {
    return this.stage ? this.panes.solid.pixelsOfUnit : NaN;
  }

  pixelsOf(node) {
    return this.panes.solid.project(this.#placeOf(this.slots.one, node, false));
  }

  home() {
    if (!this.stage) return;
    this.moved = false;
    this.panes.flat.home();
    this.panes.solid.home();
  }

  get eye() {
    return this.moved ? this.panes.solid.view.join(',') : '';
  }

  set eye(text) {
    const numbers = text.split(',').map(Number);
    if (this.stage && numbers.length === 6 && numbers.every(Number.isFinite)) {
      this.moved = true;
      this.panes.solid.view = numbers;
    }
  }

  /* ---- the pointer ---- */

  #listen(pane, slot) {
    const patched = () => pane === this.panes.solid && this.patches;
    followPointer(this.stage, pane, {
      onHover: (event) => {
        if (patched()) this.patches.onHover(event ? this.#patchAt(event) : -1);
        else this.onHover(event && this.hit(pane, slot, event));
      },
      onLooking: (on) => element('panes').toggleAttribute('data-looking', on),
      sweeps: () => Boolean(patched() && this.patches.sweeps()),
      onSweep: (event) => this.patches.onPick(this.#patchAt(event), true),
      onClick: (event) => this.#click(pane, slot, event),
      onTwice: (event) => {
        if (this.drawing) this.drawing.onEnd();
        else if (patched()) this.patches.onTwice(this.#patchAt(event));
        else if (pane === this.panes.solid) this.#place(event, true);
      },
    });
  }

  #click(pane, slot, event) {
    const solid = pane === this.panes.solid;
    if (this.drawing) solid && this.#draw(event);
    else if (solid && this.patches) this.patches.onPick(this.#patchAt(event), false);
    else if (solid && (this.placing || !this.slots.one)) this.#place(event, true);
    else this.onPick(this.hit(pane, slot, event));
  }

  /** The cell and its nearest node at a place of the window, or null. */
  hit(pane, slot, event) {
    const entry = this.slots[slot];
    if (!entry || !pane.visible) return null;
    const { clientX, clientY } = event;
    const cell = entry.net.cellAt(this.stage, pane, event);
    if (cell < 0) return null;
    const box = pane.element.getBoundingClientRect();
    const away = (node) => {
      const { x, y } = pane.project(this.#placeOf(entry, node, pane.flat));
      return Math.hypot(x + box.left - clientX, y + box.top - clientY);
    };
    const node = cornersOf(entry.lattice, cell).reduce((best, other) =>
      away(other) < away(best) ? other : best,
    );
    return { slot, cell, node };
  }

  #placeOf({ lattice, spacing, shift }, node, flat) {
    if (flat)
      return [lattice.places[2 * node] * spacing[0], lattice.places[2 * node + 1] * spacing[1], 0];
    return [0, 1, 2].map((axis) => lattice.position[3 * node + axis] + shift[axis]);
  }

  /* ---- places of the surface ---- */

  get #body() {
    return this.panes.solid.scene.getObjectByName('surface')?.userData.body;
  }

  /** What the pointer is on: {point of the picture, place in space, uv}; undefined beside the surface. */
  #surfaceAt({ clientX, clientY }) {
    const [found] = this.panes.solid.ray(clientX, clientY).intersectObject(this.#body);
    const point = found?.point.toArray();
    return found && { point, place: point.map((x, axis) => x + this.origin[axis]), uv: found.uv };
  }

  /** The place in space that the pointer is on; null beside the part. */
  placeAt(event) {
    return (this.#body && this.#surfaceAt(event)?.place) ?? null;
  }

  /** Clicks in 3D are points of a line, and a double click ends it: {onPoint(place,
   *  event), onEnd()}, null for a click beside the part; without them no longer. */
  setDrawing(drawing) {
    this.drawing = drawing;
    element('pane-solid').classList.toggle('placing', Boolean(drawing));
  }

  #draw(event) {
    this.drawing.onPoint(this.placeAt(event), event);
  }

  /** The pixels of a place in space. */
  pixelsOfPlace(place) {
    return this.panes.solid.project(place.map((x, axis) => x - this.origin[axis]));
  }

  /** Turns the picture to a cell of the main net, seen from the side that nothing hides. */
  lookAt(cell) {
    const entry = this.slots.one;
    if (!this.stage || !entry) return;
    const corners = cornersOf(entry.lattice, cell).map((node) => this.#placeOf(entry, node, false));
    this.panes.solid.lookAt(corners, this.#body);
    this.moved = true;
    this.onEye();
  }

  /* ---- the start ---- */

  /** Moves the start to what the pointer is on. */
  #place(event, settled) {
    if (!this.#body) return;
    const found = this.#surfaceAt(event);
    if (found) {
      this.handlePoint = found.point;
      const point = found.place;
      this.onStart(found.uv ? found.uv.toArray() : point, settled);
    } else if (settled) {
      this.onStart(null, true);
    }
    this.stage.redraw();
  }

  setPlacing(placing) {
    this.placing = placing;
    element('pane-solid').classList.toggle('placing', placing);
  }

  /** Puts the handle at the net's start. */
  setHandle(node) {
    if (!this.stage) return;
    const entry = this.slots.one;
    if (!this.dragging)
      this.handlePoint = entry && node >= 0 ? this.#placeOf(entry, node, false) : null;
    this.stage.redraw();
  }

  #moveHandle() {
    const handle = element('handle');
    handle.hidden = !this.handlePoint || Boolean(this.patches);
    if (handle.hidden) return;
    const { x, y } = this.panes.solid.project(this.handlePoint);
    handle.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
  }

  #listenHandle() {
    const handle = element('handle');
    handle.addEventListener('pointerdown', (event) => {
      event.stopPropagation();
      handle.setPointerCapture(event.pointerId);
      this.dragging = true;
    });
    handle.addEventListener('pointermove', (event) => {
      if (this.dragging) this.#place(event, false);
    });
    handle.addEventListener('pointerup', (event) => {
      event.stopPropagation();
      if (this.dragging) this.#place(event, true);
      this.dragging = false;
    });
    handle.addEventListener('keydown', (event) => {
      const moves = { ArrowLeft: [-8, 0], ArrowRight: [8, 0], ArrowUp: [0, -8], ArrowDown: [0, 8] };
      if (!moves[event.key] || !event.shiftKey) return;
      event.preventDefault();
      event.stopPropagation();
      const box = handle.getBoundingClientRect();
      const [x, y] = moves[event.key];
      this.#place(
        { clientX: box.x + box.width / 2 + x, clientY: box.y + box.height / 2 + y },
        true,
      );
    });
  }
}
