#!/usr/bin/python3
"""What publishing a step costs from Python in processor time, beside a loop in C on the same handle and arrays, in turn.

Prints, by the number of spheres, medians and quartiles over the rounds, and that of the rounds' differences.
"""
import argparse
import ctypes
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("STILLGRID_BUILD_DIR", ROOT / "build/release"))
os.environ["STILLGRID_LIBRARY"] = str(BUILD / "lib/libstillgrid.so.1")
sys.path.append(str(ROOT / "shared/python"))
import stillgrid  # after the path it needs

STATES = 16  # of the cloud, in turn forwards and back
LOOP = """
#include <stillgrid.h>
int loop(stillgrid_publisher* publisher, uint32_t count, const double* const* positions, int states,
         const double* velocities, int steps) {
  for (int i = 0; i < steps; ++i)
    if (stillgrid_publisher_set_spheres(publisher, count, positions[i % states], velocities) ||
        stillgrid_publisher_publish(publisher, 0))
      return -1;
  return 0;
}
"""


def compiled_loop(folder):
    (folder / "loop.c").write_text(LOOP)
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", f"-I{ROOT / 'proto'}", folder / "loop.c", "-o", folder / "loop.so",
                    f"-L{BUILD / 'lib'}", "-lstillgrid", f"-Wl,-rpath,{BUILD / 'lib'}"], check=True)
    return ctypes.CDLL(folder / "loop.so").loop


def cloud(count):
    """States of spheres that overlap two others each, and move by a tenth of their radius a step."""
    random = numpy.random.default_rng(1)
    edge_m = 0.01 * numpy.cbrt(count * 4 / 3 * numpy.pi * 9 / 1.9)
    start_m = random.uniform(-0.5 * edge_m, 0.5 * edge_m, (count, 3))
    way_m = random.normal(size=(count, 3))
    way_m *= 0.001 / numpy.linalg.norm(way_m, axis=1)[:, None]
    forwards = [start_m + i * way_m for i in range(STATES)]
    return forwards + forwards[-2:0:-1], 100.0 * way_m


def measure(loop, count, rounds, seconds):
    """Microseconds a step: rows of Python's and C's."""
    states, velocities = cloud(count)
    scene = stillgrid.Scene(0.01, count, [stillgrid.Material(500.0, 1.0, 0.3)])
    with stillgrid.Publisher(scene, f"python-publish-{os.getpid()}") as publisher:
        publisher.set_shapes(numpy.full(count, 0.01))
        places = (ctypes.c_void_p * len(states))(*(state.ctypes.data for state in states))
        by_c = (publisher._handle, count, places, len(states), ctypes.c_void_p(velocities.ctypes.data))

        def by_python(steps):
            for i in range(steps):
                publisher.set_spheres(states[i % len(states)], velocities)
                publisher.publish()

        def time_us(run, steps):
            begin_s = time.process_time()
            run(steps)
            return 1e6 * (time.process_time() - begin_s) / steps

        ways = (by_python, lambda steps: loop(*by_c, steps))
        turns = len(states) * max(1, round(seconds / 2 / rounds / (1e-6 * time_us(by_python, len(states)) * len(states))))
        times_us = numpy.empty((rounds, 2))
        for i in range(rounds):
            for way in (0, 1) if i % 2 else (1, 0):
                times_us[i, way] = time_us(ways[way], turns)
        return times_us


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", type=int, nargs="+", default=[400, 4000, 40000, 400000], metavar="N")
    parser.add_argument("--rounds", type=int, default=15, metavar="N")
    parser.add_argument("--seconds", type=float, default=10, metavar="S", help="a count, about")
    arguments = parser.parse_args()
    print("spheres,python_us,python_quartiles_us,c_us,c_quartiles_us,difference_us,difference_quartiles_us")
    with tempfile.TemporaryDirectory() as folder:
        loop = compiled_loop(pathlib.Path(folder))
        for count in arguments.counts:
            times_us = measure(loop, count, arguments.rounds, arguments.seconds)
            columns = (*times_us.T, times_us[:, 0] - times_us[:, 1])
            print(count, *(f"{median:.3g},{low:.3g}-{high:.3g}" for low, median, high in (
                numpy.percentile(column, (25, 50, 75)) for column in columns)), sep=",", flush=True)


if __name__ == "__main__":
    main()
