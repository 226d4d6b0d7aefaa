// What is plotted of the ticks: force, age of the snapshot, work and wake, safety flags.
import { PlotCanvas, round_up } from './plot_canvas.js';

export const kWindow_s = 10;
const kAgeWindow_s = 1;  // in which single snapshots can be told apart
const kBin_s = 0.25;  // of which percentiles are taken

export const kColours = {
  norm: '#f2c14e', x: '#e8695a', y: '#7bc96f', z: '#5aa9e6', age: '#c792ea', mark: '#e3e9ef',
  work: '#4fc1b0', wake: '#e79a4b', flag: '#e5644a',
};

const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '–');

/// Percentiles 50 and 99 of a column in bins: rows of { time_s, p50, p99 }.
export function binned_percentiles(times, values, begin, end) {
  const rows = [];
  for (let i = begin; i < end;) {
    const bin = Math.floor(times[i] / kBin_s);
    const here = [];
    const first = i;
    for (; i < end && Math.floor(times[i] / kBin_s) === bin; ++i) here.push(values[i]);
    here.sort((a, b) => a - b);
    const at = (share) => here[Math.min(here.length - 1, Math.floor(share * here.length))];
    rows.push({ time_s: times[(first + i) >> 1], p50: at(0.5), p99: at(0.99) });
  }
  return rows;
}

/// From when to when each flag stood: spans[flag] = [[from_s, to_s], ...].
export function flag_spans(times, flags, begin, end, flag_count) {
  const spans = Array.from({ length: flag_count }, () => []);
  for (let i = begin; i < end; ++i) {
    for (let rest = flags[i]; rest !== 0; rest &= rest - 1) {
      const flag = 31 - Math.clz32(rest & -rest);
      if (flag >= flag_count) continue;
      const last = spans[flag].at(-1);
      if (last && times[i] - last[1] < 0.02) last[1] = times[i];
      else spans[flag].push([times[i], times[i]]);
    }
  }
  return spans;
}

const kPlots = [
  ['force', 'Force on the hand, its norm and its components, in newtons'],
  ['age', 'Age of the snapshot in milliseconds, with marks where a snapshot came'],
  ['time', 'Work of a tick and lateness of its wake in microseconds, median and 99th percentile'],
  ['flags', 'Safety flags, a strip each'],
];

export class Plots {
  /// parent: an element for the canvases. ticks: a TickHistory.
  constructor(parent, ticks, on_hover) {
    this.ticks = ticks;
    this.flag_names = [];
    this.hover_s = null;  // the time that is pointed at
    this.tops = {};
    for (const [name, label] of kPlots) {
      const canvas = document.createElement('canvas');
      canvas.id = `plot-${name}`;
      canvas.setAttribute('role', 'img');
      canvas.setAttribute('aria-label', label);
      parent.append(canvas);
      this[name] = new PlotCanvas(canvas, name === 'flags' ? 72 : 48);
      canvas.addEventListener('pointermove', (event) => {
        this.hover_s = this[name].time_at(event.offsetX);
        on_hover();
      });
      canvas.addEventListener('pointerleave', () => {
        this.hover_s = null;
        on_hover();
      });
    }
  }

  /// The window that ends at end_s.
  draw(end_s) {
    const begin = this.ticks.lower_bound(end_s - kWindow_s);
    const end = this.ticks.lower_bound(end_s + 1e-9);
    const window_ = { from_s: end_s - kWindow_s, to_s: end_s, begin, end };
    const pointed = this.hover_s === null ? end - 1
      : Math.min(this.ticks.lower_bound(this.hover_s), end - 1);
    this.#draw_force(window_, pointed);
    const late = this.ticks.lower_bound(end_s - kAgeWindow_s);
    this.#draw_age({ from_s: end_s - kAgeWindow_s, to_s: end_s, begin: late, end }, pointed);
    this.#draw_times(window_);
    this.#draw_flags(window_);
  }

  /// The top of an axis: grows at once, shrinks when a third would do, so that it does not flicker.
  #top(name, most, least_top) {
    const wanted = round_up(Math.max(most, least_top));
    const top = this.tops[name] ?? wanted;
    this.tops[name] = wanted > top || wanted < top / 3 ? wanted : top;
    return this.tops[name];
  }

  #draw_force({ from_s, to_s, begin, end }, pointed) {
    const { time_s, force_N } = this.ticks.columns;
    const norm = (i) => Math.hypot(force_N[3 * i], force_N[3 * i + 1], force_N[3 * i + 2]);
    let most = 0;
    for (let i = begin; i < end; ++i) most = Math.max(most, norm(i));
    const top = this.#top('force', most, 1);
    this.force.begin(from_s, to_s, -top, top);
    this.force.grid([-top, -top / 2, 0, top / 2, top]);
    for (const axis of [0, 1, 2]) {
      this.force.line(time_s, begin, end, (i) => force_N[3 * i + axis], kColours['xyz'[axis]]);
    }
    this.force.line(time_s, begin, end, norm, kColours.norm, 1.5);
    const told = (value) => fixed(pointed >= begin ? value : NaN, 2);
    this.force.title('force, N (10 s)', [
      [`|F| ${told(norm(pointed))}`, kColours.norm],
      ...[0, 1, 2].map((axis) =>
        [`${'xyz'[axis]} ${told(force_N[3 * pointed + axis])}`, kColours['xyz'[axis]]])]);
    this.force.cursor(this.hover_s);
  }

  #draw_age({ from_s, to_s, begin, end }, pointed) {
    const { time_s, age_s, snapshot_id } = this.ticks.columns;
    let most = 0;
    const marks = [];
    for (let i = begin; i < end; ++i) {
      most = Math.max(most, age_s[i]);
      if (i > begin && snapshot_id[i] !== snapshot_id[i - 1]) marks.push(time_s[i]);
    }
    const top = this.#top('age', 1000 * most, 20);
    this.age.begin(from_s, to_s, 0, top);
    this.age.grid([0, top / 2, top]);
    this.age.line(time_s, begin, end, (i) => 1000 * age_s[i], kColours.age);
    this.age.marks(marks, kColours.mark);
    this.age.title('age of the snapshot, ms (1 s)', [
      ['publications', kColours.mark],
      [fixed(pointed >= begin ? 1000 * age_s[pointed] : NaN, 1), kColours.age]]);
    this.age.cursor(this.hover_s);
  }

  #draw_times({ from_s, to_s, begin, end }) {
    const { time_s, tick_us, wake_us } = this.ticks.columns;
    const series = [['work', tick_us], ['wake', wake_us]].map(([name, values]) =>
      [name, binned_percentiles(time_s, values, begin, end)]);
    const most = Math.max(0, ...series.flatMap(([, rows]) => rows.map((row) => row.p99)));
    // Decades: a median of some microseconds, and what one tick in a hundred waits for.
    const top = Math.max(3, Math.ceil(Math.log10(Math.max(most, 1))));
    this.time.begin(from_s, to_s, 0, top);
    const decades = Array.from({ length: top + 1 }, (_, decade) => decade);
    this.time.grid(decades, (decade) => (decade >= 3 ? `${10 ** (decade - 3)} ms` : `${10 ** decade} µs`));
    for (const [name, rows] of series) {
      const times = rows.map((row) => row.time_s);
      const log = (value) => Math.log10(Math.max(value, 1e-3));
      for (const [share, width] of [['p50', 2], ['p99', 1]]) {
        this.time.line(times, 0, rows.length, (i) => log(rows[i][share]), kColours[name], width, 2 * kBin_s);
      }
    }
    this.time.title('tick, p50 and p99 (10 s)', [['work', kColours.work], ['wake-up latency', kColours.wake]]);
    this.time.cursor(this.hover_s);
  }

  #draw_flags({ from_s, to_s, begin, end }) {
    const { time_s, flags } = this.ticks.columns;
    const names = this.flag_names;
    const spans = flag_spans(time_s, flags, begin, end, names.length);
    this.flags.begin(from_s, to_s, 0, 1);
    names.forEach((name, row) => this.flags.strip(row, names.length, name, spans[row], kColours.flag));
    this.flags.title('safety flags (10 s)', []);
    this.flags.cursor(this.hover_s);
  }
}
