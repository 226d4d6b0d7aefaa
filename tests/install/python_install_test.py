#!/usr/bin/python3
"""The installed Python package: found with PYTHONPATH alone, wherever its tree was moved to; its examples run."""
import importlib.util
import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
import daemons  # after the path it needs

EXAMPLES = daemons.ROOT / "docs" / "examples" / "python"


class PythonInstallTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        installed = self.folder / "first place"
        self.run_quietly("cmake", "--install", daemons.BUILD, "--prefix", installed)
        self.prefix = installed.rename(self.folder / "prefix")  # it may be moved
        self.examples = self.folder / "examples"
        shutil.copytree(EXAMPLES, self.examples, ignore=shutil.ignore_patterns("__pycache__", ".pytest_cache"))
        self.environment = {name: value for name, value in os.environ.items() if name != "STILLGRID_LIBRARY"}
        self.environment["PYTHONPATH"] = str(self.prefix / "lib" / "python3" / "dist-packages")

    def run_quietly(self, *command, **options):
        result = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, **options)
        self.assertEqual(result.returncode, 0, result.stdout)
        return result.stdout.strip()

    def python(self, *arguments):
        return self.run_quietly("/usr/bin/python3", *arguments, cwd=self.examples, env=self.environment)

    def pytest(self, *arguments):
        command = ["/usr/bin/python3", "-m", "pytest", "-p", "no:cacheprovider", "numpy_test.py", *arguments]
        return subprocess.run(command, cwd=self.examples, env=self.environment, text=True, capture_output=True)

    @unittest.skipUnless(importlib.util.find_spec("pytest"), "skipped: pytest is not installed, see scripts/setup")
    def test_a_hand_is_replayed_in_pytest_and_another_spring_is_found(self):
        result = self.pytest()
        self.assertEqual(result.returncode, 0, result.stdout)
        simulation = self.examples / "numpy_simulation.py"
        text = simulation.read_text()
        self.assertEqual(text.count("0.02, 1.0, 100.0"), 1)
        simulation.write_text(text.replace("0.02, 1.0, 100.0", "0.02, 1.0, 105.0"))
        result = self.pytest()
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertRegex(result.stdout, r"at \d\.\d{4} s, f[xyz]_N: expected .* N, got .* N, tolerance 0.01 N")
        self.assertEqual(self.pytest("--stillgrid-write-expected").returncode, 0)
        self.assertEqual(self.pytest().returncode, 0)
        (self.examples / "press_forces.csv").unlink()
        self.assertIn("expected pytest --stillgrid-write-expected once", self.pytest().stdout)

    def test_the_simulation_is_felt_by_one_command_and_logged_by_another(self):
        self.assertRegex(self.python("numpy_simulation.py"), r"^felt \d{4} ticks, \d\.\d\d N at most$")
        scene = self.prefix / "share" / "stillgrid" / "scenes" / "wall.toml"
        self.start(self.prefix / "bin" / "sim_server", "--scene", scene, "--session", self.session)
        self.start(self.prefix / "bin" / "haptic_server", "--session", self.session,
                   "--device", self.still_device(0, 0, 0.003))
        header, *rows = self.python("logger.py", self.session, "3").splitlines()
        self.assertGreater(len(rows), 10)
        last = dict(zip(header.split(","), map(float, rows[-1].split(","))))
        self.assertAlmostEqual(last["fz_N"], 2.0, 2)
        self.assertGreater(last["contacts"], 0)

    def test_the_notebook_runs_from_its_first_cell_to_its_last(self):
        notebook = json.loads((self.examples / "bed_of_pins.ipynb").read_text())
        cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
        self.assertTrue(all(not cell["outputs"] and cell["execution_count"] is None for cell in cells))
        program = self.examples / "cells.py"
        program.write_text("import matplotlib\nmatplotlib.use('Agg')\n"
                           + "\n".join("".join(cell["source"]) for cell in cells))
        self.assertRegex(self.python(program), r"in contact for \d+% of 3\.0 s\n\d\.\d\d N at most")

    def test_a_shipped_scene_is_found_by_its_name_and_the_version_is_the_trees(self):
        program = self.write("shipped.py", """
import stillgrid
with stillgrid.Session("wall", lockstep=True, duration_s=0.1) as session:
    pass
print(session.report["ticks"], stillgrid.library_version())
""")
        self.assertEqual(self.python(program), f"100 {(daemons.ROOT / 'VERSION').read_text().strip()}")


if __name__ == "__main__":
    daemons.main()
