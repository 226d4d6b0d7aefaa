"""One fit: reference, search, choice, the fitted file, and the check of it."""
from hands import Hand, failure_of, worst_of, worst_stability
from report import at, error_of, jnd_of, row_of, summary_of, verdict
from runs import Unusable
from search import Goal, Search, Trial
from toml_edit import literal

REPEATS = 5  # of a run that is timed alone; its cost is the median's
# The reference's own method, as a candidate.
REFERENCE_AS_CANDIDATE = ("--set", "simulation.rate_hz=1000.0", "--set", 'simulation.integrator="implicit_euler"',
                          "--transition", "hold", "--latency-share", "0")


class Fit:
    def __init__(self, arguments, files, runs):
        self.arguments, self.files, self.runs = arguments, files, runs
        self.goal = Goal(arguments.force_error, arguments.budget_us, arguments.margin)
        self.hands = [Hand(arguments, files, trajectory, runs) for trajectory in arguments.trajectory]
        self.unseen = Hand(arguments, files, arguments.check, runs) if arguments.check else None
        self.space = self.search = None

    def check_references(self, note):
        """Of all trajectories, what the reference itself errs: 1 kHz against 2 kHz."""
        for path in filter(None, (*self.hands, self.unseen)):
            self.check_reference(path, note)

    def check_reference(self, path, note):
        self.runs.progress.show("reference", 0, 2)
        path.reference = path.make_reference(1)
        self.runs.progress.show("reference", 1, 2)
        finer = path.make_reference(2)
        self.runs.progress.clear()
        result = self.runs.results("reference", [path.request(finer, REFERENCE_AS_CANDIDATE)], alone=True)[0]
        if failure_of(result):
            raise Unusable(failure_of(result))
        path.own_error = error_of(result)
        if path.own_error is None or not at(result, "reference", "contact_share"):
            raise Unusable(f"{path.trajectory}: the hand touches nothing: expected a trajectory with contact")
        if path.own_error > self.goal.force_error:
            advice = "" if self.arguments.settle else "; where bodies fall first, let them come to rest: --settle 3"
            note(f"warning: {path.trajectory}: the reference differs by {100 * path.own_error:.3g} % when it is "
                 f"simulated at 2 kHz, more than the tolerance of {100 * self.goal.force_error:.3g} %: no method can "
                 f"be judged to within it{advice}")

    def options_of(self, candidate):
        """What fit_run is told of a candidate."""
        names = [body.get("name") for body in self.files.copied.get("body", [])]
        options = []
        for path, value in self.space.changes(candidate).items():
            if value is None:
                continue  # an integrator that is set takes these out
            key = ".".join(names[part] if isinstance(part, int) else part for part in path)
            parts = {f"{key}.{name}": item for name, item in value.items()} if isinstance(value, dict) else {key: value}
            for name, item in parts.items():
                options += ["--set", f"{name}={literal(item)}"]
        return [*options, *candidate.haptic_options()]

    def stability_options(self, trial, hand):
        latency_share = (trial.results[hand].get("settings") or {}).get("latency_share")
        return ["--device", self.arguments.device, "--margin", f"{self.goal.margin:g}", "--latency-share",
                str(latency_share)]

    def on_all_hands(self, what, requests_of, number, alone=False):
        """Of so many candidates the results, one a hand. requests_of(i, j, hand): of candidate i on hand j."""
        requests = [requests_of(i, j, hand) for i in range(number) for j, hand in enumerate(self.hands)]
        results, count = self.runs.results(what, requests, alone), len(self.hands)
        return [results[i * count:(i + 1) * count] for i in range(number)]

    def evaluate(self, candidates, what, alone):
        more = ["--repeats", str(REPEATS)] if alone else []
        found = self.on_all_hands(what, lambda i, _, hand: hand.request(
            hand.reference, self.options_of(candidates[i]) + more, self.space.files(candidates[i])),
            len(candidates), alone)
        return [Trial(candidate, worst_of(results), what, alone, results=results)
                for candidate, results in zip(candidates, found)]

    def test_stability(self, trials, what, more=()):
        found = self.on_all_hands(what, lambda i, j, hand: hand.request(
            hand.reference, [*self.options_of(trials[i].candidate), *self.stability_options(trials[i], j), *more],
            self.space.files(trials[i].candidate)), len(trials))
        for trial, results in zip(trials, found):
            trial.stability = worst_stability([result.get("stability") or {"stable": None} for result in results])
            if trial.is_stable() is None:
                told = [line for result in results for line in result.get("problems") or []
                        if line.startswith("stability")]
                failed = next(filter(None, map(failure_of, results)), None)
                trial.stability["problem"] = (told or [f"stability not tested: {failed}"])[0]

    def fit(self, space, head_of):
        """The whole answer, as fit.json holds it. head_of: the comment of the fitted scene, of this answer."""
        self.space = space
        self.search = search = Search(space, self.goal, self.evaluate, self.test_stability,
                                      self.runs.machines.jobs or 2)
        search.try_all("as given", [space.given])
        given = search.trials[space.given]
        if "refused" in given.result:
            raise Unusable(given.result["refused"])
        search.explore()
        search.measure_alone([given], "as given, alone")
        choice, cheaper = search.conclude()
        given = search.trials[space.given]
        if choice is None:
            raise Unusable(f"{self.files.scene}: {self.why_nothing(given)}")
        shown = [trial for trial in dict.fromkeys((choice, given, cheaper)) if trial and not trial.broken()]
        self.test_stability(shown, "largest margins", ["--search-margin"])
        roles = {"given": given, "choice": choice, "next cheaper": cheaper}
        rows = [{**row_of(trial, space, self.goal),
                 "role": ", ".join(role for role, mine in roles.items() if mine is trial)}
                for trial in search.trials.values()]
        answer = {
            "scene": self.files.scene.stem, "scene_file": str(self.files.scene),
            "trajectory": ", ".join(hand.trajectory.name for hand in self.hands), "force_error": self.goal.force_error,
            "budget_us": self.goal.budget_us, "margin": self.goal.margin, "device": self.arguments.device,
            "settle_s": self.arguments.settle, "replay": self.arguments.replay, "grid": self.arguments.grid,
            "reference_own_error": max(hand.own_error for hand in self.hands), "fits": not choice.faults(self.goal),
            "given": summary_of(given, space, self.goal), "choice": summary_of(choice, space, self.goal),
            "next_cheaper": summary_of(cheaper, space, self.goal), "check": None,
            "runs": rows}
        self.write_fitted(choice, head_of(answer))
        if self.unseen:
            answer["check"] = self.check(choice)
        return answer

    def why_nothing(self, given):
        """Where not even a closest is left."""
        usable = self.search.usable()
        if usable:  # and so there is a budget
            return (f"the cheapest that can be used costs {min(trial.cost_us for trial in usable):.3g} us: expected "
                    f"a larger budget than {self.goal.budget_us:g} us")
        return f"no way to simulate it can be used; as given: {'; '.join(given.faults(self.goal))}"

    def write_fitted(self, choice, head):
        """The fitted scene, once it has given the very forces that were chosen."""
        text = self.files.fitted_text(self.space.changes(choice.candidate), head)
        fitted = self.files.fitted
        part = fitted.with_name(f"{fitted.stem}.part.toml")
        part.write_text(text, encoding="utf-8", newline="")
        try:
            for hand, chosen in zip(self.hands, choice.results):
                request = hand.request(hand.reference, [*choice.candidate.haptic_options(), "--latency-share",
                                                        str(at(chosen, "settings", "latency_share"))], scene=part.name)
                result = self.runs.results("the fitted file", [request], alone=True)[0]
                if result.get("error") != chosen["error"]:
                    why = failure_of(result)
                    raise Unusable(f"{fitted}: its forces are not those of the run that was chosen: expected the same "
                                   f"to the bit{': ' + why if why else ''}")
            part.replace(fitted)
        finally:
            part.unlink(missing_ok=True)

    def check(self, choice):
        """Scene as given and fitted file on the trajectory that the fit did not see."""
        path, repeats = self.unseen, ["--repeats", str(REPEATS)]
        requests = [path.request(path.reference, [*self.space.given.haptic_options(), *repeats]),
                    path.request(path.reference, [*choice.candidate.haptic_options(), *repeats],
                                 scene=self.files.fitted.name)]
        results = self.runs.results("the unseen trajectory", requests, alone=True)
        return {"trajectory": path.trajectory.name, "reference_own_error": path.own_error, **{
            key: {"cost_us_per_ms": at(result, "cost", "processor_us_per_ms"),
                  "error_share": error_of(result), "jnd": jnd_of(error_of(result)),
                  "verdict": verdict(Trial(candidate, result, "check"), self.goal), "result": result}
            for key, candidate, result in zip(("given", "choice"), (self.space.given, choice.candidate), results)}}
