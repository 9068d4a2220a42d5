// SPDX-License-Identifier: MIT
// A mesh with its fields from the service's VTU: VTK XML with raw appended arrays, 64-bit lengths.
// Runs in the worker.

const TYPES = {
  Float64: Float64Array,
  Int64: BigInt64Array,
  Int32: Int32Array,
  UInt8: Uint8Array,
};
const START = '<AppendedData encoding="raw">';

/** {columns by name, points, connectivity, offsets}: numbers; vectors as name_x, name_y, name_z. */
export function readVtu(buffer) {
  const head = new TextDecoder('latin1').decode(
    new Uint8Array(buffer, 0, Math.min(buffer.byteLength, 65536)),
  );
  const begin = head.indexOf('_', head.indexOf(START)) + 1;
  const view = new DataView(buffer);
  const arrays = {};
  for (const [tag] of head.slice(0, begin).matchAll(/<DataArray [^>]*>/g)) {
    const of = (key) => new RegExp(`${key}="([^"]*)"`).exec(tag)[1];
    const at = begin + Number(of('offset'));
    const length = Number(view.getBigUint64(at, true));
    const values = new TYPES[of('type')](buffer.slice(at + 8, at + 8 + length));
    arrays[of('Name')] = {
      width: Number(of('NumberOfComponents')),
      values: of('type') === 'Int64' ? Float64Array.from(values, Number) : values,
    };
  }
  const { Points, connectivity, offsets, types, ...fields } = arrays;
  const columns = Object.fromEntries(
    Object.entries(fields)
      .filter(([, { width }]) => width === 1)
      .map(([name, { values }]) => [name, values]),
  );
  return {
    columns,
    points: Points.values,
    connectivity: connectivity.values,
    offsets: offsets.values,
  };
}
