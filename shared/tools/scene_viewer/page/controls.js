// Switches, buttons and keys, and what each does.

import { byId } from './dom.js';

/// name, label, key, on at first.
const kSwitches = [
  ['displayed', 'displayed', 'd', true],
  ['newest', 'newest snapshot', 'n', false],
  ['previous', 'previous snapshot', 'p', false],
  ['surfaces', 'surfaces', 'm', true],
  ['spheres', 'spheres', 's', false],
  ['planes', 'planes', 'l', true],
  ['voxels', 'voxels', 'v', false],
  ['path', 'path', 't', true],
  ['axes', 'axes', 'a', true],
];

const kViews = [
  ['oblique', 'Oblique', 'o'], ['front', 'Front', 'f'], ['top', 'Top', 'u'], ['follow', 'Follow', 'g'],
];

/// Which parts are shown, by name; voxel_edge_m: of the level, or null for all.
export function initial_switches() {
  return { ...Object.fromEntries(kSwitches.map(([name, , , on]) => [name, on])), voxel_edge_m: null };
}

function make_switches(switches, on_change) {
  for (const [name, label, key] of kSwitches) {
    const line = document.createElement('label');
    const box = document.createElement('input');
    box.type = 'checkbox';
    box.id = `show-${name}`;
    box.checked = switches[name];
    box.addEventListener('change', () => {
      switches[name] = box.checked;
      on_change();
    });
    const hint = document.createElement('kbd');
    hint.textContent = key.toUpperCase();
    const dot = document.createElement('i');
    dot.className = `dot ${name}`;
    line.append(box, dot, label, hint);
    byId('switches').append(line);
  }
  const level = document.createElement('select');
  level.id = 'voxel-level';
  level.setAttribute('aria-label', 'Level of voxels');
  level.addEventListener('change', () => {
    switches.voxel_edge_m = level.value === '' ? null : Number(level.value);
    on_change();
  });
  byId('switches').append(level);
}

/// edges_m: of the voxels of each level. The one that is chosen stays so while there is one as large.
export function set_voxel_levels(edges_m, switches) {
  const level = byId('voxel-level');
  const edges = [...new Set(edges_m)].sort((a, b) => b - a);
  level.hidden = !switches.voxels;
  if (level.dataset.edges === edges.join()) return;
  level.dataset.edges = edges.join();
  const options = [['', 'all levels'], ...edges.map((edge) => [`${edge}`, `${+(1000 * edge).toPrecision(3)} mm`])];
  level.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  if (!edges.includes(switches.voxel_edge_m)) switches.voxel_edge_m = null;
  level.value = switches.voxel_edge_m ?? '';
}

/// actions: view(name), changed(), toggle(), step(frames), first(), live(), seek(number), speed(x), theme(), link(),
/// session(name), zoom(factor), zoom_out().
export function make_controls(switches, actions) {
  make_switches(switches, actions.changed);
  for (const [name, label, key] of kViews) {
    const button = document.createElement('button');
    button.textContent = label;
    button.title = `View: ${label} (${key.toUpperCase()})`;
    button.addEventListener('click', () => actions.view(name));
    byId('views').append(button);
  }
  const on_click = (id, action) => byId(id).addEventListener('click', action);
  on_click('play', actions.toggle);
  on_click('back', () => actions.step(-1));
  on_click('forward', () => actions.step(1));
  on_click('first', actions.first);
  on_click('live', actions.live);
  on_click('help-button', () => byId('help').showModal());
  on_click('theme', actions.theme);
  on_click('link', actions.link);
  byId('session-choice').addEventListener('change', () => actions.session(byId('session-choice').value));
  // Where the picture is small its switches would hide it.
  const small = matchMedia('(max-width: 900px), (max-height: 520px)');
  const fold = () => { byId('show').open = !small.matches; };
  small.addEventListener('change', fold);
  fold();
  byId('timeline').addEventListener('input', () => actions.seek(Number(byId('timeline').value)));
  byId('speed').addEventListener('change', () => actions.speed(Number(byId('speed').value)));

  const shortcuts = make_shortcuts(actions);
  show_shortcuts(shortcuts);
  window.addEventListener('keydown', (event) => on_key(event, shortcuts));
}

/// key, label, meaning, action; a key with shift has a capital S before it.
function make_shortcuts(actions) {
  return [
    [' ', 'space', 'pause, play on', actions.toggle],
    ['ArrowLeft', '←', 'a frame back', () => actions.step(-1)],
    ['ArrowRight', '→', 'a frame on', () => actions.step(1)],
    ['Shift ArrowLeft', 'shift ←', 'a second back', () => actions.step_s(-1)],
    ['Shift ArrowRight', 'shift →', 'a second on', () => actions.step_s(1)],
    ['Home', 'home', 'the first frame', actions.first],
    ['End', 'end', 'the newest frame, live', actions.live],
    ...kSwitches.map(([name, label, key]) => [key, key.toUpperCase(), label, () => byId(`show-${name}`).click()]),
    ...kViews.map(([name, label, key]) =>
      [key, key.toUpperCase(), `view: ${label.toLowerCase()}`, () => actions.view(name)]),
    ['b', 'B', 'dark or light', actions.theme],
    ['k', 'K', 'copy a link to this instant', actions.link],
    ['i', 'I', 'picture of the scene (PNG)', () => byId('picture').click()],
    ['c', 'C', 'film of the scene: begin, end', () => byId('film').click()],
    ['+', '+', 'plots: into a shorter time', () => actions.zoom(0.5)],
    ['-', '−', 'plots: a longer time', () => actions.zoom(2)],
    ['0', '0', 'plots: as at first', actions.zoom_out],
    ['?', '?', 'this help', () => byId('help').showModal()],
  ];
}

function show_shortcuts(shortcuts) {
  for (const [, label, meaning] of shortcuts) {
    const line = document.createElement('div');
    const key = document.createElement('kbd');
    key.textContent = label;
    line.append(key, meaning);
    byId('shortcuts').append(line);
  }
}

/// Keys that do again what they do while they are held.
const kRepeats = ['ArrowLeft', 'ArrowRight', '+', '-'];

function on_key(event, shortcuts) {
  if (event.ctrlKey || event.altKey || event.metaKey || byId('help').open) return;
  if (event.target.tagName === 'SELECT') return;
  const shift = event.shiftKey && event.key.startsWith('Arrow') ? 'Shift ' : '';
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (event.repeat && !kRepeats.includes(event.key)) return;
  const shortcut = shortcuts.find(([wanted]) => wanted === shift + key);
  if (!shortcut) return;
  event.preventDefault();
  shortcut[3]();
}
