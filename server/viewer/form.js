// SPDX-License-Identifier: MIT
// The request as a form: from a document into the fields and back, and errors of the service at the
// fields that their pointers name. What the form does not show is kept and sent along.
import { element } from './dom.js';
import { slideOf } from './drape.js';
import { Materials } from './material.js';

const DEFAULTS = { yarn_path: 'chord', cavity: 'flexible', permeability: null };
const FABRIC = {
  thickness: 'thickness',
  fraction: 'fiber_volume_fraction',
  locking: 'locking_angle_deg',
  kinematics: 'kinematics',
  limit: 'limit_curve',
};
const ROSETTE = ['origin', 'x', 'z'];
const MODELS = {
  kozeny_carman: { k1: 'k1', k2: 'k2', k3: 'k3', 'at-fraction': 'at_fiber_volume_fraction' },
  gebart: { radius: 'fiber_radius', packing: 'packing' },
};
const NO_FACE =
  'No face is chosen: click on those of the tool side in the picture, or take them from the list of ' +
  'faces, then try again.';
const SUGGESTED = { k1: '2e-10', k2: '1e-10', k3: '2e-11', 'at-fraction': '0.5', radius: '8e-6' };

/** One number of "8,5", two of "0.5,0.5", three of "1,2,3"; NaN where it may be either, as "1.5,2". */
function numbersOfWord(word) {
  const parts = word.split(',');
  const pointed = parts.filter((part) => part.includes('.')).length;
  if (parts.length === 2 && pointed === 0) return [Number(word.replace(',', '.'))];
  if (parts.length === 2 && pointed === 1) return [NaN];
  return parts.map((part) => (part ? Number(part) : NaN));
}

/** Numbers as one writes them, with a point or a comma, between blanks, semicolons, or commas with a
 *  blank: a decimal comma never makes two numbers of one. */
export const numbersOf = (text) =>
  text
    .replaceAll('−', '-')
    .split(/(?:\s*,\s+|\s+,\s*|[\s;]+)/)
    .map((word) => word.replace(/^,|,$/g, ''))
    .filter(Boolean)
    .flatMap(numbersOfWord);

/** The one number that a text is, or NaN. */
export function numberOf(text) {
  const numbers = numbersOf(text);
  return numbers.length === 1 ? numbers[0] : NaN;
}

/** A number, several as a list, or the text itself: the service then says what is wrong with it. */
function parse(text) {
  const numbers = numbersOf(text);
  if (!numbers.length || numbers.some(Number.isNaN)) return text;
  return numbers.length === 1 ? numbers[0] : numbers;
}

/** Of a field of the fabric, as the request has it. */
const FABRIC_OF_TEXT = {
  locking(text) {
    const value = parse(text);
    if (!Array.isArray(value) || value.length !== 2) return value;
    return { positive: value[0], negative: value[1] };
  },
  kinematics: (text) => (text === 'slide' ? { slide: parse(element('slide').value) } : text),
  limit(text) {
    const rows = text.split(/[;\n]/).filter((row) => row.trim());
    const of = (k) => rows.map((row) => numbersOf(row)[k] ?? NaN);
    const curve = { shear_deg: of(0), severity: of(1) };
    const good = rows.every((row) => numbersOf(row).length === 2);
    return good && ![...curve.shear_deg, ...curve.severity].some(Number.isNaN) ? curve : text;
  },
};

/** And as the field shows it. */
const TEXT_OF_FABRIC = {
  locking: (value) =>
    typeof value === 'object' ? `${value.positive}, ${value.negative}` : show(value),
  kinematics: (value) => (typeof value === 'object' ? 'slide' : show(value)),
  limit: (value) =>
    (value?.shear_deg ?? []).map((angle, k) => `${angle} ${value.severity[k]}`).join('; '),
};

const show = (value) => (value === undefined || value === null ? '' : [value].flat().join(', '));

/** A round spacing for a shape: some sixty cells across it, or across those of its faces that are
 *  chosen. */
function suggestSpacing({ size }) {
  const wanted = (Math.hypot(...size) || 1) / 60;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= wanted * 0.999);
  return Number((step * power).toPrecision(1));
}

/** Generators that are said once, of warp and of weft; where weft slides, of warp. */
const ofEach = (generators, fabric) =>
  typeof generators === 'string' || generators?.steered
    ? { warp: generators, ...(slideOf(fabric) ? {} : { weft: generators }) }
    : generators;

/** Without what the service fills in by itself. */
function withoutDefaults(settings) {
  const kept = { ...settings, fabric: { ...settings.fabric } };
  for (const [key, value] of Object.entries(DEFAULTS)) if (kept[key] === value) delete kept[key];
  if (kept.generators) kept.generators = ofEach(kept.generators, kept.fabric);
  const { warp = 'geodesic', weft = 'geodesic' } = kept.generators || {};
  if (warp === 'geodesic' && weft === 'geodesic') delete kept.generators;
  if (kept.fabric.kinematics === 'pin_jointed' && !kept.fabric.material)
    delete kept.fabric.kinematics;
  if (kept.fabric.pre_shear_deg === 0) delete kept.fabric.pre_shear_deg;
  if (kept.fabric.plies === 1) delete kept.fabric.plies;
  const { spacing } = kept.fabric;
  if (Array.isArray(spacing) && spacing[0] === spacing[1]) kept.fabric.spacing = spacing[0];
  return kept;
}

export class Form {
  /** `onLive` while a value is dragged, `onSettled` when it is let go, `onUnit` for a new unit;
   *  `isEmpty()`: of the faces of the surface none is chosen. */
  constructor({ onLive, onSettled, onUnit, isEmpty }) {
    this.root = element('request');
    this.kept = {};
    this.splits = [];
    this.surfaceText = null;
    this.shape = null;
    this.onUnit = onUnit;
    this.isEmpty = isEmpty;
    this.materials = new Materials();
    const slider = element('angle-slider');
    slider.addEventListener('input', () => {
      element('angle').value = slider.value;
      onLive();
    });
    slider.addEventListener('change', onSettled);
    element('angle').addEventListener('change', () => {
      this.#moveSlider();
      onSettled();
    });
    element('start').addEventListener('change', onSettled);
    element('spacing').addEventListener('input', () => (this.suggested = false));
    element('permeability').addEventListener('change', () => this.#showModel());
    element('kinematics').addEventListener('change', () => this.#showSlide());
    element('unit').addEventListener('change', () => this.#showUnit());
  }

  #moveSlider() {
    const angle = numberOf(element('angle').value);
    if (!Number.isNaN(angle))
      element('angle-slider').value = ((((angle + 90) % 180) + 180) % 180) - 90;
  }

  #showUnit() {
    for (const label of document.querySelectorAll('[data-unit="length"]'))
      label.textContent = this.unit;
    this.onUnit();
  }

  #showSlide() {
    element('slide-of').hidden = element('kinematics').value !== 'slide';
    if (!element('slide').value) element('slide').value = '0.5';
  }

  #showModel() {
    const model = element('permeability').value;
    for (const [name, inputs] of Object.entries(MODELS)) {
      element(name).hidden = name !== model;
      for (const id of Object.keys(inputs))
        if (!element(id).value) element(id).value = SUGGESTED[id] || 'quadratic';
    }
  }

  get unit() {
    return element('unit').value;
  }

  /** Fills the form from what the worker read of a document. */
  load({ settings, surfaceText, shape }) {
    this.clearErrors();
    this.surfaceText = surfaceText;
    this.shape = shape;
    const kept = withoutDefaults(settings);
    this.kept = kept;
    this.splits = [];
    this.#setUnit(kept.length_unit || 'm');
    element('method').value = kept.method || 'gib';
    element('spacing').value = show(kept.fabric.spacing);
    this.suggested = kept.fabric.spacing === undefined;
    this.#suggest();
    for (const [id, key] of Object.entries(FABRIC))
      element(id).value = (TEXT_OF_FABRIC[id] ?? show)(kept.fabric[key]);
    element('slide').value = show(kept.fabric.kinematics?.slide);
    this.#showSlide();
    this.materials.name = kept.fabric.material;
    const vector = kept.direction?.vector;
    element('angle').value = vector ? '' : show(kept.direction?.angle_deg ?? 0);
    element('angle').placeholder = vector ? 'vector' : '';
    element('cavity').value = show(kept.cavity?.height);
    this.rosette = kept.rosette;
    this.setStart(kept.start?.uv || kept.start?.point, 17); // rounded it may lie beyond an edge
    this.#loadPermeability(kept.permeability);
    this.#moveSlider();
    element('start-kind').textContent = shape && shape.kind !== 'nurbs' ? 'x, y, z' : 'u, v';
    this.#showKept();
  }

  /** Another surface with the same settings. */
  setSurface(surfaceText, shape) {
    this.surfaceText = surfaceText;
    this.shape = shape;
    this.#suggest();
    this.onUnit();
  }

  /** A spacing for the shape, until somebody says one. */
  #suggest() {
    if (this.suggested && this.shape) element('spacing').value = suggestSpacing(this.shape);
  }

  #setUnit(unit) {
    const select = element('unit');
    if (![...select.options].some((option) => option.value === unit)) select.add(new Option(unit));
    select.value = unit;
    this.#showUnit();
  }

  #loadPermeability(permeability) {
    const model = permeability?.model || '';
    element('permeability').value = model;
    for (const [id, key] of Object.entries(MODELS[model] || {}))
      element(id).value = show(permeability[key]);
    element('permeability').querySelector('[value="table"]').hidden = model !== 'table';
    this.#showModel();
  }

  #showKept() {
    const shown = [
      'fabric',
      'start',
      'direction',
      'method',
      'cavity',
      'permeability',
      'length_unit',
      'cuts',
      'rosette',
      'generators',
    ];
    const fabric = ['spacing', ...Object.values(FABRIC)];
    if (typeof this.kept.fabric.material === 'string') fabric.push('material');
    const names = Object.keys(this.kept).filter((key) => !shown.includes(key));
    names.push(...Object.keys(this.kept.fabric).filter((key) => !fabric.includes(key)));
    if (this.kept.direction?.vector) names.push('direction.vector');
    element('kept').textContent = names.length
      ? `Sent unchanged as in the file: ${names.join(', ')}.`
      : '';
  }

  /** [{path, name, allowance}]; the array is not changed, but another takes its place. */
  get cuts() {
    return this.kept.cuts ?? [];
  }

  set cuts(cuts) {
    this.kept = { ...this.kept, cuts: cuts.length ? cuts : undefined };
  }

  /** {warp, weft}; undefined: geodesics. Not changed, but others take their place. */
  get generators() {
    return this.kept.generators;
  }

  set generators(generators) {
    this.kept = { ...this.kept, generators };
  }

  /** All that is drawn on the part; splits are of a ply, and no drape has them. */
  get drawn() {
    return { cuts: this.cuts, splits: this.splits, generators: this.generators };
  }

  set drawn({ cuts, splits, generators }) {
    this.cuts = cuts;
    this.splits = splits;
    this.generators = generators;
  }

  setStart(numbers, digits = 6) {
    element('start').value = numbers
      ? numbers.map((value) => Number(Number(value).toPrecision(digits))).join(', ')
      : '';
  }

  /** {origin, x, z}, as far as they are given; undefined: the default. */
  get rosette() {
    const given = ROSETTE.map((key) => [key, element(`rosette-${key}`).value.trim()]);
    const rosette = given.filter(([, text]) => text).map(([key, text]) => [key, parse(text)]);
    return rosette.length ? { origin: [0, 0, 0], ...Object.fromEntries(rosette) } : undefined;
  }

  set rosette(rosette) {
    for (const key of ROSETTE) element(`rosette-${key}`).value = show(rosette?.[key]);
  }

  /** As the address keeps them. */
  get main() {
    const keys = ['method', 'spacing', 'angle', 'start'];
    return Object.fromEntries(keys.map((id) => [id, element(id).value]));
  }

  set main(values) {
    for (const [id, value] of Object.entries(values)) element(id).value = value;
    if ('spacing' in values) this.suggested = false;
    this.#moveSlider();
  }

  /** What a field says, or the material where it is empty; null without a number. */
  #figure(id) {
    const { value, placeholder } = element(id);
    const figure = parse(value || placeholder);
    return typeof figure === 'number' ? figure : null;
  }

  /** The locking angles of positive and of negative shear; null without any. */
  get lockings() {
    const { value, placeholder } = element('locking');
    const angles = [parse(value || placeholder)].flat();
    if (angles.length > 2 || angles.some((angle) => typeof angle !== 'number')) return null;
    return [angles[0], angles.at(-1)];
  }

  /** The lesser of them. */
  get locking() {
    return this.lockings && Math.min(...this.lockings);
  }

  /** What objectives of a study may need, and whether the request has it. */
  get given() {
    const has = (id) => this.#figure(id) !== null;
    const cavity = has('thickness') && has('fraction') && has('cavity');
    const permeability = Boolean(
      element('permeability').value || this.materials.figures.permeability,
    );
    const { value } = element('limit');
    const limit = Boolean(value || this.materials.figures.fabric?.limit_curve);
    return { locking: this.locking !== null, limit, cavity, permeability };
  }

  /** The spacing along warp and weft; [1, 1] while it is no number. */
  get spacing() {
    const [warp, weft = warp] = [parse(element('spacing').value)].flat();
    return [warp, weft].every((value) => typeof value === 'number') ? [warp, weft] : [1, 1];
  }

  /** How far weft slides along warp; where the form says nothing, in the material. */
  get slide() {
    const { kinematics } = this.#fabric(1);
    return slideOf(kinematics ? { kinematics } : this.materials.figures.fabric);
  }

  #fabric(coarser) {
    const fabric = { ...this.kept.fabric };
    const spacing = parse(element('spacing').value);
    fabric.spacing = coarser > 1 ? this.spacing.map((value) => value * coarser) : spacing;
    if (typeof fabric.material === 'string') delete fabric.material;
    if (this.materials.name) fabric.material = this.materials.name;
    for (const [id, key] of Object.entries(FABRIC)) {
      delete fabric[key];
      const text = element(id).value.trim();
      if (text) fabric[key] = (FABRIC_OF_TEXT[id] ?? parse)(text);
    }
    return fabric;
  }

  #permeability() {
    const model = element('permeability').value;
    if (!model) return undefined;
    if (!MODELS[model]) return this.kept.permeability;
    const inputs = Object.entries(MODELS[model]).map(([id, key]) => [
      key,
      parse(element(id).value),
    ]);
    return { model, ...Object.fromEntries(inputs) };
  }

  /** The request without its surface; `coarser` times the spacing. */
  settings(coarser = 1) {
    const text = (id) => element(id).value.trim();
    const place = parse(element('start').value);
    return {
      ...this.kept,
      length_unit: this.unit,
      fabric: this.#fabric(coarser),
      start: text('start')
        ? Array.isArray(place) && place.length === 3
          ? { point: place }
          : { uv: place, face: this.kept.start?.face }
        : undefined,
      direction: text('angle') ? { angle_deg: parse(text('angle')) } : this.kept.direction,
      rosette: this.rosette,
      method: element('method').value,
      cavity: text('cavity') ? { height: parse(text('cavity')) } : undefined,
      permeability: this.#permeability(),
    };
  }

  /** What decides which columns the result has. */
  get kind() {
    const { method, fabric, cavity, permeability } = this.settings();
    return JSON.stringify({ method, fabric: { ...fabric, spacing: null }, cavity, permeability });
  }

  /** Throws what is to be done before there is something to drape. */
  check() {
    if (this.isEmpty()) throw new Error(NO_FACE);
  }

  /** The request as the service takes it, the surface as it was in the file. */
  body(coarser) {
    return `{"surface":${this.surfaceText},${JSON.stringify(this.settings(coarser)).slice(1)}`;
  }

  /* ---- errors ---- */

  clearErrors() {
    for (const fault of this.root.querySelectorAll('.fault[data-made]')) fault.remove();
    for (const input of this.root.querySelectorAll('[aria-invalid]')) {
      input.removeAttribute('aria-invalid');
      input.removeAttribute('aria-describedby');
    }
    for (const id of ['fault-surface', 'fault-general']) element(id).textContent = '';
  }

  surfaceError(text) {
    element('fault-surface').textContent = text;
  }

  /** Each error at the field that its pointer names, the rest below the button. */
  showErrors(problem) {
    const rest = [];
    const errors = problem.errors?.length ? problem.errors : [{ detail: problem.message }];
    for (const { pointer = '', detail } of errors) {
      const control = this.#controlOf(pointer);
      if (pointer.startsWith('/surface')) this.surfaceError(`${pointer}: ${detail}`);
      else if (control) this.#fault(control, detail);
      else rest.push(pointer ? `${pointer}: ${detail}` : detail);
    }
    element('fault-general').textContent = rest.join(' ');
    this.root.querySelector('[aria-invalid]')?.focus();
    this.root.querySelector('.fault[data-made]')?.scrollIntoView({ block: 'nearest' });
  }

  #controlOf(pointer) {
    const within = (control) => `${pointer}/`.startsWith(`${control.dataset.pointer}/`);
    const controls = [...this.root.querySelectorAll('input[data-pointer], select[data-pointer]')];
    const length = (control) => control.dataset.pointer.length;
    return controls.filter(within).sort((a, b) => length(b) - length(a))[0];
  }

  #fault(control, detail) {
    element(`fault-of-${control.id}`)?.remove();
    const fault = document.createElement('p');
    Object.assign(fault, { className: 'fault', id: `fault-of-${control.id}`, textContent: detail });
    fault.dataset.made = '';
    control.closest('.slider, div').append(fault);
    control.setAttribute('aria-invalid', 'true');
    control.setAttribute('aria-describedby', fault.id);
  }
}
