// SPDX-License-Identifier: MIT
// The section by a plane: what lies beyond it is not drawn. One plane for all pictures in 3D, in the
// coordinates of their scenes.
import * as THREE from './three.module.min.js';

const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

/** The uniform of the plane: its normal, and how far along it is kept. */
export const plane = { value: new THREE.Vector4(0, 0, 0, 1) };

/** For a vertex shader: the place in the scene, and its declaration. */
export const declare = 'out vec3 placed;';
export const place = 'placed = (modelMatrix * vec4(position, 1.0)).xyz;';

/** For a fragment shader. */
export const declareCut = 'in vec3 placed; uniform vec4 plane;';
export const cut = 'if (dot(plane.xyz, placed) > plane.w) discard;';

/** Cuts at `share` (0..1) of a body of `size` about the origin along an axis; '' cuts nothing. */
export function setSection(axis, share, size) {
  const normal = AXES[axis];
  if (!normal) return plane.value.set(0, 0, 0, 1);
  const length = size[Object.keys(AXES).indexOf(axis)];
  return plane.value.set(...normal, (share - 0.5) * length * 1.0001);
}
