#!/usr/bin/python3
"""Measures how old what arrives is, over a link that delays and loses: docs/charts/relay_age.csv, relay_streams.csv.

relay_age: snapshots of spheres that all move, 30 a second, by size, delay (each way) and loss. relay_streams: three
such streams and the tool's, by scene_relay and by Cyclone DDS as it is delivered (tests/network/plain_stream.cpp),
best effort and reliable with the last kept. A row is what several runs say, each with another seed of the link: the
median run's p50, p99 and share of looks older than 100 ms, the worst run's p99, and the longest of all.
"""
import concurrent.futures
import json
import math
import os
import subprocess
import time

from measuring import ROOT, parser_of, program
from relay_bed import SCENES, SESSION, Bed, median
from tables import write_rows

RATE_HZ = 30.0
# Spheres of a snapshot, and what it is called: a sphere's motion is 36 bytes, and 128 stand before them.
SIZES = {"10 kB": 274, "100 kB": 2774, "1 MB": 27774}
DELAYS_MS, LOSSES = (0, 2, 10, 20, 50), (0.0, 0.001, 0.01, 0.05)
LARGE_DELAYS_MS, LARGE_LOSSES = (2, 20, 50), (0.0, 0.001)  # of the largest
STREAMS = (("tool", 2, 0.01), ("10 kB", 10, 0.01), ("100 kB", 2, 0.01), ("1 MB", 2, 0.001))
WAYS = ("relay", "plain best effort", "plain reliable")
BYTES = {"tool": 192, "10 kB": 10_000, "100 kB": 100_000, "1 MB": 1_000_000}
AT_ONCE = {"tool": 2, "10 kB": 4, "100 kB": 2, "1 MB": 1}
RUNS, RUN_S = 8, 4.0
NEVER = {"p50": math.inf, "p99": math.inf, "max": math.inf, "over_100_ms": 1.0}  # nothing came


def settings_of(delay_ms, loss, rate_mbit_s=0):
    return (f"delay_ms {delay_ms}", f"loss {loss}", f"rate_mbit_per_s {rate_mbit_s}")


def snapshots_by_relay(build, size, settings, seed, seconds):
    """What the relay beside the hand reports."""
    environment = {**os.environ, "STILLGRID_LIBRARY": str(build / "lib/libstillgrid.so.1")}
    with Bed(build, *settings, seed=seed) as bed:
        publisher = bed.start("a", "publisher", [
            "/usr/bin/python3", ROOT / "scripts/gallery/moving_spheres.py", "--session", SESSION, "--count",
            SIZES[size], "--rate", RATE_HZ, "--duration", 60], env=environment)
        bed.wait_for("a", "scene")
        relays = bed.relays()
        bed.wait_for("b", "scene")
        time.sleep(seconds)
        bed.end(*reversed(relays), publisher)
        return bed.report("hand")


def tool_by_relay(build, settings, seed, seconds):
    with Bed(build, *settings, seed=seed) as bed:
        sim = bed.sim_server("wall")
        relays = bed.relays()
        bed.wait_for("b", "scene")
        haptic = bed.haptic_server("b", f"phantom:path={SCENES / 'wall.hand.csv'}", "--duration", seconds)
        time.sleep(seconds)
        bed.end(*relays, haptic, sim)
        return bed.report("simulation")


def stream_by_dds(build, size, settings, seed, seconds, is_reliable):
    words = ["--reliable"] if is_reliable else []
    with Bed(build, *settings, seed=seed, clock_offset_s=0.0) as bed:
        stream = program(build, "plain_stream")
        sender = bed.start("a", "sender", [stream, "send", *words, "--bytes", BYTES[size], "--rate",
                                           1000.0 if size == "tool" else RATE_HZ, "--duration", seconds + 5.0])
        receiver = bed.start("b", "receiver", [stream, "receive", *words, "--duration", seconds + 1.0],
                             stdout=subprocess.PIPE, text=True)
        heard = receiver.communicate()[0]
        bed.end(sender)
        return json.loads(heard)


def run(build, size, way, settings, seed, seconds):
    if way != "relay":
        return stream_by_dds(build, size, settings, seed, seconds, way == "plain reliable")
    if size == "tool":
        return tool_by_relay(build, settings, seed, seconds)
    return snapshots_by_relay(build, size, settings, seed, seconds)


def row(size, way, delay_ms, loss, rate_mbit_s, reports):
    ages = [report["age_s"] if report["age_s"]["count"] else NEVER for report in reports]
    p99_ms = [1e3 * age["p99"] for age in ages]
    return {"stream": size, "way": way, "delay_ms": delay_ms, "loss": loss, "link_Mbit_s": rate_mbit_s or "",
            "runs": len(ages), "p50_ms": f"{1e3 * median([age['p50'] for age in ages]):.2f}",
            "p99_ms": f"{median(p99_ms):.2f}", "worst_p99_ms": f"{max(p99_ms):.2f}",
            "longest_ms": f"{1e3 * max(age['max'] for age in ages):.2f}",
            "over_100_ms": f"{median([age['over_100_ms'] for age in ages]):.5f}",
            "worst_over_100_ms": f"{max(age['over_100_ms'] for age in ages):.5f}",
            "load": f"{os.getloadavg()[0]:.1f}"}


def measured(build, size, way, delay_ms, loss, rate_mbit_s, runs, seconds):
    """A row. Small streams run side by side, a large one takes both processors."""
    settings = settings_of(delay_ms, loss, rate_mbit_s)
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE[size]) as pool:
        reports = list(pool.map(lambda seed: run(build, size, way, settings, seed, seconds), range(1, runs + 1)))
    result = row(size, way, delay_ms, loss, rate_mbit_s, reports)
    print(", ".join(f"{key} {value}" for key, value in result.items() if value != ""), flush=True)
    return result


def streams(is_small):
    return [(size, way, delay_ms, loss, 0) for size, delay_ms, loss in (STREAMS[:3] if is_small else STREAMS)
            for way in WAYS]


def grid(is_small):
    """And the same over 100 Mbit/s, where a large snapshot has no room."""
    if is_small:
        return [(size, "relay", 20, 0.01, 0) for size in list(SIZES)[:2]]
    cells = [(size, "relay", delay_ms, loss, 0) for size in list(SIZES)[:2] for loss in LOSSES
             for delay_ms in DELAYS_MS]
    cells += [("1 MB", "relay", delay_ms, loss, 0) for loss in LARGE_LOSSES for delay_ms in LARGE_DELAYS_MS]
    return cells + [(size, "relay", 2, 0.001, 100) for size in SIZES]


TABLES = {"relay_streams": streams, "relay_age": grid}


def main():
    parser = parser_of(__doc__, "three short runs a cell, the streams without the largest and two cells of the grid")
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"some of {', '.join(TABLES)}; default: all")
    arguments = parser.parse_args()
    for name in set(arguments.tables) - set(TABLES):
        parser.error(f"TABLE: value {name}: expected some of {', '.join(TABLES)}")
    runs, seconds = (3, 2.0) if arguments.small else (RUNS, RUN_S)
    for name in arguments.tables or TABLES:
        rows = []
        for cell in TABLES[name](arguments.small):
            rows.append(measured(arguments.build, *cell, runs, seconds))
            write_rows(arguments.charts / f"{name}.csv", rows)


if __name__ == "__main__":
    main()
