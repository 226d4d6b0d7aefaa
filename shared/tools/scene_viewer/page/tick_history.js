// The ticks of the last minute, a column a quantity, in the order of time.

const kCapacity = 1 << 17;
const kKept = 1 << 16;

/// Columns, and how many numbers a tick has in each.
const kColumns = {
  tick: 1, time_s: 1, position_m: 3, force_N: 3, age_s: 1, tick_us: 1, wake_us: 1, flags: 1,
  snapshot_id: 1,
};

export class TickHistory {
  count = 0;
  columns = {};
  #asked_from = 0;  // the first tick that was asked for of what is held

  constructor() {
    for (const [name, width] of Object.entries(kColumns)) {
      this.columns[name] = new Float64Array(kCapacity * width);
    }
  }

  get last_tick() { return this.count ? this.columns.tick[this.count - 1] : NaN; }

  clear() { this.count = 0; }

  /// arrays: as /api/ticks gives them, at most kKept ticks.
  append(arrays) {
    const added = arrays.tick.length;
    if (this.count + added > kCapacity) this.#drop(this.count - kKept);
    for (const [name, width] of Object.entries(kColumns)) {
      this.columns[name].set(arrays[name], this.count * width);
    }
    this.count += added;
  }

  /// Index of the first tick at or after this time.
  lower_bound(time_s) {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.columns.time_s[middle] < time_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /// What is to be asked for so that the `wanted` ticks up to `tick` are here: { from, most }, or null.
  /// What is held is let go where it does not join.
  missing(tick, wanted) {
    const begin = Math.max(1, tick - wanted + 1);
    if (!this.count || begin < this.#asked_from || begin > this.last_tick + 1) {
      this.clear();
      this.#asked_from = begin;
      return { from: begin, most: wanted };
    }
    return tick > this.last_tick ? { from: this.last_tick + 1, most: wanted } : null;
  }

  #drop(ticks) {
    for (const [name, width] of Object.entries(kColumns)) {
      this.columns[name].copyWithin(0, ticks * width, this.count * width);
    }
    this.count -= ticks;
    this.#asked_from = this.columns.tick[0];
  }
}
