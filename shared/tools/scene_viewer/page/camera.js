// The camera: orbit, pan and zoom by hand, views by name, and one that follows the tool.
import * as THREE from 'three';
import { OrbitControls } from 'three/OrbitControls';

/// From where the scene is seen, and what is up there.
const kViews = {
  oblique: [[0.75, -1, 0.6], [0, 0, 1]],
  front: [[0, -1, 0], [0, 0, 1]],
  // Not straight from above, where the camera would not know its up.
  top: [[0, -1e-3, 1], [0, 0, 1]],
};

export class Camera {
  follows = false;

  constructor(canvas, on_change) {
    this.camera = new THREE.PerspectiveCamera(35, 1, 1e-3, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', on_change);
    this.home(new THREE.Vector3(), 0.3);
  }

  /// The middle of what is to be seen, and its extent.
  home(centre_m, size_m) {
    this.centre_m = centre_m;
    this.size_m = size_m;
    this.camera.near = size_m / 200;
    this.camera.far = size_m * 100;
    this.view('oblique');
  }

  /// name: of a view, or 'follow', which holds the tool in the middle.
  view(name) {
    this.follows = name === 'follow';
    if (this.follows) return;
    const [from] = kViews[name];
    // In a picture that is higher than wide its width counts.
    const distance_m = 1.65 * this.size_m / Math.min(this.camera.aspect, 1);
    this.controls.target.copy(this.centre_m);
    this.camera.position.set(...from).normalize().multiplyScalar(distance_m).add(this.centre_m);
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  /// While a hand is held its are the left and the right button, the wheel and one finger; the middle button and two
  /// fingers turn.
  leave_to_hand(is_held) {
    const { MOUSE, TOUCH } = THREE;
    this.controls.enableZoom = !is_held;
    this.controls.mouseButtons = is_held ? { LEFT: null, MIDDLE: MOUSE.ROTATE, RIGHT: null }
      : { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
    this.controls.touches = is_held ? { ONE: null, TWO: TOUCH.DOLLY_ROTATE }
      : { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
  }

  /// Where the camera stands and looks at: six numbers in metres.
  get place_m() {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()];
  }

  set place_m(numbers) {
    this.follows = false;
    this.camera.position.fromArray(numbers);
    this.controls.target.fromArray(numbers, 3);
    this.controls.update();
  }

  tool_at(position_m) {
    if (!this.follows) return;
    const shift = new THREE.Vector3(...position_m).sub(this.controls.target);
    this.controls.target.add(shift);
    this.camera.position.add(shift);
    this.controls.update();
  }

  resize(width, height) {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }
}
