#!/usr/bin/python3
"""scripts/scene_fit as its users run it: what it writes, that it goes on where it was, that machines may share it."""
import contextlib
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import tomllib
import unittest.mock

import daemons
import fake_fit_run
from skin_scene import SCENE, assert_is, candidates, cheapest

sys.path.append(str(daemons.ROOT / "scripts" / "fit"))
import runs  # after the path it needs

FITTED, MISSED, COULD_NOT_RUN, STOPPED = 0, 1, 2, 130
SCENE_FIT = daemons.ROOT / "scripts" / "scene_fit"


class SceneFitTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        self.hand = self.write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,-0.01\n")
        self.scene = self.write("skin.toml", SCENE)
        self.build = self.folder / "build"
        (self.build / "bin").mkdir(parents=True)
        for name, source in (("fit_run", fake_fit_run.__file__), ("sphere_decompose", "/bin/false")):
            shutil.copy(source, self.build / "bin" / name)
            (self.build / "bin" / name).chmod(0o755)
        (self.folder / "without").mkdir()
        (self.folder / "without" / "matplotlib.py").write_text("raise ImportError('no matplotlib')\n")
        self.out = self.folder / "fit"

    def command(self, *arguments, scene=None, hand=None, build=None, program=SCENE_FIT):
        """program: one that is installed finds its build itself."""
        of_build = ["--build", build or self.build] if program == SCENE_FIT else []
        of_hand = [] if hand is False else ["--trajectory", hand or self.hand]
        return ["/usr/bin/python3", program, scene or self.scene, *of_hand, *of_build,
                "--out", self.out, "--grid", "small", "--jobs", "2", *map(str, arguments)]

    def fit(self, *arguments, draws=False, environment=(), **inputs):
        """draws: or else there is no matplotlib, which saves a second."""
        paths = {} if draws else {"PYTHONPATH": str(self.folder / "without")}
        return subprocess.run(self.command(*arguments, **inputs), cwd=self.folder, capture_output=True, text=True,
                              timeout=100 * daemons.PATIENCE, check=False, env={**os.environ, **paths, **dict(environment)})

    def fitted(self, *arguments, status=FITTED, **inputs):
        """fit.json of a fit."""
        run = self.fit(*arguments, **inputs)
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        return json.loads((self.out / "fit.json").read_text()), run

    def logged(self):
        """The arguments of all runs."""
        log = self.build / "bin" / "runs.log"
        return log.read_text().splitlines() if log.exists() else []

    def kept(self):
        return {json.loads(file.read_text())["arguments"] for file in (self.out / "runs").glob("*.json")}

    def assert_is(self, one, expected):
        assert_is(self, one, expected)

    def test_the_cheapest_within_the_tolerance_is_found_and_only_its_values_change(self):
        answer, run = self.fitted("--check", self.write("far.csv", self.hand.read_text()), status=MISSED)
        best = cheapest(0.05)
        self.assert_is(answer["choice"], best)
        self.assert_is(answer["given"], next(one for one in candidates() if one[2:] == (50.0, "predict", 0.01)))
        cheaper = answer["next_cheaper"]
        self.assertLess(cheaper["cost_us_per_ms"], best[0])
        self.assertRegex(cheaper["verdict"], "^errs by ")
        self.assertTrue(answer["fits"])  # but not on the other hand, on which all err by a half more
        self.assertAlmostEqual(answer["check"]["choice"]["error_share"], best[1] + 0.5)
        self.assertRegex(run.stdout.splitlines()[-1], "^MISSED: on far.csv, which the fit did not see: errs by 5")
        self.assertRegex(run.stderr, r"\Ascene_fit: warning: .*far.csv: the reference differs by .* at 2 kHz")
        self.assertIn(f"{100 * best[1]:.3g} %", run.stdout)
        self.assertIn(f'skin_fitted.toml --haptic "--transition {best[3]}"\n', run.stdout)
        # The file: all lines of the user's, but for the two that hold what was fitted.
        text = (self.out / "skin_fitted.toml").read_text()
        self.assertEqual(self.scene.read_text(), SCENE)
        lines = [line for line in SCENE.splitlines() if line not in text.splitlines()]
        self.assertEqual(lines, ["period_s = 0.02  # 50 Hz",
                                 "spheres = { spacing_m = 0.01, radius_m = 0.0065 }  # even"])
        self.assertIn(f"rate_hz = {best[2]}  # 50 Hz\n", text)
        self.assertIn(f"haptic_server --transition {best[3]}\n", text)
        expected = tomllib.loads(SCENE)
        del expected["simulation"]["period_s"]
        expected["simulation"]["rate_hz"] = best[2]
        expected["body"][0]["spheres"]["spacing_m"] = best[4]
        expected["body"][0]["stiffness_scale"] = float(f"{(fake_fit_run.actual_m(best[4]) / 0.01) ** 2:.6g}")
        self.assertEqual(tomllib.loads(text), expected)

    def test_without_a_trajectory_the_scenes_own_hand_is_taken(self):
        (self.folder / "sub").mkdir()
        self.write("sub/own.csv", self.hand.read_text())
        self.scene.write_text(SCENE + '[hand]\nfile = "sub/own.csv"\nsettle_s = 1.5\n')
        answer, _ = self.fitted(hand=False)
        self.assertEqual((answer["trajectory"], answer["settle_s"]), ("own.csv", 1.5))
        self.assert_is(answer["choice"], cheapest(0.05))
        fitted = tomllib.loads((self.out / "skin_fitted.toml").read_text())["hand"]["file"]
        self.assertEqual((self.out / fitted).resolve(), (self.folder / "sub/own.csv").resolve())

    def test_a_fit_that_was_stopped_goes_on_where_it_was(self):
        (self.build / "bin" / "slow").touch()
        first = self.start(*self.command())
        self.wait_until(lambda: len(self.kept()) >= 5, 30, "five runs")
        first.signal(signal.SIGINT)
        self.assertEqual(first.wait(10), STOPPED)
        self.assertEqual(first.lines(), ["scene_fit: stopped: the same command goes on from here"])
        (self.build / "bin" / "slow").unlink()
        before, kept = len(self.logged()), self.kept()
        self.assertEqual(list(self.out.glob("**/*.part*")), [])
        self.fitted()
        after = self.logged()[before:]
        self.assertLessEqual(len(after), len(set(after)) + 2)  # what was under way may have begun after the stop
        self.assertEqual(set(after) & kept, set())
        self.assertEqual(set(after) | kept, self.kept())
        before = len(self.logged())
        self.fitted()
        self.assertEqual(len(self.logged()), before)
        self.scene.write_text(SCENE + "# more\n")  # another scene: all anew, "as given" first
        self.assertEqual(len(self.fit("--print-runs").stdout.splitlines()), 1)

    def runs_of(self, folder, **machines):
        """In a fit's folder that holds what the fake reads."""
        (folder / "inputs").mkdir(parents=True)
        for name, text in (("skin.toml", SCENE), ("hand.csv", ""), ("ref.csv", "")):
            (folder / "inputs" / name).write_text(text)
        return runs.Runs(folder, runs.Machines(str(self.build / "bin/fit_run"), **machines), runs.Progress())

    @staticmethod
    def requests(*settings):
        files = ("inputs/skin.toml", "inputs/hand.csv", "inputs/ref.csv")
        return [(("inputs/skin.toml", "--trajectory", "inputs/hand.csv", "--reference", "inputs/ref.csv", "--set",
                  setting), files) for setting in settings]

    def test_machines_that_share_no_folder_are_sent_what_they_read(self):
        """ssh is one that changes into another home, for a user whose shell runs nothing."""
        home, away = self.folder / "home", self.folder / "away"
        ssh = self.write("ssh", "#!/bin/sh\nwhile :; do case \"$1\" in -l|-p|-S|-o) shift 2;; -*) shift;; *) break;; "
                         f"esac; done\nshift\n[ \"$1\" = -- ] && shift\nexport HOME={away}\ncd \"$HOME\"\n"
                         "exec sh -c \"$*\"\n")
        ssh.chmod(0o755)
        shutil.copytree(self.build / "bin", away / "bin")
        there = self.runs_of(home / "fit", sshlogin="2/elsewhere", ssh=str(ssh),
                             remote_program=str(away / "bin/fit_run"))
        requests = self.requests("simulation.rate_hz=10.0", "simulation.rate_hz=20.0")
        with unittest.mock.patch.dict(os.environ, HOME=str(home), SHELL="/bin/false"):
            results = there.results("there", requests)
        self.assertTrue((away / "fit/inputs/skin.toml").is_file())
        self.assertEqual(self.logged(), [])
        shutil.rmtree(home)
        self.assertEqual(results, self.runs_of(home / "fit").results("here", requests))

    def test_a_run_that_is_refused_is_kept_and_one_that_crashes_is_tried_again(self):
        one = self.runs_of(self.folder / "fit")
        requests = self.requests("simulation.rate_hz=10.0", "simulation.integrator=refuse", "simulation.integrator=crash")
        for runs_more in (3, 1):
            before = len(self.logged())
            good, refused, crashed = one.results("all", requests)
            self.assertEqual(len(self.logged()), before + runs_more)
            self.assertEqual(good["settings"], {"latency_share": 0.1})
            self.assertEqual(refused, {"refused": "no such integrator"})
            self.assertEqual(crashed, {"crashed": "fit_run: broken"})

    def test_what_keeps_a_run_from_starting_stops_the_fit_and_is_not_held_against_the_candidate(self):
        one = self.runs_of(self.folder / "fit")
        requests = self.requests("simulation.rate_hz=10.0", "simulation.integrator=implicit_euler", "simulation.integrator=velocity_verlet")
        full = self.build / "bin" / "full"
        full.touch()
        with self.assertRaisesRegex(runs.Unusable, "^/tmp: no space left$"):
            one.results("all", requests)
        self.assertEqual(len(self.logged()), 3)
        full.unlink()
        for result in one.results("all", requests):
            self.assertEqual(result["problems"], [])
        self.assertEqual(len(self.logged()), 5)  # the first was kept

    def test_a_run_depends_on_the_plugins_that_it_loads(self):
        devices = self.build / "lib/stillgrid/devices"
        devices.mkdir(parents=True)
        one, request = self.runs_of(self.folder / "fit"), self.requests("simulation.rate_hz=10.0")[0]
        keys = {one.key(*request)}
        for name in ("phantom.so", "replay.so"):
            (devices / name).write_text(name)
            keys.add(one.key(*request))
        (devices / "other.so").write_text("another")
        keys.add(one.key(*request))
        self.assertEqual(len(keys), 3)

    def test_a_printed_run_that_is_refused_is_not_printed_again(self):
        one = self.runs_of(self.folder / "fit", print_only=True)
        requests = self.requests("simulation.integrator=refuse", "simulation.integrator=crash")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed), self.assertRaises(runs.Printed):
            one.results("all", requests)
        subprocess.run(["sh"], input=printed.getvalue(), text=True, check=False, stderr=subprocess.DEVNULL)
        self.assertEqual(one.results("all", requests[:1]), [{"refused": "refused where it was run"}])
        with contextlib.redirect_stdout(io.StringIO()), self.assertRaisesRegex(runs.Printed, "1 runs to do"):
            one.results("all", requests)

    def test_printed_runs_are_taken_up_when_somebody_has_run_them(self):
        for _ in range(20):
            run = self.fit("--print-runs")
            self.assertEqual(run.returncode, FITTED, run.stderr)
            if (self.out / "fit.json").exists():
                break
            before = len(self.logged())
            subprocess.run(["sh", "-c", run.stdout], check=True)
            self.assertEqual(len(self.logged()), before + len(run.stdout.splitlines()))
            self.assertNotIn("--repeats", run.stdout)  # times that are compared: only here
        self.assert_is(json.loads((self.out / "fit.json").read_text())["choice"], cheapest(0.05))

    def test_what_cannot_be_fitted_is_refused_in_one_line(self):
        broken = self.write("broken.toml", SCENE + "[")
        for words, arguments, inputs in (
                ("--force-error: value 'much'", ("--force-error", "much"), {}),
                ("--force-error: value '5'", ("--force-error", "5"), {}),  # per cent, or 500 %?
                ("--margin: value '-1'", ("--margin", "-1"), {}),
                ("--device: invalid choice: 'toy'", ("--device", "toy"), {}),
                ("--trajectory: expected it, or the table [hand]", (), {"hand": False}),
                ("nothing: no such scene", (), {"scene": "nothing"}),
                ("broken.toml: ", (), {"scene": broken}),
                (r"'inputs/ha\tnd.csv': expected printable", (), {"hand": self.write("ha\tnd.csv", "t_s,x_m\n")}),
                ("absent.csv: no such file", (), {"hand": "absent.csv"}),
                ("expected scripts/build to have run", (), {"build": self.folder})):
            with self.subTest(words):
                run = self.fit(*arguments, **inputs)
                self.assertEqual(run.returncode, COULD_NOT_RUN, run.stdout + run.stderr)
                self.assertRegex(run.stderr, r"\Ascene_fit: .*\n\Z")
                self.assertIn(words, run.stderr)
                self.assertFalse(self.out.exists())

    def test_installed_it_fits_a_real_scene_and_the_fitted_file_gives_the_very_forces(self):
        """A sphere that comes at 0.1 m/s: a snapshot that is held is late by its age, the answer is not. It leaves the
        hand that stays, so that stability cannot be tested."""
        prefix = self.folder / "prefix"
        subprocess.run(["cmake", "--install", daemons.BUILD, "--prefix", prefix, "--component", "scene_fit"],
                       check=True, stdout=subprocess.DEVNULL)
        (prefix / "lib").symlink_to(daemons.BUILD / "lib")
        hand = self.write("ride.csv", "t_s,x_m,y_m,z_m\n0,-0.039,0,0\n0.6,0.021,0,0\n")
        answer, run = self.fitted(scene=daemons.SCENES / "moving_sphere.toml", hand=hand,
                                  program=prefix / "bin" / "scene_fit", draws=True, status=MISSED)
        self.assertEqual(answer["choice"]["verdict"], "stability not tested: the hand that presses touches nothing")
        self.assertEqual(answer["choice"]["transition"], "predict")
        held = [row for row in answer["runs"] if row["transition"] == "hold" and row["rate_hz"] == 10.0]
        self.assertGreater(held[0]["error_share"], 0.05)
        self.assertEqual((self.out / "fit.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        rate_hz = tomllib.loads((self.out / "moving_sphere_fitted.toml").read_text())["simulation"].get("rate_hz")
        self.assertIn(rate_hz, (answer["choice"]["rate_hz"], None))  # none: as given, by its period
        self.assertIn("written: ", run.stdout)


if __name__ == "__main__":
    daemons.main()
