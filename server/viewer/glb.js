// SPDX-License-Identifier: MIT
// The preview of a surface: binary glTF with one primitive a face. Runs in the worker.

const MAGIC = 0x46546c67;
const TYPES = { 5126: Float32Array, 5125: Uint32Array, 5123: Uint16Array };
const WIDTHS = { SCALAR: 1, VEC3: 3 };

/** The description and the buffer. */
function chunksOf(buffer) {
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== MAGIC)
    throw new Error('The preview that the service sent is not glTF.');
  const length = view.getUint32(12, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, 20, length));
  return { description: JSON.parse(text), start: 28 + length };
}

/** The primitives: {face, position, normal, index}. */
export function readGlb(buffer) {
  const { description, start } = chunksOf(buffer);
  const { accessors, bufferViews, meshes } = description;
  const read = (number) => {
    const { bufferView, byteOffset = 0, componentType, count, type } = accessors[number];
    const offset = start + (bufferViews[bufferView].byteOffset || 0) + byteOffset;
    return new TYPES[componentType](buffer, offset, count * WIDTHS[type]);
  };
  return meshes[0].primitives.map(({ attributes, indices, extras }, k) => ({
    face: extras?.face ?? k,
    position: read(attributes.POSITION),
    normal: attributes.NORMAL === undefined ? null : read(attributes.NORMAL), // a mesh has none
    index: read(indices),
  }));
}
