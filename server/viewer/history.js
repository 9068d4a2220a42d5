// SPDX-License-Identifier: MIT
// What is drawn on the part, before and after each change of it: undo and redo.
import { element } from './dom.js';

const WRITES = 'input:not([type="checkbox"], [type="radio"], [type="range"]), textarea, select';

export class History {
  /** `read()`: the state, which is never changed but replaced; `write(state)` puts one back. */
  constructor({ read, write }) {
    Object.assign(this, { read, write });
    this.clear();
    element('undo').addEventListener('click', () => this.#go(this.past, this.future));
    element('redo').addEventListener('click', () => this.#go(this.future, this.past));
    document.addEventListener('keydown', (event) => this.#key(event));
  }

  #key(event) {
    const { ctrlKey, metaKey, shiftKey, target } = event;
    const key = event.key.toLowerCase();
    if (!(ctrlKey || metaKey) || !['z', 'y'].includes(key) || target.matches?.(WRITES)) return;
    event.preventDefault();
    if (key === 'y' || shiftKey) this.#go(this.future, this.past);
    else this.#go(this.past, this.future);
  }

  /** Another request is in the form. */
  clear() {
    this.past = [];
    this.future = [];
    this.#offer();
  }

  /** The state is about to be replaced. */
  note(before = this.read()) {
    this.past.push(before);
    this.future = [];
    this.#offer();
  }

  #go(from, to) {
    if (!from.length) return;
    to.push(this.read());
    this.write(from.pop());
    this.#offer();
  }

  #offer() {
    element('undo').disabled = !this.past.length;
    element('redo').disabled = !this.future.length;
  }
}
