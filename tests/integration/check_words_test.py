#!/usr/bin/python3
"""The check of words finds what is planted, in code, keys and pages, and nothing in what is clean."""
import unittest

import daemons
from check_layers_test import SourceTreeTest


class CheckWordsTest(SourceTreeTest):
    def words_in(self, file, text):
        (self.root / file).parent.mkdir(parents=True, exist_ok=True)
        self.plant(file, text)
        result = self.run_script("check_words")
        self.assertEqual(result.returncode, 1 if result.stdout else 0, result.stderr)
        return result.stdout.splitlines()

    def test_clean_sources_hold_no_old_word(self):
        self.assertEqual(self.words_in("proto/clean.hpp", "double stiffness_N_per_m, torque_N_m, per_mm;\n"), [])
        for clean in ("kNoTorque_N_m", "tx_N_m", "angular_momentum_N_m_s", "joint_N_m_per_rad", "impulse_N_s",
                      "damping_N_s_per_m", "t{}_N_m", "a company of laws", "to regenerate", "regeneration"):
            with self.subTest(clean):
                self.assertEqual(self.words_in("docs/clean.md", f"{clean}\n"), [])

    def test_a_planted_word_is_named_with_its_place_and_what_is_said_instead(self):
        for file, text, instead in (
                ("shared/a.hpp", "struct StillGrid {};", "voxel grid"),
                ("shared/a.cpp", "std::uint64_t generation = 0;", "snapshot_id"),
                ("sim_server/a.cpp", "// bodies that are asleep", "sleeping"),
                ("sim_server/a.hpp", "constexpr int kMostSteps = 3;", "kMax"),
                ("haptic_server/a.cpp", 'log("the newest image is late");', "snapshot"),
                ("scripts/a.py", "told_J = 0.0", "commanded"),
                ("docs/a.md", "The told force is bounded.", "commanded"),
                ("docs/b.md", "as the handbook says", "docs/cases.md"),
                ("shared/b.hpp", "constexpr int kMost = 3;", "max_"),
                ("shared/c.hpp", "std::size_t most_spheres;", "max_"),
                ("haptic_server/b.hpp", "ToolSweep way_;", "sweep"),
                ("sim_server/b.cpp", "enter(still_covers(world));", "static"),
                ("shared/a.js", "this.still = 1;", "static"),
                ("shared/a.mjs", "const kMostSteps = 1;", "max_"),
                ("shared/a.css", "/* the newest image */", "snapshot"),
                ("shared/a.json", '{"generation": 1}', "snapshot_id"),
                ("scripts/a.sh", "wake_late=1", "wake-up latency"),
                (".github/a.yml", "run: told_J", "commanded")):
            with self.subTest(text):
                lines = self.words_in(file, f"\n{text}\n")
                self.assertEqual(len(lines), 1, lines)
                self.assertTrue(lines[0].startswith(f"{file}:2: '"), lines)
                self.assertIn(instead, lines[0])
                (self.root / file).unlink()

    def test_a_unit_that_can_be_read_in_two_ways_is_named(self):
        for name in ("stiffness_N_m", "damping_N_s_m", "answers_m_N", "slew_N_ms", "WALL_N_M", "per_mass_kg", "torque_Nm",
                     "kTorque_Nm", "impulse_Ns", "fade_N_s", "FADE_N_S", "return_N_m", "controlled_N_m", "hand_N_mm",
                     "stiffness_per_step_N_m"):
            with self.subTest(name):
                lines = self.words_in("docs/a.toml", f"{name} = 1.0\n")
                self.assertEqual(len(lines), 1, lines)
                self.assertIn("ambiguous unit", lines[0])


if __name__ == "__main__":
    daemons.main()
