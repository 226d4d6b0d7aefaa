#!/usr/bin/python3
"""scripts/replay_check reads and keeps expectations, and says in one line what it cannot use."""
import gzip
import re
import resource
import subprocess
import xml.etree.ElementTree as xml

import daemons
import replays
from replays import COULD_NOT_RUN, DIFFERENT, EQUAL, REPLAY_CHECK
import expectation  # after replays, by which it is found
import forces
import recording


class ReplayFilesTest(replays.ReplayTest):
    def test_forces_are_not_kept_in_place_of_what_the_hand_follows(self):
        before = self.hand.read_bytes()
        self.assert_one_line(self.check("wall", "--write-expected", expected=self.hand), "is what the hand follows")
        self.assertEqual(self.hand.read_bytes(), before)

    def test_what_is_read_is_not_written_over_and_a_picture_has_a_name_of_one(self):
        self.assert_says(self.check("wall", "--write-expected"), EQUAL, "written: ")
        before = {file: file.read_bytes() for file in (self.hand, self.expected)}
        for option in ("--record", "--junit"):
            for file in before:
                self.assert_one_line(self.check("wall", option, file), f"{option}: value '{file}': expected another file")
        self.assert_one_line(self.check("wall", "--picture", self.folder / "p.txt"), "expected a name that ends in .png")
        self.assertEqual({file: file.read_bytes() for file in before}, before)

    def test_a_recording_replays_alike_once_it_was_imported_and_links_and_pipes_stay(self):
        scene = daemons.SCENES / "tissue_and_blocks.toml"
        self.assert_says(self.check(scene, "--write-expected"), EQUAL, "written: ")
        imported, link = self.folder / "imported.csv", self.folder / "link.csv"
        link.symlink_to(imported)
        subprocess.run([daemons.ROOT / "scripts" / "stillgrid_import", self.expected, "--out", link], check=True,
                       stdout=subprocess.DEVNULL)
        self.assertTrue(link.is_symlink())
        self.assertIn("# scene: tissue_and_blocks\n", imported.read_text())
        again = self.folder / "again.csv"
        self.assert_says(self.check(scene, "--write-expected", hand=self.expected, expected=again), EQUAL, "written: ")
        self.assert_says(self.check(scene, hand=imported, expected=again), EQUAL, "equal: byte for byte")

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

    def test_a_recording_with_a_column_twice_is_refused_in_one_line(self):
        both = self.write("both.csv", "time_s,fx_N,snapshot_id,snapshot_id\n0,1,7,7\n")
        line = "both.csv.*: column snapshot_id: given twice"
        with self.assertRaisesRegex(expectation.Unusable, line):
            forces.read_forces(both)
        with self.assertRaisesRegex(ValueError, line):
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

    def test_a_disk_that_is_full_leaves_both_an_expectation_and_its_metadata_as_they_were(self):
        new = self.write("new.csv", "time_s,fx_N\n" + 200 * "0,1\n")
        for limit, of_metadata, named in ((500, 20, "expected.csv"), (900, 1000, "expected.csv-metadata.json")):
            self.write("new.csv-metadata.json", of_metadata * " ")
            both = [self.write(name, "as it was\n") for name in ("expected.csv", "expected.csv-metadata.json")]
            before, limits = sorted(self.folder.iterdir()), resource.getrlimit(resource.RLIMIT_FSIZE)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limits[1]))
            try:
                with self.assertRaises(OSError) as raised:
                    expectation.keep(new, self.expected)
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, limits)
            self.assertEqual(raised.exception.filename, str(self.folder / named))
            self.assertEqual([file.read_text() for file in both], 2 * ["as it was\n"])
            self.assertEqual(sorted(self.folder.iterdir()), before)

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

    def test_junit_has_the_same_cases_where_nothing_can_run_and_is_XML_whatever_a_name_holds(self):
        file = self.folder / "result.xml"
        both = {"hand": self.folder / "both.csv", "expected": self.folder / "e\x1b[31m\udcff&.csv"}
        for options, cases in (((), ["both.left, hand left", "both.right, hand right"]),
                               (("--hand", "right"), ["both.right, hand right"]),
                               (("--hand", "middle"), ["both"])):
            run = self.check("block_pinched", "--junit", file, *options, **both)
            self.assertEqual(run.returncode, COULD_NOT_RUN)
            (suite,) = xml.parse(file).getroot()
            self.assertEqual([case.get("name") for case in suite], cases)
            self.assertEqual(suite.get("errors"), str(len(cases)))
        self.check("wall", "--junit", file, expected=both["expected"])
        (suite,) = xml.parse(file).getroot()
        self.assertIn(r"e\x1b[31m\udcff&.csv: there is none yet", suite.find("testcase/error").get("message"))

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
