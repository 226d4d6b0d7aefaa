"""The search: rounds of candidates, each judged by error, cost and stability."""
import dataclasses

from report import error_of

TIE = 1.05  # of a cost: no more than two measurements of one run differ by
NEAR = 1.25  # of the least cost: measured again, alone
MOST_FINALISTS = 8
MOST_RIVALS = 6  # measured alone to find the next cheaper
LOAD = 0.9  # of a period, that a step may be expected to take
WORTH = 0.97  # of the cost: another round is made for no less
MOST_STABILITY_RUNS = 24  # a round
ROUNDING = 0.002  # of the force: a last bit's change grew to 3e-6 N of 0.6 N in a scene that falls (docs/replay.md)


@dataclasses.dataclass
class Goal:
    """What a choice must keep to."""
    force_error: float  # share of the true force's rms
    budget_us: float | None = None
    margin: float = 2.0

    def describe(self):
        text = f"{100 * self.force_error:.3g} % of the force"
        return text + (f" for {self.budget_us:g} us" if self.budget_us else "")


@dataclasses.dataclass(eq=False)
class Trial:
    """A candidate and what it came to."""
    candidate: object
    result: dict
    stage: str
    alone: bool = False  # its cost was measured with nothing else running
    stability: dict | None = None
    results: list = dataclasses.field(default_factory=list)  # of each hand; `result` is the worst of them

    @property
    def error(self):
        value = error_of(self.result)
        return float("inf") if value is None else value

    @property
    def cost_us(self):
        value = (self.result.get("cost") or {}).get("processor_us_per_ms")
        return float("inf") if value is None else value

    @property
    def step_share(self):
        """What a slow step takes of its period."""
        return (self.result.get("cost") or {}).get("step_share") or 0.0

    @property
    def latency_share(self):
        return (self.result.get("settings") or {}).get("latency_share")

    def is_stable(self):
        """None where nobody looked."""
        return self.stability.get("stable") if self.stability else None

    def broken(self):
        """Why it cannot be used at all, or nothing."""
        for key in ("refused", "crashed"):
            if key in self.result:
                return self.result[key]
        if self.candidate.is_compared_only():
            return "for comparison: sim_server has no such integrator"
        if self.step_share > 1.0:
            return f"cannot keep its rate: a step takes {100 * self.step_share:.0f} % of the period"
        if self.result.get("problems"):
            return self.result["problems"][0]
        if self.error == float("inf") or self.cost_us == float("inf"):
            return "its force is no number"
        return None

    def faults(self, goal):
        """All that keeps it from being chosen; what nobody looked at does not."""
        if self.broken():
            return [self.broken()]
        faults = []
        if self.error > goal.force_error:
            faults.append(f"errs by {100 * self.error:.3g} %")
        if goal.budget_us is not None and self.cost_us > goal.budget_us:
            faults.append(f"costs {self.cost_us:.3g} us, over the budget of {goal.budget_us:g} us")
        if self.stability and not self.is_stable():
            faults.append(self.stability.get("problem") or
                          f"unstable at {goal.margin:g} times the contact stiffness")
        return faults


def _first_of_each(trials, count):
    """Their candidates, but one of each rate and display."""
    found = {}
    for trial in trials:
        found.setdefault((trial.candidate.rate_hz, trial.candidate.transition), trial.candidate)
    return list(found.values())[:count]


class Search:
    """evaluate(candidates, what, alone) and test_stability(trials) do the runs."""

    def __init__(self, space, goal, evaluate, test_stability, jobs):
        self.space, self.goal, self.jobs = space, goal, jobs
        self._evaluate, self._test_stability = evaluate, test_stability
        self.trials = {}  # by candidate

    def fitting(self):
        """All that may be chosen as far as one knows, the cheapest first."""
        return sorted((trial for trial in self.trials.values() if self.fits(trial)),
                      key=lambda trial: trial.cost_us)

    def best(self, count):
        """Where to go on from, no two of one rate and display: the cheapest within the tolerance, were they over the
        budget; where they are few, the most accurate of the others; and where nothing fits yet, the most accurate
        within the budget."""
        def near(trial):
            is_near = trial.error <= self.goal.force_error
            return not is_near, trial.cost_us if is_near else trial.error

        usable = sorted(self.usable(), key=near)
        chosen = _first_of_each(usable, count)
        if not self.fitting():
            accurate = sorted(filter(self.is_within_budget, usable), key=lambda trial: trial.error)
            chosen += _first_of_each(accurate, count)
        return list(dict.fromkeys(chosen))

    def slowed(self):
        """What errs less than all that can be used, but cannot keep its rate, at the fastest rate that it could."""
        least = min((trial.error for trial in self.usable()), default=float("inf"))
        found = []
        for trial in self.trials.values():
            if trial.step_share > 1.0 and not trial.candidate.is_compared_only() and trial.error < max(least, self.goal.force_error):
                most_hz = LOAD * trial.candidate.rate_hz / trial.step_share
                slower = [rate_hz for rate_hz in self.space.rates_hz if rate_hz <= most_hz]
                found += [trial.candidate.but(rate_hz=slower[-1])] if slower else []
        return found

    def is_within_budget(self, trial):
        return self.goal.budget_us is None or trial.cost_us <= self.goal.budget_us

    def usable(self):
        return [trial for trial in self.trials.values() if not trial.broken() and trial.is_stable() is not False]

    def fits(self, trial):
        """Stability that could not be tested stands in the way only where that of others could."""
        faults = trial.faults(self.goal)
        if trial.stability and trial.is_stable() is None and trial.stability.get("problem") in faults:
            return len(faults) == 1 and all(other.is_stable() is None for other in self.trials.values())
        return not faults

    def try_all(self, what, candidates):
        new = [candidate for candidate in dict.fromkeys(candidates) if candidate not in self.trials]
        for trial in self._evaluate(new, what, False) if new else []:
            self.trials[trial.candidate] = trial

    def find_stable(self, what):
        """Tests what fits, cheapest first, until one holds."""
        tested = 0
        while tested < MOST_STABILITY_RUNS:
            fitting = self.fitting()
            untested = [trial for trial in fitting if trial.stability is None][:self.jobs]
            if not fitting or fitting[0].stability or not untested:
                return
            self._test_stability(untested, what)
            tested += len(untested)

    def least_cost_us(self):
        fitting = self.fitting()
        return fitting[0].cost_us if fitting else float("inf")

    def check_voxels(self):
        """The voxel's size may change no force but by rounding, which contacts let grow."""
        errors = {}
        for trial in self.trials.values():
            if trial.broken():
                continue
            same = trial.candidate.but(voxel_ratio=None), trial.latency_share
            if abs(errors.setdefault(same, trial.error) - trial.error) > ROUNDING:
                trial.result = {**trial.result, "problems": [f"errs by {100 * trial.error:.3g} %, but by "
                                                             f"{100 * errors[same]:.3g} % with other voxels"]}

    def explore(self):
        """All rounds."""
        space, best = self.space, self.space.grid.best
        self.try_all("rates and transitions", [space.given, *space.rates_and_transitions()])
        self.find_stable("stability")
        rates = list(dict.fromkeys(candidate.rate_hz for candidate in self.best(3 * best)))[:min(best, 2)]
        self.try_all("other displays", [other for rate_hz in rates
                                        for other in space.other_displays(space.given.but(rate_hz=rate_hz))])
        for what, variants, count in (("methods", space.other_methods, min(best, 2)),
                                      ("levels of detail", space.coarser, best),
                                      ("voxel sizes", space.other_voxels, 1)):
            self.try_all(what, [other for candidate in self.best(count) for other in variants(candidate)])
            self.try_all(what, self.slowed())
            self.check_voxels()
            self.find_stable("stability")
        for number in range(space.grid.rounds):
            before_us = self.least_cost_us()
            self.try_all(f"round {number + 1}", [other for candidate in self.best(min(best, 2))
                                                 for other in space.neighbours(candidate)])
            self.try_all(f"round {number + 1}", self.slowed())
            self.check_voxels()
            self.find_stable("stability")
            if not self.least_cost_us() < WORTH * before_us:
                break

    def measure_alone(self, trials, what="finalists, alone"):
        for trial in self._evaluate([trial.candidate for trial in trials], what, True):
            old = self.trials[trial.candidate]
            same = trial.latency_share == old.latency_share
            trial.stage, trial.stability = old.stage, old.stability if same else None
            self.trials[trial.candidate] = trial
        self.check_voxels()

    def choose(self):
        """The cheapest that holds, its cost and that of its rivals measured alone; of those that cost as much, the
        scene as given, or else the most accurate; nothing if none holds."""
        while True:
            fitting = self.fitting()
            if not fitting:
                return None
            near = [trial for trial in fitting if trial.cost_us <= NEAR * fitting[0].cost_us][:MOST_FINALISTS]
            shared = [trial for trial in near if not trial.alone]
            if shared:
                self.measure_alone(shared)
            elif fitting[0].stability is None:
                self._test_stability(fitting[:1], "stability")
            else:
                equals = [trial for trial in fitting if trial.cost_us <= TIE * fitting[0].cost_us and trial.alone]
                choice = min(equals, key=lambda trial: (trial.candidate != self.space.given, round(trial.error, 3),
                                                        trial.cost_us))
                if choice.stability:
                    return choice
                self._test_stability([choice], "stability")

    def closest(self):
        """Where none fits: the most accurate of those that can be used and are within the budget."""
        while True:
            usable = [trial for trial in self.usable() if self.is_within_budget(trial)]
            if not usable:
                return None
            nearest = min(usable, key=lambda trial: (trial.error, trial.cost_us))
            if not nearest.alone:
                self.measure_alone([nearest])
            elif nearest.stability is None:
                self._test_stability([nearest], "stability")
            else:
                return nearest

    def conclude(self):
        """The choice and the next cheaper; or the closest to a choice, and nothing."""
        while True:
            choice = self.choose()
            if choice is None:
                return self.closest(), None
            cheaper = self.next_cheaper(choice)
            if cheaper is None or not self.fits(cheaper):
                return choice, cheaper
            # Measured alone, it may prove to fit after all.
            self._test_stability([cheaper], "stability")

    def next_cheaper(self, choice):
        """The dearest of all that cost less, but for its equals; nothing where none does."""
        for _ in range(MOST_RIVALS):
            cheaper = self.cheaper_than(choice)
            if not cheaper or cheaper[0].alone:
                break
            self.measure_alone(cheaper[:1], "the next cheaper, alone")
        cheaper = self.cheaper_than(choice)
        return next((trial for trial in cheaper if trial.alone), cheaper[0] if cheaper else None)

    def cheaper_than(self, choice):
        """All that cost less and may not be had for that, the dearest first."""
        return sorted((trial for trial in self.trials.values()
                       if trial.cost_us < choice.cost_us and trial.error < float("inf")
                       and not (trial.alone and trial.stability and self.fits(trial))),
                      key=lambda trial: -trial.cost_us)

