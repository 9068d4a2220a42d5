// SPDX-License-Identifier: MIT
// A knob over the picture: dragged, or moved with the arrow keys, it goes over the part.

const STEPS = { ArrowLeft: [-8, 0], ArrowRight: [8, 0], ArrowUp: [0, -8], ArrowDown: [0, 8] };

/** A button that says `begin()`, `move(place, event)` for every place, null beside the part, and, where one was taken, `end(kept)`, false of a drag that was broken off; `remove()` at Delete, if given. `again()`: the
 *  button that has its place after a move by a key, which made all anew. */
export function makeKnob(view, { label, kind, begin, move, end, remove, again }) {
  const knob = Object.assign(document.createElement('button'), { type: 'button' });
  knob.className = `handle ${kind}`;
  knob.setAttribute('aria-label', label);
  let held = false;
  let moved = false;
  const hold = () => {
    held = true;
    moved = false;
    begin();
  };
  const go = (event) => {
    if (move(view.placeAt(event), event)) moved = true;
  };
  const release = (keeps) => {
    if (held && moved) end(keeps);
    held = false;
  };
  knob.addEventListener('pointerdown', (event) => {
    event.stopPropagation();
    knob.setPointerCapture(event.pointerId);
    hold();
  });
  knob.addEventListener('pointermove', (event) => held && go(event));
  knob.addEventListener('pointerup', (event) => {
    event.stopPropagation();
    release(true);
  });
  knob.addEventListener('pointercancel', () => release(false));
  knob.addEventListener('keydown', (event) => {
    const removes = remove && event.key === 'Delete';
    if (!STEPS[event.key] && !removes) return;
    event.preventDefault();
    event.stopPropagation();
    if (removes) return remove();
    const box = knob.getBoundingClientRect();
    const [x, y] = STEPS[event.key];
    hold();
    go({ clientX: box.x + box.width / 2 + x, clientY: box.y + box.height / 2 + y });
    release(true);
    again()?.focus();
  });
  return knob;
}

/** Puts a knob where it is in the picture. */
export function putKnob(knob, { x, y }) {
  knob.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
}
