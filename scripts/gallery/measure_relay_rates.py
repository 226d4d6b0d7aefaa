#!/usr/bin/python3
"""Measures which rate of a simulation feels best over a delay, in virtual time: docs/charts/relay_rates.csv.

Shipped scenes on their own hand, by predict, in the laboratory of both servers' own code with a network between them
(stability_lab run --delay): the force's error against the scene at 1 kHz without a network, by rate, delay each way
and a loss of 1 %; the median and the worst of eight seeds. A row without a delay is without a network.
"""
import concurrent.futures
import csv
import json
import math
import pathlib
import tempfile

from measuring import ROOT, output_of, parser_of, program
from relay_bed import median
from tables import write_rows

SCENES = ROOT / "sim_server/scene/scenes"
NAMES = ("threads", "organ", "moving_sphere")
RATES_HZ, DELAYS_MS, LOSS, SEEDS = (10, 20, 30, 50, 100, 250), (0, 5, 10, 20, 50), 0.01, range(1, 9)
DURATION_S = 2
SHORTEST_PROMISE_S = 1.0 / 30.0  # scene_relay declares that, or a step and a round trip


def options_of(scene, period_s):
    return ["--scene", SCENES / f"{scene}.toml", "--device", f"replay:file={SCENES / scene}.hand.csv", "--duration",
            DURATION_S, "--period", f"{period_s:.9g}", "--transition", "predict"]


def force_rms_N(build, scene):
    """Of the scene at 1 kHz, over the run."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "run.csv"
        output_of([program(build, "stability_lab"), "run", *options_of(scene, 0.001), "--record", file])
        with open(file) as stream:
            rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    return math.sqrt(sum(float(row[f"f{axis}_N"]) ** 2 for row in rows for axis in "xyz") / len(rows))


def error_of(build, scene, rate_hz, delay_ms, seed):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "metrics.json"
        delay_s, period_s = 1e-3 * delay_ms, 1.0 / rate_hz
        told_s = max(period_s + min(period_s, 2.0 * delay_s), SHORTEST_PROMISE_S)
        network = ["--delay", f"{delay_s:g}", "--loss", LOSS, "--told-period", f"{told_s:.9g}"] if delay_ms else []
        output_of([program(build, "stability_lab"), "run", *options_of(scene, period_s), "--seed", seed, *network,
                   "--metrics", file])
        return json.loads(file.read_text())["error_N"]


def row_of(build, scene, rate_hz, delay_ms, scale_N, seeds):
    errors = [error_of(build, scene, rate_hz, delay_ms, seed) for seed in (seeds if delay_ms else seeds[:1])]
    return {"scene": scene, "rate_hz": rate_hz, "delay_ms": delay_ms, "loss": LOSS if delay_ms else 0,
            "seeds": len(errors), "force_rms_N": f"{scale_N:.4g}",
            "rms_N": f"{median([error['rms'] for error in errors]):.4g}",
            "worst_rms_N": f"{max(error['rms'] for error in errors):.4g}",
            "largest_N": f"{max(error['max'] for error in errors):.4g}"}


def main():
    arguments = parser_of(__doc__, "threads at two rates and one delay, two seeds").parse_args()
    build, small = arguments.build, arguments.small
    names = NAMES[:1] if small else NAMES
    cells = [(name, rate_hz, delay_ms) for name in names for delay_ms in (DELAYS_MS[3:4] if small else DELAYS_MS)
             for rate_hz in (RATES_HZ[2:4] if small else RATES_HZ)]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        scale_N = dict(zip(names, pool.map(lambda name: force_rms_N(build, name), names)))
        rows = list(pool.map(lambda cell: row_of(build, *cell, scale_N[cell[0]], SEEDS[:2] if small else SEEDS), cells))
    write_rows(arguments.charts / "relay_rates.csv", rows)


if __name__ == "__main__":
    main()
