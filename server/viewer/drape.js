// SPDX-License-Identifier: MIT
// One drape of the service, fetched: its columns ready to draw, its summary, its request.
import { read, status } from './api.js';
import { readNet, readRequest } from './work.js';

const FORMAT = 'result?format=npz';

/** {id, lattice, summary} of a drape that has succeeded; `document` is its status, if known. */
export async function fetchDrape(id, document, signal) {
  const [state, buffer] = await Promise.all([
    document || status(id, signal),
    read(`v1/drapes/${id}/${FORMAT}`, 'arrayBuffer', { signal }),
  ]);
  return { id, summary: state.summary, lattice: await readNet(buffer) };
}

/** What the form needs of the request of a drape, a surface that it names included. */
export async function fetchRequest(id, signal) {
  const text = await read(`v1/drapes/${id}/request`, 'text', { signal });
  const request = await readRequest(text);
  if (!request.named) return request;
  const surface = await read(`v1/surfaces/${request.named}`, 'text', { signal });
  return readRequest(text, surface);
}

/** What tells a drape from another: its method, direction, spacing and start. */
export function labelOf({ method, direction, fabric, length_unit: unit = 'm', start }) {
  const rounded = (value) => (Math.abs(value) < 1e-9 ? 0 : Number(Number(value).toPrecision(3)));
  const round = (values) => values.map(rounded).join(', ');
  const angle = direction?.angle_deg;
  const spacing = [...new Set([fabric.spacing].flat())];
  const parts = [method || 'gib', angle === undefined ? 'along a vector' : `${angle}°`];
  parts.push(`${round(spacing).replace(', ', ' × ')} ${unit}`);
  const face = start?.face === undefined ? '' : `face ${start.face}, `;
  if (start) parts.push(`from ${face}${round([start.uv || start.point].flat())}`);
  return parts.join(', ');
}

/** The spacing along warp and weft that a fabric asks for. */
export function spacingOf({ spacing }) {
  const [warp, weft = warp] = [spacing].flat();
  return [warp, weft];
}

/** How far weft slides along warp: 0 in a weave, 1 in parallel fibres. */
export const slideOf = ({ kinematics } = {}) =>
  kinematics === 'parallel_fibers' ? 1 : (kinematics?.slide ?? 0);

/** What a drape is drawn by, of its request. */
export const toldOf = (settings) => ({
  spacing: spacingOf(settings.fabric),
  slide: slideOf(settings.fabric),
  label: labelOf(settings),
});
