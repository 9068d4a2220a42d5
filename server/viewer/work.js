// SPDX-License-Identifier: MIT
// The page's side of the worker: one promise a task.
import { makeLattice } from './lattice.js';
import { readNpz } from './npz.js';

const SMALL = 1.5e6; // bytes

let worker;
let count = 0;
const waiting = new Map();

function start() {
  worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
  worker.onmessage = ({ data }) => {
    const { done, failed } = waiting.get(data.number);
    waiting.delete(data.number);
    if (data.error) failed(new Error(data.error));
    else done(data.answer);
  };
  worker.onerror = (event) => {
    for (const { failed } of waiting.values())
      failed(
        new Error(
          event.message || 'The page ran out of memory. Use a greater spacing or a smaller file.',
        ),
      );
    waiting.clear();
    worker.terminate();
    worker = null;
  };
}

function ask(task, input, transfer = []) {
  if (!worker) start();
  const number = ++count;
  return new Promise((done, failed) => {
    waiting.set(number, { done, failed });
    worker.postMessage({ task, number, input }, transfer);
  });
}

/** A file's text (and that of the stored surface which it names): settings, surface, shape. */
export const readRequest = (text, surfaceText) => ask('request', { text, surfaceText });

/** The columns of a result, ready to draw; takes the buffer over. A small one is read here, which
 *  is done before the worker has it. */
export async function readNet(buffer) {
  return buffer.byteLength < SMALL
    ? makeLattice(readNpz(buffer))
    : ask('net', { buffer }, [buffer]);
}

/** What `makeDifference` takes; the values of this minus those of the other. */
export const readDifference = (input) => ask('difference', input);

/** The faces of a preview, and the elements of a VTU with their columns, as `facets.js` makes them;
 *  they take the buffers over. */
export const readFaces = (buffer) => ask('faces', { buffer }, [buffer]);
export const readElements = (buffer) => ask('elements', { buffer }, [buffer]);

/** Some faces as a shape to drape on. */
export const readShape = (body, chosen, about) => ask('some', { body, chosen, about });

/** A shape in tiles, one round each place. */
export const readTiles = (shape, places) => ask('tiles', { shape, places });
