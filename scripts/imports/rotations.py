"""Orientations as unit quaternions x, y, z, w, scene from tool, from what laboratories write."""
import numpy

from table import Unusable

MOST_OFF = 0.05  # what a rotation may be off by its rounding


def quaternions(values, kind, refuse):
    """values: a row each. refuse(row, text) gives the line of a row that is no rotation."""
    if kind in ("xyzw", "wxyz"):
        length = numpy.linalg.norm(values, axis=1)
        bad = numpy.flatnonzero(numpy.abs(length - 1.0) > MOST_OFF)
        if len(bad):
            raise Unusable(refuse(bad[0], f"a quaternion of length {length[bad[0]]:.3g}: expected 1"))
        unit = values / length[:, None]
        return unit if kind == "xyzw" else unit[:, [1, 2, 3, 0]]
    if kind.startswith("rotation_vector"):
        return of_vectors(numpy.radians(values) if kind.endswith("deg") else values)
    matrices = values.reshape(-1, 3, 3)
    if kind == "matrix_columns":
        matrices = matrices.transpose(0, 2, 1)
    off = numpy.abs(matrices @ matrices.transpose(0, 2, 1) - numpy.eye(3)).max(axis=(1, 2))
    bad = numpy.flatnonzero((off > MOST_OFF) | (numpy.linalg.det(matrices) < 0.0))
    if len(bad):
        raise Unusable(refuse(bad[0], "a matrix that is no rotation: expected columns of length 1, at right angles, "
                              "right-handed"))
    return continuous(of_matrices(matrices))


def of_vectors(vectors_rad):
    angle_rad = numpy.linalg.norm(vectors_rad, axis=1, keepdims=True)
    # sin(a / 2) / a, whole at 0.
    return continuous(numpy.hstack([vectors_rad * 0.5 * numpy.sinc(angle_rad / (2.0 * numpy.pi)),
                                    numpy.cos(0.5 * angle_rad)]))


def of_matrices(m):
    """The nearest rotation: the largest eigenvector of Bar-Itzhack's matrix (J. Guidance 23(6), 2000)."""
    k = numpy.zeros((len(m), 4, 4))
    k[:, :3, :3] = m + m.transpose(0, 2, 1) - numpy.einsum("nii->n", m)[:, None, None] * numpy.eye(3)
    k[:, :3, 3] = k[:, 3, :3] = numpy.stack([m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0],
                                             m[:, 1, 0] - m[:, 0, 1]], axis=1)
    k[:, 3, 3] = numpy.einsum("nii->n", m)
    return numpy.linalg.eigh(k)[1][:, :, 3]


def continuous(turns):
    """Signs so that a row is near the one before it; of the first w is not negative."""
    flips = numpy.append(turns[0, 3] < 0.0, (turns[1:] * turns[:-1]).sum(axis=1) < 0.0)
    return turns * numpy.where(numpy.cumsum(flips) % 2, -1.0, 1.0)[:, None]


def angles_rad(turns):
    """Between neighbours."""
    inner = numpy.abs((turns[1:] * turns[:-1]).sum(axis=1))
    return 2.0 * numpy.arccos(numpy.clip(inner, 0.0, 1.0))


def between(time_s, turns, at_s):
    """Turned evenly from row to row."""
    turns = continuous(turns)
    row = numpy.clip(numpy.searchsorted(time_s, at_s, side="right") - 1, 0, len(time_s) - 2)
    share = ((at_s - time_s[row]) / (time_s[row + 1] - time_s[row]))[:, None]
    a, b = turns[row], turns[row + 1]
    half_rad = numpy.arccos(numpy.clip((a * b).sum(axis=1, keepdims=True), -1.0, 1.0))
    near = half_rad < 1e-6
    sine = numpy.where(near, 1.0, numpy.sin(half_rad))
    mixed = numpy.where(near, (1.0 - share) * a + share * b,
                        (numpy.sin((1.0 - share) * half_rad) * a + numpy.sin(share * half_rad) * b) / sine)
    return mixed / numpy.linalg.norm(mixed, axis=1, keepdims=True)
