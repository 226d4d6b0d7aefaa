#!/usr/bin/python3
"""What rate the Haply Inverse Service's protocol bears: the driver's own thread against the fake service on this
machine. Prints the table of docs/haply.md.

With the period of a nanosecond the service's answers are the pace: a tick a message."""
import json
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "release"
PERIODS_NS = {"1 kHz": 1_000_000, "4 kHz": 250_000, "as fast as it answers": 1}
SECONDS, RUNS = 3, 3


def run_pace(port, period_ns):
    run = subprocess.run([BUILD / "tests" / "haply_pace", BUILD / "lib" / "stillgrid" / "devices" / "haply.so", port,
                          str(SECONDS), str(period_ns)], capture_output=True, text=True, check=True)
    outcome = json.loads(run.stdout)
    if outcome["code"] != 0:
        sys.exit(f"haply_figures: {outcome['line']}")
    return {**outcome, "rate": outcome["ticks"] / outcome["span_s"]}


def main():
    service = subprocess.Popen(["/usr/bin/python3", ROOT / "tests" / "integration" / "haply_service.py"],
                               stdout=subprocess.PIPE, text=True)
    try:
        port = service.stdout.readline().strip()
        print("| Asked for | Ticks a second | From tick to tick, median, us | 99 %, us | Age of the state, median, us "
              "| 99 %, us |\n|---|---|---|---|---|---|")
        for name, period_ns in PERIODS_NS.items():
            runs = [run_pace(port, period_ns) for _ in range(RUNS)]
            cells = []
            for key, digits in (("rate", 0), ("step_p50_us", 0), ("step_p99_us", 0), ("age_p50_us", 1),
                                ("age_p99_us", 1)):
                values = sorted(run[key] for run in runs)
                cells.append(f"{statistics.median(values):.{digits}f} ({values[0]:.{digits}f} to "
                             f"{values[-1]:.{digits}f})")
            print(f"| {name} | {' | '.join(cells)} |")
    finally:
        service.terminate()


if __name__ == "__main__":
    main()
