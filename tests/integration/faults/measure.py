"""What a fault did to the force, from the log of what the device was told."""
import dataclasses
import typing

import numpy

from faults.call_log import (ACTIVATE, DEACTIVATE, EMERGENCY_STOP, FAULT_BEGINS, FAULT_ENDS,
                             IGNORED_WRITE, WRITE, force_norms_N)

MAX_FORCE_N = 3.3  # as faulty_driver.cpp declares
MAX_SLEW_N_PER_MS = 0.1 * MAX_FORCE_N
FADE_N_PER_MS = MAX_FORCE_N / 100.0  # of a force at the limit
PERIOD_MS = 1.0
STALL_MS = 50.0  # without a tick: zero at once
ROUNDING = 1e-6


@dataclasses.dataclass
class Measured:
    """Times in ms from the moment the fault began; none: it did not come to that."""
    force_N: float  # the largest
    step_N_per_ms: float  # the fastest change, cuts left out
    cut_N: float  # the largest force that went to zero at once
    zero_ms: typing.Optional[float]
    recovered_ms: typing.Optional[float]  # from the end of the fault to the full force, which stays
    gap_ms: float  # the longest without a tick while the force went to zero, or at all


def moment_ms(records, call):
    """When it was first called, or nothing."""
    at = numpy.flatnonzero(records["call"] == call)
    return records["time_ns"][at[0]] * 1e-6 if len(at) else None


def fault_moments_ms(records):
    return moment_ms(records, FAULT_BEGINS), moment_ms(records, FAULT_ENDS)


def growth_N(held, force):
    """How much of a change is growth or turn: the norm may fall at once."""
    norm, held_norm = numpy.linalg.norm(force), numpy.linalg.norm(held)
    return numpy.linalg.norm(force - held * min(1.0, norm / held_norm if held_norm else 1.0))


def steps(records):
    """Changes from one commanded force to the next: size, time between the ticks, whether a cut, index,
    how much of it is growth or turn, and the time between the writes.

    A tick's stamp is the host's; broken_limits() holds it to real time.
    """
    held, tick_ms, written_ms, found = numpy.zeros(3), None, None, []
    for i, record in enumerate(records):
        call = record["call"]
        if call == WRITE:
            passed_ms = (record["tick_ns"] * 1e-6 - tick_ms) if tick_ms is not None else 1.0
            change_N = numpy.linalg.norm(record["force_N"] - held)
            is_cut = passed_ms >= STALL_MS and not record["force_N"].any()
            apart_ms = record["time_ns"] * 1e-6 - written_ms if written_ms is not None else 1.0
            found.append((change_N, passed_ms, is_cut, i, growth_N(held, record["force_N"]), apart_ms))
            written_ms = record["time_ns"] * 1e-6
            held, tick_ms = record["force_N"], record["tick_ns"] * 1e-6
        elif call in (DEACTIVATE, EMERGENCY_STOP, ACTIVATE):
            found.append((numpy.linalg.norm(held), 0.0, True, i, 0.0, 0.0))
            held = numpy.zeros(3)
        elif call == IGNORED_WRITE:
            tick_ms = record["tick_ns"] * 1e-6
    return found


def broken_limits(records):
    """A line for each limit that the whole run broke."""
    broken = []
    force_N = force_norms_N(records)
    if force_N.max() > MAX_FORCE_N * (1.0 + ROUNDING):
        broken.append(f"told {force_N.max():.6g} N, limit {MAX_FORCE_N}")
    for _, _, is_cut, i, grown_N, apart_ms in steps(records):
        # From write to write; one that comes late is granted no more than a period's growth.
        if not is_cut and grown_N > MAX_SLEW_N_PER_MS * min(apart_ms, 1.0) * (1.0 + ROUNDING):
            broken.append(f"call {i}: grown by {grown_N:.4g} N in {apart_ms:.4g} ms, limit "
                          f"{MAX_SLEW_N_PER_MS:.4g} N/ms")
            break
    writes = records[records["call"] == WRITE]
    if (writes["tick_ns"] > writes["time_ns"]).any() or \
            (writes["tick_ns"][1:] < writes["time_ns"][:-1]).any():
        broken.append("a tick's stamp is not within the time since the tick before")
    return broken


def measure(records, began_ms, ended_ms, full_N):
    time_ms, force_N = records["time_ns"] * 1e-6, force_norms_N(records)
    after = time_ms >= began_ms
    is_told = ~numpy.isin(records["call"], (FAULT_BEGINS, FAULT_ENDS))
    first = max(int(numpy.argmax(after)) - 1, 0)
    taken = [step for step in steps(records) if step[3] > first]
    zeros = numpy.flatnonzero(after & is_told & (force_N == 0.0))
    judged = slice(first, zeros[0] + 1 if len(zeros) else len(records))
    recovered_ms = None
    if ended_ms is not None:
        other = numpy.flatnonzero(after & is_told & (abs(force_N - full_N) > 0.01 * full_N))
        back_ms = time_ms[min(other[-1] + 1, len(records) - 1)] if len(other) else ended_ms
        recovered_ms = max(back_ms - ended_ms, 0.0)
    return Measured(
        force_N=force_N[after].max(initial=0.0),
        # A tick that follows a late one soon is of a whole period.
        step_N_per_ms=max((change_N / max(passed_ms, PERIOD_MS) for change_N, passed_ms, is_cut, *_ in taken
                       if not is_cut), default=0.0),
        cut_N=max((change_N for change_N, _, is_cut, *_ in taken if is_cut), default=0.0),
        zero_ms=time_ms[zeros[0]] - began_ms if len(zeros) else None,
        recovered_ms=recovered_ms,
        gap_ms=numpy.diff(time_ms[judged]).max(initial=0.0))
