"""The hands of a fit: trajectories with their references, and what several of them say together: the worst."""
import csv
import math

from report import error_of

NEAR_M = 0.03  # that a body may move in the meantime, or bodies between it and the hand are thick
# How far a body is thought to extend beyond its nodes, or a rigid one from its centre.
EXTENT = {"sheet": lambda _: 0.0, "thread": lambda _: 0.0, "soft_block": lambda _: 0.0,
          "rigid_box": lambda body: 0.5 * math.hypot(*body["size_m"])}


def failure_of(result):
    """The line of a run that was refused or crashed, or nothing."""
    return result.get("refused") or result.get("crashed")


class Hand:
    """A trajectory with its reference: what each run is given, and which files it reads."""

    def __init__(self, arguments, files, trajectory, runs):
        self.files, self.runs, self.trajectory = files, runs, trajectory
        self.reference = self.own_error = None
        copy = files.copy(trajectory.resolve())
        self.options = ["--trajectory", f"inputs/{copy.name}"]
        self.needed = [*files.needed, f"inputs/{copy.name}"]
        # A recording of haptic_server is in the scene's frame, whatever its device's.
        replay = arguments.replay or files.laid_back(trajectory)
        for name, value in (("--replay", replay), ("--duration", arguments.duration),
                            ("--settle", arguments.settle)):
            if value:
                self.options += [name, str(value)]

    @property
    def scene(self):
        return f"inputs/{self.files.scene.name}"

    def make_reference(self, steps_per_tick):
        """Its name; it is made where it is not there."""
        arguments = [self.scene, *self.options, "--steps-per-tick", str(steps_per_tick)]
        file = f"inputs/reference_{self.runs.key(arguments, self.needed)}.csv"
        self.runs.make([*arguments, "--write-reference", file], file)
        return file

    def path_m(self):
        """Of the tool in the scene, a point each 10 ms."""
        return [tuple(map(float, row[1:4])) for row in self.rows_of(self.reference)[::10]]

    def places_m(self):
        """Of each body's nodes when the hand begins; a rigid body's centre."""
        places = {}
        for row in self.rows_of(self.state_of(self.reference)):
            if row[0] == "start":
                places.setdefault(row[2], []).append(tuple(map(float, row[4:7])))
        return places

    def rows_of(self, file):
        """Below the header; none where there is no such file, as of a scene in which nothing moves."""
        if not (self.runs.folder / file).is_file():
            return []
        with open(self.runs.folder / file, encoding="utf-8") as stream:
            return list(csv.reader(line for line in stream if not line.startswith("#")))[1:]

    @staticmethod
    def state_of(reference):
        return reference.removesuffix(".csv") + ".state.csv"

    def request(self, reference, options, files=(), scene=None):
        """As Runs takes it."""
        state = self.state_of(reference)
        read = [*self.needed, *files, reference, *([state] if (self.runs.folder / state).is_file() else [])]
        if scene:
            read.append(scene)
        return (scene or self.scene, *self.options, "--reference", reference, *options), tuple(read)


def far_bodies(document, hands):
    """Names of the bodies that no hand's path comes within NEAR_M of, from where they lie when it begins."""
    tool = document.get("tool", {})
    tool_m = max((math.hypot(*sphere.get("position_m", (0.0,))) + sphere["radius_m"]
                   for sphere in tool.get("spheres", ())), default=tool.get("radius_m", 0.005))
    far = None
    for hand in hands:
        path = hand.path_m()
        places = hand.places_m()
        names = {body["name"] for body in document.get("body", [])
                 if body["kind"] in EXTENT and places.get(body["name"]) and path
                 and min(math.dist(a, b) for a in path for b in places[body["name"]])
                 > NEAR_M + tool_m + EXTENT[body["kind"]](body)}
        far = names if far is None else far & names
    return frozenset(far or ())


def worst_of(results):
    """What the runs of one candidate on all hands come to: the largest error, the highest cost, every problem."""
    failed = next((result for result in results if failure_of(result)), None)
    if failed or len(results) == 1:
        return failed or results[0]

    def error(result):
        value = error_of(result)
        return float("inf") if value is None else value

    costs = [result.get("cost") or {} for result in results]
    dearest = max(costs, key=lambda cost: cost.get("processor_us_per_ms") or float("inf"))
    shares = [cost.get("step_share") or 0.0 for cost in costs]
    latest = max((result.get("settings") or {}).get("latency_share") or 0.0 for result in results)
    worst = max(results, key=error)
    return {**worst, "cost": {**dearest, "step_share": max(shares)} if dearest else None,
            "settings": {**(worst.get("settings") or {}), "latency_share": latest},
            "problems": list(dict.fromkeys(line for result in results for line in result.get("problems") or []))}


def worst_stability(found):
    """Of several hands: unstable in one is unstable; what no hand could test is not tested."""
    unstable = [one for one in found if one.get("stable") is False]
    stable = [one for one in found if one.get("stable")]
    worst = (unstable or stable or found)[0]
    margins = [one.get("largest_margin") for one in found if one.get("stable") is not None]
    if "largest_margin" in worst and margins:
        worst = {**worst, "largest_margin": None if None in margins else min(margins)}
    return worst
