#!/usr/bin/python3
"""Measures error against time of every integrator and writes docs/charts/work_precision.csv.

Runs the program work_precision, a scene at a time, and writes after each, so that a run that was broken
off goes on with --resume, and --scenes measures some anew. All take twenty minutes.
"""
import csv
import io
import os
import subprocess
import time

from benchmark_report import processor_name, processor_times
from measuring import parser_of, program
from tables import read_notes, write_rows

SCENES = ["cloth_8x8_1e3", "cloth_8x8_1e4", "cloth_8x8_1e5", "cloth_32x32_1e3", "cloth_32x32_1e4",
          "cloth_32x32_1e5", "hanging_chain", "threads", "tissue_and_blocks", "cloth_100x100_1e4",
          "chain_modes"]
SMALL = ["hanging_chain", "chain_modes"]


def read_table(path):
    """Rows and notes of an earlier run."""
    if not path.exists():
        return [], []
    lines = path.read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#"))), read_notes(path)


def measure(benchmark, scene, rounds):
    """The scene's rows, and a note on what the machine did meanwhile."""
    load, before, began = os.getloadavg()[0], processor_times(), time.monotonic()
    text = subprocess.run([benchmark, str(rounds), scene], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    after = processor_times()
    stolen = 100.0 * (after[1] - before[1]) / max(1, after[0] - before[0])
    note = (f"{scene}: {time.monotonic() - began:.0f} s, load {load:.1f} at the start, "
            f"{stolen:.1f} % of the time stolen by the host.")
    return list(csv.DictReader(io.StringIO(text))), note


def main():
    parser = parser_of(__doc__, f"once, and only {', '.join(SMALL)}")
    parser.add_argument("--scenes", nargs="*", choices=SCENES, metavar="SCENE",
                        help="only these; the others' rows stay")
    parser.add_argument("--resume", action="store_true", help="only scenes without rows")
    arguments = parser.parse_args()
    benchmark = program(arguments.build, "work_precision")
    table = arguments.charts / "work_precision.csv"
    rows, notes = read_table(table)
    scenes = arguments.scenes or (SMALL if arguments.small else SCENES)
    if arguments.resume:
        scenes = [scene for scene in scenes if scene not in {row["scene"] for row in rows}]
    head = (f"{processor_name()}; one thread, Release, not tuned for the processor. Processor time, "
            "medians and quartiles.")
    for scene in scenes:
        fresh, note = measure(benchmark, scene, 1 if arguments.small else 7)
        rows = [row for row in rows if row["scene"] != scene] + fresh
        rows.sort(key=lambda row: SCENES.index(row["scene"]))
        notes = [old for old in notes if old != head and not old.startswith(scene + ":")] + [note]
        write_rows(table, rows, [head] + notes)
        print(note, flush=True)


if __name__ == "__main__":
    main()
