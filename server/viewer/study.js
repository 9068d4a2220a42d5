// SPDX-License-Identifier: MIT
// A study: many starts and directions of one part, and what its variants say.
import { follow, read, submitStudy } from './api.js';

/** What may be made small, and how it is written: in `unit`, or in that `power` of the length unit;
 *  and what has to be said for it. */
export const OBJECTIVES = [
  { key: 'max_shear_deg', label: 'Greatest shear', unit: '°' },
  { key: 'p95_shear_deg', label: 'Shear that 95 % of the area stays below', unit: '°' },
  { key: 'uncovered_area', label: 'Area without cloth', power: 2 },
  { key: 'waste_area', label: 'Waste of the rectangle to cut from', power: 2 },
  { key: 'locked_area', label: 'Area beyond the locking angle', power: 2, needs: 'locking' },
  { key: 'severity_area', label: 'Area times its severity', power: 2, needs: 'limit' },
  { key: 'fiber_volume_fraction_range', label: 'Range of the fibre fraction', needs: 'cavity' },
  {
    key: 'k1_ratio_p95',
    label: 'Change of k1 that 95 % of the area stays below',
    unit: '×',
    needs: 'permeability',
  },
  {
    key: 'angle_deviation_deg',
    label: 'Warp from the wanted direction',
    unit: '°',
    needs: 'wanted',
  },
];
const NO_DIRECTION = 'The wanted direction has three numbers, x, y and z.';

export const objectiveOf = (key) => OBJECTIVES.find((one) => one.key === key);
const ANYTHING = { cloth_coverage: { min: 0 }, max_shear_deg: { max: 90 } }; // limits are the page's

/** The study of a drape request (JSON text) with about `starts` places and an angle each `step`
 *  degrees, of all objectives that it has what is `given` for, a wanted direction of the warp [x, y, z]
 *  among it; with `optimise` the best of these are refined. */
export function requestOf(drape, { starts, step, optimise, given }) {
  const { wanted } = given;
  if (wanted.length && (wanted.length !== 3 || wanted.some(Number.isNaN)))
    throw new Error(NO_DIRECTION);
  const has = { ...given, wanted: wanted.length };
  const objectives = OBJECTIVES.filter(({ needs }) => !needs || has[needs]);
  const rest = {
    vary: { start: { grid: starts }, angle_deg: { from: -90, to: 90 - step, step } },
    objectives: objectives.map(({ key }) => key),
    limits: ANYTHING,
    ...(wanted.length ? { wanted_direction: wanted } : {}),
    ...(optimise ? { search: 'optimise', budget: 2 * starts * Math.round(180 / step) } : {}),
  };
  return `{"drape":${drape},${JSON.stringify(rest).slice(1)}`;
}

/** Runs it: the result document. */
export async function runStudy(body, onStatus, signal) {
  const { id } = await submitStudy(body, signal);
  onStatus({ id, status: 'queued', progress: 0 });
  const last = await follow(id, onStatus, signal, 'studies');
  if (last.status === 'failed') throw new Error(last.error?.detail || 'The study has failed.');
  if (last.status === 'cancelled') return null;
  return read(`v1/studies/${id}/result?format=json`, 'json', { signal });
}

/** The variants by their start: [{place, rows}]. */
export function startsOf({ x, y, z }) {
  const starts = new Map();
  x.forEach((_, row) => {
    const key = `${x[row]} ${y[row]} ${z[row]}`;
    if (!starts.has(key)) starts.set(key, { place: [x[row], y[row], z[row]], rows: [] });
    starts.get(key).rows.push(row);
  });
  return [...starts.values()];
}

const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

/** Which rows have numbers and keep the limits of the sliders. */
export function keptRows(variants, { coverage, shear }) {
  const { cloth_coverage: covered, max_shear_deg: sheared } = variants;
  return covered.map((value, row) => isNumber(value) && value >= coverage && sheared[row] <= shear);
}

/** Of some rows that with the least of a column; -1 without any. */
export function leastOf(column, rows, kept) {
  return rows.reduce(
    (best, row) => (kept[row] && (best < 0 || column[row] < column[best]) ? row : best),
    -1,
  );
}

/** The rows that no other one is better than in both columns. */
export function frontOf(first, second, rows) {
  const sorted = [...rows].sort((a, b) => first[a] - first[b] || second[a] - second[b]);
  const front = [];
  for (const row of sorted)
    if (!front.length || second[row] < second[front.at(-1)]) front.push(row);
  return front;
}
