// The tool's spheres, where it has been, and the force on the hand as an arrow.
import * as THREE from 'three';
import { SphereSet } from './sphere_set.js';

const kPathPoints = 1024;
const kArrowColour = '#f2c14e';
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
function make_stem(tool_spheres) {
  const stem = new THREE.Group();
  const off_m = ({ position_m, radius_m }) => Math.hypot(...position_m) - radius_m;
  const nearest = [...tool_spheres].sort((a, b) => off_m(a) - off_m(b))[0];
  if (!nearest || off_m(nearest) <= 0) return stem;
  const to_m = new THREE.Vector3(...nearest.position_m);
  const radius_m = 0.3 * nearest.radius_m;
  const bar = new THREE.Mesh(new THREE.CylinderGeometry(radius_m, radius_m, to_m.length(), 10),
    new THREE.MeshLambertMaterial({ color: '#aab3bd' }));
  bar.position.copy(to_m).multiplyScalar(0.5);
  bar.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), to_m.normalize());
  return stem.add(bar);
}

export class ToolView {
  object = new THREE.Group();
  metres_per_N = 0.01;

  /// tool_spheres: position_m in the tool's frame, radius_m. size_m: of the scene.
  constructor(tool_spheres, size_m) {
    this.tool_spheres = tool_spheres;
    this.spheres = new SphereSet(tool_spheres.map((sphere) => sphere.radius_m), { colour: '#eef2f6' });
    this.shine = new SphereSet(this.spheres.radius_m, { ghost: true, colour: '#eef2f6', opacity: 0.4 });
    this.shine.mesh.material.depthTest = false;
    const geometry = new THREE.BufferGeometry();
    this.path_at = new THREE.BufferAttribute(new Float32Array(3 * kPathPoints), 3);
    this.path_shade = new THREE.BufferAttribute(new Float32Array(3 * kPathPoints), 3);
    geometry.setAttribute('position', this.path_at);
    geometry.setAttribute('color', this.path_shade);
    this.path = new THREE.Line(geometry, new THREE.LineBasicMaterial({ vertexColors: true, ...kSeenThrough }));
    this.path.frustumCulled = false;
    this.#make_arrow(size_m);
    this.stem = make_stem(tool_spheres);
    this.object.add(this.stem, this.spheres.mesh, this.shine.mesh, this.path, this.arrow);
  }

  #make_arrow(size_m) {
    const material = new THREE.MeshLambertMaterial({ color: kArrowColour, emissive: '#5a4310', ...kSeenThrough });
    const radius_m = 0.006 * size_m;
    const along_y = (geometry) => geometry.translate(0, 0.5, 0);
    this.shaft = new THREE.Mesh(along_y(new THREE.CylinderGeometry(radius_m, radius_m, 1, 12)), material);
    this.head = new THREE.Mesh(along_y(new THREE.ConeGeometry(2.6 * radius_m, 1, 16)), material);
    this.head_m = 7 * radius_m;
    this.arrow = new THREE.Group().add(this.shaft, this.head);
  }

  /// tool: of a frame.
  place(tool) {
    const centres = tool_centres(this.tool_spheres, tool);
    this.spheres.place(centres);
    this.shine.place(centres);
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

  /// The positions of ticks begin .. end of a TickHistory, thinned, older ones darker.
  place_path(positions_m, begin, end) {
    const step = Math.max(1, Math.ceil((end - begin) / kPathPoints));
    let count = 0;
    for (let i = end - 1; i >= begin && count < kPathPoints; i -= step, ++count) {
      const fade = 1 - 0.8 * (end - 1 - i) / Math.max(end - begin, 1);
      for (let axis = 0; axis < 3; ++axis) {
        this.path_at.array[3 * count + axis] = positions_m[3 * i + axis];
        this.path_shade.array[3 * count + axis] = fade * [0.55, 0.75, 0.95][axis];
      }
    }
    this.path_at.needsUpdate = this.path_shade.needsUpdate = true;
    this.path.geometry.setDrawRange(0, count);
  }
}
