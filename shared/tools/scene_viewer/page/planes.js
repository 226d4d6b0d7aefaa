// The scene's planes: a faint square with a grid, about where the bodies are.
import * as THREE from 'three';
import { round_up } from './plot_canvas.js';

/// A group with all planes. centre_m, size_m: of what lies on them. colours: of a theme's picture. cell_m: the
/// grid's.
export function make_planes(planes, centre_m, size_m, colours) {
  const group = new THREE.Group();
  const cell_m = round_up(size_m / 20);
  const cells = 2 * Math.ceil(size_m / cell_m);
  for (const { normal, offset_m, body } of planes) {
    const up = new THREE.Vector3(...normal).normalize();
    const foot = centre_m.clone().addScaledVector(up, offset_m - centre_m.dot(up));
    const one = new THREE.Group();
    const ground = new THREE.Mesh(
      new THREE.PlaneGeometry(cells * cell_m, cells * cell_m),
      new THREE.MeshBasicMaterial({
        color: colours.plane, transparent: true, opacity: 0.5, side: THREE.DoubleSide, depthWrite: false }));
    const lines = new THREE.GridHelper(cells * cell_m, cells, colours.grid, colours.fine_grid);
    ground.userData.body = body;
    lines.rotateX(Math.PI / 2);
    one.add(ground, lines);
    one.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), up);
    one.position.copy(foot);
    group.add(one);
  }
  return { group, cell_m };
}
