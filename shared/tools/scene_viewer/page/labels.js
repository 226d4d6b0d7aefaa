// Words in the picture: always upright, as large as text.
import * as THREE from 'three';

const kFont = '600 26px system-ui, "DejaVu Sans", sans-serif';
const kHeight = 40;  // of the canvas a label is drawn on, in its pixels
const kUsual_px = 22;  // of the label, not of its letters
const kTwoTangents = 2 * Math.tan(17.5 * Math.PI / 180);  // of half the camera's field of view

/// colours: label, label_ground of a theme's picture. height_px: on the screen. is_in_front: of everything.
export function make_label(text, colours, { height_px = kUsual_px, is_in_front = false } = {}) {
  const canvas = document.createElement('canvas');
  const context = canvas.getContext('2d');
  context.font = kFont;
  canvas.width = Math.ceil(context.measureText(text).width) + 16;
  canvas.height = kHeight;
  context.font = kFont;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.lineJoin = 'round';
  context.lineWidth = 6;
  context.strokeStyle = colours.label_ground;
  context.strokeText(text, canvas.width / 2, kHeight / 2);
  context.fillStyle = colours.label;
  context.fillText(text, canvas.width / 2, kHeight / 2);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  const label = new THREE.Sprite(new THREE.SpriteMaterial({
    map, sizeAttenuation: false, depthTest: !is_in_front, depthWrite: false, transparent: true }));
  label.userData = { height_px, ratio: canvas.width / kHeight };
  label.renderOrder = 10;
  return label;
}

/// So that it is as high as was said, in a picture of that height in pixels.
export function fit_label(label, picture_px) {
  const { height_px, ratio } = label.userData;
  const height = height_px / picture_px * kTwoTangents;
  label.scale.set(height * ratio, height, 1);
}

export function drop_label(label) {
  label.removeFromParent();
  label.material.map.dispose();
  label.material.dispose();
}
