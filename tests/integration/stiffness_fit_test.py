#!/usr/bin/python3
"""scripts/stiffness_fit finds what is known, predicts what it has not seen, and says what it cannot do."""
import concurrent.futures
import csv
import json
import os
import signal
import subprocess
import sys
import time
import tomllib
import unittest

import numpy

import daemons
import palpation
import recorded_forces

for folder in ("fit", "replay", "stiffness"):
    sys.path.insert(1, str(daemons.ROOT / "scripts" / folder))
import fit_scene  # after the paths they need
import law

FITTED, MISSED, COULD_NOT_RUN, STOPPED = 0, 1, 2, 130
STIFFNESS_FIT = daemons.ROOT / "scripts" / "stiffness_fit"
FIELD = 'contact = "field"\nfield = { cell_m = 0.001 }  # a millimetre'
SEEDS = range(1, 9)


class LawTest(unittest.TestCase):
    def test_a_least_stiffness_is_kept_and_nothing_else_is_given_up(self):
        for seed in SEEDS:
            random = numpy.random.default_rng(seed)
            count = int(random.integers(2, 40))
            root = random.normal(size=(count + 5, count))
            matrix, vector, least = root.T @ root, random.normal(size=count), random.uniform(-0.5, 0.2)
            x = law.at_least(matrix, vector, least)
            slope = matrix @ x - vector
            self.assertGreaterEqual(x.min(), least)
            self.assertLess(numpy.abs(slope[x > least]).max(initial=0.0), 1e-9)  # where it is free it is the best
            self.assertGreater(slope[x == least].min(initial=0.0), -1e-9)  # elsewhere it would be still less

    def test_where_a_body_lies_its_places_are_found(self):
        for seed in SEEDS:
            random = numpy.random.default_rng(seed)
            turn = random.normal(size=4)
            turn /= numpy.linalg.norm(turn)
            points_m, at_m = random.normal(size=(20, 3)), random.normal(size=3)
            scene = fit_scene.FitScene.__new__(fit_scene.FitScene)
            scene.body = {"orientation_xyzw": list(turn), "position_m": list(at_m)}
            there_m = numpy.array([palpation.turned(point, turn) for point in points_m]) + at_m
            numpy.testing.assert_allclose(scene.to_mesh(there_m), points_m, atol=1e-12)


class StiffnessFitTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        without = self.folder / "without"
        without.mkdir()
        (without / "matplotlib.py").write_text("raise ImportError('no matplotlib')\n")
        self.without = str(without)
        self.scene = self.write("kidney.toml", palpation.scene_text(palpation.KIDNEY, FIELD))

    def command(self, *arguments, program=STIFFNESS_FIT):
        of_build = ["--build", daemons.BUILD] if program == STIFFNESS_FIT else []
        return ["/usr/bin/python3", *map(str, (program, *arguments, *of_build))]

    def fit(self, *arguments, draws=False, **options):
        """draws: or else there is no matplotlib, which saves a second."""
        environment = os.environ if draws else {**os.environ, "PYTHONPATH": self.without}
        return subprocess.run(self.command(*arguments, **options), cwd=self.folder, capture_output=True, text=True,
                              timeout=100 * daemons.PATIENCE, check=False, env=environment)

    def fitted(self, *arguments, out, status=FITTED, **options):
        run = self.fit(*arguments, "--out", out, **options)
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        return json.loads((self.folder / out / "stiffness_fit.json").read_text()), run

    def record(self, truth, run, seed):
        return palpation.write(palpation.record(truth, run, seed), self.folder / f"run{run}_{seed}.csv")

    def map_of(self, out):
        with open(self.folder / out / "stiffness_map.csv") as stream:
            rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
        return numpy.array([[float(value) for value in row.values()] for row in rows])

    def palpated(self, seed):
        truth = palpation.Truth(palpation.KIDNEY, seed)
        first, second = (self.record(truth, run, seed) for run in (0, 1))
        return truth, self.fitted(self.scene, first, "--check", second, "--goal", 0.9, out=f"fit{seed}")

    def test_a_known_map_is_found_and_an_unseen_run_is_predicted(self):
        with concurrent.futures.ThreadPoolExecutor(2) as threads:
            found = list(threads.map(self.palpated, SEEDS))
        for seed, (truth, (answer, _)) in zip(SEEDS, found):
            with self.subTest(seed=seed):
                R2 = {name: value["along_normal"] for name, value in answer["recordings"][1]["R2"].items()}
                self.assertGreater(R2["field with map"], 0.9)
                self.assertLess(R2["field, one stiffness"], 0.7)  # the truth has a hard place
                self.assertGreater(R2["field with map"], R2["linear map"] - 0.015)
                self.assertAlmostEqual(answer["offset_m"], truth.offset_m, delta=2e-4)
                places = self.map_of(f"fit{seed}")
                self.assertEqual(len(places), answer["places"])
                self.assert_is_map_of(truth, places, answer["own_N_per_m"])

    def assert_is_map_of(self, truth, places, own_N_per_m):
        """Over the places' middle, where what was felt is on all sides."""
        on_bench_m = numpy.array([palpation.turned(place, truth.organ.turn_xyzw) for place in places[:, :3]])
        near = (numpy.abs(on_bench_m - truth.middle_m)[:, :2] < 0.8 * numpy.array(truth.organ.patch_m)).all(axis=1)
        self.assertGreater(near.sum(), 5)
        known = numpy.append(places[:, 3], own_N_per_m)
        fitted = law.weights(places[near, :3], places[:, :3]) @ known
        error = fitted / truth.stiffness_N_per_m(on_bench_m[near]) - 1.0
        self.assertLess(numpy.sqrt((error ** 2).mean()), 0.15)

    def test_where_the_stiffness_is_even_no_map_is_made(self):
        for seed in (11, 12):
            truth = palpation.Truth(palpation.KIDNEY, seed, soft_N_per_m=740.0, hard_N_per_m=0.0, slow_share=0.0)
            answer, run = self.fitted(self.scene, self.record(truth, 0, seed), out=f"even{seed}")
            self.assertEqual(answer["places"], 0)
            self.assertAlmostEqual(answer["own_N_per_m"], 740.0, delta=75.0)
            self.assertAlmostEqual(answer["offset_m"], truth.offset_m, delta=2e-4)
            self.assertIn("one for the whole body", run.stdout)
            files = sorted(file.name for file in (self.folder / f"even{seed}").iterdir())
            self.assertEqual(files, ["forces.csv", "kidney_fitted.toml", "stiffness_fit.json"])

    def test_a_scene_keeps_its_text_but_for_what_was_fitted(self):
        truth = palpation.Truth(palpation.KIDNEY, 3)
        first = self.record(truth, 0, 3)
        answer, run = self.fitted(self.scene, first, "--goal", 0.999, "--spacing", 0.006, out="sub", draws=True,
                                  status=MISSED)
        self.assertRegex(run.stdout.splitlines()[-1], r"^MISSED: R2 0\.9\d+ along the normal on .*: expected 0\.999$")
        text = (self.folder / "sub" / "kidney_fitted.toml").read_text()
        expected = tomllib.loads(self.scene.read_text())
        body = expected["body"][0]
        body["file"] = os.path.relpath(body["file"], self.folder / "sub")
        body["stiffness_scale"] = float(f"{answer['own_N_per_m'] / 400.0:.6g}")
        body["field"] |= {"offset_m": answer["offset_m"], "stiffness_map": "stiffness_map.csv"}
        got = tomllib.loads(text)
        self.assertAlmostEqual(got["body"][0].pop("stiffness_scale"), body.pop("stiffness_scale"), places=4)
        self.assertEqual(got, expected)
        self.assertIn("  # a millimetre\n", text)
        self.assertEqual((self.folder / "sub" / "stiffness_fit.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        # Fitted anew from there, by an installed program, it is the same.
        prefix = self.folder / "prefix"
        subprocess.run(["cmake", "--install", daemons.BUILD, "--prefix", prefix, "--component", "stiffness_fit"],
                       check=True, stdout=subprocess.DEVNULL)
        (prefix / "lib").symlink_to(daemons.BUILD / "lib")
        for program in ("sim_server", "haptic_server"):
            (prefix / "bin" / program).symlink_to(daemons.BUILD / "bin" / program)
        again, _ = self.fitted(self.folder / "sub" / "kidney_fitted.toml", first, "--spacing", 0.006, out="again",
                               program=prefix / "bin" / "stiffness_fit")
        self.assertEqual((again["own_N_per_m"], again["recordings"][0]["R2"]),
                         (answer["own_N_per_m"], answer["recordings"][0]["R2"]))
        numpy.testing.assert_array_equal(self.map_of("again"), self.map_of("sub"))

    def test_a_springs_second_half_is_predicted_from_its_first(self):
        if not recorded_forces.SPRING.exists():
            self.skipTest(f"skipped: {recorded_forces.SPRING} is absent")
        scene, halves = recorded_forces.spring_halves(self.folder)
        answer, _ = self.fitted(scene, halves[0], "--check", halves[1], *recorded_forces.SPRING_FIT, "--goal", 0.9,
                                out="spring")
        self.assertAlmostEqual(answer["own_N_per_m"], 606.0, delta=6.0)  # docs/replay.md

    def test_what_cannot_be_fitted_is_refused_with_a_line_and_nothing_is_written(self):
        ramp = [(0.01 * i, -0.0074, 0.0098, 0.028 - 4e-5 * i) for i in range(200)]

        def rows(force_N, header="time_s,x_m,y_m,z_m,fx_N,fy_N,fz_N"):
            return header + "\n" + "".join(f"{t:g},{x:g},{y:g},{z:g},0,0,{force_N(z)}\n" for t, x, y, z in ramp)

        pushes = self.write("pushes.csv", rows(lambda z: f"{max(0.0, 500 * (0.03 - z)):.4g}"))
        pulls = self.write("pulls.csv", rows(lambda z: f"{-max(0.0, 500 * (0.03 - z)):.4g}"))
        bad = self.write("bad.csv", pushes.read_text().replace("\n0.5,-0.0074,", "\n0.5,-0.0074x,"))
        bad_force = self.write("bad_force.csv", rows(lambda z: "nan" if z < 0.025 else "0"))
        short = self.write("short.csv", "".join(pushes.read_text().splitlines(True)[:50]))
        without = self.write("without.csv", rows(lambda z: "1", "time_s,x_m,y_m,z_m,E,D,F"))
        text = self.scene.read_text()

        def scene(name, old, new):
            self.assertIn(old, text)
            return self.write(f"{name}.toml", text.replace(old, new))

        still = 'motion = "static"'
        for arguments, words in (
                ((self.scene, self.folder / "none.csv"), "none.csv: cannot be read: No such file"),
                ((self.folder / "none.toml", pushes), "none.toml: "),
                ((self.scene, bad_force), r"bad_force\.csv:78: column fz_N: value 'nan': expected a finite number"),
                ((self.scene, bad), r"bad\.csv:52: column x_m: value '-0\.0074x': expected a finite number"),
                ((self.scene, without), r"without\.csv:1: column fx_N: missing"),
                ((self.scene, without, "--force", "fz_N:G"),
                 r"without\.csv:1: column G: missing: expected it for fz_N"),
                ((self.scene, short), r"short\.csv: 49 rows: expected 100 at least"),
                ((self.scene, pushes, "--check", short), r"short\.csv: 49 rows"),
                ((self.scene, pushes, "--replay", "offset_x_m=1"),
                 r"pushes\.csv: 0 rows within 2 mm of body 'organ': expected 100 at least"),
                ((self.scene, pulls), r"pulls\.csv: the measured force pulls the tool in"),
                ((self.scene, pushes, "--force", "fz_N=F"), "--force: value 'fz_N=F': expected fx_N, fy_N or fz_N"),
                ((self.scene, pushes, "--force", "fz_N:F*x"), r"--force: value 'fz_N:F\*x': expected"),
                ((self.scene, pushes, "--goal", "90"), "--goal: value '90': expected a number up to 1"),
                ((self.scene, pushes, "--body", "liver"), "--body: value 'liver': expected one of organ"),
                ((self.scene, pushes, "--one", "--spacing", "0.01"), "--spacing: value 0.01: expected no such option"),
                ((self.scene, pushes, "--out", self.scene), "kidney.toml: expected a folder that can be written"),
                ((scene("spheres", FIELD, "spheres = { tolerance_m = 0.002 }"), pushes),
                 r"spheres\.toml: body: value 0 bodies with contact = \"field\": expected one"),
                ((scene("moves", still, 'motion = "rigid"'), pushes),
                 r"moves\.toml: body 'organ': motion: value 'rigid': expected \"static\""),
                ((scene("tool", "radius_m = 0.005", "spheres = [{ radius_m = 1.0 }, { radius_m = 2.0 }]"), pushes),
                 r"tool\.toml: tool\.spheres: value 2 spheres: expected one"),
                ((scene("turned", "[tool]", "[device]\norientation_xyzw = [1.0, 0.0, 0.0, 0.0]\n[tool]"), pushes),
                 r"turned\.toml: device\.orientation_xyzw: value \[1\.0, 0\.0, 0\.0, 0\.0\]: expected a device"),
                ((scene("toml", "[tool]", "[tool"), pushes), r"toml\.toml: "),
                ((scene("mesh", "organ.obj", "none.obj"), pushes), r"body\.file: value '.*: expected .*none\.obj: no such file")):
            with self.subTest(words):
                run = self.fit(*arguments, *(() if "--out" in arguments else ("--out", "refused")))
                self.assertEqual(run.returncode, COULD_NOT_RUN, run.stdout + run.stderr)
                self.assertRegex(run.stderr, r"\Astiffness_fit: .*\n\Z")
                self.assertRegex(run.stderr, words)
                self.assertEqual(run.stdout, "")
                self.assertFalse((self.folder / "refused").exists())

    def test_a_fit_that_is_stopped_leaves_nothing(self):
        truth = palpation.Truth(palpation.KIDNEY, 5)
        first = self.record(truth, 0, 5)
        scratch = self.folder / "scratch"
        scratch.mkdir()
        with subprocess.Popen(self.command(self.scene, first, "--out", self.folder / "stopped"), cwd=self.folder,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              env={**os.environ, "TMPDIR": str(scratch)}) as process:
            self.wait_until(lambda: any(scratch.glob("*/sim_server")), 20, "the servers")
            time.sleep(0.1)
            process.send_signal(signal.SIGINT)
            said = process.communicate(timeout=20 * daemons.PATIENCE)
        self.assertEqual((process.returncode, *said), (STOPPED, "", "stiffness_fit: stopped\n"))
        self.assertFalse((self.folder / "stopped").exists())
        self.assertEqual(list(scratch.iterdir()), [])
        self.assertEqual(list(daemons.SHM.glob(f"replay-check-{process.pid}*")), [])


if __name__ == "__main__":
    daemons.main()
