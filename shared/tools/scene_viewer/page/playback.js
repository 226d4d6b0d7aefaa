// Which frame is to be shown: the newest, one that stands, or one after the other.

export class Playback {
  mode = 'live';  // live, paused, playing
  number = 0;     // of the frame that is shown or asked for
  first = 0;
  last = 0;
  frames_per_s = 30;
  speed = 1;
  #asked = null;   // of the last frame that next() gave
  #position = 0;   // of play, in frames
  #played_ms = null;

  /// is_live: frames go on to come; what was kept plays at once.
  constructor(is_live = true) {
    this.is_live = is_live;
    if (!is_live) this.mode = 'playing';
  }

  /// The frames that there are now.
  set_range(first, last) {
    this.first = first;
    this.last = last;
    if (this.mode !== 'live' && this.#asked === null) this.number = this.#within(this.number);
  }

  shown(number) {
    if (this.mode === 'live') this.number = number;
  }

  pause() {
    this.mode = 'paused';
    this.#asked = this.number;
  }

  toggle(now_ms) {
    if (this.mode !== 'paused') return this.pause();
    if (this.number >= this.last) {
      if (this.is_live) return this.live();
      this.seek(this.first);
    }
    this.mode = 'playing';
    this.#position = this.number;
    this.#played_ms = now_ms;
  }

  live() {
    if (!this.is_live) return this.seek(this.last);
    this.mode = 'live';
    this.#asked = null;
  }

  seek(number) {
    this.mode = 'paused';
    this.number = this.#within(number);
    this.#asked = null;
  }

  step(frames) {
    this.seek(this.number + frames);
  }

  /// 'latest', the number of a frame, or null where what is shown stands.
  next(now_ms) {
    if (this.mode === 'playing') this.#play_on(now_ms);
    if (this.mode === 'live') return 'latest';
    if (this.#asked === this.number) return null;
    this.#asked = this.number;
    return this.number;
  }

  /// What next() gave did not come: it is to be asked for again.
  not_come() {
    this.#asked = null;
  }

  #play_on(now_ms) {
    if (this.#played_ms === null) {  // from where it was opened
      this.#position = this.number;
      this.#played_ms = now_ms;
    }
    this.#position += (now_ms - this.#played_ms) / 1000 * this.frames_per_s * this.speed;
    this.#played_ms = now_ms;
    this.number = this.#within(Math.floor(this.#position));
    if (this.number < this.last) return;
    if (this.is_live && this.speed >= 1) this.live();
    else if (!this.is_live) this.mode = 'paused';
  }

  #within(number) {
    return Math.min(Math.max(number, this.first), this.last);
  }
}
