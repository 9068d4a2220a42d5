// SPDX-License-Identifier: MIT
// Measuring: the distance of two nodes that are picked, in space and along the yarns, with a line
// over the picture; and the bar that tells how large things are.
import { element } from './dom.js';
import { format, withUnit } from './fields.js';

const BAR = 120; // pixels that the bar has at most

export class Measure {
  constructor() {
    this.on = false;
    this.nodes = [];
  }

  /** Begins or ends measuring; whether it is on. */
  toggle(on = !this.on) {
    this.on = on;
    this.nodes = [];
    element('measure').setAttribute('aria-pressed', String(on));
    element('measured').textContent = on ? 'Click on two nodes.' : '';
    return on;
  }

  /** Takes a node of the lattice; a third one begins anew. */
  pick(drape, node, unit) {
    if (this.nodes.length === 2) this.nodes = [];
    this.nodes.push(node);
    element('measured').textContent =
      this.nodes.length === 2 ? describe(drape, this.nodes, unit) : 'Now click on the second node.';
  }

  /** Draws the line between the nodes; `project(node)` gives the pixels of one. */
  draw(project) {
    const line = element('measure-line');
    const shown = this.nodes.length === 2;
    line.parentNode.toggleAttribute('hidden', !shown);
    if (!shown) return;
    this.nodes.map(project).forEach(({ x, y }, k) => {
      line.setAttribute(`x${k + 1}`, x.toFixed(1));
      line.setAttribute(`y${k + 1}`, y.toFixed(1));
    });
  }
}

/** "83.2 mm straight; 12 warp and 40 weft steps, 41.8 mm of cloth as the crow flies". */
function describe({ lattice, spacing }, [a, b], unit) {
  const { position, places } = lattice;
  const gap = [0, 1, 2].map((axis) => position[3 * b + axis] - position[3 * a + axis]);
  const [warp, weft] = [0, 1].map((axis) => Math.abs(places[2 * b + axis] - places[2 * a + axis]));
  const cloth = Math.hypot(warp * spacing[0], weft * spacing[1]);
  const length = (value) => withUnit(format(value), unit);
  return `${length(Math.hypot(...gap))} straight; ${warp} steps along the warp, ${weft} along the weft, ${length(cloth)} in the flat pattern`;
}

/** A bar of a round length, when a unit of length takes `pixels`. */
export function drawBar(pixels, unit) {
  const most = BAR / pixels;
  const power = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].find((factor) => factor * power <= most) * power;
  const bar = element('ruler');
  bar.hidden = !Number.isFinite(length);
  if (bar.hidden) return;
  bar.style.width = `${(length * pixels).toFixed(1)}px`;
  bar.textContent = withUnit(format(length), unit);
}
