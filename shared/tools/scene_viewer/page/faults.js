// What is asked for again and again, how often it failed in a row, and when it is due.
import * as api from './api.js';

const kFirstBackOff_ms = 250;
const kLongestBackOff_ms = 4000;
const kAbsent_ms = 400;
const kNone = { count: 0, line: '', is_absent: false };

export class Faults {
  due_ms = {};
  was_away = false;  // the viewer did not answer in between
  #faults = {};

  /// names: of what is asked for; the first tells whether the viewer is there.
  constructor(names) {
    this.names = names;
    this.forget();
  }

  /// All are due, and none has failed.
  forget() {
    for (const name of this.names) {
      this.#faults[name] = { ...kNone };
      this.due_ms[name] = 0;
    }
  }

  of(name) { return this.#faults[name]; }

  /// What there is to say, of the first that has something.
  get line() { return this.names.map((name) => this.of(name).line).find((line) => line !== '') ?? ''; }

  /// Whether it succeeded. A fault of one does not end with the success of another.
  async attempt(name, take) {
    try {
      await take();
      Object.assign(this.of(name), kNone);
      return true;
    } catch (error) {
      this.#note(name, error);
      return false;
    }
  }

  #note(name, error) {
    const fault = this.of(name);
    ++fault.count;
    fault.is_absent = error instanceof api.Absent;
    if (fault.is_absent) {  // a frame that is no more, or is damaged: asked for again now and then
      fault.line = error.message;
      this.due_ms[name] = performance.now() + kAbsent_ms;
      return;
    }
    this.due_ms[name] = performance.now() + Math.min(kFirstBackOff_ms * 2 ** (fault.count - 1), kLongestBackOff_ms);
    if (error instanceof api.Stranger) {
      fault.line = 'viewer was started anew: open the address that it printed';
      return;
    }
    const [first] = this.names;
    if (error instanceof api.Unreachable) {
      this.was_away = true;
      this.due_ms[first] = Math.min(this.due_ms[first], this.due_ms[name]);
    }
    if (fault.count < 2 || name === 'sessions') return;
    fault.line = name === first ? 'viewer is gone: start scene_viewer again'
      : `the ${name} cannot be shown: ${error.message}`;
  }
}
