#!/usr/bin/python3
"""Measures how well stiffness_fit predicts a force: docs/charts/stiffness_fit*.csv.

Simulated palpations of a real organ's mesh with a known truth (palpation.py), eight seeds, two runs each: fitted to
the first, predicted on the second, by both servers in lockstep; and the recorded spring of recorded_forces.py, fitted
to its first half. The same build gives the same figures.
"""
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy

import palpation
import recorded_forces
from measuring import ROOT, fail, parser_of
from tables import read_rows, write_rows

sys.path.insert(1, str(ROOT / "scripts/stiffness"))
import law  # after the path it needs

FIELD = 'contact = "field"\nfield = { cell_m = 0.001 }'
SHOWN = 4  # seed whose map and forces are kept


def fitted(build, out, *arguments):
    subprocess.run([ROOT / "scripts/stiffness_fit", *arguments, "--build", build, "--out", out], check=True,
                   stdout=subprocess.DEVNULL)
    return json.loads((out / "stiffness_fit.json").read_text())


def rows_of(answer, name, seed, more):
    first, second = (one["R2"] for one in answer["recordings"])
    return [{"recording": name, "seed": seed, "model": model, "R2_fitted": f"{first[model]['along_normal']:.4f}",
             "R2_predicted": f"{second[model]['along_normal']:.4f}", "R2_size": f"{second[model]['size']:.4f}",
             "places": answer["places"] if "map" in model else 0, "offset_mm": f"{1e3 * answer['offset_m']:.3f}",
             **more} for model in first]


def maps(truth, out, own_N_per_m, spacing_m=0.0015):
    """Points of the palpated patch, with the true stiffness and the fitted one; bench, from the patch's middle."""
    places = numpy.array([[float(value) for value in row.values()] for row in read_rows(out / "stiffness_map.csv")])
    on_bench_m = numpy.array([palpation.turned(place, truth.organ.turn_xyzw) for place in places[:, :3]])
    half_m = numpy.array(truth.organ.patch_m)
    grid = [numpy.linspace(-half, half, 1 + int(2.0 * half / spacing_m)) for half in half_m]
    points_m = numpy.array([truth.on_surface(truth.middle_m[:2] + (x, y)) for x in grid[0] for y in grid[1]])
    known = numpy.append(places[:, 3], own_N_per_m)
    found = law.weights(points_m, on_bench_m) @ known
    return points_m - truth.middle_m, truth.stiffness_N_per_m(points_m), found, on_bench_m - truth.middle_m


def measure_palpation(build, charts, seed, folder):
    truth, out = palpation.Truth(palpation.LIVER, seed), folder / str(seed) / "fit"
    folder = folder / str(seed)
    folder.mkdir()
    scene = folder / "liver.toml"
    scene.write_text(palpation.scene_text(palpation.LIVER, FIELD))
    runs = [palpation.write(palpation.record(truth, run, seed), folder / f"run{run}.csv") for run in (0, 1)]
    answer = fitted(build, out, scene, runs[0], "--check", runs[1], "--rivals")
    points_m, true_N_per_m, found_N_per_m, places_m = maps(truth, out, answer["own_N_per_m"])
    inside = (numpy.abs(points_m[:, :2]) < 0.9 * numpy.array(truth.organ.patch_m)).all(axis=1)
    error = numpy.sqrt(((found_N_per_m / true_N_per_m - 1.0)[inside] ** 2).mean())
    if seed == SHOWN:
        rows = [{"kind": "point", "x_mm": f"{1e3 * x:.2f}", "y_mm": f"{1e3 * y:.2f}", "true_N_per_m": f"{true:.1f}",
                 "fitted_N_per_m": f"{found:.1f}"}
                for (x, y, _), true, found in zip(points_m, true_N_per_m, found_N_per_m)]
        rows += [{"kind": "place", "x_mm": f"{1e3 * x:.2f}", "y_mm": f"{1e3 * y:.2f}", "true_N_per_m": "",
                  "fitted_N_per_m": ""} for x, y, _ in places_m]
        write_rows(charts / "stiffness_fit_map.csv", rows)
        forces = [row for row in read_rows(out / "forces.csv") if 8.0 < float(row["time_s"]) < 20.0]
        write_rows(charts / "stiffness_fit_force.csv", forces)
    return rows_of(answer, "palpation", seed, {"true_offset_mm": f"{1e3 * truth.offset_m:.3f}",
                                               "stiffness_error": f"{error:.4f}"})


def measure_spring(build, folder):
    scene, halves = recorded_forces.spring_halves(folder)
    answer = fitted(build, folder / "spring", scene, halves[0], "--check", halves[1], *recorded_forces.SPRING_FIT)
    print(f"spring: {answer['own_N_per_m']:.1f} N/m")
    return rows_of(answer, "spring", 0, {"true_offset_mm": "", "stiffness_error": ""})


def main():
    arguments = parser_of(__doc__, "one seed of eight").parse_args()
    if not palpation.LIVER.file.exists() or not recorded_forces.SPRING.exists():
        fail(f"{recorded_forces.DATA}: expected the real inputs there")
    seeds = [SHOWN] if arguments.small else range(1, 9)
    with (tempfile.TemporaryDirectory() as name,
          concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as threads):  # in virtual time: nothing is timed
        rows = measure_spring(arguments.build, pathlib.Path(name))
        found = threads.map(lambda seed: measure_palpation(arguments.build, arguments.charts, seed,
                                                           pathlib.Path(name)), seeds)
        for seed, of_seed in zip(seeds, found):
            print(f"palpation {seed}: " + ", ".join(f"{row['model']} {row['R2_predicted']}" for row in of_seed),
                  flush=True)
            rows += of_seed
    write_rows(arguments.charts / "stiffness_fit.csv", rows)


if __name__ == "__main__":
    main()
