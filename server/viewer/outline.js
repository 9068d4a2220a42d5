// SPDX-License-Identifier: MIT
// The boundary of a ply, drawn on the part with the pointer: a polygon of places of the surface, over
// the picture.
import { element } from './dom.js';

const HINT =
  'Click the corners of the boundary on the part. Enter or a double click ends, Escape leaves it as it was.';

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

  /** Begins a polygon; `take(points)` gets it once it has three corners and is ended. */
  begin(take) {
    this.points = [];
    this.taker = take;
    this.view.setDrawing({
      onPoint: (point) => {
        if (point) this.points.push(point);
        this.say(point ? HINT : `That is beside the part. ${HINT}`);
        this.view.stage.redraw();
      },
      onEnd: () => {
        this.points.pop(); // the second click of the two
        this.end(true);
      },
    });
    this.say(HINT);
  }

  end(keeps) {
    const { taker, points } = this;
    const whole = keeps && points.length >= 3;
    this.taker = null;
    if (!whole) this.points = [];
    this.view.setDrawing(null);
    this.say('');
    if (whole) taker(points);
  }

  /** Draws the corners and the lines between them; `project(point)` gives pixels. */
  draw(project) {
    const shape = element('outline');
    shape.parentNode.toggleAttribute('hidden', !this.points.length);
    shape.setAttribute(
      'points',
      this.points
        .map(project)
        .map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`)
        .join(' '),
    );
  }
}
