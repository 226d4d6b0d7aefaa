#!/usr/bin/python3
"""What solver = "auto" takes beside every method picked by hand, on the scenes that ship at their rates:
docs/charts/choice.csv, and prints the table of docs/algorithms/method_choice.md.

A row is a method on a scene: what a step costs, as the processor time of a second's steps less that of one, the median of
repetitions that alternate between the methods; and how far the end of half a second is from that by velocity Verlet
in steps of a quarter of a millisecond.
"""
import csv
import math
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import tomllib

from measuring import ROOT, fail, parser_of
from tables import write_rows

sys.path.append(str(ROOT / "scripts/fit"))
import toml_edit  # after the path it needs

SCENES = ROOT / "sim_server/scene/scenes"
ERROR_S, FINE_HZ = 0.5, 4000.0
TARGET_M = 1e-3  # error_target_m where a scene names none
EXPLICIT = [("velocity_verlet", None, None), ("symplectic_euler", None, None)]
IMPLICIT = [(integrator, solver, substeps) for integrator in ("implicit_euler", "bdf2", "trapezoid")
            for solver in ("newton", "newton_cg", "newton_lu") for substeps in (1, 2, 4)]
AUTO = ("auto", None, None)


def name_of(method):
    integrator, solver, substeps = method
    return integrator if solver is None else f"{integrator}, {solver}" + (f", {substeps} substeps" if substeps > 1 else "")


def with_method(text, method):
    """The scene's text with that method; who is tried by hand has no hand of the scene's to choose a rate by."""
    integrator, solver, substeps = method
    own = tomllib.loads(text)["simulation"]
    values = {"solver": "auto"} if method == AUTO else {"integrator": integrator, "solver": solver, "substeps": substeps}
    changes = {("simulation", key): values.get(key) for key in ("integrator", "solver", "substeps")
               if key in own or values.get(key) is not None}
    return toml_edit.edited(text, changes)


def run(build, scene, *options):
    """Processor time of a run, s; nothing where the method does not bear the scene."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([build / "bin/sim_server", "--scene", scene, "--offline", *map(str, options)],
                          capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        return None
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def places_of(file):
    with open(file, encoding="utf-8") as stream:
        return [tuple(float(row[axis]) for axis in ("x_m", "y_m", "z_m")) for row in csv.DictReader(stream)]


def end_of(build, folder, scene, *options):
    end = folder / "end.csv"
    end.unlink(missing_ok=True)
    return places_of(end) if run(build, scene, "--duration", ERROR_S, "--final-state", end, *options) is not None else None


def rms_m(places, others):
    return math.sqrt(sum(math.dist(a, b) ** 2 for a, b in zip(places, others)) / len(places))


def rows_of(build, folder, name, methods, repetitions):
    shutil.copytree(SCENES, folder, dirs_exist_ok=True)  # a scene reads what lies beside it
    text = (SCENES / f"{name}.toml").read_text()
    rate_hz = tomllib.loads(text)["simulation"]["rate_hz"]
    scenes, record = {}, folder / f"{name}_choice.json"
    for i, method in enumerate([AUTO, *methods]):
        scenes[method] = folder / f"{name}_{i}.toml"
        scenes[method].write_text(with_method(text, method))
    options = {method: ("--choice", record) if method == AUTO else () for method in scenes}
    choosing = subprocess.run([build / "bin/sim_server", "--scene", scenes[AUTO], "--explain", "--choice", record],
                              capture_output=True, text=True, check=False)
    if choosing.returncode:
        fail(f"{name}: {choosing.stderr.strip().splitlines()[-1]}")
    chosen = next(line.removeprefix("chosen: ") for line in choosing.stdout.splitlines() if line.startswith("chosen: "))
    truth = end_of(build, folder, scenes[EXPLICIT[0]], "--rate", FINE_HZ)
    costs_s = {method: [] for method in scenes}
    for _ in range(repetitions):
        for method, scene in scenes.items():
            short_s, long_s = (run(build, scene, "--duration", seconds, *options[method]) for seconds in (1.0 / rate_hz, 1.0))
            if None not in (short_s, long_s):
                costs_s[method].append(long_s - short_s)
    rows = []
    for method, scene in scenes.items():
        end = end_of(build, folder, scene, *options[method])
        rows.append({"scene": name, "method": chosen if method == AUTO else name_of(method),
                     "role": "auto" if method == AUTO else "",
                     "step_ms": f"{1e3 * statistics.median(costs_s[method]) / (rate_hz - 1.0):.4g}" if costs_s[method] else "",
                     "error_m": f"{rms_m(end, truth):.4g}" if end and truth else ""})
    return rows


def table_of(rows):
    lines = ["| scene | `auto` | ms a step | cheapest by hand within the target | ms a step | ratio |",
             "|---|---|---|---|---|---|"]
    for scene in dict.fromkeys(row["scene"] for row in rows):
        own = [row for row in rows if row["scene"] == scene and row["step_ms"] and row["error_m"]]
        auto = next((row for row in own if row["role"] == "auto"), None)
        good = [row for row in own if row["role"] != "auto" and float(row["error_m"]) <= TARGET_M]
        if auto is None or not good:
            lines.append(f"| {scene} | | | none | | |")
            continue
        best = min(good, key=lambda row: float(row["step_ms"]))
        lines.append(f"| {scene} | {auto['method']} | {auto['step_ms']} | {best['method']} | {best['step_ms']} | "
                     f"{float(auto['step_ms']) / float(best['step_ms']):.2f} |")
    return "\n".join(lines)


def main():
    arguments = parser_of(__doc__, "threads by three methods, once").parse_args()
    names = ["threads"] if arguments.small else ["tissue_and_blocks", "threads", "organ", "laparoscopy"]
    methods = EXPLICIT + (IMPLICIT[:1] if arguments.small else IMPLICIT)
    with tempfile.TemporaryDirectory() as folder:
        rows = [row for name in names
                for row in rows_of(arguments.build, pathlib.Path(folder), name, methods, 1 if arguments.small else 3)]
    write_rows(arguments.charts / "choice.csv", rows)
    print(table_of(rows))


if __name__ == "__main__":
    main()
