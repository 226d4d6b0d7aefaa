#!/usr/bin/python3
"""scene_fit changes the values of a scene that were fitted, and no other byte of it."""
import sys
import tomllib
import types
import unittest

import daemons
from skin_scene import SCENE

sys.path.append(str(daemons.ROOT / "scripts" / "fit"))
import candidates as space  # these after the path they need
import hands
import levels
import scene_files
import toml_edit

DECOMPOSE = """#!/usr/bin/python3 -IS
import json, sys
mesh, *rest = sys.argv[1:]
options = dict(zip(rest[::2], rest[1::2]))
size_m = float(next(value for key, value in options.items() if key in ("--tolerance", "--volume-spacing")))
count = round(0.02 / size_m)
open(options["--out"], "w").write("x_m,y_m,z_m,radius_m\\n" + "0,0,0,0.01\\n" * count)
json.dump({"mesh": {"diagonal_m": 0.2}, "levels": [{"balls": count, "force": {"stiffness_scale": 1.0 / count}}]},
          open(options["--report"], "w"))
"""

MESHES = SCENE + """
[device]
position_m = [0.0, 0.1, 0.0]
scale = 2.0
[[body]]
name = "soft"
kind = "mesh"
file = "meshes/a.obj"
spheres = { file = "meshes/a.csv" }
normalise = { tool_radius_m = 0.005, press_depth_m = 0.002 }
[[body]]
name = "hard"
kind = "mesh"
file = "meshes/a.obj"
[body.spheres]  # few
tolerance_m = 0.001
"""


class SceneFilesTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        (self.folder / "meshes").mkdir()
        for name in ("a.obj", "a.csv"):
            self.write(f"meshes/{name}", "x_m,y_m,z_m,radius_m\n" + "0,0,0,0.01\n" * 25)
        self.out = self.folder / "fits" / "one"
        self.files = scene_files.SceneFiles(self.write("skin.toml", MESHES), self.out)

    def test_bodies_that_no_hand_comes_near_are_a_group_of_their_own(self):
        def hand(x_m):
            return types.SimpleNamespace(path_m=lambda: [(x_m, 0.0, 0.2), (x_m, 0.0, 0.04)],
                                         places_m=lambda: {"a": [(0.0, 0.0, 0.0)], "b": [(0.1, 0.0, 0.0)],
                                                           "c": [(0.2, 0.0, 0.0)]})
        boxes = [{"name": name, "kind": "rigid_box", "size_m": [0.02, 0.02, 0.01], "mass_kg": 0.1} for name in "abc"]
        document = {"body": [*boxes, {"name": "floor", "kind": "plane"}]}
        self.assertEqual(hands.far_bodies(document, [hand(0.0)]), {"b", "c"})
        self.assertEqual(hands.far_bodies(document, [hand(0.0), hand(0.1)]), {"c"})
        self.assertEqual(hands.far_bodies({**document, "tool": {"radius_m": 0.064}}, [hand(0.0)]), {"c"})
        groups = levels.groups_of(document, None, print, hands.far_bodies(document, [hand(0.1)]))
        self.assertEqual([group.bodies for group in groups], [["a", "c"], ["b"]])

    def test_a_body_of_an_unknown_kind_is_left_as_it_is_with_a_line_that_says_so(self):
        lines = []
        known = self.files.copied["body"][0]
        groups = levels.groups_of({"body": [{"name": "hat", "kind": "cone"}, known]}, None, lines.append)
        self.assertEqual([group.bodies for group in groups], [[known["name"]]])
        self.assertEqual(lines, ["hat: left as it is: of the kind cone no coarser spheres are known"])

    def test_meshes_get_fewer_spheres_and_the_fitted_scene_finds_all_files(self):
        program = self.write("decompose", DECOMPOSE)
        program.chmod(0o755)
        sheet, soft, hard = levels.groups_of(
            self.files.copied, levels.Decomposer(program, self.files.inputs), self.fail)
        self.assertEqual([level.label for level in sheet.levels],
                         ["as given", "spheres 14.1 mm apart", "spheres 20 mm apart", "spheres 28 mm apart"])
        fields = [f"field, cells of {size_mm} mm" for size_mm in ("1.43", "2.86", "5.71")]
        self.assertEqual([level.label for level in soft.levels],  # of 1.3, 1.8, 2.5 and 3.6 mm; the file has 25
                         ["as given", "15 spheres", "11 spheres", "8 spheres", "6 spheres", *fields])
        self.assertEqual(soft.levels[5].changes["normalise"], None)
        self.assertEqual([level.label for level in hard.levels],
                         ["as given", "13 spheres", "10 spheres", "5 spheres", *fields])
        self.assertEqual(hard.levels[4].changes, {"contact": "field", "field": {"cell_m": 0.00143}, "spheres": None,
                                                  "stiffness_scale": 20.0})
        # Without normalise it is to stay as stiff: one over the count by DECOMPOSE, 20 of them as given.
        self.assertAlmostEqual(hard.levels[2].changes["stiffness_scale"], 2.0)
        fewest = space.Space(self.files.copied, [sheet, soft, hard], space.GRIDS["small"])
        read = fewest.files(fewest.given.but(levels=(3, 4, 3)))
        self.assertEqual([(self.out / file).is_file() for file in read], [True, True])
        both = {("body", 1, "spheres"): soft.levels[1].changes["spheres"],
                ("body", 2, "spheres"): hard.levels[1].changes["spheres"]}
        for changes in ({}, both):
            read = tomllib.loads(self.files.fitted_text(changes, ["Fitted."]))
            for body in read["body"][1:]:
                self.assertTrue((self.out / body["file"]).resolve().samefile(self.folder / "meshes/a.obj"))
                if "file" in body["spheres"]:
                    self.assertTrue((self.out / body["spheres"]["file"]).is_file())
            self.assertEqual("tolerance_m" in read["body"][2]["spheres"], not changes)

    def test_a_soft_mesh_gets_no_field(self):
        program = self.write("decompose", DECOMPOSE)
        program.chmod(0o755)
        body = {**self.files.copied["body"][1], "spring_stiffness_N_per_m": {"structural": 1.0}}
        group, = levels.groups_of({"body": [body]}, levels.Decomposer(program, self.files.inputs), self.fail)
        self.assertFalse([level.label for level in group.levels if "field" in level.label])

    def test_a_field_gets_other_cells_or_spheres(self):
        program = self.write("decompose", DECOMPOSE)
        program.chmod(0o755)
        body = {**self.files.copied["body"][2], "contact": "field", "field": {"cell_m": 0.002, "band_m": 0.004}}
        del body["spheres"]
        decomposer = levels.Decomposer(program, self.files.inputs)
        group, = levels.groups_of({"body": [body], "tool": {"radius_m": 0.008}}, decomposer, self.fail)
        self.assertEqual([level.label for level in group.levels],
                         ["as given", *(f"field, cells of {size_mm} mm" for size_mm in ("1", "2.82", "4", "5.6")),
                          "6 spheres", "3 spheres"])
        self.assertEqual(group.levels[2].changes, {"contact": "field", "field": {"cell_m": 0.00282, "band_m": 0.004}})
        spheres = group.levels[-1].changes
        self.assertEqual((spheres["contact"], spheres["field"]), (None, None))
        self.assertEqual(spheres["normalise"], {"tool_radius_m": 0.008, "press_depth_m": 0.002})
        chosen = {**body, "contact": "auto", "force_error": "1jnd"}
        del chosen["field"]
        group, = levels.groups_of({"body": [chosen]}, decomposer, self.fail)
        self.assertTrue(all(level.changes["force_error"] is None for level in group.levels[1:]))

    def test_a_scene_keeps_its_line_ends(self):
        scene = self.folder / "returns.toml"
        scene.write_bytes(MESHES.replace("\n", "\r\n").encode())
        files = scene_files.SceneFiles(scene, self.out)
        self.assertEqual((files.inputs / "returns.toml").read_bytes().count(b"\r\n"), MESHES.count("\n"))
        text = files.fitted_text({("simulation", "substeps"): 2, ("grid", "voxel_ratio"): 2.0}, ["Fitted."])
        self.assertEqual(text.count("\n"), text.count("\r\n"))

    def test_a_recording_is_laid_back_into_the_devices_frame(self):
        recording = self.write("recording.csv", "# scene: skin\n# device: replay\ntime_s,x_m,y_m,z_m\n")
        self.assertEqual(self.files.laid_back(recording), "scale=0.5,offset_y_m=-0.05")
        recording = self.write("today.csv", "time_s,x_m,y_m,z_m,fx_N,rendered_fx_N,contacts\n")
        self.assertEqual(self.files.laid_back(recording), "scale=0.5,offset_y_m=-0.05")
        self.assertEqual(self.files.laid_back(self.write("other.csv", "t_s,x_m\n")), "")
        early = self.write("early.csv", "# stillgrid: 0.0.9\ntime_s,x_m,y_m,z_m,rendered_fx_N\n")
        self.assertEqual(self.files.laid_back(early), "scale=0.5,offset_y_m=-0.05")


class TomlEditTest(unittest.TestCase):
    TEXT = ('# head\na.b = 1 # dotted\n[t] # table\nlist = [ # of\n  1, "]", # two\n]\nname = "x # no comment"\n\n'
            '[[body]]\nname = \'one\'\nspheres = { file = "a.csv" }\n[body.springs]\nk = 1.5\n\n[[body]]\n'
            'name = """\nt"wo"""\nspheres={spacing_m=0.1,radius_m=0.2}\nsince = 1979-05-27 07:32:00\n')

    def check(self, changes, *pieces, renamed=()):
        """The pieces are new lines; every other line is an old one."""
        text = toml_edit.edited(self.TEXT, changes, renamed)
        with_returns = toml_edit.edited(self.TEXT.replace("\n", "\r\n"), changes, renamed)
        self.assertEqual(with_returns, text.replace("\n", "\r\n"))
        new = [line for line in text.splitlines() if line not in self.TEXT.splitlines()]
        self.assertEqual(new, list(pieces))

    def test_each_way_to_write_a_value_is_changed_in_place(self):
        self.check({("a", "b"): 2.5}, "a.b = 2.5 # dotted")
        self.check({("t", "name"): "y"}, 'name = "y"')
        self.check({("body", 0, "springs", "k"): 2.0}, "k = 2.0")
        self.check({("body", 1, "spheres", "spacing_m"): 0.3}, "spheres={spacing_m=0.3,radius_m=0.2}")
        self.check({("body", 1, "spheres", "file"): "b"}, 'spheres={ spacing_m=0.1,radius_m=0.2, file = "b" }')
        self.check({("body", 0, "spheres"): {"tolerance_m": 0.1}}, "spheres = { tolerance_m = 0.1 }")
        self.check({("t", "list"): [3]}, "list = [3]")

    def test_what_is_not_there_is_added_to_its_table(self):
        self.check({("body", 0, "stiffness_scale"): 2.0}, "stiffness_scale = 2.0")
        self.check({("body", 1, "stiffness_scale"): 3.0}, "stiffness_scale = 3.0")
        self.check({("grid", "voxel_ratio"): 2.0}, "[grid]", "voxel_ratio = 2.0")

    def test_what_goes_stays_as_a_comment(self):
        self.check({("t", "name"): None}, '# name = "x # no comment"')
        self.check({("t", "list"): None}, "# list = [ # of", '#   1, "]", # two', "# ]")
        self.check({("body", 1, "spheres", "spacing_m"): None}, "spheres={radius_m=0.2}")

    def test_a_key_is_renamed_where_it_stands(self):
        self.check({("t", "called"): "z"}, 'called = "z"', renamed=[(("t", "name"), "called")])

    def test_what_would_read_otherwise_is_refused(self):
        with self.assertRaises(toml_edit.Exotic):
            toml_edit.edited("a = { b.c = 1 }\n", {("a", "b", "d", "e"): 1})


if __name__ == "__main__":
    daemons.main()
