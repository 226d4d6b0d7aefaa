#!/usr/bin/python3
"""A simulation in Python that dies in mid-write: its force fades, and comes back with the next."""
import time

import numpy

import daemons
from python_test import start_python
import stillgrid

FADE_S = 0.1
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
        full = force_N > 0.999 * force_N.max()
        self.assertEqual(force_N[-1], 0.0)
        fades = 0
        for last in numpy.flatnonzero(full[:-1] & ~full[1:]):  # the last tick in full
            gone = last + numpy.flatnonzero(force_N[last:] == 0.0)[0]
            if full[last + 1:gone].any():
                continue  # it came back before it was gone
            fades += 1
            self.assertLess(time_s[gone] - time_s[last], FADE_S + 0.01 + late_s)
            self.assertTrue((numpy.diff(force_N[last:gone]) <= 1e-9).all(), "it only falls")
        self.assertEqual(fades, 3)

    def is_felt(self, session, record):
        """In full, within the last 50 rows."""
        session.check()
        lines = record.read_text().splitlines(keepends=True) if record.exists() else []
        if len(lines) < 200:
            return False
        header = next(line for line in lines if line.startswith("time_s")).split(",")
        column = header.index("rendered_fz_N"), header.index("fz_N")
        rows = [line.split(",") for line in lines[-50:] if line.endswith("\n")]
        return all(float(row[column[1]]) > 0.1 and row[column[0]] == row[column[1]] for row in rows)


if __name__ == "__main__":
    daemons.main()
