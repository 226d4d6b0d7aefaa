"""A reader's side of a session: what its simulation and one haptic_server publish, for loggers and GUIs."""
import ctypes
import dataclasses
from typing import Any

import numpy
from numpy.typing import NDArray

from . import _library
from ._arrays import Floats, address
from .errors import Code, StillgridError
from .scene import Hand, Material, Plane
from .tool import Tool, take_tool


@dataclasses.dataclass(frozen=True)
class State:
    """Who is there."""

    is_virtual_time: bool
    is_published: bool  # its simulation lives
    is_felt: bool  # so does its haptic_server
    scene_epoch: int  # random, of this run of the simulation; 0: none was seen
    tool_epoch: int
    publication_period_s: float
    tick_period_s: float
    snapshots: int  # published
    ticks: int
    sphere_capacity: int
    static_count: int
    scene_name: str


@dataclasses.dataclass(frozen=True)
class Fixed:
    """What is published once."""

    materials: list[Material]
    planes: list[Plane]
    hand: Hand


@dataclasses.dataclass(frozen=True)
class Snapshot:
    """Spheres at a time: arrays of N rows, float32 as they are published; times on the scene's clock. A
    sphere that is not there has no place: NaN."""

    snapshot_id: int
    state_time_ns: int
    publish_time_ns: int
    tool_time_ns: int  # of the tool in it; 0: none
    step_ns: int  # what its step cost
    contacts: int  # in the simulation
    positions_m: NDArray[numpy.float32]  # (N, 3), as the one below
    velocities_m_s: NDArray[numpy.float32]
    radii_m: NDArray[numpy.float32]  # (N,), as the two below
    materials: NDArray[numpy.uint32]
    bodies: NDArray[numpy.uint32]


_ARRAYS: dict[str, tuple[tuple[int, ...], Any]] = {
    "positions_m": ((3,), numpy.float32), "velocities_m_s": ((3,), numpy.float32),
    "radii_m": ((), numpy.float32),
    "materials": ((), numpy.uint32), "bodies": ((), numpy.uint32)}
_NUMBERS = ("snapshot_id", "state_time_ns", "publish_time_ns", "tool_time_ns", "step_ns", "contacts")


class Reader:
    """Looks at a session, and at one hand of it, there or not yet; its writers notice nothing.

    poll() takes up what came and drops what went; the other calls read what the last poll found, and
    give None where there is nothing. close(), or leaving a with block, ends it. One thread at a time.
    """

    def __init__(self, session: str | None = None, hand: str | None = None):
        """session: None is "default". hand: None is the only one."""
        self._handle = ctypes.c_void_p()
        self._state = _library.SessionState()
        _library.check(_library.function("reader_open")(
            _library.encoded(session), _library.encoded(hand), ctypes.byref(self._handle)))

    def close(self) -> None:
        """Twice does nothing."""
        handle, self._handle = self._handle, ctypes.c_void_p()
        _library.function("reader_close")(handle)

    def __copy__(self) -> "Reader":
        raise TypeError("a Reader is one program's: expected no copy")

    def __deepcopy__(self, _: object) -> "Reader":
        return self.__copy__()

    def __enter__(self) -> "Reader":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self.close()

    def poll(self) -> State:
        """Who is there now; to be asked some 10 times a second or more often."""
        self._checked("poll", ctypes.byref(self._state))
        state = self._state
        return State(
            state.clock == _library.VIRTUAL_TIME, bool(state.is_published), bool(state.is_felt),
            state.scene_epoch, state.tool_epoch, 1e-9 * state.publication_period_ns,
            1e-9 * state.tick_period_ns, state.snapshots, state.ticks, state.sphere_capacity,
            state.static_count, state.scene_name.decode(errors="replace"))

    def fixed(self) -> Fixed | None:
        """Materials, planes, the tool and where its device stands."""
        state = self._state
        materials = (_library.Material * state.material_count)()
        planes = (_library.Plane * state.plane_count)()
        tool_m: Floats = numpy.empty((state.tool_count, 4))
        fixed = _library.Fixed(
            material_capacity=len(materials), plane_capacity=len(planes), tool_capacity=len(tool_m),
            materials=materials, planes=planes, tool_m=address(tool_m))
        if self._checked("fixed", ctypes.byref(fixed)) == Code.NOTHING:
            return None
        return Fixed(
            [Material(*(getattr(one, name) for name, *_ in one._fields_)) for one in materials],
            [Plane(tuple(one.normal), one.offset_m, one.material, one.body) for one in planes],
            Hand(tool_m, device_position_m=tuple(fixed.device_position_m),
                 device_orientation_xyzw=tuple(fixed.device_orientation_xyzw),
                 device_scale=fixed.device_scale))

    def snapshot(self) -> Snapshot | None:
        """The newest snapshot, whole. None: none yet, or overtaken at each attempt."""
        return self._spheres("snapshot", self._state.sphere_capacity)

    def static(self) -> Snapshot | None:
        """The static spheres; the times are 0."""
        return self._spheres("static", self._state.static_count)

    def displayed(self) -> Snapshot | None:
        """As snapshot(), but where the hand feels the spheres at the newest tick: between snapshots,
        and given way where the tick shows the newest one. Velocities are NaN."""
        return self._spheres("displayed", self._state.sphere_capacity)

    def tool(self) -> Tool | None:
        """The newest tick. None: no haptic_server is there."""
        return take_tool(lambda figures: self._checked("tool", figures))

    def _spheres(self, call: str, capacity: int) -> Snapshot | None:
        arrays = {name: numpy.zeros((capacity, *shape), kind) for name, (shape, kind) in _ARRAYS.items()}
        snapshot = _library.Snapshot(
            capacity=capacity, **{name: address(array) for name, array in arrays.items()})
        if self._checked(call, ctypes.byref(snapshot)) == Code.NOTHING:
            return None
        count = min(snapshot.count, capacity)
        told: dict[str, Any] = {name: getattr(snapshot, name) for name in _NUMBERS}
        told |= {name: array[:count] for name, array in arrays.items()}
        return Snapshot(**told)

    def _checked(self, call: str, *arguments: Any) -> int:
        if not self._handle:
            raise StillgridError(Code.ORDER, f"{call}: expected a reader that is not closed")
        return _library.check(_library.function(f"reader_{call}")(self._handle, *arguments))
