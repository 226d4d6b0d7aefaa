// What the page decides without a browser: which frame is next, which ticks are missing, how bytes are read.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { decode } from '../../shared/tools/scene_viewer/page/api.js';
import { device_figures, is_by_mouse } from '../../shared/tools/scene_viewer/page/device.js';
import { format_link, frame_at, parse_link } from '../../shared/tools/scene_viewer/page/link.js';
import { Playback } from '../../shared/tools/scene_viewer/page/playback.js';
import { binned_percentiles, flag_spans } from '../../shared/tools/scene_viewer/page/plots.js';
import { relay_figures } from '../../shared/tools/scene_viewer/page/relay.js';
import { words_of } from '../../shared/tools/scene_viewer/page/state_words.js';
import { kBodyColours, kDashes, kThemes } from '../../shared/tools/scene_viewer/page/theme.js';
import { TickHistory } from '../../shared/tools/scene_viewer/page/tick_history.js';
import { kLongest_s, kShortest_s, TimeWindow } from '../../shared/tools/scene_viewer/page/time_window.js';
import { contrast, difference, kEyes } from './colour_vision.mjs';

function message(head, ...arrays) {
  let text = JSON.stringify(head);
  text += ' '.repeat((4 - text.length % 4) % 4);
  const bytes = [new Uint32Array([text.length]), new TextEncoder().encode(text), ...arrays]
    .flatMap((array) => [...new Uint8Array(array.buffer, array.byteOffset, array.byteLength)]);
  return Uint8Array.from(bytes).buffer;
}

test('a message gives its arrays, doubles on odd places too', () => {
  const head = { frame: 7, arrays: [{ name: 'a', type: 'f32', count: 3 }, { name: 'b', type: 'f64', count: 2 },
    { name: 'c', type: 'u32', count: 1 }] };
  const { frame, arrays } = decode(message(head, Float32Array.of(1, 2, 3), Float64Array.of(0.1, -5), Uint32Array.of(9)));
  assert.equal(frame, 7);
  assert.deepEqual([...arrays.a], [1, 2, 3]);
  assert.deepEqual([...arrays.b], [0.1, -5]);
  assert.deepEqual([...arrays.c], [9]);
});

test('the mouse is the hand where the command says so', () => {
  for (const device of ['mouse', 'mouse:pull_N=3', 'mouse@0', '/opt/devices/mouse.so', "'mouse:session=a b'"]) {
    assert.ok(is_by_mouse(`bin/haptic_server --session demo --device ${device} --duration 3`), device);
    assert.ok(is_by_mouse(`haptic_server --device=${device}`), device);
  }
  for (const device of ['spacemouse', 'mouse2', 'phantom:path=mouse.csv', 'mouse.so.bak', 'mouse/phantom.so']) {
    assert.ok(!is_by_mouse(`haptic_server --device ${device} --session mouse`), device);
  }
  assert.ok(!is_by_mouse(''));
});

function paused_at(number) {
  const playback = new Playback();
  playback.set_range(0, 100);
  playback.seek(number);
  return playback;
}

test('live asks for the latest, a pause for nothing, a seek once', () => {
  const playback = new Playback();
  playback.set_range(1, 50);
  assert.equal(playback.next(0), 'latest');
  playback.shown(50);
  playback.pause();
  assert.equal(playback.next(0), null);
  playback.step(-1);
  assert.equal(playback.next(0), 49);
  assert.equal(playback.next(0), null);
});

test('a frame that did not come is asked for again', () => {
  const playback = paused_at(10);
  playback.next(0);
  playback.not_come();
  assert.equal(playback.next(0), 10);
});

test('a seek stays among the frames that there are', () => {
  assert.equal(paused_at(500).next(0), 100);
  assert.equal(paused_at(-5).next(0), 0);
});

test('play goes by the clock and the speed', () => {
  const playback = paused_at(10);
  playback.speed = 0.5;
  playback.toggle(1000);
  assert.equal(playback.next(2000), 25);
});

test('play that comes to the newest frame is live; in a saved view it ends, and begins anew', () => {
  const live = paused_at(95);
  live.toggle(0);
  assert.equal(live.next(1000), 'latest');
  const saved = new Playback(false);
  saved.set_range(0, 100);
  saved.seek(95);
  saved.toggle(0);
  assert.equal(saved.next(1000), 100);
  assert.equal(saved.mode, 'paused');
  saved.toggle(2000);
  assert.equal(saved.next(2000), 0);
});

function ticks(from, count, time_of = (tick) => tick / 1000) {
  const numbers = Float64Array.from({ length: count }, (_, i) => from + i);
  const columns = { tick: numbers, time_s: numbers.map(time_of) };
  for (const name of ['age_s', 'tick_us', 'wake_us', 'flags', 'snapshot_id']) columns[name] = new Float32Array(count);
  for (const name of ['position_m', 'force_N']) columns[name] = new Float32Array(3 * count);
  return columns;
}

test('ticks are asked for where they end, and anew where they do not join', () => {
  const history = new TickHistory();
  assert.deepEqual(history.missing(20000, 10000), { from: 10001, most: 10000 });
  history.append(ticks(10001, 10000));
  assert.equal(history.missing(20000, 10000), null);
  assert.deepEqual(history.missing(20030, 10000), { from: 20001, most: 10000 });
  assert.equal(history.missing(20000, 10000), null, 'scrubbed back into what is held');
  assert.deepEqual(history.missing(15000, 10000), { from: 5001, most: 10000 }, 'before it');
  history.append(ticks(5001, 10000));
  assert.deepEqual(history.missing(90000, 10000), { from: 80001, most: 10000 }, 'after a gap');
});

test('an hour of ticks keeps the last minute, in order', () => {
  const history = new TickHistory();
  history.missing(1, 10000);
  for (let tick = 1; tick < 400000; tick += 100) history.append(ticks(tick, 100));
  assert.ok(history.count >= 60000 && history.count <= 131072);
  assert.equal(history.last_tick, 400000);
  assert.equal(history.columns.tick[history.lower_bound(350)], 350000);
  assert.ok(history.missing(400000, 10000) === null);
});

test('percentiles of a bin are those of its values, each bin by itself', () => {
  const times = Array.from({ length: 500 }, (_, i) => i / 1000);
  const values = times.map((_, i) => (i < 250 ? (i * 7) % 250 : 1000));
  const [first, second] = binned_percentiles(times, values, 0, 500);
  assert.equal(first.p50, 125);
  assert.equal(first.p99, 247);
  assert.equal(second.p50, 1000);
});

test('a flag stands from its first tick to its last, and a pause between makes two', () => {
  const times = [0, 0.001, 0.002, 0.003, 0.5, 0.501];
  const spans = flag_spans(times, [4, 4, 4, 0, 5, 4], 0, 6, 3);
  assert.deepEqual(spans, [[[0.5, 0.5]], [], [[0, 0.002], [0.5, 0.501]]]);
});

test('of a device that is shown which it tells, and nothing of the rest', () => {
  const silent = { status: 0, status_known: 0, temperature_C: null, gripper_m: null, gripper_force_N: null, axes: null };
  assert.deepEqual(device_figures(null), []);
  assert.deepEqual(device_figures(silent), []);
  // The last bit is of no status that this page knows.
  assert.deepEqual(device_figures({ ...silent, status: 0b100001, status_known: 0b101011 }),
    [['status', 'motors on, not enabled, not hot']]);
  assert.deepEqual(device_figures({ ...silent, temperature_C: 41.26 }), [['temperature', '41.3 °C']]);
  assert.deepEqual(device_figures({ ...silent, gripper_m: 0.0123, gripper_force_N: -0.5, axes: [0, -1, 0.25, null] }),
    [['gripper', 'open 12.3 mm, force -0.50 N'], ['axes', '0.00, -1.00, 0.25, –']]);
});

test('of a relay the counts that are not zero are shown, and of none nothing', () => {
  const silent = { connected: false, round_trip_ns: null, clock_offset_ns: null, clock_bound_ns: null, received: 0,
    received_bytes: 0, lost: 0, repeated: 0, out_of_order: 0, late: 0, refused: 0, partitions: 0, longest_silence_ns: 0 };
  assert.equal(relay_figures(null), '');
  assert.equal(relay_figures(undefined), '', 'a view of before');
  assert.equal(relay_figures(silent), 'silent: the other side is not heard, 0 received, 0 lost');
  assert.equal(relay_figures({ ...silent, connected: true, round_trip_ns: 20340000, clock_offset_ns: -1234567890123,
    clock_bound_ns: 84300, received: 1234567, lost: 1002, out_of_order: 3, longest_silence_ns: 3.14e9 }),
  'connected, round trip 20.3 ms, clock −1234.6 s ± 0.084 ms, 1,234,567 received, 1,002 lost, 3 out of order, '
    + 'longest silence 3.1 s');
});

/// The least difference of two of these colours, for any eyes.
function least_difference(colours) {
  let least = Infinity;
  for (const eyes of Object.keys(kEyes)) {
    for (let i = 0; i < colours.length; ++i) {
      for (let j = 0; j < i; ++j) least = Math.min(least, difference(colours[i], colours[j], eyes));
    }
  }
  return least;
}

test('series of one plot differ for the colour-blind too, and by their dashes', () => {
  for (const [theme, { plot }] of Object.entries(kThemes)) {
    for (const series of [['norm', 'x', 'y', 'z'], ['work', 'wake'], ['age', 'mark']]) {
      const least = least_difference(series.map((name) => plot[name]));
      assert.ok(least > 25, `${theme}, ${series}: ${least}`);
    }
  }
  const dashes = ['x', 'y', 'z'].map((axis) => kDashes[axis].join());
  assert.equal(new Set(dashes).size, 3);
});

test('bodies and hands differ for the colour-blind too', () => {
  assert.ok(least_difference(kBodyColours) > 15, `bodies: ${least_difference(kBodyColours)}`);
  for (const [theme, { picture }] of Object.entries(kThemes)) {
    assert.ok(least_difference(picture.hands) > 25, `${theme}: ${least_difference(picture.hands)}`);
  }
});

test('what is measured of colours is what is known of them', () => {
  assert.ok(Math.abs(contrast('#ffffff', '#000000') - 21) < 1e-9);
  assert.ok(Math.abs(contrast('#767676', '#ffffff') - 4.54) < 0.01, 'the lightest grey that can be read on white');
  // A red and a green that who has no cones for middle wavelengths takes for one.
  assert.ok(difference('#c8523c', '#87762f', 'deuteranopia') < 0.5 * difference('#c8523c', '#87762f', 'usual'));
  assert.equal(Math.round(difference('#ffffff', '#000000', 'protanopia')), 100);
});

test('texts can be read, and lines of plots seen, in both themes', () => {
  for (const [theme, { css, plot }] of Object.entries(kThemes)) {
    for (const [text, ground] of [['text', 'panel'], ['text', 'ground'], ['text', 'card'], ['text', 'button'],
      ['text', 'hover'], ['text', 'on'], ['muted', 'panel'], ['muted', 'card'], ['alive-text', 'alive'],
      ['dead-text', 'dead'], ['neutral-text', 'neutral']]) {
      const ratio = contrast(css[text], css[ground]);
      assert.ok(ratio >= 4.5, `${theme}: ${text} on ${ground}: ${ratio}`);
    }
    for (const text of ['text', 'muted']) assert.ok(contrast(plot[text], css.panel) >= 4.5, `${theme}: ${text} of plots`);
    for (const line of ['norm', 'x', 'y', 'z', 'age', 'mark', 'work', 'wake', 'flag']) {
      assert.ok(contrast(plot[line], css.panel) >= 3, `${theme}: ${line}: ${contrast(plot[line], css.panel)}`);
    }
  }
});

test('a window of time keeps what is pointed at where it is, and stays where ticks are', () => {
  const window_ = new TimeWindow();
  const at = (share) => { const { from_s, to_s } = window_.range(100, 10); return from_s + share * (to_s - from_s); };
  const before_s = at(0.3);
  window_.zoom(0.25, 0.3, 10);
  assert.ok(Math.abs(at(0.3) - before_s) < 1e-9);
  assert.ok(Math.abs(window_.reach_s(10) - (100 - window_.range(100, 10).from_s)) < 1e-9);
  const moved_s = at(0);
  window_.pan(-0.5, 10);
  assert.ok(Math.abs(at(0) - (moved_s - 1.25)) < 1e-9);
  for (const [factor, share] of [[1e-6, 0.5], [1e6, 0], [1e6, 1], [0.5, 0]]) {
    window_.zoom(factor, share, 10);
    window_.pan(share - 5, 10);
    window_.pan(share + 500, 10);
    const { from_s, to_s } = window_.range(100, 10);
    assert.ok(to_s <= 100 && from_s >= 100 - kLongest_s - 1e-9 && to_s - from_s >= kShortest_s - 1e-12, `${from_s}, ${to_s}`);
  }
  window_.reset();
  assert.deepEqual(window_.range(100, 10), { from_s: 90, to_s: 100 });
  assert.deepEqual(window_.range(100, 1), { from_s: 99, to_s: 100 });
});

test('a link tells session, instant and camera, and what is none of these is left out', () => {
  const camera_m = [0.1, -2, 3.25, 0, 1e-4, -0.5];
  const link = format_link({ session: 'a b+left', time_s: 12.3456, camera_m });
  assert.equal(link, '#session=a%20b%2Bleft&t=12.346&camera=0.1,-2,3.25,0,0.0001,-0.5');
  assert.deepEqual(parse_link(link), { session: 'a b+left', time_s: 12.346, camera_m });
  const none = { session: null, time_s: null, camera_m: null };
  for (const text of ['', '#', '#t=', '#t=x', '#t=1e999', '#camera=1,2,3', '#camera=1,2,3,4,5,', '#camera=1,2,3,4,5,NaN',
    '#camera=1,2,3,4,5,1e9', '#session=', '#%']) assert.deepEqual(parse_link(text), none, text);
});

test('the frame of an instant is found, whatever frames are damaged', async () => {
  const times = [0, 0.03, 0.07, 0.1, 0.9, 1, 1.5];  // of frames 5 to 11
  const find = (time_s, damaged = []) => frame_at(time_s, 5, 11, async (number) =>
    (damaged.includes(number) ? null : times[number - 5]));
  for (const [i, time_s] of times.entries()) assert.equal(await find(time_s), 5 + i);
  assert.equal(await find(-3), 5);
  assert.equal(await find(99), 11);
  assert.equal(await find(0.5), 8);
  assert.equal(await find(0.0996), 8, 'links are rounded');
  for (let number = 5; number <= 11; ++number) {
    const found = await find(0.5, [number]);
    assert.ok(Math.abs(found - 8) <= (number === 8 ? 1 : 0), `${number} damaged: ${found}`);
  }
});

test('of a dead server the page tells the command that starts it again', () => {
  const frame = { sim: 'dead', hand: 'alive', snapshot_id: 3 };
  const scene = { session: 'demo+left', name: 'wall', source: 'session' };
  const status = { live: true, note: '', sim_command: '', hand_command: 'haptic_server --session demo' };
  assert.equal(words_of(frame, status, scene).help.command, 'sim_server --session demo --scene wall.toml');
  assert.equal(words_of(frame, { ...status, sim_command: 'as it was' }, scene).help.command, 'as it was');
  const dead_hand = { ...frame, sim: 'alive', hand: 'dead' };
  assert.equal(words_of(dead_hand, status, scene).help.command, 'haptic_server --session demo');
  assert.equal(words_of(dead_hand, { ...status, hand_command: '' }, scene).help.command,
    'haptic_server --session demo --hand left --device PLUGIN');
  assert.equal(words_of(frame, { ...status, live: false }, scene).help, null, 'what was kept is not started again');
  assert.equal(words_of({ ...frame, sim: 'alive' }, status, scene).line, '');
});

test('a saved view plays from where it was opened', () => {
  const saved = new Playback(false);
  saved.number = 1;
  saved.set_range(1, 100);
  assert.equal(saved.next(5000), 1);
  assert.equal(saved.next(6000), 31);
});
