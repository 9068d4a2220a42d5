// SPDX-License-Identifier: MIT
// A drape on somebody's mesh: its elements coloured by the fields, an inlet that is picked by clicks,
// the cavity's heights, and the map in every format that the service has.
import { call, read, storeSurface } from './api.js';
import { element } from './dom.js';
import { format, rangeOf, valuesOf, withUnit } from './fields.js';
import { fileName, saveAs } from './links.js';
import { formatOf } from './part.js';
import { readElements } from './work.js';

const DESCRIPTION = 'v1/openapi.json';
const MAP = '/v1/drapes/{id}/map';
const ENDINGS = { gmsh: 'msh', lcmsim: 'zip', 'lcmsim-h5': 'h5', lims: 'dmp' };
const CAVITY = { 'mesh-height': 'cavity_height', 'mesh-punch': 'punch' };

/** The formats of maps by the service's own description. */
async function formatsOf() {
  const { paths } = await read(DESCRIPTION);
  const { schema } = paths[MAP].post.parameters.find(({ name }) => name === 'format');
  return schema.enum;
}

/** The body and type of the call that maps this file. */
async function messageOf(file, unit) {
  const kind = formatOf(file.name);
  if (kind === 'nastran') return { body: file, type: 'text/x-nastran' };
  let document;
  if (kind) {
    const query = `?format=${kind}&unit=${unit}`;
    const { id } = await storeSurface(file, 'application/octet-stream', query);
    document = await read(`v1/surfaces/${id}`);
  } else {
    document = JSON.parse(await file.text());
  }
  const { vertices, triangles } = document;
  const body = JSON.stringify(vertices ? { mesh: { vertices, triangles } } : document);
  return { body, type: 'application/json' };
}

export class Mapped {
  /** `onShow()` when the mesh is to be coloured, `onError(error)`. */
  constructor(view, { onShow, onError }) {
    Object.assign(this, { view, onShow, onError });
    this.file = null;
    this.shown = false;
    this.inlet = new Set(); // rows of the map
    element('mesh-file').addEventListener('change', ({ target }) => this.open(target.files[0]));
    element('mesh-show').addEventListener('change', ({ target }) => this.show(target.checked));
    element('mesh-close').addEventListener('click', () => this.close());
    element('mesh-whole').addEventListener('change', () => this.#again());
    for (const id of Object.keys(CAVITY))
      element(id).addEventListener('change', () => this.#again());
    element('mesh-inlet').addEventListener('change', ({ target }) => this.#takeInlet(target.value));
  }

  /** The drape that meshes are mapped from; null: there is none. Maps the mesh anew. */
  setDrape(drape, unit) {
    const same = drape?.id === this.drape?.id;
    Object.assign(this, { drape, unit });
    element('mesh-file').disabled = !drape;
    if (!drape) this.close();
    else if (!same) this.#again();
  }

  /** A laminate whose stack can be mapped instead of the drape; null: there is none. */
  setStack(id) {
    const before = this.#whole;
    this.stack = id;
    element('mesh-stack').hidden = !id;
    if (before) this.#again();
  }

  get #whole() {
    return Boolean(this.stack && element('mesh-whole').checked);
  }

  /** Maps anew; what is wrong with the words about it is told beside them. */
  #again() {
    element('fault-mesh').textContent = '';
    if (!this.message) return;
    this.#map().catch((error) => {
      if (error.status !== 422) this.onError(error);
      else element('fault-mesh').textContent = error.message;
    });
  }

  /** What the page says of the cavity, for the query of a map. */
  get #cavity() {
    return Object.entries(CAVITY)
      .map(([id, name]) => [name, element(id).value.replace(/\s/g, '')])
      .filter(([, value]) => value)
      .map(([name, value]) => `&${name}=${encodeURIComponent(value)}`)
      .join('');
  }

  /** Maps the drape onto the mesh of a file. */
  async open(file) {
    if (!file || !this.drape) return;
    element('fault-mesh').textContent = '';
    element('mesh-about').textContent = `Mapping onto ${file.name} …`;
    for (const id of Object.keys(CAVITY)) element(id).value = '';
    try {
      this.inlet = new Set();
      this.file = file;
      this.message = await messageOf(file, this.unit);
      this.formats ||= await formatsOf();
      await this.#map();
    } catch (error) {
      this.close();
      element('fault-mesh').textContent = `${file.name}: ${error.message}`;
      if (error.status === 401) this.onError(error);
    }
  }

  close() {
    this.show(false);
    this.file = this.message = this.body = null;
    for (const id of ['mesh-about', 'fault-mesh']) element(id).textContent = '';
    element('mesh-tools').hidden = true;
    element('mesh-file').value = '';
  }

  #post(query) {
    const { body, type } = this.message;
    const headers = { 'Content-Type': type };
    const of = this.#whole ? `laminates/${this.stack}` : `drapes/${this.drape.id}`;
    return call(`v1/${of}/map?${query}${this.#cavity}`, { method: 'POST', body, headers });
  }

  async #map() {
    const { drape, message, stack } = this;
    const whole = this.#whole;
    const [answer, words] = await Promise.all([
      this.#post('format=vtu'),
      this.#post('format=json&fields=id&precision=3'),
    ]);
    const body = await readElements(await answer.arrayBuffer());
    const { warnings } = await words.json();
    const same = this.drape === drape && this.message === message && this.stack === stack;
    if (!same || this.#whole !== whole) return; // another one came meanwhile
    const inlet = this.body ? this.#inletIds : [];
    this.body = body;
    this.inlet = new Set(this.#rowsOf(inlet).filter((row) => row !== undefined));
    element('mesh-tools').hidden = false;
    this.#describe(warnings);
    this.#fillDownloads();
    this.show(true);
  }

  #describe(warnings) {
    const { count, columns } = this.body;
    const beyond = columns.extrapolated.reduce((sum, value) => sum + value, 0);
    const far = withUnit(format(rangeOf(columns.distance)[1], 3), this.unit);
    element('mesh-about').textContent =
      `${this.file.name}: ${count.toLocaleString('en')} elements, ${beyond.toLocaleString('en')} ` +
      `beyond the cloth, the farthest ${far} from it. ${warnings.join(' ')}`;
  }

  /** Shows the elements in 3D, or the net again. */
  show(on) {
    if (!on && !this.shown) return;
    const handlers = {
      onPick: (row) => this.#pick(row),
      onHover: (row) => this.#hover(row),
      onGone: () => this.#setShown(false),
    };
    this.view.setPatches(on ? this.body : null, handlers);
    this.#setShown(on);
    if (on) this.#mark();
    this.onShow();
  }

  #setShown(on) {
    this.shown = on;
    element('mesh-show').checked = on;
  }

  /** The values of a field on the elements; null where the mesh is not shown, or has none. */
  valuesOf(field) {
    const column = this.shown && this.body.columns[field.column.replace('cells.', '')];
    return column ? valuesOf({ [field.column]: column }, field) : null;
  }

  /** Colours the elements by a field on the scale of all that is shown. */
  colour(field, { range, map }) {
    if (!this.shown) return;
    this.field = field;
    this.values = this.valuesOf(field);
    this.view.patches?.setValues(this.values, range, map);
    const unit = field.unit(this.unit);
    const ends = this.values && rangeOf(this.values).map((x) => withUnit(format(x, 3), unit));
    element('mesh-range').textContent = this.values
      ? `${field.label}: ${ends.join(' to ')}.`
      : `The map has no ${field.label.toLowerCase()}.`;
    this.view.stage?.redraw();
  }

  #hover(row) {
    if (this.view.patches.hover(row)) this.view.stage.redraw();
    const chip = element('chip');
    chip.hidden = row < 0;
    if (row < 0) return;
    const { columns } = this.body;
    const value = this.values
      ? `: ${withUnit(format(this.values[row]), this.field.unit(this.unit))}`
      : '';
    const beyond = columns.extrapolated[row] ? ', beyond the cloth' : '';
    chip.textContent = `element ${columns.id[row]}${value}${beyond}`;
  }

  /* ---- the inlet ---- */

  #pick(row) {
    if (row < 0) return;
    if (!this.inlet.delete(row)) this.inlet.add(row);
    this.#mark();
  }

  /** The rows of elements by their numbers; undefined for one that there is not. */
  #rowsOf(ids) {
    const rows = new Map(Array.from(this.body.columns.id, (id, row) => [id, row]));
    return ids.map((id) => rows.get(Number(id)));
  }

  #takeInlet(text) {
    const ids = text.split(/[\s,;]+/).filter(Boolean);
    const rows = this.#rowsOf(ids);
    const unknown = ids.filter((_, k) => rows[k] === undefined);
    element('fault-mesh').textContent = unknown.length
      ? `The mesh has no element ${unknown.join(', ')}.`
      : '';
    this.inlet = new Set(rows.filter((row) => row !== undefined));
    this.#mark();
  }

  get #inletIds() {
    return [...this.inlet].map((row) => this.body.columns.id[row]).sort((a, b) => a - b);
  }

  #mark() {
    this.view.patches?.choose(this.inlet);
    this.view.stage?.redraw();
    element('mesh-inlet').value = this.#inletIds.join(', ');
  }

  /* ---- downloads ---- */

  #fillDownloads() {
    const items = this.formats.map((name) => {
      const item = document.createElement('li');
      const button = Object.assign(document.createElement('button'), {
        type: 'button',
        textContent: name,
      });
      button.addEventListener('click', () => this.#download(name));
      item.append(button);
      return item;
    });
    element('mesh-downloads').replaceChildren(...items);
  }

  async #download(name) {
    element('fault-mesh').textContent = '';
    const ids = this.#inletIds;
    const inlet = ids.length ? `&inlet=${ids.join(',')}` : '';
    try {
      const answer = await this.#post(`format=${name}${inlet}`);
      const title = fileName(this.file.name.replace(/\.\w+$/, ''));
      saveAs(await answer.blob(), `${title}-draped.${ENDINGS[name] || name}`);
    } catch (error) {
      element('fault-mesh').textContent = `${name}: ${error.message}`;
    }
  }
}
