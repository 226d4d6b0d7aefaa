#!/usr/bin/python3
"""scripts/scene_fit as its users run it: what it chooses, what it writes, that it goes on where it was."""
import json
import os
import subprocess
import sys
import tomllib

import daemons

sys.path.append(str(daemons.ROOT / "scripts" / "fit"))
import levels

FITTED, MISSED, COULD_NOT_RUN = 0, 1, 2
SCENE_FIT = daemons.ROOT / "scripts" / "scene_fit"
# A ball that goes to and fro below a hand. By CVODE it is not local: the rate makes the force err.
SCENE = """# a ball
format = 2
[simulation]
integrator = "cvode_bdf"
period_s = 0.1  # 10 Hz
[[material]]
name = "ball"
contact_stiffness_N_per_m = 310.0
[[body]]
name = "ball"
kind = "sphere"
motion = "prescribed"
position_m = [0.0, 0.0, -0.13]
direction = [0.0, 0.0, 1.0]
amplitude_m = 0.004
frequency_hz = 4.3
radius_m = 0.13  # large
material = "ball"
"""
HAND = "time_s,x_m,y_m,z_m\n" + "".join(f"{0.01 * i},0,0,{0.0005 + 0.00001 * i}\n" for i in range(91))


class SceneFitTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        self.hand = self.write("hand.csv", HAND)
        self.scene = self.write("ball.toml", SCENE)
        self.out = self.folder / "fit"
        (self.folder / "without").mkdir()
        (self.folder / "without" / "matplotlib.py").write_text("raise ImportError('no matplotlib')\n")

    def fit(self, *arguments, hand=True, draws=False):
        """draws: or else there is no matplotlib, which saves a second."""
        paths = {} if draws else {"PYTHONPATH": str(self.folder / "without")}
        of_hand = ["--trajectory", self.hand] if hand else []
        return subprocess.run(["/usr/bin/python3", SCENE_FIT, self.scene, *of_hand, "--build", daemons.BUILD, "--grid",
                               "small", "--out", self.out, *map(str, arguments)], cwd=self.folder, check=False,
                              capture_output=True, text=True, timeout=200 * daemons.PATIENCE,
                              env={**os.environ, **paths})

    def fitted(self, *arguments, status=FITTED, **options):
        run = self.fit(*arguments, **options)
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        return json.loads((self.out / "fit.json").read_text()), run

    def test_the_cheapest_within_the_tolerance_is_taken_and_only_its_values_change(self):
        answer, run = self.fitted("--force-error", "0.3", "--check", self.write("again.csv", HAND), draws=True)
        choice, given = answer["choice"], answer["given"]
        self.assertTrue(answer["fits"])
        self.assertLessEqual(choice["error_share"], 0.3)
        self.assertGreater(given["error_share"], 0.3)
        self.assertTrue(choice["stable"])
        self.assertEqual(answer["check"]["error_share"], choice["error_share"])
        for row in answer["runs"]:
            if row["cost_us_per_ms"] < choice["cost_us_per_ms"]:
                self.assertNotEqual(row["verdict"], "fits", row)
        self.assertEqual(self.scene.read_text(), SCENE)
        text = (self.out / "ball_fitted.toml").read_text()
        for line in ("# a ball", "radius_m = 0.13  # large", f"rate_hz = {choice['rate_hz']}  # 10 Hz"):
            self.assertIn(line + "\n", text)
        self.assertIn(f"haptic_server --transition {choice['transition']}\n", text)
        expected = tomllib.loads(SCENE)
        expected["simulation"] = tomllib.loads(text)["simulation"]
        self.assertEqual(tomllib.loads(text), expected)
        self.assertIn(f"{100 * choice['error_share']:.3g} %", run.stdout)
        self.assertTrue((self.out / "fit.png").is_file())
        self.assertEqual((self.out / "runs.csv").read_text().count("\n"), len(answer["runs"]) + 1)

        # The same command again judges nothing anew.
        before = [file.read_text() for file in self.out.glob("inputs/records.jsonl")]
        again, _ = self.fitted("--force-error", "0.3", "--check", self.folder / "again.csv")
        self.assertEqual(again, answer)
        self.assertEqual([file.read_text() for file in self.out.glob("inputs/records.jsonl")], before)

    def test_where_nothing_keeps_to_the_tolerance_the_closest_is_written(self):
        answer, run = self.fitted("--force-error", "0.001%", status=MISSED)
        self.assertFalse(answer["fits"])
        self.assertRegex(run.stdout.splitlines()[-1], "^MISSED: errs by .*: the closest is shown$")
        self.assertIn("# It FAILS: errs by", (self.out / "ball_fitted.toml").read_text())
        least = min(row["error_share"] for row in answer["runs"] if row["error_share"] is not None)
        self.assertEqual(answer["choice"]["error_share"], least)

    def test_without_a_trajectory_the_scenes_own_hand_is_taken(self):
        self.scene.write_text(SCENE + '[hand]\nfile = "hand.csv"\nsettle_s = 0.5\n')
        answer, _ = self.fitted("--force-error", "0.5", hand=False)
        self.assertEqual((answer["trajectory"], answer["settle_s"]), ("hand.csv", 0.5))
        own = tomllib.loads((self.out / "ball_fitted.toml").read_text())["hand"]["file"]
        self.assertEqual((self.out / own).resolve(), self.hand.resolve())

    def test_bad_input_is_refused_in_one_line(self):
        nowhere = self.write("nowhere.csv", "time_s,x_m,y_m,z_m\n0,0,0,1\n0.1,0,0,1\n")
        for arguments, words in ((("--force-error", "5"), "expected a share of the force"),
                                 (("--margin", "17"), "expected a factor from 0.01 to 16"),
                                 (("--device", "x"), "--device"),
                                 (("--trajectory", self.folder / "none.csv"), "none.csv"),
                                 (("--build", self.folder), "expected scripts/build")):
            with self.subTest(arguments=arguments):
                run = self.fit(*arguments)
                self.assertEqual(run.returncode, COULD_NOT_RUN, run.stdout + run.stderr)
                self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
                self.assertIn(words, run.stderr)
        self.hand = nowhere
        self.assertIn("the hand touches nothing", self.fit().stderr)
        self.scene.write_text(SCENE + "wrong = 1\n")
        run = self.fit()
        self.assertEqual((run.returncode, len(run.stderr.splitlines())), (COULD_NOT_RUN, 1), run.stderr)
        self.assertIn("body.wrong", run.stderr)

    def test_a_coarser_level_has_fewer_spheres_as_stiff_as_before(self):
        sheet = {"name": "s", "kind": "sheet", "size_m": [0.1, 0.1], "nodes": [11, 11],
                 "spheres": {"spacing_m": 0.01, "radius_m": 0.0065}}
        exact = {"name": "e", "kind": "rigid_box", "size_m": [0.06, 0.06, 0.03]}
        box = {**exact, "name": "b", "spheres": {}}
        mesh = {"name": "m", "kind": "mesh", "spheres": {"tolerance_m": 0.002}}
        told = []
        groups = levels.groups_of({"body": [sheet, {**sheet, "name": "t", "position_m": [1, 0, 0]}, exact, box, mesh,
                                            {"name": "p", "kind": "plane"}, {"name": "n", "kind": "new"}]}, told.append)
        self.assertEqual([names for names, _ in groups], [["s", "t"], ["b"], ["m"]])
        label, changes = groups[0][1][2]
        self.assertEqual(label, "spheres 20 mm apart")
        self.assertEqual(changes, {"spheres": {"spacing_m": 0.02, "radius_m": 0.0065}})
        self.assertEqual(groups[1][1][1][0], "spheres 14.1 mm apart")  # a box's radius is a sixth of its longest side
        self.assertEqual(groups[2][1][1], ("spheres within 3 mm", {"spheres": {"tolerance_m": 0.003}}))
        self.assertEqual(told, ["n: left as it is: of the kind new no coarser spheres are known"])


if __name__ == "__main__":
    daemons.main()
