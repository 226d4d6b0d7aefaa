#!/usr/bin/python3
"""scripts/replay_check says where forces first differ, and by its exit status whether they do."""
import gzip
import os
import pathlib
import random
import re
import subprocess
import sys
import unittest
import xml.etree.ElementTree as xml

import numpy

import daemons

sys.path.append(str(daemons.ROOT / "scripts" / "replay"))
import expectation  # after the path it needs
import forces
import old_names
import recording

EQUAL, DIFFERENT, COULD_NOT_RUN = 0, 1, 2
DURATION_S = 0.4
REPLAY_CHECK = daemons.ROOT / "scripts" / "replay_check"


def left_behind():
    """Segments of a replay_check that has ended: others may run beside this test."""
    return [file for file in daemons.SHM.glob("replay-check-*")
            if not pathlib.Path("/proc", re.match(r"replay-check-(\d+)", file.name)[1]).exists()]


class ReplayCheckTest(daemons.SessionTest):
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

    def test_an_axis_of_force_that_is_not_expected_is_told(self):
        self.write_expected()
        self.expected.write_text(self.expected.read_text().replace("fz_N", "fz_mN", 1))
        run = self.check()
        self.assert_says(run, EQUAL, f"warning: fz_N is not in {self.expected}: its ")
        self.assertNotIn("fx_N is not", run.stdout)

    def test_forces_are_not_kept_in_place_of_what_the_hand_follows(self):
        before = self.hand.read_bytes()
        self.assert_one_line(self.check("wall", "--write-expected", expected=self.hand), "is what the hand follows")
        self.assertEqual(self.hand.read_bytes(), before)

    def test_a_recording_replays_alike_once_it_was_imported_and_links_and_pipes_stay(self):
        scene = daemons.SCENES / "tissue_and_blocks.toml"
        self.assert_says(self.check(scene, "--write-expected"), EQUAL, "written: ")
        imported, link = self.folder / "imported.csv", self.folder / "link.csv"
        link.symlink_to(imported)
        subprocess.run([daemons.ROOT / "scripts" / "stillgrid_import", self.expected, "--out", link], check=True,
                       stdout=subprocess.DEVNULL)
        self.assertTrue(link.is_symlink())
        again = self.folder / "again.csv"
        self.assert_says(self.check(scene, "--write-expected", hand=self.expected, expected=again), EQUAL, "written: ")
        self.assert_says(self.check(scene, hand=imported, expected=again), EQUAL, "equal: byte for byte")

    def stiffer_wall(self):
        text = (daemons.SCENES / "wall.toml").read_text()
        self.assertIn("contact_stiffness_N_per_m = 1000.0", text)
        return self.write("stiffer.toml", text.replace("_N_per_m = 1000.0", "_N_per_m = 1100.0"))

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

    def test_an_expectation_that_cannot_be_used_is_named_in_one_line_before_any_run(self):
        self.assert_one_line(self.check(expected="absent.csv"), "absent.csv: there is none yet: --write-expected")
        bad = self.write("bad.csv", "time_s,fx_N,fy_N\n0,0,0\n1,0,nan\n")
        run = self.check(self.write("bad.toml", "format = 2\n[world\n"), expected=bad)
        self.assert_one_line(run, "bad.csv:3: column fy_N: value 'nan': expected a finite number")

    def test_a_bad_table_of_forces_is_refused_with_line_and_column(self):
        for text, words in (("time_s,x_m\n0,0\n", ":1: column fx_N: missing"),
                            ("x_m,fx_N\n0,0\n", ":1: column time_s: missing"),
                            ("time_s,fx_N\n0,0\n1,0\n0.5,0\n", ":4: column time_s: value '0.5'"),
                            ("time_s,fx_N\n0,0\n1,force\n", ":3: column fx_N: value 'force'"),
                            ("time_s,fx_N\n0,0\n1\n", ":3: 1 fields: expected 2"),
                            ("time_s,fx_N,fx_N\n0,0,0\n", ":1: column fx_N: given twice"),
                            ("time_s,fx_N\n0,0", "no whole row"), ("", "no whole row"),
                            ("time_s,fx_N\n0,\xe9\n", ":2: column fx_N")):
            with self.subTest(text), self.assertRaisesRegex(expectation.Unusable, f"bad.csv.*{words}"):
                forces.read_forces(self.write("bad.csv", text))

    def test_the_old_name_of_a_column_is_read_as_that_of_today(self):
        (flag,), (*columns,) = old_names.FLAGS, old_names.COLUMNS
        old = self.write("old.csv", f"time_s,fx_N,{','.join(columns)},flags\n0,1,7,2,3,4,{flag}|swept\n1,1,8,5,6,7,\n")
        self.assertEqual(list(forces.read_forces(old).columns["snapshot_id"]), [7.0, 8.0])
        read = recording.load(old)
        self.assertEqual(list(read["snapshot_id"]), [7.0, 8.0])
        self.assertEqual([list(read[f"t{axis}_N_m"]) for axis in "xyz"], [[2.0, 5.0], [3.0, 6.0], [4.0, 7.0]])
        self.assertEqual(list(read["flags"]), ["truncated|swept", ""])

    def test_a_column_under_its_old_name_and_that_of_today_is_refused_in_one_line(self):
        for before, now in old_names.COLUMNS.items():
            both = self.write("both.csv", f"time_s,fx_N,{before},{now}\n0,1,7,7\n")
            line = f"both.csv.*: column {now}: given twice, by this name or an earlier one"
            with self.subTest(now), self.assertRaisesRegex(expectation.Unusable, line):
                forces.read_forces(both)
            with self.subTest(now), self.assertRaisesRegex(ValueError, line):
                recording.load(both)

    def test_a_table_cut_off_anywhere_is_read_up_to_its_last_whole_row(self):
        text = "# key: value\ntime_s,fx_N\n0,1\n0.5,2\n0.5,3\n1,4.25\n"
        for end in range(text.index("0,1") + 4, len(text) + 1):
            read = forces.read_forces(self.write("cut.csv", text[:end]))
            whole = text[:end].count("\n") - 2
            stamps, last_N = {1: (1, 1.0), 2: (2, 2.0), 3: (2, 3.0), 4: (3, 4.25)}[whole]
            self.assertEqual((len(read.time_s), read.columns["fx_N"][-1]), (stamps, last_N), text[:end])

    def test_what_the_daemons_refuse_is_passed_on_in_one_line_and_nothing_is_written(self):
        before = self.write_expected() and self.expected.read_bytes()
        always = ("--write-expected",)
        self.assert_one_line(self.check("no_such_scene", *always), "no_such_scene: no such scene")
        bad_scene = self.write("bad.toml", "format = 2\n[world\n")
        self.assert_one_line(self.check(bad_scene, *always), "sim_server: ", "bad.toml:2:")
        bad_hand = self.write("bad.csv", "time_s,x_m,y_m,z_m\n0,0,nothing,0\n")
        self.assert_one_line(self.check("wall", *always, hand=bad_hand), "bad.csv:2: column y_m")
        self.assert_one_line(self.check("wall", *always, "--replay", "pace=2"), "pace")
        self.assert_one_line(self.check("wall", *always, build=("--build", self.folder)), "bin/haptic_server")
        self.assertEqual(self.expected.read_bytes(), before)

    def test_a_new_expectation_says_how_the_old_one_differed(self):
        self.write_expected()
        scene = self.stiffer_wall()
        self.assert_says(self.check(scene, "--write-expected"), EQUAL, "first difference: at", "written: ")
        self.assert_says(self.check(scene), EQUAL, "equal: byte for byte")

    def test_a_first_expectation_is_told_to_be_new_and_never_equal(self):
        first = self.check("wall", "--write-expected")
        self.assert_says(first, EQUAL, f"written: {self.expected}, 401 rows: new")
        self.assertNotIn("equal", first.stdout)
        self.assert_says(self.check("wall", "--write-expected"), EQUAL, "401 rows: its forces were equal")
        self.assert_says(self.check(self.stiffer_wall(), "--write-expected"), EQUAL, "401 rows: changed")
        self.expected.write_text("time_s,fx_N\n0,none\n")
        self.assert_says(self.check("wall", "--write-expected"), EQUAL,
                         "none that could be used", ":2: column fx_N: value 'none'")

    def test_a_compressed_expectation_is_the_same_and_much_smaller(self):
        self.write_expected()
        packed = self.folder / "expected.csv.gz"
        self.assert_says(self.check("wall", "--write-expected", expected=packed), EQUAL, "401 rows: new")
        before = packed.read_bytes()
        self.assert_says(self.check("wall", "--write-expected", expected=packed), EQUAL, "were equal")
        self.assertEqual(packed.read_bytes(), before, "no time of day is in it")
        self.assertLess(3 * len(before), len(self.expected.read_bytes()))
        self.assertEqual(gzip.decompress(before), self.expected.read_bytes())
        self.assert_says(self.check(expected=packed), EQUAL, "equal: byte for byte, 401 rows")
        self.assert_says(self.check(self.stiffer_wall(), expected=packed), DIFFERENT, "expected.csv.gz:")
        packed.write_bytes(before[:-20])
        self.assert_one_line(self.check(expected=packed), "expected.csv.gz: cannot be read: expected a whole gzip file")

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

    def test_junit_has_a_case_a_hand_and_says_what_differs(self):
        file = self.folder / "result.xml"
        self.assert_says(self.check("wall", "--write-expected", "--junit", file), EQUAL)
        self.assert_says(self.check("wall", "--junit", file), EQUAL)
        (suite,) = xml.parse(file).getroot()
        self.assertEqual((suite.get("tests"), suite.get("failures"), suite.get("errors")), ("1", "0", "0"))
        self.assert_says(self.check(self.stiffer_wall(), "--junit", file), DIFFERENT)
        (suite,) = xml.parse(file).getroot()
        (case,) = suite
        self.assertEqual((suite.get("failures"), case.get("classname"), case.get("name")), ("1", "stiffer", "hand"))
        self.assertIn("fz_N: expected", case.find("failure").get("message"))
        self.assertIn("largest ", case.find("failure").text)
        self.assert_one_line(self.check("no_such_scene", "--junit", file), "no such scene")
        (suite,) = xml.parse(file).getroot()
        self.assertIn("no such scene", suite.find("testcase/error").get("message"))

    def test_a_hand_that_touches_nothing_is_warned_of(self):
        far = ("--replay", "offset_z_m=0.1", "--duration", "0.05")
        self.assert_says(self.check("wall", "--write-expected", *far), EQUAL, "touched nothing")

    def test_a_recording_is_replayed_where_it_was_unless_options_place_it(self):
        placed = self.write("placed.toml", (daemons.SCENES / "wall.toml").read_text() +
                            "\n[device]\nposition_m = [0.0, 0.01, -0.004]\nscale = 2.0\n")
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

    def test_the_example_workflow_is_YAML_and_calls_what_there_is(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("skipped: no python3-yaml")
        workflow = yaml.safe_load((daemons.ROOT / "docs/examples/github_workflow.yml").read_text())
        job = workflow["jobs"]["replay"]
        commands = "\n".join(step.get("run", "") for step in job["steps"])
        options = [case.get("options", "") for case in job["strategy"]["matrix"]["include"]]
        replay = job["env"]["REPLAY"]
        arguments = " ".join([replay, *re.findall(r"env\.REPLAY \}\}(.*)", commands), *options])
        told = subprocess.run([REPLAY_CHECK, "--help"], capture_output=True, text=True, check=True).stdout
        for option in re.findall(r"--[a-z-]+", arguments):
            self.assertIn(option, told)
        for script in re.findall(r"stillgrid/(scripts/\w+)", commands + replay):
            self.assertTrue((daemons.ROOT / script).exists(), script)

    def test_it_runs_from_where_it_is_installed(self):
        prefix = self.folder / "prefix"
        subprocess.run(["cmake", "--install", daemons.BUILD, "--prefix", prefix, "--component",
                        "replay_check"], check=True, stdout=subprocess.DEVNULL)
        for name in ("sim_server", "haptic_server"):
            (prefix / "bin" / name).symlink_to(daemons.BUILD / "bin" / name)
        installed = {"program": prefix / "bin" / "replay_check", "build": ()}
        wall = daemons.SCENES / "wall.toml"
        self.assert_says(self.check(wall, "--write-expected", **installed), EQUAL, "written: ")
        run = self.check(self.stiffer_wall(), **installed)
        self.assert_says(run, DIFFERENT, "no picture: no matplotlib")  # it found all of its own parts


if __name__ == "__main__":
    daemons.main()
