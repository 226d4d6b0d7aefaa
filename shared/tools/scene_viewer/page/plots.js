// What is plotted of the ticks: force, age of the snapshot, work and wake, safety flags.
import { PlotCanvas, round_up } from './plot_canvas.js';
import { watch_gestures } from './plot_gestures.js';
import { TimeWindow } from './time_window.js';

export const kWindow_s = 10;
const kAgeWindow_s = 1;  // in which single snapshots can be told apart
const kBin_s = 0.25;  // of which percentiles are taken
const kLeastStrips = 6;  // of flags: the room of each
const kBins = 40;     // at least, where the user has zoomed

const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '–');

/// Percentiles 50 and 99 of a column in bins: rows of { time_s, p50, p99 }.
export function binned_percentiles(times, values, begin, end, bin_s = kBin_s) {
  const rows = [];
  for (let i = begin; i < end;) {
    const bin = Math.floor(times[i] / bin_s);
    const here = [];
    const first = i;
    for (; i < end && Math.floor(times[i] / bin_s) === bin; ++i) here.push(values[i]);
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
  window = new TimeWindow();

  /// parent: an element for the canvases. ticks: a TickHistory. theme: a Theme. on_change: what is pointed at or
  /// which time is shown has changed.
  constructor(parent, ticks, theme, on_change) {
    this.ticks = ticks;
    this.theme = theme;
    this.flag_names = [];
    this.flags_seen = new Set();
    this.hover_s = null;  // the time that is pointed at
    this.tops = {};
    this.labels = {};  // what each shows, in words
    for (const [name, label] of kPlots) {
      const canvas = document.createElement('canvas');
      canvas.id = `plot-${name}`;
      canvas.setAttribute('role', 'img');
      this.labels[name] = label;
      parent.append(canvas);
      this[name] = new PlotCanvas(canvas, name === 'flags' ? 90 : 48);
      const own_s = name === 'age' ? kAgeWindow_s : kWindow_s;
      watch_gestures(canvas, {
        point: (x) => { this.hover_s = x === null ? null : this[name].time_at(x); },
        zoom: (factor, x) => this.window.zoom(factor, this[name].share_at(x), own_s),
        pan: (pixels) => this.window.pan(-pixels / this[name].width, own_s),
        reset: () => this.window.reset(),
      }, on_change);
    }
  }

  /// The length of a window that is not zoomed, but for the age's.
  get own_s() { return kWindow_s; }

  /// How many seconds before the frame that is shown have to be known.
  get reach_s() { return this.window.reach_s(kWindow_s); }

  /// The frame at end_s is shown: windows end there, or so much before as the user wants.
  draw(end_s) {
    const { plot } = this.theme.colours;
    for (const [name] of kPlots) this[name].colours = plot;
    const newest = this.ticks.lower_bound(end_s + 1e-9);
    const of = (own_s) => {
      const { from_s, to_s } = this.window.range(end_s, own_s);
      const end = Math.min(this.ticks.lower_bound(to_s + 1e-9), newest);
      const begin = this.ticks.lower_bound(from_s);
      return { from_s, to_s, end_s, end, begin: Math.min(begin, end),
        pointed: this.hover_s === null ? end - 1 : Math.min(this.ticks.lower_bound(this.hover_s), end - 1) };
    };
    this.#draw_force(of(kWindow_s));
    this.#draw_age(of(kAgeWindow_s));
    this.#draw_times(of(kWindow_s));
    this.#draw_flags(of(kWindow_s));
  }

  /// "10 s", or "0.5 s, to −2.1 s" of a window that ends before the frame; the plot of that name is labelled so.
  #length(name, { from_s, to_s, end_s }) {
    const lag_s = end_s - to_s;
    const text = `${+(to_s - from_s).toPrecision(2)} s${lag_s > 1e-6 ? `, to −${+lag_s.toPrecision(3)} s` : ''}`;
    const label = `${this.labels[name]}: ${text}`;
    if (this[name].canvas.ariaLabel !== label) this[name].canvas.ariaLabel = label;
    return text;
  }

  /// The top of an axis: grows at once, shrinks when a third would do, so that it does not flicker.
  #top(name, most, least_top) {
    const wanted = round_up(Math.max(most, least_top));
    const top = this.tops[name] ?? wanted;
    this.tops[name] = wanted > top || wanted < top / 3 ? wanted : top;
    return this.tops[name];
  }

  #draw_force(shown) {
    const { from_s, to_s, begin, end, pointed } = shown;
    const { time_s, force_N } = this.ticks.columns;
    const norm = (i) => Math.hypot(force_N[3 * i], force_N[3 * i + 1], force_N[3 * i + 2]);
    let most = 0;
    for (let i = begin; i < end; ++i) most = Math.max(most, norm(i));
    const top = this.#top('force', most, 1);
    this.force.begin(from_s, to_s, -top, top);
    this.force.grid([-top, -top / 2, 0, top / 2, top]);
    for (const axis of [0, 1, 2]) {
      this.force.line(time_s, begin, end, (i) => force_N[3 * i + axis], 'xyz'[axis]);
    }
    this.force.line(time_s, begin, end, norm, 'norm', 2);
    const told = (value) => fixed(pointed >= begin ? value : NaN, 2);
    this.force.title(`force, N (${this.#length('force', shown)})`, [
      [`|F| ${told(norm(pointed))}`, 'norm'],
      ...[0, 1, 2].map((axis) => [`${'xyz'[axis]} ${told(force_N[3 * pointed + axis])}`, 'xyz'[axis]])]);
    this.force.cursor(this.hover_s);
  }

  #draw_age(shown) {
    const { from_s, to_s, begin, end, pointed } = shown;
    const { time_s, age_s, snapshot_id } = this.ticks.columns;
    let most = 0;
    const marks = [];
    for (let i = begin; i < end; ++i) {
      most = Math.max(most, age_s[i]);
      if (i > begin && snapshot_id[i] !== snapshot_id[i - 1]) marks.push(time_s[i]);
    }
    const top = this.#top('age', 1000 * most, 0.5);
    this.age.begin(from_s, to_s, 0, top);
    this.age.grid([0, top / 2, top]);
    this.age.line(time_s, begin, end, (i) => 1000 * age_s[i], 'age');
    this.age.marks(marks, 'mark');
    this.age.title(`snapshot's age, ms (${this.#length('age', shown)})`, [
      ['publications', 'mark'], [fixed(pointed >= begin ? 1000 * age_s[pointed] : NaN, 1), 'age']]);
    this.age.cursor(this.hover_s);
  }

  #draw_times(shown) {
    const { from_s, to_s, begin, end } = shown;
    const { time_s, tick_us, wake_us } = this.ticks.columns;
    const bin_s = Math.min(kBin_s, (to_s - from_s) / kBins);
    const series = [['work', tick_us], ['wake', wake_us]].map(([name, values]) =>
      [name, binned_percentiles(time_s, values, begin, end, bin_s)]);
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
        this.time.line(times, 0, rows.length, (i) => log(rows[i][share]), name, width,
          Math.max(2 * bin_s, 0.05));
      }
    }
    this.time.title(`tick, p50 and p99 (${this.#length('time', shown)})`, [['work', 'work'], ['wake-up latency', 'wake']]);
    this.time.cursor(this.hover_s);
  }

  #draw_flags(shown) {
    const { from_s, to_s, begin, end } = shown;
    const { time_s, flags } = this.ticks.columns;
    const names = this.flag_names;
    const spans = flag_spans(time_s, flags, begin, end, names.length);
    this.flags.begin(from_s, to_s, 0, 1);
    // Those that stood once keep their place: a strip that comes and goes is not followed by the eye.
    spans.forEach((list, flag) => { if (list.length) this.flags_seen.add(flag); });
    const seen = [...this.flags_seen].filter((flag) => flag < names.length).sort((a, b) => a - b);
    seen.forEach((flag, row) => this.flags.strip(row, Math.max(seen.length, kLeastStrips), names[flag], spans[flag], 'flag'));
    const stood = seen.length ? `${seen.length} of ${names.length} stood` : `none of ${names.length} stood`;
    this.flags.title(`safety flags (${this.#length('flags', shown)}): ${stood}`, []);
    this.flags.cursor(this.hover_s);
  }
}
