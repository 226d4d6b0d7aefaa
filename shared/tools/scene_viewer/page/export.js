// The picture as a PNG file, and as a film while it is shown.
import { byId, say } from './dom.js';

const kFilms = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];
const kFilmFrames_per_s = 30;
const kFilmBits_per_s = 8e6;

/// A name that every file system takes.
export const file_name = (scene, time_s, ending) =>
  `${scene.replace(/[^\w.-]+/g, '_') || 'scene'}_${time_s.toFixed(2)}s.${ending}`;

function keep(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  say(`${name}: ${(blob.size / 1e6).toFixed(1)} MB, kept where this browser keeps downloads`);
}

/// The canvas, and below it on the left what is seen.
function with_caption(canvas, caption, { label, label_ground }) {
  const copy = document.createElement('canvas');
  copy.width = canvas.width;
  copy.height = canvas.height;
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  const size = Math.max(11, Math.round(canvas.height / 48));
  context.font = `${size}px system-ui, "DejaVu Sans", sans-serif`;
  context.lineJoin = 'round';
  context.lineWidth = size / 4;
  context.strokeStyle = label_ground;
  context.fillStyle = label;
  context.strokeText(caption, size, canvas.height - size);
  context.fillText(caption, size, canvas.height - size);
  return copy;
}

export class Exporter {
  #recorder = null;

  /// canvas: of the picture. render(): draws it anew. told(): { scene, time_s, caption, colours } of what is shown.
  constructor(canvas, render, told) {
    Object.assign(this, { canvas, render, told });
    this.film_type = typeof MediaRecorder !== 'undefined' && canvas.captureStream
      ? kFilms.find((type) => MediaRecorder.isTypeSupported(type)) : undefined;
    byId('picture').addEventListener('click', () => this.picture());
    byId('film').addEventListener('click', () => this.film());
    if (!this.film_type) {
      byId('film').disabled = true;
      byId('film').title = 'This browser records no film of a canvas (no MediaRecorder for WebM or MP4)';
    }
  }

  picture() {
    this.render();  // and copied before the browser clears what it drew
    const { scene, time_s, caption, colours } = this.told();
    with_caption(this.canvas, caption, colours).toBlob((blob) => keep(blob, file_name(scene, time_s, 'png')), 'image/png');
  }

  /// Begins to record what is shown, or ends it.
  film() {
    if (this.#recorder) return this.#recorder.stop();
    const { scene, time_s } = this.told();
    const stream = this.canvas.captureStream(kFilmFrames_per_s);
    const parts = [];
    const recorder = new MediaRecorder(stream, { mimeType: this.film_type, videoBitsPerSecond: kFilmBits_per_s });
    recorder.addEventListener('dataavailable', ({ data }) => { if (data.size) parts.push(data); });
    recorder.addEventListener('error', () => say('the film ended: this browser could not go on recording'));
    recorder.addEventListener('stop', () => {
      for (const track of stream.getTracks()) track.stop();
      this.#recorder = null;
      this.#show();
      const [type] = this.film_type.split(';');
      keep(new Blob(parts, { type }), file_name(scene, time_s, type.split('/')[1]));
    });
    recorder.start(1000);
    this.#recorder = recorder;
    this.#show();
    this.render();
  }

  #show() {
    const records = this.#recorder !== null;
    byId('film').classList.toggle('on', records);
    byId('film').setAttribute('aria-pressed', `${records}`);
    byId('film').title = records ? 'End the film and keep it (C)' : 'Film of the picture, from now on (C)';
  }
}
