"""A palpation with a known truth, for what has no recording: an organ's mesh with a hard place in it, and a hand that
goes over it in lines, pressing. Forces are of the exact distance to the mesh, by no part of the product.

The law of the truth: stiffness at the nearest point of the surface times depth along its normal; the surface lies off
the mesh by what a registration errs. What is recorded has the noise of a tracker and of a force sensor.
"""
import dataclasses

import numpy

RATE_HZ = 100.0
TRACKER_M, SENSOR_N = 3e-4, 0.1  # standard deviation, each axis, each sample
SPEED_M_S = 0.025
PRESSES_HZ = 1.1
COLUMNS = ("time_s", "x_m", "y_m", "z_m", "fx_N", "fy_N", "fz_N")


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

    file: object
    scale: float
    tool_m: float
    patch_m: tuple  # half the palpated patch, along x and y, round the highest point
    seed: int
    soft_N_per_m: float = 320.0
    hard_N_per_m: float = 900.0
    hard_m: float = 0.007

    def __post_init__(self):
        self.vertices_m, self.triangles = read_obj(self.file, self.scale)
        random = numpy.random.default_rng(self.seed)
        self.offset_m = random.uniform(-8e-4, 8e-4)
        corners_m = self.vertices_m[self.triangles]
        up = numpy.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])[:, 2] > 0.0
        self.middle_m = self.vertices_m[self.vertices_m[:, 2].argmax()]
        far_m = numpy.abs(corners_m.mean(axis=1) - self.middle_m)[:, :2] - numpy.array(self.patch_m)
        size_m = numpy.linalg.norm(corners_m - corners_m.mean(axis=1)[:, None], axis=2).max()
        self.corners_m = corners_m[up & (far_m < 0.01 + size_m).all(axis=1)]  # all that the tool may meet
        a, b, c = (self.corners_m[:, k] for k in range(3))
        self.normals = numpy.cross(b - a, c - a)
        self.hard_at_m = self.on_surface(self.middle_m[:2] + random.uniform(-0.6, 0.6, 2) * self.patch_m)
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
        slow = 1.0 + 0.25 * numpy.sin(x / 0.013 + self.phase) * numpy.cos(y / 0.010)
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


def record(truth, run, seed):
    """Rows of COLUMNS. run 0: along x, 4 mm apart; run 1: along y, 5 mm apart, with other presses."""
    random = numpy.random.default_rng((seed, run))
    corners_m = lines_over(truth.patch_m, (0.004, 0.005)[run], run)
    legs_m = numpy.append(0.0, numpy.cumsum(numpy.linalg.norm(numpy.diff(corners_m, axis=0), axis=1)))
    time_s = numpy.arange(0.0, legs_m[-1] / SPEED_M_S, 1.0 / RATE_HZ)
    at_m = numpy.column_stack([numpy.interp(SPEED_M_S * time_s, legs_m, corners_m[:, k]) for k in range(2)])
    presses = 2.0 * numpy.pi * PRESSES_HZ * (1.0 + 0.13 * run) * time_s + random.uniform(0.0, 2.0 * numpy.pi)
    depth_m = 0.0015 + 0.0004 * numpy.sin(0.7 * time_s + run) + 0.0018 * numpy.sin(presses)
    way_m = numpy.array([truth.on_surface(truth.middle_m[:2] + at) for at in at_m])
    # The hand does not follow each facet: its way and direction are smooth.
    kernel = numpy.hanning(31) / numpy.hanning(31).sum()
    padded = numpy.concatenate([numpy.repeat(way_m[:1], 15, 0), way_m, numpy.repeat(way_m[-1:], 15, 0)])
    way_m = numpy.column_stack([numpy.convolve(padded[:, k], kernel, "valid") for k in range(3)])
    centre_m = numpy.empty_like(way_m)
    for i, on_m in enumerate(way_m):
        nearest_m, _, out = truth.nearest(on_m + numpy.array((0.0, 0.0, 0.02)))
        centre_m[i] = nearest_m + (truth.tool_m + truth.offset_m - depth_m[i]) * out
    force_N = numpy.array([truth.force_N(centre) for centre in centre_m])
    return numpy.column_stack((time_s, centre_m + random.normal(0.0, TRACKER_M, centre_m.shape),
                               force_N + random.normal(0.0, SENSOR_N, force_N.shape)))


def write(rows, file):
    lines = [",".join(COLUMNS), *(",".join(f"{value:.7g}" for value in row) for row in rows)]
    file.write_text("\n".join(lines) + "\n")
    return file
