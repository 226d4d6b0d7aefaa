// What a device tells beside its place: names and values of what it did tell, in segment_inspect's words.

const kStatus = ['motors on', 'enabled', 'calibrated', 'hot', 'fault'];  // the lowest bit first

const status_text = ({ status, status_known }) => kStatus
  .map((name, bit) => (status & (1 << bit) ? name : `not ${name}`))
  .filter((_, bit) => status_known & (1 << bit))
  .join(', ');

const fixed = (value, digits) => (value === null ? '–' : value.toFixed(digits));

/// device: of a frame's tool, or null. [name, value] each.
export function device_figures(device) {
  if (!device) return [];
  const figures = [];
  const status = status_text(device);
  if (status) figures.push(['status', status]);
  if (device.temperature_C !== null) figures.push(['temperature', `${fixed(device.temperature_C, 1)} °C`]);
  if (device.gripper_m !== null) {
    figures.push(['gripper', `open ${fixed(1000 * device.gripper_m, 1)} mm, force ${fixed(device.gripper_force_N, 2)} N`]);
  }
  if (device.axes !== null) figures.push(['axes', device.axes.map((axis) => fixed(axis, 2)).join(', ')]);
  return figures;
}

/// Whether a command starts haptic_server with the device `mouse`.
export const is_by_mouse = (command) => /--device[= ]'?([^ :']*\/)?mouse(\.so)?(?=[:@' ]|$)/.test(command ?? '');
