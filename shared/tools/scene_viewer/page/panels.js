// Figures with their units, the badges of both servers, the legend and what went wrong.

import { device_figures } from './device.js';
import { byId } from './dom.js';
import { parts_of } from './hands.js';
import { body_name } from './hover.js';
import { relay_figures } from './relay.js';
import { kBodyColours } from './theme.js';

const fixed = (value, digits) =>
  (value === null || value === undefined || !Number.isFinite(value) ? '–' : value.toFixed(digits));

const pair = (values, digits) => `${fixed(values?.p50, digits)} / ${fixed(values?.p99, digits)}`;

/// id, name and unit, value of a frame, what it means.
const kNumbers = [
  ['rate', 'ticks, 1/s', (f) => fixed(f.ticks?.per_s, 0), 'Ticks of the haptic loop in the last second'],
  ['missed', 'missed', (f) => fixed(f.ticks?.missed, 0), 'Ticks that the haptic loop missed since its start'],
  ['force', 'force, N', (f) => fixed(f.tool ? Math.hypot(...f.tool.force_N) : NaN, 2), 'Norm of the force on the hand'],
  ['contacts', 'contacts', (f) => fixed(f.tool?.contacts, 0), 'Contacts of the tool in this tick'],
  ['snapshot_id', 'snapshot', (f) => fixed(f.snapshot_id, 0), 'Number of the newest snapshot'],
  ['alpha', 'alpha', (f) => fixed(f.display?.alpha, 2), 'How far the transition has come to the newest snapshot, of 1'],
  ['age', 'age, ms', (f) => fixed(f.tool ? 1000 * f.tool.age_s : NaN, 1), 'Age of the snapshot that the hand feels'],
  ['step', 'step, ms', (f) => fixed(f.snapshot?.step_ms, 2), 'Work of the simulation on the newest snapshot'],
  ['tool_work', 'work, mJ', (f) => fixed(1000 * (f.snapshot?.tool_work_J ?? NaN), 1), 'Work of the tool on the scene since its start, as the newest snapshot tells it'],
  ['work', 'tick µs, p50/99', (f) => pair(f.ticks?.tick_us, 0), 'Work of a tick, last second'],
  ['wake', 'late µs, p50/99', (f) => pair(f.ticks?.wake_us, 0), 'How late a tick woke, last second'],
];

export function make_numbers() {
  for (const [id, name, , meaning] of kNumbers) {
    const cell = document.createElement('div');
    cell.title = meaning;
    const term = document.createElement('dt');
    term.textContent = name;
    const value = document.createElement('dd');
    value.id = `number-${id}`;
    value.textContent = '–';
    cell.append(term, value);
    byId('numbers').append(cell);
  }
}

/// Of a hand that is no more they are the last that were seen.
export function show_numbers(frame) {
  byId('numbers').classList.toggle('stale', frame.hand !== 'alive' && !byId('hand-badge').hidden);
  for (const [id, , value] of kNumbers) byId(`number-${id}`).textContent = value(frame);
}

/// [name, value] each.
const lines = (figures) => figures.map(([name, value]) => {
  const cell = document.createElement('div');
  cell.textContent = `${name} `;
  const told = document.createElement('b');
  told.textContent = value;
  cell.append(told);
  return cell;
});

/// What the device told, a line each.
export function show_device(frame) {
  byId('device').replaceChildren(...lines(device_figures(frame.tool?.device)));
  byId('device').classList.toggle('stale', byId('numbers').classList.contains('stale'));
}

/// How what comes from another machine came, a line each.
export function show_relays(frame) {
  byId('relay').replaceChildren(...lines([['simulation over a relay', relay_figures(frame.sim_relay)],
    ['hand over a relay', relay_figures(frame.hand_relay)]].filter(([, told]) => told)));
}

/// state: alive, silent, dead or absent.
function show_badge(id, name, state) {
  byId(id).className = `badge ${state}`;
  byId(id).textContent = `${name} ${state}`;
}

export function show_badges(sim, hand) {
  show_badge('sim-badge', 'simulation', sim);
  show_badge('hand-badge', 'hand', hand);
}

/// The line across the picture; '' takes it away. kind: dead, gone or note.
export function show_banner(text, kind = 'note') {
  byId('banner').hidden = text === '';
  byId('banner').className = kind;
  if (byId('banner').textContent !== text) byId('banner').textContent = text;
}

export function show_scene(scene) {
  const name = scene.name || 'recording';
  byId('scene-name').textContent = name;
  byId('source').hidden = scene.source === 'session';
  // Which servers there were a recording does not know.
  byId('sim-badge').hidden = byId('hand-badge').hidden = scene.source === 'recording';
  byId('source').textContent = scene.source === 'view' ? 'saved view' : scene.source;
  document.title = `${name} – Stillgrid viewer`;
}

/// What a session is called: SESSION, or SESSION+HAND.
export function session_text(session) {
  const { whole, hand } = parts_of(session);
  return hand ? `${whole}, hand ${hand}` : whole;
}

/// names: to choose among; chosen: the one that is shown. Without a choice there is none to make.
export function show_sessions(names, chosen) {
  const choice = byId('session-choice');
  const all = [...new Set([...names, ...chosen ? [chosen] : []])].sort();
  if (choice.dataset.names !== all.join()) {
    choice.dataset.names = all.join();
    choice.replaceChildren(...all.map((name) => new Option(session_text(name), name)));
  }
  choice.value = chosen;
  choice.hidden = all.length === 0;
}

const kMaxBodies = 40;

/// The bodies with their colours, for who does not point at them.
export function show_bodies(scene) {
  const bodies = [...new Set([...scene.spheres.body, ...scene.planes.map(({ body }) => body),
    ...scene.surfaces?.bodies.map(({ body }) => body) ?? []])].sort((a, b) => a - b);
  const planes = new Set(scene.planes.map(({ body }) => body));
  byId('bodies').hidden = bodies.length === 0;
  byId('body-count').textContent = `${bodies.length}`;
  const lines = bodies.slice(0, kMaxBodies).map((body) => {
    const line = document.createElement('li');
    const swatch = document.createElement('i');
    swatch.className = planes.has(body) ? 'body plane' : `body body-${body % kBodyColours.length}`;
    line.append(swatch, body_name(scene, body));
    return line;
  });
  if (bodies.length > kMaxBodies) {
    const rest = document.createElement('li');
    rest.textContent = `and ${bodies.length - kMaxBodies} more: point at them`;
    lines.push(rest);
  }
  byId('body-list').replaceChildren(...lines);
}

/// What stands below the line across the picture: why, and the command that helps; { text, command } or null.
export function show_banner_help(help) {
  byId('banner-help').hidden = !help;
  if (!help || byId('banner-help').dataset.known === help.command + help.text) return;
  byId('banner-help').dataset.known = help.command + help.text;
  byId('banner-text').textContent = help.text;
  byId('banner-command').textContent = help.command;
}

const length = (metres) => (metres < 0.1 ? `${+(1000 * metres).toPrecision(3)} mm` : `${+metres.toPrecision(3)} m`);

export function show_scales({ metres_per_N, cell_m }) {
  byId('force-scale').textContent = `force: ${length(metres_per_N)} is 1 N`;
  byId('plane-scale').textContent = cell_m ? `grid of planes: ${length(cell_m)}` : '';
}

export function show_voxel_scale(visible, most) {
  byId('voxel-scale').hidden = !visible;
  byId('voxel-most').textContent = `${most}`;
}

/// time_s: of the frame shown, behind_s: how far behind the newest.
export function show_time(playback, time_s, behind_s) {
  const timeline = byId('timeline');
  timeline.min = playback.first;
  timeline.max = playback.last;
  timeline.value = playback.number;
  byId('time').textContent = playback.is_live
    ? (playback.mode === 'live' ? 'live' : `−${fixed(behind_s, 2)} s`)
    : `${fixed(time_s, 2)} s`;
  byId('time').title = `frame ${playback.number}`;
  byId('live').classList.toggle('on', playback.mode === 'live');
  byId('live').hidden = !playback.is_live;
  const pauses = playback.mode !== 'paused';
  byId('play').classList.toggle('pauses', pauses);
  byId('play').setAttribute('aria-label', pauses ? 'Pause' : 'Play');
}
