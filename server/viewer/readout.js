// SPDX-License-Identifier: MIT
// Numbers in words: a cell and its nearest node, and the summary of a drape.
import { fields, format, ofNodes, rangeOf, withUnit } from './fields.js';
import { nodeAt, NO_VALUE } from './lattice.js';
import { REASONS, REASON_TEXT } from './marks.js';

const SUMMARY = [
  ['outcome', 'Outcome'],
  ['nodes', 'Nodes'],
  ['cells', 'Cells'],
  ['cloth_coverage', 'Covered area', (value) => `${format(100 * value)} %`],
  ['coverage', 'In whole cells', (value) => `${format(100 * value)} %`],
  ['max_shear_deg', 'Greatest shear', (value, summary) => `${format(value)}°${errorOf(summary)}`],
  ['p95_shear_deg', '95 % of area below', (value) => `${format(value)}°`],
  ['mean_shear_deg', 'Mean shear', (value) => `${format(value)}°`],
  ['locked_cells', 'Locked cells'],
  ['residual_max', 'Greatest edge error', (value) => format(value, 2)],
  ['severity_max', 'Greatest severity'],
  ['error_estimate_max', 'Error of a node’s place'],
  ['thickness_error_max', 'Error of the thickness'],
];
const LENGTHS = ['error_estimate_max', 'thickness_error_max'];

/** The error bar of the greatest shear, where the method estimates one. */
function errorOf({ max_shear_error_deg: error }) {
  return error >= 0 && error !== null ? ` ± ${format(error, 2)}°` : '';
}

// What stands there before there is a drape, so that nothing moves later.
const ALWAYS = [
  'Shear angle',
  'Thickness',
  'Fibre volume fraction',
  'Porosity',
  'Beyond locking',
  'Nearest node',
  'x',
  'y',
  'z',
  'u, v',
  'Shear at the node',
];

/** A line that opens to sentences. */
function folded(text, sentences) {
  const details = document.createElement('details');
  details.append(
    Object.assign(document.createElement('summary'), { textContent: text }),
    ...sentences.map((sentence) =>
      Object.assign(document.createElement('p'), { textContent: sentence }),
    ),
  );
  return details;
}

function valueOf([, text, data, sentences]) {
  const value = document.createElement('dd');
  if (sentences?.length) value.append(folded(text, sentences));
  else if (data === undefined) value.textContent = text;
  else
    value.append(
      Object.assign(document.createElement('data'), { value: String(data), textContent: text }),
    );
  return value;
}

/** Rows of name and text; `data` is the whole number, as the service gave it. With the rows of
 *  `others` beside those of the same name. */
function fill(list, rows, others = null) {
  const beside = new Map((others || []).map((row) => [row[0], row]));
  const nodes = rows.flatMap((row) => {
    const term = document.createElement('dt');
    term.textContent = row[0];
    return [term, valueOf(row), ...(others ? [valueOf(beside.get(row[0]) || ['', '–'])] : [])];
  });
  list.classList.toggle('two', Boolean(others));
  list.replaceChildren(...nodes);
}

/** The cell (i, j) or -1. */
export function cellAt({ grid, cellOfNode }, i, j) {
  const owner = nodeAt(grid, i, j);
  return owner < 0 ? -1 : cellOfNode[owner];
}

export function placeOf({ columns }, cell) {
  return [columns['cells.i'][cell], columns['cells.j'][cell]];
}

/** The corners of a cell: (i, j), (i+1, j), (i+1, j+1), (i, j+1). */
export function cornersOf({ grid, columns }, cell) {
  const [i, j] = placeOf({ columns }, cell);
  return [
    [0, 0],
    [1, 0],
    [1, 1],
    [0, 1],
  ].map(([a, b]) => nodeAt(grid, i + a, j + b));
}

/** Why the net stops at one of the cell's corners, or ''. */
function reasonAt(lattice, front, cell) {
  const reasons = cornersOf(lattice, cell)
    .map((node) => front.get(node))
    .filter((reason) => reason !== undefined);
  const worst = Math.max(...reasons);
  return reasons.length ? REASONS[worst] : '';
}

/** A cell in a line: where it is, the value it shows (null: none), and why the net stops at it. */
export function describeCell(lattice, cell, { value, unit, front }) {
  const place = `cell (${placeOf(lattice, cell).join(', ')})`.replaceAll('-', '−');
  const text = value < NO_VALUE ? withUnit(format(value), unit) : 'not covered by the other';
  const reason = reasonAt(lattice, front, cell);
  const stop = reason ? `, the net stops: ${REASON_TEXT[reason]}` : '';
  return `${place}${value === null ? '' : `: ${text}`}${stop}`;
}

function cellRows({ columns }, cell, unit) {
  const given = fields.filter(
    (field) => !ofNodes(field) && field.key !== 'shear' && columns[field.column],
  );
  const rows = given.map((field) => {
    const value = columns[field.column][cell];
    return [
      field.label.replace(', signed', ''),
      withUnit(format(value, 5), field.unit(unit)),
      value,
    ];
  });
  if (columns['cells.locked'])
    rows.push(['Beyond locking', columns['cells.locked'][cell] ? 'yes' : 'no']);
  return rows;
}

function nodeRows({ columns }, node, unit, isUv) {
  const at = (name) => columns[`nodes.${name}`][node];
  const rows = [
    ['Nearest node', `(${at('i')}, ${at('j')})`.replaceAll('-', '−')],
    ...['x', 'y', 'z'].map((axis) => [axis, withUnit(format(at(axis), 6), unit), at(axis)]),
  ];
  if (isUv) rows.push(['u, v', `${format(at('u'), 5)}, ${format(at('v'), 5)}`]);
  rows.push(['Shear at the node', `${format(at('shear_deg'), 5)}°`, at('shear_deg')]);
  if (columns['nodes.shear_error_deg'])
    rows.push(['Error of that', `${format(at('shear_error_deg'), 2)}°`, at('shear_error_deg')]);
  if (columns['nodes.error_estimate'])
    rows.push([
      'Error estimate',
      withUnit(format(at('error_estimate'), 3), unit),
      at('error_estimate'),
    ]);
  return rows;
}

/** All about a cell and its corner `node`; an invitation without one. `isUv`: the surface has
 *  parameters, as meshes have not. */
export function showReadout(list, { lattice, cell, node, front, unit, isUv }) {
  if (!lattice || !lattice.columns['cells.i'].length) {
    fill(list, [['Cell', '–'], ...ALWAYS.map((name) => [name, '–'])]);
    return;
  }
  if (cell === null) {
    // the same rows, so that nothing moves later
    const rows = [...cellRows(lattice, 0, unit), ...nodeRows(lattice, 0, unit, isUv)];
    fill(list, [['Cell', 'point at a cell'], ...rows.map(([name]) => [name, '–'])]);
    return;
  }
  const [i, j] = placeOf(lattice, cell);
  const reason = reasonAt(lattice, front, cell);
  fill(list, [
    ['Cell', `(${i}, ${j})`.replaceAll('-', '−')],
    ...cellRows(lattice, cell, unit),
    ...nodeRows(lattice, node, unit, isUv),
    ...(reason ? [['The net stops here', REASON_TEXT[reason]]] : []),
  ]);
}

/** While the numbers are on their way. */
export function blankReadout(list) {
  for (const value of list.querySelectorAll('dd')) value.textContent = '–';
}

/** What the page can tell of a net by itself; NaN for all else that the summary `before` has. */
export function briefSummary({ columns }, before) {
  const unknown = Object.entries(before || {}).map(([key, value]) => [
    key,
    value === null ? null : NaN,
  ]);
  const shear = columns['cells.shear_deg'].map(Math.abs);
  const sum = (column) => column?.reduce((total, value) => total + value, 0);
  const reasons = {};
  for (const reason of columns['front.reason'])
    reasons[REASONS[reason]] = (reasons[REASONS[reason]] || 0) + 1;
  return {
    ...Object.fromEntries(unknown),
    outcome: 'in progress',
    nodes: columns['nodes.i'].length,
    cells: shear.length,
    max_shear_deg: rangeOf(shear)[1],
    mean_shear_deg: sum(shear) / (shear.length || 1),
    locked_cells: sum(columns['cells.locked']),
    front_reasons: reasons,
    timing_ms: { queue: NaN, solve: NaN },
  };
}

/** How much of the cloth is grown, and the greatest shear of it and of the other. */
function grownText({ grown_area, cloth_area, max_shear_grown_deg, max_shear_pinned_deg }) {
  if (max_shear_grown_deg === null) return 'none';
  if (!(max_shear_grown_deg >= 0)) return '–';
  const share = format((100 * grown_area) / cloth_area, 2);
  return `${share} %, ${format(max_shear_grown_deg, 3)}°; other ${format(max_shear_pinned_deg, 3)}°`;
}

/** What generators of least energy save: energies are areas, or work by the fabric's shear curve. */
function energyRows({ energy_before: before, energy_after: after }) {
  const rows = [['Energy, geodesics', format(before, 4), before]];
  const saved = before > 0 ? `, −${format(100 * (1 - after / before), 3)} %` : '';
  return [...rows, ['Energy, steered', `${format(after, 4)}${saved}`, after]];
}

function summaryRows(summary, unit) {
  const rows = SUMMARY.filter(([key]) => summary[key] !== null && summary[key] !== undefined).map(
    ([key, name, write]) => {
      const value = summary[key];
      if (typeof value === 'string') return [name, value];
      if (Number.isNaN(value)) return [name, '–'];
      const text = write
        ? write(value, summary)
        : LENGTHS.includes(key)
          ? withUnit(format(value, 3), unit)
          : value.toLocaleString('en');
      return [name, text, value];
    },
  );
  const greatest = rows.findIndex(([name]) => name === 'Greatest shear');
  rows.splice(greatest + 1, 0, ['Grown cloth', grownText(summary)]);
  if (summary.steering) rows.push(...energyRows(summary.steering));
  if (summary.error_estimate_max === null) rows.push(['Numerical errors', 'by gib4 alone']);
  const reasons = Object.entries(summary.front_reasons || {}).filter(([, count]) => count);
  rows.push([
    'Front',
    reasons
      .map(([name, count]) => `${count.toLocaleString('en')} ${name.replace('_', ' ')}`)
      .join(', ') || 'none',
  ]);
  const warnings = Array.isArray(summary.warnings) ? summary.warnings : [];
  const { verdict } = summary;
  const known = Boolean(verdict?.detail); // not yet, or not in what an earlier version stored
  const told = verdict?.drapable ? 'drapable' : `not drapable: ${verdict?.obstacle}`;
  rows.push(['Verdict', known ? told : '–', undefined, known ? [verdict.detail] : []]);
  const codes = warnings.map(({ code }) => code.replace('_', ' ')).join(', ');
  rows.push(['Warnings', codes || 'none', undefined, warnings.map(({ detail }) => detail)]);
  const { queue, solve } = summary.timing_ms;
  rows.push(['Queue, solve', `${format(queue, 3)}, ${format(solve, 3)} ms`]);
  return rows;
}

/** The numbers of a drape; `other`: [summary, label] of one to compare with, or null. */
export function showSummary(list, summary, unit, other = null) {
  if (!summary) {
    const names = SUMMARY.slice(1, -3).map(([, name]) => name);
    const last = [
      'Grown cloth',
      'Numerical errors',
      'Front',
      'Verdict',
      'Warnings',
      'Queue, solve',
    ];
    const rows = [...names, ...last].map((name) => [name, '–']);
    fill(list, [['Outcome', 'nothing is draped yet'], ...rows]);
    return;
  }
  const rows = summaryRows(summary, unit);
  if (!other) fill(list, rows);
  else
    fill(
      list,
      [['', 'this'], ...rows],
      [['', `the other: ${other[1]}`], ...summaryRows(other[0], unit)],
    );
}
