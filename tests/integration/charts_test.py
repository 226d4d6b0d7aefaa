#!/usr/bin/python3
"""scripts/charts: its table, its page, what it draws, and what it says of a chart that fails."""
import importlib.machinery
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import daemons

sys.path.append(str(daemons.ROOT / "scripts/gallery"))
import chart_table  # after the path it needs

CHARTS = daemons.ROOT / "docs/charts"
GALLERY = daemons.ROOT / "scripts/gallery"
TABLE = chart_table.read()
CHART = next(chart for chart in TABLE["chart"] if chart["measure"])
check_charts = importlib.machinery.SourceFileLoader("check_charts", str(daemons.ROOT / "scripts/check_charts")).load_module()


def run_charts(*arguments, **environment):
    return subprocess.run([daemons.ROOT / "scripts/charts", *map(str, arguments)], capture_output=True,
                          text=True, timeout=100 * daemons.PATIENCE, check=False,
                          env={**os.environ, **{name: str(value) for name, value in environment.items()}})


class ChartsTest(unittest.TestCase):
    def setUp(self):
        self.out = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-"))
        self.addCleanup(shutil.rmtree, self.out)

    def assert_drawn(self, *pictures):
        self.assertEqual(sorted(file.name for file in self.out.glob("*.png")), sorted(pictures))
        for picture in pictures:
            content = (self.out / picture).read_bytes()
            self.assertTrue(content.startswith(b"\x89PNG") and content.endswith(b"IEND\xaeB`\x82"), picture)

    def test_every_picture_and_table_of_the_folder_is_in_the_table_of_charts_once(self):
        listed = ["README.md"]
        for chart in TABLE["chart"]:
            listed += chart.get("data", []) + [picture["file"] for picture in chart["pictures"]]
        self.assertEqual(sorted(listed), sorted(file.name for file in CHARTS.iterdir()))

    def test_every_chart_names_programs_pages_and_sections_that_exist(self):
        names = [chart["name"] for chart in TABLE["chart"]]
        self.assertEqual(len(names), len(set(names)))
        for chart in TABLE["chart"]:
            with self.subTest(chart["name"]):
                self.assertIn(chart["section"], TABLE["sections"])
                self.assertIn(chart["full"], ("seconds", "minutes", "hours"))
                for picture in chart["pictures"]:
                    page = picture.get("page", chart["page"])
                    self.assertIn(picture["file"], (daemons.ROOT / "docs" / page).read_text())
                for command in [*chart["measure"], *([chart["draw"]] if "draw" in chart else [])]:
                    program = command.split()[0]
                    file = daemons.ROOT / program if "/" in program else GALLERY / program
                    self.assertTrue(os.access(file, os.X_OK), program)
                if any(picture.get("kept", True) for picture in chart["pictures"]):
                    self.assertIn("draw", chart)

    def test_no_program_of_the_gallery_is_used_by_nobody(self):
        used = " ".join(" ".join(chart["measure"] + [chart.get("draw", "")]) for chart in TABLE["chart"])
        programs = {file.name for file in GALLERY.glob("*.py") if file.name.startswith(("measure_", "plot_"))}
        programs -= {"plot_recording.py"}  # of scripts/demo
        self.assertEqual(sorted(name for name in programs if name not in used), [])

    def test_a_chart_is_stale_once_its_scene_or_code_changes_but_not_for_a_comment_or_another_file(self):
        chart = {"name": "wall", "measure": [], "page": "README.md", "made_of": ["scenes/wall.*", "law"]}
        for file, text in (("scenes/wall.toml", "mass_kg = 1  \n# heavy\n"), ("law/a.cpp", "int a;  // one\n"),
                           ("law/b.py", '"""Says."""\nx = 1\n'), ("other.cpp", "int b;\n")):
            (self.out / file).parent.mkdir(exist_ok=True)
            (self.out / file).write_text(text)
        measured = chart_table.made_of(chart, self.out)
        for file, text, is_stale in (("other.cpp", "int c;\n", False), ("scenes/wall.toml", "mass_kg = 1\n", False),
                                     ("law/a.cpp", "/* two */ int a ;\n", False), ("law/b.py", '"""Reads."""\nx = 1\n', False),
                                     ("scenes/wall.toml", "mass_kg = 2\n", True), ("law/a.cpp", "int d;\n", True),
                                     ("law/b.py", "x = 2\n", True), ("law/new.cpp", "int e;\n", True)):
            with self.subTest(file=file, text=text):
                kept = (self.out / file).read_text() if (self.out / file).exists() else None
                (self.out / file).write_text(text)
                self.assertEqual(chart_table.made_of(chart, self.out) != measured, is_stale)
                (self.out / file).unlink() if kept is None else (self.out / file).write_text(kept)

    def test_a_stale_chart_is_one_line_and_fails_unless_its_page_says_of_which_commit_it_is(self):
        now = chart_table.made_of(CHART)
        old = {**now, CHART["made_of"][0]: "0"}
        again = f"scripts/charts --only {CHART['name']} --full"
        self.assertEqual(list(check_charts.check(CHART, now)), [])
        self.assertEqual(list(check_charts.check(CHART, old)), [
            (f"{CHART['name']}: {CHART['made_of'][0]} has changed since it was measured: {again}", True)])
        self.assertIn("expected the words 'commit 0badc0de'",
                      next(check_charts.check({**CHART, "stale_since": "0badc0de"}, old))[0])
        self.assertEqual([fails for _, fails in check_charts.check({**CHART, "stale_since": "0badc0de"}, now)], [True])

    def test_every_chart_that_is_measured_says_what_it_is_made_of(self):
        for chart in TABLE["chart"]:
            self.assertEqual(bool(chart["measure"]), bool(chart.get("made_of")), chart["name"])
            for path in chart.get("made_of", ()):
                self.assertTrue(any(daemons.ROOT.glob(path)), path)

    def test_the_page_is_what_the_table_says(self):
        self.assertEqual((CHARTS / "README.md").read_text(), chart_table.page(TABLE),
                         "expected what scripts/charts --page writes")

    def test_a_list_names_every_chart(self):
        run = run_charts("--list")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual([line.split()[0] for line in run.stdout.splitlines()],
                         [chart["name"] for chart in TABLE["chart"]])

    def test_charts_are_drawn_again_from_the_tables_that_are_kept(self):
        run = run_charts("--draw-only", "--only", "axes", "paper_figures", "demo", "--out", self.out)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assert_drawn("axes.png", "paper_figures.png")
        self.assertIn("not drawn, as only measuring does that: demo_force.png", run.stdout)
        self.assertEqual((self.out / "paper_figures.csv").read_bytes(), (CHARTS / "paper_figures.csv").read_bytes())

    def test_a_chart_that_fails_is_named_and_the_others_are_drawn(self):
        run = run_charts("--only", "broyden", "axes", "--out", self.out, STILLGRID_BUILD_DIR=self.out / "build")
        self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
        self.assertRegex(run.stderr, r"\Acharts: failed: broyden \(.*\)\n\Z")
        self.assertRegex(run.stdout, r"broyden .* FAILED: measure_printed.py: .*/broyden_figures: expected a program")
        self.assert_drawn("axes.png")

    def test_without_the_real_inputs_a_chart_is_drawn_from_the_table_that_is_kept(self):
        run = run_charts("--only", "recorded_forces", "--out", self.out, STILLGRID_BUILD_DIR=daemons.BUILD,
                         STILLGRID_DATA=self.out / "absent")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertIn("skipped: measuring it needs the folder of real inputs, drawn", run.stdout)
        self.assert_drawn("spring_recording.png")

    def test_what_cannot_be_asked_for_is_one_line(self):
        for arguments, words in ((["--only", "tool_rage"], "--only: value tool_rage: expected some of demo"),
                                 (["--jobs", "0"], "--jobs: value 0: expected 1 at least"),
                                 (["--out", CHARTS], "expected another folder")):
            run = run_charts(*arguments)
            self.assertEqual(run.returncode, 1)
            self.assertRegex(run.stderr, r"\Acharts: .*\n\Z")
            self.assertIn(words, run.stderr)


if __name__ == "__main__":
    daemons.main()
