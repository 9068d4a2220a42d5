// SPDX-License-Identifier: MIT
// Cuts that a study proposes: drawn over the part as ghosts, to be taken or not.
import { read } from './api.js';
import { element } from './dom.js';
import { format } from './fields.js';
import { Search } from './search.js';
import { away } from './tracing.js';

const NONE = 'No cut is proposed: the drape keeps its limits without any.';

const lengthOf = (path) => path.slice(1).reduce((sum, end, k) => sum + away(path[k], end), 0);

export class Proposals {
  /** `cuts`: the lines that take what is accepted; `onError` for what is not the study's own fault. */
  constructor(view, form, cuts, { onError }) {
    Object.assign(this, { view, form, cuts });
    this.search = new Search({
      button: 'propose',
      state: 'propose-state',
      study: () => this.#study(),
      onFound: (result, id) => this.#show(result, id),
      onError,
    });
    element('proposed-all').addEventListener('click', () => this.#take(this.ghosts));
    element('proposed-none').addEventListener('click', () => this.clear());
    this.clear();
  }

  /** Another part, or nothing of it is wanted. */
  clear() {
    this.search.stop();
    this.search.say('');
    this.#offer([]);
  }

  #offer(ghosts) {
    this.ghosts = ghosts; // {path, name}
    this.#fill();
  }

  #study() {
    this.#offer([]);
    this.form.check();
    return `{"drape":${this.form.body()},"vary":{"splits":"proposed"}}`;
  }

  /** The cuts of the best variant that the request has not yet. */
  async #show({ best, variants, summary }, id) {
    const row = Object.values(best)[0];
    if (!(row >= 0)) return summary.verdict.detail;
    const { cuts = [] } = await read(`v1/studies/${id}/variants/${row}/request`);
    this.#offer(cuts.slice(this.form.cuts.length));
    const [shear, covered] = ['max_shear_deg', 'cloth_coverage'].map((key) => variants[key]?.[row]);
    return this.ghosts.length
      ? `With all of these: shear up to ${format(shear, 3)}°, ${format(100 * covered, 4)} % covered.`
      : NONE;
  }

  #take(ghosts) {
    const left = this.ghosts.filter((ghost) => !ghosts.includes(ghost));
    this.cuts.set([...this.cuts.lines, ...ghosts]);
    this.#offer(left);
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
