"""What a simulation publishes once. Units are SI; the frame is the scene's; quaternions are x, y, z, w."""
import ctypes
import dataclasses
from collections.abc import Sequence
from typing import Any

from numpy.typing import ArrayLike

from . import _library
from ._arrays import address, floats, indices


@dataclasses.dataclass(frozen=True)
class Material:
    """How a contact with the tool feels."""

    stiffness_N_per_m: float
    damping_N_s_per_m: float = 0.0
    friction: float = 0.0  # Coulomb's


@dataclasses.dataclass(frozen=True)
class Plane:
    """Solid below: points with normal . x < offset_m are inside. normal: a unit vector, (3,)."""

    normal: ArrayLike
    offset_m: float
    material: int = 0
    body: int = 0


@dataclasses.dataclass(frozen=True)
class StaticSpheres:
    """Spheres that never move: positions (N, 3), radii (N,), numbers of materials and bodies (N,)."""

    positions_m: ArrayLike
    radii_m: ArrayLike
    materials: ArrayLike | None = None
    bodies: ArrayLike | None = None


@dataclasses.dataclass(frozen=True)
class Hand:
    """A hand: its tool, spheres (N, 4) of centre and radius in the tool's frame, and where its device stands."""

    tool_m: ArrayLike = ((0.0, 0.0, 0.0, 0.005),)
    name: str | None = None  # None: the only hand
    device_position_m: ArrayLike = (0.0, 0.0, 0.0)
    device_orientation_xyzw: ArrayLike = (0.0, 0.0, 0.0, 1.0)
    device_scale: float = 1.0  # metres in the scene a metre of the device


@dataclasses.dataclass(frozen=True)
class Scene:
    """A scene of at most sphere_capacity moving spheres, published every period_s.

    gives_inertia: set_responses() comes with each state, and haptic_server moves the touched bodies on
    from it in each tick. Without it haptic_server shows snapshots up to a period later.
    """

    period_s: float
    sphere_capacity: int
    materials: Sequence[Material]
    planes: Sequence[Plane] = ()
    static: StaticSpheres | None = None
    hands: Sequence[Hand] = ()  # none: one hand, a ball of 5 mm, its device at the origin
    gives_inertia: bool = False
    name: str | None = None  # shown to people


def shapes_struct(kept: list[Any], radii_m: ArrayLike, materials: ArrayLike | None, bodies: ArrayLike | None,
                  positions_m: ArrayLike | None = None) -> _library.Shapes:
    """Spheres as the library takes them; kept: gets the arrays that it points into."""
    radii = floats(radii_m, "radii_m", None)
    count = len(radii)
    arrays = [radii,
              None if materials is None else indices(materials, "materials", count),
              None if bodies is None else indices(bodies, "bodies", count),
              None if positions_m is None else floats(positions_m, "positions_m", count, 3)]
    kept += arrays
    places = map(address, arrays)
    return _library.Shapes(count=count, **dict(zip(("radii_m", "materials", "bodies", "positions_m"), places)))


def scene_struct(scene: Scene, session: str | None, virtual_time: bool, kept: list[Any]) -> _library.Scene:
    """A scene as the library takes it; kept: gets what it points into."""
    materials = (_library.Material * len(scene.materials))(
        *(_library.Material(*dataclasses.astuple(material)) for material in scene.materials))
    planes = (_library.Plane * len(scene.planes))(
        *(_library.Plane(tuple(floats(plane.normal, "normal", 3)), plane.offset_m, plane.material, plane.body)
          for plane in scene.planes))
    hands = (_library.Hand * len(scene.hands))(*(_hand_struct(hand, kept) for hand in scene.hands))
    static = None
    if scene.static is not None:
        static = ctypes.pointer(shapes_struct(kept, scene.static.radii_m, scene.static.materials,
                                              scene.static.bodies, scene.static.positions_m))
    return _library.Scene(
        clock=_library.VIRTUAL_TIME if virtual_time else _library.REAL_TIME,
        session=_library.encoded(session), name=_library.encoded(scene.name), period_s=scene.period_s,
        sphere_capacity=scene.sphere_capacity, material_count=len(materials), materials=materials,
        plane_count=len(planes), planes=planes, hand_count=len(hands), hands=hands,
        gives_inertia=scene.gives_inertia, static_shapes=static)


def _hand_struct(hand: Hand, kept: list[Any]) -> _library.Hand:
    tool = floats(hand.tool_m, "tool_m", None, 4)
    kept.append(tool)
    return _library.Hand(
        tool_count=len(tool), tool_m=address(tool), name=_library.encoded(hand.name),
        device_position_m=tuple(floats(hand.device_position_m, "device_position_m", 3)),
        device_orientation_xyzw=tuple(floats(hand.device_orientation_xyzw, "device_orientation_xyzw", 4)),
        device_scale=hand.device_scale)
