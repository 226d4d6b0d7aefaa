#!/usr/bin/python3
"""The commands of docs/tutorials do what the pages say, in their order."""
import pathlib
import sys
import tempfile
import unittest

import daemons

sys.path.append(str(daemons.ROOT / "scripts" / "pages"))
import tutorials

MUJOCO = pathlib.Path("/usr/include/mujoco/mujoco.h")


class TutorialTest(unittest.TestCase):
    def do(self, page, *made):
        """What a page's commands print; made: files of build/mine that stand there then, none empty."""
        folder = tempfile.TemporaryDirectory(prefix="stillgrid-test-")
        self.addCleanup(folder.cleanup)
        self.mine = pathlib.Path(folder.name) / "build/mine"
        status, printed = tutorials.run(page, folder.name, daemons.BUILD)
        self.assertEqual(status, 0, printed)
        for file in made:
            self.assertGreater((self.mine / file).stat().st_size, 0, file)
        for picture in tutorials.pictures(page):
            self.assertGreater(tutorials.picture_of(folder.name, picture).stat().st_size, 10_000, picture)
        return printed

    def force_N(self, recording):
        """The vertical force of a recording of build/mine, by tick."""
        return daemons.read_recording(self.mine / recording)["fz_N"]

    def test_a_first_scene_is_felt_drawn_and_its_slip_told(self):
        printed = self.do("first_scene", "first.csv", "hand.csv", "organ_felt.csv")
        self.assertRegex(printed, r"wrong\.toml:\d+:\d+: .*radius")
        for felt in ("first.csv", "ball.csv", "hand.csv", "organ_felt.csv"):
            self.assertGreater(self.force_N(felt).max(), 0.2, felt)

    def test_a_first_device_is_built_checked_and_felt(self):
        printed = self.do("first_device", "handle.csv")
        self.assertIn("FAIL read.believed", printed)
        self.assertIn("option rest_z_m=-30", printed)
        rest = daemons.read_recording(self.mine / "handle.csv")
        self.assertAlmostEqual(rest["fz_N"][-1], 50.0 * (rest["z_m"][-1] + 0.01), delta=0.01)  # its spring holds
        self.assertGreater(rest["fz_N"][-1], 0.5)

    def test_the_pieces_of_the_first_device_are_the_example_that_is_installed(self):
        files = tutorials.files("first_device")
        example = daemons.ROOT / "tests/install/handle"
        self.assertEqual(files["build/mine/handle/handle.c"], (example / "handle.c").read_text())
        self.assertEqual(files["build/mine/handle/CMakeLists.txt"], (example / "CMakeLists.txt").read_text())

    def test_a_replay_fails_where_the_page_says(self):
        printed = self.do("replay_in_ci", "expected.csv.gz", "verdict.xml")
        self.assertIn("equal: byte for byte", printed)
        self.assertIn("DIFFERENT", printed)

    def test_a_scene_is_fitted_to_its_hand(self):
        self.do("fit_a_scene", "ball_fit/ball_fitted.toml")

    def test_a_model_of_MuJoCo_is_felt(self):
        if not MUJOCO.exists():
            self.skipTest(f"skipped: {MUJOCO} is not installed, see scripts/setup")
        self.do("publish_from_mujoco")
        self.assertGreater(self.force_N("heavy.csv").max(), self.force_N("mujoco.csv").max())
        self.assertGreater(self.force_N("mujoco.csv").max(), 0.2)

    def test_every_page_is_done_by_a_test(self):
        text = pathlib.Path(__file__).read_text()
        self.assertEqual([page for page in tutorials.names() if f'self.do("{page}"' not in text], [])


if __name__ == "__main__":
    daemons.main()
