"""A simulation's side of a session."""
import ctypes
from collections.abc import Callable, Iterator
import os
from typing import Any

import numpy
from numpy.typing import ArrayLike

from . import _library
from ._arrays import address, floats, indices, whole
from .errors import Code, StillgridError
from .scene import Scene, scene_struct, shapes_struct
from .tool import Tool, take_tool


class Publisher:
    """Takes a session and publishes a scene into it; close(), or leaving a with block, ends it.

    One thread at a time. float64 arrays that are C-contiguous are read where they are, others are
    converted first. A wrong shape or type is a ValueError, what the library refuses a StillgridError.

        with stillgrid.Publisher(scene, "ball") as publisher:
            publisher.set_shapes(radii_m)
            for time_s in publisher.steps():
                publisher.set_spheres(positions_m, velocities_m_s)
                publisher.publish()
    """

    def __init__(self, scene: Scene, session: str | None = None, *, virtual_time: bool = False):
        """session: the name that haptic_server --session is given; None: "default".
        virtual_time: in lockstep with haptic_server --lockstep, time counted from 0."""
        self.scene = scene
        self.count = 0  # moving spheres
        self._handle = ctypes.c_void_p()
        self._process = os.getpid()
        self._time_ns = ctypes.c_uint64()
        self._responses = numpy.zeros(0, _library.RESPONSE)
        self._pushes = numpy.zeros(64, _library.PUSH)
        self._is_over: Callable[[], bool] = lambda: False
        kept: list[Any] = []
        self._call = {name: _library.function(f"publisher_{name}") for name in (
            "close", "wait", "set_shapes", "set_spheres", "set_responses", "pushes",
            "publish",
            "tool")}
        _library.check(_library.function("publisher_open")(
            scene_struct(scene, session, virtual_time, kept), ctypes.byref(self._handle)))

    def close(self) -> None:
        """Ends the session: forces fade. Twice does nothing."""
        handle, self._handle = self._handle, ctypes.c_void_p()
        if os.getpid() == self._process:  # the session is not a forked child's to end
            self._call["close"](handle)

    def __copy__(self) -> "Publisher":
        raise TypeError("a Publisher is one session's: expected no copy")

    def __deepcopy__(self, _: object) -> "Publisher":
        return self.__copy__()

    def __enter__(self) -> "Publisher":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self.close()

    def steps(self, duration_s: float | None = None) -> Iterator[float]:
        """Waits for each next step and gives its time, seconds since the first. Ends after duration_s,
        and when haptic_server has come to its end: in virtual time, and of a Session."""
        start_ns = None
        while (time_ns := self.wait()) is not None:
            start_ns = time_ns if start_ns is None else start_ns
            time_s = 1e-9 * (time_ns - start_ns)
            if duration_s is not None and time_s > duration_s:
                return
            yield time_s

    def wait(self) -> int | None:
        """Waits for the next step: the time in ns, on the scene's clock, of the state to publish next.
        None: a haptic_server came to its end, as steps() says. Ctrl-C ends the wait."""
        code: int = Code.AGAIN
        while code == Code.AGAIN:
            if self._is_over():
                return None
            code = self._checked("wait", ctypes.byref(self._time_ns))
        return None if code == Code.NOTHING else self._time_ns.value

    def set_shapes(self, radii_m: ArrayLike, materials: ArrayLike | None = None,
                   bodies: ArrayLike | None = None) -> None:
        """Declares the moving spheres anew, arrays (N,), N up to the scene's capacity. No materials: all
        of material 0. No bodies: all of body 0."""
        kept: list[Any] = []
        shapes = shapes_struct(kept, radii_m, materials, bodies)
        self._checked("set_shapes", shapes)
        self.count = shapes.count

    def set_spheres(self, positions_m: ArrayLike, velocities_m_s: ArrayLike | None = None) -> None:
        """Their state, arrays (N, 3). Without velocities they are taken from the positions before."""
        positions = floats(positions_m, "positions_m", None, 3)
        velocities = None
        if velocities_m_s is not None:
            velocities = floats(velocities_m_s, "velocities_m_s", len(positions), 3)
        self._checked("set_spheres", len(positions), address(positions), address(velocities))

    def set_responses(self, bodies: ArrayLike, centres_m: ArrayLike, velocities: ArrayLike,
                      inverse_inertias: ArrayLike) -> None:
        """The rigid bodies near the tool, which give way to it: their numbers (B,), centres of mass (B, 3),
        velocities of the centre and about it (B, 6; m/s, rad/s), and inverse inertias (B, 6, 6):
        acceleration and angular acceleration (m/s2, rad/s2) by force at the centre and torque (N, N m).
        The scene gives inertia."""
        numbers = indices(bodies, "bodies", None)
        count = len(numbers)
        if len(self._responses) < count:
            self._responses = numpy.zeros(count, _library.RESPONSE)
        responses = self._responses[:count]
        responses["body"] = numbers
        responses["centre_m"] = floats(centres_m, "centres_m", count, 3)
        responses["velocity"] = floats(velocities, "velocities", count, 6)
        responses["inverse_inertia"] = floats(inverse_inertias, "inverse_inertias", count, 6, 6)
        self._checked("set_responses", count, address(responses))

    def pushes(self, step_s: float | None = None) -> "numpy.recarray[Any, Any]":
        """What the hands' tools did to each moving body in the step that leads on from the state that was
        set: the mean along the tools' recorded paths, a row a body and hand: body, contacts, force_N
        (3,), point_m (3,) where it acts, torque_N_m (3,) beside that. step_s: of the engine; None: the
        scene's period."""
        step_s = self.scene.period_s if step_s is None else step_s
        while True:
            count = ctypes.c_uint32(len(self._pushes))
            try:
                self._checked("pushes", step_s, address(self._pushes), ctypes.byref(count))
                return self._pushes[:count.value].copy().view(numpy.recarray)
            except StillgridError as error:
                if error.code != Code.CAPACITY or count.value <= len(self._pushes):
                    raise
                self._pushes = numpy.zeros(count.value, _library.PUSH)

    def publish(self, state_time_ns: int = 0) -> None:
        """Shows all hands the state that was set. state_time_ns: its time on the scene's clock; 0: as
        wait() gave it, or now."""
        self._checked("publish", whole(state_time_ns, "state_time_ns", 64))

    def tool(self, hand: int = 0) -> Tool | None:
        """The newest tick of a hand, by its number in the scene. None: no haptic_server is there."""
        return take_tool(lambda figures: self._checked("tool", whole(hand, "hand", 32), figures))

    def _checked(self, call: str, *arguments: Any) -> int:
        if not self._handle:
            raise StillgridError(Code.ORDER, f"{call}: expected a publisher that is not closed")
        return _library.check(self._call[call](self._handle, *arguments))
