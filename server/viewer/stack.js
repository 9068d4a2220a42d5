// SPDX-License-Identifier: MIT
// A laminate: a table of plies, draped together, and looked through one after the other.
import { address, explain, follow, read, submitLaminate, token } from './api.js';
import { element } from './dom.js';
import { fileName, saveAs } from './links.js';

const OWN = ['fabric', 'start', 'direction', 'generators', 'method', 'yarn_path', 'permeability'];

/** What of a drape's settings is a ply's own. */
export const plyOf = (settings) => Object.fromEntries(OWN.map((key) => [key, settings[key]]));

/** The plies of a stack and those that mirror them, the last one outside. */
export const mirrored = (plies) => [...plies, ...[...plies].reverse().map((ply) => ({ ...ply }))];

/** The request for a laminate; `surface` is JSON text. A ply is {name, angle, own}. */
export function requestOf(surface, unit, plies) {
  const rows = plies.map(({ name, angle, own }) => ({
    ...own,
    name,
    ...(angle === null ? {} : { direction: { angle_deg: angle } }),
  }));
  return `{"surface":${surface},"length_unit":${JSON.stringify(unit)},"plies":${JSON.stringify(rows)}}`;
}

export class Stack {
  /** `onLook(id, ply)` to show a ply's drape, `onStack(id)` with a laminate that is draped, null
   *  when it no longer is what the table says. */
  constructor(form, { onLook, onStack, onError }) {
    Object.assign(this, { form, onLook, onStack, onError });
    this.plies = [];
    element('ply-add').addEventListener('click', () =>
      this.#set([...this.plies, this.#fromForm()]),
    );
    element('ply-mirror').addEventListener('click', () => this.#set(mirrored(this.plies)));
    element('stack-drape').addEventListener('click', () => this.#run());
    this.#set([]);
  }

  #fromForm() {
    const own = plyOf(this.form.settings());
    const angle = own.direction?.angle_deg;
    return { name: `ply ${this.plies.length + 1}`, angle: angle === undefined ? null : angle, own };
  }

  /** Another order or other plies: what was draped is no longer of these. */
  #set(plies) {
    this.plies = plies.map(({ name, angle, own }) => ({ name, angle, own }));
    this.#fill();
    this.onStack(null);
  }

  #fill() {
    element('plies').replaceChildren(...this.plies.map((ply, k) => this.#row(ply, k)));
    for (const id of ['ply-mirror', 'stack-drape']) element(id).disabled = !this.plies.length;
  }

  #row(ply, k) {
    const item = document.createElement('li');
    const field = (label, value, take) => {
      const input = Object.assign(document.createElement('input'), { value });
      input.setAttribute('aria-label', `${label} of ply ${k + 1}`);
      input.addEventListener('change', () => take(input.value));
      return input;
    };
    const angle = field('Direction in degrees', ply.angle ?? 'vector', (text) => {
      const number = Number(text.replace('−', '-'));
      if (text.trim() && Number.isFinite(number)) ply.angle = number;
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
      ...this.#outcome(ply, k),
    );
    return item;
  }

  /** The focus goes on to what was moved. */
  #button(text, what, k, act, to = k) {
    const button = Object.assign(document.createElement('button'), {
      type: 'button',
      textContent: text,
    });
    button.dataset.do = what;
    button.setAttribute('aria-label', `${what} ply ${k + 1}`);
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
    const name = `${fileName(`${k + 1} ${ply.name}`)}.dxf`;
    const link = Object.assign(document.createElement('a'), {
      href: address(path),
      download: name,
      textContent: 'Pattern DXF',
    });
    link.addEventListener('click', (event) => {
      if (!token.get()) return;
      event.preventDefault();
      read(path, 'blob').then((blob) => saveAs(blob, name), this.onError);
    });
    return [look, link];
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

  async #run() {
    if (this.running) return;
    this.running = true;
    element('fault-stack').textContent = '';
    const { plies } = this;
    try {
      const body = requestOf(this.form.surfaceText, this.form.unit, plies);
      const { id } = await submitLaminate(body);
      const say = (status) =>
        status &&
        (element('stack-state').textContent =
          `${status.status}, ${Math.round(100 * status.progress)} %`);
      const last = await follow(id, say, undefined, 'laminates');
      if (this.plies === plies)
        this.#take(id, last.plies || (await read(`v1/laminates/${id}`)).plies);
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
    this.onStack(done ? id : null);
    const first = this.plies.find((ply) => ply.id);
    if (first) this.onLook(first.id, first);
  }
}
