#!/usr/bin/python3
"""Measures what a session over a network feels like beside the same hand on one machine: docs/charts/relay_felt.csv.

Ticks of scenes that ship, on their own hand, on one machine and over a link of 20 ms each way that loses 1 %, at the
rate that suits that delay and at a fast one. In real time.
"""
import time

import numpy

from measuring import parser_of
from recording import load
from relay_bed import SCENES, Bed
from tables import write_rows

# Scenes whose bodies the hand moves, by how long they come to rest before, s.
SETTLE_S = {"organ": 1.0, "tissue_and_blocks": 4.0}
FELT = (("organ", 50.0), ("organ", 250.0), ("tissue_and_blocks", 50.0), ("tissue_and_blocks", 250.0))
DELAY_MS, LOSS = 20.0, 0.01
EVERY_MS = 2


def session(build, scene, rate_hz, link, seed, seconds=30.0):
    """The recording of the scene's own hand. Link: delay in ms and loss; None: one machine."""
    settings = () if link is None else (f"delay_ms {link[0]}", f"loss {link[1]}")
    with Bed(build, *settings, seed=seed) as bed:
        sim = bed.sim_server(scene, "--rate", rate_hz)
        bed.wait_for("a", "scene")
        began_s = time.monotonic()
        side = "a"
        if link is not None:
            relays, side = bed.relays(), "b"
            bed.wait_for("b", "scene")
        time.sleep(max(0.0, SETTLE_S[scene] + 0.7 - (time.monotonic() - began_s)))
        haptic = bed.haptic_server(side, f"replay:file={SCENES / f'{scene}.hand.csv'}")
        haptic.wait(seconds)
        if link is not None:
            bed.end(*relays)
        bed.end(sim)
        bed.report("haptic")
        return load(bed.folder / "haptic.csv")


def felt_rows(build, felt):
    rows = []
    for scene, rate_hz in felt:
        sessions = {"one machine": session(build, scene, rate_hz, None, 1),
                    "relay": session(build, scene, rate_hz, (DELAY_MS, LOSS), 1)}
        for where, recording in sessions.items():
            force_N = numpy.linalg.norm(recording.force_N, axis=1)
            for tick in range(0, len(recording), EVERY_MS):
                rows.append({"scene": scene, "rate_hz": f"{rate_hz:g}", "where": where,
                             "time_s": f"{recording.time_s[tick]:.4f}",
                             **{f"{axis}_mm": f"{1e3 * recording.position_m[tick, n]:.3f}"
                                for n, axis in enumerate("xyz")},
                             "force_N": f"{force_N[tick]:.4f}", "age_ms": f"{1e3 * recording['age_s'][tick]:.2f}",
                             "faded": int(any("faded" in f for f in recording["flags"][tick:tick + EVERY_MS]))})
    return rows


def main():
    arguments = parser_of(__doc__, "the organ at 50 Hz").parse_args()
    felt = FELT[:1] if arguments.small else FELT
    rows = felt_rows(arguments.build, felt)
    write_rows(arguments.charts / "relay_felt.csv", rows)
    for scene, rate_hz in felt:
        here, over = (numpy.array([float(row["force_N"]) for row in rows if row["where"] == where
                                   and (row["scene"], row["rate_hz"]) == (scene, f"{rate_hz:g}")])
                      for where in ("one machine", "relay"))
        count = min(len(here), len(over))
        apart = numpy.abs(here[:count] - over[:count])
        print(f"{scene}, {rate_hz:g} Hz: apart by {numpy.sqrt(numpy.mean(apart**2)):.3f} N rms, {apart.max():.3f} N at "
              f"most, of {here.max():.2f} N")


if __name__ == "__main__":
    main()
