// A colour for each body.
import * as THREE from 'three';
import { kBodyColours } from './theme.js';

export function body_colour(body) {
  const colour = new THREE.Color(kBodyColours[body % kBodyColours.length]);
  return colour.multiplyScalar(0.85 ** Math.floor(body / kBodyColours.length));
}
