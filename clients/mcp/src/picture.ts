// SPDX-License-Identifier: MIT
// Pictures as PNG: drawings of the daemon, and polygons in space seen from two sides.
import { Resvg } from '@resvg/resvg-js';
import { PNG } from 'pngjs';

const LONGEST = 1000; // side of a picture, in pixels
const SIDE = 500; // of each of the two views
const MARGIN = 24;
const LEGIBLE = 2; // a face no wider than twice so many pixels has no label
const DOT: [number, number][] = [
  [6, 0],
  [3, 6],
]; // the other corners of a point

/** A drawing as PNG. */
export function drawn(svg: string): Uint8Array {
  const { width, height } = new Resvg(svg);
  const mode = width >= height ? 'width' : 'height';
  const font = { defaultFontFamily: 'Liberation Sans' };
  return new Resvg(svg, { fitTo: { mode, value: LONGEST }, background: 'white', font })
    .render()
    .asPng();
}

/** The first drawing in a page of the daemon, with the page's styles. */
export function drawnOf(page: string): Uint8Array {
  const style = /<style>[^<]*<\/style>/.exec(page)?.[0] ?? '';
  const svg = /<svg([^>]*)>(.*?)<\/svg>/s.exec(page);
  if (!svg) throw new Error('The page has no drawing.');
  return drawn(`<svg xmlns="http://www.w3.org/2000/svg" ${svg[1]}>${style}${svg[2]}</svg>`);
}

type Colour = [number, number, number];

/** A polygon in space, or a point; those with the same `label` are told apart from others. */
export interface Facet {
  corners: number[][];
  colour: Colour;
  label: string;
}

/** Orthogonal axes of a view: to the right, up, to the eye. */
type View = [number[], number[], number[]];
const unit = (a: number[]) => a.map((x) => x / Math.hypot(...a));
const cross = ([a = 0, b = 0, c = 0]: number[], [d = 0, e = 0, f = 0]: number[]) => [
  b * f - c * e,
  c * d - a * f,
  a * e - b * d,
];
const dot = (a: number[], b: number[]) => a.reduce((sum, x, k) => sum + x * b[k]!, 0);
function viewFrom(eye: number[]): View {
  const to = unit(eye);
  const right = unit(cross([0, 0, 1], to));
  return [right, cross(to, right), to];
}
const VIEWS: [string, View][] = [
  ['from above, +x −y', viewFrom([0.5, -0.75, 0.75])],
  ['from below, −x +y', viewFrom([-0.5, 0.75, -0.75])],
];

/** What a view shows at each pixel: the number of a facet, -1 for none, and how near it is. */
class Raster {
  readonly facet = new Int32Array(SIDE * SIDE).fill(-1);
  readonly depth = new Float64Array(SIDE * SIDE).fill(-Infinity);

  /** A triangle of pixels and depths: by its edge functions, all of one sign inside. */
  fill(number: number, [a, b, c]: [number[], number[], number[]]): void {
    const [ax, ay, bx, by, cx, cy] = [a[0]!, a[1]!, b[0]!, b[1]!, c[0]!, c[1]!];
    const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (area === 0) return;
    const [left, right] = [Math.floor(Math.min(ax, bx, cx)), Math.ceil(Math.max(ax, bx, cx))];
    const [low, high] = [Math.floor(Math.min(ay, by, cy)), Math.ceil(Math.max(ay, by, cy))];
    for (let y = low; y <= high; y++)
      for (let x = left; x <= right; x++) {
        const s = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area;
        const t = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area;
        if (s < 0 || t < 0 || s + t > 1) continue;
        const depth = s * a[2]! + t * b[2]! + (1 - s - t) * c[2]!;
        if (depth <= this.depth[y * SIDE + x]!) continue;
        this.depth[y * SIDE + x] = depth;
        this.facet[y * SIDE + x] = number;
      }
  }
}

/** The facets in a view, as large as the picture allows. */
function rasterOf(facets: Facet[], view: View): Raster {
  const seen = facets.map(({ corners }) => corners.map((p) => view.map((axis) => dot(p, axis))));
  const least = [Infinity, Infinity];
  const most = [-Infinity, -Infinity];
  for (const corner of seen.flat())
    for (const k of [0, 1]) {
      least[k] = Math.min(least[k]!, corner[k]!);
      most[k] = Math.max(most[k]!, corner[k]!);
    }
  const extent = Math.max(most[0]! - least[0]!, most[1]! - least[1]!) || 1;
  const scale = (SIDE - 2 * MARGIN) / extent;
  const pixel = ([x = 0, y = 0, z = 0]: number[]) => [
    SIDE / 2 + scale * (x - (least[0]! + most[0]!) / 2),
    SIDE / 2 - scale * (y - (least[1]! + most[1]!) / 2),
    z,
  ];
  const raster = new Raster();
  seen.forEach((corners, number) => {
    const at = corners.map(pixel);
    if (at.length === 1)
      for (const [x, y] of DOT) at.push([at[0]![0]! + x, at[0]![1]! + y, at[0]![2]!]);
    for (let k = 2; k < at.length; k++) raster.fill(number, [at[0]!, at[k - 1]!, at[k]!]);
  });
  return raster;
}

/** Lambert's shade of a facet under a light at the eye. */
function shadeOf({ corners: [a, b, c] }: Facet, to: number[]): number {
  if (!c) return 1;
  const edge = (p: number[], q: number[]) => p.map((x, k) => q[k]! - x);
  const normal = cross(edge(a!, b!), edge(a!, c!));
  return 0.45 + (0.55 * Math.abs(dot(normal, to))) / (Math.hypot(...normal) || 1);
}

/** A view as PNG: facets in their shade, dark between different labels. */
function shaded(facets: Facet[], { facet }: Raster, to: number[]): string {
  const png = new PNG({ width: SIDE, height: SIDE });
  const shades = facets.map((each) => shadeOf(each, to));
  const label = (at: number) => facets[facet[at]!]?.label;
  for (let at = 0; at < SIDE * SIDE; at++) {
    const { colour = [1, 1, 1] } = facets[facet[at]!] ?? {};
    const edge = at >= SIDE && (label(at) !== label(at - 1) || label(at) !== label(at - SIDE));
    const light = edge ? 0.15 : (shades[facet[at]!] ?? 1);
    colour.forEach((part, k) => (png.data[4 * at + k] = 255 * light * part));
    png.data[4 * at + 3] = 255;
  }
  return PNG.sync.write(png).toString('base64');
}

/** Of each label that is seen its pixel that is furthest from all others, by city blocks: two passes
 *  carry the distance to where another label or the margin begins (Rosenfeld and Pfaltz, 1966). */
function placesOf(facets: Facet[], { facet }: Raster): Map<string, [number, number]> {
  const labels = [...new Set(facets.map(({ label }) => label))].filter(Boolean);
  if (labels.length === 0) return new Map();
  const numbers = facets.map(({ label }) => labels.indexOf(label));
  const shown = facet.map((each) => numbers[each] ?? -1);
  const far = new Int32Array(SIDE * SIDE).fill(1);
  const pass = (at: number, step: number) =>
    Math.min(
      shown[at + step] === shown[at] ? far[at + step]! + 1 : 1,
      shown[at + SIDE * step] === shown[at] ? far[at + SIDE * step]! + 1 : 1,
    );
  for (let at = SIDE; at < SIDE * SIDE; at++) far[at] = pass(at, -1);
  const places = new Map<string, number>();
  for (let at = SIDE * (SIDE - 1) - 1; at >= 0; at--) {
    far[at] = Math.min(far[at]!, pass(at, 1));
    const label = labels[shown[at]!];
    if (label && far[at]! > (far[places.get(label) ?? -1] ?? LEGIBLE)) places.set(label, at);
  }
  return new Map([...places].map(([name, at]) => [name, [at % SIDE, Math.floor(at / SIDE)]]));
}

const escaped = (text: string) => text.replace(/[<>&]/g, (sign) => `&#${sign.charCodeAt(0)};`);

/** Facets seen from two opposite sides, with their labels where they are seen; `title` below. */
export function pictured(facets: Facet[], title: string): Uint8Array {
  const views = VIEWS.map(([name, view], k) => {
    const raster = rasterOf(facets, view);
    const labels = [...placesOf(facets, raster)].map(
      ([label, [x, y]]) => `<text x="${x}" y="${y + 5}">${escaped(label)}</text>`,
    );
    return `<g transform="translate(${k * SIDE} 0)">
      <image width="${SIDE}" height="${SIDE}"
        href="data:image/png;base64,${shaded(facets, raster, view[2])}"/>
      <g font-weight="700" stroke="#fff" stroke-width="3" paint-order="stroke"
        text-anchor="middle">${labels.join('')}</g>
      <text x="${MARGIN}" y="${SIDE + 12}" fill="#566072">${name}</text></g>`;
  });
  return drawn(`<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${2 * SIDE} ${SIDE + 50}"
    font-family="Liberation Sans" font-size="15" fill="#1b2330">${views.join('')}
    <text x="${MARGIN}" y="${SIDE + 38}" font-size="17">${escaped(title)}</text></svg>`);
}

/** Viridis by its five fifths, 0 to 1. */
const VIRIDIS: Colour[] = [
  [0.267, 0.005, 0.329],
  [0.229, 0.322, 0.546],
  [0.128, 0.567, 0.551],
  [0.369, 0.789, 0.383],
  [0.993, 0.906, 0.144],
];
export function viridis(share: number): Colour {
  const at = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const k = Math.min(Math.floor(at), VIRIDIS.length - 2);
  const [a, b] = [VIRIDIS[k]!, VIRIDIS[k + 1]!];
  return [0, 1, 2].map((c) => a[c]! + (at - k) * (b[c]! - a[c]!)) as Colour;
}

/** Colours that neighbours can be told by, from a hue that turns by the golden angle. */
export function colourOf(number: number): Colour {
  const hue = (number * 137.508) % 360;
  const part = (shift: number) => 0.72 + 0.2 * Math.cos(((hue - shift) * Math.PI) / 180);
  return [part(0), part(120), part(240)];
}
