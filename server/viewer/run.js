// SPDX-License-Identifier: MIT
// Draping: at the press of the button with progress and cancel, and live while something is
// dragged.
import * as api from './api.js';
import { element, say } from './dom.js';
import { fetchDrape, labelOf } from './drape.js';
import { readNet } from './work.js';

const LIVE_CELLS = 8000; // a drape this large answers while one drags
const LIVE_MOST = 30 * LIVE_CELLS; // a larger one is run with its progress when one lets go
const LIVE_SECONDS = 20;
const REST_MS = 400; // after which the drapes on the way are deleted
const TOO_LONG = 'This takes too long to follow the pointer; press Drape.';

export class Runner {
  /** `onDrape(drape, passing)` with what is to be shown, `onError`, `onEnd` after a run,
   *  `onSettled` when nothing is dragged any more;
   *  `columnsOnTheWay(names)`: those of a result that are shown while one drags. */
  constructor(form, { onDrape, onError, onEnd, onSettled, columnsOnTheWay }) {
    Object.assign(this, { form, onDrape, onError, onEnd, onSettled, columnsOnTheWay });
    this.busy = null; // AbortController of the run
    this.running = null; // its drape
    this.asked = null; // the request that is under way to be shown for good
    this.net = null; // of the drape that is shown: its area, its columns, the request's kind
    this.age = 0; // of the surface
    this.passing = []; // drapes on the way, to be deleted
    addEventListener('pagehide', () => this.#deletePassing(true));
  }

  /** The surface is another one: what is still under way is not to be shown. */
  forget() {
    this.age++;
    this.net = null;
    this.wanted = null;
  }

  /** This drape is shown, the answer to a request of that kind; what is dragged now drapes it anew. */
  follow({ lattice, spacing }, kind = this.form.kind) {
    const { columns } = lattice;
    const area = columns['cells.i'].length * spacing[0] * spacing[1];
    this.net = { area, names: Object.keys(columns), kind };
  }

  /** About how many cells there will be at the spacing of the form. */
  get #cells() {
    const [warp, weft] = this.form.spacing;
    return this.net.area / (warp * weft);
  }

  /** Buttons that do nothing now are not disabled: the focus would be lost. */
  #setBusy(controller) {
    this.busy = controller;
    element('drape').setAttribute('aria-disabled', String(Boolean(controller)));
    element('cancel').setAttribute('aria-disabled', String(!controller));
    if (!controller) element('progress').value = 0;
  }

  #show(drape, { age, kind, passing = false }) {
    if (age !== this.age)
      return say('The drape of the previous surface is in the list of earlier drapes.');
    if (!passing) this.follow(drape, kind);
    return this.onDrape(drape, passing);
  }

  /** Submits the form and follows the drape to its end. */
  async run() {
    if (this.busy || api.token.link || this.asked === this.form.body()) return;
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
    this.asked = null;
    this.#setBusy(null);
    this.onEnd();
  }

  async #runOnce(signal) {
    this.form.check();
    const { age } = this;
    const { spacing, kind, slide } = this.form;
    const label = labelOf(this.form.settings());
    const body = this.form.body();
    this.asked = body;
    const { id } = await api.submit(body, signal);
    this.running = id;
    const last = await api.follow(id, showProgress, signal);
    if (last.status === 'failed') throw new api.Problem(last.error.status, last.error);
    if (last.status === 'cancelled') return say('Cancelled.');
    say('Fetching the net …');
    const drape = await fetchDrape(id, last, signal);
    return this.#show({ ...drape, spacing, slide, label, body }, { age, kind });
  }

  async cancel() {
    if (!this.running) return this.busy?.abort();
    element('cancel').setAttribute('aria-disabled', 'true');
    return api.cancel(this.running).catch(this.onError);
  }

  /** Drapes what the form says while it changes: one call at a time, the last state always; the
   *  drapes on the way are deleted. */
  async live(settled) {
    this.wanted = { settled: settled || Boolean(this.wanted?.settled) };
    if (!this.net || this.busy || this.living || api.token.link) return;
    this.living = true;
    clearTimeout(this.rest);
    try {
      while (this.wanted) {
        const final = this.wanted.settled;
        this.wanted = null;
        if (final && this.asked === this.form.body()) continue;
        await (final && this.#cells > LIVE_MOST ? this.run() : this.#liveOnce(final));
      }
    } catch (error) {
      this.onError(error);
    }
    this.wanted = null;
    this.living = false;
    this.asked = null;
    this.onSettled();
    this.rest = setTimeout(() => this.#deletePassing(), REST_MS);
  }

  async #liveOnce(final) {
    this.form.check();
    const { age } = this;
    const { kind, slide } = this.form;
    const label = labelOf(this.form.settings());
    const begun = performance.now();
    const coarser = final ? 1 : Math.max(1, Math.sqrt(this.#cells / LIVE_CELLS));
    const spacing = this.form.spacing.map((value) => value * coarser);
    const same = kind === this.net.kind; // otherwise other columns may come
    const names = final || !same ? null : this.columnsOnTheWay(this.net.names);
    this.form.clearErrors();
    const body = this.form.body(coarser);
    if (final) this.asked = body;
    const { id, columns } = await api.drapeNow(body, LIVE_SECONDS, names);
    if (!final) this.passing.push(id);
    if (!columns) throw new api.Problem(0, { detail: TOO_LONG });
    const [lattice, state] = await Promise.all([readNet(columns), final && api.status(id)]);
    const told = { spacing, slide, label, body };
    const drape = { id: final ? id : null, lattice, summary: state?.summary, ...told };
    this.#show(drape, { age, kind, passing: !final });
    const cells = lattice.columns['cells.i'].length.toLocaleString('en');
    say(`${cells} cells in ${(performance.now() - begun).toFixed(0)} ms`);
    if (final) this.onEnd();
  }

  /** Deletes the drapes that were shown on the way, one after the other, until one drags again. */
  async #deletePassing(leaving = false) {
    if (!this.passing.length) return;
    while (this.passing.length && (leaving || !this.living)) {
      const call = api.remove(this.passing.at(-1), leaving).catch(() => {});
      if (!leaving) await call;
      this.passing.pop();
    }
    this.onEnd();
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
