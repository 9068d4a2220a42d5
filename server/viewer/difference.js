// SPDX-License-Identifier: MIT
// The difference of two drapes, cell by cell of the first: the other's value at the same place is
// the mean of the cells around it, weighted by 1 / distance². Runs in the worker.
import { NO_VALUE } from './lattice.js';

const CLOSE = 1e-6; // of the reach: the same place

/** Cells by the cube of side `reach` that they lie in. */
function makeCubes(centres, shift, reach) {
  const cubes = new Map();
  for (let cell = 0; cell < centres.length / 3; cell++) {
    const place = [0, 1, 2].map((axis) =>
      Math.floor((centres[3 * cell + axis] + shift[axis]) / reach),
    );
    const key = place.join();
    if (cubes.has(key)) cubes.get(key).push(cell);
    else cubes.set(key, [cell]);
  }
  return cubes;
}

function* cellsAround(cubes, point, reach) {
  const [a, b, c] = point.map((value) => Math.floor(value / reach));
  for (let x = a - 1; x <= a + 1; x++)
    for (let y = b - 1; y <= b + 1; y++)
      for (let z = c - 1; z <= c + 1; z++) yield* cubes.get(`${x},${y},${z}`) || [];
}

/** `one` and `two`: {centres, values} of the cells; `shift` moves those of two to the origin of one;
 *  cells of two further away than `reach` do not count. */
export function makeDifference({ one, two, shift, reach }) {
  const cubes = makeCubes(two.centres, shift, reach);
  const difference = new Float32Array(one.values.length).fill(NO_VALUE);
  const least = (CLOSE * reach) ** 2;
  for (let cell = 0; cell < one.values.length; cell++) {
    const point = [...one.centres.subarray(3 * cell, 3 * cell + 3)];
    let weights = 0;
    let sum = 0;
    for (const other of cellsAround(cubes, point, reach)) {
      let square = 0;
      for (let axis = 0; axis < 3; axis++)
        square += (two.centres[3 * other + axis] + shift[axis] - point[axis]) ** 2;
      if (square > reach * reach) continue;
      weights += 1 / (square + least);
      sum += two.values[other] / (square + least);
    }
    if (weights) difference[cell] = one.values[cell] - sum / weights;
  }
  return difference;
}
