// The aim of a mouse that holds the hand: what a drag, the wheel and keys make of it, and what the viewer is told.
import * as THREE from 'three';

const kMove_per_s = 0.2;   // of the scene's extent, by a key that is held
const kTurn_rad_s = 1.2;
const kNotch = 0.01;       // of the scene's extent, a notch of the wheel
const kNotch_px = 100;
const kLeash = 0.1;        // of the scene's extent: no depth is scrolled farther from the tool
const kRest_ms = 50;       // a mouse at rest is told of so often: the device waits for 500 ms

/// Keys that are held: along or about which of the view's axes (right, up, towards the viewer).
const kMoves = { a: [-1, 0, 0], d: [1, 0, 0], w: [0, 1, 0], s: [0, -1, 0], PageUp: [0, 0, -1], PageDown: [0, 0, 1] };
const kTurns = { ArrowLeft: [0, -1, 0], ArrowRight: [0, 1, 0], ArrowUp: [-1, 0, 0], ArrowDown: [1, 0, 0],
  q: [0, 0, 1], e: [0, 0, -1] };
export const kHeldKeys = [...Object.keys(kMoves), ...Object.keys(kTurns)];

/// A pose of the scene in the device's frame. device: of /api/scene.
export function in_device(device, position_m, orientation) {
  const turn = new THREE.Quaternion(...device.orientation_xyzw).invert();
  const origin_m = new THREE.Vector3(...device.position_m);
  return { position_m: position_m.clone().sub(origin_m).applyQuaternion(turn).divideScalar(device.scale).toArray(),
    orientation_xyzw: turn.multiply(orientation).normalize().toArray() };
}

/// Metres a pixel at a place in front of a camera. height_px: of its picture.
export function metres_per_px(camera, place_m, height_px) {
  const ahead = camera.getWorldDirection(new THREE.Vector3());
  const depth_m = Math.max(place_m.clone().sub(camera.position).dot(ahead), camera.near);
  return 2 * depth_m * Math.tan(THREE.MathUtils.degToRad(camera.fov) / 2) / height_px;
}

const random_name = () => [...crypto.getRandomValues(new Uint8Array(12))]
  .map((byte) => byte.toString(16).padStart(2, '0')).join('');

export class MouseHand {
  aim = null;       // { position_m, orientation } in the scene, while the hand is held
  buttons = 0;      // bit 0: grip
  clutch = false;   // the mouse moves, and not the tool
  keys = new Set();
  #holder = random_name();
  #told = '';
  #told_ms = 0;
  #is_under_way = false;
  #before_ms = null;

  /// send(message): a promise, rejected with { is_refusal, message } where the viewer refuses.
  constructor(send, on_refusal) { Object.assign(this, { send, on_refusal }); }

  /// tool: of a frame; the aim begins there. size_m: of the scene. device: of /api/scene.
  take(tool, size_m, device) {
    Object.assign(this, { size_m, device, buttons: 0, clutch: false });
    this.aim = { position_m: new THREE.Vector3(...tool.position_m),
      orientation: new THREE.Quaternion(...tool.orientation_xyzw) };
    this.#told = '';
    this.#before_ms = null;
  }

  /// The message that lets the hand go.
  get release() { return { holder: this.#holder, release: true }; }

  let_go() {
    this.aim = null;
    this.rest();
  }

  /// No key or button is down any more.
  rest() {
    this.buttons = 0;
    this.clutch = false;
    this.keys.clear();
  }

  /// A drag by so many pixels, to the right and down.
  drag(right_px, down_px, camera, height_px) {
    if (!this.aim || this.clutch) return;
    const scale_m = metres_per_px(camera, this.aim.position_m, height_px);
    this.#shift([right_px * scale_m, -down_px * scale_m, 0], camera);
  }

  /// The wheel: forwards is away from the viewer. tool_m: where the tool is.
  scroll(delta_px, camera, tool_m) {
    if (!this.aim || this.clutch) return;
    this.#deepen(delta_px / kNotch_px * kNotch * this.size_m, camera, tool_m);
  }

  #shift(along_m, camera) {
    this.aim.position_m.add(new THREE.Vector3(...along_m).applyQuaternion(camera.quaternion));
  }

  /// Depth has no cursor that shows how far it is ahead of the tool: so it does not run away from it.
  #deepen(nearer_m, camera, tool_m) {
    const towards = new THREE.Vector3(0, 0, 1).applyQuaternion(camera.quaternion);
    const ahead_m = this.aim.position_m.clone().sub(new THREE.Vector3(...tool_m)).dot(towards);
    const most_m = kLeash * this.size_m;
    const wanted_m = Math.max(Math.min(ahead_m, -most_m), Math.min(Math.max(ahead_m, most_m), ahead_m + nearer_m));
    this.#shift([0, 0, wanted_m - ahead_m], camera);
  }

  #follow_keys(passed_s, camera, tool_m) {
    for (const key of this.keys) {
      const step_m = kMove_per_s * this.size_m * passed_s;
      const [right, up, nearer] = kMoves[key] ?? [0, 0, 0];
      if (!this.clutch) {
        this.#shift([right * step_m, up * step_m, 0], camera);
        if (nearer) this.#deepen(nearer * step_m, camera, tool_m);
      }
      if (!kTurns[key]) continue;
      const axis = new THREE.Vector3(...kTurns[key]).applyQuaternion(camera.quaternion);
      this.aim.orientation.premultiply(new THREE.Quaternion().setFromAxisAngle(axis, kTurn_rad_s * passed_s)).normalize();
    }
  }

  /// What is told now: { holder, position_m, orientation_xyzw, buttons }.
  get message() {
    return { holder: this.#holder, ...in_device(this.device, this.aim.position_m, this.aim.orientation),
      buttons: this.buttons };
  }

  /// Some 60 times a second. Tells the viewer what is new, and never two things at once.
  async tick(now_ms, camera, tool_m) {
    if (!this.aim) return;
    const passed_s = Math.min(now_ms - (this.#before_ms ?? now_ms), 100) / 1000;
    this.#before_ms = now_ms;
    this.#follow_keys(passed_s, camera, tool_m);
    const { message } = this;
    const text = JSON.stringify(message);
    if (this.#is_under_way || (text === this.#told && now_ms - this.#told_ms < kRest_ms)) return;
    this.#is_under_way = true;
    this.#told = text;
    this.#told_ms = now_ms;
    try {
      await this.send(message);
    } catch (error) {
      if (error.is_refusal && this.aim) {
        this.let_go();
        this.on_refusal(error.message);
      }
    } finally {
      this.#is_under_way = false;
    }
  }
}
