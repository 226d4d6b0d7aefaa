#!/usr/bin/python3
"""Runs Google Benchmark and reads its report, for the scripts that measure and draw."""
import os
import pathlib
import re
import subprocess

NS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}


def processor_name():
    names = re.findall(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{len(names)} x {names[0].strip()}" if names else "unknown processor"


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
