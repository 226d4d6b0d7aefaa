// The viewer's HTTP interface: docs/viewer.md. Times in seconds on the frames' axis, SI units.

/// The server has no such thing, which is an answer: its line.
export class Absent extends Error {}
/// Another viewer answers, whose key is another.
export class Stranger extends Error {}
/// There is no answer.
export class Unreachable extends Error {}
/// What was wanted is refused: its line.
export class Refused extends Error { is_refusal = true; }

const kArrayTypes = { f32: Float32Array, f64: Float64Array, u32: Uint32Array };
const kTimeout_ms = 3000;
let session = '';  // that is asked for; '': the viewer's own choice

const text_of = (bytes) => new TextDecoder().decode(bytes);
const json_of = (bytes) => JSON.parse(text_of(bytes));

/// The bytes of the answer.
async function get(path, more = {}) {
  let response, body;
  try {
    response = await fetch(path, { cache: 'no-store', signal: AbortSignal.timeout(kTimeout_ms), ...more });
    body = await response.arrayBuffer();
  } catch (error) {
    throw new Unreachable(`${path}: ${error.message}`);
  }
  if (response.status === 404) throw new Absent(text_of(body).trim());
  if (response.status === 403) throw new Stranger(`${path}: 403`);
  if (response.status === 409) throw new Refused(text_of(body).trim());
  if (!response.ok) throw new Error(`${path}: ${response.status}`);
  return body;
}

/// A JSON head with its arrays as typed arrays by name: { ...head, arrays: { newest, ... } }.
export function decode(buffer) {
  const head_bytes = new DataView(buffer).getUint32(0, true);
  const head = json_of(new Uint8Array(buffer, 4, head_bytes));
  const arrays = {};
  let offset = 4 + head_bytes;
  for (const { name, type, count } of head.arrays) {
    const bytes = count * kArrayTypes[type].BYTES_PER_ELEMENT;
    // A copy: doubles need not begin where they may be read in place.
    arrays[name] = new kArrayTypes[type](buffer.slice(offset, offset + bytes));
    offset += Math.ceil(bytes / 4) * 4;
  }
  return { ...head, arrays };
}

/// From now on all is asked of that session.
export function choose(name) { session = name; }
export const chosen = () => session;

const of = (name, query = '') => get(`api/${name}?session=${encodeURIComponent(session)}${query}`);

/// { named, running }: the session that the viewer was started for, and those that run.
export const sessions = async () => json_of(await get('api/sessions'));

/// key: scene_key of a frame.
export const scene = async (key) => json_of(await of('scene', `&key=${encodeURIComponent(key)}`));
export const status = async () => json_of(await of('status'));

/// number: of a frame, or 'latest'.
export const frame = async (number) =>
  decode(await of('frame', `&number=${number}`));

export const ticks = async (from, most) =>
  decode(await of('ticks', `&from=${from}&most=${most}`));

const mouse_path = () => `api/mouse?session=${encodeURIComponent(session)}`;

/// message: { holder, position_m, orientation_xyzw, buttons }, device frame. Throws Refused where another holds the hand.
export const mouse = (message) => get(mouse_path(), { method: 'POST', body: JSON.stringify(message) });

/// The same without an answer, also from a page that closes.
export const mouse_beacon = (message) => navigator.sendBeacon(mouse_path(), JSON.stringify(message));
