#!/usr/bin/python3
"""Measures how old what arrives is, over a link that delays and loses: docs/charts/relay_age.csv, relay_streams.csv.

relay_age: snapshots of spheres that all move, 30 a second, by size, delay (each way) and loss. relay_streams: three
such streams and the tool's, by scene_relay and by Cyclone DDS as it is delivered (tests/network/plain_stream.cpp),
best effort and reliable with the last kept. A row is what several runs say, each with another seed of the link: the
median run's p50, p99 and share of looks older than 100 ms, the worst run's p99, and the longest of all.
"""
import concurrent.futures
import json
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
STREAMS = (("tool", 2, 0.01), ("10 kB", 10, 0.01), ("100 kB", 2, 0.01), ("1 MB", 2, 0.001))
WAYS = ("relay", "plain best effort", "plain reliable")
BYTES = {"tool": 192, "10 kB": 10_000, "100 kB": 100_000, "1 MB": 1_000_000}
RUN_S = 5.0


def settings_of(delay_ms, loss, rate_mbit_s=0):
    return (f"delay_ms {delay_ms}", f"loss {loss}", f"rate_mbit_per_s {rate_mbit_s}")


def snapshots_by_relay(build, size, settings, seed, seconds):
    """What the relay beside the hand reports."""
    environment = {**os.environ, "STILLGRID_LIBRARY": str(build / "lib/libstillgrid.so.1")}
    with Bed(build, *settings, seed=seed) as bed:
        publisher = bed.start("a", "publisher", [
            "/usr/bin/python3", ROOT / "scripts/gallery/moving_spheres.py", "--session", SESSION, "--count",
            SIZES[size], "--rate", RATE_HZ, "--duration", 60], env=environment)
        bed.wait_for_scene("a")
        relays = bed.relays()
        bed.wait_for_scene("b")
        time.sleep(seconds)
        bed.end(*reversed(relays), publisher)
        return {**bed.report("hand"), "sent": bed.report("simulation")["sent"]}


def tool_by_relay(build, settings, seed, seconds):
    with Bed(build, *settings, seed=seed) as bed:
        sim = bed.sim_server("wall")
        relays = bed.relays()
        bed.wait_for_scene("b")
        haptic = bed.haptic_server("b", f"phantom:path={SCENES / 'wall.hand.csv'}", "--duration", seconds)
        time.sleep(seconds)
        bed.end(*relays, haptic, sim)
        return {**bed.report("simulation"), "sent": bed.report("hand")["sent"]}


def stream_by_dds(build, size, settings, seed, seconds, is_reliable):
    words = ["--reliable"] if is_reliable else []
    with Bed(build, *settings, seed=seed, clock_offset_s=0.0) as bed:
        stream = program(build, "plain_stream")
        sender = bed.start("a", "sender", [stream, "send", *words, "--bytes", BYTES[size], "--rate",
                                           1000.0 if size == "tool" else RATE_HZ, "--duration", seconds + 5.0],
                           stdout=subprocess.PIPE, text=True)
        receiver = bed.start("b", "receiver", [stream, "receive", *words, "--duration", seconds + 1.0],
                             stdout=subprocess.PIPE, text=True)
        heard = json.loads(receiver.communicate()[0])
        sender.terminate()
        return {**heard, "sent": json.loads(sender.communicate()[0])["sent"]}


def run(build, size, way, settings, seed, seconds):
    if way != "relay":
        return stream_by_dds(build, size, settings, seed, seconds, way == "plain reliable")
    if size == "tool":
        return tool_by_relay(build, settings, seed, seconds)
    return snapshots_by_relay(build, size, settings, seed, seconds)


def row(size, way, delay_ms, loss, rate_mbit_s, reports):
    ages = [report["age_s"] for report in reports]
    p99_ms = [1e3 * age["p99"] for age in ages]
    return {"stream": size, "way": way, "delay_ms": delay_ms, "loss": loss, "link_Mbit_s": rate_mbit_s or "",
            "runs": len(ages), "p50_ms": f"{1e3 * median([age['p50'] for age in ages]):.2f}",
            "p99_ms": f"{median(p99_ms):.2f}", "worst_p99_ms": f"{max(p99_ms):.2f}",
            "longest_ms": f"{1e3 * max(age['max'] for age in ages):.2f}",
            "over_100_ms": f"{median([age['over_100_ms'] for age in ages]):.5f}",
            "worst_over_100_ms": f"{max(age['over_100_ms'] for age in ages):.5f}",
            "arrived_share": f"{sum(r['received'] for r in reports) / max(1, sum(r['sent'] for r in reports)):.4f}",
            "load": f"{os.getloadavg()[0]:.1f}"}


class Measurement:
    def __init__(self, build, runs, seconds):
        self.build, self.runs, self.seconds = build, runs, seconds

    def cell(self, size, way, delay_ms, loss, rate_mbit_s=0):
        """Small streams run side by side, a large one takes both processors."""
        settings = settings_of(delay_ms, loss, rate_mbit_s)
        with concurrent.futures.ThreadPoolExecutor(1 if size == "1 MB" else 4) as pool:
            reports = list(pool.map(lambda seed: run(self.build, size, way, settings, seed, self.seconds),
                                    range(1, self.runs + 1)))
        result = row(size, way, delay_ms, loss, rate_mbit_s, reports)
        print(", ".join(f"{key} {value}" for key, value in result.items() if value != ""), flush=True)
        return result


def main():
    parser = parser_of(__doc__, "3 runs of the streams but the largest, and four cells of the grid")
    parser.add_argument("--runs", type=int, default=8)
    arguments = parser.parse_args()
    small = arguments.small
    measurement = Measurement(arguments.build, 3 if small else arguments.runs, 3.0 if small else RUN_S)
    write_rows(arguments.charts / "relay_streams.csv", [
        measurement.cell(size, way, delay_ms, loss)
        for size, delay_ms, loss in (STREAMS[:3] if small else STREAMS) for way in WAYS])
    grid = [(size, delay_ms, loss) for size in (list(SIZES)[:2] if small else SIZES)
            for loss in (LOSSES[2:3] if small else LOSSES) for delay_ms in (DELAYS_MS[3:5] if small else DELAYS_MS)]
    rows = [measurement.cell(size, "relay", delay_ms, loss) for size, delay_ms, loss in grid]
    rows += [measurement.cell(size, "relay", 2, 0.001, 100) for size in (() if small else SIZES)]
    write_rows(arguments.charts / "relay_age.csv", rows)


if __name__ == "__main__":
    main()
