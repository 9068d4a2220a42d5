// SPDX-License-Identifier: MIT
// The pointer over a pane: what it is on, looked for once a frame, on a slow graphics card when it
// rests; clicks, which move it hardly; and what is dragged where dragging does not turn the picture.
const CLICK = 5; // pixels that a click may move
const HOVER_REST_MS = 120; // before a slow graphics card looks for what it is on, and as long as it
// takes for a picture

/** `onHover(event)`, null when it leaves; `onClick(event)`, `onTwice(event)`; while `sweeps()`,
 *  `onSweep(event)` in place of turning; `onLooking(on)`: something is still to be looked for. */
export function followPointer(stage, pane, handlers) {
  const { onHover, onClick, onTwice = () => {}, onLooking = () => {} } = handlers;
  const { sweeps = () => false, onSweep } = handlers;
  let pressed = null;
  let frame = 0;
  let rest = 0;
  let last = null;
  const look = () => {
    frame = 0;
    onHover(last);
    onLooking(false);
  };
  const forget = () => {
    clearTimeout(rest);
    if (!frame) onLooking(false);
  };
  const move = ({ clientX, clientY }) => {
    last = { clientX, clientY };
    if (frame) return;
    forget();
    onLooking(true);
    if (stage.slow) rest = setTimeout(look, Math.max(HOVER_REST_MS, stage.cost));
    else frame = requestAnimationFrame(look);
  };
  const { element } = pane;
  element.addEventListener('pointermove', (event) => {
    if (!event.buttons) move(event);
    else if (sweeps()) onSweep(event);
  });
  element.addEventListener('pointerleave', () => {
    cancelAnimationFrame(frame);
    frame = 0;
    forget();
    onHover(null);
  });
  element.addEventListener(
    'pointerdown',
    (event) => {
      pressed = [event.clientX, event.clientY];
      forget();
      pane.controls.enabled = !sweeps();
    },
    true,
  );
  element.addEventListener('pointerup', (event) => {
    const [x, y] = pressed ?? [Infinity, Infinity];
    pressed = null;
    if (event.button === 0 && Math.hypot(event.clientX - x, event.clientY - y) < CLICK)
      onClick(event);
    move(event); // it rests there now
  });
  element.addEventListener('dblclick', onTwice);
}
