// Spheres that are drawn in one call: one mesh, a matrix each.
import * as THREE from 'three';

/// So much larger is a ghost, not to flicker where it lies on what it is the ghost of.
const kGhostScale = 1.02;

/// Many triangles where spheres are few.
function detail_for(count) {
  if (count <= 200) return 4;
  return count <= 3000 ? 2 : 1;
}

export class SphereSet {
  /// radius_m: of each sphere. ghost: seen through.
  constructor(radius_m, { ghost = false, colour = '#ffffff', opacity = 0.25 } = {}) {
    this.radius_m = ghost ? radius_m.map((radius) => kGhostScale * radius) : radius_m;
    const geometry = new THREE.IcosahedronGeometry(1, detail_for(radius_m.length));
    const material = ghost
      ? new THREE.MeshLambertMaterial({ color: colour, transparent: true, opacity, depthWrite: false })
      : new THREE.MeshLambertMaterial({ color: colour });
    this.mesh = new THREE.InstancedMesh(geometry, material, Math.max(radius_m.length, 1));
    this.mesh.frustumCulled = false;
    this.mesh.count = 0;
  }

  /// A colour each, instead of the one of all.
  colour(colour_of) {
    for (let i = 0; i < this.radius_m.length; ++i) this.mesh.setColorAt(i, colour_of(i));
    if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
  }

  /// centres_m: x, y, z of each; fewer than there are radii show fewer spheres. hides(i): whether a
  /// sphere is left out. Returns how many are shown.
  place(centres_m, hides = () => false) {
    const count = Math.min(centres_m.length / 3, this.radius_m.length);
    let shown = 0;
    const matrix = this.mesh.instanceMatrix.array;
    for (let i = 0; i < count; ++i) {
      const at = 16 * i;
      const [x, y, z] = [centres_m[3 * i], centres_m[3 * i + 1], centres_m[3 * i + 2]];
      const is_there = Number.isFinite(x + y + z) && !hides(i);  // an absent sphere is no number
      if (is_there) ++shown;
      matrix[at] = matrix[at + 5] = matrix[at + 10] = is_there ? this.radius_m[i] : 0;
      matrix[at + 12] = is_there ? x : 0;
      matrix[at + 13] = is_there ? y : 0;
      matrix[at + 14] = is_there ? z : 0;
      matrix[at + 15] = 1;
    }
    this.mesh.count = count;
    this.mesh.instanceMatrix.needsUpdate = true;
    return shown;
  }

  /// The sphere that a ray meets first, as { index, distance_m }, or null.
  nearest(ray) {
    const { origin, direction } = ray;
    const matrix = this.mesh.instanceMatrix.array;
    let found = null;
    for (let i = 0; i < this.mesh.count; ++i) {
      const at = 16 * i;
      const radius = matrix[at];
      const x = matrix[at + 12] - origin.x, y = matrix[at + 13] - origin.y, z = matrix[at + 14] - origin.z;
      const along = x * direction.x + y * direction.y + z * direction.z;
      const inside = radius * radius - (x * x + y * y + z * z - along * along);
      if (!(radius > 0) || !(inside >= 0) || along < 0) continue;
      const distance_m = along - Math.sqrt(inside);
      if (!found || distance_m < found.distance_m) found = { index: i, distance_m };
    }
    return found;
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}
