// A link to an instant: session, time and camera behind the '#' of the page's address.

const kCameraDigits = 5;

/// { session, time_s, camera_m }: the last six numbers, place and target. Behind a '#'.
export function format_link({ session, time_s, camera_m }) {
  const parts = [];
  if (session) parts.push(`session=${encodeURIComponent(session)}`);
  if (Number.isFinite(time_s)) parts.push(`t=${time_s.toFixed(3)}`);
  if (camera_m) parts.push(`camera=${camera_m.map((x) => +x.toPrecision(kCameraDigits)).join(',')}`);
  return `#${parts.join('&')}`;
}

/// What of it is there and sound; the rest is null.
export function parse_link(hash) {
  const values = new URLSearchParams(hash.replace(/^#/, ''));
  const numbers = (values.get('camera') ?? '').split(',').map((text) => (text.trim() ? Number(text) : NaN));
  const is_camera = numbers.length === 6 && numbers.every((x) => Number.isFinite(x) && Math.abs(x) < 1e6);
  const time = values.get('t');
  const time_s = time?.trim() ? Number(time) : NaN;
  return { session: values.get('session') || null, time_s: Number.isFinite(time_s) ? time_s : null,
    camera_m: is_camera ? numbers : null };
}

/// The number of the last frame at or before a time, of those from first to last. time_of(number): its time in
/// seconds, or null where it cannot be had, as of a damaged one. A millisecond late is not: links are rounded.
export async function frame_at(time_s, first, last, time_of) {
  let low = first, high = last;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    let known = middle, here_s = await time_of(known);
    while (here_s === null && known > low + 1) here_s = await time_of(--known);
    if (here_s === null || here_s > time_s + 1e-3) high = known - 1;
    else low = middle;
  }
  return Math.max(low, first);
}
