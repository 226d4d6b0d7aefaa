// Occupied voxels as boxes of wire, coloured by how many spheres are entered.
import * as THREE from 'three';

const kMax = 20000;  // boxes; more would only hide each other

function box_edges() {
  const corners = [];
  for (let axis = 0; axis < 3; ++axis) {
    for (const [a, b] of [[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]]) {
      for (const end of [-0.5, 0.5]) {
        const corner = [0, 0, 0];
        corner[axis] = end;
        corner[(axis + 1) % 3] = a;
        corner[(axis + 2) % 3] = b;
        corners.push(...corner);
      }
    }
  }
  return new Float32Array(corners);
}

const kRamp = ['#3b528b', '#21918c', '#5ec962', '#fde725'].map((text) => new THREE.Color(text));

/// Of a count among 1 .. most.
function ramp_colour(count, most) {
  const at = most > 1 ? (count - 1) / (most - 1) * (kRamp.length - 1) : 0;
  const below = Math.min(Math.floor(at), kRamp.length - 2);
  return kRamp[below].clone().lerp(kRamp[below + 1], at - below);
}

export class VoxelBoxes {
  most_count = 0;  // in one voxel of those shown

  constructor() {
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(box_edges(), 3));
    this.box = new THREE.InstancedBufferAttribute(new Float32Array(4 * kMax), 4);
    this.tint = new THREE.InstancedBufferAttribute(new Float32Array(3 * kMax), 3);
    geometry.setAttribute('box', this.box);
    geometry.setAttribute('tint', this.tint);
    geometry.instanceCount = 0;
    const material = new THREE.ShaderMaterial({
      transparent: true,
      depthWrite: false,
      vertexShader: `
        attribute vec4 box;  // centre, edge
        attribute vec3 tint;
        varying vec3 shade;
        void main() {
          shade = tint;
          gl_Position = projectionMatrix * modelViewMatrix * vec4(box.xyz + position * box.w, 1.0);
        }`,
      fragmentShader: `
        varying vec3 shade;
        void main() {
          gl_FragColor = vec4(shade, 0.55);
          #include <colorspace_fragment>
        }`,
    });
    this.object = new THREE.LineSegments(geometry, material);
    this.object.frustumCulled = false;
  }

  /// grids: of each box_m, centre and edge of its voxels, and count, the spheres in them.
  /// edge_m: of the level shown, or null for all.
  place(grids, edge_m) {
    const counts = [];
    for (const { box_m, count } of grids) {
      for (let i = 0; i < count.length && counts.length < kMax; ++i) {
        if (edge_m !== null && Math.abs(box_m[4 * i + 3] - edge_m) >= 1e-4 * edge_m) continue;
        for (let k = 0; k < 4; ++k) this.box.array[4 * counts.length + k] = box_m[4 * i + k];
        counts.push(count[i]);
      }
    }
    this.most_count = counts.reduce((most, count) => Math.max(most, count), 0);
    counts.forEach((count, i) => ramp_colour(count, this.most_count).toArray(this.tint.array, 3 * i));
    this.box.needsUpdate = this.tint.needsUpdate = true;
    this.object.geometry.instanceCount = counts.length;
  }
}
