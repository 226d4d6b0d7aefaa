#!/usr/bin/python3
"""sim_server --contacts: what bodies weigh on each other, by each method, and what a tool adds."""
import csv
import subprocess
import unittest

import daemons
from daemons import BAD_INPUT, BUILD

SCENE = """format = 2
[simulation]
rate_hz = 200.0
{method}
[device]
position_m = [0.0, 0.0, 0.075]
[[material]]
name = "pad"
contact_stiffness_N_per_m = 2000.0
contact_damping_N_s_per_m = 5.0
friction = 0.5
[[body]]
name = "floor"
kind = "plane"
normal = [0.0, 0.0, 1.0]
material = "pad"
[[body]]
name = "lower"
kind = "rigid_box"
size_m = [0.04, 0.04, 0.04]
position_m = [0.1, 0.0, 0.02]
mass_kg = 0.2
material = "pad"
[[body]]
name = "upper"
kind = "{kind}"
position_m = [0.1, 0.0, 0.055]
mass_kg = 0.1
material = "pad"
{shape}
"""
BOX = {"kind": "rigid_box", "shape": "size_m = [0.03, 0.03, 0.03]"}
BLOCK = {"kind": "soft_block", "shape": "size_m = [0.03, 0.03, 0.03]\nnodes = [3, 3, 3]\n"
         "spring_stiffness_N_per_m = { structural = 500.0, shear = 250.0 }\nspring_damping_N_s_per_m = 0.5"}
METHODS = ("velocity_verlet", "implicit_euler", "cvode_bdf")
GRAVITY = 9.81


def rows_of(file):
    """The rows of the last step by their two bodies."""
    rows = list(csv.DictReader(file.read_text().splitlines()))
    last = [row for row in rows if row["time_s"] == rows[-1]["time_s"]]
    return {(row["body_a"], row["body_b"]): {key: float(value) for key, value in row.items() if not key.startswith("body")}
            for row in last}


class ContactLogTest(daemons.SessionTest):
    def logged(self, scene, duration_s):
        log = self.folder / "contacts.csv"
        subprocess.run([BUILD / "bin" / "sim_server", "--scene", scene, "--offline", "--duration", str(duration_s),
                        "--contacts", log], check=True, capture_output=True)
        return rows_of(log)

    def test_each_body_bears_what_stands_on_it(self):
        for method in METHODS:
            for upper in (BOX, BLOCK):
                with self.subTest(method, upper=upper["kind"]):
                    pairs = self.logged(self.write("s.toml", SCENE.format(method=f'integrator = "{method}"', **upper)), 2.5)
                    floor, between = pairs["floor", "lower"], pairs["lower", "upper"]
                    self.assertAlmostEqual(floor["fz_N"], -0.3 * GRAVITY, delta=0.01 * 0.3 * GRAVITY)
                    self.assertAlmostEqual(between["fz_N"], -0.1 * GRAVITY, delta=0.01 * 0.1 * GRAVITY)
                    self.assertAlmostEqual(between["z_m"], 0.04, delta=2e-3)
                    for pair in (floor, between):
                        self.assertAlmostEqual(pair["x_m"], 0.1, delta=1e-3)
                        self.assertLess(abs(pair["fx_N"]) + abs(pair["fy_N"]), 0.01)
                        self.assertLess(max(abs(pair[f"t{axis}_N_m"]) for axis in "xyz"), 1e-3)
                        self.assertGreaterEqual(pair["contacts"], 4)

    def test_a_tool_presses_through_a_body(self):
        scene = self.write("press.toml", SCENE.format(method="", **BOX).replace("[0.1, 0.0,", "[0.0, 0.0,"))
        log = self.folder / "contacts.csv"
        path = self.write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,0.02\n1,0,0,-0.001\n2,0,0,-0.001\n")
        self.run_lockstep(scene, f"replay:file={path}", 2.0, sim=("--contacts", log))
        pairs = rows_of(log)
        pressed_N = pairs["upper", "(tool)"]["fz_N"]
        self.assertLess(pressed_N, -1.0)
        self.assertAlmostEqual(pairs["lower", "upper"]["fz_N"], pressed_N - 0.1 * GRAVITY, delta=0.02 * abs(pressed_N))
        self.assertAlmostEqual(pairs["floor", "lower"]["fz_N"], pressed_N - 0.3 * GRAVITY, delta=0.02 * abs(pressed_N))

    def test_a_file_that_cannot_be_written_is_a_line_and_loses_no_other(self):
        scene, state = self.write("s.toml", SCENE.format(method="", **BOX)), self.folder / "state.csv"
        for log in (self.folder, scene, "/nowhere/contacts.csv", "", "/dev/full"):
            with self.subTest(log=log):
                ended = subprocess.run([BUILD / "bin" / "sim_server", "--scene", scene, "--offline", "--duration", "1",
                                        "--contacts", log, "--final-state", state], capture_output=True, text=True)
                self.assertEqual(ended.returncode, BAD_INPUT, ended.stderr)
                self.assertEqual(len(ended.stderr.splitlines()), 1, ended.stderr)
                self.assertEqual(state.exists(), log == "/dev/full")
        self.assertIn("[[body]]", scene.read_text())

    def test_two_outputs_in_one_file_are_refused(self):
        scene = self.write("s.toml", SCENE.format(method="", **BOX))
        ended = subprocess.run([BUILD / "bin" / "sim_server", "--scene", scene, "--offline", "--duration", "1",
                                "--contacts", "x.csv", "--final-state", "./x.csv"], capture_output=True, text=True,
                               cwd=self.folder)
        self.assertEqual(ended.returncode, BAD_INPUT, ended.stderr)


if __name__ == "__main__":
    unittest.main()
