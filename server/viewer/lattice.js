// SPDX-License-Identifier: MIT
// The net as the graphics card takes it, from the columns of a result. Runs in the worker.
//
// One vertex a node. A cell (i, j) is owned by its corner (i, j): both its triangles end with that
// vertex, whose values WebGL then gives to the whole cell (`flat`). So a field of the cells is one
// number a node, and colours change without touching the triangles.

/** The value of a cell that has none; not NaN, which graphics cards need not know. */
export const NO_VALUE = Math.fround(1e30);

const COARSE_CELLS = 12000; // of a picture in motion

/** Extremes of a column; 0 and 0 without rows. */
function range(column) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of column) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 0];
}

/** The node at every place (i, j) of the net's bounds, -1 for none. */
function makeGrid(columns) {
  const [imin, imax] = range(columns['nodes.i']);
  const [jmin, jmax] = range(columns['nodes.j']);
  const width = imax - imin + 1;
  const nodes = new Int32Array(width * (jmax - jmin + 1)).fill(-1);
  columns['nodes.i'].forEach((i, node) => {
    nodes[(columns['nodes.j'][node] - jmin) * width + (i - imin)] = node;
  });
  return { imin, imax, jmin, jmax, width, nodes };
}

/** The node (i, j), -1 for none. */
export function nodeAt(grid, i, j) {
  if (i < grid.imin || i > grid.imax || j < grid.jmin || j > grid.jmax) return -1;
  return grid.nodes[(j - grid.jmin) * grid.width + (i - grid.imin)];
}

/** Two triangles a cell, and which cell each node owns. */
function makeCells(columns, grid) {
  const cellI = columns['cells.i'];
  const cellJ = columns['cells.j'];
  const index = new Uint32Array(cellI.length * 6);
  const cellOfNode = new Int32Array(columns['nodes.i'].length).fill(-1);
  for (let cell = 0; cell < cellI.length; cell++) {
    const i = cellI[cell];
    const j = cellJ[cell];
    const owner = nodeAt(grid, i, j);
    const far = nodeAt(grid, i + 1, j + 1);
    const at = 6 * cell;
    index[at] = nodeAt(grid, i + 1, j);
    index[at + 1] = index[at + 3] = far;
    index[at + 2] = index[at + 5] = owner;
    index[at + 4] = nodeAt(grid, i, j + 1);
    cellOfNode[owner] = cell;
  }
  return { index, cellOfNode };
}

/** Fewer triangles for a picture in motion: two for each block of cells that is complete, and those
 *  of the cells that are in none. The blocks are as large as it takes to be about COARSE_CELLS; null
 *  where the net is not larger than two of that. */
function makeCoarse(columns, grid, cellOfNode, index) {
  const count = index.length / 6;
  const step = Math.ceil(Math.sqrt(count / COARSE_CELLS));
  if (count < 2 * COARSE_CELLS) return null;
  const coarse = new Uint32Array(index.length);
  let length = 0;
  const put = (a, b, c, d) => {
    coarse.set([b, c, a, c, d, a], length);
    length += 6;
  };
  for (let j = grid.jmin; j <= grid.jmax; j += step)
    for (let i = grid.imin; i <= grid.imax; i += step) {
      const owners = ownersOf(grid, cellOfNode, i, j, step);
      if (owners.length === step * step)
        put(
          owners[0],
          nodeAt(grid, i + step, j),
          nodeAt(grid, i + step, j + step),
          nodeAt(grid, i, j + step),
        );
      else
        for (const owner of owners) {
          coarse.set(index.subarray(6 * cellOfNode[owner], 6 * cellOfNode[owner] + 6), length);
          length += 6;
        }
    }
  return coarse.slice(0, length);
}

/** The owners of the cells of a block, by rows. */
function ownersOf(grid, cellOfNode, i, j, step) {
  const owners = [];
  for (let b = j; b < j + step; b++)
    for (let a = i; a < i + step; a++) {
      const owner = nodeAt(grid, a, b);
      if (owner >= 0 && cellOfNode[owner] >= 0) owners.push(owner);
    }
  return owners;
}

/** Positions about the middle of the bounds, where single precision is enough. */
function makePositions(columns) {
  const axes = ['x', 'y', 'z'].map((axis) => columns[`nodes.${axis}`]);
  const bounds = axes.map(range);
  const origin = bounds.map(([low, high]) => (low + high) / 2);
  const position = new Float32Array(axes[0].length * 3);
  axes.forEach((values, axis) => {
    for (let node = 0; node < values.length; node++)
      position[3 * node + axis] = values[node] - origin[axis];
  });
  const radius = Math.hypot(...bounds.map(([low, high]) => (high - low) / 2)) || 1;
  return { position, origin, radius };
}

/** Adds the area vector of the triangle with the corners index[at..at+2] to them. */
function addNormal(normal, p, index, at) {
  const a = 3 * index[at];
  const b = 3 * index[at + 1];
  const c = 3 * index[at + 2];
  const x1 = p[b] - p[a],
    y1 = p[b + 1] - p[a + 1],
    z1 = p[b + 2] - p[a + 2];
  const x2 = p[c] - p[a],
    y2 = p[c + 1] - p[a + 1],
    z2 = p[c + 2] - p[a + 2];
  const x = y1 * z2 - z1 * y2,
    y = z1 * x2 - x1 * z2,
    z = x1 * y2 - y1 * x2;
  for (const k of [a, b, c]) {
    normal[k] += x;
    normal[k + 1] += y;
    normal[k + 2] += z;
  }
}

export function makeNormals(position, index) {
  const normal = new Float32Array(position.length);
  for (let at = 0; at < index.length; at += 3) addNormal(normal, position, index, at);
  return normal;
}

/** Of the cell that each node owns, when it is locked: 16 and the sides without a locked neighbour,
 *  1: i - 1, 2: i + 1, 4: j - 1, 8: j + 1. Otherwise 0. */
function makeSides(columns, grid, cellOfNode) {
  const locked = columns['cells.locked'];
  const sides = new Uint8Array(cellOfNode.length);
  if (!locked) return sides;
  const free = (i, j) => {
    const owner = nodeAt(grid, i, j);
    return owner < 0 || cellOfNode[owner] < 0 || !locked[cellOfNode[owner]];
  };
  for (let node = 0; node < sides.length; node++) {
    const cell = cellOfNode[node];
    if (cell < 0 || !locked[cell]) continue;
    const i = columns['cells.i'][cell];
    const j = columns['cells.j'][cell];
    sides[node] =
      16 + free(i - 1, j) + 2 * free(i + 1, j) + 4 * free(i, j - 1) + 8 * free(i, j + 1);
  }
  return sides;
}

/** The middles of the cells, as positions are. */
export function centresOf({ position: p, index }) {
  const centres = new Float32Array(index.length / 2);
  for (let at = 0, k = 0; at < index.length; at += 6)
    for (let axis = 0; axis < 3; axis++, k++) {
      const [b, c, a, d] = [index[at], index[at + 1], index[at + 2], index[at + 4]];
      centres[k] = (p[3 * a + axis] + p[3 * b + axis] + p[3 * c + axis] + p[3 * d + axis]) / 4;
    }
  return centres;
}

function interleave(first, second) {
  const both = new Float32Array(first.length * 2);
  for (let k = 0; k < first.length; k++) {
    both[2 * k] = first[k];
    both[2 * k + 1] = second[k];
  }
  return both;
}

/** Everything the page needs of a result. */
export function makeLattice(columns) {
  const grid = makeGrid(columns);
  const cells = makeCells(columns, grid);
  const placed = makePositions(columns);
  return {
    columns,
    grid,
    ...cells,
    ...placed,
    coarse: makeCoarse(columns, grid, cells.cellOfNode, cells.index),
    normal: makeNormals(placed.position, cells.index),
    sides: makeSides(columns, grid, cells.cellOfNode),
    places: interleave(columns['nodes.i'], columns['nodes.j']),
  };
}

/** The buffers of a lattice, to hand over instead of copying. */
export function buffersOf(lattice) {
  const own = [lattice.grid.nodes, lattice.index, lattice.cellOfNode, lattice.position];
  const all = [
    ...own,
    lattice.normal,
    lattice.sides,
    lattice.places,
    ...(lattice.coarse ? [lattice.coarse] : []),
    ...Object.values(lattice.columns),
  ];
  return all.map((array) => array.buffer);
}
