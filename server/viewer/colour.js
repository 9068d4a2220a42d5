// SPDX-License-Identifier: MIT
// Colour maps whose lightness grows evenly, so that equal steps of a value look equal.
//
// `sequential` is viridis (Smith and van der Walt, 2015, CC0), from the same ten colours as the
// service's glb. `diverging`, for signed values, is made here in OKLab (Ottosson, 2020): from dark
// blue over a light middle to dark red, lightness linear on both sides and equal at both ends.

const SIZE = 256;
const VIRIDIS = '440154 482878 3e4a89 31688e 26828e 1f9e89 35b779 6dcd59 b4de2c fde725';

function rgbOf(hex) {
  return [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16));
}

const mix = (a, b, t) => a.map((value, k) => value + (b[k] - value) * t);

function sample(stops, t) {
  const place = Math.min(Math.max(t, 0), 1) * (stops.length - 1);
  const step = Math.min(Math.floor(place), stops.length - 2);
  return mix(stops[step], stops[step + 1], place - step);
}

const encode = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);

/** sRGB, 0..255, of OKLab (lightness, a, b). */
function fromOklab([lightness, a, b]) {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  return linear.map((x) => 255 * encode(Math.min(Math.max(x, 0), 1)));
}

function polar(lightness, chroma, hueDegrees) {
  const hue = (hueDegrees * Math.PI) / 180;
  return [lightness, chroma * Math.cos(hue), chroma * Math.sin(hue)];
}

function table(colourAt) {
  const bytes = new Uint8Array(SIZE * 4);
  for (let k = 0; k < SIZE; k++) {
    const rgb = colourAt(k / (SIZE - 1)).map(Math.round);
    bytes.set([...rgb, 255], 4 * k);
  }
  return bytes;
}

/** Of pieces of cloth side by side, told apart by everyone (Okabe and Ito, 2008). */
const PIECES = '56b4e9 e69f00 009e73 f0e442 cc79a7 0072b2 d55e00 999999'.split(' ').map(rgbOf);

const stops = VIRIDIS.split(' ').map(rgbOf);
const arms = [polar(0.38, 0.15, 255), [0.95, 0, 0], polar(0.38, 0.15, 25)];

/** RGBA bytes of 256 colours. */
export const maps = {
  sequential: table((t) => sample(stops, t)),
  diverging: table((t) => fromOklab(sample(arms, t))),
  pieces: table((t) => PIECES[Math.min(Math.floor(t * PIECES.length), PIECES.length - 1)]),
};

/** The share of the map `pieces` at which the k-th colour is. */
export const shareOfPiece = (k) => ((k % PIECES.length) + 0.5) / PIECES.length;

/** The colour at `t` of 0..1 for a style sheet or an SVG. */
export function css(map, t) {
  const k = 4 * Math.round(Math.min(Math.max(t, 0), 1) * (SIZE - 1));
  return `rgb(${maps[map].slice(k, k + 3).join(' ')})`;
}
