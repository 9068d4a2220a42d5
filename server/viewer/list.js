// SPDX-License-Identifier: MIT
// The earlier drapes of the service: to open again, to compare with, to delete.
import { list, remove, token } from './api.js';

const SHOWN = 30;

function button(text, label, onClick, kind = '') {
  const node = Object.assign(document.createElement('button'), {
    type: 'button',
    textContent: text,
    className: kind,
  });
  node.setAttribute('aria-label', label);
  node.addEventListener('click', onClick);
  return node;
}

/** Names of drapes, as far as this browser has shown them. */
const NAMES = 'draped-names';
const NAMES_MOST = 200;

function readNames() {
  try {
    return JSON.parse(localStorage.getItem(NAMES)) || {};
  } catch {
    return {};
  }
}

function describe({ id, status, summary, created }, names) {
  const at = new Date(created).toLocaleString([], { dateStyle: 'short', timeStyle: 'medium' });
  const time = names[id] ? `${names[id]}\n${at}` : at;
  if (!summary) return `${time}\n${status}`;
  const { cells, max_shear_deg } = summary;
  return `${time}\n${cells.toLocaleString('en')} cells, up to ${max_shear_deg.toFixed(1)}°`;
}

export class Drapes {
  constructor(element, { isHidden, onOpen, onCompare, onError }) {
    Object.assign(this, { element, isHidden, onOpen, onCompare, onError, current: null });
  }

  /** Keeps what a drape is called in this browser; the oldest names are dropped. */
  name(id, text) {
    const others = Object.entries(readNames()).filter(([key]) => key !== id);
    const kept = Object.fromEntries([...others, [id, text]].slice(-NAMES_MOST));
    try {
      localStorage.setItem(NAMES, JSON.stringify(kept));
    } catch {
      // a browser that keeps nothing: drapes are told apart by their time
    }
  }

  #row(drape, names) {
    const item = document.createElement('li');
    const text = describe(drape, names);
    const done = drape.status === 'succeeded';
    const open = button(text, `Open the drape of ${text}`, () => this.onOpen(drape.id), 'open');
    const compare = button('Compare', `Compare with the drape of ${text}`, () =>
      this.onCompare(drape.id),
    );
    open.disabled = !done;
    compare.disabled = !done || drape.id === this.current;
    if (drape.id === this.current) item.setAttribute('aria-current', 'true');
    const drop = button('✕', `Delete the drape of ${text}`, () =>
      remove(drape.id).then(() => this.refresh(), this.onError),
    );
    item.append(open, compare, drop);
    return item;
  }

  /** Asks the service again; marks the drape that is shown. */
  async refresh(current = this.current) {
    this.current = current;
    if (token.link) return;
    try {
      const { drapes } = await list(SHOWN);
      const names = readNames();
      const rows = drapes
        .filter(({ id }) => !this.isHidden(id))
        .map((drape) => this.#row(drape, names));
      const none = Object.assign(document.createElement('li'), { textContent: 'None yet.' });
      this.element.replaceChildren(...(rows.length ? rows : [none]));
    } catch (error) {
      this.onError(error);
    }
  }
}
