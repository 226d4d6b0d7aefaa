"""The level of detail of bodies: fewer spheres that push as hard on average.

Bodies that are alike but for their places change together, those that a hand comes near apart from those that it does
not: where nothing is felt fewer spheres may do. Level 0 is the body as given, each next one coarser:
by FACTORS times its spacing, or by MESH_FACTORS times the tolerance of a mesh's spheres.
"""
import dataclasses
import json
import pathlib
import subprocess

FACTORS = (1.41, 2.0, 2.8)
MESH_FACTORS = (1.5, 2.0, 4.0)
# In place of a file of spheres, whose tolerance nobody knows: parts of the mesh's diagonal, from coarse to fine.
DIAGONAL_PARTS = (20.0, 28.0, 40.0, 56.0, 80.0, 110.0, 160.0)
MOST_LEVELS = 4
SPACED = ("sheet", "thread", "soft_block", "rigid_box")  # kinds whose spheres have a spacing
WITHOUT_LEVELS = ("plane", "sphere")
PLACES = ("name", "position_m", "orientation_xyzw", "from_m", "to_m", "velocity_m_s", "angular_velocity_rad_s",
          "motion", "direction", "amplitude_m", "frequency_hz", "pinned")
MOST_MATERIALS = 64  # of a scene, and of bodies with a stiffness of their own, together


@dataclasses.dataclass
class Level:
    label: str
    changes: dict  # key of the body: value
    files: tuple = ()  # of spheres, made for it


@dataclasses.dataclass
class Group:
    """Bodies that are alike, and their levels, the first as given."""
    bodies: list  # names
    levels: list

    @property
    def name(self):
        return self.bodies[0] if len(self.bodies) == 1 else f"{self.bodies[0]} and {len(self.bodies) - 1} more"


def length_m(body):
    return sum((a - b) ** 2 for a, b in zip(body["from_m"], body["to_m"])) ** 0.5


def alike(body):
    """What bodies of one group have in common, to be compared."""
    kept = {key: value for key, value in body.items() if key not in PLACES}
    if body["kind"] == "thread":
        kept["length_m"] = round(length_m(body), 9)
    return json.dumps(kept, sort_keys=True)


def count_along(size_m, spacing_m):
    """As the simulation places spheres along a length (bodies/kinds/packing.cpp)."""
    return max(1, int(size_m / spacing_m + 0.5) + 1)


def packing(body):
    """Spacing and radius as given, or as the simulation chooses them."""
    spheres, kind = body.get("spheres", {}), body["kind"]
    if kind == "thread":
        spacing_m, share = length_m(body) / (body["nodes"] - 1), 0.75
    elif kind == "sheet":
        spacing_m, share = min(size_m / (n - 1) for size_m, n in zip(body["size_m"], body["nodes"])), 0.75
    else:
        spacing_m, share = min(body["size_m"]) / 3.0, 0.5
    spacing_m = spheres.get("spacing_m", spacing_m)
    return spacing_m, spheres.get("radius_m", share * spacing_m)


def lengths_of(body, radius_m):
    if body["kind"] == "thread":
        return [length_m(body)]
    inset_m = 0.0 if body["kind"] == "sheet" else 2.0 * radius_m
    return [max(size_m - inset_m, 0.0) for size_m in body["size_m"]]


def density(body, lengths_m, spacing_m):
    """How densely spheres push, up to a factor: along a thread and over a sheet one over the spacing as it comes
    out; of a box, which rests and is felt as a whole, their number on the largest face."""
    counts = [count_along(size_m, spacing_m) for size_m in lengths_m]
    if body["kind"] not in ("thread", "sheet"):
        widest = sorted(range(3), key=lambda axis: -body["size_m"][axis])[:2]
        return counts[widest[0]] * counts[widest[1]], counts
    result = 1.0
    for count, size_m in zip(counts, lengths_m):
        result *= max(count - 1, 0.5) / size_m
    return result, counts


def spaced_levels(body):
    spacing_m, radius_m = packing(body)
    lengths_m = lengths_of(body, radius_m)
    given, last_counts = density(body, lengths_m, spacing_m)
    levels = []
    for factor in FACTORS:
        new_m = float(f"{factor * spacing_m:.4g}")
        new, counts = density(body, lengths_m, new_m)
        if counts == last_counts:
            continue
        last_counts = counts
        scale = float(f"{body.get('stiffness_scale', 1.0) * given / new:.6g}")
        levels.append(Level(f"spheres {1e3 * new_m:g} mm apart",
                            {"spheres": {"spacing_m": new_m, "radius_m": radius_m}, "stiffness_scale": scale}))
    return levels


class Decomposer:
    """Makes files of spheres, once each, in the folder of the fit's inputs."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def make(self, mesh, scale, option, size_m, name):
        """The file's name and its report; nothing where the mesh has no such spheres."""
        out = self.folder / f"{name}_{option.lstrip('-').split('-')[0]}_{1e3 * size_m:.4g}mm.csv"
        report = out.with_suffix(".json")
        if not (out.is_file() and report.is_file()):
            done = subprocess.run([self.program, self.folder / mesh, "--scale", str(scale), option, repr(size_m),
                                   "--out", out, "--report", report], capture_output=True, text=True, check=False)
            if done.returncode:
                return None
        return out.name, json.loads(report.read_text())

    def diagonal_m(self, mesh, scale):
        """Of the mesh's box, from the report of its coarsest spheres."""
        for size in (0.05, 0.01):
            made = self.make(mesh, scale, "--volume-spacing", size, pathlib.Path(mesh).stem)
            if made:
                return made[1]["mesh"]["diagonal_m"]
        return None


def sizes_below(count, body, decomposer):
    """Tolerances of which fewer spheres come than so many, the finest of them first."""
    mesh, scale = body["file"], body.get("scale", 1.0)
    diagonal_m = decomposer.diagonal_m(mesh, scale)
    sizes_m = []
    for part in DIAGONAL_PARTS if diagonal_m else ():
        size_m = float(f"{diagonal_m / part:.2g}")
        made = decomposer.make(mesh, scale, "--tolerance", size_m, body["name"])
        if made and made[1]["levels"][0]["balls"] >= count:
            break
        sizes_m.insert(0, size_m)
    return sizes_m[:MOST_LEVELS]


def mesh_levels(body, decomposer, report):
    spheres, scale = body["spheres"], body.get("scale", 1.0)
    mesh = body["file"]
    if "feel" in spheres:
        report(f"{body['name']}: left as it is: its spheres are the fewest that feel as near to the mesh as asked")
        return []
    option = {"tolerance_m": "--tolerance", "surface_spacing_m": "--surface-spacing",
              "volume_spacing_m": "--volume-spacing"}.get(next(iter(spheres)), None)
    given = None
    if option:
        size_m = next(iter(spheres.values()))
        given = decomposer.make(mesh, scale, option, size_m, body["name"])
        sizes_m = [factor * size_m for factor in (MESH_FACTORS if option == "--tolerance" else FACTORS)]
        last = given[1]["levels"][0]["balls"] if given else 0
    else:
        option = "--tolerance"
        last = sum(1 for line in (decomposer.folder / spheres["file"]).read_text().splitlines()
                   if line and not line.startswith("#")) - 1
        sizes_m = sizes_below(last, body, decomposer)
    if "normalise" not in body and given is None:
        report(f"{body['name']}: left as it is: without normalise nobody knows how stiff other spheres would be")
        return []
    levels = []
    for size_m in sizes_m:
        made = decomposer.make(mesh, scale, option, float(f"{size_m:.4g}"), body["name"])
        if made is None or made[1]["levels"][0]["balls"] >= last:
            continue
        last = made[1]["levels"][0]["balls"]
        changes = {"spheres": {"file": made[0]}}
        if "normalise" not in body:
            felt = [of[1]["levels"][0]["force"]["stiffness_scale"] for of in (made, given)]
            changes["stiffness_scale"] = float(f"{body.get('stiffness_scale', 1.0) * felt[0] / felt[1]:.6g}")
        levels.append(Level(f"{last} spheres", changes, (made[0],)))
    return levels


def groups_of(document, decomposer, report, far=frozenset()):
    """All groups of the scene that have a coarser level. report: told what is left out. far: names of the bodies that
    no hand comes near."""
    together = {}
    for body in document.get("body", []):
        if body["kind"] in (*SPACED, "mesh"):
            together.setdefault((alike(body), body["name"] in far), []).append(body)
        elif body["kind"] not in WITHOUT_LEVELS:
            report(f"{body['name']}: left as it is: of the kind {body['kind']} no coarser spheres are known")
    free = MOST_MATERIALS - len(document.get("material", []))
    groups = []
    for bodies in together.values():
        body = bodies[0]
        levels = mesh_levels(body, decomposer, report) if body["kind"] == "mesh" else spaced_levels(body)
        if levels and "stiffness_scale" in levels[0].changes:
            free -= len(bodies)
            if free < 0:
                report(f"{body['name']}: left as it is: a scene has room for {MOST_MATERIALS} materials, and for no "
                       "more bodies with a stiffness of their own")
                free += len(bodies)
                continue
        if levels:
            groups.append(Group([body["name"] for body in bodies], [Level("as given", {}), *levels]))
    return groups
