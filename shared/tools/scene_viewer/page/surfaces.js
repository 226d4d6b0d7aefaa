// Bodies as surfaces: a vertex is a weighted sum of sphere centres; of a body that has no spheres and never
// moves, a place.
import * as THREE from 'three';
import { body_colour } from './palette.js';

/// One body's triangles or lines, moved by the spheres.
class Surface {
  constructor({ body, vertices, triangles, lines }) {
    this.offsets = new Uint32Array(vertices.length + 1);
    vertices.forEach((vertex, i) => { this.offsets[i + 1] = this.offsets[i] + vertex.spheres.length; });
    this.spheres = Uint32Array.from(vertices.flatMap((vertex) => vertex.spheres));
    this.weights = Float32Array.from(vertices.flatMap((vertex) => vertex.weights));

    const geometry = new THREE.BufferGeometry();
    this.is_still = vertices.every((vertex) => vertex.spheres.length === 0);
    this.position = new THREE.BufferAttribute(
      Float32Array.from(vertices.flatMap((vertex) => vertex.still_m ?? [0, 0, 0])), 3);
    geometry.setAttribute('position', this.position);
    geometry.setIndex((triangles ?? lines).flat());
    const color = body_colour(body);
    this.object = triangles
      ? new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ color, side: THREE.DoubleSide, flatShading: true }))
      : new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color }));
    this.object.frustumCulled = false;
    this.object.userData.body = body;
    // Its vertices go anywhere: a ray is held against every triangle.
    geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(), Infinity);
  }

  place(centres_m) {
    if (this.is_still) return;
    const { offsets, spheres, weights } = this;
    const to = this.position.array;
    for (let vertex = 0; vertex + 1 < offsets.length; ++vertex) {
      let x = 0, y = 0, z = 0;
      for (let k = offsets[vertex]; k < offsets[vertex + 1]; ++k) {
        const from = 3 * spheres[k];
        x += weights[k] * centres_m[from];
        y += weights[k] * centres_m[from + 1];
        z += weights[k] * centres_m[from + 2];
      }
      to[3 * vertex] = x;
      to[3 * vertex + 1] = y;
      to[3 * vertex + 2] = z;
    }
    this.position.needsUpdate = true;
  }
}

export class Surfaces {
  object = new THREE.Group();
  skinned = new Set();  // bodies whose spheres lie under triangles

  /// list: of sim_server --surfaces. static_m: centres of the static spheres, which come after the
  /// moving ones in the numbers.
  constructor(list, static_m) {
    this.static_m = static_m;
    this.surfaces = list.map((surface) => new Surface(surface));
    for (const { body, triangles } of list) if (triangles) this.skinned.add(body);
    for (const surface of this.surfaces) this.object.add(surface.object);
  }

  /// Those of bodies without spheres are all that there is to see of them.
  show(is_shown) {
    for (const surface of this.surfaces) surface.object.visible = is_shown || surface.is_still;
  }

  /// moving_m: centres of the moving spheres.
  place(moving_m) {
    const centres_m = new Float32Array(moving_m.length + this.static_m.length);
    centres_m.set(moving_m);
    centres_m.set(this.static_m, moving_m.length);
    for (const surface of this.surfaces) surface.place(centres_m);
  }
}
