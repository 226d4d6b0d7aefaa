"""Measures the largest stiffness of a wall on which a device comes to rest, with both servers' own programs.

The device has 0.075 kg and a damper of 5 N s/m, and is pushed onto the wall by 1 N: at the host's pace, at the
device's, and by a host beside the device's own thread (late).
"""
import csv
import math
import os
import pathlib
import subprocess
import tempfile

from measuring import fail, program

SCENE = """format = 2
[simulation]
period_s = 0.02
[[material]]
name = "wall"
contact_stiffness_N_per_m = {stiffness_N_per_m}
[[body]]
name = "wall"
kind = "plane"
normal = [0.0, 0.0, 1.0]
material = "wall"
"""
DEVICE = ("phantom:profile=premium15,hand=none,limits=0,max_force_N=0,friction_N=0,resolution_m=0,mass_kg=0.075,"
          "damping_N_s_per_m=5,path=still,push_z_N=-1,start_z_m={start_m},pace={pace}")
PACES = ("host", "device", "late")
STARTS_M = (0.0007, 0.0011)
LOWEST_N_PER_M, HIGHEST_N_PER_M, HALVINGS = 500.0, 40000.0, 7
DURATION_S = 1.7


def speeds_m_s(recording):
    with open(recording) as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    if len(rows) < 100:
        fail(f"{recording}: expected a recording of {DURATION_S} s, not {len(rows)} ticks")
    heights = [(float(row["time_s"]), float(row["z_m"])) for row in rows]
    return [(z1 - z0) / max(1e-4, t1 - t0) for (t0, z0), (t1, z1) in zip(heights, heights[1:])]


def comes_to_rest(speeds):
    def rms(part):
        return math.sqrt(sum(speed * speed for speed in part) / len(part))
    quarter = len(speeds) // 4
    before, last = rms(speeds[quarter:2 * quarter]), rms(speeds[-quarter:])
    return last < 1e-5 or last < 0.9 * before


def run(build, pace, start_m, stiffness_N_per_m):
    """Whether the device comes to rest on the wall."""
    session = f"delay-{os.getpid()}"
    with tempfile.TemporaryDirectory() as folder:
        scene, recording = pathlib.Path(folder) / "wall.toml", pathlib.Path(folder) / "run.csv"
        scene.write_text(SCENE.format(stiffness_N_per_m=stiffness_N_per_m))
        both = ["--session", session, "--lockstep", "--duration", str(DURATION_S)]
        sim = subprocess.Popen([program(build, "sim_server"), "--scene", scene, *both], stderr=subprocess.DEVNULL)
        try:
            haptic = subprocess.run(
                [program(build, "haptic_server"), *both, "--device",
                 DEVICE.format(start_m=start_m, pace=pace), "--max-stiffness", "1e9", "--max-slew", "1e6",
                 "--record", recording], stderr=subprocess.PIPE, text=True)
        finally:
            sim.terminate()
            sim.wait()
        if haptic.returncode:
            fail(haptic.stderr.strip())
        return comes_to_rest(speeds_m_s(recording))


def limit_N_per_m(build, pace):
    low, high = LOWEST_N_PER_M, HIGHEST_N_PER_M
    for _ in range(HALVINGS):
        middle = math.sqrt(low * high)
        if all(run(build, pace, start_m, middle) for start_m in STARTS_M):
            low = middle
        else:
            high = middle
    return low
