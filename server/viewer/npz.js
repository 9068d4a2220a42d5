// SPDX-License-Identifier: MIT
// Reads the service's results in NumPy's format: a zip that is not compressed, of one float64
// array a column. Works through the directory at the end, with 64-bit sizes where they are used.

const END = 0x06054b50;
const ENTRY = 0x02014b50;
const LARGE = 0xffffffff;

function findEnd(view) {
  for (let at = view.byteLength - 22; at >= 0; at--)
    if (view.getUint32(at, true) === END) return at;
  throw new Error('the result is cut off');
}

/** The size and place of an entry, from its 64-bit field where they do not fit into 32 bits. */
function extent(view, at) {
  const nameLength = view.getUint16(at + 28, true);
  let size = view.getUint32(at + 24, true);
  let offset = view.getUint32(at + 42, true);
  let field = at + 46 + nameLength + 4;
  if (size === LARGE) {
    size = Number(view.getBigUint64(field, true));
    field += view.getUint32(at + 20, true) === LARGE ? 16 : 8;
  }
  if (offset === LARGE) offset = Number(view.getBigUint64(field, true));
  return { size, offset };
}

function readArray(buffer, view, { size, offset }) {
  const start = offset + 30 + view.getUint16(offset + 26, true) + view.getUint16(offset + 28, true);
  const header = 10 + view.getUint16(start + 8, true);
  return new Float64Array(buffer.slice(start + header, start + size));
}

/** {'nodes.x': Float64Array, ...} */
export function readNpz(buffer) {
  const view = new DataView(buffer);
  const end = findEnd(view);
  const columns = {};
  let at = view.getUint32(end + 16, true);
  if (at === LARGE) throw new Error('the result is too large for a browser');
  while (at < end && view.getUint32(at, true) === ENTRY) {
    const lengths = [28, 30, 32].map((k) => view.getUint16(at + k, true));
    const name = new TextDecoder().decode(new Uint8Array(buffer, at + 46, lengths[0]));
    columns[name.replace(/\.npy$/, '')] = readArray(buffer, view, extent(view, at));
    at += 46 + lengths[0] + lengths[1] + lengths[2];
  }
  return columns;
}
