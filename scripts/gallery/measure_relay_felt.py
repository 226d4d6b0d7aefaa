#!/usr/bin/python3
"""Measures what a session over a network feels like beside the same hand on one machine: docs/charts/relay_felt.csv,
relay_rates.csv.

relay_felt: ticks of scenes that ship, on their own hand, on one machine and over a link of 20 ms each way that loses
1 %. relay_rates: by how much the force over a link differs from that on one machine, at rates of the simulation and
delays: `same`, from a session on one machine at the same rate; `best`, from one at the highest rate, which is what
the scene is. Of ticks in contact; the median of runs, each with another seed of the link. In real time.
"""
import concurrent.futures
import os
import time

import numpy

from measuring import parser_of
from recording import load
from relay_bed import SCENES, Bed, median
from tables import write_rows

# Scenes whose bodies the hand moves, by how long they come to rest before, s.
SETTLE_S = {"organ": 1.0, "tissue_and_blocks": 4.0, "threads": 1.0}
FELT = (("organ", 30.0), ("organ", 250.0), ("tissue_and_blocks", 30.0), ("tissue_and_blocks", 250.0))
DELAY_MS, LOSS = 20.0, 0.01
RATES_HZ, BEST_HZ = (20.0, 30.0, 50.0, 100.0, 250.0), 500.0
DELAYS_MS = (0.0, 5.0, 10.0, 20.0, 50.0)
EVERY_MS = 2


def session(build, scene, rate_hz, link, seed, seconds=30.0):
    """The recording of the scene's own hand. Link: delay in ms and loss; None: one machine."""
    settings = () if link is None else (f"delay_ms {link[0]}", f"loss {link[1]}")
    with Bed(build, *settings, seed=seed) as bed:
        sim = bed.sim_server(scene, "--rate", rate_hz)
        bed.wait_for_scene("a")
        began_s = time.monotonic()
        side = "a"
        if link is not None:
            relays, side = bed.relays(), "b"
            bed.wait_for_scene("b")
        time.sleep(max(0.0, SETTLE_S[scene] + 0.7 - (time.monotonic() - began_s)))
        haptic = bed.haptic_server(side, f"replay:file={SCENES / f'{scene}.hand.csv'}")
        haptic.wait(seconds)
        if link is not None:
            bed.end(*relays)
        bed.end(sim)
        bed.report("haptic")
        return load(bed.folder / "haptic.csv")


def forces_N(recording, time_s):
    """Rows (N, 3) at those times, each the last tick's before it."""
    tick = numpy.searchsorted(recording.time_s, time_s, side="right") - 1
    return recording.force_N[numpy.maximum(tick, 0)], recording["contacts"][numpy.maximum(tick, 0)] > 0


def difference(recording, reference):
    """rms and largest of the force's difference in ticks in contact of either, and the reference's rms, N."""
    end_s = min(recording.time_s[-1], reference.time_s[-1])
    time_s = numpy.arange(0.1, end_s, 1e-3)  # after the ramp of the beginning
    (force, touches), (true, really) = forces_N(recording, time_s), forces_N(reference, time_s)
    felt = touches | really
    distance = numpy.linalg.norm(force - true, axis=1)[felt]
    rms = lambda values: float(numpy.sqrt(numpy.mean(values**2)))
    return rms(distance), float(distance.max()), rms(numpy.linalg.norm(true[felt], axis=1))


def rate_rows(build, scene, rates_hz, delays_ms, runs):
    """Two sessions at once: each takes some tenth of a processor."""
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        best = list(pool.map(lambda seed: session(build, scene, BEST_HZ, None, seed), range(2)))[0]
        cells = [(rate_hz, delay_ms) for rate_hz in rates_hz for delay_ms in (None, *delays_ms)]
        jobs = {(*cell, seed): pool.submit(session, build, scene, cell[0],
                                           None if cell[1] is None else (cell[1], LOSS), seed)
                for cell in cells for seed in range(1, runs + 1)}
        felt = {key: job.result() for key, job in jobs.items()}
    rows = []
    for rate_hz, delay_ms in cells:
        some = [felt[rate_hz, delay_ms, seed] for seed in range(1, runs + 1)]
        to_best = [difference(one, best) for one in some]
        # One machine beside itself is a run beside the next.
        to_same = [difference(one, felt[rate_hz, None, seed % runs + 1]) for seed, one in enumerate(some, 1)]
        row = {"scene": scene, "rate_hz": f"{rate_hz:g}", "delay_ms": "" if delay_ms is None else f"{delay_ms:g}",
               "loss": 0 if delay_ms is None else LOSS, "runs": runs,
               "force_rms_N": f"{median([d[2] for d in to_best]):.4f}"}
        for name, differences in (("same", to_same), ("best", to_best)):
            row[f"{name}_rms_N"] = f"{median([d[0] for d in differences]):.4f}"
            row[f"{name}_worst_rms_N"] = f"{max(d[0] for d in differences):.4f}"
            row[f"{name}_largest_N"] = f"{median([d[1] for d in differences]):.4f}"
        row["age_p50_ms"] = f"{1e3 * median([float(numpy.median(one['age_s'])) for one in some]):.1f}"
        row["faded_share"] = f"{median([float(numpy.mean(['faded' in f for f in one['flags']])) for one in some]):.4f}"
        row["load"] = f"{os.getloadavg()[0]:.1f}"
        print(", ".join(f"{key} {value}" for key, value in row.items()), flush=True)
        rows.append(row)
    return rows


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
    parser = parser_of(__doc__, "the organ at 30 Hz, one run at two rates over one delay")
    parser.add_argument("--runs", type=int, default=8)
    arguments = parser.parse_args()
    small = arguments.small
    write_rows(arguments.charts / "relay_felt.csv", felt_rows(arguments.build, FELT[:1] if small else FELT))
    scenes = ("organ",) if small else SETTLE_S
    rates_hz, delays_ms = (RATES_HZ[1:4:2], (DELAY_MS,)) if small else (RATES_HZ, DELAYS_MS)
    write_rows(arguments.charts / "relay_rates.csv", [
        row for scene in scenes
        for row in rate_rows(arguments.build, scene, rates_hz, delays_ms, 1 if small else arguments.runs)])


if __name__ == "__main__":
    main()
