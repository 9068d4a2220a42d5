// SPDX-License-Identifier: MIT
// Choosing the faces of a part: by clicks and sweeps in the picture, by a list for the keyboard, and
// all that is smooth from one, by a button or a double click; choices can be taken back.
import { element } from './dom.js';
import { format } from './fields.js';
import { numberOf } from './form.js';
import { grow, holdsBody } from './part.js';

const SWEEP_MS = 500; // between two faces of one sweep, at the most
const STEPS = 100; // that can be taken back

export class Chooser {
  /** `onChange(part, chosen)` after each choice that is complete. */
  constructor(view, { onChange }) {
    Object.assign(this, { view, onChange });
    this.part = null;
    this.chosen = new Set();
    this.last = -1; // the face that was clicked
    this.before = []; // the choices before this one
    this.sweptAt = 0;
    element('faces-open').addEventListener('click', () => this.show(!this.on));
    element('faces-all').addEventListener('click', () => this.#take(this.#all()));
    element('faces-none').addEventListener('click', () => this.#take(new Set()));
    element('faces-smooth').addEventListener('click', () => this.#takeSmooth());
    element('faces-undo').addEventListener('click', () => this.#undo());
    const list = element('faces-list');
    list.addEventListener('change', ({ target }) =>
      this.#pick(Number(target.value), target.checked),
    );
    list.addEventListener('pointerover', ({ target }) => this.#point(target));
    list.addEventListener('focusin', ({ target }) => this.#point(target));
    list.addEventListener('pointerleave', () => this.#point(null));
  }

  /** Begins with a part, of which `chosen` faces are chosen; null: there is none. */
  open(part, chosen = part?.first) {
    if (this.on) this.show(false);
    this.part = part?.faces.length > 1 ? part : null;
    element('faces').hidden = !this.part;
    if (!this.part) return;
    this.chosen = new Set(chosen);
    this.last = -1;
    this.before = [];
    this.#fillList();
    this.show(this.chosen.size === 0, true);
  }

  /** A part is there, and none of its faces is chosen. */
  get isEmpty() {
    return this.part !== null && this.chosen.size === 0;
  }

  #all() {
    return new Set(this.part.faces.map(({ index }) => index));
  }

  #fillList() {
    const rows = this.part.faces.map(({ index, kind, area, name }) => {
      const label = document.createElement('label');
      const box = Object.assign(document.createElement('input'), {
        type: 'checkbox',
        value: index,
      });
      const unit = this.part.unit ? ` ${this.part.unit}²` : '';
      label.append(box, ` ${index}: ${kind}, ${format(area, 3)}${unit}${name ? `, ${name}` : ''}`);
      const item = document.createElement('li');
      item.append(label);
      return item;
    });
    element('faces-list').replaceChildren(...rows);
  }

  /** Shows the faces to choose from in the picture, or the part that is made of those chosen. */
  show(on, first = false) {
    if (!on && !this.on) return this.#mark();
    const handlers = {
      onPick: (face, swept) => this.#pick(face, swept || !this.chosen.has(face), swept),
      onTwice: (face) => this.#takeTwice(face),
      onHover: (face) => this.#hover(face),
      onGone: () => this.#setOn(false),
      sweeps: () => element('faces-sweep').checked,
      frames: first,
    };
    this.view.setPatches(on && this.part ? this.part.body : null, handlers);
    this.#setOn(on && Boolean(this.part));
    return this.#mark();
  }

  #setOn(on) {
    this.on = on;
    element('faces-open').setAttribute('aria-pressed', String(on));
  }

  #hover(face) {
    if (this.view.patches.hover(face)) this.view.stage.redraw();
    const chip = element('chip');
    chip.hidden = face < 0;
    const known = this.part.faces.find(({ index }) => index === face);
    if (known)
      chip.textContent = `face ${face}: ${known.kind}${known.name ? `, ${known.name}` : ''}`;
  }

  /** Shows in the picture which face a row of the list is. */
  #point(row) {
    const box = row?.closest('li')?.querySelector('input');
    if (this.on && this.view.patches?.hover(box ? Number(box.value) : -1)) this.view.stage.redraw();
  }

  #pick(face, wanted, swept = false) {
    if (face < 0 || wanted === this.chosen.has(face)) return;
    this.last = wanted ? face : -1;
    const chosen = new Set(this.chosen);
    if (wanted) chosen.add(face);
    else chosen.delete(face);
    const now = performance.now();
    const goesOn = swept && now - this.sweptAt < SWEEP_MS; // one sweep is one choice
    if (swept) this.sweptAt = now;
    this.#take(chosen, goesOn);
    this.#reveal(face);
  }

  /** The row of a face, where the list is open. */
  #reveal(face) {
    const list = element('faces-list');
    const row = list.querySelector(`input[value="${face}"]`).closest('li');
    const [above, below] = [list, row].map((one) => one.getBoundingClientRect());
    if (below.top < above.top || below.bottom > above.bottom)
      list.scrollTop += below.top - above.top;
  }

  /** All smooth from a face, in place of what the two clicks of a double click have done. */
  #takeTwice(face) {
    if (face < 0) return;
    if (this.before.length > 1) this.chosen = this.before.splice(-2)[0];
    this.last = face;
    this.#takeSmooth();
  }

  #takeSmooth() {
    const angle = numberOf(element('faces-angle').value);
    if (this.last < 0) [this.last = -1] = this.chosen;
    if (this.last < 0 || !(angle >= 0)) return;
    this.#take(new Set([...this.chosen, ...grow(this.part.joints, this.last, angle + 1e-6)]));
  }

  #take(chosen, goesOn = false) {
    if (!goesOn) this.before = [...this.before.slice(1 - STEPS), this.chosen];
    this.#become(chosen);
  }

  #undo() {
    if (this.before.length) this.#become(this.before.pop());
  }

  #become(chosen) {
    this.chosen = chosen;
    this.#mark();
    this.onChange(this.part, chosen);
  }

  /** "3 of 9 faces are chosen, 49985 mm²." */
  #count() {
    const { faces, unit } = this.part;
    if (!this.chosen.size)
      return `None of ${faces.length} faces is chosen yet: click on one of the tool side.`;
    const area = faces.reduce((sum, { index, area: own }) => sum + this.chosen.has(index) * own, 0);
    const size = unit ? `${format(area, 4)} ${unit}²` : format(area, 4);
    const are = this.chosen.size === 1 ? 'is' : 'are';
    const closed = holdsBody(this.part, this.chosen)
      ? ' All faces of a closed body are chosen; of a thin wall these are both skins: choose one side.'
      : '';
    return `${this.chosen.size} of ${faces.length} faces ${are} chosen, ${size}.${closed}`;
  }

  #mark() {
    if (!this.part) return;
    if (this.on && this.view.patches) this.view.patches.choose(this.chosen);
    this.view.stage?.redraw();
    for (const box of element('faces-list').querySelectorAll('input'))
      box.checked = this.chosen.has(Number(box.value));
    const { notes } = this.part;
    element('faces-count').textContent = this.#count();
    element('faces-undo').setAttribute('aria-disabled', String(this.before.length === 0));
    element('faces-told').hidden = notes.length === 0;
    element('faces-told').querySelector('summary').textContent =
      `Notes on the file (${notes.length})`;
    element('faces-notes').replaceChildren(
      ...notes.map((text) => Object.assign(document.createElement('li'), { textContent: text })),
    );
  }
}
