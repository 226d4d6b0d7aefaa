#!/usr/bin/python3
"""sphere_decompose takes what bounds a solid, says in one line why not, and leaves nothing half done."""
import itertools
import json
import math
import signal
import subprocess
import time

import daemons
from daemons import BAD_INPUT, DONE

PROGRAM = daemons.BUILD / "bin" / "sphere_decompose"
MESHES = daemons.DATA / "meshes"
HEADER = "x_m,y_m,z_m,radius_m"
# A box of 4 x 2 x 1, its twelve triangles counter-clockwise seen from outside.
BOX = [(1, 3, 4), (1, 4, 2), (5, 6, 8), (5, 8, 7), (1, 2, 6), (1, 6, 5), (3, 7, 8), (3, 8, 4),
       (1, 5, 7), (1, 7, 3), (2, 4, 8), (2, 8, 6)]
BOX_SIZE = (4.0, 2.0, 1.0)


def box_text(faces):
    corners = [(4 * (i & 1), 2 * (i >> 1 & 1), i >> 2) for i in range(8)]
    return "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + \
        "".join("f %d %d %d\n" % face for face in faces)


def torus_text(around, across):
    """Fine enough that it takes a while."""
    lines = []
    for i, j in itertools.product(range(around), range(across)):
        u, v = 2 * math.pi * i / around, 2 * math.pi * j / across
        out = 1 + 0.3 * math.cos(v)
        lines.append(f"v {out * math.cos(u)} {out * math.sin(u)} {0.3 * math.sin(v)}")
    for i, j in itertools.product(range(around), range(across)):
        a, b = 1 + across * i, 1 + across * ((i + 1) % around)
        next_j = (j + 1) % across
        lines += [f"f {a + j} {b + j} {b + next_j}", f"f {a + j} {b + next_j} {a + next_j}"]
    return "\n".join(lines) + "\n"


def read_spheres(file):
    """Rows of four numbers; the file must be whole."""
    text = file.read_text()
    lines = text.splitlines()
    assert text.endswith("\n") and lines[0] == HEADER, lines[:1]
    return [tuple(map(float, line.split(","))) for line in lines[1:]]


def outside_m(spheres, point):
    return min(math.dist(sphere[:3], point) - sphere[3] for sphere in spheres)


class SphereDecomposeTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        self.box = self.write("box.obj", box_text(BOX))
        self.out, self.report = self.folder / "out.csv", self.folder / "report.json"

    def run_program(self, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                              timeout=100 * daemons.PATIENCE, check=False)

    def decompose(self, mesh, *arguments):
        result = self.run_program(mesh, "--out", self.out, *arguments)
        self.assertEqual((result.returncode, result.stderr), (DONE, ""))
        return result.stdout.splitlines()

    def assert_refused(self, mesh, *arguments, words, out=None):
        before = sorted(self.folder.iterdir())
        result = self.run_program(mesh, "--out", out or self.out, *arguments)
        self.assertEqual((result.returncode, result.stdout), (BAD_INPUT, ""), result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertTrue(result.stderr.startswith("sphere_decompose: "), result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertEqual(sorted(self.folder.iterdir()), before, "files left behind")


class OutputTest(SphereDecomposeTest):
    def test_the_spheres_of_a_box_are_written_whole_and_cover_it(self):
        lines = self.decompose(self.box, "--tolerance", 0.2, "--scale", 0.5)
        spheres = read_spheres(self.out)
        self.assertEqual(len(lines), 1)
        self.assertTrue(lines[0].startswith(f"{self.out}: {len(spheres)} spheres"), lines)
        for corner in itertools.product(*((0.0, 0.5 * size) for size in BOX_SIZE)):
            self.assertLess(abs(outside_m(spheres, corner)), 0.2)
        for sphere in spheres:
            self.assertTrue(all(0.0 < x < 0.5 * size for x, size in zip(sphere, BOX_SIZE)), sphere)

    def test_the_same_mesh_gives_the_same_file(self):
        self.decompose(self.box, "--tolerance", 0.3)
        first = self.out.read_bytes()
        self.decompose(self.box, "--tolerance", 0.3)
        self.assertEqual(self.out.read_bytes(), first)

    def test_a_tolerance_out_of_reach_leaves_the_nearest_spheres_a_warning_and_status_4(self):
        # The upper corners turned by half a turn: the box cuts itself.
        lines = box_text(BOX).splitlines()
        lines[4:8] = lines[7:3:-1]
        twisted = self.write("twisted.obj", "\n".join(lines) + "\n")
        result = self.run_program(twisted, "--out", self.out, "--tolerance", 0.4, "--report", self.report)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn("the tolerance of 0.4 m was not reached", result.stderr)
        self.assertTrue(all(sphere[3] > 0.0 for sphere in read_spheres(self.out)))
        self.assertGreater(json.loads(self.report.read_text())["hausdorff_m"], 0.4)

    def test_a_scene_takes_the_file(self):
        self.decompose(self.box, "--tolerance", 0.2)
        scene = self.write("scene.toml", f"""format = 2
material = [{{ name = "m", contact_stiffness_N_per_m = 100.0 }}]
[[body]]
name = "b"
kind = "mesh"
file = "box.obj"
mass_kg = 1.0
spheres = {{ file = "out.csv" }}
material = "m"
""")
        report = self.folder / "sim.json"
        sim = self.start(daemons.BUILD / "bin" / "sim_server", "--scene", scene, "--offline",
                         "--duration", 0.05, "--report", report)
        self.assertEqual(sim.wait(), DONE, sim.lines())
        self.assertEqual(daemons.read_report(report)["spheres"], len(read_spheres(self.out)))

    def test_the_report_tells_mesh_and_distances(self):
        self.decompose(self.box, "--tolerance", 0.2, "--report", self.report)
        report = daemons.read_report(self.report)
        mesh = report["mesh"]
        self.assertEqual(report["tolerance_m"], 0.2)
        self.assertGreater(report["time_s"], 0.0)
        self.assertEqual((mesh["file"], mesh["scale"], mesh["triangles"]), (str(self.box), 1.0, 12))
        self.assertAlmostEqual(mesh["volume_m3"], 8.0, places=6)
        self.assertAlmostEqual(mesh["area_m2"], 28.0, places=6)
        self.assertAlmostEqual(mesh["diagonal_m"], math.sqrt(21), places=6)
        self.assertEqual(set(mesh["repair"].values()), {0})
        self.assertEqual((report["file"], report["balls"]), (str(self.out), len(read_spheres(self.out))))
        self.assertEqual(report["hausdorff_m"], max(report["mesh_to_union_m"], report["union_to_mesh_m"]))
        self.assertLessEqual(report["hausdorff_m"], 0.2)

    def test_even_spheres_are_spaced_as_asked_and_their_error_is_measured(self):
        for option, key in (("--surface-spacing", "surface_spacing_m"),
                            ("--volume-spacing", "volume_spacing_m")):
            self.decompose(self.box, option, 0.25, "--report", self.report)
            report, spheres = daemons.read_report(self.report), read_spheres(self.out)
            self.assertEqual(report[key], 0.25)
            self.assertNotIn("tolerance_m", report)
            self.assertEqual(report["balls"], len(spheres))
            corner_m = outside_m(spheres, (4.0, 2.0, 1.0))
            self.assertTrue(corner_m - 1e-9 <= report["mesh_to_union_m"] < 0.25, corner_m)
        self.assertEqual(len(spheres), 16 * 8 * 4)


class RefusalTest(SphereDecomposeTest):
    def test_an_open_mesh_is_refused_with_the_number_of_open_edges(self):
        mesh = self.write("open.obj", box_text(BOX[:-2]))
        self.assert_refused(mesh, "--tolerance", 0.2, words=[str(mesh), "not closed: 4 boundary edges"])

    def test_a_mesh_that_is_no_mesh_is_refused(self):
        self.assert_refused(self.folder / "none.obj", "--tolerance", 0.2, words=["none.obj"])
        for name, text in (("empty.obj", ""), ("words.stl", "solid of words\n"),
                           ("nan.obj", box_text(BOX).replace("v 4 0 0", "v nan 0 0"))):
            self.assert_refused(self.write(name, text), "--tolerance", 0.2, words=[name])

    def test_a_bad_option_is_named_with_its_value(self):
        for value in ("0", "-1", "nan", "inf", "wide"):
            self.assert_refused(self.box, "--tolerance", value, words=["--tolerance", value])
            self.assert_refused(self.box, "--surface-spacing", value,
                                words=["--surface-spacing", value])
        self.assert_refused(self.box, "--tolerance", 1e-5, words=["1/5000 of the box"])
        self.assert_refused(self.box, "--tolerance", 0.2, "--scale", 0, words=["--scale"])

    def test_exactly_one_way_to_spheres_is_taken(self):
        self.assert_refused(self.box, words=["--tolerance", "--surface-spacing"])
        self.assert_refused(self.box, "--tolerance", 0.2, "--volume-spacing", 0.2,
                            words=["--tolerance", "2 were given"])

    def test_too_many_even_spheres_are_refused_with_their_number(self):
        for option in ("--surface-spacing", "--volume-spacing"):
            self.assert_refused(self.box, option, 0.001, words=["balls: expected at most 200000"])

    def test_a_place_that_cannot_be_written_is_refused_before_the_work(self):
        began_s = time.monotonic()
        mesh = self.write("torus.obj", torus_text(120, 40))
        self.assert_refused(mesh, "--tolerance", 0.005, out=self.folder / "none" / "out.csv",
                            words=["out.csv: cannot be written"])
        self.assert_refused(mesh, "--tolerance", 0.005, out=self.folder,
                            words=["cannot be written"])
        self.assert_refused(mesh, "--tolerance", 0.005, "--report", self.folder,
                            words=["cannot be written"])
        self.assertLess(time.monotonic() - began_s, 5.0)


class InterruptTest(SphereDecomposeTest):
    def test_an_interrupted_run_leaves_what_stood_there_and_nothing_else(self):
        mesh = self.write("torus.obj", torus_text(120, 40))
        self.out.write_text("stood there")
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            before = {file for file in self.folder.iterdir() if file.suffix != ".stderr"}
            daemon = self.start(PROGRAM, mesh, "--tolerance", 0.004, "--out", self.out, "--report",
                                self.report)
            time.sleep(0.6)
            self.assertTrue(daemon.runs(), "the mesh is too easy to be interrupted")
            daemon.signal(number)
            self.assertEqual(daemon.wait(5.0), -number, daemon.lines())
            after = {file for file in self.folder.iterdir() if file.suffix != ".stderr"}
            self.assertEqual(after, before)
            self.assertEqual(self.out.read_text(), "stood there")


class DataTest(SphereDecomposeTest):
    """Meshes of others; without them it is skipped."""

    def setUp(self):
        super().setUp()
        if not MESHES.is_dir():
            self.skipTest(f"skipped: no meshes in {MESHES}")

    def test_the_teapot_is_open_and_refused(self):
        self.assert_refused(MESHES / "npm_teapot.off", "--tolerance", 0.5,
                            words=["not closed: 64 boundary edges"])

    def test_the_second_torus_has_every_face_twice_and_is_repaired(self):
        self.decompose(MESHES / "sofa_torus2_scale3_for_collision.obj", "--tolerance", 1.0,
                       "--report", self.report)
        mesh = daemons.read_report(self.report)["mesh"]
        self.assertEqual((mesh["triangles"], mesh["closed"]["triangles"]), (800, 400))
        self.assertEqual(mesh["repair"]["doubled_faces"], 400)

    def test_the_bunny_is_a_handful_of_spheres(self):
        self.decompose(MESHES / "npm_bunny.off", "--scale", 0.01, "--tolerance", 0.02, "--report",
                       self.report)
        report = daemons.read_report(self.report)
        self.assertLessEqual(report["hausdorff_m"], 0.02)
        self.assertTrue(1 < report["balls"] < 20, report["balls"])


if __name__ == "__main__":
    daemons.main()
