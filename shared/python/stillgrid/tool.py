"""What was felt in a tick."""
import ctypes
import dataclasses
from collections.abc import Callable
from typing import Any

import numpy

from . import _library
from ._arrays import Floats
from .errors import Code


@dataclasses.dataclass(frozen=True)
class Tool:
    """One tick of a haptic_server, in the scene's frame. Force and torque are those on the hand over the
    tick before."""

    time_ns: int
    tick: int
    position_m: Floats
    orientation_xyzw: Floats
    velocity_m_s: Floats
    force_N: Floats
    torque_N_m: Floats
    buttons: int  # a bit a button
    gripper_m: float  # NaN where there is none, as axes
    axes: Floats
    contacts: int
    safety_flags: int  # docs/safety.md
    missed_ticks: int  # since it began
    work_ns: int  # of the tick; 0 in virtual time
    snapshot_id: int  # that was displayed; 0: none
    age_s: float  # of its state, when it was displayed


_FIELDS = [field.name for field in dataclasses.fields(Tool)]


def take_tool(call: Callable[[Any], int]) -> Tool | None:
    """A tool by the call that fills its struct; None where there is none."""
    figures = _library.Tool()
    if call(ctypes.byref(figures)) == Code.NOTHING:
        return None
    values: list[Any] = [getattr(figures, name) for name in _FIELDS]
    values = [numpy.array(value) if isinstance(value, ctypes.Array) else value for value in values]
    return Tool(*values)
