"""The C ABI of proto/stillgrid.h: its structs, its functions, and its errors as exceptions."""
import ctypes
from ctypes import c_char_p, c_double, c_int, c_uint32, c_uint64, c_void_p
import functools
from typing import Any

import numpy

from . import _places
from .errors import Code, StillgridError

REAL_TIME, VIRTUAL_TIME = 0, 1


class Sized(ctypes.Structure):
    """A struct that begins with its size, which may grow in later versions."""

    def __init__(self, **values: Any):
        super().__init__(struct_size=ctypes.sizeof(self), **values)


class Material(ctypes.Structure):
    _fields_ = [("stiffness_N_per_m", c_double), ("damping_N_s_per_m", c_double), ("friction", c_double)]


class Plane(ctypes.Structure):
    _fields_ = [("normal", c_double * 3), ("offset_m", c_double), ("material", c_uint32), ("body", c_uint32)]


class Shapes(Sized):
    _fields_ = [("struct_size", c_uint32), ("count", c_uint32), ("radii_m", c_void_p),
                ("materials", c_void_p), ("bodies", c_void_p), ("positions_m", c_void_p)]


class Hand(Sized):
    _fields_ = [("struct_size", c_uint32), ("tool_count", c_uint32), ("name", c_char_p),
                ("tool_m", c_void_p), ("device_position_m", c_double * 3),
                ("device_orientation_xyzw", c_double * 4), ("device_scale", c_double)]


class Scene(Sized):
    _fields_ = [("struct_size", c_uint32), ("clock", c_uint32), ("session", c_char_p), ("name", c_char_p),
                ("period_s", c_double), ("sphere_capacity", c_uint32), ("material_count", c_uint32),
                ("plane_count", c_uint32), ("hand_count", c_uint32), ("gives_inertia", c_uint32),
                ("reserved", c_uint32), ("materials", ctypes.POINTER(Material)),
                ("planes", ctypes.POINTER(Plane)), ("hands", ctypes.POINTER(Hand)),
                ("static_shapes", ctypes.POINTER(Shapes))]


class Tool(Sized):
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("time_ns", c_uint64), ("tick", c_uint64),
                ("position_m", c_double * 3), ("orientation_xyzw", c_double * 4),
                ("velocity_m_s", c_double * 3), ("force_N", c_double * 3), ("torque_N_m", c_double * 3),
                ("buttons", c_uint64), ("gripper_m", c_double), ("axes", c_double * 4),
                ("contacts", c_uint32), ("safety_flags", c_uint32), ("missed_ticks", c_uint64),
                ("work_ns", c_uint64), ("snapshot_id", c_uint64), ("age_s", c_double)]


class SessionState(Sized):
    _fields_ = [("struct_size", c_uint32), ("clock", c_uint32), ("is_published", c_uint32),
                ("is_felt", c_uint32), ("scene_epoch", c_uint64), ("tool_epoch", c_uint64),
                ("publication_period_ns", c_uint64), ("tick_period_ns", c_uint64), ("snapshots", c_uint64),
                ("ticks", c_uint64), ("sphere_capacity", c_uint32), ("static_count", c_uint32),
                ("material_count", c_uint32), ("plane_count", c_uint32), ("tool_count", c_uint32),
                ("reserved", c_uint32), ("scene_name", ctypes.c_char * 64)]


class Fixed(Sized):
    _fields_ = [("struct_size", c_uint32), ("material_capacity", c_uint32), ("plane_capacity", c_uint32),
                ("tool_capacity", c_uint32), ("materials", ctypes.POINTER(Material)),
                ("planes", ctypes.POINTER(Plane)), ("tool_m", c_void_p),
                ("device_position_m", c_double * 3), ("device_orientation_xyzw", c_double * 4),
                ("device_scale", c_double)]


class Snapshot(Sized):
    _fields_ = [("struct_size", c_uint32), ("capacity", c_uint32), ("count", c_uint32),
                ("contacts", c_uint32), ("snapshot_id", c_uint64), ("state_time_ns", c_uint64),
                ("publish_time_ns", c_uint64), ("tool_time_ns", c_uint64), ("step_ns", c_uint64),
                ("positions_m", c_void_p), ("velocities_m_s", c_void_p),
                ("radii_m", c_void_p), ("materials", c_void_p),
                ("bodies", c_void_p)]


class Mesh(Sized):
    _fields_ = [("struct_size", c_uint32), ("vertex_count", c_uint32), ("triangle_count", c_uint32),
                ("reserved", c_uint32), ("vertices_m", c_void_p), ("triangles", c_void_p)]


class Cover(Sized):
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("tolerance_m", c_double),
                ("surface_spacing_m", c_double), ("volume_spacing_m", c_double)]


# Structs that are handed over in arrays: numpy's own, of the same layout.
RESPONSE = numpy.dtype([("body", numpy.uint32), ("reserved", numpy.uint32),
                        ("centre_m", numpy.float64, 3), ("velocity", numpy.float64, 6),
                        ("inverse_inertia", numpy.float64, (6, 6))])
PUSH = numpy.dtype([("body", numpy.uint32), ("contacts", numpy.uint32), ("force_N", numpy.float64, 3),
                    ("point_m", numpy.float64, 3), ("torque_N_m", numpy.float64, 3)])

_COUNT = ctypes.POINTER(c_uint32)
_TIME = ctypes.POINTER(c_uint64)
_HANDLE = ctypes.POINTER(c_void_p)

# By name without "stillgrid_": what it returns, then its arguments.
SIGNATURES: dict[str, tuple[Any, ...]] = {
    "api_version": (c_uint32,),
    "library_version": (c_char_p,),
    "last_error": (c_char_p,),
    "publisher_open": (c_int, ctypes.POINTER(Scene), _HANDLE),
    "publisher_close": (None, c_void_p),
    "publisher_wait": (c_int, c_void_p, _TIME),
    "publisher_set_shapes": (c_int, c_void_p, ctypes.POINTER(Shapes)),
    "publisher_set_spheres": (c_int, c_void_p, c_uint32, c_void_p, c_void_p),
    "publisher_set_responses": (c_int, c_void_p, c_uint32, c_void_p),
    "publisher_pushes": (c_int, c_void_p, c_double, c_void_p, _COUNT),
    "publisher_publish": (c_int, c_void_p, c_uint64),
    "publisher_tool": (c_int, c_void_p, c_uint32, ctypes.POINTER(Tool)),
    "reader_open": (c_int, c_char_p, c_char_p, _HANDLE),
    "reader_close": (None, c_void_p),
    "reader_poll": (c_int, c_void_p, ctypes.POINTER(SessionState)),
    "reader_fixed": (c_int, c_void_p, ctypes.POINTER(Fixed)),
    "reader_snapshot": (c_int, c_void_p, ctypes.POINTER(Snapshot)),
    "reader_static": (c_int, c_void_p, ctypes.POINTER(Snapshot)),
    "reader_displayed": (c_int, c_void_p, ctypes.POINTER(Snapshot)),
    "reader_tool": (c_int, c_void_p, ctypes.POINTER(Tool)),
    "decompose": (c_int, ctypes.POINTER(Mesh), ctypes.POINTER(Cover), _HANDLE),
    "decomposition_free": (None, c_void_p),
    "decomposition_count": (c_uint32, c_void_p),
    "decomposition_spheres": (ctypes.POINTER(c_double), c_void_p),
    "decomposition_report": (c_char_p, c_void_p),
}


@functools.cache
def _loaded() -> ctypes.CDLL:
    name = _places.library()
    try:
        return ctypes.CDLL(name)
    except OSError as error:
        raise ImportError(f"{_places.SONAME} was not found: expected it in lib/ beside this package, by "
                          f"$STILLGRID_LIBRARY, or by the loader: {error}") from None


@functools.cache
def function(name: str) -> Any:
    """stillgrid_NAME, loaded and declared when it is first asked for."""
    try:
        found = _loaded()[f"stillgrid_{name}"]
    except AttributeError:
        raise StillgridError(Code.VERSION, f"{_places.library()}: no function stillgrid_{name}: expected a "
                             "library of this package's version") from None
    found.restype, *found.argtypes = SIGNATURES[name]
    return found


def check(code: int) -> int:
    """The code of a call that worked; raises what one that did not said."""
    if code < 0:
        raise StillgridError(code, function("last_error")().decode(errors="replace"))
    return code


def encoded(text: str | None) -> bytes | None:
    return None if text is None else text.encode()


