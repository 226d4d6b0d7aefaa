// A colour for each body: hues far apart, none as loud as the arrow of the force.
import * as THREE from 'three';

const kFirst = ['#c98686', '#7f9fc4', '#84b08a', '#c2a878', '#a48bc0', '#6fb0b3', '#b98fae', '#97a06a',
  '#8893d0', '#bf9273'];

export function body_colour(body) {
  const colour = new THREE.Color(kFirst[body % kFirst.length]);
  // Each further round is darker.
  return colour.multiplyScalar(0.85 ** Math.floor(body / kFirst.length));
}
