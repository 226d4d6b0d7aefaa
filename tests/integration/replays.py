"""Runs of scripts/replay_check on a wall and a hand that presses it."""
import os
import subprocess
import sys

import daemons

sys.path.append(str(daemons.ROOT / "scripts" / "replay"))

EQUAL, DIFFERENT, COULD_NOT_RUN = 0, 1, 2
REPLAY_CHECK = daemons.ROOT / "scripts" / "replay_check"


class ReplayTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        # Comes down on the wall's 5 mm at 0.1 m/s, is 2 mm deep after 0.07 s, and leaves it again.
        self.hand = self.write("hand.csv", "t_s,x_mm,y_mm,z_mm\n0,0,0,10\n0.07,0,0,3\n0.4,1,0,8\n")
        self.expected = self.folder / "expected.csv"

    def check(self, scene="wall", *arguments, hand=None, expected=None, program=REPLAY_CHECK,
              build=("--build", daemons.BUILD), draws=False):
        """draws: or else there is no matplotlib, as on some CI machines, which saves a second."""
        without = self.folder / "without"
        without.mkdir(exist_ok=True)
        (without / "matplotlib.py").write_text("raise ImportError('no matplotlib')\n")
        environment = os.environ if draws else {**os.environ, "PYTHONPATH": str(without)}
        return subprocess.run([program, scene, hand or self.hand, expected or self.expected, *build,
                               *map(str, arguments)], cwd=self.folder, capture_output=True, text=True,
                              timeout=60 * daemons.PATIENCE, check=False, env=environment)

    def assert_says(self, run, status, *words):
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        for word in words:
            self.assertIn(word, run.stdout)

    def assert_one_line(self, run, *words):
        """It could not run, and one line says why."""
        self.assertEqual(run.returncode, COULD_NOT_RUN, run.stdout + run.stderr)
        self.assertEqual(run.stdout, "")
        self.assertRegex(run.stderr, r"\Areplay_check: .*\n\Z")
        for word in words:
            self.assertIn(word, run.stderr)

    def write_expected(self):
        self.assert_says(self.check("wall", "--write-expected"), EQUAL, "written: ")
        return daemons.read_recording(self.expected)

    def stiffer_wall(self):
        text = (daemons.SCENES / "wall.toml").read_text()
        self.assertIn("contact_stiffness_N_per_m = 1000.0", text)
        return self.write("stiffer.toml", text.replace("_N_per_m = 1000.0", "_N_per_m = 1100.0"))
