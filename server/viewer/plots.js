// SPDX-License-Identifier: MIT
// The plots of a study, as SVG: the objective over the angle in a circle, and two objectives against
// each other. A click on either picks the nearest point.
import { frame, svg } from './charts.js';
import { format } from './fields.js';

const REACH = 14; // pixels of the drawing that a click may miss by

/** Calls with what the nearest point stands for. */
function pickable(picture, points, onPick) {
  picture.addEventListener('click', (event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(
      picture.getScreenCTM().inverse(),
    );
    const away = ({ x, y }) => Math.hypot(x - at.x, y - at.y);
    const nearest = points.reduce(
      (best, point) => (away(point) < away(best) ? point : best),
      points[0],
    );
    if (nearest && away(nearest) < REACH) onPick(nearest.row);
  });
  return picture;
}

const dots = (points, kind, radius) =>
  points.map(({ x, y }) => svg('circle', { cx: x, cy: y, r: radius, class: kind }));

/** The least value at each angle, `best` over all starts and `here` of one: [{angle, value, row}].
 *  Both ends of a direction are the same. */
export function drawPolar(parent, { best, here, label, onPick }) {
  const [size, middle, room] = [220, 110, 84];
  const most = Math.max(...[...best, ...here].map(({ value }) => value), 1e-12);
  const place = ({ angle, value, row }, turn) => {
    const phi = ((angle + turn) * Math.PI) / 180;
    const r = (room * value) / most;
    return { x: middle + r * Math.cos(phi), y: middle - r * Math.sin(phi), row };
  };
  const round = (list) => [0, 180].flatMap((turn) => list.map((one) => place(one, turn)));
  const path = (points, kind) =>
    svg('polygon', {
      points: points.map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`).join(' '),
      class: kind,
    });
  const rings = [0.5, 1].flatMap((share) => [
    svg('circle', { cx: middle, cy: middle, r: room * share, class: 'axis ring' }),
    svg('text', { x: middle + 3, y: middle - room * share + 11 }, format(most * share, 3)),
  ]);
  const marks = [0, 45, 90, 135, 180, 225, 270, 315].map((angle) => {
    const phi = (angle * Math.PI) / 180;
    const [x, y] = [middle + (room + 14) * Math.cos(phi), middle + 4 - (room + 14) * Math.sin(phi)];
    return svg(
      'text',
      { x, y, 'text-anchor': 'middle' },
      `${angle > 90 && angle <= 270 ? angle - 180 : angle > 270 ? angle - 360 : angle}°`,
    );
  });
  const [all, one] = [round(best), round(here)];
  const picture = svg(
    'svg',
    {
      viewBox: `0 0 ${size} ${size}`,
      role: 'img',
      'aria-label': `${label} over the warp's direction`,
    },
    ...rings,
    ...marks,
    path(all, 'curve second'),
    ...(one.length ? [path(one, 'curve first other')] : []),
    ...dots(all, 'dot', 2.6),
  );
  parent.replaceChildren(pickable(picture, all, onPick));
}

/** Rows as points (x, y); those of the front are joined. */
export function drawFront(parent, { rows, front, x, y, chosen, xLabel, yLabel, onPick }) {
  parent.replaceChildren();
  if (!rows.length) return;
  const bounds = (column) => {
    const values = rows.map((row) => column[row]);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return high > low
      ? [low, high]
      : [low - 0.5 * (Math.abs(low) || 1), low + 0.5 * (Math.abs(low) || 1)];
  };
  const { group, x: toX, y: toY } = frame({ xs: bounds(x), ys: bounds(y), xLabel, yLabel });
  const at = (row) => ({ x: toX(x[row]), y: toY(y[row]), row });
  const points = rows.map(at);
  const line = front.map(at).map((point) => `${point.x.toFixed(1)},${point.y.toFixed(1)}`);
  const picture = svg(
    'svg',
    { viewBox: '0 0 288 150', role: 'img', 'aria-label': `${yLabel} against ${xLabel}` },
    group,
    ...dots(points, 'dot faint', 2),
    svg('polyline', { points: line.join(' '), class: 'curve second' }),
    ...dots(front.map(at), 'dot', 3.2),
    ...(chosen >= 0 ? dots([at(chosen)], 'dot picked', 5) : []),
  );
  parent.append(pickable(picture, points, onPick));
}
