#!/usr/bin/python3
"""Measures the publication and writes docs/charts/publication_{speed,reads}.csv.

publication_speed: publishing a snapshot of N spheres, and memcpy of as many bytes between private
memories; medians of Google Benchmark's repetitions in random order. publication_reads: what the soaks
`publication` and `kills` of scripts/soak count, a row a soak; read times, and for the baseline
(cyclictest) and the reader's own timer how late it woke. The soaks take 20 minutes.
"""
import json
import pathlib
import statistics
import subprocess
import tempfile

import cyclictest
from benchmark_report import processor_name, run_benchmark, samples_by_benchmark
from measuring import ROOT, fail, parser_of, program
from tables import write_rows

SOAKS = ("snapshots_1ms", "words_512", "full_speed", "kills", "without_last_check")
COUNTS = ("ticks", "accepted", "torn", "mixed", "backwards", "nothing_shown", "rejected_attempts")
FAILED = ("failed_0", "failed_1", "failed_2")
SHARES = {"p50": 0.5, "p99": 0.99, "p999": 0.999}


def measure_speed(benchmark, repetitions, sizes, folder):
    """Rows and notes."""
    report = folder / "report.json"
    load, stolen = run_benchmark(benchmark, repetitions, f"^publish/.*/{sizes}$", report)
    runs = json.loads(report.read_text())
    samples = samples_by_benchmark(runs)
    bytes_of = {int(run["run_name"].split("/")[2]): int(run["bytes"])
                for run in runs["benchmarks"]
                if run["run_type"] == "iteration" and "bytes" in run}
    rows = []
    for n in sorted(bytes_of):
        row = {"spheres": n, "bytes": bytes_of[n]}
        for column, name in (("publish", "publish/scene_snapshot"), ("memcpy", "publish/memcpy")):
            low, median, high = statistics.quantiles(
                [1e-3 * ns for ns in samples[name, n]], n=4, method="inclusive")
            row |= {f"{column}_us": f"{median:.4g}", f"{column}_iqr_us": f"{high - low:.2g}"}
        rows.append(row)
    return rows, [f"{processor_name()}; one thread, Release, not tuned for the processor.",
                  f"Medians and distances between quartiles of {repetitions} repetitions in "
                  f"random order; load {load:.1f} at the start,",
                  f"{stolen:.1f} % of the time stolen by the host. Processor time."]


def run_soaks(build, is_small, folder):
    """A soak may fail on a busy machine; its log says why."""
    # Of fewer kills too few would fall into a write.
    for what, scale in (("publication", 200), ("kills", 10)) if is_small else (("publication", 1), ("kills", 1)):
        command = [ROOT / "scripts/soak", what, "--build", build, "--out", folder, "--scale", str(scale)]
        if subprocess.run(command).returncode:
            fail(f"scripts/soak {what} failed")


def baseline_us(file):
    """Ticks and percentiles of cyclictest's histogram, whole us."""
    counts = cyclictest.wake_ups(json.loads(file.read_text()))
    percentiles = [cyclictest.percentile_us(counts, share) for share in SHARES.values()]
    return sum(counts.values()), percentiles


def collect_reads(folder):
    """Rows and notes of what the soaks left."""
    rows = []
    for name in SOAKS:
        soak = json.loads((folder / f"{name}.json").read_text())
        rows.append({"soak": name, "time": "read", **{key: soak[key] for key in COUNTS},
                     **dict(zip(FAILED, soak["ticks_by_failed_attempts"])),
                     **{f"{p}_us": f"{1e-3 * soak['read_ns'][p]:.4g}" for p in SHARES}})
        if name == "words_512":
            rows.append({"soak": name, "time": "wake", "ticks": soak["ticks"],
                         **{f"{p}_us": f"{1e-3 * soak['wake_ns'][p]:.4g}" for p in SHARES}})
    if (folder / "cyclictest.json").exists():  # absent where no real-time priority is granted
        ticks, percentiles = baseline_us(folder / "cyclictest.json")
        rows.append({"soak": "cyclictest", "time": "wake", "ticks": ticks,
                     **{f"{p}_us": value for p, value in zip(SHARES, percentiles)}})
    return rows, [f"{processor_name()}; snapshots of 1 MiB, the writer in another process; 1 kHz and "
                  "SCHED_FIFO, but full_speed and without_last_check.",
                  "read: time of a read with all its attempts; wake: how late a timer of 1 ms woke."]


def main():
    parser = parser_of(__doc__, "publication_speed: 2 repetitions of three sizes, not 15 of all; "
                                "publication_reads: soaks 200 times as short, kills 10 times")
    parser.add_argument("table", choices=("publication_speed", "publication_reads"), metavar="TABLE",
                        help="publication_speed or publication_reads")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if arguments.table == "publication_speed":
            benchmark = program(arguments.build, "stillgrid_benchmark")
            how = (2, "(400|4000|40000)") if arguments.small else (15, "[0-9]+")
            rows, notes = measure_speed(benchmark, *how, folder)
        else:
            run_soaks(arguments.build, arguments.small, folder)
            rows, notes = collect_reads(folder)
    write_rows(arguments.charts / f"{arguments.table}.csv", rows, notes)


if __name__ == "__main__":
    main()
