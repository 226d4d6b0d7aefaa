#!/usr/bin/python3
"""scripts/soak prints and judges a report of every kind; the laws of the soak under load."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import daemons

sys.path.append(str(daemons.ROOT / "tests" / "soak"))
import stress_soak  # after the path it needs

READ_NS = {"p50": 3000, "p99": 11000, "p999": 18000, "max": 90000}
COUNTS = dict.fromkeys(("torn", "mixed", "backwards", "nothing_shown", "rejected_attempts"), 0)
PUBLICATION = {"ticks": 60003, "accepted_share": 1.0, **COUNTS, "read_ns": READ_NS,
               "broken_laws": []}
KILLS = {**PUBLICATION, "killed": {"half_made": 3, "in_mid_write": 27}, "locks_left": 0,
         "snapshots_lost": 0, "leftovers": 0,
         "later_writer_read_ns": {**READ_NS, "mean": 8.5e6, "count": 29}}
STEPS = {"steps_per_s": 59.5, "steps": 595, "late_steps": 5, "not_converged": 0}
HAPTIC = {"killed": STEPS, "undisturbed": STEPS, "step_rate_ratio": 1.0, "compared": True}
RETURN_S = {"count": 50, "p50": 0.61, "max": 1.07}
NETWORK = {"kills": 200, "fade_s": {"count": 180, "p50": 0.149, "max": 0.152}, "snapshots": 9000, "torn": 0,
           "backwards": 0, "slew_max_N_per_ms": 0.02, "return_s": {"partition": RETURN_S}, "broken_laws": []}
REPLAY = {"rows": [{"trajectory": "circle", "scene": "tissue", "rows": 11021, "same": 20,
                    "contact_share": 0.62, "force_max_N": 1.4}], "broken_laws": []}
CYCLICTEST = {"thread": {"0": {"cycles": 30, "histogram": {"14": 20, "90": 10}}}}


def stress_slice(missed, **more):
    return {"haptic": {"ticks": 60000, "missed_ticks": missed, "contended": 0, "page_faults": 0,
                       "realtime_violations": {"total": 0}, "force_N": {"max": 8.5},
                       "slew_N_per_ms": {"p999": 0.85, "max": 3.0}, "safety": {"stalled": 0}, **more},
            "growth_kib": {"haptic_server": 0, "sim_server": 100},
            "sim": {"steps": 3600, "late_steps": 0},
            "snapshots": {"snapshots": 3600, "continued": 3599, "reads": 120000, "torn": 0},
            "steal_share": 0.01}


def stress(slices, baseline_missed):
    baselines = [{"ticks": 10000, "missed_ticks": missed, "steal_share": 0.01}
                 for missed in baseline_missed]
    figures = stress_soak.sum_up(slices, baselines)
    return {**figures, "broken_laws": stress_soak.broken_laws(figures)}


class SoakScriptTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="stillgrid-test-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def print_only(self, what, **reports):
        for name, report in reports.items():
            (self.folder / f"{name}.json").write_text(json.dumps(report))
        return subprocess.run([daemons.ROOT / "scripts" / "soak", what, "--print-only", "--out",
                               self.folder], capture_output=True, text=True, timeout=30 * daemons.PATIENCE,
                              check=False)

    def assert_prints(self, run, status, *words):
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        self.assertEqual(run.stderr, "")
        for word in words:
            self.assertIn(word, run.stdout)

    def test_a_report_of_each_kind_is_printed_beside_the_others(self):
        run = self.print_only("all", snapshots_1ms=PUBLICATION, kills=KILLS, haptic=HAPTIC,
                              stress=stress([stress_slice(6)], [1]), replay=REPLAY,
                              cyclictest=CYCLICTEST)
        self.assert_prints(run, 0, "snapshots_1ms", "60,003", "cyclictest (wake)", "27 in mid write",
                           "(29 times): mean 8.5 ms", "haptic, undisturbed: 59.50 steps/s",
                           "step rates compared", "60,000 ticks in 1 slices, 0.010 % missed",
                           "circle: 11,021 rows, 20 runs alike, 62 % in contact",
                           "5 passed, 0 failed")

    def test_a_report_of_each_kind_is_printed_alone(self):
        for what, report in (("kills", KILLS), ("haptic", HAPTIC),
                             ("stress", stress([stress_slice(6)], [1])), ("network", NETWORK),
                             ("replay", REPLAY)):
            self.assert_prints(self.print_only(what, **{what: report}), 0, f"  {what}",
                               "1 passed, 0 failed")

    def test_a_broken_law_is_named_and_is_a_failure(self):
        run = self.print_only("kills", kills={**KILLS, "broken_laws": ["torn = 0"]})
        self.assert_prints(run, 1, "kills: broken: torn = 0", "0 passed, 1 failed")

    def test_a_simulation_that_was_not_compared_has_not_passed(self):
        run = self.print_only("haptic", haptic={**HAPTIC, "compared": False})
        self.assert_prints(run, 1, "NOT compared", "0 passed, 1 failed")

    def test_a_folder_without_reports_or_with_other_ones_is_refused_with_a_line(self):
        self.assertEqual(self.print_only("kills").returncode, 2)
        run = self.print_only("stress", stress={"haptic": {}})
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, r"^soak: .* a report has no 'baseline'.*\n$")


class StressLawTest(unittest.TestCase):
    def test_missed_ticks_are_summed_and_held_against_the_baseline_and_its_spread(self):
        """12 and 28 of 10,000: 0.2 % and a spread of 0.16 %."""
        for missed, holds in ((216, True), (217, False)):
            figures = stress([stress_slice(0), stress_slice(2 * missed)], [12, 28])
            self.assertEqual(figures["broken_laws"] == [], holds, figures)

    def test_the_margin_is_a_tenth_of_a_percent_at_least_and_one_percent_for_one_slice(self):
        for slices, baseline, missed, holds in ((2, [10, 10], 120, True), (2, [10, 10], 121, False),
                                                (1, [10], 660, True), (1, [10], 661, False),
                                                (1, [10, 410], 3660, True),
                                                (1, [10, 410], 3661, False)):
            figures = stress([stress_slice(missed)] * slices, baseline)
            self.assertEqual(figures["broken_laws"] == [], holds, figures)

    def test_one_fault_or_violation_in_any_slice_breaks_a_law(self):
        for fault in ({"page_faults": 1}, {"realtime_violations": {"total": 1}},
                      {"contended": 13}, {"force_N": {"max": 8.51}},
                      {"slew_N_per_ms": {"p999": 0.9, "max": 0.9}}):
            figures = stress([stress_slice(0), stress_slice(0, **fault)], [0, 0])
            self.assertEqual(len(figures["broken_laws"]), 1, fault)
        cut = {"slew_N_per_ms": {"p999": 3.0, "max": 3.0}, "safety": {"stalled": 1}}  # by design
        self.assertEqual(stress([stress_slice(0, **cut)], [0])["broken_laws"], [])
        leak = {**stress_slice(0), "growth_kib": {"haptic_server": 0, "sim_server": 1025}}
        self.assertEqual(len(stress([stress_slice(0), leak], [0, 0])["broken_laws"]), 1)
        figures = stress([stress_slice(0), stress_slice(0, contended=12)], [0, 0])
        self.assertEqual(figures["broken_laws"], [])
        for contended, holds in ((1, True), (2, False)):  # in a run too short for 10,000
            figures = stress([stress_slice(0, ticks=5000, contended=contended)], [0])
            self.assertEqual(figures["broken_laws"] == [], holds)


if __name__ == "__main__":
    daemons.main()
