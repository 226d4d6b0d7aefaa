"""A palpation with a known truth, for what has no recording: an organ's mesh with a hard place in it, and a hand that
goes over it in lines, pressing. Forces are of the exact distance to the mesh, by no part of the product.

The law of the truth: stiffness at the nearest point of the surface times depth along its normal; the surface lies off
the mesh by what a registration errs. What is recorded has the noise of a tracker and of a force sensor.
"""
import dataclasses
import pathlib

import numpy

from measuring import DATA, ROOT

RATE_HZ = 100.0
TRACKER_M, SENSOR_N = 3e-4, 0.1  # standard deviation, each axis, each sample
SPEED_M_S = 0.025
PRESSES_HZ = 1.1
COLUMNS = ("time_s", "x_m", "y_m", "z_m", "fx_N", "fy_N", "fz_N")


@dataclasses.dataclass(frozen=True)
class Organ:
    """A mesh as it lies on the bench, turned about its file's origin, and the patch of it that is palpated: from its
    highest point, and half its sides."""

    file: pathlib.Path
    scale: float
    turn_xyzw: tuple
    from_top_m: tuple
    patch_m: tuple


KIDNEY = Organ(ROOT / "sim_server/scene/scenes/organ.obj", 2.0, (0.5 ** 0.5, 0.5 ** 0.5, 0.0, 0.0), (0.0, 0.0),
               (0.012, 0.020))  # ships


def turned(points_m, turn_xyzw):
    axis, w = numpy.array(turn_xyzw[:3]), turn_xyzw[3]
    return points_m + 2.0 * numpy.cross(axis, numpy.cross(axis, points_m) + w * points_m)


def read_obj(file, scale):
    """Vertices and triangles of a closed mesh."""
    vertices, triangles = [], []
    for line in file.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) - 1 for word in words[1:]]
            triangles += [[corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1)]
    return scale * numpy.array(vertices), numpy.array(triangles)


def nearest_in_triangles(point_m, corners_m):
    """The nearest point of each triangle [Ericson 2005, Real-Time Collision Detection, 5.1.5]."""
    a, b, c = corners_m[:, 0], corners_m[:, 1], corners_m[:, 2]
    ab, ac = b - a, c - a

    def dot(u, v):
        return (u * v).sum(axis=1)

    def on_edge(start, end):
        along = end - start
        return start + numpy.clip(dot(point_m - start, along) / dot(along, along), 0.0, 1.0)[:, None] * along

    normal = numpy.cross(ab, ac)
    square = dot(normal, normal)
    v = dot(numpy.cross(point_m - a, ac), normal) / square
    w = dot(numpy.cross(ab, point_m - a), normal) / square
    inside = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
    nearest = a + v[:, None] * ab + w[:, None] * ac
    edges = numpy.stack((on_edge(a, b), on_edge(b, c), on_edge(c, a)))
    best = numpy.linalg.norm(edges - point_m, axis=2).argmin(axis=0)
    nearest[~inside] = edges[best, numpy.arange(len(a))][~inside]
    return nearest


@dataclasses.dataclass
class Truth:
    """seed: where the hard place lies, and how far the surface is off the mesh."""

    organ: Organ
    seed: int
    tool_m: float = 0.005
    soft_N_per_m: float = 320.0
    hard_N_per_m: float = 900.0
    hard_m: float = 0.007
    slow_share: float = 0.25

    def __post_init__(self):
        vertices_m, triangles = read_obj(self.organ.file, self.organ.scale)
        vertices_m = turned(vertices_m, self.organ.turn_xyzw)
        patch_m = numpy.array(self.organ.patch_m)
        random = numpy.random.default_rng(self.seed)
        self.offset_m = random.uniform(-8e-4, 8e-4)
        corners_m = vertices_m[triangles]
        up = numpy.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])[:, 2] > 0.0
        top_m = vertices_m[vertices_m[:, 2].argmax()]
        self.middle_m = top_m + numpy.array((*self.organ.from_top_m, 0.0))
        far_m = numpy.abs(corners_m.mean(axis=1) - self.middle_m)[:, :2] - patch_m
        size_m = numpy.linalg.norm(corners_m - corners_m.mean(axis=1)[:, None], axis=2).max()
        self.corners_m = corners_m[up & (far_m < 0.01 + size_m).all(axis=1)]  # all that the tool may meet
        a, b, c = (self.corners_m[:, k] for k in range(3))
        self.normals = numpy.cross(b - a, c - a)
        self.hard_at_m = self.on_surface(self.middle_m[:2] + random.uniform(-0.6, 0.6, 2) * patch_m)
        self.phase = random.uniform(0.0, 2.0 * numpy.pi)

    def on_surface(self, at_m):
        """The highest point of the mesh over x and y."""
        a, b, c = (self.corners_m[:, k] for k in range(3))
        ab, ac, ap = (b - a)[:, :2], (c - a)[:, :2], numpy.asarray(at_m) - a[:, :2]
        area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
        v = (ap[:, 0] * ac[:, 1] - ap[:, 1] * ac[:, 0]) / area
        w = (ab[:, 0] * ap[:, 1] - ab[:, 1] * ap[:, 0]) / area
        over = (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1.0 + 1e-9)
        height_m = (a[:, 2] + v * (b - a)[:, 2] + w * (c - a)[:, 2])[over].max()
        return numpy.array((*at_m, height_m))

    def nearest(self, point_m):
        """The nearest point of the patch, the distance from it, negative inside, and the direction out."""
        all_m = nearest_in_triangles(point_m, self.corners_m)
        triangle = numpy.linalg.norm(all_m - point_m, axis=1).argmin()
        away_m = point_m - all_m[triangle]
        distance_m = numpy.copysign(numpy.linalg.norm(away_m), away_m @ self.normals[triangle])
        return all_m[triangle], distance_m, away_m / distance_m

    def stiffness_N_per_m(self, on_surface_m):
        x, y = (on_surface_m - self.middle_m)[..., 0], (on_surface_m - self.middle_m)[..., 1]
        slow = 1.0 + self.slow_share * numpy.sin(x / 0.013 + self.phase) * numpy.cos(y / 0.010)
        square = ((on_surface_m - self.hard_at_m) ** 2).sum(axis=-1)
        return self.soft_N_per_m * slow + self.hard_N_per_m * numpy.exp(-0.5 * square / self.hard_m ** 2)

    def force_N(self, centre_m):
        """On the tool."""
        nearest_m, distance_m, out = self.nearest(centre_m)
        depth_m = max(self.tool_m + self.offset_m - distance_m, 0.0)
        return self.stiffness_N_per_m(nearest_m) * depth_m * out


def lines_over(patch_m, spacing_m, along):
    """A way to and fro over the patch, along x (0) or y (1): corners to go to."""
    half_m, across_m = patch_m[along], patch_m[1 - along]
    count = int(2.0 * across_m / spacing_m) + 1
    corners = []
    for i, across in enumerate(numpy.linspace(-across_m, across_m, count)):
        for end in (-half_m, half_m) if i % 2 == 0 else (half_m, -half_m):
            corners.append((end, across) if along == 0 else (across, end))
    return numpy.array(corners)


def way(truth, corners_m, legs_m, time_s):
    """Points of the surface and directions out of it, smooth, for a hand does not follow each facet."""
    coarse_s = numpy.linspace(0.0, time_s[-1], 1 + int(time_s[-1] / 0.08))
    at_m = numpy.column_stack([numpy.interp(SPEED_M_S * coarse_s, legs_m, corners_m[:, k]) for k in range(2)])
    found = [truth.nearest(truth.on_surface(truth.middle_m[:2] + at) + numpy.array((0.0, 0.0, 0.02))) for at in at_m]
    rows = numpy.array([(*nearest_m, *out) for nearest_m, _, out in found])
    kernel = numpy.hanning(7) / numpy.hanning(7).sum()
    padded = numpy.concatenate([numpy.repeat(rows[:1], 3, 0), rows, numpy.repeat(rows[-1:], 3, 0)])
    smooth = [numpy.interp(time_s, coarse_s, numpy.convolve(padded[:, k], kernel, "valid")) for k in range(6)]
    out = numpy.column_stack(smooth[3:])
    return numpy.column_stack(smooth[:3]), out / numpy.linalg.norm(out, axis=1, keepdims=True)


def record(truth, run, seed):
    """Rows of COLUMNS. run 0: along x, 4 mm apart; run 1: along y, 5 mm apart, with other presses."""
    random = numpy.random.default_rng((seed, run))
    corners_m = lines_over(truth.organ.patch_m, (0.004, 0.005)[run], run)
    legs_m = numpy.append(0.0, numpy.cumsum(numpy.linalg.norm(numpy.diff(corners_m, axis=0), axis=1)))
    time_s = numpy.arange(0.0, legs_m[-1] / SPEED_M_S, 1.0 / RATE_HZ)
    presses = 2.0 * numpy.pi * PRESSES_HZ * (1.0 + 0.13 * run) * time_s + random.uniform(0.0, 2.0 * numpy.pi)
    depth_m = 0.0015 + 0.0004 * numpy.sin(0.7 * time_s + run) + 0.0018 * numpy.sin(presses)
    on_m, out = way(truth, corners_m, legs_m, time_s)
    centre_m = on_m + (truth.tool_m + truth.offset_m - depth_m)[:, None] * out
    force_N = numpy.array([truth.force_N(centre) for centre in centre_m])
    return numpy.column_stack((time_s, centre_m + random.normal(0.0, TRACKER_M, centre_m.shape),
                               force_N + random.normal(0.0, SENSOR_N, force_N.shape)))


def write(rows, file):
    lines = [",".join(COLUMNS), *(",".join(f"{value:.7g}" for value in row) for row in rows)]
    file.write_text("\n".join(lines) + "\n")
    return file


def scene_text(organ, contact):
    """The bench: the mesh as it lies there. contact: keys of how it is met."""
    return f"""format = 2
[world]
gravity_m_s2 = [0.0, 0.0, 0.0]
[tool]
radius_m = {Truth.tool_m}

[[material]]
name = "tissue"
contact_stiffness_N_per_m = 400.0

[[body]]
name = "organ"
kind = "mesh"
file = "{organ.file}"
scale = {organ.scale}
orientation_xyzw = {list(organ.turn_xyzw)}
motion = "static"
material = "tissue"
{contact}
"""
