#!/usr/bin/python3
"""Measures the scene laparoscopy, an instrument through a trocar: docs/charts/laparoscopy*.csv.

  laparoscopy.csv         times of detection, step and tick, a row a run: in real time with a hand that
                          strokes or circles, and offline, without instrument and sleep. Where other
                          programs take the processors, run it by chrt -r 1
  laparoscopy_stroke.csv  force and torque at the handle over a stroke, in lockstep
  laparoscopy_lever.csv   the rod held against the organ's side, in lockstep: the force that the hand's
                          spring holds, over that on the rod, and where on the rod that is
"""
import json
import os
import pathlib
import subprocess
import tempfile

import numpy

from instrument import distance_of, force_at_handle_N, rows_of, shaft_of
from measuring import ROOT, parser_of
from recording import load
from tables import write_rows

PIVOT_M, DEVICE_M = numpy.array([0.0, 0.0, 0.18]), numpy.array([0.0, 0.0, 0.29])  # of the scene
SCENE = ROOT / "sim_server/scene/scenes/laparoscopy.toml"
HAND_N_PER_M = 300.0  # hand=light
PIVOT = "pivot_x_m=0,pivot_y_m=0,pivot_z_m=-0.11"
HAND = f"phantom:profile=premium15,depth_m=0.03,{PIVOT}"


def launch(build, folder, device, seconds, *options):
    """Both daemons' reports and the recording."""
    subprocess.run([ROOT / "scripts/launch", "laparoscopy", "--device", device, "--duration", str(seconds),
                    "--build", build, "--report-dir", folder, "--record", folder / "run.csv", *options],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    sim, hand = (json.loads((folder / f"{name}.json").read_text()) for name in ("sim", "haptic"))
    return sim, hand, load(folder / "run.csv")


def times_row(mode, run, name, figures, scale=1.0):
    return {"mode": mode, "run": run, "what": name,
            **{f"{p}_ms": f"{scale * figures[p]:.4f}" for p in ("p50", "p99", "p999", "max")}}


def measure_times(build, folder, runs, seconds):
    rows = []
    for run in range(1, runs + 1):
        for path in ("stroke", "circle"):
            sim, hand, _ = launch(build, folder, f"{HAND},path={path}", seconds)
            rows += [times_row(path, run, "detection", sim["phases_ms"]["detect"]),
                     times_row(path, run, "step", sim["step_ms"]),
                     times_row(path, run, "tick", hand["tick_ns"], 1e-6)]
            print(f"{path}, run {run}: late {sim['late_steps']} of {sim['steps']} steps", flush=True)
        report, awake = folder / "offline.json", folder / "awake.toml"
        awake.write_text(SCENE.read_text().replace("rate_hz", "sleeping = false\nrate_hz").replace(
            '"organ.obj"', f'"{SCENE.with_name("organ.obj")}"'))
        subprocess.run([build / "bin/sim_server", "--scene", awake, "--offline", "--duration",
                        str(seconds), "--report", report], check=True, stderr=subprocess.DEVNULL)
        figures = json.loads(report.read_text())
        rows += [times_row("offline", run, "detection", figures["phases_ms"]["detect"]),
                 times_row("offline", run, "step", figures["step_ms"])]
    return rows


def measure_stroke(build, folder):
    _, _, run = launch(build, folder, f"{HAND},path=stroke", 6, "--lockstep")
    commanded_N, felt_N = rows_of(run, "f{}_N"), force_at_handle_N(run, PIVOT_M)
    return [{"time_s": f"{run['time_s'][i]:.3f}", "handle_x_mm": f"{1e3 * run['x_m'][i]:.3f}",
             "inserted_mm": f"{1e3 * (0.25 - distance_of(run, PIVOT_M)[i]):.2f}",
             "scene_x_N": f"{commanded_N[i, 0]:.4f}", "scene_z_N": f"{commanded_N[i, 2]:.4f}",
             "torque_y_N_m": f"{run['ty_N_m'][i]:.5f}",
             "handle_x_N": f"{felt_N[i, 0]:.4f}", "handle_z_N": f"{felt_N[i, 2]:.4f}"}
            for i in range(0, len(run["time_s"]), 10)]


def held(build, folder, distance_m, tilt_rad):
    """The rod goes down beside the organ, tilted, swings against its side and is held there."""
    lines = ["time_s,x_m,y_m,z_m"]
    for time_s in numpy.arange(0.0, 1.01, 0.02):
        d = numpy.interp(time_s, (0.0, 0.5), (0.14, distance_m))
        tilt = numpy.interp(time_s, (0.5, 1.0), (0.4, tilt_rad))
        at_m = PIVOT_M - DEVICE_M + d * numpy.array([0.0, numpy.sin(tilt), numpy.cos(tilt)])
        lines.append(f"{time_s:.2f},{at_m[0]:.9g},{at_m[1]:.9g},{at_m[2]:.9g}")
    (folder / "path.csv").write_text("\n".join(lines) + "\n")
    device = (f"phantom:friction_N=0,resolution_m=0,limits=0,max_force_N=20,{PIVOT},"
              f"path={folder / 'path.csv'}")
    _, _, run = launch(build, folder, device, 3, "--lockstep")
    pull_N = HAND_N_PER_M * (at_m + DEVICE_M - rows_of(run, "{}_m")[-1])
    force_N, torque_N_m = rows_of(run, "f{}_N")[-1], rows_of(run, "t{}_N_m")[-1]
    shaft = shaft_of(run)[-1]
    turning_N = numpy.cross(shaft, force_N)
    across = numpy.cross(turning_N, shaft) / numpy.linalg.norm(turning_N)
    return {"distance_mm": f"{1e3 * distance_of(run, PIVOT_M)[-1]:.2f}", "tilt_rad": f"{tilt_rad:g}",
            "touched_mm": f"{1e3 * (turning_N @ torque_N_m) / (turning_N @ turning_N):.2f}",
            "rod_across_N": f"{force_N @ across:.4f}", "hand_across_N": f"{-pull_N @ across:.4f}"}


def main():
    arguments = parser_of(__doc__, "one run of 3 s for the times, two places of the rod").parse_args()
    runs, seconds = (1, 3) if arguments.small else (5, 10)
    has_priority = os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR)
    notes = [f"sim_server with{'' if has_priority else 'out'} real-time priority; handle, force and torque "
             "in the scene's axes"]
    places = [(d, tilt) for tilt in (0.12, 0.0) for d in (0.075, 0.085, 0.095, 0.105)]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for table, rows in (
                ("laparoscopy", measure_times(arguments.build, folder, runs, seconds)),
                ("laparoscopy_stroke", measure_stroke(arguments.build, folder)),
                ("laparoscopy_lever", [held(arguments.build, folder, *place)
                                       for place in places[:2 if arguments.small else None]])):
            write_rows(arguments.charts / f"{table}.csv", rows, notes)


if __name__ == "__main__":
    main()
