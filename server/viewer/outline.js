// SPDX-License-Identifier: MIT
// A line drawn on the part with the pointer, over the picture: the boundary of a ply, a polygon of
// places of the surface, or a cut, which is open.
import { element } from './dom.js';

const BOUNDARY = {
  least: 3,
  closed: true,
  hint: 'Click the corners of the boundary on the part. Enter or a double click ends, Escape leaves it as it was.',
};

export class Outline {
  /** `view` has the part; `say(text)` tells what to do, '' when there is nothing to say. */
  constructor(view, say) {
    Object.assign(this, { view, say });
    this.points = [];
    this.taker = null;
    document.addEventListener('keydown', (event) => {
      if (!this.taker || !['Enter', 'Escape'].includes(event.key)) return;
      event.preventDefault();
      event.stopPropagation();
      this.end(event.key === 'Enter');
    });
  }

  get on() {
    return this.taker !== null;
  }

  /** Begins a line; `take(points)` gets it once it is ended, and has as many points as its `kind`
   *  needs. `kind.first(point, event)`: where it begins that was clicked there, on the part or, of
   *  null, beside it; null for a `refusal`; `kind.next` likewise: where it goes on to; one of
   *  `kind.most` points is ended by the last; `kind.last(points)`: where it ends, null for a
   *  `lastRefusal`. */
  begin(take, kind = BOUNDARY) {
    this.points = [];
    this.taker = take;
    this.kind = kind;
    const { hint, first, next, refusal } = kind;
    this.view.setDrawing({
      onPoint: (clicked, event) => {
        const meant = this.points.length ? next : first;
        const point = meant ? meant(clicked, event) : clicked;
        if (point) this.points.push(point);
        if (this.points.length === kind.most) return this.end(true);
        this.say(point ? hint : `${clicked ? refusal : 'That is beside the part.'} ${hint}`);
        this.view.stage.redraw();
      },
      onEnd: () => {
        this.points.pop(); // the second click of the two
        this.end(true);
      },
    });
    this.say(hint);
  }

  end(keeps) {
    const { taker, points, kind } = this;
    const whole = keeps && points.length >= kind.least;
    const last = whole && kind.last ? kind.last(points) : points.at(-1);
    if (whole && !last) return this.say(`${kind.lastRefusal} ${kind.hint}`);
    if (whole) points[points.length - 1] = last;
    this.taker = null;
    if (!whole || !kind.closed) this.points = [];
    this.view.setDrawing(null);
    this.say('');
    if (whole) taker(points);
    else this.view.stage.redraw();
  }

  /** Draws the lines between the points; `project(point)` gives pixels. */
  draw(project) {
    const shape = element('outline');
    shape.parentNode.toggleAttribute('hidden', !this.points.length);
    if (!this.points.length) return;
    const pixels = this.points.map(project).map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`);
    shape.setAttribute('d', `M${pixels.join(' ')}${this.kind.closed ? 'Z' : ''}`);
    shape.classList.toggle('open', !this.kind.closed);
  }
}
