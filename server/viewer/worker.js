// SPDX-License-Identifier: MIT
// Work that would hold up the page: reading files and results, in a thread of its own.
import { readNpz } from './npz.js';
import { buffersOf, makeLattice } from './lattice.js';
import { makeDifference } from './difference.js';
import { buffersOf as buffersOfBody, elementsOf, facesOf, shapeOf, tilesOf } from './facets.js';
import { isSurface, makeShape, unwrap } from './shape.js';

const WORK = 'draped-work';

function parse(text) {
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(
      `This is not JSON: ${error.message}. Choose a surface or a drape request as a JSON file.`,
    );
  }
}

/** A file's text into the request's settings and the surface, as text and as triangles; of a file of
 *  the page's whole work also the rest of it, as `work`. */
function readRequest({ text, surfaceText }) {
  const document = parse(text);
  if (document?.format !== WORK) return readDocument(unwrap(document), surfaceText);
  const { request, ...work } = document;
  const stored = work.surface && JSON.stringify(work.surface);
  return { ...readDocument(request, stored), stored, work };
}

function readDocument(document, surfaceText) {
  const whole = Boolean(document && typeof document === 'object' && 'surface' in document);
  const { surface: inner, ...rest } = whole ? document : { surface: document };
  const surface = unwrap(surfaceText ? parse(surfaceText) : inner);
  const settings = whole ? rest : {};
  if (whole && surface && 'id' in surface && !isSurface(surface))
    return { settings, surfaceText: JSON.stringify(inner), named: surface.id, shape: null };
  if (Array.isArray(surface?.faces)) {
    const { length } = surface.faces;
    return {
      settings,
      surfaceText: JSON.stringify(inner),
      shape: null,
      faces: length,
      definition: surfaceText || JSON.stringify(surface),
      selection: inner.id ? inner : {},
    };
  }
  if (!isSurface(surface))
    throw new Error(
      'This JSON is not a surface: that needs degree_u, knotvector_u, control_points and so on, ' +
        'or vertices and triangles, or a drape request around them.',
    );
  let shape = null;
  let fault = '';
  try {
    shape = makeShape(surface);
  } catch (error) {
    fault = error.message;
  }
  return { settings, surfaceText: JSON.stringify(surfaceText ? inner : surface), shape, fault };
}

function shapeBuffers(shape) {
  return ['position', 'normal', 'index', 'edges', 'uv', 'mask'].flatMap((k) =>
    shape?.[k] ? [shape[k].buffer] : [],
  );
}

const tasks = {
  request(input) {
    const answer = readRequest(input);
    return [answer, shapeBuffers(answer.shape)];
  },
  net({ buffer }) {
    const lattice = makeLattice(readNpz(buffer));
    return [lattice, buffersOf(lattice)];
  },
  faces({ buffer }) {
    const body = facesOf(buffer);
    return [body, buffersOfBody(body)];
  },
  elements({ buffer }) {
    const body = elementsOf(buffer);
    return [body, buffersOfBody(body)];
  },
  tiles({ shape, places }) {
    const body = tilesOf(shape, places);
    return [body, buffersOfBody(body)];
  },
  some({ body, chosen, about }) {
    const shape = shapeOf(body, chosen, about);
    return [shape, shapeBuffers(shape)];
  },
  difference(input) {
    const values = makeDifference(input);
    return [values, [values.buffer]];
  },
};

self.onmessage = ({ data: { task, number, input } }) => {
  try {
    const [answer, buffers] = tasks[task](input);
    self.postMessage({ number, answer }, buffers);
  } catch (error) {
    self.postMessage({ number, error: error.message });
  }
};
