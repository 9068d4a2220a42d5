// SPDX-License-Identifier: MIT
// Lines of the cloth, drawn on the part: cuts, from an edge to a tip inside, and splits, from edge to
// edge or closed; their lists in the form, and the knobs in the picture by which they are moved.
import { element } from './dom.js';
import { format } from './fields.js';
import { numbersOf } from './form.js';
import { makeKnob, putKnob } from './knob.js';
import { away, Paths } from './tracing.js';

const KNOBS = 12; // of a line: one of more corners has those at its ends
const CLOSES = 12; // pixels from the first point, where a click closes a line
const CUT = {
  hint: 'Click on an edge of the part, where the cut begins, then on to its tip. Enter or a double click ends, Escape leaves all as it was.',
  refusal: 'A cut begins at an edge of the part, of a hole or of another cut: click nearer to one.',
  knobs: ['Mouth', 'Tip'],
};
const SPLIT = {
  hint: 'Click on an edge of the part, where the split begins, and on to another edge, or round to the first point. Enter or a double click ends, Escape leaves all as it was.',
  refusal: 'A split begins at an edge of the part or of another split: click nearer to one.',
  lastRefusal: 'A split ends at an edge of the part, at another split, or where it began.',
  knobs: ['First end', 'Last end'],
};
const KINDS = { cut: CUT, split: SPLIT };

const textOf = (path) => path.map((point) => point.join(' ')).join('; ');
const pathOf = (text) =>
  text
    .split(';')
    .map(numbersOf)
    .filter((point) => point.length);

/** What became of a cut: its row of the table `cuts`. */
function describeCut(columns, k, unit) {
  const [length, angle, width, covered] = ['length', 'tip_angle_deg', 'mouth_width', 'covered'].map(
    (name) => columns[`cuts.${name}`][k],
  );
  if (!covered) return `${format(length, 4)} ${unit} long; not covered`;
  const what = Math.abs(angle) < 0.05 ? 'slit' : angle > 0 ? 'dart' : 'opens';
  return `${format(length, 4)} ${unit} long; ${what}, ${format(angle, 4)}° at the tip, ${format(width, 4)} ${unit} at the mouth`;
}

export class Lines {
  /** `kind`: 'cut' or 'split'; `outline` draws, `tracer` finds places, `history` keeps what was;
   *  `onLive` while a knob is dragged, `onSettled` when the lines are others, `onDraw()` before one
   *  is drawn. */
  constructor(kind, { view, form, outline, tracer, history }, { onLive, onSettled, onDraw }) {
    Object.assign(this, { kind, view, form, outline, tracer, history });
    Object.assign(this, { onLive, onSettled, onDraw });
    this.paths = new Paths(tracer);
    element(`${kind}-draw`).addEventListener('click', () => this.#begin());
    this.load();
  }

  get lines() {
    return this.form[`${this.kind}s`];
  }

  set lines(lines) {
    this.form[`${this.kind}s`] = lines;
  }

  /** Other lines are in the form. */
  load() {
    this.columns = null;
    this.#fill();
  }

  /** The drape that is shown: null, or its columns and its unit. */
  show(columns, unit) {
    const { length = 0 } = columns?.['cuts.length'] ?? {};
    this.columns = length === this.lines.length ? columns : null;
    this.unit = unit;
    this.#tell();
  }

  /** Other lines, which can be taken back. */
  set(lines) {
    this.history.note();
    this.lines = lines;
    this.load();
    this.onSettled();
  }

  #change(k, values) {
    this.set(this.lines.map((line, n) => (n === k ? { ...line, ...values } : line)));
  }

  #remove(k) {
    this.set(this.lines.filter((_, n) => n !== k));
  }

  /* ---- drawing ---- */

  #begin() {
    this.onDraw();
    this.outline.begin((corners) => this.#take(corners), {
      least: 2,
      closed: false,
      first: (place, event) => this.#onEdge(place ?? this.tracer.missedRim(event)),
      next: (place, event) =>
        place ? this.tracer.onFold(place) : this.kind === 'split' && this.tracer.missedRim(event),
      last: this.kind === 'split' ? (points) => this.#last(points) : null,
      ...KINDS[this.kind],
    });
  }

  #take(corners) {
    this.set([...this.lines, { path: this.paths.through(corners) }]);
  }

  /** Where a line may begin that is meant by a place; `own`: the line itself, which is not meant. */
  #onEdge(place, anywhere = false, own = null) {
    const others = this.lines.filter((line) => line !== own);
    return this.tracer.onRim(
      place,
      others.map(({ path }) => path),
      anywhere,
    );
  }

  /** Where a split ends: where it began, or at an edge; null elsewhere. */
  #last(points) {
    const [first, last] = [points[0], points.at(-1)];
    const [a, b] = [first, last].map((place) => this.view.pixelsOfPlace(place));
    const closes = points.length > 3 && Math.hypot(a.x - b.x, a.y - b.y) < CLOSES;
    return closes ? first : this.#onEdge(last);
  }

  /** Puts lines and knobs where they are in the picture; `project(point)` gives pixels. */
  draw(project) {
    const text = ({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`;
    const drawn = this.lines.map(({ path }) => `M${path.map(project).map(text).join(' ')}`);
    element(`${this.kind}-lines`).setAttribute('d', drawn.join(''));
    for (const { knob, k, n } of this.knobs)
      putKnob(knob, project(this.paths.cornersOf(this.lines[k].path).at(n)));
  }

  /* ---- the list ---- */

  #fill() {
    const { kind, lines } = this;
    element(`${kind}-list`).replaceChildren(...lines.map((line, k) => this.#row(line, k)));
    this.knobs = lines.flatMap((line, k) => this.#knobsOf(line, k));
    element(`${kind}-knobs`).replaceChildren(...this.knobs.map(({ knob }) => knob));
    this.#tell();
    this.view.stage?.redraw();
  }

  #row(line, k) {
    const { kind } = this;
    const item = document.createElement('li');
    const field = (label, value, take) => {
      const input = Object.assign(document.createElement('input'), { value });
      input.setAttribute('aria-label', `${label} of ${kind} ${k + 1}`);
      input.addEventListener('change', () => take(input.value.trim()));
      return input;
    };
    const name = field('Name', line.name ?? '', (text) =>
      this.#change(k, { name: text || undefined }),
    );
    Object.assign(name, { id: `${kind}-name-${k}`, placeholder: `${kind}_${k + 1}` });
    name.dataset.pointer = `/${kind}s/${k}`;
    const points = field('Points, x y z;', textOf(line.path), (text) =>
      this.#change(k, { path: pathOf(text) }),
    );
    const remove = Object.assign(document.createElement('button'), { type: 'button' });
    remove.textContent = 'Remove';
    remove.setAttribute('aria-label', `Remove ${kind} ${k + 1}`);
    remove.addEventListener('click', () => this.#remove(k));
    const holder = document.createElement('div');
    holder.append(name, remove, points);
    const told = Object.assign(document.createElement('p'), { className: 'about' });
    item.append(holder, told);
    return item;
  }

  #tell() {
    [...element(`${this.kind}-list`).children].forEach((item, k) => {
      item.lastChild.textContent = this.columns ? describeCut(this.columns, k, this.unit) : '';
    });
  }

  /* ---- knobs ---- */

  #knobsOf({ path }, k) {
    const { length } = this.paths.cornersOf(path);
    const closed = away(path[0], path.at(-1)) === 0;
    const all = Array.from({ length: closed ? length - 1 : length }, (_, n) => n);
    const shown = all.length > KNOBS ? [all[0], all.at(-1)] : all;
    return shown.map((n) => ({ knob: this.#knob(k, n, length, closed), k, n }));
  }

  #knob(k, n, length, closed) {
    const isEnd = !closed && (n === 0 || n === length - 1);
    const [first, last] = KINDS[this.kind].knobs;
    const name = !isEnd ? `Point ${n + 1}` : n === 0 ? first : last;
    const isTip = this.kind === 'cut' && n === length - 1;
    let before = null;
    return makeKnob(this.view, {
      label: `${name} of ${this.kind} ${k + 1}. Drag it, or use the arrow keys; Delete removes ${isEnd ? 'the line' : 'it'}.`,
      kind: `${isTip ? 'tip' : 'corner'} of-${this.kind}`,
      begin: () => (before = this.history.read()),
      move: (place, event) => {
        const meant =
          isEnd && !isTip ? this.#along(k, place, event) : place && this.tracer.onFold(place);
        if (!meant) return false;
        this.#moveCorner(k, n, meant, closed);
        this.onLive();
        return true;
      },
      end: (kept) => {
        if (!kept) return this.history.write(before);
        this.history.note(before);
        this.load();
        this.onSettled();
      },
      remove: () => (isEnd || length < 4 ? this.#remove(k) : this.#removeCorner(k, n)),
      again: () => this.knobs.find((other) => other.k === k && other.n === n)?.knob,
    });
  }

  /** Where on an edge the end of a line is dragged to. */
  #along(k, place, event) {
    return this.#onEdge(place ?? this.tracer.missedRim(event), true, this.lines[k]);
  }

  #moveCorner(k, n, place, closed) {
    const { lines } = this;
    let path = this.paths.moved(lines[k].path, n, place);
    const last = this.paths.cornersOf(path).length - 1;
    if (closed && n === 0) path = this.paths.moved(path, last, place);
    this.lines = lines.map((line, m) => (m === k ? { ...line, path } : line));
    this.view.stage.redraw();
  }

  #removeCorner(k, n) {
    this.#change(k, { path: this.paths.without(this.lines[k].path, n) });
  }
}
