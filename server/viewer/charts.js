// SPDX-License-Identifier: MIT
// The colour bar, the histogram of the shear and its curves along the diagonals, as SVG.
import { css } from './colour.js';
import { format, withUnit } from './fields.js';
import { nodeAt } from './lattice.js';

const BINS_MAX = 40;
const WIDTH = 288;
const HEIGHT = 150;
const FRAME = { left: 34, right: 8, top: 20, bottom: 30 };

export function svg(name, attributes = {}, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

/** Round values between low and high, about `count` of them. */
function ticks(low, high, count) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= raw);
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++)
    values.push(k * step);
  return values;
}

/** The one value that a field has everywhere. */
function drawConstant(parent, value, { map, unit, label }) {
  const text = withUnit(format(value), unit);
  parent.replaceChildren(
    svg(
      'svg',
      { role: 'img', 'aria-label': `${label}: ${text} everywhere` },
      svg('rect', { x: 4, y: 4, width: 28, height: 12, fill: css(map, 0.5) }),
      svg('text', { x: 40, y: 14 }, `${text} everywhere`),
    ),
  );
}

/** `values` with a mark at each of `marks` that lies within. */
export function drawScale(parent, { range: [low, high], map, unit, label, marks = [] }) {
  if (low === high) {
    drawConstant(parent, low, { map, unit, label });
    return;
  }
  const box = { width: Math.max(parent.clientWidth, 200), top: 4, height: 12, side: 36 };
  const inner = box.width - 2 * box.side;
  const x = (value) => box.side + (inner * (value - low)) / (high - low);
  const bars = Array.from({ length: 64 }, (_, k) =>
    svg('rect', {
      x: box.side + (inner * k) / 64,
      y: box.top,
      width: inner / 64 + 0.6,
      height: box.height,
      fill: css(map, (k + 0.5) / 64),
    }),
  );
  const text = (value, y, kind) =>
    svg(
      'text',
      { x: x(value), y, 'text-anchor': 'middle', class: kind },
      withUnit(format(value, 3), unit === '°' ? unit : ''),
    );
  const inside = marks.filter((value) => value > low && value < high);
  const room = (others) => (value) => others.every((other) => Math.abs(x(other) - x(value)) > 56);
  const between = ticks(low, high, Math.max(2, inner / 90)).filter(room([low, high, ...inside]));
  const ends = [low, high].filter(room(inside));
  const labels = [...ends, ...between].map((value) => text(value, 30, ''));
  const lines = inside.flatMap((value) => [
    svg('line', { x1: x(value), x2: x(value), y1: 1, y2: 20, class: 'mark' }),
    svg(
      'text',
      { x: x(value), y: 30, 'text-anchor': 'middle', class: 'marked' },
      `locks ${withUnit(format(value, 3), unit)}`,
    ),
  ]);
  const title = `${label}${unit && unit !== '°' ? `, ${unit}` : ''}: ${format(low)} to ${withUnit(format(high), unit)}`;
  const own =
    unit && unit !== '°' ? [svg('text', { x: box.width, y: 14, 'text-anchor': 'end' }, unit)] : [];
  parent.replaceChildren(
    svg('svg', { role: 'img', 'aria-label': title }, ...bars, ...labels, ...lines, ...own),
  );
}

/** The frame of a chart with ticks; returns the group and the scales. */
export function frame({ xs, ys, xLabel, yLabel }) {
  const x = (value) =>
    FRAME.left + ((WIDTH - FRAME.left - FRAME.right) * (value - xs[0])) / (xs[1] - xs[0] || 1);
  const y = (value) =>
    HEIGHT -
    FRAME.bottom -
    ((HEIGHT - FRAME.top - FRAME.bottom) * (value - ys[0])) / (ys[1] - ys[0] || 1);
  const group = svg('g');
  for (const value of ticks(...xs, 5))
    group.append(
      svg(
        'text',
        { x: x(value), y: HEIGHT - FRAME.bottom + 13, 'text-anchor': 'middle' },
        format(value, 3),
      ),
    );
  for (const value of ticks(...ys, 4)) {
    group.append(
      svg('line', {
        x1: FRAME.left,
        x2: WIDTH - FRAME.right,
        y1: y(value),
        y2: y(value),
        class: 'axis',
      }),
    );
    group.append(
      svg('text', { x: FRAME.left - 5, y: y(value) + 4, 'text-anchor': 'end' }, format(value, 3)),
    );
  }
  const middle = (FRAME.left + WIDTH - FRAME.right) / 2;
  group.append(svg('text', { x: middle, y: HEIGHT - 3, 'text-anchor': 'middle' }, xLabel));
  group.append(svg('text', { x: 2, y: 11 }, yLabel));
  return { group, x, y };
}

function place(parent, label, ...children) {
  parent.replaceChildren(
    svg(
      'svg',
      { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: 'img', 'aria-label': label },
      ...children,
    ),
  );
}

/** How many cells have which absolute shear, in the colours of the map. */
export function drawHistogram(parent, shear, locking) {
  const most = shear.reduce((high, value) => Math.max(high, Math.abs(value)), 0) || 1;
  const bins = Math.round(Math.min(BINS_MAX, Math.max(8, Math.sqrt(shear.length) / 2)));
  const counts = new Array(bins).fill(0);
  for (const value of shear)
    counts[Math.min(bins - 1, Math.floor((Math.abs(value) / most) * bins))]++;
  const parts = counts.map((count) => (100 * count) / (shear.length || 1));
  const top = Math.max(...parts) * 1.05;
  const { group, x, y } = frame({
    xs: [0, most],
    ys: [0, top],
    xLabel: 'absolute shear angle, degrees',
    yLabel: '% of the cells',
  });
  const bars = parts.map((part, k) => {
    const [left, right] = [x((most * k) / bins), x((most * (k + 1)) / bins)];
    return svg('rect', {
      x: left,
      y: y(part),
      width: right - left - 0.6,
      height: Math.max(0, y(0) - y(part)),
      fill: css('sequential', (k + 0.5) / bins),
    });
  });
  const marks =
    locking && locking < most
      ? [svg('line', { x1: x(locking), x2: x(locking), y1: FRAME.top, y2: y(0), class: 'mark' })]
      : [];
  place(
    parent,
    `Histogram of the absolute shear of ${shear.length} cells, up to ${format(most, 3)} degrees`,
    group,
    ...bars,
    ...marks,
  );
}

/** Absolute shear at the nodes (k, side k), over the way along that diagonal from the start. */
function alongDiagonal({ grid, position, columns }, side) {
  const points = [];
  for (const direction of [-1, 1]) {
    let way = 0;
    let before = nodeAt(grid, 0, 0);
    for (let k = direction === 1 ? 0 : -1; before >= 0; k += direction) {
      const node = nodeAt(grid, k, side * k);
      if (node < 0) break;
      const step = [0, 1, 2].map((axis) => position[3 * node + axis] - position[3 * before + axis]);
      way += direction * Math.hypot(...step);
      points.push([way, Math.abs(columns['nodes.shear_deg'][node])]);
      before = node;
    }
  }
  return points.sort((a, b) => a[0] - b[0]);
}

/** The curves of one net, and of another, dashed. */
export function drawDiagonals(parent, lattices, unit, locking) {
  const curves = lattices.flatMap((lattice, k) =>
    [1, -1].map((side) => ({
      points: alongDiagonal(lattice, side),
      kind: `${side === 1 ? 'first' : 'second'}${k ? ' other' : ''}`,
    })),
  );
  const all = curves.flatMap((curve) => curve.points);
  const xs = [
    Math.min(0, ...all.map((point) => point[0])),
    Math.max(1e-12, ...all.map((point) => point[0])),
  ];
  const ys = [0, Math.max(1, ...all.map((point) => point[1])) * 1.08];
  const { group, x, y } = frame({
    xs,
    ys,
    xLabel: `distance along the diagonal, ${unit}`,
    yLabel: '|shear|, degrees',
  });
  const lines = curves.map(({ points, kind }) =>
    svg('polyline', {
      class: `curve ${kind}`,
      points: points.map(([a, b]) => `${x(a).toFixed(1)},${y(b).toFixed(1)}`).join(' '),
    }),
  );
  const key = ['first', 'second'].flatMap((kind, k) => [
    svg('line', { x1: 166 + 60 * k, x2: 180 + 60 * k, y1: 7, y2: 7, class: `curve ${kind}` }),
    svg('text', { x: 184 + 60 * k, y: 11 }, k ? 'i = −j' : 'i = j'),
  ]);
  if (lattices.length > 1)
    key.push(
      svg('line', { x1: 98, x2: 116, y1: 7, y2: 7, class: 'axis other strong' }),
      svg('text', { x: 120, y: 11 }, 'other'),
    );
  const marks =
    locking && locking < ys[1]
      ? [
          svg('line', {
            x1: FRAME.left,
            x2: WIDTH - FRAME.right,
            y1: y(locking),
            y2: y(locking),
            class: 'mark',
          }),
        ]
      : [];
  const most = ['i = j', 'i = −j'].map(
    (name, k) =>
      `along ${name} up to ${format(Math.max(0, ...curves[k].points.map((point) => point[1])), 3)}`,
  );
  place(parent, `Absolute shear in degrees ${most.join(', ')}`, group, ...marks, ...lines, ...key);
}
