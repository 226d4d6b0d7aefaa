"""A stiffness over a surface from places where it is known, as sim_server/fields/stiffness_map.cpp has it, and its
fit to measured forces: regularised least squares with a least stiffness, cross-validated."""
import dataclasses

import numpy

WIDTH, OWN_WEIGHT, NEIGHBOURS = 1.75, 0.02, 3
FOLDS, BLOCKS = 5, 25
SMOOTHNESS = (1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 1.0)
TOWARDS_OWN = 1e-4  # what keeps a place that is hardly felt near the one stiffness of the whole
LEAST_SHARE = 0.02  # of that one stiffness: no place is softer
WORTH_A_MAP = 0.01  # of the measured force's variance: what a map must predict more than one stiffness
MAX_PLACES = 800


@dataclasses.dataclass
class Contact:
    """Rows of a recording near the body, as the product's own field measures them; SI units, the mesh's frame.

    gap_m: from the tool's surface to the mesh, negative inside; force_N: the measured one along the normal.
    """

    time_s: numpy.ndarray
    gap_m: numpy.ndarray
    foot_m: numpy.ndarray  # nearest point of the mesh, row by row
    force_N: numpy.ndarray

    def depth_m(self, offset_m):
        """Of the tool in a surface that lies so far outside of the mesh."""
        return numpy.maximum(offset_m - self.gap_m, 0.0)

    def thinned(self, most):
        step = max(1, -(-len(self.time_s) // most))
        return Contact(self.time_s[::step], self.gap_m[::step], self.foot_m[::step], self.force_N[::step])


def distances(points_m, places_m):
    """A row a point, a column a place."""
    squares = ((points_m ** 2).sum(axis=1)[:, None] + (places_m ** 2).sum(axis=1)[None, :]
               - 2.0 * points_m @ places_m.T)
    return numpy.sqrt(numpy.maximum(squares, 0.0))


def widths_m(places_m):
    apart_m = distances(places_m, places_m)
    apart_m[apart_m < 1e-9] = numpy.inf
    nearest_m = numpy.sort(apart_m, axis=1)[:, :NEIGHBOURS]
    return WIDTH * numpy.array([row[numpy.isfinite(row)].mean() for row in nearest_m])


def weights(points_m, places_m):
    """Of each place at each point, and last of the body's own stiffness; a row sums to one."""
    if len(places_m) == 1:
        return numpy.tile((1.0, 0.0), (len(points_m), 1))
    share = (distances(points_m, places_m) / widths_m(places_m)) ** 2
    counts = numpy.column_stack((numpy.maximum(1.0 - share, 0.0) ** 3, numpy.full(len(points_m), OWN_WEIGHT)))
    return counts / counts.sum(axis=1, keepdims=True)


@dataclasses.dataclass
class Fit:
    """places_m: none where one stiffness serves for all."""

    own_N_per_m: float
    offset_m: float
    places_m: numpy.ndarray
    stiffness_N_per_m: numpy.ndarray
    spacing_m: float = 0.0
    smoothness: float = 0.0
    cross_R2: float = numpy.nan  # on rows that were left out, five times a fifth
    one_cross_R2: float = numpy.nan  # of one stiffness likewise

    def forces_N(self, contact):
        """The plain linear map: stiffness at the foot times depth."""
        depth_m = contact.depth_m(self.offset_m)
        if not len(self.places_m):
            return self.own_N_per_m * depth_m
        known = numpy.append(self.stiffness_N_per_m, self.own_N_per_m)
        return depth_m * (weights(contact.foot_m, self.places_m) @ known)


def one_stiffness(contact, offset_m):
    depth_m = contact.depth_m(offset_m)
    square_m2 = depth_m @ depth_m
    return max(depth_m @ contact.force_N / square_m2, 0.0) if square_m2 > 0.0 else 0.0


def best_offset_m(error_of, bound_m):
    """Where an error is least, by a grid and then finer ones round the best."""
    if bound_m == 0.0:
        return 0.0
    middle_m, half_m = 0.0, bound_m
    for _ in range(4):
        grid_m = numpy.linspace(max(middle_m - half_m, -bound_m), min(middle_m + half_m, bound_m), 9)
        middle_m = float(min(grid_m, key=error_of))
        half_m = 1.25 * (grid_m[1] - grid_m[0])
    return middle_m


def fit_one(contact, bound_m):
    def error(offset_m):
        return ((contact.force_N - one_stiffness(contact, offset_m) * contact.depth_m(offset_m)) ** 2).sum()

    offset_m = best_offset_m(error, bound_m)
    none = numpy.empty((0, 3))
    return Fit(one_stiffness(contact, offset_m), offset_m, none, numpy.empty(0))


def spread(points_m, spacing_m):
    """Points no nearer to each other than that, so many that no other is farther from all; at most MAX_PLACES + 1."""
    chosen = [points_m[0]]
    left_m = numpy.linalg.norm(points_m - points_m[0], axis=1)
    while left_m.max() > spacing_m and len(chosen) <= MAX_PLACES:
        chosen.append(points_m[left_m.argmax()])
        left_m = numpy.minimum(left_m, numpy.linalg.norm(points_m - chosen[-1], axis=1))
    return numpy.array(chosen)


def at_least(matrix, vector, least):
    """What minimises x.M.x / 2 - v.x with every x at or above `least`; M is positive definite."""
    is_free = numpy.full(len(vector), True)
    x = numpy.full(len(vector), least)
    for _ in range(100):
        x[:] = least
        rows = numpy.flatnonzero(is_free)
        rest = vector[rows] - matrix[numpy.ix_(rows, ~is_free)].sum(axis=1) * least
        x[rows] = numpy.linalg.solve(matrix[numpy.ix_(rows, rows)], rest)
        slope = matrix @ x - vector
        too_low, pulled = is_free & (x < least), ~is_free & (slope < -1e-12 * abs(vector).max())
        if not too_low.any() and not pulled.any():
            break
        is_free = is_free & ~too_low | pulled
    return numpy.maximum(x, least)


class Candidate:
    """Places of one spacing: what their least squares need, whatever the smoothness."""

    def __init__(self, contact, places_m, spacing_m, own_N_per_m):
        self.contact, self.places_m, self.spacing_m, self.own_N_per_m = contact, places_m, spacing_m, own_N_per_m
        self.weights = weights(contact.foot_m, places_m)
        count = len(places_m)
        apart_m = distances(places_m, places_m)
        numpy.fill_diagonal(apart_m, numpy.inf)
        self.rough = numpy.zeros((count, count))  # sum of squared differences of neighbours, by six a place
        for i, row in enumerate(numpy.argsort(apart_m, axis=1)[:, :min(6, count - 1)]):
            for j in row:
                self.rough[[i, j], [i, j]] += 1.0
                self.rough[[i, j], [j, i]] -= 1.0

    def normal(self, offset_m, rows=slice(None)):
        """A^T A, A^T f and f.f, of forces above those of the body's own stiffness."""
        depth_m = self.contact.depth_m(offset_m)[rows]
        matrix = depth_m[:, None] * self.weights[rows, :-1]
        force_N = self.contact.force_N[rows] - self.own_N_per_m * depth_m * self.weights[rows, -1]
        return matrix.T @ matrix, matrix.T @ force_N, force_N @ force_N

    def solve(self, normal, smoothness):
        gram, vector, _ = normal
        scale = max(numpy.trace(gram) / len(vector), 1e-300)
        matrix = gram + scale * (smoothness * self.rough + TOWARDS_OWN * numpy.eye(len(vector)))
        return at_least(matrix, vector + scale * TOWARDS_OWN * self.own_N_per_m, LEAST_SHARE * self.own_N_per_m)

    def error(self, normal, stiffness):
        gram, vector, square = normal
        return stiffness @ gram @ stiffness - 2.0 * vector @ stiffness + square

    def cross_errors(self, offset_m):
        """Squared error on rows left out, for each smoothness."""
        folds = [self.normal(offset_m, fold_of(self.contact) == k) for k in range(FOLDS)]
        whole = [sum(part) for part in zip(*folds)]
        return [sum(self.error(fold, self.solve([all_ - part for all_, part in zip(whole, fold)], smoothness))
                    for fold in folds) for smoothness in SMOOTHNESS]


def fold_of(contact):
    """Rows in blocks of time, so that what is left out is elsewhere on the surface."""
    rows = numpy.arange(len(contact.time_s))
    return (rows * BLOCKS // len(rows)) % FOLDS


def one_cross_error(contact, offset_m):
    depth_m, folds, sum_N2 = contact.depth_m(offset_m), fold_of(contact), 0.0
    for k in range(FOLDS):
        rest = folds != k
        square_m2 = depth_m[rest] @ depth_m[rest]
        stiffness = depth_m[rest] @ contact.force_N[rest] / square_m2 if square_m2 > 0.0 else 0.0
        sum_N2 += ((contact.force_N - stiffness * depth_m)[~rest] ** 2).sum()
    return sum_N2


def spacings_m(feet_m, least_m):
    """From a quarter of the touched surface down to what the field can hold."""
    size_m = numpy.linalg.norm(feet_m.max(axis=0) - feet_m.min(axis=0))
    return [size_m / parts for parts in (4, 6, 8, 11, 15, 20, 27) if size_m / parts >= least_m]


def fit_map(contact, one, bound_m, asked_spacing_m, least_spacing_m):
    """The map that predicts best what it has not seen; one stiffness where none does better."""
    feet_m = contact.foot_m[contact.depth_m(one.offset_m) > 0.0]
    candidates = []
    for spacing_m in [asked_spacing_m] if asked_spacing_m else spacings_m(feet_m, least_spacing_m):
        places_m = spread(feet_m, spacing_m)
        if 4 <= len(places_m) <= MAX_PLACES:
            candidates.append(Candidate(contact, places_m, spacing_m, one.own_N_per_m))
    total = ((contact.force_N - contact.force_N.mean()) ** 2).sum()
    best, offset_m = None, one.offset_m
    for _ in range(2):  # the offset that suits one stiffness is another than that of the map
        tried = [(error, candidate, smoothness) for candidate in candidates
                 for error, smoothness in zip(candidate.cross_errors(offset_m), SMOOTHNESS)]
        if not tried:
            break
        best = min(tried, key=lambda one: one[0])
        offset_m = best_offset_m(lambda at_m: penalised(best, at_m), bound_m)
    one.one_cross_R2 = one.cross_R2 = 1.0 - one_cross_error(contact, one.offset_m) / total
    if not best or (not asked_spacing_m and 1.0 - best[0] / total < one.cross_R2 + WORTH_A_MAP):
        return one
    _, candidate, smoothness = best
    cross = dict(zip(SMOOTHNESS, candidate.cross_errors(offset_m)))[smoothness]
    return Fit(one.own_N_per_m, offset_m, candidate.places_m,
               candidate.solve(candidate.normal(offset_m), smoothness), candidate.spacing_m, smoothness,
               1.0 - cross / total, one.one_cross_R2)


def penalised(best, offset_m):
    _, candidate, smoothness = best
    normal = candidate.normal(offset_m)
    return candidate.error(normal, candidate.solve(normal, smoothness))


def R2(measured_N, predicted_N):
    """1: all of the measured force's variance is predicted; 0: as good as its mean."""
    about_mean = ((measured_N - measured_N.mean()) ** 2).sum()
    return float(1.0 - ((measured_N - predicted_N) ** 2).sum() / about_mean) if about_mean > 0.0 else numpy.nan
