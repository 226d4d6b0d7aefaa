#!/usr/bin/python3
"""A simulation in Python that dies in mid-write: its force fades, and comes back with the next."""
import time

import numpy

import daemons
from python_test import start_python
import stillgrid

FADE_S = 0.1
FORCE_N = 1.5  # 3 mm of 500 N/m
# Publishes without a pause, so that a kill most often meets it in mid-write.
HURRIED = """
import numpy, sys
import stillgrid
scene = stillgrid.Scene(0.02, 20001, [stillgrid.Material(500.0)])
positions_m = numpy.zeros((20001, 3))
positions_m[1:] = numpy.random.default_rng(0).uniform(1.0, 2.0, (20000, 3))
with stillgrid.Publisher(scene, sys.argv[1]) as publisher:
    publisher.set_shapes(numpy.full(20001, 0.02))
    while True:
        publisher.set_spheres(positions_m)
        publisher.publish()
"""


class KillTest(daemons.SessionTest):
    def test_the_force_of_a_simulation_killed_in_mid_write_fades_and_returns_with_the_next(self):
        program, record = self.write("hurried.py", HURRIED), self.folder / "recording.csv"
        with stillgrid.Session(device=self.still_device(0, 0, 0.022), name=self.session, record=record) as session:
            for _ in range(3):
                simulation = start_python(program, self.session)
                self.addCleanup(simulation.kill)
                self.wait_until(lambda: self.is_felt(session, record), 30, "the force")
                simulation.kill()
                simulation.wait()
                time.sleep(0.4)
            self.assertIsNone(session.check())
        force_N, time_s = session.recording.force_norm_N(), session.recording.time_s
        late_s = numpy.diff(time_s).max()
        full = force_N > 0.999 * FORCE_N
        self.assertEqual(force_N[-1], 0.0)
        silent = numpy.flatnonzero((force_N[:-1] > 0.0) & (force_N[1:] == 0.0)) + 1
        silent = [gone for gone in silent if full[:gone].any() and not force_N[gone:gone + 200].any()]
        self.assertGreaterEqual(len(silent), 3)
        for gone in silent:
            last = numpy.flatnonzero(full[:gone])[-1]  # the last tick in full
            self.assertLess(time_s[gone] - time_s[last], FADE_S + 0.01 + late_s)
            self.assertTrue((numpy.diff(force_N[last:gone]) <= 1e-9).all(), "it only falls")

    def is_felt(self, session, record):
        """In full, within the last 50 rows."""
        session.check()
        lines = record.read_text().splitlines(keepends=True) if record.exists() else []
        if len(lines) < 200:
            return False
        column = next(line for line in lines if line.startswith("time_s")).split(",").index("fz_N")
        return all(float(line.split(",")[column]) > 0.999 * FORCE_N for line in lines[-50:-1])


if __name__ == "__main__":
    daemons.main()
