// How far apart colours are for people who lack one kind of cones, and how well they stand off each other.

/// Red, green and blue of light, as they reach the eyes: Machado, Oliveira and Fernandes, "A Physiologically-based
/// Model for Simulation of Color Vision Deficiency", 2009, at full severity.
export const kEyes = {
  usual: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
  tritanopia: [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
};

/// Of light, 0 to 1 each.
const light_of = (colour) => colour.match(/[0-9a-f]{2}/gi).map((digits) => parseInt(digits, 16) / 255)
  .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));

const times = (matrix, vector) => matrix.map((row) => row.reduce((sum, value, i) => sum + value * vector[i], 0));

/// CIE L*a*b* under daylight (D65).
function lab_of(colour, eyes) {
  const light = times(kEyes[eyes], light_of(colour)).map((value) => Math.min(Math.max(value, 0), 1));
  const [x, y, z] = times([[0.4124564 / 0.95047, 0.3575761 / 0.95047, 0.1804375 / 0.95047],
    [0.2126729, 0.7151522, 0.0721750], [0.0193339 / 1.08883, 0.1191920 / 1.08883, 0.9503041 / 1.08883]], light)
    .map((value) => (value > 0.008856 ? Math.cbrt(value) : 7.787 * value + 16 / 116));
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

/// CIE 1976: some 2.3 can just be told apart side by side.
export function difference(a, b, eyes) {
  const [of_a, of_b] = [lab_of(a, eyes), lab_of(b, eyes)];
  return Math.hypot(...of_a.map((value, i) => value - of_b[i]));
}

/// WCAG's ratio, 1 to 21.
export function contrast(a, b) {
  const [dark, light] = [a, b].map((colour) => times([[0.2126, 0.7152, 0.0722]], light_of(colour))[0]).sort((p, q) => p - q);
  return (light + 0.05) / (dark + 0.05);
}
