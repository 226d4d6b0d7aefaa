// What a mouse or fingers do on a plot: point, turn the wheel, drag, pinch, click twice.

const kTwice_ms = 450;  // between two clicks, or taps, that are one double
const kTwice_px = 12;
const kWheelStep = 1.0015;  // a pixel of the wheel's way

/// actions: point(x or null), zoom(factor, x), pan(pixels), reset(). on_change(): after each of them.
export function watch_gestures(canvas, actions, on_change) {
  const fingers = new Map();  // what is down: where it was seen last
  let tap = { time_ms: -Infinity, x: 0 };  // the last
  const act = (action, ...values) => {
    actions[action](...values);
    on_change();
  };
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { apart: Math.max(Math.abs(a.x - b.x), 8), middle: (a.x + b.x) / 2 };
  };

  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const pixels = event.deltaMode === 0 ? event.deltaY : 30 * event.deltaY;
    act('zoom', kWheelStep ** Math.min(Math.max(pixels, -400), 400), event.offsetX);
  }, { passive: false });
  canvas.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.offsetX, from: event.offsetX });
  });
  canvas.addEventListener('pointermove', (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) return act('point', event.offsetX);
    const before = fingers.size === 2 ? spread() : null;
    const moved = event.offsetX - finger.x;
    finger.x = event.offsetX;
    if (!before) return act('pan', moved);
    const after = spread();
    actions.pan(after.middle - before.middle);
    act('zoom', before.apart / after.apart, after.middle);
  });
  canvas.addEventListener('pointercancel', (event) => fingers.delete(event.pointerId));
  canvas.addEventListener('pointerup', (event) => {
    const finger = fingers.get(event.pointerId);
    fingers.delete(event.pointerId);
    if (!finger || Math.abs(event.offsetX - finger.from) > kTwice_px) return;
    // Not by 'dblclick', which fingers do not make everywhere.
    const is_double = event.timeStamp - tap.time_ms < kTwice_ms && Math.abs(event.offsetX - tap.x) < kTwice_px;
    tap = { time_ms: is_double ? -Infinity : event.timeStamp, x: event.offsetX };
    if (is_double) act('reset');
  });
  canvas.addEventListener('pointerleave', () => act('point', null));
}
