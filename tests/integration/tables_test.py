#!/usr/bin/python3
"""Published tables come out again: a random part of each, another with every commit."""
import pathlib
import subprocess
import tempfile
import unittest

import daemons

CHECK = daemons.ROOT / "scripts/check_tables"
CHARTS = daemons.ROOT / "docs/charts"


def check(*arguments):
    return subprocess.run([CHECK, "--build", daemons.BUILD, *map(str, arguments)], capture_output=True, text=True,
                          timeout=1000, check=False)


class TablesTest(unittest.TestCase):
    def assert_comes_out(self, *tables):
        run = check(*tables)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        for table in tables:
            self.assertRegex(run.stdout, rf"(?m)^{table} +(\d+ figures, 0 differ|skipped: no row of it can be measured here) ")

    def test_tables_of_forces_over_rows_of_spheres_come_out_again(self):
        self.assert_comes_out("row_ripple", "ku_contact", "contour_forces")

    def test_tables_of_solvers_and_voxels_come_out_again(self):
        self.assert_comes_out("broyden_iterations", "voxel_ratio")

    def test_tables_of_models_come_out_again(self):
        self.assert_comes_out("model_table", "paper_figures")

    def test_tables_of_stability_come_out_again(self):
        self.assert_comes_out("stability")

    def test_a_figure_that_was_changed_is_named(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            text = (CHARTS / "paper_figures.csv").read_text().splitlines()
            wrong = [text[0], *(f"{label},{time},{float(force) + 0.01},{snapshot}" for label, time, force, snapshot in
                                (line.split(",") for line in text[1:]))]
            (folder / "paper_figures.csv").write_text("\n".join(wrong) + "\n")
            run = check("paper_figures", "--charts", folder, "--seed", 1)
        self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
        self.assertIn("force_N: published ", run.stdout)
        self.assertEqual(run.stderr, "check_tables: do not come out again: paper_figures\n")

    def test_a_table_that_is_not_checked_is_refused_in_one_line(self):
        run = check("publication_speed")
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, r"\Acheck_tables: value publication_speed: expected some of .*\n\Z")


if __name__ == "__main__":
    daemons.main()
