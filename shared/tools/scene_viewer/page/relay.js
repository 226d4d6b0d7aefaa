// What a relay tells that writes a server's segment from its network, in segment_inspect's words.

const grouped = (count) => count.toLocaleString('en');

function duration(ns, sign = '') {
  const mark = ns < 0 ? '−' : sign;
  const ms = Math.abs(ns) * 1e-6;
  if (ms >= 999.5) return `${mark}${(1e-3 * ms).toFixed(1)} s`;
  return `${mark}${ms >= 0.9995 ? +ms.toPrecision(3) : ms.toFixed(3)} ms`;
}

/// relay: of a frame, or null. '' of none.
export function relay_figures(relay) {
  if (!relay) return '';
  const figures = [relay.connected ? 'connected' : 'silent: the other side is not heard'];
  if (relay.round_trip_ns !== null) {
    figures.push(`round trip ${duration(relay.round_trip_ns)}`,
      `clock ${duration(relay.clock_offset_ns, '+')} ± ${duration(relay.clock_bound_ns)}`);
  }
  figures.push(`${grouped(relay.received)} received`, `${grouped(relay.lost)} lost`);
  for (const [count, name] of [[relay.repeated, 'repeated'], [relay.out_of_order, 'out of order'], [relay.late, 'late'],
    [relay.refused, 'refused'], [relay.partitions, 'partitions']]) {
    if (count > 0) figures.push(`${grouped(count)} ${name}`);
  }
  if (relay.longest_silence_ns > 0) figures.push(`longest silence ${duration(relay.longest_silence_ns)}`);
  return figures.join(', ');
}
