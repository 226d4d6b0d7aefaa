// Takes the hand by the mouse: the panel with its button and the force, and what pointer, wheel and keys do while
// the hand is held.
import { is_by_mouse } from './device.js';
import { byId, say } from './dom.js';
import { kHeldKeys, MouseHand } from './mouse_hand.js';

const kGrip = 1;
const kLeft = 0, kRight = 2;
const kEnabled = 2;  // STILLGRID_STATUS_ENABLED: somebody holds the device
const kTick_ms = 16;   // as a picture of 60 Hz
const kDepth_px = 12;  // of the wheel, a tick that a button for depth is held

const key_of = (event) => (event.key.length === 1 ? event.key.toLowerCase() : event.key);
const is_control = ({ target }) => ['BUTTON', 'SELECT', 'INPUT', 'SUMMARY'].includes(target.tagName);

export class MouseControls {
  #dragged = null;  // the pointer that moves the tool: { id, x, y }
  #depth = 0;       // buttons of the panel
  #timer = 0;       // while the hand is held

  /// view: a SceneView. link: { frame(), scene(), live(), is_live(), send(message), beacon(message) }.
  constructor(canvas, view, link) {
    Object.assign(this, { canvas, view, link });
    this.hand = new MouseHand(link.send, (line) => {
      this.#show_held();
      say(line);
    });
    byId('mouse-take').addEventListener('click', () => (this.is_held ? this.let_go() : this.take()));
    this.#on_hold('mouse-grip', (is_down) => this.#grip(is_down));
    this.#on_hold('mouse-nearer', (is_down) => { this.#depth = is_down ? kDepth_px : 0; });
    this.#on_hold('mouse-farther', (is_down) => { this.#depth = is_down ? -kDepth_px : 0; });
    canvas.addEventListener('pointerdown', (event) => this.#down(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (event) => this.#up(event));
    canvas.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    window.addEventListener('keydown', (event) => this.#key(event, true), { capture: true });
    window.addEventListener('keyup', (event) => this.#key(event, false), { capture: true });
    window.addEventListener('blur', () => this.hand.rest());
    document.addEventListener('visibilitychange', () => { if (document.hidden) this.let_go(); });
    window.addEventListener('pagehide', () => this.let_go());
  }

  get is_held() { return this.hand.aim !== null; }

  take() {
    const tool = this.link.frame()?.tool;
    if (!tool) return say('there is no tool yet');
    this.link.live();
    this.#timer = setInterval(() => this.#tick(performance.now()), kTick_ms);
    this.hand.take(tool, this.view.size_m, this.link.scene().device);
    this.#show_held();
    this.canvas.focus();
  }

  let_go() {
    if (!this.is_held) return;
    this.hand.let_go();
    this.link.beacon(this.hand.release);
    this.#show_held();
  }

  #show_held() {
    this.#dragged = null;
    this.#depth = 0;
    if (!this.is_held) clearInterval(this.#timer);
    byId('view').classList.toggle('held', this.is_held);
    byId('mouse-take').textContent = this.is_held ? 'Let go' : 'Take the hand';
    byId('mouse-take').setAttribute('aria-pressed', this.is_held);
    this.view.camera.leave_to_hand(this.is_held);
    this.view.show_aim(null);
  }

  #grip(is_down) {
    if (this.is_held) this.hand.buttons = is_down ? kGrip : 0;
  }

  #on_hold(id, act) {
    const button = byId(id);
    button.addEventListener('pointerdown', (event) => {
      button.setPointerCapture(event.pointerId);
      act(true);
    });
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) button.addEventListener(end, () => act(false));
    button.addEventListener('contextmenu', (event) => event.preventDefault());
  }

  #down(event) {
    if (!this.is_held) return;
    if (event.button === kRight) this.#grip(true);
    if (event.button !== kLeft || this.#dragged) return;
    this.#dragged = { id: event.pointerId, x: event.clientX, y: event.clientY };
    this.canvas.setPointerCapture(event.pointerId);
  }

  #move(event) {
    if (!this.is_held || event.pointerId !== this.#dragged?.id) return;
    const { clientX: x, clientY: y } = event;
    this.hand.drag(x - this.#dragged.x, y - this.#dragged.y, this.view.camera.camera, this.canvas.clientHeight);
    Object.assign(this.#dragged, { x, y });
  }

  #up(event) {
    if (event.button === kRight) this.#grip(false);
    // With the right button still down the left one ends as a move does.
    if (event.pointerId === this.#dragged?.id && !(event.buttons & 1)) this.#dragged = null;
  }

  #wheel(event) {
    if (!this.is_held) return;
    event.preventDefault();
    const kLine_px = 33;
    this.hand.scroll(event.deltaY * (event.deltaMode === 1 ? kLine_px : 1), this.view.camera.camera, this.#tool_m());
  }

  #tool_m() { return this.link.frame()?.tool?.position_m ?? this.hand.aim.position_m.toArray(); }

  /// Before the page's shortcuts, of which some are the hand's keys while it is held.
  #key(event, is_down) {
    if (!this.is_held || byId('help').open) return;
    if (event.key === 'Shift') this.hand.clutch = is_down;
    const key = key_of(event);
    if (!is_down) this.hand.keys.delete(key);
    if (!is_down && key === ' ') this.#grip(false);
    if (event.ctrlKey || event.altKey || event.metaKey || (is_control(event) && key !== 'Escape')) return;
    if (!['Escape', ' ', ...kHeldKeys].includes(key)) return;
    event.preventDefault();
    event.stopPropagation();
    if (!is_down) return;
    if (key === 'Escape') this.let_go();
    else if (key === ' ') this.#grip(true);
    else this.hand.keys.add(key);
  }

  /// By a timer: where the picture is drawn slowly, the hand goes on.
  #tick(now_ms) {
    if (!this.link.is_live() || !this.link.frame()?.tool) this.let_go();
    if (!this.is_held) return;
    const { camera } = this.view.camera;
    if (this.#depth) this.hand.scroll(this.#depth, camera, this.#tool_m());
    this.hand.tick(now_ms, camera, this.#tool_m());
    this.view.show_aim(this.hand.aim?.position_m ?? null);
  }

  /// What the panel says. status, frame: of the viewer.
  show(status, frame) {
    const tool = frame?.tool;
    const is_there = status?.live && frame?.hand === 'alive' && tool && is_by_mouse(status.hand_command);
    byId('mouse').hidden = !is_there;
    if (!is_there) return;
    byId('mouse-force').textContent = `${Math.hypot(...tool.force_N).toFixed(2)} N`;
    const is_heard = Boolean(tool.device.status & kEnabled);
    byId('mouse-state').textContent = this.is_held
      ? (is_heard ? 'You hold the hand.' : 'You hold the hand; the device does not hear you.')
      : (is_heard ? 'The hand goes by itself, or another page holds it.' : 'Nobody holds the hand: it stays, without force.');
  }
}
