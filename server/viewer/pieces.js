// SPDX-License-Identifier: MIT
// A ply of several pieces: divided by splits, or laid in courses of a roll's width; each piece in a
// colour of its own, with its row in a list, and what the service reports of the seams.
import { explain, follow, Problem, read, submitLaminate, token } from './api.js';
import { clothsOf, keptOf, meshOf } from './cloths.js';
import { css, shareOfPiece } from './colour.js';
import { element } from './dom.js';
import { fetchDrape } from './drape.js';
import { format, ofNodes, valuesOf, withUnit } from './fields.js';
import { numberOf, numbersOf } from './form.js';
import { saveAs } from './links.js';

const STRIPS = 2; // colours of courses, in turn
const PLY = '/plies/0'; // what a problem of the laminate begins with
const NONE = 'Draw a split on the part, or say the width of a roll, then drape the pieces.';
const LINKS = [
  ['Patterns SVG', 'plies/0/pattern?format=svg', 'pieces.svg'],
  ['Patterns DXF', 'plies/0/pattern?format=dxf', 'pieces.dxf'],
  ['Ply book', 'report?format=html', 'pieces.html'],
];

const TEXT = 0.02; // of the patterns' width
/** Of courses: what stands above a column, its key, and whether all add up; else the greatest counts,
 *  or without a word none. */
const FIGURES = [
  ['Width', 'width'],
  ['Cut length', 'cut_length', true],
  ['Trim, area', 'trim_area', true],
  ['Covers, share', 'cloth_coverage', true],
  ['Shear, °', 'max_shear_deg', false],
  ['Gap up to', 'gap_greatest', false],
  ['Overlap, area', 'overlap_area', true],
];
const LOOSE = 1.5; // times the cloth is the roll that it may be nested on
const SEAMS = /<h2>Seams<\/h2>\s*<table>.*?<\/table>/s; // in the ply book

const mean = (column) => column.reduce((sum, value) => sum + value, 0) / column.length;

/** A table with a row for each course, and one for all. */
function fillCourses(holder, courses) {
  const row = (kind, texts) => {
    const line = document.createElement('tr');
    line.append(
      ...texts.map((textContent) => Object.assign(document.createElement(kind), { textContent })),
    );
    return line;
  };
  const table = document.createElement('table');
  const total = ([, key, sums]) => {
    const values = courses.map((course) => course[key]);
    const sum = values.reduce((all, value) => (sums ? all + value : Math.max(all, value)), 0);
    return sums === undefined ? '' : format(sum, 3);
  };
  table.append(
    row('th', ['Course', ...FIGURES.map(([title]) => title)]),
    ...courses.map((course, k) =>
      row('td', [k + 1, ...FIGURES.map(([, key]) => format(course[key], 3))]),
    ),
    row('td', ['all', ...FIGURES.map(total)]),
  );
  holder.replaceChildren(...(courses.length ? [table] : []));
}

/** A number of a field, several as a list, text that is neither as it is; undefined when empty. */
function figure(id) {
  const text = element(id).value.trim();
  const numbers = numbersOf(text);
  if (!text) return undefined;
  if (numbers.some(Number.isNaN)) return text;
  return numbers.length === 1 ? numbers[0] : numbers;
}

/** The seam of the form; undefined: cloth meets cloth. */
function seamOf() {
  const kind = element('seam').value;
  const width = figure('seam-width');
  if (!kind) return undefined;
  if (kind === 'gap') return { gap: width };
  return kind === 'overlap' ? { overlap: width } : { overlap: width, over: kind };
}

/** The courses of the form; undefined without a width. */
export function coursesOf() {
  const width = figure('course-width');
  if (width === undefined) return undefined;
  const along = element('course-along').value;
  const path = element('course-path')
    .value.split(';')
    .map(numbersOf)
    .filter((point) => point.length);
  const gap = figure('course-gap');
  return {
    width,
    along: { edge: { edge: path[0] }, path: { path } }[along] ?? along,
    first_offset: figure('course-offset'),
    ...(gap < 0 ? { overlap: -gap } : { gap }),
    order: element('course-order').value || undefined,
  };
}

/** What of the form's settings is of a ply of pieces: these have starts of their own, courses the roll
 *  in place of generators, cuts and an extent. */
export function plyOf(settings, { splits, seam, pieces, courses }) {
  const { fabric, direction, method, yarn_path, permeability, cuts, generators, extent } = settings;
  const shared = { name: 'ply', fabric, direction, method, yarn_path, permeability };
  if (!courses) return { ...shared, cuts, generators, extent, splits, seam, pieces };
  const start = courses.along === 'direction' ? settings.start : undefined;
  return { ...shared, start, courses };
}

const textOfPoints = (points) => points.map((point) => point.join(' ')).join('; ');

/** The seam of a ply into the form, as `seamOf` reads it there. */
function showSeam({ gap, overlap, over } = {}) {
  element('seam').value =
    gap !== undefined ? 'gap' : overlap === undefined ? '' : over || 'overlap';
  element('seam-width').value = [gap ?? overlap ?? ''].flat().join(', ');
}

/** And its courses. */
export function showCourses({
  width = '',
  along = 'direction',
  first_offset,
  gap,
  overlap,
  order,
} = {}) {
  const { edge, path } = along;
  const offset = overlap === undefined ? gap : [overlap].flat().map((value) => -value);
  element('course-width').value = [width].flat().join(', ');
  element('course-along').value = edge ? 'edge' : path ? 'path' : along;
  element('course-path').value = textOfPoints(edge ? [edge] : (path ?? []));
  element('course-offset').value = [first_offset ?? ''].flat().join(', ');
  element('course-gap').value = [offset ?? ''].flat().join(', ');
  element('course-order').value = order ?? '';
  element('courses').open = width !== '';
}

export class Pieces {
  /** `onLook(id)` to show a piece's drape, `onShow()` when the pieces are to be coloured, `onDraw(take,
   *  kind)` to draw a line on the part, `onEnd()` when pieces are draped; `tracer` finds its places. */
  constructor(view, form, { tracer, onLook, onShow, onDraw, onEnd, onError }) {
    Object.assign(this, { view, form, tracer, onLook, onShow, onDraw, onEnd, onError });
    this.clear();
    element('pieces-drape').addEventListener('click', () => this.run());
    element('pieces-show').addEventListener('click', () => this.show(!this.shown));
    element('pieces-own').addEventListener('change', () => this.onShow());
    element('course-draw').addEventListener('click', () => this.#drawAlong());
    for (const id of ['seam', 'course-along'])
      element(id).addEventListener('change', () => this.#showFields());
    this.#showFields();
  }

  /** Another part is in the form. */
  clear() {
    this.show(false);
    this.asked = this.id = this.cloths = this.draped = null;
    this.count = 0; // of splits
    this.own = []; // {at, name, angle} of pieces that differ from the ply
    for (const id of ['pieces-state', 'fault-pieces']) element(id).textContent = '';
    element('pieces-result').hidden = true;
    element('course-width').value = element('course-path').value = '';
  }

  #showFields() {
    element('seam-of').hidden = !element('seam').value;
    element('course-line').hidden = element('course-along').value === 'direction';
  }

  #drawAlong() {
    const edge = element('course-along').value === 'edge';
    const take = (places) => {
      const points = places.map((place) => place.map((x) => Number(x.toPrecision(9))).join(' '));
      element('course-path').value = points.join('; ');
    };
    const onRim = (place, event) => this.tracer.onRim(place ?? this.tracer.missedRim(event), []);
    this.onDraw(take, {
      closed: false,
      least: edge ? 1 : 2,
      most: edge ? 1 : Infinity,
      first: edge ? onRim : null,
      hint: edge
        ? 'Click on the edge of the part along which the first course lies.'
        : 'Click along the line of the first course. Enter or a double click ends, Escape leaves it as it was.',
      refusal: 'That is at no edge of the part.',
    });
  }

  /* ---- draping ---- */

  /** How the ply is divided, as the request of a laminate has it. */
  get division() {
    return {
      splits: this.form.splits.length ? this.form.splits : undefined,
      seam: this.form.splits.length ? seamOf() : undefined,
      courses: coursesOf(),
      pieces: this.own.length
        ? this.own.map(({ at, name, angle }) => ({
            at,
            name: name || undefined,
            direction: Number.isFinite(angle) ? { angle_deg: angle } : undefined,
          }))
        : undefined,
    };
  }

  /** Puts another division into the form. */
  load({ splits = [], seam, pieces = [], courses } = {}) {
    this.clear();
    this.form.splits = splits;
    this.count = splits.length;
    this.own = pieces.map(({ direction, ...piece }) => ({ ...piece, angle: direction?.angle_deg }));
    showSeam(seam);
    showCourses(courses);
    this.#showFields();
  }

  #body() {
    const { division } = this;
    if (!division.splits && !division.courses) throw new Error(NONE);
    const { surfaceText, unit, rosette } = this.form;
    const plies = [plyOf(this.form.settings(), division)];
    const members = JSON.stringify({ length_unit: unit, rosette, plies });
    return `{"surface":${surfaceText},${members.slice(1)}`;
  }

  /** Shows the pieces of a laminate that is there, with its division in the form. */
  async open(id, { plies: [ply] }) {
    this.load(ply);
    this.asked = id;
    const { plies } = await read(`v1/laminates/${id}`);
    await this.#take(id, id, plies[0].pieces);
    this.draped = this.#now();
  }

  /** What the form says, as a laminate; null where that has no pieces. */
  #now() {
    try {
      return this.#body();
    } catch {
      return null;
    }
  }

  /** Whether the pieces that are there are of another request than the form's; marks them as that. */
  tellStale() {
    const stale = Boolean(this.cloths) && this.draped !== this.#now();
    element('pieces-stale').hidden = !stale;
    return stale;
  }

  /** The splits are others: the pieces are draped anew. With fewer of them what was said of pieces is
   *  of none any more. */
  follow() {
    const { length } = this.form.splits;
    if (length < this.count) this.own = [];
    this.count = length;
    if (length) return this.run();
    if (this.id) this.#forget();
    return undefined;
  }

  #forget() {
    this.show(false);
    this.id = this.asked = this.cloths = this.draped = null;
    element('pieces-state').textContent = '';
    element('pieces-result').hidden = true;
  }

  /** Drapes what the form says now; the last call counts. */
  async run() {
    this.form.clearErrors();
    element('fault-pieces').textContent = '';
    let body;
    try {
      this.form.check();
      body = this.#body();
      this.asked = body;
      const { id } = await submitLaminate(body);
      await follow(id, (status) => this.#progress(status, body), undefined, 'laminates');
      const { plies } = await read(`v1/laminates/${id}`);
      if (this.asked === body) await this.#take(id, body, plies[0].pieces);
    } catch (error) {
      if (this.asked === body || !body) this.#fail(error);
    }
  }

  #progress(status, body) {
    if (!status || this.asked !== body) return;
    element('pieces-state').textContent =
      `${status.status}, ${Math.round(100 * status.progress)} %`;
  }

  /** What is wrong stands at the split or the field it is about. */
  #fail(error) {
    element('pieces-state').textContent = '';
    if (error.status === 401) this.onError(error);
    if (!(error instanceof Problem) || !error.errors.length) {
      element('fault-pieces').textContent = explain(error);
      return;
    }
    const errors = error.errors.map(({ pointer = '', detail }) => ({
      pointer: pointer.startsWith(PLY) ? pointer.slice(PLY.length) : pointer,
      detail,
    }));
    this.form.showErrors({ errors, message: error.message });
  }

  async #take(id, body, pieces) {
    const numbered = pieces.map((piece, k) => ({ ...piece, number: k + 1 }));
    const done = numbered.filter(({ status }) => status === 'succeeded');
    if (done.length) await this.#fetch(id, body, done);
    if (this.asked !== body) return;
    this.onEnd();
    const failed = pieces.filter(({ status }) => status !== 'succeeded');
    element('pieces-state').textContent = `${done.length} of ${pieces.length} pieces are draped.`;
    element('fault-pieces').textContent = failed
      .map(({ name, error, status }) => `${name}: ${error?.detail ?? status}`)
      .join(' ');
  }

  /** The nets of the pieces, of each the cells that are its own, and the reports. */
  async #fetch(id, body, done) {
    const drapes = await Promise.all(done.map((piece) => fetchDrape(piece.id)));
    const lattices = drapes.map(({ lattice }) => lattice);
    const headers = { 'Content-Type': 'application/json' };
    const mesh = JSON.stringify({ mesh: meshOf(lattices) });
    const path = `v1/laminates/${id}`;
    const [map, report, request] = await Promise.all([
      read(`${path}/map?format=json`, 'json', { method: 'POST', headers, body: mesh }),
      read(`${path}/report?format=html`, 'text'),
      read(`${path}/request`),
    ]);
    if (this.asked !== body) return;
    const numbers = done.map(({ number }) => number);
    const kept = keptOf(lattices, numbers, map.plies);
    const [ply] = request.plies;
    this.strips = Boolean(ply.courses);
    Object.assign(this, { id, lattices, done });
    this.draped = body;
    this.cloths = clothsOf(lattices, kept, this.form.shape ?? lattices[0], ply.seam?.over);
    this.#fill(report, ply);
    await this.#fillPattern(id);
    this.show(true);
  }

  /* ---- what is shown ---- */

  #colourOf(k) {
    return shareOfPiece(this.strips ? k % STRIPS : k);
  }

  #fill(report, ply) {
    element('pieces-result').hidden = false;
    element('pieces-list').replaceChildren(...this.done.map((piece, k) => this.#row(piece, k)));
    element('pieces-seams').innerHTML = SEAMS.exec(report)?.[0] ?? '';
    const courses = ply.pieces.map(({ course }) => course).filter(Boolean);
    fillCourses(element('pieces-courses'), courses);
    element('pieces-links').replaceChildren(
      ...LINKS.map(([text, path, name]) =>
        this.#link(text, `v1/laminates/${this.id}/${path}`, name),
      ),
    );
  }

  #link(text, path, name) {
    const button = Object.assign(document.createElement('button'), { type: 'button' });
    button.textContent = text;
    button.addEventListener('click', () =>
      read(path, 'blob').then(
        (blob) => saveAs(blob, name),
        (error) => (element('fault-pieces').textContent = explain(error)),
      ),
    );
    return button;
  }

  /** The cells of the k-th piece that is draped. */
  #cellsOf(k) {
    const { pieceOf, cellOf } = this.cloths;
    return cellOf.filter((_, patch) => pieceOf[patch] === k);
  }

  /** A place inside, by which the service knows a piece again. */
  #placeOf(k) {
    const { columns, index } = this.lattices[k];
    const cells = this.#cellsOf(k);
    const centres = cells.map((cell) =>
      ['x', 'y', 'z'].map((axis) =>
        mean([0, 1, 2, 4].map((n) => columns[`nodes.${axis}`][index[6 * cell + n]])),
      ),
    );
    const middle = [0, 1, 2].map((axis) => mean(centres.map((place) => place[axis])));
    const far = (place) => Math.hypot(...place.map((x, axis) => x - middle[axis]));
    return centres.reduce((best, place) => (far(place) < far(best) ? place : best));
  }

  #row(piece, k) {
    const item = document.createElement('li');
    item.style.setProperty('--dot', css('pieces', this.#colourOf(k)));
    const shear = this.#cellsOf(k).map((c) => this.lattices[k].columns['cells.shear_deg'][c]);
    const worst = shear.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
    const told = Object.assign(document.createElement('span'), { className: 'about' });
    told.textContent = `${shear.length.toLocaleString('en')} cells, shear up to ${format(worst, 3)}°`;
    const look = Object.assign(document.createElement('button'), { type: 'button' });
    look.textContent = 'Look';
    look.setAttribute('aria-label', `Look at the drape of ${piece.name}`);
    look.addEventListener('click', () => this.onLook(piece.id));
    if (this.strips || !shear.length) {
      item.append(piece.name, look, told);
      return item;
    }
    item.append(...this.#ownFields(piece, k), look, told);
    return item;
  }

  /** The name and the direction of a piece, which may be other ones than the ply's. */
  #ownFields(piece, k) {
    const own = this.own.find(({ name }) => name === piece.name);
    const field = (label, value, placeholder, take) => {
      const input = Object.assign(document.createElement('input'), { value, placeholder });
      input.setAttribute('aria-label', `${label} of ${piece.name}`);
      input.disabled = Boolean(token.link);
      input.addEventListener('change', () => {
        if (!this.own.length)
          this.own = this.done.map(({ name }, n) => ({ name, at: this.#placeOf(n) }));
        const changed = ({ name }) => name === piece.name;
        this.own = this.own.map((one) =>
          changed(one) ? { ...one, ...take(input.value.trim()) } : one,
        );
        this.run();
      });
      return input;
    };
    const angle = Number.isFinite(own?.angle) ? own.angle : '';
    return [
      field('Name', piece.name, '', (name) => ({ name: name || piece.name })),
      field('Warp direction, degrees,', angle, 'as the ply', (text) => ({ angle: numberOf(text) })),
    ];
  }

  /** The service's patterns on a roll of the pane's shape, each piece in its colour. */
  async #fillPattern(id) {
    const pane = element('pane-flat');
    const shape = (pane.offsetHeight || 1) / (pane.offsetWidth || 1);
    const area = this.done.reduce((sum, _, k) => sum + this.#flatAreaOf(k), 0);
    const path = `v1/laminates/${id}/patterns?format=svg`;
    const width = Number(Math.sqrt(LOOSE * area * shape).toPrecision(3));
    const svg = await read(`${path}&width=${width}`, 'text').catch(() => read(path, 'text'));
    const drawn = new DOMParser().parseFromString(svg, 'image/svg+xml').documentElement;
    const root = document.importNode(drawn, true);
    element('pieces-pattern').replaceChildren(root);
    const texts = [...root.querySelectorAll('text')];
    for (const text of texts) text.style.fontSize = `${TEXT * root.viewBox.baseVal.width}px`;
    root.querySelectorAll('.cut path').forEach((path, n) => {
      const k = this.done.findIndex(({ name }) => texts[n].textContent.endsWith(`, ${name}`));
      if (k >= 0) path.setAttribute('fill', css('pieces', this.#colourOf(k)));
    });
  }

  #flatAreaOf(k) {
    const [warp, weft] = this.form.spacing;
    return this.#cellsOf(k).length * warp * weft;
  }

  /** Shows the pieces in 3D and their patterns, or the net again. */
  show(on) {
    if (on ? !this.cloths : !this.shown) return;
    const handlers = {
      over: true,
      onPick: (patch) => patch >= 0 && this.onLook(this.done[this.cloths.pieceOf[patch]].id),
      onHover: (patch) => this.#hover(patch),
      onGone: () => this.#setShown(false),
    };
    this.view.setPatches(on ? this.cloths : null, handlers);
    this.#setShown(on);
    this.onShow();
  }

  #setShown(on) {
    this.shown = on;
    element('pieces-show').setAttribute('aria-pressed', String(on));
    element('pieces-pattern').hidden = !on;
    element('caption-solid').hidden = on;
  }

  /** The values of a field on all cells; null where the pieces are not coloured by it. */
  valuesOf(field) {
    if (!this.shown || element('pieces-own').checked || ofNodes(field)) return null;
    const columns = this.lattices.map((lattice) => lattice.columns[field.column]);
    if (columns.some((column) => !column)) return null;
    const { pieceOf, cellOf } = this.cloths;
    const all = Float32Array.from(cellOf, (cell, patch) => columns[pieceOf[patch]][cell]);
    return valuesOf({ [field.column]: all }, field);
  }

  /** Colours the cells by their piece, or by a field on the scale of all that is shown. */
  colour(field, { range, map }) {
    if (!this.shown) return;
    const values = this.valuesOf(field);
    this.field = field;
    this.values = values;
    const own = () => Float32Array.from(this.cloths.pieceOf, (k) => this.#colourOf(k));
    if (values) this.view.patches?.setValues(values, range, map);
    else this.view.patches?.setValues(own(), [0, 1], 'pieces');
    this.view.stage?.redraw();
  }

  #hover(patch) {
    if (this.view.patches.hover(patch)) this.view.stage.redraw();
    const chip = element('chip');
    chip.hidden = patch < 0;
    if (patch < 0) return;
    const k = this.cloths.pieceOf[patch];
    const shear = this.lattices[k].columns['cells.shear_deg'][this.cloths.cellOf[patch]];
    chip.textContent = `${this.done[k].name}: sheared by ${withUnit(format(shear, 3), '°')}`;
  }
}
