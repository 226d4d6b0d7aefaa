#!/usr/bin/python3
"""sim_server --check: what a start would say of a scene, without a start."""
import pathlib
import re
import subprocess
import tomllib
import unittest

import daemons
from daemons import BAD_INPUT, BUILD, DONE

SCENES = pathlib.Path(__file__).resolve().parents[2] / "sim_server/scene/scenes"
SCENE = """format = 2
[simulation]
{simulation}
[[material]]
name = "m"
contact_stiffness_N_per_m = 500.0
[[body]]
name = "floor"
kind = "plane"
normal = [0.0, 0.0, 1.0]
material = "m"
[[body]]
name = "thread"
kind = "thread"
nodes = {nodes}
from_m = [0.0, 0.0, {height_m}]
to_m = [0.05, 0.0, {height_m}]
{mass} = 0.01
spring_stiffness_N_per_m = {{ structural = 50.0 }}
spheres = {{ radius_m = 0.002 }}
pinned = "start"
material = "m"
"""


class SceneCheckTest(daemons.SessionTest):
    def run_program(self, scene, *arguments):
        command = [BUILD / "bin" / "sim_server", "--scene", scene, *arguments]
        return subprocess.run([str(each) for each in command], capture_output=True, text=True,
                              timeout=60 * daemons.PATIENCE)

    def scene(self, simulation="", nodes=6, height_m=0.1, mass="mass_kg"):
        return self.write("scene.toml", SCENE.format(simulation=simulation, nodes=nodes, height_m=height_m,
                                                     mass=mass))

    def test_every_scene_that_ships_is_checked_and_its_bodies_and_hands_are_told(self):
        scenes = sorted(SCENES.glob("*.toml"))
        self.assertGreater(len(scenes), 8)
        for file in scenes:
            document = tomllib.loads(file.read_text())
            motions = [body.get("motion", "static" if body["kind"] == "plane" else "free")
                       for body in document["body"]]
            result = self.run_program(file, "--check")
            self.assertEqual(result.returncode, DONE, result.stderr)
            counts = re.match(r"(\w+): (\d+) bod(?:y|ies): (\d+) free, (\d+) prescribed, (\d+) static\n",
                              result.stdout)
            self.assertEqual(counts.group(1), file.stem)
            self.assertEqual([int(each) for each in counts.groups()[1:]],
                             [len(motions)] + [motions.count(each) for each in ("free", "prescribed", "static")])
            hand = document.get("hand")
            for name in [each["name"] for each in hand] if isinstance(hand, list) else []:
                self.assertIn(f"hand '{name}': tool of ", result.stdout)

    def test_nodes_rate_and_method_are_those_of_a_run(self):
        for nodes, rate_hz, method in ((5, 40, "cvode_bdf"), (13, 125, "implicit_euler")):
            scene = self.scene(f'rate_hz = {rate_hz}.0\nintegrator = "{method}"', nodes=nodes)
            end, report = self.folder / "end.csv", self.folder / "report.json"
            run = self.run_program(scene, "--offline", "--duration", "0.1", "--final-state", end, "--report", report)
            self.assertEqual(run.returncode, DONE, run.stderr)
            simulated = daemons.read_report(report)
            checked = self.run_program(scene, "--check").stdout
            self.assertIn(f"; {len(end.read_text().splitlines()) - 1} nodes, ", checked)
            # An explicit step's substeps follow.
            self.assertRegex(checked, rf"\n{simulated['rate_hz']:g} Hz, {simulated['solver']['name']}(, 8 substeps)?\n")
            self.assertIn("\n77 Hz, ", self.run_program(scene, "--check", "--rate", "77").stdout)

    def test_what_is_left_to_choose_is_chosen(self):
        checked = self.run_program(self.scene('integrator = "auto"'), "--check")
        self.assertEqual(checked.returncode, DONE, checked.stderr)
        self.assertRegex(checked.stdout, r"\n100 Hz, .* \(chosen\)\n")

    def test_it_warns_as_a_start_would(self):
        scene = self.scene(height_m=-0.4)
        run = self.run_program(scene, "--offline", "--duration", "0.01")
        checked = self.run_program(scene, "--check")
        self.assertEqual(checked.returncode, DONE)
        self.assertIn("body 'thread'", checked.stderr)
        self.assertIn(checked.stderr.strip(), run.stderr)

    def test_no_output_is_written_over_the_scene_or_twice(self):
        scene, end = self.scene(), self.folder / "end"
        text = scene.read_text()
        for outputs in (("--report", scene), ("--report", end, "--final-state", end)):
            run = self.run_program(scene, "--offline", "--duration", "0.1", *outputs)
            self.assertEqual(run.returncode, BAD_INPUT)
            self.assertRegex(run.stderr, r"^sim_server: [^\n]*: expected a file of its own: [^\n]*\n$")
        self.assertEqual(scene.read_text(), text)
        nowhere = self.run_program(scene, "--offline", "--duration", "0.1", "--report", "/dev/null",
                                   "--final-state", "/dev/null")
        self.assertEqual(nowhere.returncode, DONE, nowhere.stderr)

    def test_a_full_disk_is_a_line_and_no_success(self):
        with open("/dev/full", "w") as full:
            checked = subprocess.run([str(BUILD / "bin" / "sim_server"), "--scene", str(self.scene()), "--check"],
                                     stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(checked.returncode, daemons.COULD_NOT_START)
        self.assertIn("sim_server: standard output could not be written to its end\n", checked.stderr)

    def test_a_scene_that_no_start_would_take_is_refused_in_one_line(self):
        text = SCENE.format(simulation="", nodes=6, height_m=0.1, mass="mass_kg")
        hand = text[:text.index("[[material]]")].count("\n") + 1
        self.write("still.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n")  # no path has one row
        handless, folder, still = (
            self.write(f"{name}.toml", text.replace("[[material]]", f'[hand]\nfile = "{file}"\n[[material]]'))
            for name, file in (("handless", "none.csv"), ("folder", "."), ("still", "still.csv")))
        misspelt = r"scene\.toml:18:1: body\.mass: value 0\.01: unknown key `mass`: did you mean `mass_kg`\? "
        for scene, words in ((self.scene(mass="mass"), misspelt + r"\(body 'thread'\)$"),
                             (self.folder / "none.toml", r"none\.toml: cannot be read: No such file or directory$"),
                             (self.folder, r": cannot be read: expected a regular file$"),
                             (handless, rf"handless\.toml:{hand}: hand\.file: [^\n]*/none\.csv: cannot be read: No such file"),
                             (folder, rf"folder\.toml:{hand}: hand\.file: [^\n]*: expected a regular file$"),
                             (still, rf"still\.toml:{hand}: hand\.file: [^\n]*/still\.csv: one row: expected two at least$")):
            checked = self.run_program(scene, "--check")
            self.assertEqual((checked.returncode, checked.stdout), (BAD_INPUT, ""))
            self.assertRegex(checked.stderr, "^sim_server: [^\n]*" + words)
            self.assertEqual(checked.stderr.count("\n"), 1)

    def test_options_of_a_run_are_refused_beside_it(self):
        scene = self.scene()
        for arguments in (("--session", "s"), ("--duration", "1"), ("--lockstep",), ("--offline",), ("--explain",),
                          ("--surfaces", self.folder / "s.json"), ("--report", self.folder / "r.json")):
            self.assertEqual(self.run_program(scene, "--check", *arguments).returncode, BAD_INPUT, arguments)
        self.assertEqual(list(self.folder.glob("*.json")), [])


if __name__ == "__main__":
    daemons.main()
