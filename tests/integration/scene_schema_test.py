#!/usr/bin/python3
"""The JSON schema of scenes against the reader: the same keys and values in every table, both ways."""
import copy
import json
import pathlib
import random
import re
import subprocess
import tomllib
import unittest

import daemons
import jsonschema
from daemons import BUILD, DONE

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMA = json.loads((ROOT / "sim_server/scene/scene.schema.json").read_text())
KINDS = SCHEMA["definitions"]["body"]["properties"]["kind"]["enum"]
CUBE = ("".join(f"v {x} {y} {z}\n" for z in (0, 1) for y in (0, 1) for x in (0, 1)) +
        "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n")
SPRINGS = {"structural": 50.0}
UNKNOWN = "zzqq"  # near to no key
GEOMETRY = {
    "sheet": {"nodes": [3, 4], "size_m": [0.1, 0.2], "spring_stiffness_N_per_m": SPRINGS, "pinned": "corners"},
    "thread": {"nodes": 5, "from_m": [0.0, 0.0, 0.1], "to_m": [0.05, 0.0, 0.1], "spring_stiffness_N_per_m": SPRINGS,
               "pinned": "both", "spheres": {"radius_m": 0.002}},
    "soft_block": {"nodes": [3, 2, 4], "size_m": [0.2, 0.1, 0.3], "spring_stiffness_N_per_m": SPRINGS,
                   "pinned": {"low_m": [-9, -9, -9], "high_m": [9, 9, -0.1]}},
    "rigid_box": {"size_m": [0.1, 0.2, 0.3], "spheres": {"spacing_m": 0.05}},
    "mesh": {"file": "cube.obj", "scale": 0.04},
    "sphere": {"radius_m": 0.05, "position_m": [0.0, 0.0, 1.0]},
    "plane": {"normal": [0.0, 0.0, 1.0]},
    "compound": {"shape": [{"kind": "box", "size_m": [0.1, 0.2, 0.3]}]}}
MOTION_KEYS = {"mass_kg": 0.1, "velocity_m_s": [0.0, 0.1, 0.0], "angular_velocity_rad_s": [0.0, 0.1, 0.0],
               "direction": [0.0, 0.0, 1.0], "amplitude_m": 0.01, "frequency_hz": 2.0,
               "keyframes": [{"time_s": 1.0, "displacement_m": [0.0, 0.0, 0.01]}]}
SOFT = {"spheres": {"surface_spacing_m": 0.01}, "spring_stiffness_N_per_m": SPRINGS, "lattice_m": 0.02, "pinned": "none"}


def body(kind, **keys):
    dynamics = {} if kind == "plane" or "motion" in keys else {"mass_kg": 0.1}
    return {"name": "b", "kind": kind, "material": "m", **dynamics, **copy.deepcopy(GEOMETRY[kind]), **keys}


def scene(*bodies, **tables):
    return {"format": 2, "material": [{"name": "m", "contact_stiffness_N_per_m": 500.0}], "body": list(bodies),
            **tables}


def value_text(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {value_text(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(value_text(each) for each in value) + "]"
    return json.dumps(value)


def toml_text(document):
    return "".join(f"{key} = {value_text(value)}\n" for key, value in document.items())


def table_variants():
    """Of every table: its place in the schema, and scenes with its place in them that together ask for all its
    keys."""
    of = SCHEMA["definitions"]
    for name in ("world", "simulation", "grid"):
        simulations = ({}, {"integrator": "auto"}) if name == "simulation" else ({},)
        yield SCHEMA["properties"][name], [(scene(**{name: dict(each)}), (name,)) for each in simulations]
    for name in ("tool", "device"):
        yield of[name], [(scene(**{name: {}}), (name,))]
    yield of["tool"]["properties"]["spheres"]["items"], [
        (scene(tool={"spheres": [{"radius_m": 0.01}]}), ("tool", "spheres", 0))]
    yield of["typicalHand"], [(scene(hand={"file": "hand.csv"}), ("hand",))]
    yield of["hand"], [(scene(hand=[{"name": "left"}]), ("hand", 0))]
    yield of["material"], [(scene(), ("material", 0))]
    yield of["joint"], [(scene(body("sphere"), {**body("sphere"), "name": "c"}, joint=[
        {"name": "j", "body": "b", "joined_to": "c", "points_m": [[0.0, 0.0, 1.0]], "stiffness_N_per_m": 10.0}]),
        ("joint", 0))]
    inner = ("body", 0)
    yield of["packing"], [(scene(body(kind, spheres={})), inner + ("spheres",))
                          for kind in ("sheet", "thread", "soft_block", "rigid_box")]
    yield of["meshSpheres"], [(scene(body("mesh", spheres={key: value})), inner + ("spheres",)) for key, value in
                              (("tolerance_m", 0.01), ("surface_spacing_m", 0.01), ("volume_spacing_m", 0.01),
                               ("file", "s.csv"))]
    yield of["springs"], [(scene(body(kind, **(SOFT if kind == "mesh" else {}))), inner + ("spring_stiffness_N_per_m",))
                          for kind in ("sheet", "soft_block", "mesh")]
    yield of["threadSprings"], [(scene(body("thread")), inner + ("spring_stiffness_N_per_m",))]
    yield of["box"], [(scene(body("soft_block")), inner + ("pinned",))]
    yield of["shape"], [(scene(body("compound", shape=[shape])), inner + ("shape", 0)) for shape in (
        {"kind": "box", "size_m": [0.1, 0.2, 0.3]}, {"kind": "sphere", "radius_m": 0.1},
        {"kind": "capsule", "radius_m": 0.1, "length_m": 0.3}, {"kind": "cylinder", "radius_m": 0.1, "length_m": 0.3})]
    yield of["keyframe"], [(scene(body("sphere", motion="prescribed", keyframes=MOTION_KEYS["keyframes"])),
                            inner + ("keyframes", 0))]
    yield of["field"], [(scene(body("mesh", field={"cell_m": 0.002}, motion="static")), inner + ("field",))]


def with_key(document, place, key, value):
    changed = copy.deepcopy(document)
    table = changed
    for step in place:
        table = table[step]
    table[key] = value
    return changed


def range_of(schema):
    """The least and the largest number of a key; nothing for what is no number alone."""
    for part in (schema, *schema.get("allOf", ())):
        part = SCHEMA["definitions"][part["$ref"].rpartition("/")[2]] if "$ref" in part else part
        if part.get("type") == "number":
            return part["minimum"], part["maximum"]
    return None


class SceneSchemaTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        self.write("cube.obj", CUBE)
        self.validator = jsonschema.Draft7Validator(SCHEMA)

    def refusal(self, document):
        """What sim_server --check says of a scene that it refuses; empty: it takes it."""
        file = self.write("scene.toml", toml_text(document))
        command = [str(BUILD / "bin" / "sim_server"), "--scene", str(file), "--check"]
        result = subprocess.run(command, capture_output=True, text=True, timeout=60 * daemons.PATIENCE)
        return "" if result.returncode == DONE else result.stderr.splitlines()[-1]

    def asked_keys(self, document, place):
        refusal = self.refusal(with_key(document, place, UNKNOWN, 1))
        listed = re.search(r": expected no such key here, but ([^()]*?)(?: \(.*\))?$", refusal)
        self.assertTrue(listed and UNKNOWN in refusal, refusal)
        return set(listed.group(1).split(", "))

    def test_the_schema_is_one_and_scenes_that_ship_and_kept_cases_satisfy_it(self):
        jsonschema.Draft7Validator.check_schema(SCHEMA)
        files = [*(ROOT / "sim_server/scene/scenes").glob("*.toml"), *(ROOT / "tests/laws/corpus").glob("*.toml")]
        self.assertGreater(len(files), 15)
        for file in files:
            errors = [error.message for error in self.validator.iter_errors(tomllib.loads(file.read_text()))]
            self.assertEqual(errors, [], file)

    def test_every_table_has_the_keys_that_the_reader_asks_for(self):
        seen = []
        for table, variants in table_variants():
            keys = set().union(*(self.asked_keys(*variant) for variant in variants))
            self.assertEqual(set(table["properties"]), keys)
            self.assertIs(table["additionalProperties"], False)
            seen.append(id(table))
        self.assertEqual(set(SCHEMA["properties"]), self.asked_keys(scene(), ()))
        # And there is no table that no reader was asked about, but for bodies, which follow.
        tables = [each for each in SCHEMA["definitions"].values() if "properties" in each]
        tables += [each for each in SCHEMA["properties"].values() if "properties" in each]
        self.assertEqual([each for each in tables if id(each) not in seen], [SCHEMA["definitions"]["body"]])

    def test_every_kind_of_body_has_the_keys_that_the_reader_asks_for(self):
        definition = SCHEMA["definitions"]["body"]
        owned = {rule["if"]["properties"]["kind"]["const"]: rule["then"]["propertyNames"]["enum"]
                 for rule in definition["allOf"] if "propertyNames" in rule["then"]}
        self.assertEqual(list(owned), KINDS)
        for kind, keys in owned.items():
            variants = [body(kind)]
            if kind == "mesh":
                variants += [body(kind, **SOFT), body(kind, motion="static")]
            if kind not in ("sheet", "thread", "soft_block", "plane"):
                variants.append(body(kind, motion="prescribed", velocity_m_s=[0.1, 0.0, 0.0]))
            asked = set().union(*(self.asked_keys(scene(each), ("body", 0)) for each in variants))
            self.assertEqual(set(keys), asked, kind)
        self.assertEqual(set(definition["properties"]), set().union(*owned.values()))

    def test_every_word_that_a_key_may_be_is_one_that_the_reader_takes(self):
        properties = SCHEMA["definitions"]["body"]["properties"]
        simulation = SCHEMA["properties"]["simulation"]["properties"]
        details = {rule["if"]["properties"]["kind"]["const"]: rule["then"]["properties"]
                   for rule in SCHEMA["definitions"]["body"]["allOf"] if "propertyNames" in rule["then"]}
        cases = [(scene(simulation={"integrator": UNKNOWN}), simulation["integrator"]["enum"])]
        cases += [(scene(body("mesh", contact=UNKNOWN)), properties["contact"]["enum"]),
                  (scene({**body("sphere"), "kind": UNKNOWN}), properties["kind"]["enum"])]
        for kind in KINDS:
            motions = details[kind].get("motion", properties["motion"])["enum"]
            cases.append((scene(body(kind, motion=UNKNOWN)), motions))
            if "pinned" in details[kind]:
                soft = {**(SOFT if kind == "mesh" else {}), "pinned": UNKNOWN}
                cases.append((scene(body(kind, **soft)), details[kind]["pinned"]["anyOf"][0]["enum"]))
        cases.append((scene(body("compound", shape=[{"kind": UNKNOWN}])),
                      SCHEMA["definitions"]["shape"]["properties"]["kind"]["enum"]))
        for document, words in cases:
            refusal = self.refusal(document)
            listed = re.search(r": expected one of ([^(]*?)(?: \(.*\))?$", refusal)
            self.assertTrue(listed, refusal)
            self.assertEqual(listed.group(1).split(", "), words)

    def test_every_number_has_the_range_that_the_reader_has(self):
        of_bodies = SCHEMA["definitions"]["body"]["properties"]
        cases = [([(scene(body(kind, **extra)), ("body", 0))], key, of_bodies[key]) for kind, extra, keys in (
            ("sphere", {}, ("mass_kg", "radius_m", "stiffness_scale")),
            ("sphere", {"motion": "prescribed", "amplitude_m": 0.1, "frequency_hz": 1.0},
             ("amplitude_m", "frequency_hz")),
            ("thread", {}, ("spring_damping_N_s_per_m", "spring_rest_ratio")), ("mesh", {}, ("scale",)), ("mesh", SOFT, ("lattice_m",)))
            for key in keys]
        cases += [(variants, key, schema) for table, variants in table_variants()
                  for key, schema in table["properties"].items()]
        ranges = 0
        for variants, key, schema in cases:
            if range_of(schema) is None:
                continue
            least, most = range_of(schema)
            ranges += 1
            for beyond in (least - max(1e-3 * abs(least), 1e-10), 1.001 * most):
                refusals = [self.refusal(with_key(*variant, key, beyond)) for variant in variants]
                self.assertTrue(any(f".{key}: value " in refusal for refusal in refusals), (key, beyond, refusals))
            for within in (least, most):
                for variant in variants:
                    if variant[0]["body"][0:1] and variant[0]["body"][0]["kind"] == "mesh":
                        continue  # spheres so near to each other take hours
                    self.assertNotRegex(self.refusal(with_key(*variant, key, within)),
                                        rf"\.{key}: value [^:]*: expected (a number|at most 1e|at most \d+ s)")
        self.assertGreater(ranges, 25)

    def test_keys_of_another_motion_are_refused_by_both(self):
        refused = 0
        for kind, motion in (("sphere", "free"), ("sphere", "static"), ("sphere", "prescribed"), ("sheet", "free"),
                             ("rigid_box", "prescribed"), ("thread", "static"), ("plane", "static")):
            own = {"free": {"mass_kg": 0.1}, "static": {}, "prescribed": {"velocity_m_s": [0.1, 0.0, 0.0]}}[motion]
            self.assertEqual(self.refusal(scene(body(kind, motion=motion, **own))), "")
            for key, value in MOTION_KEYS.items():
                document = scene({**body(kind, motion=motion, **own), key: value})
                refusal = self.refusal(document)
                self.assertEqual(self.validator.is_valid(document), refusal == "", (kind, motion, key, refusal))
                refused += refusal != ""
        self.assertGreater(refused, 15)

    def test_methods_and_rates_are_taken_or_refused_by_both_in_drawn_scenes(self):
        self.write("hand.csv", "time_s,x_m,y_m,z_m\n0,0,0,0.1\n1,0,0,0.1\n")
        keys = SCHEMA["properties"]["simulation"]["properties"]
        choices = {"integrator": keys["integrator"]["enum"], "substeps": [1, 7],
                   "tolerance_m_s": [3e-7], "rate_hz": ["auto", 41.0]}
        taken = {False: 0, True: 0}
        for seed in (5, 1013, 65539):
            draw = random.Random(seed)
            for _ in range(30):
                drawn = {key: draw.choice(values) for key, values in choices.items() if draw.random() < 0.4}
                hand = {"hand": {"file": "hand.csv"}} if draw.random() < 0.5 else {}
                document = scene(body("sphere"), simulation=drawn, **hand)
                refusal = self.refusal(document)
                self.assertEqual(self.validator.is_valid(document), refusal == "", (document, refusal))
                taken[refusal == ""] += 1
        self.assertGreater(min(taken.values()), 15, taken)

    def test_what_the_reader_takes_the_schema_takes_in_drawn_scenes(self):
        """And most of what it refuses: not what depends on files, on sizes or on other tables."""
        refused = {False: 0, True: 0}
        taken = 0
        values = [0.01, -1.0, 3, "auto", "static", "prescribed", "none", True, [0.0, 0.0, 1.0], [2, 3], {}, 1e13]
        keys = sorted(SCHEMA["definitions"]["body"]["properties"])
        for seed in (3, 1009, 65537):
            draw = random.Random(seed)
            for _ in range(70):
                drawn = body(draw.choice(KINDS))
                key = draw.choice(draw.choice((sorted(drawn), keys)))
                if draw.random() < 0.3:
                    drawn.pop(key, None)
                else:
                    drawn[key] = draw.choice(values)
                document = scene(drawn)
                refusal, is_valid = self.refusal(document), self.validator.is_valid(document)
                if refusal:
                    refused[is_valid] += 1
                else:
                    taken += 1
                    self.assertTrue(is_valid, (drawn, [each.message for each in self.validator.iter_errors(document)]))
        self.assertGreater(taken, 20)
        self.assertGreater(refused[False], 4 * refused[True], refused)


if __name__ == "__main__":
    daemons.main()
