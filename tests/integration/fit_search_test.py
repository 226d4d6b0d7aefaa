#!/usr/bin/python3
"""scene_fit's search finds the cheapest candidate that keeps to its goal: in one process, with formulas for runs."""
import dataclasses
import sys
import types
import unittest.mock

import daemons
import fake_fit_run
from skin_scene import SCENE, assert_is, cheapest

sys.path.append(str(daemons.ROOT / "scripts" / "fit"))
import candidates as space  # these after the path they need
import fit
import levels
import report
import runs
import scene_files


class Formulas:
    """As Runs, but that it asks the formulas."""

    def __init__(self, folder, is_faulty=False):
        self.folder, self.is_faulty, self.progress = folder, is_faulty, runs.Progress()
        self.machines = runs.Machines("none", jobs=2)

    def key(self, *_):
        return "0"

    def make(self, _, file):
        (self.folder / file).touch()

    def results(self, _, requests, *__, **___):
        parsed = [fake_fit_run.parsed(arguments) for arguments, _ in requests]
        return [fake_fit_run.candidate((self.folder / scene).read_text(), settings, options, self.is_faulty)
                for scene, settings, options in parsed]


def crashing_at(stage, results):
    """results(), all of whose runs of that stage crash."""
    def broken(self, what, requests, *_, **__):
        if what.startswith(stage):
            return [{"crashed": "it broke"} for _ in requests]
        return results(self, what, requests)
    return broken


class OneThatSolves(Formulas):
    """All but one method err by a tenth and more, and that one can keep no more than 30 Hz."""

    def results(self, what, requests, *_, **__):
        found = super().results(what, requests)
        for (arguments, _), result in zip(requests, found):
            scene, settings, _ = fake_fit_run.parsed(arguments)
            told = f"{settings}\n{(self.folder / scene).read_text()}"
            if "implicit_euler" in told:
                result["cost"]["step_share"] = (fake_fit_run.value_of(told, "rate_hz") or 50.0) / 30.0
            else:
                result["error"] = {key: 0.1 + value for key, value in result["error"].items()}
        return found


class OneIsAsCheap(Formulas):
    """Everything costs 100, but the scene as given: so much where others run beside it, and so much alone."""
    BESIDE_US = ALONE_US = 100.0

    def results(self, what, requests, *_, **__):
        found = super().results(what, requests)
        for (arguments, _), result in zip(requests, found):
            is_given = "--set" not in arguments and "predict" in arguments
            given_us = self.ALONE_US if "--repeats" in arguments else self.BESIDE_US
            result["cost"]["processor_us_per_ms"] = given_us if is_given else 100.0
        return found


class NoContact(Formulas):
    """No press of the closed loop touches anything."""

    def results(self, what, requests, *_, **__):
        found = super().results(what, requests)
        for result in found:
            if result["stability"]:
                result.update(stability={"stable": None}, problems=["stability not tested: it touches nothing"])
        return found


class SearchTest(daemons.SessionTest):
    """In this process, with formulas in place of runs."""

    def fit(self, text=SCENE, grid="small", runs_of=Formulas, **changed):
        arguments = types.SimpleNamespace(**{
            "trajectory": [self.write("hand.csv", "t_s,x_m\n0,0\n")], "force_error": 0.05, "budget_us": None,
            "margin": 2.0, "device": "touch", "settle": 0.0, "duration": None, "replay": "", "check": None,
            "grid": grid, **changed})
        self.notes = []
        self.out = self.folder / "fit"
        self.out.mkdir(exist_ok=True)
        files = scene_files.SceneFiles(self.write("skin.toml", text), self.out)
        one = fit.Fit(arguments, files, runs_of(self.out))
        one.check_references(self.notes.append)
        groups = levels.groups_of(files.copied, None, lambda _: None)
        return one.fit(space.Space(files.copied, groups, space.GRIDS[grid]), lambda _: ["Fitted."])

    def assert_is(self, one, expected):
        assert_is(self, one, expected)

    def test_the_cheapest_within_any_tolerance_is_found(self):
        for tolerance in (0.02, 0.03, 0.05, 0.08, 0.2, 1.0):
            with self.subTest(tolerance):
                self.assert_is(self.fit(force_error=tolerance)["choice"], cheapest(tolerance))

    def test_of_several_hands_the_worst_counts(self):
        hands = [self.write(name, f"t_s,x_m\n0,{name[0]!r}\n") for name in ("near.csv", "far.csv", "also_near.csv")]
        answer = self.fit(trajectory=hands, force_error=0.6)  # on the far one all err by a half more
        self.assertEqual(answer["trajectory"], "near.csv, far.csv, also_near.csv")
        self.assertAlmostEqual(answer["choice"]["error_share"], cheapest(0.1)[1] + 0.5)
        self.assertEqual(answer["choice"]["cost_us_per_ms"], cheapest(0.1)[0])
        self.assertFalse(self.fit(trajectory=hands, force_error=0.4)["fits"])

    def test_an_integrator_that_sim_server_lacks_is_compared_and_not_chosen(self):
        def cost_us(rate_hz, transition, spacing_m, integrator):
            return 1.0 if integrator == "broyden" else 100.0 + rate_hz

        with unittest.mock.patch.object(fake_fit_run, "cost_us", cost_us), \
                unittest.mock.patch.dict(space.GRIDS, small=dataclasses.replace(
                    space.GRIDS["small"], methods=(("broyden", 1),))):
            answer = self.fit()
        compared = [row for row in answer["runs"] if row["method"] == "broyden"]
        self.assertEqual({row["verdict"] for row in compared}, {"for comparison: sim_server has no such integrator"})
        self.assertEqual({row["cost_us_per_ms"] for row in compared}, {1.0})
        self.assertEqual(answer["choice"]["method"], "as given")

    def test_a_full_grid_finds_nothing_dearer_than_a_small_one(self):
        for tolerance in (0.02, 0.05, 0.2):
            answer = self.fit(grid="full", force_error=tolerance)
            self.assertTrue(answer["fits"])
            self.assertLessEqual(answer["choice"]["cost_us_per_ms"], cheapest(tolerance)[0])

    def test_no_method_is_tried_twice_under_two_names(self):
        methods = {row["method"] for row in self.fit()["runs"]}
        self.assertEqual(methods, {"as given", "implicit_euler"})  # given: velocity_verlet
        methods = {row["method"] for row in self.fit(SCENE.replace('integrator = "velocity_verlet"\n', ""))["runs"]}
        self.assertEqual(methods, {"as given", "velocity_verlet"})

    def test_of_those_that_cost_as_much_the_most_accurate_is_taken(self):
        """Costs that differ by a hundredth are one cost; linear errs three times as much as predict."""
        def cost_us(rate_hz, transition, spacing_m, integrator):
            shown = {"linear": 50.0, "predict": 50.5}.get(transition, 100.0)
            return shown + rate_hz + 1e3 * spacing_m + 10.0 * (integrator == "implicit_euler")

        with unittest.mock.patch.object(fake_fit_run, "cost_us", cost_us):
            answer = self.fit(force_error=0.2)
        self.assertEqual(answer["choice"]["transition"], "predict")
        self.assertGreater(answer["choice"]["cost_us_per_ms"], min(row["cost_us_per_ms"] for row in answer["runs"]))

    def test_the_choice_costs_no_more_than_the_scene_as_given_which_is_left_as_it_is_at_a_tie(self):
        for beside_us, alone_us in ((200.0, 50.0), (100.0, 100.0), (200.0, 104.0)):
            with self.subTest(alone_us), unittest.mock.patch.multiple(OneIsAsCheap, BESIDE_US=beside_us,
                                                                      ALONE_US=alone_us):
                answer = self.fit(force_error=0.2, runs_of=OneIsAsCheap)
                self.assertEqual(answer["choice"], answer["given"])
        with unittest.mock.patch.object(OneIsAsCheap, "ALONE_US", 106.0):
            answer = self.fit(force_error=0.2, runs_of=OneIsAsCheap)
        self.assertEqual(answer["choice"]["cost_us_per_ms"], 100.0)

    def test_the_next_cheaper_is_the_one_that_costs_least_less(self):
        for tolerance in (0.01, 0.03, 0.08, 0.1):
            answer = self.fit(force_error=tolerance)
            choice_us, cheaper = answer["choice"]["cost_us_per_ms"], answer["next_cheaper"]
            self.assertEqual(cheaper["cost_us_per_ms"], max(
                row["cost_us_per_ms"] for row in answer["runs"]
                if row["cost_us_per_ms"] < choice_us and row["verdict"] != "fits"))
            self.assertTrue(cheaper["alone"])
            self.assertNotEqual(cheaper["verdict"], "fits")

    def test_stability_that_could_not_be_tested_is_no_stability_and_why_is_told(self):
        answer = self.fit(runs_of=NoContact)
        self.assert_is(answer["choice"], cheapest(0.05, 0.0))  # of what fits but for that
        self.assertFalse(answer["fits"])
        self.assertIn("stability not tested: it touches nothing", report.missed(answer, fit.Goal(0.05)))

    def test_where_nothing_can_be_used_a_budget_is_told_only_where_there_is_one(self):
        with self.assertRaisesRegex(runs.Unusable, "as given: unstable") as raised:
            self.fit(SCENE.replace("200.0", "1e9"))
        self.assertNotIn("budget", str(raised.exception))
        with self.assertRaisesRegex(runs.Unusable, "costs [1-9].* us: expected a larger budget than 0.01 us"):
            self.fit(budget_us=0.01)

    def test_a_fitted_scene_that_fails_on_another_hand_is_no_fit(self):
        far, near = (self.write(f"{name}.csv", "t_s,x_m\n0,0\n") for name in ("far", "near"))
        answer = self.fit(check=near)
        self.assertEqual((report.missed(answer, fit.Goal(0.05)), self.notes), (None, []))
        answer = self.fit(check=far)
        self.assertIn("far.csv, which the fit did not see: errs by 5", report.missed(answer, fit.Goal(0.05)))
        self.assertRegex(report.printed(answer), r"unseen, choice .* far.csv\n +FAILS: errs by 5")
        self.assertIn("far.csv: the reference differs by", self.notes[0])
        with unittest.mock.patch.object(Formulas, "results", crashing_at("the unseen", Formulas.results)):
            answer = self.fit(check=near)
        self.assertIn("near.csv, which the fit did not see: it broke", report.missed(answer, fit.Goal(0.05)))

    def test_what_cannot_keep_its_rate_is_tried_at_the_fastest_that_it_can(self):
        with unittest.mock.patch.object(space.Space, "neighbours", lambda *_: []):
            answer = self.fit(SCENE, "full", OneThatSolves)
        self.assertTrue(answer["fits"])
        self.assertIn("implicit_euler", answer["choice"]["method"])
        self.assertEqual(answer["choice"]["rate_hz"], 20.0)  # of 10, 14, 20, 28: nine tenths of 30 and no more

    def test_what_is_unstable_at_the_margin_is_passed_over_and_told(self):
        answer = self.fit(SCENE.replace("200.0", "1000.0"), force_error=0.2)
        self.assert_is(answer["choice"], cheapest(0.2, 2000.0))
        self.assertGreaterEqual(answer["choice"]["largest_margin"], 2.0)
        self.assertLess(answer["next_cheaper"]["cost_us_per_ms"], answer["choice"]["cost_us_per_ms"])
        self.assertIn("unstable at 2 times the contact stiffness", answer["next_cheaper"]["verdict"])

    def test_nothing_dearer_than_the_budget_is_chosen_and_a_miss_is_told(self):
        self.assertTrue(self.fit(budget_us=1.01 * cheapest(0.05)[0])["fits"])
        budget_us = 0.5 * (cheapest(0.05)[0] + 1.0)
        answer = self.fit(budget_us=budget_us)
        self.assertFalse(answer["fits"])
        self.assertLessEqual(answer["choice"]["cost_us_per_ms"], budget_us)
        self.assertEqual(answer["choice"]["error_share"], min(
            row["error_share"] for row in answer["runs"]
            if row["stable"] is not False and row["cost_us_per_ms"] <= budget_us))

    def test_a_voxel_size_that_changes_forces_is_a_fault(self):
        answer = self.fit(runs_of=lambda folder: Formulas(folder, is_faulty=True))
        self.assert_is(answer["choice"], cheapest(0.05))
        voxels = [row for row in answer["runs"] if row["voxel_ratio"]]
        self.assertTrue(voxels)
        for row in voxels:
            self.assertIn("with other voxels", row["verdict"])

    def test_a_fitted_file_with_other_forces_is_not_written(self):
        with unittest.mock.patch.object(scene_files.SceneFiles, "fitted_text", lambda files, *_: files.text):
            with self.assertRaisesRegex(runs.Unusable, "its forces are not those"):
                self.fit()
        self.assertEqual(list(self.out.glob("*.toml")), [])


if __name__ == "__main__":
    daemons.main()
