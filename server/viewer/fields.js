// SPDX-License-Identifier: MIT
// What a net can be coloured by: where the numbers are in the result, their unit and how they are
// written.

const identity = (value) => value;

/** `column` of the result; `of` turns its numbers into what is shown; `unit` of the request; of less
 *  than `least` the colours do not spread. */
export const fields = [
  {
    key: 'shear',
    label: 'Shear angle, absolute',
    column: 'cells.shear_deg',
    of: Math.abs,
    unit: () => '°',
    zero: true,
    least: 1,
  },
  {
    key: 'shear_signed',
    label: 'Shear angle, signed',
    column: 'cells.shear_deg',
    of: identity,
    unit: () => '°',
    signed: true,
    least: 1,
  },
  {
    key: 'thickness',
    label: 'Thickness',
    column: 'cells.thickness',
    of: identity,
    unit: (length) => length,
  },
  {
    key: 'fiber_volume_fraction',
    label: 'Fibre volume fraction',
    column: 'cells.fiber_volume_fraction',
    of: identity,
    unit: () => '',
  },
  { key: 'porosity', label: 'Porosity', column: 'cells.porosity', of: identity, unit: () => '' },
  {
    key: 'severity',
    label: 'Severity of the shear',
    column: 'cells.severity',
    of: identity,
    unit: () => '',
    zero: true,
  },
  { key: 'k1', label: 'Permeability k1', column: 'cells.k1', of: identity, unit: () => 'm²' },
  { key: 'k2', label: 'Permeability k2', column: 'cells.k2', of: identity, unit: () => 'm²' },
  { key: 'k3', label: 'Permeability k3', column: 'cells.k3', of: identity, unit: () => 'm²' },
  {
    key: 'error_estimate',
    label: 'Error estimate',
    column: 'nodes.error_estimate',
    of: identity,
    unit: (length) => length,
    zero: true,
  },
  {
    key: 'shear_error',
    label: 'Error of the shear',
    column: 'nodes.shear_error_deg',
    of: identity,
    unit: () => '°',
    zero: true,
  },
];

export const fieldOf = (key) => fields.find((field) => field.key === key) || fields[0];
const isShear = (field) => field.column === 'cells.shear_deg';
export const ofNodes = (field) => field.column.startsWith('nodes.');

/** The shown values of a field, of nodes or of cells, or null when the result has none. */
export function valuesOf(columns, field) {
  const column = columns[field.column];
  if (!column) return null;
  const values = new Float32Array(column.length);
  for (let row = 0; row < values.length; row++) values[row] = field.of(column[row]);
  return values;
}

export function rangeOf(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 1];
}

/** What the ends of the colour bar stand for. */
function scaleOf(field, range) {
  let [low, high] = range;
  if (field.signed) {
    high = Math.max(Math.abs(low), Math.abs(high), field.least ?? 0) || 1;
    return [-high, high];
  }
  if (field.zero) low = 0;
  if (field.least) high = Math.max(high, low + field.least);
  return high - low > Math.abs(high) * 1e-6 ? [low, high] : [low, low]; // the same everywhere
}

/** The range of the colours, as far as it is fixed by hand. */
function limited([low, high], [from, to] = []) {
  const range = [from ?? low, to ?? high];
  return range[1] > range[0] ? range : [low, high];
}

/** The colours of values of a field that lie within `range`, as `drawScale` takes them. `limits`: [from,
 *  to], by hand; `lockings`: the angles of positive and of negative shear, to be marked; `unit`: of
 *  length. */
export function colouringOf(field, range, { limits, lockings, unit }) {
  const [positive, negative] = (isShear(field) && lockings) || [];
  const marks = field.signed ? [-negative, positive] : [Math.min(positive, negative)];
  return {
    range: limited(scaleOf(field, range), limits),
    map: field.signed ? 'diverging' : 'sequential',
    unit: field.unit(unit),
    label: field.label,
    marks: positive === undefined ? [] : marks,
  };
}

/** Four digits, with a real minus sign; powers of ten where they are shorter. */
export function format(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  let text;
  if (size < 1e-3 || size >= 1e6) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
    text = `${Number(mantissa)} × 10${superscript(exponent)}`;
  } else {
    text = String(Number(value.toPrecision(digits)));
  }
  return text.replace('-', '−');
}

function superscript(exponent) {
  const digits = '⁰¹²³⁴⁵⁶⁷⁸⁹';
  return String(Number(exponent))
    .replace(/\d/g, (digit) => digits[digit])
    .replace('-', '⁻');
}

export const withUnit = (text, unit) =>
  unit === '°' ? `${text}°` : unit ? `${text} ${unit}` : text;
