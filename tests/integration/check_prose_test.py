#!/usr/bin/python3
"""The check of prose counts planted faults of each kind, and lets a file's count fall but not rise."""
import subprocess
import unittest

import daemons
from check_layers_test import SCRIPTS, SourceTreeTest

CLEAN = "# Page\n\nReturns the force in N. What is the limit?\n\n```\nwhat nobody told\n```\n"


class CheckProseTest(SourceTreeTest):
    def check(self, *options):
        run = subprocess.run([SCRIPTS / "check_prose", self.root, *options], capture_output=True, text=True,
                             timeout=30 * daemons.PATIENCE, check=False)
        return run.returncode, run.stdout.splitlines(), run.stderr

    def faults_in(self, file, text):
        self.plant(file, text)
        status, lines, error = self.check("--list", file)
        self.assertEqual((status, error), (0, ""))
        return [line.split(": ")[:2] for line in lines if line]

    def test_a_fault_of_each_kind_is_named_with_its_place(self):
        long = " ".join(["word"] * 26)
        for file, text, kind in (
                ("shared/a.hpp", "// Returns what sticks.\nint a();\n", "what"),
                ("shared/a.hpp", "int a();  // for nobody\n", "nothing"),
                ("shared/a.hpp", "/* A reader is told. */\nint a();\n", "tell"),
                ("shared/a.hpp", "// A body that gives\n// way.\nint a();\n", "stands"),
                ("shared/a.hpp", "int a();  // of a mode\n", "begins"),
                ("shared/a.hpp", "double tool_way_m;\n", "name"),
                ("shared/a.cpp", 'fail("the file has nothing in it");\n', "nothing"),
                ("README.md", f"{long}.\n", "long"),
                ("README.md", "- A limit. With it a tick ends.\n", "begins"),
                ("README.md", "| a | nobody |\n", "nothing")):
            with self.subTest(text):
                self.assertEqual(self.faults_in(file, text), [[f"{file}:1", kind]])
        self.assertEqual(self.faults_in("README.md", CLEAN), [])

    def test_a_count_may_fall_and_not_rise_and_a_moved_file_keeps_its_row(self):
        table = self.root / "scripts/prose_counts.txt"
        table.parent.mkdir(exist_ok=True)
        for file in self.root.rglob("*.?pp"):
            file.unlink()
        self.plant("shared/a.hpp", "// what\n// nobody\n")
        self.assertEqual(self.check("--update")[0], 0)
        self.assertEqual(table.read_text(), "3 shared/a.hpp\n")
        self.assertEqual(self.check(), (0, [], ""))
        self.plant("shared/a.hpp", "// what\n// nobody told\n")
        for options in ((), ("--update",)):
            status, lines, _ = self.check(*options)
            self.assertEqual(status, 1)
            self.assertIn("check_prose: shared/a.hpp: 4 faults, 3 allowed", lines[0])
        self.assertEqual(table.read_text(), "3 shared/a.hpp\n")
        self.plant("shared/a.hpp", "// Returns nobody.\n")
        self.assertEqual(self.check()[:2], (1, ["check_prose: shared/a.hpp: 1 faults, its row says 3: scripts/check_prose --update"]))
        self.assertEqual(self.check("--update")[0], 0)
        (self.root / "shared/a.hpp").rename(self.root / "proto/a.hpp")
        self.assertEqual(self.check("--update")[0], 0)
        self.assertEqual(table.read_text(), "1 proto/a.hpp\n")
        self.plant("shared/new.hpp", "// Returns nobody.\n")
        self.assertEqual(self.check("--update")[0], 1)


if __name__ == "__main__":
    daemons.main()
