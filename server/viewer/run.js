// SPDX-License-Identifier: MIT
// Draping: at the press of the button with progress and cancel, and live while something is
// dragged.
import * as api from './api.js';
import { element, say } from './dom.js';
import { fetchDrape } from './drape.js';
import { readNet } from './work.js';

const LIVE_CELLS = 12000; // a drape this large answers while one drags
const LIVE_MOST = 20 * LIVE_CELLS; // a larger one is run with its progress when one lets go
const LIVE_SECONDS = 20;
const TOO_LONG = 'This takes too long to follow the pointer; press Drape.';

export class Runner {
  /** `onDrape(drape, passing)` with what is to be shown, `onError`, `onEnd` after a run. */
  constructor(form, { onDrape, onError, onEnd }) {
    Object.assign(this, { form, onDrape, onError, onEnd });
    this.busy = null; // AbortController of the run
    this.running = null; // its drape
    this.cells = 0; // of the drape that is shown, at the spacing of the form
    this.age = 0; // of the surface
  }

  /** The surface is another one: what is still under way is not to be shown. */
  forget() {
    this.age++;
    this.cells = 0;
    this.wanted = null;
  }

  #setBusy(controller) {
    this.busy = controller;
    element('drape').disabled = Boolean(controller);
    element('cancel').disabled = !controller;
    if (!controller) element('progress').value = 0;
  }

  #show(drape, age, passing = false) {
    if (age !== this.age) return say('The drape of the surface before is among the earlier ones.');
    if (!passing) this.cells = drape.lattice.columns['cells.i'].length;
    return this.onDrape(drape, passing);
  }

  /** Submits the form and follows the drape to its end. */
  async run() {
    const controller = new AbortController();
    this.form.clearErrors();
    this.#setBusy(controller);
    say('Sending …');
    try {
      await this.#runOnce(controller.signal);
    } catch (error) {
      say('');
      this.onError(error);
    }
    this.running = null;
    this.#setBusy(null);
    this.onEnd();
  }

  async #runOnce(signal) {
    const { age } = this;
    const { spacing } = this.form;
    const { id } = await api.submit(this.form.body(), signal);
    this.running = id;
    const last = await api.follow(id, showProgress, signal);
    if (last.status === 'failed') throw new api.Problem(last.error.status, last.error);
    if (last.status === 'cancelled') return say('Cancelled.');
    say('Fetching the net …');
    return this.#show({ ...(await fetchDrape(id, last, signal)), spacing }, age);
  }

  async cancel() {
    if (!this.running) return this.busy?.abort();
    element('cancel').disabled = true;
    return api.cancel(this.running).catch(this.onError);
  }

  /** Drapes what the form says while it changes: one call at a time, the last state always; the
   *  drapes on the way are deleted. */
  async live(settled) {
    this.wanted = { settled: settled || Boolean(this.wanted?.settled) };
    if (!this.cells || this.busy || this.living) return;
    this.living = true;
    try {
      while (this.wanted) {
        const final = this.wanted.settled;
        this.wanted = null;
        await (final && this.cells > LIVE_MOST ? this.run() : this.#liveOnce(final));
      }
    } catch (error) {
      this.onError(error);
    }
    this.wanted = null;
    this.living = false;
  }

  async #liveOnce(final) {
    const { age } = this;
    const begun = performance.now();
    const coarser = final ? 1 : Math.max(1, Math.sqrt(this.cells / LIVE_CELLS));
    const spacing = this.form.spacing.map((value) => value * coarser);
    this.form.clearErrors();
    const { id, columns } = await api.drapeNow(this.form.body(coarser), LIVE_SECONDS);
    this.#forgetPassing(final ? null : id);
    if (!columns) throw new api.Problem(0, { detail: TOO_LONG });
    const lattice = await readNet(columns);
    const summary = final ? (await api.status(id)).summary : null;
    this.#show({ id: final ? id : null, lattice, summary, spacing }, age, !final);
    const cells = lattice.columns['cells.i'].length.toLocaleString('en');
    say(`${cells} cells in ${(performance.now() - begun).toFixed(0)} ms`);
    if (final) this.onEnd();
  }

  /** Deletes the drape that was shown on the way, now that there is another. */
  #forgetPassing(id) {
    if (this.passing) api.remove(this.passing).catch(() => {});
    this.passing = id;
  }
}

function showProgress(status) {
  if (!status) {
    say('The service does not answer; trying again …');
    return;
  }
  element('progress').value = status.progress;
  const part = status.status === 'running' ? ` ${Math.round(100 * status.progress)} %` : '';
  say(`${status.status}${part}${status.attempts > 1 ? `, attempt ${status.attempts}` : ''}`);
}
