// A plot against time on a canvas: axes, lines thinned to the pixels, marks, rows of strips.
import { kDashes } from './theme.js';

const kRight = 10, kTop = 22, kBottom = 4;
const kSample = 14;  // pixels of a line beside its name
const kFont = '11px system-ui, "DejaVu Sans", sans-serif';
const kSmallFont = '10px system-ui, "DejaVu Sans", sans-serif';

/// The smallest of 1, 2, 5, 10, ... that is not below value.
export function round_up(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((step) => step * decade).find((step) => step >= value * (1 - 1e-9));
}

export class PlotCanvas {
  /// canvas: laid out by CSS. left: room for labels, in pixels. colours: of a theme's plots; may be set anew.
  constructor(canvas, left = 48, colours = {}) {
    this.colours = colours;
    this.canvas = canvas;
    this.left = left;
    this.context = canvas.getContext('2d');
  }

  /// Clears; from here on times and values lie in these limits.
  begin(from_s, to_s, low, high) {
    const { canvas, context } = this;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    Object.assign(this, { from_s, to_s, low, high, right: width - kRight, foot: height - kBottom });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = kFont;
    context.lineWidth = 1;
    context.lineJoin = 'round';
  }

  x(time_s) { return this.left + (time_s - this.from_s) / (this.to_s - this.from_s) * (this.right - this.left); }
  y(value) { return this.foot - (value - this.low) / (this.high - this.low) * (this.foot - kTop); }
  time_at(x) { return this.from_s + (x - this.left) / (this.right - this.left) * (this.to_s - this.from_s); }

  /// Where in the window a pixel stands, 0 to 1, and how many pixels the window has.
  share_at(x) { return Math.min(Math.max((x - this.left) / this.width, 0), 1); }
  get width() { return Math.max(this.right - this.left, 1); }

  /// Lines of the grid at tenths of the window, and at `values` with their labels.
  grid(values, label = (value) => `${value}`) {
    const { context } = this;
    context.strokeStyle = this.colours.grid;
    context.beginPath();
    const step_s = (this.to_s - this.from_s) / 10;
    for (let i = Math.ceil(this.from_s / step_s); i * step_s <= this.to_s; ++i) {
      context.moveTo(this.x(i * step_s), kTop);
      context.lineTo(this.x(i * step_s), this.foot);
    }
    for (const value of values) {
      context.moveTo(this.left, this.y(value));
      context.lineTo(this.right, this.y(value));
    }
    context.stroke();
    context.fillStyle = this.colours.muted;
    context.textAlign = 'right';
    context.textBaseline = 'middle';
    for (const value of values) context.fillText(label(value), this.left - 6, this.y(value));
  }

  /// The points i from begin to end, at times[i] and value(i), in the colour and the dashes of that name: of a
  /// pixel's column the least and most.
  /// Between points more than gap_s apart nothing was seen, and no line is drawn.
  line(times, begin, end, value, name, width = 1, gap_s = 0.05) {
    const { context } = this;
    context.strokeStyle = this.colours[name];
    context.lineWidth = width;
    context.setLineDash(kDashes[name] ?? []);
    context.beginPath();
    let column = NaN, least = 0, most = 0, last_s = -Infinity;
    const flush = () => {
      if (Number.isNaN(column)) return;
      context.lineTo(column, this.y(least));
      if (most !== least) context.lineTo(column, this.y(most));
    };
    for (let i = begin; i < end; ++i) {
      const here = Math.round(this.x(times[i]) * 2) / 2;
      const now = Math.min(Math.max(value(i), this.low), this.high);
      const broken = times[i] - last_s > gap_s;
      if (here !== column || broken) {
        flush();
        if (broken) context.moveTo(here, this.y(now));
        column = here;
        least = most = now;
      }
      least = Math.min(least, now);
      most = Math.max(most, now);
      last_s = times[i];
    }
    flush();
    context.stroke();
    context.setLineDash([]);
  }

  /// Short marks at the foot.
  marks(times_s, name) {
    this.context.fillStyle = this.colours[name];
    for (const time_s of times_s) this.context.fillRect(this.x(time_s) - 1, this.foot - 4, 2, 5);
  }

  /// Bars from time to time in row `row` of `rows`, with the row's name.
  strip(row, rows, name, spans, colour_name) {
    const { context } = this;
    const height = (this.foot - kTop) / rows;
    const top = kTop + row * height;
    context.font = kSmallFont;
    context.textAlign = 'left';
    context.textBaseline = 'middle';
    context.fillStyle = this.colours.strip;
    context.fillRect(this.left, top + 1, this.right - this.left, height - 2);
    context.fillStyle = spans.length ? this.colours.text : this.colours.muted;
    context.fillText(name, 4, top + height / 2 + 0.5);
    context.fillStyle = this.colours[colour_name];
    for (const [from_s, to_s] of spans) {
      const left = Math.max(this.x(from_s), this.left);
      context.fillRect(left, top + 1, Math.max(this.x(to_s) - left, 1), height - 2);
    }
  }

  /// The line at the top: what is plotted, without what stands in brackets where that is too long; entries: [words,
  /// name] of each line, a piece of which stands before.
  title(text, entries) {
    const { context } = this;
    context.font = kFont;
    context.textBaseline = 'middle';
    context.fillStyle = this.colours.text;
    context.textAlign = 'right';
    let x = this.right;
    for (const [words, name] of [...entries].reverse()) {
      context.fillText(words, x, 8);
      x -= context.measureText(words).width + 4;
      this.#sample(x - kSample, x, name);
      x -= kSample + 8;
    }
    context.textAlign = 'left';
    const fits = entries.length === 0 || context.measureText(text).width + 4 < x;
    context.fillText(fits ? text : text.replace(/ \(.*/, ''), 4, 8);
  }

  /// A piece of a line.
  #sample(from, to, name) {
    const { context } = this;
    context.strokeStyle = this.colours[name];
    context.lineWidth = 2;
    context.setLineDash(kDashes[name] ?? []);
    context.beginPath();
    context.moveTo(from, 8);
    context.lineTo(to, 8);
    context.stroke();
    context.setLineDash([]);
  }

  cursor(time_s) {
    if (time_s === null || time_s < this.from_s || time_s > this.to_s) return;
    this.context.fillStyle = this.colours.cursor;
    this.context.fillRect(this.x(time_s), kTop, 1, this.foot - kTop);
  }
}
