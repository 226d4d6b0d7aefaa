// Asks for frames and ticks, and hands them to the picture, the plots and the figures.
import * as api from './api.js';
import { initial_switches, make_controls, set_voxel_levels } from './controls.js';
import * as panels from './panels.js';
import { Playback } from './playback.js';
import { kWindow_s, Plots } from './plots.js';
import { SceneView } from './scene_view.js';
import { TickHistory } from './tick_history.js';

const kFrame_ms = 1000 / 30;
const kTicks_ms = 100;
const kPlots_ms = 80;
const kStatus_ms = 400;
const kPath_s = 2;
const kLongestBackOff_ms = 4000;

const switches = initial_switches();
const ticks = new TickHistory();
let playback = new Playback();
let scene = null;  // of /api/scene
let frame = null;  // that is shown
let status = null;
let view = null;
let plots = null;
let no_picture = '';  // why there is none

function begin() {
  panels.make_numbers();
  plots = new Plots(document.getElementById('plots'), ticks, () => { plots.dirty = true; });
  try {
    view = new SceneView(document.getElementById('scene-canvas'), switches);
  } catch (error) {
    document.getElementById('view').dataset.picture = 'none';
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
  });
  requestAnimationFrame(loop);
}

/// A new scene, also at the start: the plots' flags, the view's bodies.
async function take_scene(of_frame) {
  const next = await api.scene(of_frame.scene_key);
  // A recording knows no bodies: there the tool's path is what is to be seen.
  const around_m = next.spheres.count > 0
    ? of_frame.arrays.newest : (await api.ticks(1, 1 << 16)).arrays.position_m;
  plots.flag_names = next.flags;
  panels.show_scene(next);
  view?.set_scene(next, around_m, of_frame.tool);
  if (view) panels.show_scales(view.scales);
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
  const asked = ticks.missing(frame.tool.tick, Math.round(kWindow_s * per_s));
  if (asked === null) return;
  const { arrays } = await api.ticks(asked.from, asked.most);
  ticks.append(arrays);
  plots.dirty = true;
}

function show() {
  if (!frame || !scene) return;
  const levels = [...frame.grid.levels, ...scene.static_grid?.levels ?? []];
  set_voxel_levels(levels.map((level) => level.voxel_m), switches);
  if (view && scene.scene_key === frame.scene_key) {
    const end = ticks.lower_bound(frame.time_s + 1e-9);
    view.place(frame, ticks, ticks.lower_bound(frame.time_s - kPath_s), end);
    document.getElementById('shown-spheres').textContent =
      `${view.spheres_shown} of ${scene.spheres.radius_m.length} spheres`;
    panels.show_voxel_scale(switches.voxels, view.voxels.most_count);
  }
  panels.show_numbers(frame);
  panels.show_device(frame);
  panels.show_relays(frame);
  plots.dirty = true;
}

/// The line across the picture and its kind: the first of what there is to say.
function banner() {
  const fault = Object.values(faults).find(({ line }) => line !== '');
  if (faults.status.line) return [faults.status.line, 'gone'];
  if (fault) return [fault.line];
  if (!frame) return [status.note || 'waiting for a session'];
  if (frame.sim === 'dead') return ['simulation dead', 'dead'];
  if (frame.hand === 'dead') return ['hand dead', 'dead'];
  if (frame.sim === 'silent') return ['simulation silent: its relay hears nothing of it', 'dead'];
  if (frame.hand === 'silent') return ['hand silent: its relay hears nothing of it', 'dead'];
  if (status.note) return [status.note];
  if (scene?.source === 'view' && frame.snapshot_id === null) return ['no snapshot yet: space plays on'];
  return [no_picture];
}

function show_state() {
  panels.show_banner(...banner());
  const is_gone = faults.status.line !== '';
  const { sim, hand } = playback.is_live || !frame ? status : frame;
  panels.show_badges(is_gone ? 'unknown' : sim, is_gone ? 'unknown' : hand);
  if (!frame) return;
  panels.show_time(playback, frame.time_s, (status.now_s ?? frame.time_s) - frame.time_s);
  document.getElementById('view').classList.toggle('dead', frame.sim === 'dead' || frame.sim === 'silent');
}

const due = { frame: 0, ticks: 0, status: 0 };
/// Of each that is asked for: how often it failed in a row, and what there is to say of that.
const faults = { status: { count: 0, line: '' }, frame: { count: 0, line: '' }, ticks: { count: 0, line: '' } };
let plots_due_ms = 0;
let busy = false;
let was_away = false;

/// What is due is asked for, one after the other: never two requests at once.
async function ask(now_ms) {
  if (now_ms >= due.status) {
    due.status = now_ms + kStatus_ms;
    if (await attempt('status', take_status) && was_away) {
      ticks.clear();  // another viewer counts its time from its own start
      was_away = false;
    }
  }
  if (!status || faults.status.count > 0) return;
  if (now_ms >= due.frame && status.first_frame <= status.last_frame) {
    const number = playback.next(now_ms);
    if (number !== null) {
      due.frame = now_ms + kFrame_ms * 0.9;  // displays show a frame a little early or late
      await attempt('frame', () => take_frame(number));
    }
  }
  if (now_ms >= due.ticks) {
    due.ticks = now_ms + kTicks_ms;
    await attempt('ticks', take_ticks);
  }
}

/// Whether it succeeded. A fault of one does not end with the success of another.
async function attempt(what, take) {
  try {
    await take();
    Object.assign(faults[what], { count: 0, line: '' });
    return true;
  } catch (error) {
    back_off(what, error);
    return false;
  }
}

function back_off(what, error) {
  const fault = faults[what];
  ++fault.count;
  if (error instanceof api.Absent) {  // a frame that is no more, or is damaged: asked for again now and then
    fault.line = error.message;
    due[what] = performance.now() + kStatus_ms;
    return;
  }
  due[what] = performance.now() + Math.min(250 * 2 ** (fault.count - 1), kLongestBackOff_ms);
  if (error instanceof api.Stranger) {
    fault.line = 'viewer was started anew: open the address that it printed';
    return;
  }
  if (error instanceof api.Unreachable) {
    was_away = true;
    due.status = Math.min(due.status, due[what]);  // which tells whether the viewer is gone
  }
  if (fault.count < 2) return;
  fault.line = what === 'status' ? 'viewer is gone: start scene_viewer again'
    : `the ${what} cannot be shown: ${error.message}`;
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
  if (status) show_state();
  busy = false;
}

begin();
