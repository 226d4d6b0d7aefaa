#!/usr/bin/python3
"""fit_run: one command line, one line of JSON, the same by settings as by a file with those values."""
import json
import math
import os
import shutil
import subprocess

import daemons
from daemons import BAD_INPUT, COULD_NOT_START, DONE

PROGRAM = daemons.BUILD / "bin" / "fit_run"
SCENE = daemons.SCENES / "moving_sphere.toml"


def ride(duration_s):
    """Goes with the sphere of moving_sphere, pressed by 5 to 9 mm."""
    rows = ["time_s,x_m,y_m,z_m"]
    for i in range(round(1e3 * duration_s)):
        t = 1e-3 * i
        rows.append(f"{t},{-0.05 + 0.1 * t + 0.015 - 0.007 - 0.002 * math.sin(6.0 * t)},0,0")
    return "\n".join(rows) + "\n"


def without_times(line):
    """The JSON, but for what no two runs have in common."""
    result = json.loads(line)
    del result["cost"], result["settings"]["set"], result["settings"]["scene"]
    return result


class FitRunTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        self.hand = self.write("hand.csv", ride(1.2))
        self.reference = self.folder / "ref.csv"

    def run_program(self, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=60 * daemons.PATIENCE)

    def results(self, *arguments):
        """The one line of a run that is done."""
        done = self.run_program(*arguments)
        self.assertEqual((done.returncode, done.stderr), (DONE, ""))
        self.assertEqual(done.stdout.count("\n"), 1)
        return done.stdout

    def write_reference(self):
        return self.results("moving_sphere", "--trajectory", self.hand, "--write-reference", self.reference)

    def candidate(self, *arguments, scene=SCENE):
        return self.results(scene, "--trajectory", self.hand, "--reference", self.reference,
                            "--latency-share", 0.1, *arguments)

    def test_a_reference_says_what_it_is_and_has_its_worlds_beside_it(self):
        result = json.loads(self.write_reference())
        self.assertTrue((self.folder / "ref.state.csv").is_file())
        self.assertEqual(result["settings"]["method"], "implicit_euler")
        self.assertAlmostEqual(result["reference"]["contact_share"], 1.0)
        self.assertGreater(result["reference"]["force_rms_N"], 3.0)
        self.assertEqual(result["problems"], [])

    def test_settings_and_a_file_with_those_values_come_to_the_same_but_for_times(self):
        self.write_reference()
        text = SCENE.read_text().replace("period_s = 0.033", "rate_hz = 40.5")
        edited = self.write("moving_sphere.toml", text.replace("friction = 0.0", "friction = 0.25"))
        by_file = self.candidate("--transition", "linear", "--margin", 2, scene=edited)
        by_settings = self.candidate("--transition", "linear", "--margin", 2, "--set", "simulation.rate_hz=40.5",
                                     "--set", "material.elastic.friction=0.25")
        self.assertEqual(without_times(by_file), without_times(by_settings))
        self.assertGreater(json.loads(by_file)["error"]["share"], 0.1)
        self.assertNotEqual(without_times(by_file), without_times(self.candidate("--transition", "linear")))

    def test_the_latency_that_was_measured_is_named_so_that_the_run_can_be_repeated(self):
        self.write_reference()
        arguments = ["moving_sphere", "--trajectory", self.hand, "--reference", self.reference, "--transition", "hold"]
        measured = self.results(*arguments)
        share = json.loads(measured)["settings"]["latency_share"]
        self.assertEqual(without_times(measured), without_times(self.results(*arguments, "--latency-share", share)))

    def test_stability_without_a_contact_is_a_problem(self):
        self.write_reference()
        held = json.loads(self.candidate("--margin", 2, "--search-margin", "--set", "body.sphere.velocity_m_s=[0.1, 0.0, 0.0]"))
        self.assertEqual(held["problems"], ["stability not tested: the hand that presses touches nothing"])
        self.assertEqual((held["stability"]["stable"], held["stability"]["largest_margin"]), (None, None))
        self.assertEqual(held["stability"]["contact_share"], 0.0)

    def test_a_machine_at_fault_is_not_bad_input(self):
        self.write_reference()
        alone = self.folder / "alone" / "fit_run"  # without its plugins
        alone.parent.mkdir()
        shutil.copy(PROGRAM, alone)
        arguments = [SCENE, "--trajectory", self.hand, "--reference", self.reference, "--latency-share", "0",
                     "--margin", "1"]
        for program, environment, word in [
                (PROGRAM, {"TMPDIR": self.folder / "none"}, "$TMPDIR"),
                (alone, {"STILLGRID_DEVICE_PATH": ""}, "device: value 'replay'")]:
            with self.subTest(word):
                done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=60 * daemons.PATIENCE,
                                      env={**os.environ, **environment})
                self.assertEqual((done.returncode, done.stdout), (COULD_NOT_START, ""), done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                self.assertIn(word, done.stderr)

    def test_bad_input_is_one_line_and_writes_nothing(self):
        self.write_reference()
        candidate = ["--trajectory", self.hand, "--reference", self.reference]
        for arguments, *words in [
                (["nowhere", *candidate], "SCENE: value 'nowhere'"),
                ([SCENE, "--trajectory", self.hand], "--reference: value 'missing'"),
                ([SCENE, "--trajectory", self.folder / "none.csv", "--reference", self.reference], "none.csv"),
                ([SCENE, "--trajectory", self.folder / "a,b.csv", "--reference", self.reference], "without a comma"),
                ([SCENE, "--trajectory", self.hand, "--reference", self.folder / "none.csv"], "none.csv"),
                ([SCENE, "--trajectory", self.hand, "--reference", self.folder], f"{self.folder}: expected a file"),
                ([SCENE, *candidate, "--set", "simulation.speed=3"], "--set", "simulation.speed"),
                ([SCENE, *candidate, "--transition", "jump"], "--transition: value 'jump'"),
                ([SCENE, *candidate, "--latency-share", "2"], "--latency-share: value '2'"),
                ([SCENE, *candidate, "--device", "pen", "--margin", "2"], "--device: value 'pen'"),
                ([SCENE, *candidate, "--settle", "1"], "--settle: value '1"),
                ([SCENE, *candidate, "--replay", "scale=none"], "scale"),
                ([SCENE, *candidate, "--replay", "offset_x_m=1"], "elsewhere"),
                (["organ", *candidate], "ref.state.csv:2:"),
                ([SCENE, "--trajectory", self.hand, "--write-reference", self.folder / "no/ref.csv"], "no/ref.csv")]:
            with self.subTest(words[0]):
                done = self.run_program(*arguments)
                self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, ""), done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                for word in ("fit_run: ", *words):
                    self.assertIn(word, done.stderr)
        self.assertEqual(sorted(file.name for file in self.folder.iterdir()),
                         ["hand.csv", "ref.csv", "ref.state.csv"])


if __name__ == "__main__":
    daemons.main()
