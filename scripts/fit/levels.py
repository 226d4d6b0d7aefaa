"""The level of detail of bodies: fewer spheres that push as hard on average.

Bodies that are alike but for their places change together. Level 0 is the body as given, each next one coarser.
"""
import json

FACTORS = (1.41, 2.0, 2.8)  # of a spacing or a field's cell
MESH_FACTORS = (1.5, 2.0, 4.0)  # of the tolerance of a mesh's spheres
SPACED = ("sheet", "thread", "soft_block", "rigid_box")
PLACES = ("name", "position_m", "orientation_xyzw", "from_m", "to_m", "velocity_m_s", "angular_velocity_rad_s",
          "motion", "direction", "amplitude_m", "frequency_hz", "pinned")


def length_m(body):
    return sum((a - b) ** 2 for a, b in zip(body["from_m"], body["to_m"])) ** 0.5


def alike(body):
    """The keys that bodies of one group have in common, as text."""
    kept = {key: value for key, value in body.items() if key not in PLACES}
    if body["kind"] == "thread":
        kept["length_m"] = round(length_m(body), 9)
    return json.dumps(kept, sort_keys=True)


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


def density(body, spacing_m, radius_m):
    """How densely spheres push, up to a factor, and how many there are along each length: along a thread and over a
    sheet one over the spacing as it comes out; of a box their number on the largest face."""
    kind = body["kind"]
    inset_m = 0.0 if kind in ("thread", "sheet") else 2.0 * radius_m
    sizes_m = [length_m(body)] if kind == "thread" else [max(size - inset_m, 0.0) for size in body["size_m"]]
    counts = [max(1, int(size_m / spacing_m + 0.5) + 1) for size_m in sizes_m]  # bodies/kinds/packing.cpp
    if kind not in ("thread", "sheet"):
        widest = sorted(range(3), key=lambda axis: -body["size_m"][axis])[:2]
        return counts[widest[0]] * counts[widest[1]], counts
    result = 1.0
    for count, size_m in zip(counts, sizes_m):
        result *= max(count - 1, 0.5) / size_m
    return result, counts


def spaced_levels(body):
    spacing_m, radius_m = packing(body)
    given, last = density(body, spacing_m, radius_m)
    levels = []
    for factor in FACTORS:
        new_m = float(f"{factor * spacing_m:.4g}")
        new, counts = density(body, new_m, radius_m)
        if counts != last:
            scale = float(f"{body.get('stiffness_scale', 1.0) * given / new:.6g}")
            levels.append((f"spheres {1e3 * new_m:g} mm apart",
                           {"spheres": {"spacing_m": new_m, "radius_m": radius_m}, "stiffness_scale": scale}))
            last = counts
    return levels


def mesh_levels(body):
    spheres, field = body.get("spheres", {}), body.get("field", {})
    levels = []
    if "tolerance_m" in spheres and "contact" not in body:
        for factor in MESH_FACTORS:
            size_m = float(f"{factor * spheres['tolerance_m']:.4g}")
            levels.append((f"spheres within {1e3 * size_m:g} mm", {"spheres": {**spheres, "tolerance_m": size_m}}))
    if body.get("contact") == "field" and "cell_m" in field:
        for factor in (0.5, *FACTORS):
            size_m = float(f"{factor * field['cell_m']:.3g}")
            levels.append((f"field, cells of {1e3 * size_m:g} mm", {"field": {**field, "cell_m": size_m}}))
    return levels


def groups_of(document, note):
    """(names, levels) of each group of bodies that has another level; a level is a label and changed keys."""
    together = {}
    for body in document.get("body", []):
        if body["kind"] in (*SPACED, "mesh"):
            together.setdefault(alike(body), []).append(body)
        elif body["kind"] not in ("plane", "sphere"):
            note(f"{body['name']}: left as it is: of the kind {body['kind']} no coarser spheres are known")
    groups = []
    for bodies in together.values():
        levels = mesh_levels(bodies[0]) if bodies[0]["kind"] == "mesh" else spaced_levels(bodies[0])
        if levels:
            groups.append(([body["name"] for body in bodies], [("as given", {}), *levels]))
    return groups
