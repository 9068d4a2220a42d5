// SPDX-License-Identifier: MIT
// A button that runs a study and stops it, with how it goes beside it.
import { cancel, explain } from './api.js';
import { element } from './dom.js';
import { runStudy } from './study.js';

export class Search {
  /** `button` and `state` are ids; `study()` gives the study's request, `onFound(result, id)` tells what
   *  to say of its result; `onError` is for what is not the study's own fault. */
  constructor({ button, state, study, onFound, onError }) {
    Object.assign(this, {
      button: element(button),
      state: element(state),
      study,
      onFound,
      onError,
    });
    this.text = this.button.textContent;
    this.button.addEventListener('click', () => (this.running ? this.stop() : this.#run()));
  }

  say(text) {
    this.state.textContent = text;
  }

  /** Nothing of a study that runs is wanted. */
  stop() {
    if (this.id) cancel(this.id, 'studies').catch(() => {});
    this.running?.abort();
  }

  async #run() {
    const controller = new AbortController();
    this.running = controller;
    this.button.textContent = 'Stop';
    this.say('');
    try {
      const result = await runStudy(this.study(), (it) => this.#progress(it), controller.signal);
      if (result) this.say(await this.onFound(result, this.id));
    } catch (error) {
      if (error.name !== 'AbortError') this.say(explain(error));
      if (error.status === 401) this.onError(error);
    }
    if (this.running !== controller) return;
    this.running = this.id = null;
    this.button.textContent = this.text;
  }

  #progress(status) {
    if (!status) return;
    this.id = status.id;
    this.say(`${status.status}, ${Math.round(100 * status.progress)} %`);
  }
}
