"""Stillgrid from Python: publish a simulation, read a session, run one, replay a hand (docs/python.md).

Units are SI, the frame is the scene's, quaternions are x, y, z, w. Arrays are numpy's, a row a sphere.
"""
from ._library import PUSH, RESPONSE
from .errors import Code, DaemonError, StillgridError
from .mesh import decompose
from .publisher import Publisher
from .reader import Fixed, Reader, Snapshot, State
from .recording import Recording, compare_forces, load, save_forces, save_trajectory
from .scene import Hand, Material, Plane, Scene, StaticSpheres
from .session import Session, replay
from .tool import Tool


def library_version() -> str:
    """Of the library that was loaded."""
    from ._library import function
    return str(function("library_version")().decode())


__all__ = [
    "PUSH", "RESPONSE", "Code", "DaemonError", "Fixed", "Hand", "Material", "Plane", "Publisher", "Reader",
    "Recording", "Scene", "Session", "Snapshot", "State", "StaticSpheres", "StillgridError", "Tool",
    "compare_forces", "decompose", "library_version", "load", "replay", "save_forces", "save_trajectory"]
