// SPDX-License-Identifier: MIT
// Cuts of the cloth, drawn on the part: lines from an edge to a tip inside, their list in the form,
// and their tips in the picture, to be moved.
import { element } from './dom.js';
import { format } from './fields.js';
import { numbersOf } from './form.js';

const REACH = 30; // pixels from an edge within which a cut begins there
const STEP = 8; // pixels from one place of a cut that is drawn to the next
const SLACK = 1e-3; // of the part's radius: what lies nearer to a straight line is left out
const LINE = {
  least: 2,
  closed: false,
  hint: 'Click on an edge of the part, where the cut begins, then on to its tip. Enter or a double click ends, Escape leaves all as it was.',
};
const INSIDE =
  'A cut begins at an edge of the part, of a hole or of another cut: click nearer to one.';

/** The place of the line from a to b that is nearest to a point. */
function nearestOf(a, b, point) {
  const along = b.map((x, k) => x - a[k]);
  const length2 = along.reduce((sum, x) => sum + x * x, 0);
  const share = along.reduce((sum, x, k) => sum + x * (point[k] - a[k]), 0) / (length2 || 1);
  return a.map((x, k) => x + Math.min(Math.max(share, 0), 1) * along[k]);
}

/** The place of the edges of a shape and of lines before that is nearest to a point. */
export function nearestEdge({ position, edges, origin }, lines, point) {
  const corner = (n) => origin.map((x, k) => x + position[3 * n + k]);
  let best = null;
  const take = (a, b) => {
    const place = nearestOf(a, b, point);
    const far = away(place, point);
    if (!best || far < best.far) best = { place, far };
  };
  for (let k = 0; k < edges.length; k += 2) take(corner(edges[k]), corner(edges[k + 1]));
  for (const line of lines) for (let k = 1; k < line.length; k++) take(line[k - 1], line[k]);
  return best?.place ?? null;
}

const away = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));

/** Without points that lie on the straight lines between others, to within `slack`. */
export function straightened(path, slack) {
  const kept = [path[0]];
  for (let from = 0, to = 2; to <= path.length; to++) {
    const between = path.slice(from + 1, to);
    const straight = between.every(
      (point) => to < path.length && away(point, nearestOf(path[from], path[to], point)) < slack,
    );
    if (straight) continue;
    from = to - 1;
    kept.push(path[from]);
  }
  return kept;
}

const rounded = (place) => place.map((x) => Number(x.toPrecision(9)));
const textOf = (path) => path.map((point) => point.join(' ')).join('; ');

/** What became of a cut: its row of the table `cuts`. */
function describeCut(columns, k, unit) {
  const [length, angle, width, covered] = ['length', 'tip_angle_deg', 'mouth_width', 'covered'].map(
    (name) => columns[`cuts.${name}`][k],
  );
  if (!covered) return `${format(length, 4)} ${unit} long; not covered`;
  const what = Math.abs(angle) < 0.05 ? 'slit' : angle > 0 ? 'dart' : 'opens';
  return `${format(length, 4)} ${unit} long; ${what}, ${format(angle, 4)}° at the tip, ${format(width, 4)} ${unit} at the mouth`;
}

export class Cuts {
  /** `onLive` while a tip is dragged, `onSettled` when the cuts are others; `outline` draws lines,
   *  `onDraw()` before it does. */
  constructor(view, form, outline, { onLive, onSettled, onDraw }) {
    Object.assign(this, { view, form, outline, onLive, onSettled, onDraw });
    this.past = [];
    this.corners = new WeakMap(); // of paths: the points that were clicked
    element('cut-draw').addEventListener('click', () => this.#begin());
    element('cut-undo').addEventListener('click', () => this.#undo());
    this.load();
  }

  /** Another request is in the form. */
  load() {
    this.past = [];
    this.columns = null;
    this.#fill();
  }

  /** The drape that is shown: null, or its columns and its unit. */
  show(columns, unit) {
    const { length = 0 } = columns?.['cuts.length'] ?? {};
    this.columns = length === this.form.cuts.length ? columns : null;
    this.unit = unit;
    this.#tell();
  }

  #set(cuts) {
    this.past.push(this.form.cuts);
    this.form.cuts = cuts;
    this.columns = null;
    this.#fill();
    this.onSettled();
  }

  #undo() {
    this.form.cuts = this.past.pop();
    this.columns = null;
    this.#fill();
    this.onSettled();
  }

  #change(k, values) {
    this.#set(this.form.cuts.map((cut, n) => (n === k ? { ...cut, ...values } : cut)));
  }

  /* ---- drawing ---- */

  #begin() {
    this.onDraw();
    const first = (place) => this.#onEdge(place);
    const take = (corners) => this.#set([...this.form.cuts, { path: this.#along(corners) }]);
    this.outline.begin(take, { ...LINE, first, refusal: INSIDE });
  }

  /** The path over the part that lies under straight lines of the picture from corner to corner. */
  #along(corners) {
    const box = element('pane-solid').getBoundingClientRect();
    const path = [corners[0]];
    for (let n = 1; n < corners.length; n++) {
      const [a, b] = [corners[n - 1], corners[n]];
      const [from, to] = [a, b].map((place) => this.view.pixelsOfPlace(place));
      const steps = Math.ceil(Math.hypot(to.x - from.x, to.y - from.y) / STEP);
      for (let k = 1; k < steps; k++) {
        const clientX = box.x + from.x + (k / steps) * (to.x - from.x);
        const clientY = box.y + from.y + (k / steps) * (to.y - from.y);
        const place = this.view.placeAt({ clientX, clientY });
        const near = place && away(place, nearestOf(a, b, place)) < away(a, b); // else of a part before it
        if (near) path.push(place);
      }
      path.push(b);
    }
    const slack = SLACK * (this.form.shape?.radius ?? 0);
    const whole = straightened(path, slack).map(rounded);
    this.corners.set(whole, corners);
    return whole;
  }

  /** The place of an edge that is meant by one beside it; null where none is near. */
  #onEdge(place) {
    const { shape, cuts } = this.form;
    const lines = cuts.map(({ path }) => path);
    const found = shape && nearestEdge(shape, lines, place);
    if (!found) return null;
    const [a, b] = [place, found].map((point) => this.view.pixelsOfPlace(point));
    return Math.hypot(a.x - b.x, a.y - b.y) < REACH ? found : null;
  }

  /** Puts lines and tips where they are in the picture; `project(point)` gives pixels. */
  draw(project) {
    const paths = this.form.cuts.map(({ path }) => path.map(project));
    const text = ({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`;
    element('cut-lines').setAttribute(
      'd',
      paths.map((line) => `M${line.map(text).join(' ')}`).join(''),
    );
    [...element('cut-tips').children].forEach((tip, k) => {
      const { x, y } = paths[k].at(-1);
      tip.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    });
  }

  /* ---- the list ---- */

  #fill() {
    const { cuts } = this.form;
    element('cut-list').replaceChildren(...cuts.map((cut, k) => this.#row(cut, k)));
    element('cut-tips').replaceChildren(...cuts.map((cut, k) => this.#tip(k)));
    element('cut-undo').disabled = !this.past.length;
    this.#tell();
    this.view.stage?.redraw();
  }

  #row(cut, k) {
    const item = document.createElement('li');
    const field = (label, value, take) => {
      const input = Object.assign(document.createElement('input'), { value });
      input.setAttribute('aria-label', `${label} of cut ${k + 1}`);
      input.addEventListener('change', () => take(input.value.trim()));
      return input;
    };
    const name = field('Name', cut.name ?? '', (text) =>
      this.#change(k, { name: text || undefined }),
    );
    Object.assign(name, { id: `cut-name-${k}`, placeholder: `cut_${k + 1}` });
    name.dataset.pointer = `/cuts/${k}`;
    const points = field('Points, x y z;', textOf(cut.path), (text) => {
      const path = text
        .split(';')
        .map(numbersOf)
        .filter((point) => point.length);
      this.#change(k, { path });
    });
    const remove = Object.assign(document.createElement('button'), { type: 'button' });
    remove.textContent = 'Remove';
    remove.setAttribute('aria-label', `Remove cut ${k + 1}`);
    remove.addEventListener('click', () => this.#set(this.form.cuts.filter((_, n) => n !== k)));
    const holder = document.createElement('div');
    holder.append(name, remove, points);
    const told = Object.assign(document.createElement('p'), { className: 'about' });
    item.append(holder, told);
    return item;
  }

  #tell() {
    [...element('cut-list').children].forEach((item, k) => {
      item.lastChild.textContent = this.columns ? describeCut(this.columns, k, this.unit) : '';
    });
  }

  /** The tip of a cut: dragged, or moved with the arrow keys, it goes over the part. */
  #tip(k) {
    const tip = Object.assign(document.createElement('button'), { type: 'button' });
    tip.className = 'handle tip';
    tip.setAttribute('aria-label', `Tip of cut ${k + 1}. Drag it, or use the arrow keys.`);
    let before = null;
    const move = (place) => {
      const { cuts } = this.form;
      const corners = this.corners.get(cuts[k].path) ?? cuts[k].path;
      const path = this.#along([...corners.slice(0, -1), place]);
      this.form.cuts = cuts.map((cut, n) => (n === k ? { ...cut, path } : cut));
      this.view.stage.redraw();
    };
    const end = () => {
      const { cuts } = this.form;
      this.form.cuts = before;
      before = null;
      this.#set(cuts);
    };
    tip.addEventListener('pointerdown', (event) => {
      event.stopPropagation();
      tip.setPointerCapture(event.pointerId);
      before = this.form.cuts;
    });
    tip.addEventListener('pointermove', (event) => {
      const place = before && this.view.placeAt(event);
      if (!place) return;
      move(place);
      this.onLive();
    });
    tip.addEventListener('pointerup', (event) => {
      event.stopPropagation();
      if (before && before !== this.form.cuts) end();
      before = null;
    });
    tip.addEventListener('pointercancel', () => {
      if (before) this.form.cuts = before;
      before = null;
      this.onSettled();
    });
    tip.addEventListener('keydown', (event) => {
      const moves = { ArrowLeft: [-8, 0], ArrowRight: [8, 0], ArrowUp: [0, -8], ArrowDown: [0, 8] };
      if (!moves[event.key]) return;
      event.preventDefault();
      event.stopPropagation();
      const box = tip.getBoundingClientRect();
      const [x, y] = moves[event.key];
      const place = this.view.placeAt({
        clientX: box.x + box.width / 2 + x,
        clientY: box.y + box.height / 2 + y,
      });
      if (!place) return;
      before = this.form.cuts;
      move(place);
      end();
      element('cut-tips').children[k]?.focus();
    });
    return tip;
  }
}
