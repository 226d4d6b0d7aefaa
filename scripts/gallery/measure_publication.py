#!/usr/bin/python3
"""Measures the publication and writes docs/charts/publication_{speed,reads}.csv.

speed: publishing an image of N spheres, and memcpy of as many bytes between private memories;
medians of Google Benchmark's repetitions in random order. reads: what scripts/soak left in
build/soak, a row a soak; read times, and for the baseline (cyclictest) and the reader's own timer
how late it woke. Draw both with plot_publication.py.
"""
import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

import cyclictest
from benchmark_report import processor_name, run_benchmark, samples_by_benchmark

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHARTS = ROOT / "docs/charts"
SOAKS = ("images_1ms", "words_512", "full_speed", "kills", "without_last_check")
COUNTS = ("ticks", "accepted", "torn", "mixed", "backwards", "nothing_shown", "rejected_attempts")
SHARES = {"p50": 0.5, "p99": 0.99, "p999": 0.999}


def write_csv(file, notes, header, rows):
    with open(file, "w", newline="") as stream:
        stream.writelines(f"# {note}\n" for note in notes)
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def measure_speed(program, repetitions, out):
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.json"
        load, stolen = run_benchmark(program, repetitions, "^publish/", report)
        runs = json.loads(report.read_text())
    samples = samples_by_benchmark(runs)
    bytes_of = {int(run["run_name"].split("/")[2]): int(run["bytes"])
                for run in runs["benchmarks"]
                if run["run_type"] == "iteration" and "bytes" in run}
    rows = []
    for n in sorted(bytes_of):
        row = [n, bytes_of[n]]
        for name in ("publish/scene_image", "publish/memcpy"):
            low, median, high = statistics.quantiles(
                [1e-3 * ns for ns in samples[name, n]], n=4, method="inclusive")
            row += [f"{median:.4g}", f"{high - low:.2g}"]
        rows.append(row)
    write_csv(out, [f"{processor_name()}; one thread, Release, not tuned for the processor.",
                    f"Medians and distances between quartiles of {repetitions} repetitions in "
                    f"random order; load {load:.1f} at the start,",
                    f"{stolen:.1f} % of the time stolen by the host. Processor time."],
              ["spheres", "bytes", "publish_us", "publish_iqr_us", "memcpy_us", "memcpy_iqr_us"],
              rows)


def baseline_us(file):
    """Ticks and percentiles of cyclictest's histogram, whole us."""
    counts = cyclictest.wake_ups(json.loads(file.read_text()))
    percentiles = [cyclictest.percentile_us(counts, share) for share in SHARES.values()]
    return sum(counts.values()), percentiles


def collect_reads(folder, out):
    rows = []
    for name in SOAKS:
        file = folder / f"{name}.json"
        if not file.exists():
            continue
        soak = json.loads(file.read_text())
        counts = [soak[key] for key in COUNTS] + soak["ticks_by_failed_attempts"]
        rows.append([name, "read", *counts, *(f"{1e-3 * soak['read_ns'][p]:.4g}" for p in SHARES)])
        if name == "words_512":
            rows.append([name, "wake", soak["ticks"], *[""] * 9,
                         *(f"{1e-3 * soak['wake_ns'][p]:.4g}" for p in SHARES)])
    if (folder / "cyclictest.json").exists():
        ticks, percentiles = baseline_us(folder / "cyclictest.json")
        rows.append(["cyclictest", "wake", ticks, *[""] * 9, *percentiles])
    if not rows:
        raise ValueError(f"{folder}: expected what scripts/soak writes")
    write_csv(out, [f"{processor_name()}; images of 1 MiB, the writer in another process; 1 kHz and "
                    "SCHED_FIFO, but full_speed and without_last_check.",
                    "read: time of a read with all its attempts; wake: how late a timer of 1 ms "
                    "woke."],
              ["soak", "time", *COUNTS, "failed_0", "failed_1", "failed_2", "p50_us", "p99_us",
               "p999_us"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="?", choices=("speed", "reads", "both"), default="both")
    parser.add_argument("--program", default=ROOT / "build/release/tests/stillgrid_benchmark",
                        help="default: %(default)s")
    parser.add_argument("--soak", type=pathlib.Path, default=ROOT / "build/soak", metavar="FOLDER",
                        help="default: %(default)s")
    parser.add_argument("--repetitions", type=int, default=15, help="default: %(default)s")
    arguments = parser.parse_args()
    if arguments.repetitions < 2:
        parser.error(f"--repetitions: value {arguments.repetitions}: expected 2 at least")
    try:
        if arguments.what != "reads":
            measure_speed(arguments.program, arguments.repetitions, CHARTS / "publication_speed.csv")
        if arguments.what != "speed":
            collect_reads(arguments.soak, CHARTS / "publication_reads.csv")
    except (OSError, subprocess.CalledProcessError, ValueError, KeyError) as error:
        sys.exit(f"measure_publication: {type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
