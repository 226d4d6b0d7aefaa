#!/usr/bin/python3
"""scripts/replay_check says where forces first differ, and by its exit status whether they do."""
import pathlib
import random
import re
import subprocess

import numpy

import daemons
import replays
from replays import DIFFERENT, EQUAL
import forces  # after replays, by which it is found

DURATION_S = 0.4


def left_behind():
    """Segments of a replay_check that has ended: others may run beside this test."""
    return [file for file in daemons.SHM.glob("replay-check-*")
            if not pathlib.Path("/proc", re.match(r"replay-check-(\d+)", file.name)[1]).exists()]


class ReplayCheckTest(replays.ReplayTest):
    def test_an_axis_of_force_that_is_not_expected_is_told(self):
        self.write_expected()
        self.expected.write_text(self.expected.read_text().replace("fz_N", "fz_mN", 1))
        run = self.check()
        self.assert_says(run, EQUAL, f"warning: fz_N is not in {self.expected}: its ")
        self.assertNotIn("fx_N is not", run.stdout)

    def replace_field(self, recording, line, name, value):
        """EXPECTED with one field changed; lines count from one."""
        lines = recording.read_text().split("\n")
        header = next(text for text in lines if not text.startswith("#")).split(",")
        fields = lines[line - 1].split(",")
        fields[header.index(name)] = value
        lines[line - 1] = ",".join(fields)
        return self.write("changed.csv", "\n".join(lines))

    def test_the_same_scene_and_hand_give_the_same_bytes(self):
        self.write_expected()
        self.assertEqual(daemons.read_recording(self.expected).metadata["scene"], "wall")  # beside it
        self.assert_says(self.check(), EQUAL, "equal: byte for byte, 401 rows")
        self.assertFalse((self.folder / "replay_check.png").exists())
        self.assertEqual([], left_behind())

    def test_another_stiffness_differs_from_the_first_contact_on(self):
        expected = self.write_expected()
        first = int((expected["contacts"] > 0).argmax())
        run = self.check(self.stiffer_wall(), "--tolerance", "1e-9", draws=True)
        self.assert_says(run, DIFFERENT, "DIFFERENT", "picture: replay_check.png")
        told = re.search(r"first difference: at ([\d.]+) s, fz_N: expected (\S+) N, got (\S+) N", run.stdout)
        self.assertAlmostEqual(float(told[1]), expected["time_s"][first])
        self.assertAlmostEqual(float(told[2]), expected["fz_N"][first], places=5)
        self.assertAlmostEqual(float(told[3]) / float(told[2]), 1.1, places=3)
        picture = (self.folder / "replay_check.png").read_bytes()
        self.assertEqual(picture[:8], b"\x89PNG\r\n\x1a\n")

    def test_what_differs_by_no_more_than_the_tolerance_is_equal(self):
        most_N = 0.1 * self.write_expected()["fz_N"].max()  # the stiffer wall gives a tenth more
        scene = self.stiffer_wall()
        self.assert_says(self.check(scene, "--tolerance", 1.001 * most_N), EQUAL,
                         "equal within the tolerance", "; 0 rows beyond")
        self.assert_says(self.check(scene, "--tolerance", 0.999 * most_N), DIFFERENT)

    def test_a_hand_that_moved_elsewhere_is_told_before_its_forces(self):
        self.write_expected()
        run = self.check("wall", "--replay", "offset_z_m=-0.001")
        self.assert_says(run, DIFFERENT, "first difference: at")
        self.assertTrue(run.stdout.startswith("positions differ first: at 0.0000 s, z_m: expected 0.01 m"),
                        run.stdout)

    def test_an_expectation_that_was_cut_off_is_not_equal(self):
        self.write_expected()
        self.expected.write_bytes(self.expected.read_bytes()[:30_000])
        self.assert_says(self.check(), DIFFERENT, "lengths differ: ", "0 rows beyond",
                         "no picture: no matplotlib")

    def test_one_wrong_number_is_found(self):
        time_s = self.write_expected()["time_s"]
        line = 1 + 101  # the 101st row below the header
        changed = self.replace_field(self.expected, line, "fy_N", "0.5")
        run = self.check(expected=changed)
        self.assert_says(run, DIFFERENT, f"first difference: at {time_s[100]:.4f} s, fy_N: expected 0.5 N, "
                         "got 0 N, difference -0.5 N", f"changed.csv:{line})", "; 1 rows beyond")

    def test_forces_of_another_origin_are_compared_at_their_own_stamps(self):
        recording = self.write_expected()
        rows = range(0, 400, 7)
        lines = [f"{46.07 + recording['time_s'][i]:.4f},{recording['fz_N'][i]:.4f},7" for i in rows]
        foreign = self.write("foreign.csv", "t_s,fz_N,other\n" + "\n".join(lines) + "\n")
        self.assert_says(self.check(expected=foreign), EQUAL, f"compared {len(lines)} rows, fz_N: ")
        self.assert_says(self.check(self.stiffer_wall(), expected=foreign), DIFFERENT, "fz_N: expected")

    def test_a_change_of_one_unit_in_the_last_place_is_found_at_its_time_and_axis(self):
        drawn = random.Random(7)
        recording = self.write_expected()
        touched = numpy.flatnonzero(recording["fz_N"])
        head = 1
        for row in drawn.sample(list(touched), 4):
            value = numpy.nextafter(recording["fz_N"][row], numpy.inf)
            changed = self.replace_field(self.expected, head + int(row) + 1, "fz_N", repr(float(value)))
            run = self.check("wall", "--tolerance", "0", expected=changed)
            self.assert_says(run, DIFFERENT, f"first difference: at {recording['time_s'][row]:.4f} s, fz_N",
                             "; 1 rows beyond 0 N", f"fz_N at {recording['time_s'][row]:.4f} s")

    def drawn_comparison(self, seed):
        """Two random tables of forces, one axis flat and the same in both."""
        random_ = numpy.random.default_rng(seed)
        rows = int(random_.integers(2, 200))
        tables = []
        for name in ("expected", "got"):
            lines = [f"{0.001 * i:.3f},{x!r},0.5,{z!r}" for i, (x, z) in enumerate(random_.normal(size=(rows, 2)).tolist())]
            tables.append(forces.read_forces(self.write(f"{name}.csv", "time_s,fx_N,fy_N,fz_N\n" + "\n".join(lines) + "\n")))
        return forces.compare(*tables, tolerance_N=float(random_.uniform(0.0, 2.0)))

    def test_the_stated_first_and_largest_differences_are_the_true_ones(self):
        for seed in range(20):
            comparison = self.drawn_comparison(seed)
            off_N = [(abs(got - expected), row, k) for row, both in
                     enumerate(zip(comparison.expected_N.tolist(), comparison.got_N.tolist()))
                     for k, (expected, got) in enumerate(zip(*both))]
            most = max(off_N)[0]
            row, column = comparison.largest
            self.assertEqual(abs(comparison.got_N[row, column] - comparison.expected_N[row, column]), most)
            beyond = [(row, k) for off, row, k in off_N if off > comparison.tolerance_N]
            self.assertEqual(comparison.first, min(beyond) if beyond else None)

    def test_the_picture_is_zoomed_at_the_first_difference_and_leaves_flat_axes_out(self):
        try:
            import picture
        except ImportError as error:
            self.skipTest(str(error))
        for seed in range(20):
            comparison = self.drawn_comparison(seed)
            self.assertNotIn("fy_N", picture.drawn_names(comparison))
            zoom = picture.zoom_s(comparison)
            self.assertEqual(zoom is None, comparison.first is None)
            if zoom:
                first_s = comparison.time_s[comparison.first[0]]
                self.assertTrue(zoom[0] <= first_s <= zoom[1])
                self.assertLessEqual(((comparison.time_s >= zoom[0]) & (comparison.time_s <= zoom[1])).sum(), 61)

    def test_a_hand_that_touches_nothing_is_warned_of(self):
        far = ("--replay", "offset_z_m=0.1", "--duration", "0.05")
        self.assert_says(self.check("wall", "--write-expected", *far), EQUAL, "touched nothing")

    def test_a_recording_is_replayed_where_it_was_unless_options_place_it(self):
        placed = self.write("placed.toml", (daemons.SCENES / "wall.toml").read_text() +
                            "\n[device]\nposition_m = [0.0, 0.01, -0.004]\nscale = 2.0\n"
                            "orientation_xyzw = [0.0, 0.0, 0.0, 1.0]\n")
        felt, again = self.folder / "felt.csv", self.folder / "again.csv"
        self.assert_says(self.check(placed, "--write-expected", "--record", felt), EQUAL)
        self.assert_says(self.check(placed, "--record", again, hand=felt), EQUAL, "equal")
        self.assertGreater(daemons.read_recording(again)["contacts"].max(), 0)
        for axis in "xyz":
            was, now = (daemons.read_recording(file)[f"{axis}_m"] for file in (felt, again))
            self.assertLess(abs(was - now).max(), 1e-9)
        run = self.check(placed, "--replay", "offset_z_m=0", hand=felt)
        self.assert_says(run, DIFFERENT, "positions differ first: at 0.0000 s")

    def record_two_hands(self):
        """Of block_pinched, as scripts/launch records them. Options of a run as long."""
        devices = {name: f"phantom:profile=touchx,path={daemons.SCENES}/block_pinched.{name}.csv"
                   for name in ("left", "right")}
        run = subprocess.run(
            [daemons.ROOT / "scripts/launch", "block_pinched", "--lockstep", "--duration", "3.1", "--record",
             self.folder / "both.csv", *(word for hand in devices.items() for word in ("--hand", "=".join(hand)))],
            capture_output=True, text=True, timeout=60 * daemons.PATIENCE, check=False)
        self.assertEqual(run.returncode, EQUAL, run.stderr)
        return {"hand": self.folder / "both.csv"}

    def test_a_recording_of_two_hands_is_replayed_where_it_was_and_each_is_compared(self):
        both = self.record_two_hands()
        self.assert_says(self.check("block_pinched", "--write-expected", **both), EQUAL,
                         "written: " + str(self.folder / "expected.left.csv"), "expected.right.csv")
        for name in ("left", "right"):
            felt, again = (daemons.read_recording(self.folder / f"{kind}.{name}.csv")
                           for kind in ("both", "expected"))
            for axis in "xyz":
                self.assertLess(abs(felt[f"{axis}_m"] - again[f"{axis}_m"]).max(), 1e-9)
            self.assertLess(abs(felt["fx_N"] - again["fx_N"]).max(), 0.05)
        run = self.check("block_pinched", **both)
        self.assert_says(run, EQUAL, "hand left:\nequal: byte for byte", "hand right:\nequal: byte for byte")
        left = self.folder / "both.left.csv"
        left.write_bytes(left.read_bytes()[:200_000])  # it stops where it is, a while before
        run = self.check("block_pinched", **both)
        self.assert_says(run, DIFFERENT, "hand left:\nlengths differ", "DIFFERENT")
        self.assertEqual([], left_behind())

    def test_one_hand_of_two_is_replayed_with_the_other_away(self):
        both = self.record_two_hands()
        (self.folder / "both.right.csv").unlink()
        alone = ("--hand", "left")
        self.assert_says(self.check("block_pinched", "--write-expected", *alone, **both), EQUAL)
        run = self.check("block_pinched", *alone, **both)
        self.assert_says(run, EQUAL, "hand left:\nequal: byte for byte")
        self.assertNotIn("right", run.stdout)
        self.assert_one_line(self.check("block_pinched", **both), "both.right.csv: cannot be read")
        self.assert_one_line(self.check("block_pinched", "--hand", "middle", **both), "'left, right'")
        self.assert_one_line(self.check("wall", *alone), "names no hands")


if __name__ == "__main__":
    daemons.main()
