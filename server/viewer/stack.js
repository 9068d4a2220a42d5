// SPDX-License-Identifier: MIT
// A laminate: a table of plies, draped together, and looked through one after the other.
import { address, explain, follow, read, submitLaminate, token } from './api.js';
import { element } from './dom.js';
import { numberOf, numbersOf } from './form.js';
import { fileName, saveAs } from './links.js';

const OWN = [
  'fabric',
  'start',
  'direction',
  'generators',
  'method',
  'yarn_path',
  'permeability',
  'cuts',
];

/** What of a drape's settings is a ply's own. */
export const plyOf = (settings) => Object.fromEntries(OWN.map((key) => [key, settings[key]]));

/** The plies of a stack and those that mirror them, the last one outside. */
export const mirrored = (plies) => [...plies, ...[...plies].reverse().map((ply) => ({ ...ply }))];

/** What a ply has beside its cloth, as the service takes it; it says what is wrong with it. */
export function restOf({ repeat, law, boundary }) {
  const [a, b] = numbersOf(law);
  const points = boundary.split(';').map(numbersOf);
  return {
    ...(repeat.trim() ? { repeat: Number(repeat) } : {}),
    ...(law.trim() ? { compaction: { a, b } } : {}),
    ...(boundary.trim() ? { boundary: { polygon: points.filter((point) => point.length) } } : {}),
  };
}

/** A ply of the table, of that of a request. */
const rowOf = ({ name, direction, repeat = 1, compaction, boundary, ...ply }) => ({
  name,
  angle: direction?.angle_deg ?? null,
  own: plyOf({ ...ply, direction }),
  repeat: repeat === 1 ? '' : String(repeat),
  law: compaction ? `${compaction.a} ${compaction.b}` : '',
  boundary: boundary?.polygon ? textOf(boundary.polygon) : '',
});

/** A polygon as the field of a boundary has it. */
const textOf = (points) =>
  points.map((point) => point.map((x) => Number(x.toPrecision(7))).join(' ')).join('; ');

/** And that of a request, of one of the table: {name, angle, own, repeat, law, boundary}, the last
 *  three as text. */
export const plyOfRow = ({ name, angle, own, ...rest }) => ({
  ...own,
  name,
  ...(angle === null ? {} : { direction: { angle_deg: angle } }),
  ...restOf(rest),
});

export class Stack {
  /** `onLook(id, ply)` to show a ply's drape, `onStack(id)` with a laminate that is draped, null
   *  when it no longer is what the table says, `onDraw(take)` for a polygon that is drawn. */
  constructor(form, { onLook, onStack, onDraw, onError }) {
    Object.assign(this, { form, onLook, onStack, onDraw, onError });
    this.plies = [];
    this.id = '';
    element('ply-add').addEventListener('click', () =>
      this.#set([...this.plies, this.#fromForm()]),
    );
    element('ply-mirror').addEventListener('click', () => this.#set(mirrored(this.plies)));
    element('stack-drape').addEventListener('click', () => this.run());
    for (const id of ['stack-cavity', 'stack-height', 'stack-nominal', 'stack-other'])
      element(id).addEventListener('change', () => this.#set(this.plies));
    element('stack-width').addEventListener('change', () => this.#offer());
    this.#set([]);
  }

  /** The stack as a request for a laminate has it, but for its surface. */
  get members() {
    const plies = this.plies.map(plyOfRow);
    return { length_unit: this.form.unit, ...this.#whole(), plies };
  }

  /** Puts that of another request into the table. */
  load({ plies = [], cavity = 'flexible', offset, side } = {}) {
    const [[kind, value]] = typeof cavity === 'string' ? [[cavity, '']] : Object.entries(cavity);
    element('stack-cavity').value = kind;
    element('stack-height').value = value;
    element('stack-nominal').checked = offset === 'nominal';
    element('stack-other').checked = side === -1;
    this.#set(plies.map(rowOf));
  }

  /** The same of a laminate that is there, with what became of its plies. */
  async open(id, request) {
    this.load(request);
    this.#take(id, (await read(`v1/laminates/${id}`)).plies);
  }

  /** Another part: none of the plies is draped on it. */
  forget() {
    this.#set(this.plies);
  }

  #fromForm() {
    const own = plyOf(this.form.settings());
    const angle = own.direction?.angle_deg;
    const name = `ply ${this.plies.length + 1}`;
    const rest = { repeat: '', law: '', boundary: '' };
    return { name, angle: angle === undefined ? null : angle, own, ...rest };
  }

  /** What is said of the stack as a whole. */
  #whole() {
    const kind = element('stack-cavity').value;
    const value = numberOf(element('stack-height').value);
    return {
      cavity: kind === 'flexible' ? kind : { [kind]: value },
      offset: element('stack-nominal').checked ? 'nominal' : 'none',
      side: element('stack-other').checked ? -1 : 1,
      rosette: this.form.rosette,
    };
  }

  /** Another order or other plies: what was draped is no longer of these. */
  #set(plies) {
    const kept = ['name', 'angle', 'own', 'repeat', 'law', 'boundary', 'open'];
    this.plies = plies.map((ply) => Object.fromEntries(kept.map((key) => [key, ply[key]])));
    this.id = '';
    element('stack-state').textContent = '';
    element('stack-height').hidden = element('stack-cavity').value === 'flexible';
    this.#fill();
    this.#offer();
    this.onStack(null);
  }

  #fill() {
    element('plies').replaceChildren(...this.plies.map((ply, k) => this.#row(ply, k)));
    for (const id of ['ply-mirror', 'stack-drape'])
      element(id).disabled = !this.plies.length || Boolean(token.link);
  }

  #row(ply, k) {
    const item = document.createElement('li');
    const field = (label, value, take) => {
      const input = Object.assign(document.createElement('input'), { value });
      input.setAttribute('aria-label', `${label} of ply ${k + 1}`);
      input.disabled = Boolean(token.link);
      input.addEventListener('change', () => take(input.value));
      return input;
    };
    const angle = field('Direction in degrees', ply.angle ?? 'vector', (text) => {
      const number = numberOf(text);
      if (Number.isFinite(number)) ply.angle = number;
      this.#set(this.plies);
    });
    const move = (to) => {
      const plies = [...this.plies];
      plies.splice(to, 0, ...plies.splice(k, 1));
      this.#set(plies);
    };
    const copy = () => this.#set([...this.plies.slice(0, k + 1), ply, ...this.plies.slice(k + 1)]);
    const drop = () => this.#set(this.plies.filter((_, other) => other !== k));
    item.append(
      field('Name', ply.name, (text) => (ply.name = text)),
      angle,
      this.#button('Copy', 'copy', k, copy),
      this.#button('↑', 'up', k, () => k > 0 && move(k - 1), k - 1),
      this.#button('↓', 'down', k, () => move(k + 1), k + 1),
      this.#button('✕', 'delete', k, drop),
      this.#more(ply, k, field),
      ...this.#outcome(ply, k),
    );
    return item;
  }

  /** What most plies do without. */
  #more(ply, k, field) {
    const more = document.createElement('details');
    const list = [
      ['Layers', 'repeat', '1'],
      ['Compaction a, b', 'law', 'none'],
      [`Boundary x y z; ... (${this.form.unit})`, 'boundary', 'the whole part'],
    ];
    const rows = list.map(([text, key, placeholder]) => {
      const label = document.createElement('label');
      const input = field(text, ply[key], (value) => {
        ply[key] = value;
        this.#set(this.plies);
        element('plies').children[k]?.querySelector(`[data-key="${key}"]`)?.focus();
      });
      input.dataset.key = key;
      input.placeholder = placeholder;
      label.append(text, input);
      return label;
    });
    const summary = Object.assign(document.createElement('summary'), { textContent: 'More' });
    const draw = this.#button('Draw', 'draw', k, () =>
      this.onDraw((points) => {
        ply.boundary = textOf(points);
        this.#set(this.plies);
      }),
    );
    draw.title = 'The boundary, by clicks on the part';
    more.append(summary, ...rows, draw);
    more.open = Boolean(ply.open);
    // Not when it has been toggled, which is told later: the list may be drawn anew before.
    summary.addEventListener('click', () => (ply.open = !more.open));
    return more;
  }

  /** A link to save what the service writes of the stack. */
  #link(text, path, name) {
    const link = Object.assign(document.createElement('a'), {
      href: address(path),
      download: name,
      textContent: text,
    });
    // Fetched, so that a refusal is words on the page and no file.
    link.addEventListener('click', (event) => {
      event.preventDefault();
      read(path, 'blob').then((blob) => saveAs(blob, name), this.onError);
    });
    return link;
  }

  /** Of a stack that is draped: its patterns on a roll, and its ply book. */
  #offer() {
    const width = numberOf(element('stack-width').value);
    const roll = width > 0 ? `&width=${width}` : '';
    const path = `v1/laminates/${this.id}`;
    element('stack-roll').hidden = !this.id;
    element('stack-links').replaceChildren(
      this.#link('Patterns SVG', `${path}/patterns?format=svg${roll}`, 'patterns.svg'),
      this.#link('Patterns DXF', `${path}/patterns?format=dxf${roll}`, 'patterns.dxf'),
      this.#link('Patterns ASTM', `${path}/patterns?format=astm${roll}`, 'patterns-astm.dxf'),
      this.#link('Laser lines', `${path}/laser?format=laser`, 'laser.json'),
      this.#link('All as zip', `${path}/bundle.zip?format=bundle${roll}`, 'laminate.zip'),
      this.#link('Ply book', `${path}/report?format=html${roll}`, 'plies.html'),
    );
  }

  /** The focus goes on to what was moved. */
  #button(text, what, k, act, to = k) {
    const button = Object.assign(document.createElement('button'), {
      type: 'button',
      textContent: text,
    });
    button.dataset.do = what;
    button.setAttribute('aria-label', `${what} ply ${k + 1}`);
    button.hidden = Boolean(token.link) && what !== 'look';
    button.addEventListener('click', () => {
      act();
      const row = Math.min(Math.max(to, 0), this.plies.length - 1);
      element('plies').children[row]?.querySelector(`[data-do="${what}"]`)?.focus();
    });
    return button;
  }

  /** Of a ply that was draped: to look at it, and its pattern; or why it was not. */
  #outcome(ply, k) {
    if (ply.error)
      return [
        Object.assign(document.createElement('p'), { className: 'fault', textContent: ply.error }),
      ];
    if (!ply.id) return [];
    const look = this.#button('Look', 'look', k, () => this.onLook(ply.id, ply));
    look.setAttribute('aria-pressed', String(ply.id === this.shown));
    const path = `v1/laminates/${this.id}/plies/${k}/pattern?format=dxf`;
    return [look, this.#link('Pattern DXF', path, `${fileName(`${k + 1} ${ply.name}`)}.dxf`)];
  }

  /** The drape that is shown. */
  mark(id) {
    this.shown = id;
    element('plies')
      .querySelectorAll('[data-do="look"]')
      .forEach((button) => {
        const row = [...element('plies').children].indexOf(button.closest('li'));
        button.setAttribute('aria-pressed', String(this.plies[row].id === id));
      });
  }

  /** Drapes it, and looks at its first ply, if it is to. */
  async run(looks = true) {
    if (this.running) return;
    this.running = true;
    element('fault-stack').textContent = '';
    const { plies } = this;
    try {
      this.form.check();
      const members = JSON.stringify(this.members);
      const body = `{"surface":${this.form.surfaceText},${members.slice(1)}`;
      const { id } = await submitLaminate(body);
      const say = (status) =>
        status &&
        (element('stack-state').textContent =
          `${status.status}, ${Math.round(100 * status.progress)} %`);
      const last = await follow(id, say, undefined, 'laminates');
      const outcomes = last.plies || (await read(`v1/laminates/${id}`)).plies;
      if (this.plies === plies) {
        this.#take(id, outcomes);
        const first = this.plies.find((ply) => ply.id);
        if (first && looks) this.onLook(first.id, first);
      }
    } catch (error) {
      element('fault-stack').textContent = explain(error);
      if (error.status === 401) this.onError(error);
    }
    this.running = false;
  }

  #take(id, outcomes) {
    this.id = id;
    this.plies.forEach((ply, k) => {
      const { id: drape, status, error } = outcomes[k];
      Object.assign(ply, status === 'succeeded' ? { id: drape, error: '' } : { id: '' });
      if (status !== 'succeeded') ply.error = error?.detail || status;
    });
    const done = this.plies.filter((ply) => ply.id).length;
    element('stack-state').textContent =
      `${done} of ${this.plies.length} plies are draped, ` +
      `${new Set(this.plies.map((ply) => ply.id)).size} of them different.`;
    this.#fill();
    if (done) this.#offer();
    this.onStack(done ? id : null);
  }
}
