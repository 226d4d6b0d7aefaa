#!/usr/bin/python3
"""integrator = "auto" is chosen by the spectrum: no clock decides."""
import subprocess

import daemons
from daemons import DONE, NOT_CONVERGED

SCENE = """
format = 2
[simulation]
rate_hz = 50.0
integrator = "auto"
[[material]]
name = "thread"
contact_stiffness_N_per_m = 200.0
[[body]]
name = "thread"
kind = "thread"
nodes = 6
from_m = [0.0, 0.0, 0.0]
to_m = [0.05, 0.0, 0.0]
mass_kg = 0.01
spring_stiffness_N_per_m = { structural = 50.0 }
spheres = { radius_m = 0.002 }
pinned = "start"
material = "thread"
"""


class MethodChoiceTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("auto.toml", SCENE)
        self.end = self.folder / "end.csv"

    def explain(self):
        return self.run_program("--explain")

    def offline(self, *arguments):
        return self.run_program("--offline", "--duration", "0.5", "--final-state", self.end,
                                *arguments)

    def run_program(self, *arguments):
        command = [daemons.BUILD / "bin" / "sim_server", "--scene", self.scene, *arguments]
        return subprocess.run([str(each) for each in command], capture_output=True, text=True,
                              timeout=60 * daemons.PATIENCE)

    def test_explain_names_the_chosen_method_and_why(self):
        result = self.explain()

        self.assertEqual(result.returncode, DONE, result.stderr)
        self.assertRegex(result.stdout, "method by the spectrum: velocity_verlet: springs of .* rad/s")
        self.assertEqual(self.explain().stdout, result.stdout)  # no clock is read
        self.write("auto.toml", SCENE.replace("structural = 50.0", "structural = 1e9"))
        self.assertRegex(self.explain().stdout, "method by the spectrum: implicit_euler: .* more than 16\n")

    def test_virtual_time_chooses_a_method_and_repeats_it_to_the_bit(self):
        ends = []
        for _ in range(2):
            result = self.offline()
            self.assertEqual(result.returncode, DONE, result.stderr)
            self.assertIn("method chosen: ", result.stderr)
            ends.append(self.end.read_bytes())
        self.assertEqual(ends[0], ends[1])

    def test_a_run_of_which_no_step_converged_says_so_by_its_exit_status_too(self):
        stiff = SCENE.replace("structural = 50.0", "structural = 1e9").replace(
            'integrator = "auto"', "tolerance_m_s = 1e-9").replace("rate_hz = 50.0", "rate_hz = 10.0")
        for scene, status in ((stiff, NOT_CONVERGED), (stiff.replace("1e9", "1e6"), DONE)):
            self.write("auto.toml", scene)
            result = self.offline()
            self.assertEqual(result.returncode, status, result.stderr)
            self.assertEqual("5 of 5 steps did not converge" in result.stderr, status == NOT_CONVERGED)
            self.assertTrue(self.end.exists())


if __name__ == "__main__":
    daemons.main()
