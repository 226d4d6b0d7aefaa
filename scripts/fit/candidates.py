"""What a fit may choose from, and a choice as changes of the scene."""
import dataclasses
import itertools

FIRST_TRANSITIONS = ("hold", "linear", "predict")
OTHER_TRANSITIONS = ("restart", "hermite", "extrapolate", "playout")
DEFAULT_TRANSITION = "predict"  # of haptic_server
DEFAULT_HZ = 100.0  # of a scene that says nothing

EXPLICIT = "velocity_verlet"
SUNDIALS = "cvode_bdf"  # its second part is the tolerance, m/s
# The laboratory's, beside the product's: what they cost and err is shown, but sim_server does not have them.
COMPARED = ("broyden",)
GIVEN = ("as given",)
METHOD_KEYS = ("integrator", "substeps", "tolerance_m_s", "error_target_m")  # of [simulation]


@dataclasses.dataclass(frozen=True)
class Grid:
    """How finely a fit looks."""
    rates_hz: tuple
    displays: tuple  # other transitions, at the best rates
    methods: tuple  # integrator, and of implicit ones substeps
    voxel_ratios: tuple
    best: int  # how many of the best the rounds go on from
    rounds: int


GRIDS = {
    "small": Grid(rates_hz=(10.0, 33.0, 100.0), displays=(),
                  methods=((EXPLICIT,), ("implicit_euler", 1)),
                  voxel_ratios=(1.5,), best=2, rounds=1),
    "full": Grid(rates_hz=(10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0, 110.0, 160.0, 250.0, 500.0, 1000.0),
                 displays=OTHER_TRANSITIONS,
                 methods=((EXPLICIT,), ("implicit_euler", 1), ("implicit_euler", 2), (SUNDIALS, 1e-5),
                          (SUNDIALS, 1e-3), *((name, 1) for name in COMPARED)),
                 voxel_ratios=(1.0, 1.5, 2.0, 3.0), best=3, rounds=4),
}


@dataclasses.dataclass(frozen=True)
class Candidate:
    """One way to simulate and to show a scene."""
    rate_hz: float
    transition: str = DEFAULT_TRANSITION
    method: tuple = GIVEN
    levels: tuple = ()  # of each group of bodies
    voxel_ratio: float | None = None  # none: as given

    def haptic_options(self):
        """As haptic_server takes them."""
        return ["--transition", self.transition]

    def is_compared_only(self):
        """Whether sim_server lacks its integrator."""
        return self.method[0] in COMPARED

    def but(self, **changes):
        return dataclasses.replace(self, **changes)


def method_text(method):
    if method[0] == SUNDIALS:
        return f"{SUNDIALS} to {method[1]:g} m/s"
    return method[0] + (f" in {method[1]} substeps" if method[1:] > (1,) else "")


class Space:
    """The candidates of one scene."""

    def __init__(self, document, groups, grid):
        self.groups, self.grid = groups, grid
        self.simulation = document.get("simulation", {})
        given_hz = self.simulation.get("rate_hz", 1.0 / self.simulation["period_s"]
                                       if "period_s" in self.simulation else DEFAULT_HZ)
        # "auto" is another method, or rate, at each start; what it is fitted from is to be one.
        self.leaves_rate = given_hz == "auto"
        if self.leaves_rate:
            given_hz = DEFAULT_HZ
        method = ("implicit_euler", 1) if self.simulation.get("integrator") == "auto" else GIVEN
        self.given = Candidate(rate_hz=float(given_hz), method=method, levels=(0,) * len(groups))
        self.rates_hz = sorted({self.given.rate_hz, *grid.rates_hz})
        self.bodies = {body["name"]: i for i, body in enumerate(document.get("body", []))}

    def changes(self, candidate):
        """What the candidate changes of the scene: paths of toml_edit, and values."""
        changes = {}
        if candidate.rate_hz != self.given.rate_hz or self.leaves_rate:
            changes["simulation", "rate_hz"] = candidate.rate_hz
        if candidate.method != GIVEN:
            integrator, *value = candidate.method
            changes["simulation", "integrator"] = integrator
            if value:
                changes["simulation", "tolerance_m_s" if integrator == SUNDIALS else "substeps"] = value[0]
            changes.update({("simulation", key): None for key in METHOD_KEYS
                            if key in self.simulation and ("simulation", key) not in changes})
        for group, level in zip(self.groups, candidate.levels):
            for body, (key, value) in itertools.product(group.bodies, group.levels[level].changes.items()):
                changes["body", self.bodies[body], key] = value
        if candidate.voxel_ratio is not None:
            changes["grid", "voxel_ratio"] = candidate.voxel_ratio
        return changes

    def files(self, candidate):
        """Of spheres, that were made for it; in the fit's folder."""
        return [f"inputs/{file}" for group, level in zip(self.groups, candidate.levels)
                for file in group.levels[level].files]

    def describe(self, candidate):
        """In words."""
        parts = [f"{candidate.rate_hz:g} Hz", candidate.transition]
        if candidate.method != GIVEN:
            parts.append(method_text(candidate.method))
        parts += [f"{group.name}: {group.levels[level].label}"
                  for group, level in zip(self.groups, candidate.levels) if level]
        if candidate.voxel_ratio is not None:
            parts.append(f"voxel ratio {candidate.voxel_ratio:g}")
        return ", ".join(parts)

    def rates_and_transitions(self):
        return [self.given.but(rate_hz=rate_hz, transition=transition)
                for rate_hz in self.rates_hz for transition in FIRST_TRANSITIONS]

    def other_displays(self, candidate):
        return [candidate.but(transition=name) for name in self.grid.displays]

    def coarser(self, candidate):
        """Each group at each level, and all together at each."""
        found = [candidate.but(levels=(*candidate.levels[:i], level, *candidate.levels[i + 1:]))
                 for i, group in enumerate(self.groups) for level in range(len(group.levels))]
        most = max((len(group.levels) for group in self.groups), default=1)
        return found + [candidate.but(levels=tuple(min(level, len(group.levels) - 1) for group in self.groups))
                        for level in range(1, most)]

    def other_methods(self, candidate):
        others = [method for method in self.grid.methods if method != self.method_given()]
        return [candidate.but(method=method) for method in (self.given.method, *others)]

    def method_given(self):
        """The scene's, as the grid has methods."""
        integrator = self.simulation.get("integrator", "implicit_euler")
        if integrator == SUNDIALS:
            return (integrator, self.simulation.get("tolerance_m_s", 1e-8))
        return (integrator,) if integrator == EXPLICIT else (integrator, self.simulation.get("substeps", 1))

    def other_voxels(self, candidate):
        return [candidate.but(voxel_ratio=ratio) for ratio in self.grid.voxel_ratios]

    def neighbours(self, candidate):
        """One step along each coordinate."""
        place = self.rates_hz.index(candidate.rate_hz)
        found = [candidate.but(rate_hz=self.rates_hz[i])
                 for i in range(max(place - 2, 0), min(place + 3, len(self.rates_hz)))]
        found += [candidate.but(transition=name) for name in FIRST_TRANSITIONS]
        for i, group in enumerate(self.groups):
            for level in (candidate.levels[i] - 1, candidate.levels[i] + 1):
                if 0 <= level < len(group.levels):
                    found.append(candidate.but(levels=(*candidate.levels[:i], level, *candidate.levels[i + 1:])))
        return found + self.other_methods(candidate) + self.other_voxels(candidate)
