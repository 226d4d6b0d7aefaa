"""The statics of an instrument through a trocar, of a recording's rows: docs/laparoscopy.md."""
import numpy


def rows_of(recording, name):
    """Three columns as rows of vectors: rows_of(recording, "f{}_N")."""
    return numpy.stack([recording[name.format(axis)] for axis in "xyz"], axis=1)


def shaft_of(recording):
    """Unit vectors from the handle towards the tip, by the recorded orientation."""
    x, y, z, w = (recording[f"q{axis}"] for axis in "xyzw")
    return -numpy.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)


def distance_of(recording, pivot_m):
    """From the handle to the pivot, metres; both in the scene's frame."""
    return numpy.linalg.norm(pivot_m - rows_of(recording, "{}_m"), axis=1)


def force_at_handle_N(recording, pivot_m):
    """What a hand feels that holds the handle as a ball joint, in a [device] that is not turned."""
    shaft, torque_N_m = shaft_of(recording), rows_of(recording, "t{}_N_m")
    down = numpy.array([0.0, 0.0, -1.0])
    roll_torque_N_m = numpy.sum(shaft * torque_N_m, axis=1) / (1.0 + shaft @ down)
    cross_torque_N_m = torque_N_m - roll_torque_N_m[:, None] * down
    return (rows_of(recording, "f{}_N")
            + numpy.cross(shaft, cross_torque_N_m) / distance_of(recording, pivot_m)[:, None])
