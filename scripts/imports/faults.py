"""Finds what no hand did: gaps in time, jumps of place and of orientation."""
import dataclasses

import numpy

import rotations

SLACK_M = 1e-3  # a step so small is noise, however short its time
SLACK_RAD = 0.05


@dataclasses.dataclass
class Limits:
    gap_s: float
    speed_m_s: float
    turn_rad_s: float


@dataclasses.dataclass
class Fault:
    """Between a row of the trajectory and the next. kind: gap, jump or turn, a jump of the orientation."""

    kind: str
    row: int
    start_s: float
    duration_s: float
    size: float  # metres that were moved meanwhile, or radians

    def text(self, trajectory):
        there = f"{trajectory.table.place(trajectory.rows[self.row + 1])}: {self.kind}"
        if self.kind == "gap":
            return (f"{there} of {self.duration_s:.4g} s from {self.start_s:.4f} s on, {1e3 * self.size:.4g} mm moved "
                    "meanwhile")
        size = f"{1e3 * self.size:.4g} mm" if self.kind == "jump" else f"{numpy.degrees(self.size):.4g} degrees"
        return f"{there} of {size} in {1e3 * self.duration_s:.4g} ms at {self.start_s + self.duration_s:.4f} s"


def find(trajectory, limits):
    """In order of time; a gap is no jump as well."""
    steps_s = numpy.diff(trajectory.time_s)
    moved_m = numpy.linalg.norm(numpy.diff(trajectory.position_m, axis=0), axis=1)
    is_gap = steps_s > limits.gap_s * (1.0 + 1e-9)
    faults = [Fault("gap", i, trajectory.time_s[i], steps_s[i], moved_m[i]) for i in numpy.flatnonzero(is_gap)]
    kinds = [("jump", moved_m, SLACK_M, limits.speed_m_s)]
    if trajectory.turns is not None:
        kinds.append(("turn", rotations.angles_rad(trajectory.turns), SLACK_RAD, limits.turn_rad_s))
    for kind, moved, slack, speed in kinds:
        meanwhile_s = numpy.maximum(steps_s, fresh_s(trajectory.time_s, moved, limits.gap_s))
        is_jump = ~is_gap & (moved > slack + speed * meanwhile_s)
        faults += [Fault(kind, i, trajectory.time_s[i], steps_s[i], moved[i]) for i in numpy.flatnonzero(is_jump)]
    return sorted(faults, key=lambda fault: (fault.row, fault.kind))


def fresh_s(time_s, moved, longest_s):
    """How far apart readings come that are new: poses of 28 Hz are repeated in rows of 1 kHz, and their steps are no
    jumps. Of a hand that rests now and then it is the rows' own interval."""
    changes_s = time_s[1:][moved > 0.0]
    if len(changes_s) < 3:
        return 0.0
    return min(float(numpy.median(numpy.diff(changes_s))), longest_s)
