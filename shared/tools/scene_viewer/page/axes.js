// The axes of the scene's frame, with metres: beside what there is, ticks on round numbers.
import * as THREE from 'three';
import { make_label } from './labels.js';
import { round_up } from './plot_canvas.js';

const kSmall_px = 17;

/// "0.05": a coordinate with as many digits as its step needs.
export function metres_text(value_m, step_m) {
  const digits = Math.max(0, -Math.floor(Math.log10(step_m) + 1e-9));
  const text = value_m.toFixed(digits);
  return Number(text) === 0 ? '0' : text.replace('-', '−');
}

/// Round numbers within a range, step_m apart.
function round_numbers([from_m, to_m], step_m) {
  const first = Math.ceil(from_m / step_m - 1e-6);
  const count = Math.floor(to_m / step_m + 1e-6) - first + 1;
  return Array.from({ length: Math.max(count, 0) }, (_, i) => (first + i) * step_m);
}

/// The range of an axis: a step at least, of height above.
function range_of(axis, low_m, high_m, step_m) {
  const length_m = Math.max(high_m[axis] - low_m[axis], step_m);
  const from_m = axis === 2 ? low_m[2] : (low_m[axis] + high_m[axis] - length_m) / 2;
  return [from_m, from_m + length_m];
}

/// low_m, high_m: corners of what there is. colours: of a theme.
export function make_axes(low_m, high_m, { picture, plot }) {
  const group = new THREE.Group();
  // One spacing for all three, or a flat scene would have ticks of a millimetre up.
  const size_m = Math.max(...[0, 1, 2].map((axis) => high_m[axis] - low_m[axis]), 0.1);
  const step_m = round_up(size_m / 4);
  const [x_m, y_m, z_m] = [0, 1, 2].map((axis) => range_of(axis, low_m, high_m, step_m));
  // Along the back and the left, where the usual views look over them: a place on each, and the way outwards.
  const edges = [
    { range_m: x_m, along: (value_m) => [value_m, y_m[1], z_m[0]], outwards: [0, 1, 0] },
    { range_m: y_m, along: (value_m) => [x_m[0], value_m, z_m[0]], outwards: [-1, 0, 0] },
    { range_m: z_m, along: (value_m) => [x_m[0], y_m[1], value_m], outwards: [-0.7, 0.7, 0] },
  ];
  edges.forEach(({ range_m, along, outwards }, axis) => {
    const at = (value_m, aside_m = 0) => new THREE.Vector3(...along(value_m))
      .addScaledVector(new THREE.Vector3(...outwards), aside_m);
    const ticks = round_numbers(range_m, step_m);
    const points = range_m.map((value_m) => at(value_m));
    for (const value_m of ticks) points.push(at(value_m), at(value_m, 0.12 * step_m));
    group.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points),
      new THREE.LineBasicMaterial({ color: plot['xyz'[axis]] })));
    for (const value_m of ticks) {
      const label = make_label(metres_text(value_m, step_m), picture, { height_px: kSmall_px });
      label.position.copy(at(value_m, 0.35 * step_m));
      group.add(label);
    }
    const name = make_label(`${'xyz'[axis]}, m`, { ...picture, label: plot['xyz'[axis]] });
    name.position.copy(axis === 2 ? at(range_m[1] + 0.3 * step_m) : at((range_m[0] + range_m[1]) / 2, 0.8 * step_m));
    group.add(name);
  });
  return group;
}
