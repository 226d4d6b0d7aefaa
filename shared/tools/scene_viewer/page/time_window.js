// The stretch of time that the plots show: each its own until the user zooms, then one for all.

export const kShortest_s = 0.005;
export const kLongest_s = 60;  // as long as the viewer holds ticks

export class TimeWindow {
  length_s = null;  // null: each plot's own
  lag_s = 0;        // between the end of the window and the frame that is shown

  /// own_s: of a plot that is not zoomed. { from_s, to_s }.
  range(end_s, own_s) {
    const to_s = end_s - this.lag_s;
    return { from_s: to_s - (this.length_s ?? own_s), to_s };
  }

  /// By a factor, below 1 into it; what stands at that share of the window stays there.
  zoom(factor, share, own_s) {
    const before_s = this.length_s ?? own_s;
    const length_s = Math.min(Math.max(before_s * factor, kShortest_s), kLongest_s);
    this.lag_s += (before_s - length_s) * (1 - share);
    this.length_s = length_s;
    this.#keep_within();
  }

  /// By a share of the window, to later times where positive.
  pan(share, own_s) {
    this.length_s ??= own_s;
    this.lag_s -= share * this.length_s;
    this.#keep_within();
  }

  reset() {
    this.length_s = null;
    this.lag_s = 0;
  }

  /// How many seconds before the frame are shown.
  reach_s(own_s) { return this.lag_s + (this.length_s ?? own_s); }

  #keep_within() {
    this.lag_s = Math.min(Math.max(this.lag_s, 0), kLongest_s - this.length_s);
  }
}
