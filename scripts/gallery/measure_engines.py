#!/usr/bin/python3
"""Measures engines of others that publish by libstillgrid, built from docs/examples against an installed tree:
docs/charts/mujoco_ball.csv, mujoco_killed.csv and bullet_pile.csv, and prints the figures of docs/engines.md.

A ball in MuJoCo and in sim_server below the same hand in virtual time, without and with 30 um of noise (8 seeds); a
MuJoCo that is killed and started again in real time; a pile in Bullet felt for 10 s in virtual time.
"""
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time

import numpy

from measuring import fail, output_of, parser_of
from recording import Recording
from tables import write_rows

SEEDS = range(1, 9)
NOISE_M = 3e-5
PILE_HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0.03,depth_m=0.01,limits=0"


class Bench:
    def __init__(self, build, folder):
        self.folder, self.prefix, self.runs = folder, folder / "prefix", 0
        output_of(["cmake", "--install", build, "--prefix", self.prefix])
        self.examples = self.prefix / "share/stillgrid/examples"

    def built(self, name):
        output_of(["cmake", "-S", self.examples / name, "-B", self.folder / name, "-G", "Ninja",
                   f"-DCMAKE_PREFIX_PATH={self.prefix}", "-DCMAKE_BUILD_TYPE=Release"])
        output_of(["cmake", "--build", self.folder / name])
        return self.folder / name / f"publish_{name}"

    def start(self, command):
        return subprocess.Popen([str(word) for word in command], stderr=subprocess.PIPE, text=True)

    def felt(self, publisher, device, duration_s):
        """Recording and report of a run in virtual time; publisher: its command, of the session's name."""
        self.runs += 1
        session = f"engines-{os.getpid()}-{self.runs}"
        recording, report = self.folder / f"{self.runs}.csv", self.folder / f"{self.runs}.json"
        engine = self.start(publisher(session))
        output_of([self.prefix / "bin/haptic_server", "--session", session, "--device", device, "--lockstep",
                   "--duration", duration_s, "--record", recording, "--report", report])
        if engine.wait(60):
            fail(engine.stderr.read().strip())
        return Recording(recording), json.loads(report.read_text())


def press_down(file, duration_s, seed):
    """A device that goes down on the ball, 5 mm, and off it again, every two seconds."""
    time_s = numpy.arange(0.0, duration_s + 0.1, 0.001)
    z_m = -0.003 - 0.0035 * (1.0 - numpy.cos(numpy.pi * time_s))
    if seed:
        z_m += numpy.random.default_rng(seed).uniform(-NOISE_M, NOISE_M, len(z_m))
    rows = "".join(f"{t:.3f},0,0,{z:.7f}\n" for t, z in zip(time_s, z_m))
    file.write_text(f"time_s,x_m,y_m,z_m\n{rows}")
    return f"replay:file={file}"


def measure_ball(bench, mujoco, charts, duration_s):
    folder, scene = bench.examples / "mujoco", "ball_on_floor"

    def ours(session):
        return [bench.prefix / "bin/sim_server", "--scene", folder / f"{scene}.toml", "--session", session,
                "--lockstep", "--duration", duration_s]

    def theirs(response):
        return lambda session: [mujoco, folder / f"{scene}.xml", session, "--lockstep", "--response", response]

    rows, differences = [], {"step": [], "mass": []}
    for seed in (0, *SEEDS):
        hand = press_down(bench.folder / f"hand-{seed}.csv", duration_s, seed)
        one = bench.felt(ours, hand, duration_s)[0]
        for response, found in differences.items():
            other = bench.felt(theirs(response), hand, duration_s)[0]
            difference_N = other["fz_N"] - one["fz_N"]
            found.append(abs(difference_N).max())
            if response == "step" and seed == 0:
                rows = [{"time_s": f"{t:.3f}", "sim_server_N": f"{a:.4f}", "mujoco_N": f"{b:.4f}"}
                        for t, a, b in zip(one["time_s"], one["fz_N"], other["fz_N"])]
                print(f"largest force {one['fz_N'].max():.3f} N, {other['fz_N'].max():.3f} N; difference "
                      f"{abs(difference_N).max():.3f} N, rms {numpy.sqrt(numpy.mean(difference_N ** 2)):.3f} N")
    for response, found in differences.items():
        print(f"response {response}: largest difference of 8 seeds: median {numpy.median(found[1:]):.3f} N, "
              f"{min(found[1:]):.3f} to {max(found[1:]):.3f} N")
    write_rows(charts / "mujoco_ball.csv", rows)


def measure_killed(bench, mujoco, charts):
    session, still, recording = f"engines-{os.getpid()}-killed", bench.folder / "still.csv", bench.folder / "killed.csv"
    still.write_text("time_s,x_m,y_m,z_m\n0,0,0,-0.009\n100,0,0,-0.009\n")
    command = [mujoco, bench.examples / "mujoco/ball_on_floor.xml", session]
    engine = bench.start(command)
    haptic_server = bench.start([bench.prefix / "bin/haptic_server", "--session", session, "--device",
                                 f"replay:file={still}", "--duration", 3, "--record", recording])
    time.sleep(1.5)
    engine.send_signal(signal.SIGKILL)
    time.sleep(0.5)
    again = bench.start(command)
    status = haptic_server.wait(60)
    again.send_signal(signal.SIGKILL)
    if status:
        fail(haptic_server.stderr.read().strip())
    felt = Recording(recording)
    time_s, force_N, age_s = felt["time_s"], felt["fz_N"], felt["age_s"]
    is_faded = numpy.array(["faded" in flags for flags in felt["flags"]])
    silent = numpy.flatnonzero(is_faded & (force_N == 0.0) & (time_s > 1.0))[0]
    began = numpy.flatnonzero(~is_faded[:silent])[-1]
    back = silent + numpy.flatnonzero(force_N[silent:] > 0.99 * force_N[began])[0]
    print(f"killed: the force fades from {1e3 * age_s[began]:.0f} ms after the last state, within "
          f"{1e3 * (time_s[silent] - time_s[began]):.0f} ms; back in full {time_s[back] - time_s[silent]:.2f} s later")
    write_rows(charts / "mujoco_killed.csv", [{"time_s": f"{t:.3f}", "force_N": f"{f:.4f}"}
                                              for t, f in zip(time_s, force_N)])


def measure_pile(bench, bullet, charts, duration_s):
    felt, report = bench.felt(lambda session: [bullet, session, "--lockstep"], PILE_HAND, duration_s)
    force_N = numpy.stack([felt[f"f{axis}_N"] for axis in "xyz"], axis=1)
    print(f"pile: largest force {felt.force_norm_N().max():.2f} N, in contact {(felt['contacts'] > 0).mean():.0%}, "
          f"largest change in 1 ms {numpy.linalg.norm(numpy.diff(force_N, axis=0), axis=1).max():.2f} N, "
          f"interface made {1e3 * report['interface']['made_J']:.1f} mJ")
    write_rows(charts / "bullet_pile.csv", [{"time_s": f"{t:.3f}", "fx_N": f"{x:.3f}", "fy_N": f"{y:.3f}", "fz_N": f"{z:.3f}"}
                                            for t, (x, y, z) in list(zip(felt["time_s"], force_N))[::2]])


def main():
    arguments = parser_of(__doc__, "shorter runs").parse_args()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(arguments.build, pathlib.Path(folder))
        mujoco = bench.built("mujoco")
        measure_ball(bench, mujoco, arguments.charts, 2 if arguments.small else 6)
        measure_killed(bench, mujoco, arguments.charts)
        measure_pile(bench, bench.built("bullet"), arguments.charts, 3 if arguments.small else 10)


if __name__ == "__main__":
    main()
