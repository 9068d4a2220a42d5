// SPDX-License-Identifier: MIT
// Two drapes side by side, with a map of their difference.
import { drawScale } from './charts.js';
import { element } from './dom.js';
import { fetchDrape, fetchRequest, toldOf } from './drape.js';
import { fields, format, ofNodes, valuesOf, withUnit } from './fields.js';
import { centresOf, NO_VALUE } from './lattice.js';
import { readDifference } from './work.js';

const SHARE = 0.99; // of the cells: the colours span their differences, not those of a few at the rim

export class Comparison {
  constructor(view) {
    this.view = view;
    this.other = null; // {id, lattice, summary, spacing}
    this.values = null; // the difference at the cells of the main drape
  }

  /** Fetches the other drape and shows it. */
  async start(id) {
    const [request, drape] = await Promise.all([fetchRequest(id), fetchDrape(id)]);
    const { settings } = request;
    this.other = { ...drape, ...toldOf(settings) };
    this.view.setNet('two', this.other);
    element('caption-other').textContent = `The other: ${this.other.label}`;
    for (const id of ['compare-end', 'caption-flat']) element(id).hidden = false;
    this.view.arrange('compare');
  }

  end() {
    this.other = this.values = null;
    for (const slot of ['two', 'difference']) this.view.setNet(slot, null);
    for (const id of ['compare-end', 'caption-flat']) element(id).hidden = true;
    element('caption-one').textContent = '';
  }

  /** Colours the difference of a field; of the shear for one that is known at nodes. */
  async colour(one, shown, unitOfLength) {
    const two = this.other;
    const field = ofNodes(shown) ? fields[0] : shown;
    element('caption-one').textContent = `This: ${one.label} · `;
    const values = await differenceOf(one, two, field);
    if (!values || this.other !== two) return;
    this.values = values;
    const unit = field.unit(unitOfLength);
    const { most, span } = extremes(values);
    const text = withUnit(format(most, 3), unit);
    element('caption-difference').textContent = `Difference, this − other; greatest ${text}`;
    if (this.view.slots.difference?.lattice !== one.lattice) this.view.setNet('difference', one);
    this.view.setField('difference', values, false, [-span, span], 'diverging');
    const label = `${field.label}, this − other`;
    drawScale(element('difference-scale'), { range: [-span, span], map: 'diverging', unit, label });
  }
}

/** The field of one minus that of two, at the cells of one; null when one of them lacks it. */
async function differenceOf(one, two, field) {
  const [first, second] = [one, two].map(({ lattice }) => ({
    centres: centresOf(lattice),
    values: valuesOf(lattice.columns, field),
  }));
  if (!first.values || !second.values) return null;
  const shift = two.lattice.origin.map((value, axis) => value - one.lattice.origin[axis]);
  const reach = Math.max(...one.spacing, ...two.spacing);
  return readDifference({ one: first, two: second, shift, reach });
}

/** The greatest difference, and what nearly all stay within. */
function extremes(values) {
  const sizes = values.filter((value) => value < NO_VALUE).map(Math.abs);
  sizes.sort();
  const span = sizes[Math.floor(SHARE * sizes.length)] || 1e-9;
  return { most: sizes.at(-1) ?? 0, span };
}
