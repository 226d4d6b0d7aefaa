// The tool's spheres, where it has been, and the force on the hand as an arrow.
import * as THREE from 'three';
import { drop_label, make_label } from './labels.js';
import { SphereSet } from './sphere_set.js';

const kPathPoints = 1024;
/// Where a hand's name stands.
const kAbove = new THREE.Vector3(0, 0, 1.2);
/// Whatever lies in front: a tool presses into what would hide it.
const kSeenThrough = { depthTest: false, transparent: true };

/// Centres of the tool's spheres in the scene. tool: of a frame.
export function tool_centres(tool_spheres, tool) {
  const turn = new THREE.Quaternion(...tool.orientation_xyzw);
  const origin = new THREE.Vector3(...tool.position_m);
  return tool_spheres.flatMap((sphere) =>
    new THREE.Vector3(...sphere.position_m).applyQuaternion(turn).add(origin).toArray());
}

/// What joins the tool's origin, which the hand holds, with spheres that lie off it.
function make_stem(tool_spheres, colour) {
  const stem = new THREE.Group();
  const off_m = ({ position_m, radius_m }) => Math.hypot(...position_m) - radius_m;
  const nearest = [...tool_spheres].sort((a, b) => off_m(a) - off_m(b))[0];
  if (!nearest || off_m(nearest) <= 0) return stem;
  const to_m = new THREE.Vector3(...nearest.position_m);
  const radius_m = 0.3 * nearest.radius_m;
  const bar = new THREE.Mesh(new THREE.CylinderGeometry(radius_m, radius_m, to_m.length(), 10),
    new THREE.MeshLambertMaterial({ color: colour }));
  bar.position.copy(to_m).multiplyScalar(0.5);
  bar.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), to_m.normalize());
  return stem.add(bar);
}

export class ToolView {
  object = new THREE.Group();
  metres_per_N = 0.01;

  /// tool_spheres: position_m in the tool's frame, radius_m. size_m: of the scene. colours: of a theme's picture.
  constructor(tool_spheres, size_m, colours) {
    this.colours = colours;
    this.path_colour = new THREE.Color(colours.path);
    this.ground = new THREE.Color(colours.ground);
    this.label = null;  // its hand's name, where there are several
    this.tool_spheres = tool_spheres;
    this.spheres = new SphereSet(tool_spheres.map((sphere) => sphere.radius_m), { colour: colours.tool });
    this.shine = new SphereSet(this.spheres.radius_m, { ghost: true, colour: colours.tool, opacity: 0.4 });
    this.shine.mesh.material.depthTest = false;
    const geometry = new THREE.BufferGeometry();
    this.path_at = new THREE.BufferAttribute(new Float32Array(3 * kPathPoints), 3);
    this.path_shade = new THREE.BufferAttribute(new Float32Array(3 * kPathPoints), 3);
    geometry.setAttribute('position', this.path_at);
    geometry.setAttribute('color', this.path_shade);
    this.path = new THREE.Line(geometry, new THREE.LineBasicMaterial({ vertexColors: true, ...kSeenThrough }));
    this.path.frustumCulled = false;
    this.#make_arrow(size_m);
    this.stem = make_stem(tool_spheres, colours.stem);
    this.#make_aim(size_m);
    this.object.add(this.aim, this.stem, this.spheres.mesh, this.shine.mesh, this.path, this.arrow);
  }

  #make_arrow(size_m) {
    const material = new THREE.MeshLambertMaterial({ ...kSeenThrough });
    const radius_m = 0.006 * size_m;
    const along_y = (geometry) => geometry.translate(0, 0.5, 0);
    this.shaft = new THREE.Mesh(along_y(new THREE.CylinderGeometry(radius_m, radius_m, 1, 12)), material);
    this.head = new THREE.Mesh(along_y(new THREE.ConeGeometry(2.6 * radius_m, 1, 16)), material);
    this.head_m = 7 * radius_m;
    this.arrow = new THREE.Group().add(this.shaft, this.head);
    this.set_hand('', 0);
  }

  #make_aim(size_m) {
    const material = new THREE.MeshBasicMaterial({ color: this.colours.path, ...kSeenThrough });
    const radius_m = 0.002 * size_m;
    const bar = new THREE.CylinderGeometry(radius_m, radius_m, 1, 8).translate(0, 0.5, 0);
    this.band = new THREE.Mesh(bar, material);
    this.aim_ball = new THREE.Mesh(new THREE.SphereGeometry(3 * radius_m, 16, 12), material);
    this.aim = new THREE.Group().add(this.band, this.aim_ball);
    this.aim.visible = false;
  }

  /// Where a mouse draws the tool, or null: a ball, and a band from the tool.
  place_aim(aim_m) {
    this.aim.visible = aim_m !== null;
    if (!aim_m) return;
    const along = aim_m.clone().sub(this.arrow.position);
    this.aim.position.copy(this.arrow.position);
    this.aim_ball.position.copy(along);
    this.band.scale.set(1, Math.max(along.length(), 1e-9), 1);
    this.band.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
  }

  /// name: of the hand, '' for the only one. index: its place among the hands, which gives the colour.
  set_hand(name, index) {
    const known = `${name} ${index}`;
    if (known === this.known) return;
    this.known = known;
    const colour = new THREE.Color(this.colours.hands[index % this.colours.hands.length]);
    this.shaft.material.color = colour;
    this.shaft.material.emissive = colour.clone().multiplyScalar(0.35);
    if (this.label) drop_label(this.label);
    this.label = name ? make_label(name, { ...this.colours, label: this.colours.hands[index % 4] },
      { is_in_front: true }) : null;
    if (this.label) this.object.add(this.label);
  }

  /// tool: of a frame.
  place(tool) {
    const centres = tool_centres(this.tool_spheres, tool);
    this.spheres.place(centres);
    this.shine.place(centres);
    this.label?.position.set(...tool.position_m).add(kAbove.clone().multiplyScalar(this.head_m));
    this.stem.position.set(...tool.position_m);
    this.stem.quaternion.set(...tool.orientation_xyzw);

    const force = new THREE.Vector3(...tool.force_N);
    const length_m = force.length() * this.metres_per_N;
    this.arrow.visible = length_m > 1e-3 * this.head_m;
    const head_m = Math.min(this.head_m, 0.6 * length_m);
    this.shaft.scale.set(1, Math.max(length_m - head_m, 1e-9), 1);
    this.head.position.set(0, length_m - head_m, 0);
    this.head.scale.set(head_m / this.head_m, Math.max(head_m, 1e-9), head_m / this.head_m);
    this.arrow.position.set(...tool.position_m);
    this.arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), force.normalize());
  }

  /// The positions of ticks begin .. end of a TickHistory, thinned, older ones fainter.
  place_path(positions_m, begin, end) {
    const step = Math.max(1, Math.ceil((end - begin) / kPathPoints));
    const shade = new THREE.Color();
    let count = 0;
    for (let i = end - 1; i >= begin && count < kPathPoints; i -= step, ++count) {
      const fade = 1 - 0.8 * (end - 1 - i) / Math.max(end - begin, 1);
      for (let axis = 0; axis < 3; ++axis) {
        this.path_at.array[3 * count + axis] = positions_m[3 * i + axis];
      }
      shade.lerpColors(this.ground, this.path_colour, fade).toArray(this.path_shade.array, 3 * count);
    }
    this.path_at.needsUpdate = this.path_shade.needsUpdate = true;
    this.path.geometry.setDrawRange(0, count);
  }
}
