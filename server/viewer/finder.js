// SPDX-License-Identifier: MIT
// "Find the best start": a study of the request, its map over the part, its plots, and each of its
// variants as a drape at a click.
import { cancel, explain, read } from './api.js';
import { drawScale } from './charts.js';
import { element } from './dom.js';
import { format, rangeOf, withUnit } from './fields.js';
import { numberOf, numbersOf } from './form.js';
import { drawFront, drawPolar } from './plots.js';
import {
  frontOf,
  keptRows,
  leastOf,
  objectiveOf,
  OBJECTIVES,
  requestOf,
  runStudy,
  startsOf,
} from './study.js';
import { readTiles } from './work.js';

const ASKED = ['find-starts', 'find-step', 'find-wanted'];
const LISTED = 5; // of the best starts
const COMPLETE = 0.999; // the share of the part that is covered in one piece, as of an outcome
const NOTHING = 1e30; // the value of a start that keeps no limit; grey

export class Finder {
  /** `onDrape(place)` with {uv, point, angle} to drape; `onEnd()` when there is another result, whose
   *  study has the id `done`; `current()`: the summary shown. */
  constructor(view, form, { onDrape, onEnd, onError, current }) {
    Object.assign(this, { view, form, onDrape, onEnd, onError, current });
    this.result = null;
    for (const id of ['find-objective', 'find-against'])
      element(id).replaceChildren(...OBJECTIVES.map(({ key, label }) => new Option(label, key)));
    element('find-against').value = 'waste_area';
    element('find').addEventListener('click', () => (this.running ? this.#stop() : this.#run()));
    element('find-map').addEventListener('click', () => this.show(!this.on));
    for (const id of ['find-objective', 'find-against', 'find-coverage', 'find-shear'])
      element(id).addEventListener('input', () => this.refresh());
    for (const id of ['find-starts', 'find-step'])
      element(id).addEventListener('input', () => this.#showCount());
    this.#showCount();
  }

  get #settings() {
    const number = (id) => numberOf(element(id).value);
    const optimise = element('find-optimise').checked;
    return {
      starts: number('find-starts'),
      step: number('find-step'),
      optimise,
      given: { ...this.form.given, wanted: numbersOf(element('find-wanted').value) },
    };
  }

  #showCount() {
    const { starts, step } = this.#settings;
    const count = starts * Math.round(180 / step);
    element('find-count').textContent =
      count > 0 && Number.isFinite(count) ? `${count.toLocaleString('en')} drapes.` : '';
  }

  /** Another part: what was found says nothing of it. */
  clear() {
    if (this.on) this.show(false);
    this.#stop();
    this.result = this.tiles = this.done = null;
    element('found').hidden = true;
    element('find-state').textContent = '';
  }

  /** What is asked and what was found, to be opened elsewhere by `load`. */
  get state() {
    const asked = Object.fromEntries(ASKED.map((id) => [id, element(id).value]));
    asked['find-optimise'] = element('find-optimise').checked;
    return { asked, result: this.result ?? undefined, ms: this.ms };
  }

  async load({ asked = {}, result, ms }) {
    for (const id of ASKED) if (id in asked) element(id).value = asked[id];
    element('find-optimise').checked = Boolean(asked['find-optimise']);
    this.#showCount();
    if (result) await this.#take(result, this.form.shape, ms);
  }

  /** Shows what a study has found that is there. */
  async open(id) {
    const path = `v1/studies/${id}`;
    const [{ started, finished }, result] = await Promise.all([
      read(path),
      read(`${path}/result?format=json`),
    ]);
    this.done = id;
    await this.#take(result, this.form.shape, new Date(finished) - new Date(started));
  }

  /* ---- running ---- */

  #stop() {
    if (this.id) cancel(this.id, 'studies').catch(() => {});
    this.running?.abort();
  }

  async #run() {
    const controller = new AbortController();
    this.running = controller;
    element('find').textContent = 'Stop';
    element('fault-find').textContent = '';
    const begun = performance.now();
    try {
      this.form.check();
      const body = requestOf(this.form.body(), this.#settings);
      const { shape } = this.form;
      const result = await runStudy(body, (status) => this.#progress(status), controller.signal);
      this.done = result ? this.id : null;
      if (result) await this.#take(result, shape, performance.now() - begun);
    } catch (error) {
      if (error.name !== 'AbortError') this.#fail(error);
    }
    this.running = this.id = null;
    element('find').textContent = 'Find the best start';
    element('find-progress').value = 0;
  }

  #fail(error) {
    element('fault-find').textContent = explain(error);
    if (error.status === 401) this.onError(error);
  }

  #progress(status) {
    if (!status) return;
    this.id = status.id;
    element('find-progress').value = status.progress;
    const key = element('find-objective').value;
    const least = status.best_so_far?.[key];
    const so = least === undefined ? '' : `, least so far ${this.#write(key, least)}`;
    element('find-state').textContent =
      `${status.status}, ${Math.round(100 * status.progress)} %${so}`;
  }

  async #take(result, shape, ms) {
    Object.assign(this, { result, ms });
    this.starts = startsOf(result.variants);
    this.shape = shape;
    this.chosen = -1;
    const places = this.starts.map(({ place }) => place);
    this.tiles = shape && (await readTiles(shape, places));
    const { variants, failed, coarse, verdict } = result.summary;
    element('find-state').textContent =
      `${variants.toLocaleString('en')} variants from ${places.length} starts in ` +
      `${format(ms / 1000, 3)} s${failed ? `; ${failed} of them failed` : ''}` +
      (coarse ? `; ${coarse} on a coarser net, only for the map` : '') +
      `: ${verdict.detail}`;
    element('found').hidden = false;
    this.#fitSliders();
    this.refresh();
    if (this.tiles) this.show(true);
    this.onEnd();
  }

  /** The sliders begin where nothing is left out. */
  #fitSliders() {
    const shear = this.result.variants.max_shear_deg.filter((value) => value !== null);
    const most = Math.ceil(rangeOf(shear)[1]);
    Object.assign(element('find-shear'), {
      max: most,
      min: Math.floor(rangeOf(shear)[0]),
      value: most,
    });
  }

  /* ---- what is shown ---- */

  #write(key, value) {
    return withUnit(format(value, 3), this.#unitOf(key));
  }

  #unitOf(key) {
    const { unit = '', power } = objectiveOf(key);
    return power ? `${this.form.unit}²` : unit;
  }

  /** After a change of the limits, the objective or the drape that is shown. */
  refresh() {
    if (!this.result) return;
    const { variants } = this.result;
    const limits = {
      coverage: Number(element('find-coverage').value) / 100,
      shear: Number(element('find-shear').value),
    };
    element('find-coverage-text').textContent = `${format(100 * limits.coverage, 4)} %`;
    element('find-shear-text').textContent = `${limits.shear}°`;
    for (const id of ['find-objective', 'find-against'])
      for (const option of element(id).options) option.disabled = !variants[option.value];
    this.key = element('find-objective').value;
    this.column = variants[this.key];
    this.limits = limits;
    this.kept = keptRows(variants, limits);
    this.best = this.starts.map(({ rows }) => leastOf(this.column, rows, this.kept));
    this.#fillTable();
    this.#draw();
    if (this.on) this.#colour();
  }

  /** The best, on the drape's own net alone: of each start, or of those that were refined. */
  #sortedBest() {
    const { coarseness } = this.result.variants;
    const fine = (row) => this.kept[row] && coarseness[row] < 1 + 1e-9;
    const rows = this.result.summary.coarse
      ? this.column.map((_, row) => row).filter(fine)
      : this.best.filter((row) => row >= 0);
    return rows.sort((a, b) => this.column[a] - this.column[b]);
  }

  /** Whether the drape that is shown keeps the limits that variants have to. */
  #currentKept() {
    const { cloth_coverage: covered, max_shear_deg: sheared } = this.current();
    return keptRows({ cloth_coverage: [covered], max_shear_deg: [sheared] }, this.limits)[0];
  }

  /** That a variant leaves some of the part bare. */
  #inPieces(row) {
    const covered = this.result.variants.cloth_coverage?.[row] ?? 1;
    return covered < COMPLETE ? `, not in one piece (${format(100 * covered, 4)} % covered)` : '';
  }

  /** What the best is compared with, the drape that is shown. */
  #besides(now, best) {
    if (now === undefined) return '';
    const shown = `; the drape that is shown: ${this.#write(this.key, now)}`;
    if (!this.#currentKept()) return `${shown}, which does not keep these limits`;
    return now < best * (1 - 1e-3)
      ? `${shown}, better than all variants: search from more starts`
      : shown;
  }

  #fillTable() {
    const { variants } = this.result;
    const sorted = this.#sortedBest();
    const now = this.current()?.[this.key];
    element('find-now').textContent = sorted.length
      ? `Best: ${this.#write(this.key, this.column[sorted[0]])}${this.#inPieces(sorted[0])}${this.#besides(now, this.column[sorted[0]])}.`
      : 'No variant keeps these limits: relax one of them.';
    const rows = sorted.slice(0, LISTED).map((row) => {
      const item = document.createElement('li');
      const button = Object.assign(document.createElement('button'), { type: 'button' });
      const covered = format(100 * variants.cloth_coverage[row], 4);
      button.textContent =
        `${this.#write(this.key, this.column[row])} at ${format(variants.angle_deg[row], 3)}°, ` +
        `${covered} % covered`;
      button.addEventListener('click', () => this.#drape(row));
      item.append(button);
      return item;
    });
    element('find-best').replaceChildren(...rows);
  }

  #draw() {
    const { variants } = this.result;
    const onPick = (row) => this.#drape(row);
    const byAngle = (rows) => {
      const angles = new Map();
      for (const row of rows.filter((one) => this.kept[one])) {
        const angle = Math.round(variants.angle_deg[row] * 1e6) / 1e6;
        const known = angles.get(angle);
        if (known === undefined || this.column[row] < this.column[known]) angles.set(angle, row);
      }
      const list = [...angles].map(([angle, row]) => ({ angle, row, value: this.column[row] }));
      return list.sort((a, b) => a.angle - b.angle);
    };
    const all = this.column.map((_, row) => row);
    const own = this.starts.find(({ rows }) => rows.includes(this.chosen))?.rows || [];
    const { label } = objectiveOf(this.key);
    drawPolar(element('find-polar'), { best: byAngle(all), here: byAngle(own), label, onPick });
    const against = element('find-against').value;
    const rows = variants[against] ? all.filter((row) => this.kept[row]) : [];
    const [first, second] = [this.key, against].map((key) => this.#scaled(key, rows));
    drawFront(element('find-front'), {
      rows,
      front: frontOf(first.values, second.values, rows),
      x: first.values,
      y: second.values,
      chosen: this.kept[this.chosen] ? this.chosen : -1,
      xLabel: first.label,
      yLabel: second.label,
      onPick,
    });
  }

  /** A column for an axis, in thousands or the like of its unit, and what is written there. */
  #scaled(key, rows) {
    const column = this.result.variants[key] || [];
    const { label, power } = objectiveOf(key);
    const most = Math.max(...rows.map((row) => Math.abs(column[row])), 0);
    const thousands = power && most > 0 ? 3 * Math.floor(Math.log10(most) / 3) : 0;
    const values = column.map((value) => value / 10 ** thousands);
    const factor = thousands ? `${format(10 ** thousands, 1).replace('1 × ', '')} ` : '';
    return { values, label: [label, factor + this.#unitOf(key)].filter(Boolean).join(', ') };
  }

  /** Shows the map over the part, or the net again. */
  show(on) {
    if (!this.tiles || (!on && !this.on)) return;
    const handlers = {
      onPick: (start) => start >= 0 && this.best[start] >= 0 && this.#drape(this.best[start]),
      onHover: (start) => this.#hover(start),
      onGone: () => this.#setOn(false),
    };
    this.view.setPatches(on ? this.tiles : null, handlers);
    this.#setOn(on);
    if (on) this.#colour();
  }

  #setOn(on) {
    this.on = on;
    element('find-map').setAttribute('aria-pressed', String(on));
    element('caption-solid').hidden = on;
    for (const id of ['caption-map', 'map-scale']) element(id).hidden = !on;
  }

  #colour() {
    const values = Float32Array.from(this.best, (row) => (row < 0 ? NOTHING : this.column[row]));
    const range = rangeOf(values.filter((value) => value < NOTHING));
    this.view.patches?.setValues(values, range, 'sequential');
    const [best] = this.#sortedBest();
    const isBest = ({ rows }) => rows.includes(best);
    this.view.setDots(this.starts.map((start) => ({ place: start.place, chosen: isBest(start) })));
    const { label } = objectiveOf(this.key);
    element('caption-map').textContent =
      `${label} in the best direction from each start (dot), the best of all in red`;
    const scale = { range, map: 'sequential', label, unit: this.#unitOf(this.key) };
    if (range[0] <= range[1]) drawScale(element('map-scale'), scale);
    else element('map-scale').replaceChildren();
  }

  #hover(start) {
    if (this.view.patches.hover(start)) this.view.stage.redraw();
    const chip = element('chip');
    const row = this.best[start] ?? -1;
    chip.hidden = start < 0;
    if (start < 0) return;
    chip.textContent =
      row < 0
        ? 'no direction from this start keeps the limits'
        : `best from this start: ${this.#write(this.key, this.column[row])}, at ${format(this.result.variants.angle_deg[row], 3)}°`;
  }

  #drape(row) {
    const { start_u: u, start_v: v, x, y, z, angle_deg: angle } = this.result.variants;
    this.chosen = row;
    this.#draw();
    const start = this.shape?.kind === 'nurbs' ? [u[row], v[row]] : [x[row], y[row], z[row]];
    this.onDrape({ start, angle: angle[row] });
  }
}
