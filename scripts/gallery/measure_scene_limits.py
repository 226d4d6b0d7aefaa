#!/usr/bin/python3
"""Measures how scenes load: docs/charts/scene_limits.csv.

Scenes of 400 to 400,000 spheres, each sphere a body, all of one rigid box at rest and at 2 m/s, or one
sheet's: the time until the first step is done, without the step of a simulation that is not there, and
the most memory that sim_server held. Processor time: what else the machine does is not in it.
"""
import os
import pathlib
import subprocess
import tempfile

from measuring import parser_of
from tables import write_rows

HEAD = """format = 2
[simulation]
integrator = "velocity_verlet"
period_s = 0.001
[[material]]
name = "m"
contact_stiffness_N_per_m = 500.0
contact_damping_N_s_per_m = 0.2
"""
SPACING_M = 0.002
COUNTS, SMALL_COUNTS = (400, 4_000, 40_000, 400_000), (400, 4_000)


def bodies(count):
    side = round(count ** (1 / 3) + 0.5)
    text = ('[[body]]\nname = "ball {}"\nkind = "sphere"\nposition_m = [{:.4f}, {:.4f}, {:.4f}]\n'
            'radius_m = 0.0009\nmass_kg = 0.001\nmaterial = "m"\n')
    return (text.format(i, SPACING_M * (i % side), SPACING_M * (i // side % side),
                        SPACING_M * (i // side ** 2)) for i in range(count))


def box(count, speed_m_s):
    side = round(count ** (1 / 3))
    length_m = SPACING_M * side
    return (f'[[body]]\nname = "box"\nkind = "rigid_box"\nmass_kg = 1.0\nmaterial = "m"\n'
            f'size_m = [{length_m}, {length_m}, {length_m}]\nvelocity_m_s = [{speed_m_s}, 0.0, 0.0]\n'
            f'spheres = {{ spacing_m = {SPACING_M}, radius_m = {0.499 * SPACING_M} }}\n')


def sheet(count):
    side = round(count ** 0.5)
    return (f'[[body]]\nname = "sheet"\nkind = "sheet"\nmass_kg = {1e-5 * side * side}\n'
            f'material = "m"\nnodes = [{side}, {side}]\n'
            f'size_m = [{SPACING_M * (side - 1)}, {SPACING_M * (side - 1)}]\n'
            'spring_stiffness_N_per_m = { structural = 20.0, shear = 10.0, bend = 2.0 }\n')


# Of each its text, and how many spheres it has of those asked for.
SCENES = {"bodies": (bodies, lambda n: n),
          "box at rest": (lambda n: box(n, 0.0), lambda n: round(n ** (1 / 3)) ** 3),
          "box at 2 m/s": (lambda n: box(n, 2.0), lambda n: round(n ** (1 / 3)) ** 3),
          "sheet": (sheet, lambda n: round(n ** 0.5) ** 2)}


def run(scene, count, build):
    """One row of the table."""
    text, spheres = SCENES[scene]
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "scene.toml"
        with file.open("w") as out:  # line by line: what this process holds, its child begins with
            out.write(HEAD)
            out.writelines(text(count))
        with subprocess.Popen(
                [build / "bin/sim_server", "--scene", file, "--offline", "--duration", "0.001"],
                stderr=subprocess.DEVNULL) as server:
            _, status, usage = os.wait4(server.pid, 0)
            server.returncode = os.waitstatus_to_exitcode(status)
        if server.returncode != 0:
            raise SystemExit(f"{scene} of {count} spheres: exit status {server.returncode}")
    return {"scene": scene, "spheres": spheres(count),
            "processor_s": f"{usage.ru_utime + usage.ru_stime:.3f}",
            "memory_MB": f"{usage.ru_maxrss / 1e3:.0f}"}


def main():
    arguments = parser_of(__doc__, "scenes of at most 4,000 spheres").parse_args()
    rows = []
    for scene in SCENES:
        for count in SMALL_COUNTS if arguments.small else COUNTS:
            rows.append(run(scene, count, pathlib.Path(arguments.build)))
            print(*rows[-1].values(), flush=True)
    write_rows(arguments.charts / "scene_limits.csv", rows)


if __name__ == "__main__":
    main()
