#!/usr/bin/python3
"""Measures speed with stillgrid_benchmark and writes docs/charts/step1_speed.csv.

A row a benchmark: its median over repetitions in random order, and the distance between the
quartiles. Figures of the handbook stand beside, marked as such: they are another machine's, so
compare ratios, not times. Google Benchmark's own JSON goes to --json, for plot_benchmark.py.
"""
import argparse
import csv
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

NS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}
# Question: unit of the row, its size in ns, and whether it is shared out among the spheres.
UNITS = {
    "fill": ("ns per sphere", 1.0, True),
    "detect": ("ns per sphere", 1.0, True),
    "query_hot": ("ns", 1.0, False),
    "query_anywhere": ("ns", 1.0, False),
    "query_flushed": ("ns", 1.0, False),
    "publish": ("us", 1e3, False),
    "step_detect": ("ms", 1e6, False),
    "step_integrate": ("ms", 1e6, False),
}
ANOTHER_MACHINE = "handbook, another machine"
# Of the handbook, what its CSV does not hold: (benchmark, n): (figure, note).
OTHER_FIGURES = {
    ("publish/memcpy", 400): (0.45, "memcpy of a smaller snapshot"),
    ("publish/memcpy", 4000): (3.9, "memcpy of a smaller snapshot"),
    ("publish/memcpy", 40000): (42, "memcpy of a smaller snapshot"),
    ("query_anywhere/grid", 400): (156, "the paper's grid, random places"),
    ("query_anywhere/grid", 40000): (627, "the paper's grid, random places"),
}


def handbook_figures(file):
    """(benchmark, n): (figure, note), for the paper's own method in the handbook's CSV."""
    figures = {key: (figure, f"{note}; {ANOTHER_MACHINE}")
               for key, (figure, note) in OTHER_FIGURES.items()}
    with open(file) as stream:
        for row in csv.DictReader(line for line in stream if not line.startswith("#")):
            if row["method"].startswith("the paper's grid"):
                figures[f"{row['question']}/grid", int(row["spheres"])] = (
                    row["ns"], f"{row['method']}; {ANOTHER_MACHINE}")
    return figures


def processor_times():
    words = pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:]
    times = [int(word) for word in words]
    return sum(times[:8]), times[7]  # all, stolen by the host


def run_benchmark(program, repetitions, pattern, out):
    load = os.getloadavg()[0]
    all_before, stolen_before = processor_times()
    subprocess.run(
        [program, f"--benchmark_repetitions={repetitions}", f"--benchmark_filter={pattern}",
         "--benchmark_min_time=0.1", "--benchmark_enable_random_interleaving=true",
         f"--benchmark_out={out}", "--benchmark_out_format=json"],
        check=True, stdout=subprocess.DEVNULL)
    all_after, stolen_after = processor_times()
    stolen = 100.0 * (stolen_after - stolen_before) / max(1, all_after - all_before)
    return load, stolen


def samples_by_benchmark(report):
    """{(benchmark, n): [ns, ...]}, a sample a repetition."""
    samples = {}
    for run in report["benchmarks"]:
        if run["run_type"] != "iteration" or run.get("error_occurred"):
            continue
        words = run["run_name"].split("/")
        n = int(words[2]) if len(words) > 2 and words[2].isdigit() else None
        # Manual times are wall times; where nobody else runs both clocks agree.
        key = "real_time" if "manual_time" in words else "cpu_time"
        samples.setdefault((f"{words[0]}/{words[1]}", n), []).append(
            run[key] * NS[run["time_unit"]])
    return samples


def rows_of(samples, figures):
    questions = list(UNITS)
    order = sorted(samples, key=lambda key: (questions.index(key[0].split("/")[0]), key[0],
                                             key[1] or 0))
    for benchmark, n in order:
        times_ns = samples[benchmark, n]
        unit, size_ns, is_shared = UNITS[benchmark.split("/")[0]]
        values = [ns / size_ns / (n if is_shared else 1) for ns in times_ns]
        low, median, high = statistics.quantiles(values, n=4, method="inclusive")
        figure, note = figures.get((benchmark, n), ("", ""))
        yield [benchmark, n or "", f"{median:.4g}", unit, f"{high - low:.2g}", figure, note]


def processor_name():
    names = re.findall(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{len(names)} x {names[0].strip()}" if names else "unknown processor"


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=root / "build/release/tests/stillgrid_benchmark",
                        help="default: %(default)s")
    parser.add_argument("--out", default=root / "docs/charts/step1_speed.csv", metavar="FILE.csv",
                        help="default: %(default)s")
    parser.add_argument("--json", metavar="FILE.json", help="keep Google Benchmark's report there")
    parser.add_argument("--repetitions", type=int, default=15, help="default: %(default)s")
    parser.add_argument("--filter", default=".", metavar="REGEX", help="benchmarks to run")
    arguments = parser.parse_args()
    if arguments.repetitions < 2:
        parser.error("--repetitions: value %d: expected 2 at least" % arguments.repetitions)
    try:
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(arguments.json or pathlib.Path(folder) / "report.json")
            load, stolen = run_benchmark(arguments.program, arguments.repetitions,
                                         arguments.filter, out)
            samples = samples_by_benchmark(json.loads(out.read_text()))
        figures = handbook_figures(root / "docs/charts/handbook_figures.csv")
        rows = list(rows_of(samples, figures))
    except (OSError, subprocess.CalledProcessError, ValueError, KeyError) as error:
        sys.exit(f"measure_step1: {type(error).__name__}: {error}")
    with open(arguments.out, "w", newline="") as stream:
        stream.write(f"# {processor_name()}; one thread, Release, not tuned for the processor.\n"
                     f"# Medians of {arguments.repetitions} repetitions in random order; load "
                     f"{load:.1f} at the start, {stolen:.1f} % of the time stolen by the host.\n"
                     "# handbook_figure: measured elsewhere, in the row's unit; compare ratios.\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["benchmark", "n", "median", "unit", "iqr", "handbook_figure",
                         "handbook_note"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
