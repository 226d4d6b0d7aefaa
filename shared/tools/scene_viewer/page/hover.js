// The name of what is pointed at, or tapped.
import { byId } from './dom.js';

const kLook_ms = 60;
const kTapShown_ms = 3000;
const kTap_px = 8;  // a finger that moved farther turned the camera

/// The name of a body, as the scene's file of surfaces tells it.
export const body_name = (scene, body) => scene?.surfaces?.names?.[body] ?? `body ${body}`;

export class Hover {
  #due_ms = 0;
  #down = null;
  #hide = 0;

  /// canvas: of the picture. pick(x, y): { body } or { hand } or null. name_of(picked): its words.
  constructor(canvas, pick, name_of) {
    Object.assign(this, { canvas, pick, name_of });
    canvas.addEventListener('pointermove', (event) => {
      if (event.pointerType === 'touch' || event.buttons || event.timeStamp < this.#due_ms) return;
      this.#due_ms = event.timeStamp + kLook_ms;
      this.show(event.offsetX, event.offsetY);
    });
    canvas.addEventListener('pointerleave', (event) => { if (event.pointerType !== 'touch') this.hide(); });
    canvas.addEventListener('pointerdown', (event) => {
      this.#down = [event.offsetX, event.offsetY];
      this.hide();
    });
    canvas.addEventListener('pointerup', (event) => {
      if (!this.#down) return;
      const moved_px = Math.hypot(event.offsetX - this.#down[0], event.offsetY - this.#down[1]);
      this.#down = null;
      if (moved_px > kTap_px) return;
      this.show(event.offsetX, event.offsetY);
      if (event.pointerType === 'touch') this.#hide = setTimeout(() => this.hide(), kTapShown_ms);
    });
  }

  hide() {
    clearTimeout(this.#hide);
    byId('tooltip').hidden = true;
  }

  /// x, y: pixels of the canvas.
  show(x, y) {
    this.hide();
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const picked = this.pick(2 * x / width - 1, 1 - 2 * y / height);
    if (!picked) return;
    const tip = byId('tooltip');
    tip.textContent = this.name_of(picked);
    tip.hidden = false;
    tip.style.left = `${Math.max(4, Math.min(x + 14, width - tip.offsetWidth - 4))}px`;
    tip.style.top = `${Math.max(4, Math.min(y + 14, height - tip.offsetHeight - 4))}px`;
  }
}
