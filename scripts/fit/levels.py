"""The level of detail of bodies: fewer spheres, or wider cells.

Bodies that are alike but for their places change together. Level 0 is the body as given, each next one coarser.
"""
import json
import math

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
    """Spacing and radius as given, or as the simulation completes them (sim_server/bodies/kinds/packing.cpp)."""
    spheres, kind = body.get("spheres", {}), body["kind"]
    largest_m = float("inf")
    if kind == "thread":
        radius_m = length_m(body) / (body["nodes"] - 1)
    elif kind == "sheet":
        radius_m = min(size_m / (n - 1) for size_m, n in zip(body["size_m"], body["nodes"]))
    else:
        radius_m, largest_m = min(max(body["size_m"]) / 6.0, min(body["size_m"]) / 3.0), min(body["size_m"]) / 2.0
    if "spacing_m" in spheres:
        radius_m = min(spheres["spacing_m"], largest_m)
    radius_m = spheres.get("radius_m", radius_m)
    return spheres.get("spacing_m", radius_m), radius_m


def counts_along(body, spacing_m, radius_m):
    """Spheres along each length, as sim_server/bodies/kinds/packing.cpp counts them."""
    inset_m = 0.0 if body["kind"] in ("thread", "sheet") else 2.0 * radius_m
    sizes_m = [length_m(body)] if body["kind"] == "thread" else [max(size - inset_m, 0.0) for size in body["size_m"]]
    return [max(1, math.ceil(size_m / spacing_m - 1e-6) + 1) for size_m in sizes_m]


def spaced_levels(body):
    spacing_m, radius_m = packing(body)
    last = counts_along(body, spacing_m, radius_m)
    levels = []
    for factor in FACTORS:
        new_m = float(f"{factor * spacing_m:.4g}")
        counts = counts_along(body, new_m, radius_m)
        if counts != last:
            levels.append((f"spheres {1e3 * new_m:g} mm apart", {"spheres": {"spacing_m": new_m, "radius_m": radius_m}}))
            last = counts
    return levels


def mesh_levels(body):
    spheres, field = body.get("spheres", {}), body.get("field", {})
    levels = []
    if "tolerance_m" in spheres:
        for factor in MESH_FACTORS:
            size_m = float(f"{factor * spheres['tolerance_m']:.4g}")
            levels.append((f"spheres within {1e3 * size_m:g} mm", {"spheres": {**spheres, "tolerance_m": size_m}}))
    if "cell_m" in field:
        for factor in (0.5, *FACTORS):
            size_m = float(f"{factor * field['cell_m']:.3g}")
            levels.append((f"field, cells of {1e3 * size_m:g} mm", {"field": {**field, "cell_m": size_m}}))
    return levels


def groups_of(document, note):
    """(names, levels) of each group of bodies that has another level; a level is a label and changed keys."""
    together = {}
    for body in document.get("body", []):
        if body["kind"] in ("plane", "sphere", "compound") or (body["kind"] == "rigid_box" and "spheres" not in body):
            continue  # exact
        if body["kind"] in (*SPACED, "mesh"):
            together.setdefault(alike(body), []).append(body)
        else:
            note(f"{body['name']}: left as it is: of the kind {body['kind']} no coarser spheres are known")
    groups = []
    for bodies in together.values():
        levels = mesh_levels(bodies[0]) if bodies[0]["kind"] == "mesh" else spaced_levels(bodies[0])
        if levels:
            groups.append(([body["name"] for body in bodies], [("as given", {}), *levels]))
    return groups
