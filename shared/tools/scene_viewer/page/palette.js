// A colour for each body.
import * as THREE from 'three';
import { kBodyColours } from './theme.js';

const kRounds = 3;  // in shades, before they begin anew

export function body_colour(body) {
  const colour = new THREE.Color(kBodyColours[body % kBodyColours.length]);
  return colour.multiplyScalar(0.8 ** (Math.floor(body / kBodyColours.length) % kRounds));
}
