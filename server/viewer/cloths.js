// SPDX-License-Identifier: MIT
// The pieces of a ply as one body of cells: their nets are of the whole part, and a piece has those of
// its cells that the service's map finds under it.

const SIDES = [
  [2, 0],
  [0, 1],
  [1, 4],
  [4, 2],
]; // of a cell, in its part of the index
const LAYERS = 8; // neighbours lie above each other by one of so many steps
const LIFT = 4e-4; // of the part's radius, a step

/** The cells of all nets as a mesh to be mapped, one net after the other. */
export function meshOf(lattices) {
  const vertices = [];
  const quads = [];
  for (const { columns, index } of lattices) {
    const first = vertices.length;
    const [x, y, z] = ['x', 'y', 'z'].map((axis) => columns[`nodes.${axis}`]);
    x.forEach((_, node) => vertices.push([x[node], y[node], z[node]]));
    for (let at = 0; at < index.length; at += 6)
      quads.push([2, 0, 1, 4].map((corner) => first + index[at + corner]));
  }
  return { vertices, quads };
}

/** Of each cell of that mesh whether it is of its own piece, by the rows {element, piece} of the map;
 *  `numbers`: of the nets' pieces, from 1. */
export function keptOf(lattices, numbers, { element, piece }) {
  const own = lattices.flatMap(({ index }, k) => new Array(index.length / 6).fill(numbers[k]));
  const kept = new Uint8Array(own.length);
  element.forEach((cell, row) => {
    if (piece[row] === own[cell]) kept[cell] = 1;
  });
  return kept;
}

/** The kept cells about `origin`, as `facets.js` makes bodies: a patch each, its sides as edges, and
 *  `pieceOf` and `cellOf`, by patches. The first net lies on top, or with `over` 'last' the last. */
export function clothsOf(lattices, kept, { origin, radius }, over) {
  const parts = { position: [], normal: [], patch: [], edges: [], edgePatch: [] };
  const [pieceOf, cellOf] = [[], []];
  let number = 0;
  lattices.forEach((lattice, k) => {
    const layer = (over === 'last' ? k : lattices.length - 1 - k) % LAYERS;
    const place = placer(lattice, origin, (layer * LIFT + LIFT) * radius);
    for (let cell = 0; cell < lattice.index.length / 6; cell++, number++) {
      if (!kept[number]) continue;
      addCell(parts, lattice, 6 * cell, pieceOf.length, place);
      pieceOf.push(k);
      cellOf.push(cell);
    }
  });
  const arrays = Object.entries(parts).map(([name, values]) => [name, Float32Array.from(values)]);
  return {
    ...Object.fromEntries(arrays),
    origin,
    radius,
    fewer: null,
    count: pieceOf.length,
    pieceOf,
    cellOf,
  };
}

/** Where a node is, lifted off the part. */
function placer({ position, normal, origin: own }, origin, height) {
  return (node) => {
    const along = [0, 1, 2].map((axis) => normal[3 * node + axis]);
    const length = Math.hypot(...along) || 1;
    return along.map(
      (value, axis) =>
        position[3 * node + axis] + own[axis] - origin[axis] + (height * value) / length,
    );
  };
}

function addCell(parts, { index, normal }, at, patch, place) {
  for (let k = 0; k < 6; k++) {
    const node = index[at + k];
    parts.position.push(...place(node));
    parts.normal.push(...normal.subarray(3 * node, 3 * node + 3));
    parts.patch.push(patch);
  }
  for (const side of SIDES)
    for (const corner of side) {
      parts.edges.push(...place(index[at + corner]));
      parts.edgePatch.push(patch);
    }
}
