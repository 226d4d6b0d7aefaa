"""Judges candidates on hands, and looks for the cheapest that keeps the force and is stable."""
import csv
import dataclasses
import hashlib
import json
import math
import subprocess

import messages
import recorded_frame
import scene_candidates

WORK_PER_US = 170.0  # counted work of one processor (sim_server/dynamics/choice/counted_work.hpp)
WORTH = 0.97  # of the cost: another round is made for no less
TRANSITIONS = ("hold", "linear", "local")
RATES_HZ = {"small": (10.0, 33.0, 100.0),
            "full": (10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0, 110.0, 160.0, 250.0, 500.0, 1000.0)}


class Hand:
    """A trajectory, and the judge of scene files on it: sim_server --try."""

    def __init__(self, name, scene, folder, program, settle_s):
        self.name, self.scene, self.folder, self.program, self.settle_s = name, scene, folder, program, settle_s
        self.file = folder / f"hand_{hashlib.sha256(str(name).encode()).hexdigest()[:8]}.csv"
        self.file.write_text(self.read(name), encoding="utf-8")
        self.given = self.write(scene.given, "given")
        self.process, self.texts = None, {}
        # Judged before, by a hash of all that a record depends on.
        stat = program.stat()
        self.world = f"{self.file.read_text()}{self.given.read_text()}{stat.st_size} {stat.st_mtime_ns}"
        self.kept_file = folder / "records.jsonl"
        lines = self.kept_file.read_text().splitlines() if self.kept_file.exists() else []
        self.kept = {one["key"]: one for one in map(json.loads, lines)}

    def read(self, trajectory):
        """A recording of haptic_server is laid back into the device's frame."""
        try:
            if not recorded_frame.is_recording(trajectory):
                return trajectory.read_text(encoding="utf-8")
            options = recorded_frame.laid_back(trajectory, self.scene.document.get("device", {}))
            back = {name: float(value) for name, value in (one.split("=") for one in options.split(",") if one)}
            with open(trajectory, encoding="utf-8") as stream:
                rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
            return "time_s,x_m,y_m,z_m\n" + "".join(
                ",".join([row.get("time_s") or row["t_s"]] + [
                    repr(float(row[f"{axis}_m"]) * back.get("scale", 1.0) + back.get(f"offset_{axis}_m", 0.0))
                    for axis in "xyz"]) + "\n" for row in rows)
        except (OSError, UnicodeDecodeError, ValueError, KeyError) as error:
            raise messages.Unusable(f"{trajectory}: {error}") from error

    def write(self, candidate, name):
        file = self.folder / f"{name}_{self.file.stem}.toml"
        file.write_text(self.scene.text_of(candidate, self.folder, self.file, self.settle_s), encoding="utf-8",
                        newline="")
        return file

    def judge(self, candidates):
        """Their records."""
        keys, lines = [], {}
        for i, candidate in enumerate(candidates):
            file = self.write(candidate, f"candidate_{i}")
            key = hashlib.sha256(f"{self.world}{file.read_text()}{candidate.transition}".encode()).hexdigest()
            keys.append(key)
            if key not in self.kept:
                lines[key] = f"{file} {candidate.transition}\n"
        if lines:
            if not self.process:
                self.process = subprocess.Popen([self.program, "--scene", self.given, "--try"], text=True,
                                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            try:
                self.process.stdin.write("".join(lines.values()) + "\n")
                self.process.stdin.flush()
            except BrokenPipeError:
                pass
            with open(self.kept_file, "a", encoding="utf-8") as kept:
                for key in lines:
                    line = self.process.stdout.readline()
                    if not line:
                        raise messages.Unusable(self.process.stderr.read().strip().splitlines()[-1])
                    self.kept[key] = {"key": key, **json.loads(line)}
                    kept.write(json.dumps(self.kept[key]) + "\n")
        return [self.kept[key] for key in keys]


@dataclasses.dataclass(eq=False)
class Trial:
    candidate: scene_candidates.Candidate
    records: list  # of each hand
    stability: dict | None = None

    @property
    def error(self):
        errors = [record["error_share"] for record in self.records]
        return math.inf if None in errors else max(errors)

    @property
    def cost_us(self):
        return max(record["work_per_ms"] for record in self.records) / WORK_PER_US

    def faults(self, goal):
        refused = next((record["refusal"] for record in self.records if record["refusal"]), None)
        if refused or self.error == math.inf:
            return [refused or "the hand touches nothing"]
        faults = [f"errs by {100 * self.error:.3g} %"] * (self.error > goal.force_error)
        if goal.budget_us and self.cost_us > goal.budget_us:
            faults.append(f"costs {self.cost_us:.3g} us, over the budget of {goal.budget_us:g} us")
        if self.stability and self.stability["stable"] is False:
            faults.append(f"unstable at {goal.margin:g} times the contact stiffness")
        return faults


class Search:
    """Rounds of candidates around the best, then the cheapest that is stable."""

    def __init__(self, scene, goal, hands, fit_run):
        self.scene, self.goal, self.hands, self.fit_run = scene, goal, hands, fit_run
        self.rates_hz = sorted({scene.given.rate_hz, *RATES_HZ[goal.grid]})
        self.trials = {}

    def try_all(self, candidates):
        new = [one for one in dict.fromkeys(candidates) if one not in self.trials]
        found = [hand.judge(new) for hand in self.hands] if new else []
        for i, one in enumerate(new):
            self.trials[one] = Trial(one, [records[i] for records in found])

    def rank(self, trial):
        """The cheapest without a fault, then the most accurate that runs at all. Of two as cheap the nearer."""
        faults = trial.faults(self.goal)
        runs = trial.error < math.inf and not any(record["refusal"] for record in trial.records)
        is_over = bool(self.goal.budget_us) and trial.cost_us > self.goal.budget_us
        figure = trial.error if faults else trial.cost_us
        return bool(faults), not runs, is_over, figure, trial.candidate != self.scene.given, trial.error

    def best(self, count):
        return [trial.candidate for trial in sorted(self.trials.values(), key=self.rank)[:count]]

    def other_levels(self, candidate):
        found = [candidate.but(levels=(*candidate.levels[:i], level, *candidate.levels[i + 1:]))
                 for i, (_, group) in enumerate(self.scene.groups) for level in range(len(group))]
        most = max((len(group) for _, group in self.scene.groups), default=1)
        return found + [candidate.but(levels=tuple(min(level, len(group) - 1) for _, group in self.scene.groups))
                        for level in range(1, most)]

    def neighbours(self, candidate):
        place = self.rates_hz.index(candidate.rate_hz)
        return ([candidate.but(rate_hz=hz) for hz in self.rates_hz[max(place - 2, 0):place + 3]]
                + [candidate.but(transition=name) for name in TRANSITIONS]
                + [candidate.but(method=method) for method in scene_candidates.METHODS] + self.other_levels(candidate))

    def explore(self):
        given = self.scene.given
        self.try_all([given, *(given.but(rate_hz=hz, transition=name)
                               for hz in self.rates_hz for name in TRANSITIONS)])
        for _ in range(4 if self.goal.grid == "full" else 1):
            before_us = self.trials[self.best(1)[0]].cost_us
            self.try_all([other for one in self.best(2) for other in self.neighbours(one)])
            if not self.trials[self.best(1)[0]].cost_us < WORTH * before_us:
                break

    def test_stability(self, trial, *more):
        """Of several hands the worst counts."""
        found = []
        for hand, record in zip(self.hands, trial.records):
            file = hand.write(trial.candidate, "held")
            done = subprocess.run([self.fit_run, file, "--transition", trial.candidate.transition, "--device",
                                   self.goal.device, "--margin", f"{self.goal.margin:g}", "--latency-share",
                                   f"{min(1.0, record['latency_share']):g}", *more], capture_output=True, text=True,
                                  check=False)
            if done.returncode:
                raise messages.Unusable(done.stderr.strip() or f"{self.fit_run}: status {done.returncode}")
            found.append(json.loads(done.stdout))
        trial.stability = min(found, key=lambda one: (one["stable"] is not False, one["largest_margin"] or 0.0))

    def choose(self):
        """The cheapest that is stable, or else the closest."""
        while True:
            best = self.trials[self.best(1)[0]]
            if best.faults(self.goal) or best.stability:
                return best
            self.test_stability(best)
