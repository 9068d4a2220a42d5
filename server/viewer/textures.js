// SPDX-License-Identifier: MIT
// The colour maps on the graphics card, shared by all that is coloured by a field.
import * as THREE from './three.module.min.js';
import { maps } from './colour.js';

function textureOf(bytes) {
  const texture = new THREE.DataTexture(bytes, bytes.length / 4, 1);
  texture.needsUpdate = true;
  return texture;
}

export const textures = {
  sequential: textureOf(maps.sequential),
  diverging: textureOf(maps.diverging),
  pieces: textureOf(maps.pieces),
};
