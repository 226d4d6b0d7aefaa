// Asks for frames and ticks, and hands them to the picture, the plots and the figures.
import * as api from './api.js';
import { initial_switches, make_controls, set_voxel_levels } from './controls.js';
import { byId, copy, say } from './dom.js';
import { Exporter } from './export.js';
import { parts_of, show_hands } from './hands.js';
import { Faults } from './faults.js';
import { body_name, Hover } from './hover.js';
import { format_link, frame_at, parse_link } from './link.js';
import { MouseControls } from './mouse_controls.js';
import * as panels from './panels.js';
import { Playback } from './playback.js';
import { Plots } from './plots.js';
import { SceneView } from './scene_view.js';
import { words_of } from './state_words.js';
import { Theme } from './theme.js';
import { TickHistory } from './tick_history.js';

const kFrame_ms = 1000 / 30;
const kTicks_ms = 100;
const kPlots_ms = 80;
const kStatus_ms = 400;
const kSessions_ms = 2000;
const kPath_s = 2;
const kMaxTicks = 65536;  // that the viewer gives at once

const switches = initial_switches();
const ticks = new TickHistory();
let playback = new Playback();
let scene = null;  // of /api/scene
let frame = null;  // that is shown
let status = null;
let view = null;
let plots = null;
let mouse = null;  // where there is a picture
let no_picture = '';  // why there is none
const faults = new Faults(['status', 'frame', 'ticks', 'sessions']);
let wanted = parse_link(location.hash);  // an instant that is not shown yet
const theme = new Theme(recolour);

function begin() {
  panels.make_numbers();
  plots = new Plots(byId('plots'), ticks, theme, () => { plots.dirty = true; });
  const canvas = byId('scene-canvas');
  try {
    view = new SceneView(canvas, switches, theme);
    new Hover(canvas, (x, y) => view.pick(x, y), name_of);
    new Exporter(canvas, () => view.render(true), told);
    mouse = new MouseControls(canvas, view, { frame: () => frame, scene: () => scene, live: () => playback.live(),
      is_live: () => playback.mode === 'live', send: api.mouse, beacon: api.mouse_beacon });
  } catch (error) {
    byId('view').dataset.picture = 'none';
    for (const id of ['picture', 'film']) byId(id).disabled = true;
    no_picture = `no picture: this browser gives no WebGL (${error.message})`;
  }
  make_controls(switches, {
    view: (name) => { view?.camera.view(name); show(); },
    changed: show,
    toggle: () => playback.toggle(performance.now()),
    step: (frames) => playback.step(frames),
    step_s: (seconds) => playback.step(Math.round(seconds * playback.frames_per_s)),
    first: () => playback.seek(playback.first),
    live: () => playback.live(),
    seek: (number) => playback.seek(number),
    speed: (speed) => { playback.speed = speed; },
    theme: () => theme.toggle(),
    link,
    session: (name) => { next_session = name; },
    zoom: (factor) => { plots.window.zoom(factor, 1, plots.own_s); plots.dirty = true; },
    zoom_out: () => { plots.window.reset(); plots.dirty = true; },
  });
  byId('banner-copy').addEventListener('click', async () => {
    const command = byId('banner-command').textContent;
    say(await copy(command) ? 'the command is copied' : 'this browser gives no clipboard: mark the command');
  });
  window.addEventListener('hashchange', () => { wanted = parse_link(location.hash); });
  requestAnimationFrame(loop);
}

function recolour() {
  view?.recolour();
  if (plots) plots.dirty = true;
  show();
}

const name_of = ({ hand, body }) => {
  if (body !== undefined) return body_name(scene, body);
  return hand ? `tool of hand ${hand}` : 'tool';
};

/// What a picture or a film shows.
const told = () => ({
  scene: scene?.name ?? '', time_s: frame?.time_s ?? 0, colours: theme.colours.picture,
  caption: `${scene?.name ?? ''}, ${(frame?.time_s ?? 0).toFixed(2)} s; ${byId('force-scale').textContent}`,
});

/// The address gets what is shown now, and the clipboard the address.
async function link() {
  if (!frame) return;
  playback.pause();
  const { source } = scene ?? {};
  const hash = format_link({ session: source === 'session' ? api.chosen() : '', time_s: frame.time_s,
    camera_m: view?.camera.place_m });
  history.replaceState(null, '', hash);
  say(await copy(location.href) ? 'a link to this instant is copied' : 'the address is a link to this instant');
}

/// The session that the user chose, or the link, or where none was named the first that runs.
let next_session = null;
let running = [];

async function take_sessions() {
  const told_ = await api.sessions();
  running = told_.running;
  if (!api.chosen()) api.choose(told_.named || running[0] || '');
  panels.show_sessions(running, api.chosen());
}

/// From here on nothing is of the session before.
function turn_to(session) {
  next_session = null;
  if (session === api.chosen()) return;
  mouse?.let_go();
  api.choose(session);
  status = frame = scene = null;
  ticks.clear();
  faults.forget();
  panels.show_sessions(running, session);
}

/// What the link asked for, once its session is known.
async function follow_link() {
  const { time_s, camera_m } = wanted;
  wanted = { session: null, time_s: null, camera_m: null };
  if (camera_m) kept_camera_m = camera_m;
  if (time_s === null) return;
  const time_of = (number) => api.frame(number).then((found) => found.time_s, () => null);
  const { first_frame, last_frame } = status;
  const number = await frame_at(time_s, first_frame, last_frame, time_of);
  const found_s = await time_of(number);
  if (found_s === null || Math.abs(found_s - time_s) > 1) say(`nothing is held of ${time_s.toFixed(2)} s: the nearest is shown`);
  playback.set_range(first_frame, last_frame);
  playback.seek(number);
}
let kept_camera_m = null;  // of a link, for when the scene has come

/// A new scene, also at the start: the plots' flags, the view's bodies.
async function take_scene(of_frame) {
  const next = await api.scene(of_frame.scene_key);
  // A recording knows no bodies: there the tool's path is what is to be seen.
  const around_m = next.spheres.count > 0
    ? of_frame.arrays.newest : (await api.ticks(1, 1 << 16)).arrays.position_m;
  plots.flag_names = next.flags;
  panels.show_scene(next);
  const others_m = (of_frame.others ?? []).flatMap(({ tool }) => tool.position_m);
  view?.set_scene(next, [...around_m, ...others_m], of_frame.tool);
  panels.show_bodies(next);
  if (view) panels.show_scales(view.scales);
  if (view && kept_camera_m) view.camera.place_m = kept_camera_m;
  kept_camera_m = null;
  scene = next;  // now that nothing of it is missing: what fails before is tried again
}

async function take_status() {
  const before = status;
  status = await api.status();
  if (before === null) {
    playback = new Playback(status.live);
    playback.number = status.first_frame;
    if (!status.live) await measure_frame_rate();
  }
  const has_frames = status.first_frame <= status.last_frame;
  if (has_frames && (wanted.time_s !== null || wanted.camera_m)) await follow_link();
  // The oldest of a full history will be gone when they are asked for.
  const leaving = status.live && status.first_frame > 1 ? Math.round(2 * playback.frames_per_s) : 0;
  playback.set_range(Math.min(status.first_frame + leaving, status.last_frame), status.last_frame);
}

/// Of a saved view: frames over the time between its first and its last.
async function measure_frame_rate() {
  const { first_frame, last_frame } = status;
  if (last_frame <= first_frame) return;
  const [first, last] = await Promise.all([first_frame, last_frame].map((number) =>
    api.frame(number).catch(() => null)));
  if (!first || !last) return;  // a damaged one
  playback.frames_per_s = (last_frame - first_frame) / Math.max(last.time_s - first.time_s, 1e-3);
}

async function take_frame(number) {
  try {
    const next = await api.frame(number);
    // Paused while it was on its way: what stands goes on to stand.
    if (number === 'latest' && playback.mode !== 'live') return;
    follow(frame, next);
    frame = next;
    if (scene?.scene_key !== frame.scene_key) await take_scene(frame);
    show();
  } catch (error) {
    playback.not_come();
    throw error;
  }
}

/// A frame after another one: where playback stands, and how many there are a second.
function follow(before, next) {
  playback.shown(next.frame);
  if (playback.mode !== 'live') return;
  playback.last = Math.max(playback.last, next.frame);
  const passed_s = next.time_s - before?.time_s;
  const passed = next.frame - before?.frame;
  if (passed > 0 && passed_s > 0) {
    playback.frames_per_s += 0.05 * (passed / passed_s - playback.frames_per_s);
  }
}

/// The ticks that the plots show, up to those of the frame.
async function take_ticks() {
  if (!frame?.tool) return;
  const per_s = 1 / (scene?.tick_period_s || 1e-3);
  const asked = ticks.missing(frame.tool.tick, Math.min(Math.round(plots.reach_s * per_s), kMaxTicks));
  if (asked === null) return;
  const { arrays } = await api.ticks(asked.from, asked.most);
  ticks.append(arrays);
  plots.dirty = true;
  if (playback.mode === 'paused') show();  // the path, which the frame came before
}

function show() {
  if (!frame || !scene) return;
  const levels = [...frame.grid.levels, ...scene.static_grid?.levels ?? []];
  set_voxel_levels(levels.map((level) => level.voxel_m), switches);
  if (view && scene.scene_key === frame.scene_key) {
    const end = ticks.lower_bound(frame.time_s + 1e-9);
    view.place(frame, ticks, ticks.lower_bound(frame.time_s - kPath_s), end);
    byId('shown-spheres').textContent =
      `${view.spheres_shown} of ${scene.spheres.radius_m.length} spheres`;
    panels.show_voxel_scale(switches.voxels, view.voxels.most_count);
  }
  panels.show_numbers(frame);
  panels.show_device(frame);
  panels.show_relays(frame);
  show_hands(frame, parts_of(scene.session).hand, (hand) => {
    next_session = `${parts_of(scene.session).whole}+${hand}`;
  });
  plots.dirty = true;
}

/// The line across the picture, its kind and what helps: the first of what there is to say.
function banner() {
  const { line, is_absent } = faults.of('status');
  if (line) return { line, kind: is_absent ? 'note' : 'gone' };
  if (faults.line) return { line: faults.line };
  if (!frame) return { line: status?.note || 'waiting for a session' };
  const words = words_of(frame, status, scene);
  return words.line ? words : { line: no_picture };
}

function show_state() {
  const { line, kind, help } = banner();
  panels.show_banner(line, kind);
  panels.show_banner_help(help ?? null);
  const is_gone = faults.of('status').line !== '';
  const { sim, hand } = (playback.is_live || !frame ? status : frame) ?? { sim: 'unknown', hand: 'unknown' };
  panels.show_badges(is_gone ? 'unknown' : sim, is_gone ? 'unknown' : hand);
  mouse?.show(status, frame);
  if (!frame) return;
  panels.show_time(playback, frame.time_s, (status.now_s ?? frame.time_s) - frame.time_s);
  byId('view').classList.toggle('dead', frame.sim === 'dead' || frame.sim === 'silent');
}

let plots_due_ms = 0;
let busy = false;

/// What is due is asked for, one after the other: never two requests at once.
async function ask(now_ms) {
  if (wanted.session) next_session = wanted.session;
  wanted.session = null;
  if (next_session !== null) turn_to(next_session);
  if (now_ms >= faults.due_ms.sessions) {
    faults.due_ms.sessions = now_ms + kSessions_ms;
    await faults.attempt('sessions', take_sessions);
  }
  if (now_ms >= faults.due_ms.status) {
    faults.due_ms.status = now_ms + kStatus_ms;
    if (await faults.attempt('status', take_status) && faults.was_away) {
      ticks.clear();  // another viewer counts its time from its own start
      faults.was_away = false;
    }
  }
  if (!status || faults.of('status').count > 0) return;
  if (now_ms >= faults.due_ms.frame && status.first_frame <= status.last_frame) {
    const number = playback.next(now_ms);
    if (number !== null) {
      faults.due_ms.frame = now_ms + kFrame_ms * 0.9;  // displays show a frame a little early or late
      await faults.attempt('frame', () => take_frame(number));
    }
  }
  if (now_ms >= faults.due_ms.ticks) {
    faults.due_ms.ticks = now_ms + kTicks_ms;
    await faults.attempt('ticks', take_ticks);
  }
}

async function loop(now_ms) {
  requestAnimationFrame(loop);  // which a hidden page does not come by
  if (plots.dirty && frame && now_ms >= plots_due_ms) {
    plots.dirty = false;
    plots_due_ms = now_ms + kPlots_ms;
    plots.draw(frame.time_s);
  }
  view?.render();
  if (busy) return;
  busy = true;
  await ask(now_ms);
  if (status || faults.line) show_state();
  busy = false;
}

begin();
