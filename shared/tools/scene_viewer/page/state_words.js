// What the line across the picture says of a session, and what helps.
import { parts_of } from './hands.js';

const kDead = {
  sim: 'Its process was killed or crashed. What is shown is its last snapshot; the force has faded on the hand. '
    + 'To start it again, in the folder where it was started:',
  hand: 'Its process was killed or crashed; the device gets no force of it. To start it again, in the folder where '
    + 'it was started:',
};

/// The command as it was told, or as far as it is known.
function command_of(server, { sim_command, hand_command }, scene) {
  const { whole, hand } = parts_of(scene?.session ?? '');
  if (server === 'sim') return sim_command || `sim_server --session ${whole} --scene ${scene?.name ?? 'SCENE'}.toml`;
  return hand_command || `haptic_server --session ${whole}${hand ? ` --hand ${hand}` : ''} --device PLUGIN`;
}

/// frame: that is shown; status, scene: of the viewer. { line, kind, help }; an empty line: nothing is amiss.
export function words_of(frame, status, scene) {
  const help = (server) => (status.live
    ? { text: kDead[server], command: command_of(server, status, scene) } : null);
  if (frame.sim === 'dead') return { line: 'simulation dead', kind: 'dead', help: help('sim') };
  if (frame.hand === 'dead') return { line: 'hand dead', kind: 'dead', help: help('hand') };
  if (frame.sim === 'silent') return { line: 'simulation silent: its relay hears nothing of it', kind: 'dead' };
  if (frame.hand === 'silent') return { line: 'hand silent: its relay hears nothing of it', kind: 'dead' };
  if (status.note) return { line: status.note };
  if (scene?.source === 'view' && frame.snapshot_id === null) return { line: 'no snapshot yet' };
  return { line: '' };
}
