// SPDX-License-Identifier: MIT
// Cuts that a study proposes: drawn over the part as ghosts, to be taken or not.
import { cancel, explain, read } from './api.js';
import { element } from './dom.js';
import { format } from './fields.js';
import { runStudy } from './study.js';
import { away } from './tracing.js';

const NONE = 'No cut is proposed: the drape keeps its limits without any.';

const lengthOf = (path) => path.slice(1).reduce((sum, end, k) => sum + away(path[k], end), 0);

export class Proposals {
  /** `cuts`: the lines that take what is accepted; `onError` for what is not the study's own fault. */
  constructor(view, form, cuts, { onError }) {
    Object.assign(this, { view, form, cuts, onError });
    element('propose').addEventListener('click', () => (this.running ? this.#stop() : this.#run()));
    element('proposed-all').addEventListener('click', () => this.#take(this.ghosts));
    element('proposed-none').addEventListener('click', () => this.clear());
    this.clear();
  }

  /** Another part, or nothing of it is wanted. */
  clear() {
    this.#stop();
    this.ghosts = []; // {path, name}
    this.#say('');
    this.#fill();
  }

  #say(text) {
    element('propose-state').textContent = text;
  }

  #stop() {
    if (this.id) cancel(this.id, 'studies').catch(() => {});
    this.running?.abort();
  }

  async #run() {
    this.clear();
    const controller = new AbortController();
    this.running = controller;
    element('propose').textContent = 'Stop';
    try {
      this.form.check();
      const study = `{"drape":${this.form.body()},"vary":{"splits":"proposed"}}`;
      const result = await runStudy(study, (status) => this.#progress(status), controller.signal);
      if (result) await this.#show(result);
    } catch (error) {
      if (error.name !== 'AbortError') this.#say(explain(error));
      if (error.status === 401) this.onError(error);
    }
    if (this.running !== controller) return;
    this.running = this.id = null;
    element('propose').textContent = 'Propose cuts';
  }

  #progress(status) {
    if (!status) return;
    this.id = status.id;
    this.#say(`${status.status}, ${Math.round(100 * status.progress)} %`);
  }

  /** The cuts of the best variant that the request has not yet. */
  async #show({ best, variants, summary }) {
    const row = Object.values(best)[0];
    if (!(row >= 0)) return this.#say(summary.verdict.detail);
    const { cuts = [] } = await read(`v1/studies/${this.id}/variants/${row}/request`);
    this.ghosts = cuts.slice(this.form.cuts.length);
    const [shear, covered] = ['max_shear_deg', 'cloth_coverage'].map((key) => variants[key]?.[row]);
    this.#say(
      this.ghosts.length
        ? `With all of these: shear up to ${format(shear, 3)}°, ${format(100 * covered, 4)} % covered.`
        : NONE,
    );
    this.#fill();
  }

  #take(ghosts) {
    this.ghosts = this.ghosts.filter((ghost) => !ghosts.includes(ghost));
    this.cuts.set([...this.cuts.lines, ...ghosts]);
    this.#fill();
  }

  #fill() {
    element('proposed').hidden = !this.ghosts.length;
    const rows = this.ghosts.map((ghost) => {
      const item = document.createElement('li');
      const take = Object.assign(document.createElement('button'), { type: 'button' });
      take.textContent = `Take ${ghost.name}, ${format(lengthOf(ghost.path), 3)} ${this.form.unit}`;
      take.addEventListener('click', () => this.#take([ghost]));
      item.append(take);
      return item;
    });
    element('proposed-list').replaceChildren(...rows);
    this.view.stage?.redraw();
  }

  /** Draws the ghosts; `project(point)` gives pixels. */
  draw(project) {
    const text = ({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`;
    const drawn = this.ghosts.map(({ path }) => `M${path.map(project).map(text).join(' ')}`);
    element('proposed-lines').setAttribute('d', drawn.join(''));
  }
}
