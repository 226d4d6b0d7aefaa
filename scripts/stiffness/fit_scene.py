"""The scene of a stiffness fit: the body in it, scenes that measure it, and the scene as fitted."""
import os
import tomllib

import numpy

import toml_edit
from expectation import Unusable

PROBE_N_PER_M = 1000.0


def shown(value):
    return f"value '{value}'" if isinstance(value, str) else f"value {value!r}"


def rotation(orientation_xyzw):
    x, y, z, w = numpy.array(orientation_xyzw) / numpy.linalg.norm(orientation_xyzw)
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def has_field(body):
    """Whether a body is met through its distance field, which is the default of a mesh that keeps its shape."""
    asks_for_spheres = "spheres" in body or "spring_stiffness_N_per_m" in body
    return body.get("kind") == "mesh" and body.get("contact", "spheres" if asks_for_spheres else "field") == "field"


class FitScene:
    """A scene with a static mesh that is met through its field, by a tool of one sphere."""

    def __init__(self, file, body_name):
        self.file = file
        try:
            self.text = file.read_bytes().decode("utf-8")
            self.document = tomllib.loads(self.text)
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise Unusable(f"{file}: {error}") from None
        bodies = self.document.get("body", [])
        if not isinstance(bodies, list) or not all(isinstance(body, dict) for body in bodies):
            raise Unusable(f"{file}: body: expected [[body]] tables")
        self.number = self._find(bodies, body_name)
        self.body = bodies[self.number]
        self._check_body()
        self.tool_m = self._tool_radius_m()
        self.own_N_per_m = self._own_stiffness()
        device = self.document.get("device", {})
        if device.get("orientation_xyzw", [0.0, 0.0, 0.0, 1.0])[:3] != [0.0, 0.0, 0.0]:
            raise Unusable(f"{file}: device.orientation_xyzw: {shown(device['orientation_xyzw'])}: expected a device "
                           "that is not turned, whose forces are along the scene's axes")

    def refuse(self, key, value, expected):
        raise Unusable(f"{self.file}: body '{self.body['name']}': {key}: {value}: expected {expected}")

    def _find(self, bodies, name):
        if isinstance(self.document.get("hand"), list):
            raise Unusable(f"{self.file}: hand: value {len(self.document['hand'])} hands with names: expected the "
                           "tables [tool] and [device] of one")
        fields = [i for i, body in enumerate(bodies) if has_field(body)]
        if name is not None:
            found = next((i for i, body in enumerate(bodies) if body.get("name") == name), None)
            if found is None:
                names = ", ".join(str(body.get("name")) for body in bodies)
                raise Unusable(f"--body: value '{name}': expected one of {names}")
            return found
        if len(fields) != 1:
            raise Unusable(f"{self.file}: body: value {len(fields)} bodies with contact = \"field\": expected one, or "
                           "--body NAME")
        return fields[0]

    def _check_body(self):
        body = self.body
        for key in ("name", "file", "material"):
            if not isinstance(body.get(key), str):
                raise Unusable(f"{self.file}: body {self.number + 1}: {key}: {shown(body.get(key))}: expected a string")
        for key, wanted, is_so in (("kind", "mesh", body.get("kind") == "mesh"), ("contact", "field", has_field(body)),
                                   ("motion", "static", body.get("motion") == "static")):
            if not is_so:
                self.refuse(key, shown(body[key]) if key in body else "value missing", f'"{wanted}"')
        if not isinstance(body.get("field"), dict) or not isinstance(body["field"].get("cell_m"), float):
            self.refuse("field", "value missing", "field = { cell_m = ... }")

    def _tool_radius_m(self):
        tool = self.document.get("tool", {})
        spheres = tool.get("spheres")
        if spheres is None:
            return float(tool.get("radius_m", 0.005))
        if len(spheres) != 1 or any(spheres[0].get("position_m", ())):
            raise Unusable(f"{self.file}: tool.spheres: value {len(spheres)} spheres: expected one, at the tool's "
                           "origin: only of such a tool is the depth known from a force")
        return float(spheres[0]["radius_m"])

    def _own_stiffness(self):
        """Of the material; a fit finds what the body's is over it."""
        for material in self.document.get("material", []):
            if material.get("name") == self.body["material"]:
                return float(material["contact_stiffness_N_per_m"])
        return self.refuse("material", shown(self.body["material"]), "the name of a [[material]]")

    @property
    def cell_m(self):
        return self.body["field"]["cell_m"]

    def to_mesh(self, points_m):
        """From the scene's frame into that of the mesh's file, scaled."""
        turn = rotation(self.body.get("orientation_xyzw", (0.0, 0.0, 0.0, 1.0)))
        return (points_m - numpy.array(self.body.get("position_m", (0.0, 0.0, 0.0)))) @ turn

    def alone(self, contact, tool_m=None):
        """A scene of this body alone, PROBE_N_PER_M stiff, without damping or friction; contact: how it is met."""
        kept = ("kind", "file", "scale", "position_m", "orientation_xyzw")
        body = {key: self.body[key] for key in kept if key in self.body}
        body |= {"name": "body", "material": "probe", "motion": "static",
                 "file": str((self.file.parent / self.body["file"]).resolve()), **contact}
        tables = {"world": {"gravity_m_s2": [0.0, 0.0, 0.0]}, "simulation": {"rate_hz": 10.0},
                  "tool": {"radius_m": tool_m or self.tool_m}}
        if "device" in self.document:
            tables["device"] = self.document["device"]
        tables["material"] = [{"name": "probe", "contact_stiffness_N_per_m": PROBE_N_PER_M}]
        tables["body"] = [body]
        lines = ["format = 2"]
        for name, table in tables.items():
            for one in table if isinstance(table, list) else [table]:
                lines.append(f"[[{name}]]" if isinstance(table, list) else f"[{name}]")
                lines += [f"{key} = {toml_edit.literal(value)}" for key, value in one.items()]
        return "\n".join(lines) + "\n"

    def field(self, offset_m):
        keys = {key: self.body["field"][key] for key in ("cell_m", "band_m") if key in self.body["field"]}
        return {"contact": "field", "field": {**keys, "offset_m": offset_m}}

    def fitted(self, fit, map_name, folder, head):
        """The user's text with the fitted values, to stand in a folder; map_name: None without a map."""
        changes = {}
        for i, body in enumerate(self.document["body"]):
            spheres, field = body.get("spheres"), body.get("field")
            for path, table in ((("file",), body), (("spheres", "file"), spheres), (("field", "stiffness_map"), field)):
                if isinstance(table, dict) and isinstance(table.get(path[-1]), str):
                    changes["body", i, *path] = os.path.relpath(self.file.parent / table[path[-1]], folder)
        hand = self.document.get("hand")
        if isinstance(hand, dict) and isinstance(hand.get("file"), str):
            changes["hand", "file"] = os.path.relpath(self.file.parent / hand["file"], folder)
        own = ("body", self.number)
        changes[(*own, "stiffness_scale")] = float(f"{fit.own_N_per_m / self.own_N_per_m:.6g}")
        changes[(*own, "field", "offset_m")] = float(f"{fit.offset_m:.6g}")
        if map_name or "stiffness_map" in self.body["field"]:
            changes[(*own, "field", "stiffness_map")] = map_name
        try:
            text = toml_edit.edited(self.text, changes)
        except toml_edit.Exotic as error:
            raise Unusable(f"{self.file}: {error}: expected keys and tables that can be edited safely") from None
        return toml_edit.line_end_of(text).join([*(f"# {line}" for line in head), "", text])
