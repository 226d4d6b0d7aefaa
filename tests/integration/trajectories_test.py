#!/usr/bin/python3
"""Every recorded trajectory replays the same bytes, whatever else the machine does.

Here half a second of each; scripts/soak replay does all to their ends, many times.
"""
import unittest

import daemons
import trajectories
from trajectories import TRAJECTORIES

DURATION_S = 0.5


class TrajectoriesTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        if not trajectories.FOLDER.exists():
            self.skipTest(f"skipped: {trajectories.FOLDER} is absent")

    def record_all(self):
        return {trajectory.name: self.run_lockstep(
                    trajectories.make_scene(trajectory.scene, self.folder), trajectory.device, DURATION_S)
                for trajectory in TRAJECTORIES}

    def test_every_one_is_laid_into_a_scene(self):
        files = {str(file.relative_to(trajectories.FOLDER))
                 for file in trajectories.FOLDER.rglob("*.csv")}
        files.discard("ku_contour_force/contour_edge_mm.csv")  # a line in space, without time
        self.assertEqual(files, {trajectory.file for trajectory in TRAJECTORIES})

    def test_two_runs_write_the_same_bytes_one_of_them_beside_stress_ng(self):
        quiet = self.record_all()
        with trajectories.stress():
            busy = self.record_all()
        for name, file in quiet.items():
            with self.subTest(name):
                self.assertGreater(daemons.read_recording(file)["contacts"].max(), 0, "touched nothing")
                self.assertEqual(file.read_bytes(), busy[name].read_bytes())


if __name__ == "__main__":
    daemons.main()
