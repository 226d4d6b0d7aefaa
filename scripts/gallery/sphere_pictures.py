"""Spheres in place of meshes: a picture of them by depth buffer, for measure_decomposition.py.

Spheres are drawn in parallel projection, the larger ones lighter, over their mesh in grey; a line
is the mesh's outline.
"""
import numpy as np

from drawing import plt

UP = {"bunny": 1, "spot": 1, "liver": 1, "contour": 2, "torus": 2}  # axis that is drawn upwards
TURN = {"bunny": 0.5, "spot": 0.6, "liver": 0.3, "contour": 0.4, "torus": 0.3}
TILT = {"bunny": 0.2, "spot": 0.2, "liver": 0.3, "contour": 1.0, "torus": 0.8}


def view_of(name):
    axes = np.roll(np.eye(3), UP[name] - 2, axis=1) if UP[name] != 2 else np.eye(3)
    turn, tilt = TURN[name], TILT[name]
    about_up = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0],
                         [0, 0, 1]])
    # x right, y up in the picture, z towards the eye
    look = np.array([[1, 0, 0], [0, np.sin(tilt), np.cos(tilt)], [0, -np.cos(tilt), np.sin(tilt)]])
    permute = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]) if UP[name] == 1 else axes
    return look @ about_up @ permute


def read_mesh(file, scale):
    """Corners of triangles in metres, (n, 3, 3)."""
    if file.suffix == ".stl":
        triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
        return scale * np.fromfile(file, triangle, offset=84)["corners"].astype(float)
    points, faces = [], []
    if file.suffix == ".off":
        words = file.read_text().split()
        count, face_count = int(words[1]), int(words[2])
        points = np.array(words[4:4 + 3 * count], float).reshape(-1, 3)
        faces = np.array(words[4 + 3 * count:][:4 * face_count], int).reshape(-1, 4)[:, 1:]
        return scale * points[faces]
    for line in file.read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            points.append([float(word) for word in words[:3]])
        elif kind == "f":
            corners = [int(word.split("/")[0]) - 1 for word in words]
            faces += [[corners[0], *pair] for pair in zip(corners[1:], corners[2:])]
    return scale * np.array(points)[np.array(faces)]


LIGHT = np.array([-0.4, 0.6, 0.7]) / np.linalg.norm([-0.4, 0.6, 0.7])


class Picture:
    """A picture of `size` metres by depth buffer, white where there is nothing."""

    def __init__(self, low, size, pixels_per_m):
        shape = np.ceil(size * pixels_per_m).astype(int)
        self.x, self.y = (low[k] + (np.arange(shape[k]) + 0.5) / pixels_per_m for k in (0, 1))
        self.image = np.ones((shape[1], shape[0], 3))
        self.clear_depth()

    def clear_depth(self):
        self.depth = np.full(self.image.shape[:2], -np.inf)

    def window(self, low, high):
        return (np.flatnonzero((self.x > low[0]) & (self.x < high[0])),
                np.flatnonzero((self.y > low[1]) & (self.y < high[1])))

    def paint(self, i, j, z, shade, tint):
        """z: -inf where there is nothing."""
        window = np.ix_(j, i)
        nearer = z > self.depth[window]
        self.depth[window] = np.where(nearer, z, self.depth[window])
        self.image[window] = np.where(nearer[..., None], tint * shade, self.image[window])

    def paint_mesh(self, triangles):
        for a, b, c in triangles:
            normal = np.cross(b - a, c - a)
            if normal[2] <= 0:
                continue
            corners = np.stack([a, b, c])
            i, j = self.window(corners.min(axis=0), corners.max(axis=0))
            if not len(i) or not len(j):
                continue
            px, py = np.meshgrid(self.x[i], self.y[j])
            inside = np.ones(px.shape, bool)
            for p, q in ((a, b), (b, c), (c, a)):
                inside &= (q[0] - p[0]) * (py - p[1]) - (q[1] - p[1]) * (px - p[0]) >= 0
            z = a[2] - (normal[0] * (px - a[0]) + normal[1] * (py - a[1])) / normal[2]
            shade = 0.62 + 0.33 * max(0.0, normal @ LIGHT / np.linalg.norm(normal))
            self.paint(i, j, np.where(inside, z, -np.inf), shade, np.ones(3))

    def paint_spheres(self, centres, radii):
        ranks = np.argsort(np.argsort(radii))
        tints = plt.get_cmap("viridis")(0.25 + 0.6 * (ranks + 0.5) / len(radii))[:, :3]
        for centre, radius, tint in zip(centres, radii, tints):
            i, j = self.window(centre - radius, centre + radius)
            if not len(i) or not len(j):
                continue
            dx, dy = np.meshgrid(self.x[i] - centre[0], self.y[j] - centre[1])
            dz = np.sqrt(np.maximum(radius**2 - dx**2 - dy**2, 0))
            normal = np.stack([dx, dy, dz], axis=-1) / radius
            shade = 0.35 + 0.65 * np.clip(normal @ LIGHT, 0, 1)
            self.paint(i, j, np.where(dz > 0, centre[2] + dz, -np.inf), shade[..., None], tint)


def make_panels(decomposed):
    """For each mesh: its name, triangles and spheres as the picture sees them, and where they lie in it."""
    for name, triangles, levels in decomposed:
        view = view_of(name)
        sets = [(share, spheres[:, :3] @ view.T, spheres[:, 3]) for share, spheres in levels]
        low = np.min([(centres - radii[:, None]).min(axis=0) for _, centres, radii in sets], axis=0)
        high = np.max([(centres + radii[:, None]).max(axis=0) for _, centres, radii in sets], axis=0)
        margin = 0.03 * (high - low)[:2].max()
        yield name, triangles @ view.T, sets, low[:2] - margin, (high - low)[:2] + 2 * margin


def draw_spheres(decomposed):
    """A line a mesh: (name, its triangles' corners in metres, [(tolerance, rows x, y, z, radius), ...])."""
    panels = list(make_panels(decomposed))
    width_in, pixels = 3.1, 430
    heights = [width_in * min(size[1] / size[0], 1.0) + 0.25 for *_, size in panels]
    figure, grid = plt.subplots(len(panels), len(panels[0][2]), squeeze=False,
                                figsize=(width_in * len(panels[0][2]), sum(heights) + 0.4),
                                gridspec_kw={"height_ratios": heights})
    for line, (name, triangles, sets, low, size) in zip(grid, panels):
        for axes, (share, centres, radii) in zip(line, sets):
            drawn = Picture(low, size, pixels / size.max())
            drawn.paint_mesh(triangles)
            outline = np.isfinite(drawn.depth)
            drawn.clear_depth()
            drawn.paint_spheres(centres, radii)
            axes.imshow(drawn.image, origin="lower")
            axes.contour(outline, levels=[0.5], colors="black", linewidths=0.8)
            axes.set_axis_off()
            axes.set_title(f"{name}, within {100 * share:g} %: {len(radii)}", fontsize=9.5)
    figure.suptitle("Spheres in place of meshes (grey, outlined); tolerance in % of the box's "
                    "diagonal, and how many", x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0, 1, 0.99), h_pad=0.4, w_pad=0.2)
    return figure
