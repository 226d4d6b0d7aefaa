#!/usr/bin/python3
"""Measures error against time of every integrator and writes docs/charts/work_precision.csv.

Runs build/release/tests/work_precision, a scene at a time, and writes after each, so that a run
that was broken off goes on with --resume, and --scenes measures some anew. Draw it with
plot_work_precision.py.
"""
import argparse
import csv
import io
import os
import pathlib
import subprocess
import sys
import time

from measure_publication import write_csv
from benchmark_report import processor_name, processor_times

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ["cloth_8x8_1e3", "cloth_8x8_1e4", "cloth_8x8_1e5", "cloth_32x32_1e3", "cloth_32x32_1e4",
          "cloth_32x32_1e5", "hanging_chain", "threads", "tissue_and_blocks", "cloth_100x100_1e4",
          "chain_modes"]
QUICK = ["chain_modes", "cloth_8x8_1e4", "hanging_chain"]


def read_table(path):
    """Rows and notes of an earlier run."""
    if not path.exists():
        return [], []
    lines = path.read_text().splitlines()
    notes = [line[2:] for line in lines if line.startswith("#")]
    return list(csv.DictReader(line for line in lines if not line.startswith("#"))), notes


def measure(program, scene, rounds):
    """The scene's rows, and a note on what the machine did meanwhile."""
    load, before, began = os.getloadavg()[0], processor_times(), time.monotonic()
    text = subprocess.run([program, str(rounds), scene], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    after = processor_times()
    stolen = 100.0 * (after[1] - before[1]) / max(1, after[0] - before[0])
    note = (f"{scene}: {time.monotonic() - began:.0f} s, load {load:.1f} at the start, "
            f"{stolen:.1f} % of the time stolen by the host.")
    return list(csv.DictReader(io.StringIO(text))), note


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path,
                        default=ROOT / "build/release/tests/work_precision")
    parser.add_argument("--out", type=pathlib.Path,
                        default=ROOT / "docs/charts/work_precision.csv")
    parser.add_argument("--rounds", type=int, default=7, help="runs of what is quick")
    parser.add_argument("--scenes", nargs="*", choices=SCENES, metavar="SCENE",
                        help="only these; the others' rows stay")
    parser.add_argument("--quick", action="store_true", help="three scenes, in less than a minute")
    parser.add_argument("--resume", action="store_true", help="only scenes without rows")
    arguments = parser.parse_args()
    if not arguments.program.exists():
        sys.exit(f"measure_work_precision: {arguments.program}: not there; scripts/build first")
    rows, notes = read_table(arguments.out)
    scenes = arguments.scenes or (QUICK if arguments.quick else SCENES)
    if arguments.resume:
        scenes = [scene for scene in scenes if scene not in {row["scene"] for row in rows}]
    rounds = 1 if arguments.quick else arguments.rounds
    head = (f"{processor_name()}; one thread, Release, not tuned for the processor. Processor time, "
            "medians and quartiles.")
    for scene in scenes:
        fresh, note = measure(arguments.program, scene, rounds)
        rows = [row for row in rows if row["scene"] != scene] + fresh
        rows.sort(key=lambda row: SCENES.index(row["scene"]))
        notes = [old for old in notes if old != head and not old.startswith(scene + ":")] + [note]
        write_csv(arguments.out, [head] + [old for old in notes if old != head], rows[0].keys(),
                  [row.values() for row in rows])
        print(note, flush=True)


if __name__ == "__main__":
    main()
