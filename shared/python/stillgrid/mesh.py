"""Spheres of a mesh."""
import ctypes
import json
from typing import Any

import numpy
from numpy.typing import ArrayLike

from . import _library
from ._arrays import Floats, address, floats, indices


def decompose(vertices_m: ArrayLike, triangles: ArrayLike, *, tolerance_m: float = 0.0,
              surface_spacing_m: float = 0.0, volume_spacing_m: float = 0.0) -> tuple[Floats, dict[str, Any]]:
    """Spheres of a closed mesh: (N, 4), centre and radius, and the report of sphere_decompose as a dict
    (docs/formats.md). Takes seconds for a large mesh.

    vertices_m: (V, 3). triangles: (T, 3), numbers of vertices. One of the three is asked for:
    tolerance_m: few spheres, neither surface farther than that from the other.
    surface_spacing_m: even spheres below the surface, so far apart. volume_spacing_m: throughout.
    """
    vertices = floats(vertices_m, "vertices_m", None, 3)
    corners = indices(triangles, "triangles", None, 3)
    mesh = _library.Mesh(vertex_count=len(vertices), triangle_count=len(corners),
                         vertices_m=address(vertices), triangles=address(corners))
    cover = _library.Cover(tolerance_m=tolerance_m, surface_spacing_m=surface_spacing_m,
                           volume_spacing_m=volume_spacing_m)
    handle = ctypes.c_void_p()
    _library.check(_library.function("decompose")(mesh, cover, ctypes.byref(handle)))
    try:
        count = _library.function("decomposition_count")(handle)
        found = _library.function("decomposition_spheres")(handle)
        spheres = numpy.ctypeslib.as_array(found, (count, 4)).copy()
        return spheres, json.loads(_library.function("decomposition_report")(handle))
    finally:
        _library.function("decomposition_free")(handle)
