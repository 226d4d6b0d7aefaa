#!/usr/bin/python3
"""Scenes at their limits: what is refused before it takes memory, what ends a run early, and how soon a
signal is heeded: by processor time, for a shared machine stalls."""
import json
import os
import pathlib
import signal
import subprocess
import unittest

import daemons
from daemons import BAD_INPUT, BUILD, COULD_NOT_START

SHEET = """format = 2
[simulation]
{simulation}
[[material]]
name = "m"
contact_stiffness_N_per_m = 500.0
[[body]]
name = "cloth"
kind = "sheet"
nodes = [{side}, {side}]
size_m = [{size_m}, {size_m}]
mass_kg = 0.2
material = "m"
spring_stiffness_N_per_m = {{ structural = 100.0, shear = 50.0, bend = 10.0 }}
pinned = "corners"
"""
HEAP = """format = 2
[simulation]
integrator = "velocity_verlet"
sleeping = false
[[material]]
name = "m"
contact_stiffness_N_per_m = 2000.0
contact_damping_N_s_per_m = 1.0
friction = 0.3
""" + "".join(f"""[[body]]
name = "s{x} {y} {z}"
kind = "sphere"
material = "m"
radius_m = 0.005
mass_kg = 0.001
position_m = [{0.00995 * x}, {0.00995 * y}, {0.00995 * z}]
""" for x in range(14) for y in range(14) for z in range(14))
STACKS = """format = 2
[simulation]
rate_hz = 1000.0
integrator = "velocity_verlet"
[[material]]
name = "stiff"
contact_stiffness_N_per_m = 100000.0
contact_damping_N_s_per_m = 0.0
friction = 0.3
[[body]]
name = "floor"
kind = "plane"
normal = [0.0, 0.0, 1.0]
material = "stiff"
""" + "".join(f"""[[body]]
name = "box {column} {row}"
kind = "rigid_box"
size_m = [0.04, 0.04, 0.04]
position_m = [{0.05 * column}, 0.0, {0.02 + 0.04 * row}]
mass_kg = 0.1
material = "stiff"
""" for column in range(4) for row in range(4))
TRIES = 8
REFUSE_THREADS = BUILD / "tests" / "integration" / "rights" / "refuse_threads.so"


def sheet(side, simulation):
    return SHEET.format(side=side, size_m=0.01 * side, simulation=simulation)


class LimitsTest(daemons.SessionTest):
    def offline(self, scene, *arguments):
        return self.start(BUILD / "bin" / "sim_server", "--scene", scene, "--offline", *arguments)

    def spent_after_s(self, daemon, wait_s):
        """Processor time that a process takes after SIGTERM, once it has taken wait_s of it."""
        pid = daemon.process.pid

        def spent_s():
            fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        self.wait_until(lambda: spent_s() >= wait_s or not daemon.runs(), 60.0, "no work")
        self.assertTrue(daemon.runs(), f"ended by itself: {daemon.lines()}")
        before_s = spent_s()
        daemon.signal(signal.SIGTERM)
        _, status, usage = os.wait4(pid, 0)
        daemon.process.returncode = os.waitstatus_to_exitcode(status)
        return usage.ru_utime + usage.ru_stime - before_s

    def assert_heeded(self, start, wait_s):
        """start: of a process that would run for long. In one of four tries it may be between parts
        of its work that are not interrupted."""
        spent_s = sorted(self.spent_after_s(start(), wait_s) for _ in range(TRIES))
        self.assertLess(spent_s[TRIES * 3 // 4 - 1], 0.1, spent_s)

    def test_stacks_of_stiff_boxes_without_dampers_gain_no_energy(self):
        scene, report = self.write("stacks.toml", STACKS), self.folder / "report.json"
        ended = subprocess.run([BUILD / "bin" / "sim_server", "--scene", scene, "--offline", "--duration", "0.5",
                                "--report", report], capture_output=True, text=True)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertGreater(daemons.read_report(report)["energy"]["numerical_J"], -1e-5)

    def test_a_signal_ends_a_step_of_ten_thousand_substeps(self):
        scene = self.write("slow.toml", sheet(
            40, 'integrator = "velocity_verlet"\nsubsteps = 10000\nperiod_s = 1.0'))
        self.assert_heeded(lambda: self.offline(scene, "--duration", 1e6), 0.5)

    def test_a_signal_ends_a_step_within_its_factorisation(self):
        scene = self.write("large.toml", sheet(70, 'integrator = "implicit_euler"'))
        state = self.folder / "end.csv"
        self.assert_heeded(lambda: self.offline(scene, "--duration", 1e6, "--final-state", state),
                           0.7)
        self.assertGreater(len(state.read_text().splitlines()), 70 * 70)

    def test_a_signal_ends_a_load_and_leaves_nothing(self):
        body = '[[body]]\nname = "b{}"\nkind = "sphere"\nradius_m = 0.01\nmass_kg = 1\nmaterial = "m"\n'
        scene = self.write("many.toml", 'format = 2\n[[material]]\nname = "m"\n'
                           'contact_stiffness_N_per_m = 1\n' + "".join(map(body.format, range(200_000))))
        before = set(self.folder.iterdir())
        report = self.folder / "report.json"
        self.assert_heeded(lambda: self.sim_server(scene, "--report", report), 0.3)
        left = {file for file in self.folder.iterdir() if file.suffix != ".stderr"} - before
        self.assertEqual(left, set())

    def test_a_scene_that_does_not_fit_is_refused_at_its_line(self):
        scene = self.write("huge.toml", sheet(900, 'integrator = "implicit_euler"'))
        daemon = self.start("prlimit", f"--as={4 << 30}", BUILD / "bin" / "sim_server",
                            "--scene", scene, "--offline", "--duration", 1)
        self.assert_refused(daemon, BAD_INPUT, f"{scene}:7: body 'cloth': memory: value",
                            "expected at most", "this machine has left")

    def test_threads_share_a_heap_and_no_byte_depends_on_them(self):
        scene = self.write("heap.toml", HEAP)
        daemon = self.offline(scene, "--duration", 1e3, "--threads", 2)

        def that_worked():
            tasks = pathlib.Path(f"/proc/{daemon.process.pid}/task").glob("*/stat")
            spent = [int(file.read_text().rpartition(")")[2].split()[11]) for file in tasks]
            return sum(ticks > 0.3 * os.sysconf("SC_CLK_TCK") for ticks in spent)
        self.wait_until(lambda: that_worked() >= 2 or not daemon.runs(), 60.0, "one thread does all")
        self.assertTrue(daemon.runs(), f"ended by itself: {daemon.lines()}")
        daemon.signal(signal.SIGTERM)
        self.assertEqual(daemon.wait(), daemons.DONE)
        states = [self.folder / f"by_{threads}.csv" for threads in (1, 3)]
        for threads, state in zip((1, 3), states):
            run = self.offline(scene, "--duration", 0.05, "--threads", threads, "--final-state", state)
            self.assertEqual(run.wait(60.0), daemons.DONE, run.lines())
        self.assertEqual(*(state.read_bytes() for state in states))

    def test_threads_that_the_system_refuses_are_a_warning(self):
        scene, state = self.write("heap.toml", HEAP), self.folder / "end.csv"
        daemon = self.start("prlimit", f"--as={300 << 20}", BUILD / "bin" / "sim_server", "--scene", scene,
                            "--offline", "--duration", 0.02, "--threads", 200, "--final-state", state)
        self.assertEqual(daemon.wait(60.0), daemons.DONE, daemon.lines())
        self.assertIn("threads in place of 200: no more can be made", "".join(daemon.lines()))
        self.assertEqual(len(state.read_text().splitlines()), 1 + 14**3)

    @unittest.skipUnless(REFUSE_THREADS.exists(), "skipped: a build with sanitizers takes no library before theirs")
    def test_threads_that_another_program_takes_meanwhile_are_one_line(self):
        scene, sought = self.write("heap.toml", HEAP), 3
        for made in range(sought):
            daemon = self.start("env", f"LD_PRELOAD={REFUSE_THREADS}", f"STILLGRID_TEST_THREADS={sought + made}",
                                BUILD / "bin" / "sim_server", "--scene", scene, "--offline", "--duration", 0.02,
                                "--threads", sought + 1)
            self.assertEqual(daemon.wait(), COULD_NOT_START, daemon.lines())
            self.assertIn("sim_server: --threads: expected fewer: pthread_create has failed", daemon.lines()[-1])
            self.assertLessEqual(len(daemon.lines()), 2)  # one that they are more than there are processors

    def test_no_memory_left_is_one_line(self):
        scene = self.write("some.toml", "format = 2\nmaterial = [" + 200_000 * (
            '{ name = "m", contact_stiffness_N_per_m = 1 },\n') + "]")
        daemon = self.start("prlimit", f"--as={200 << 20}", BUILD / "bin" / "sim_server",
                            "--scene", scene, "--offline", "--duration", 1)
        self.assert_refused(daemon, COULD_NOT_START, "out of memory", timeout_s=60.0)

    def test_a_run_whose_state_is_lost_still_writes_report_and_state(self):
        scene = self.write("unstable.toml", sheet(
            12, 'integrator = "velocity_verlet"\nsubsteps = 2\nperiod_s = 0.05'))
        report, state = self.folder / "report.json", self.folder / "end.csv"
        daemon = self.offline(scene, "--duration", 1e3, "--report", report, "--final-state", state)
        self.assertEqual(daemon.wait(60.0), daemons.NOT_CONVERGED, daemon.lines())
        warning, line = daemon.lines()
        self.assertIn("simulation.substeps: value 2: may not be stable in a step of 0.05 s; ", warning)
        self.assertRegex(line, "the scene has gained [0-9.e+]+ J without a source")
        kept = json.loads(report.read_text())
        self.assertEqual("sim_server: " + kept["ended_by"], line)
        self.assertGreater(kept["steps"], 0)
        self.assertEqual(len(state.read_text().splitlines()), 1 + 12 * 12)

    def test_options_out_of_range_are_refused_each_with_a_line(self):
        scene = self.write("scene.toml", sheet(4, ""))
        bad = {"sim_server": (("--seed", "-1"), ("--seed", "0x10"), ("--cpu", "-1"),
                              ("--cpu", "1.5"), ("--rate", "0x40"), ("--duration", "nan")),
               "haptic_server": (("--cpu", "-1"), ("--rate", "9"), ("--max-force", "0x1")),
               "segment_inspect": (("--max-spheres", "-1"), ("--watch-s", "nan")),
               "scene_viewer": (("--port", "65536"), ("--port", "-1"), ("--frames-per-s", "0")),
               "sphere_decompose": (("--tolerance", "0"), ("--scale", "-1"))}
        given = {"sim_server": ["--scene", scene, "--session", self.session],
                 "haptic_server": ["--session", self.session, "--device", "phantom"],
                 "segment_inspect": ["--json"], "scene_viewer": ["--session", self.session],
                 "sphere_decompose": [scene, "--out", self.folder / "o.csv", "--tolerance", "1"]}
        for program, options in bad.items():
            if not (BUILD / "bin" / program).exists():
                self.fail(f"{program} is not built")
            for option, value in options:
                with self.subTest(program=program, option=option, value=value):
                    ended = subprocess.run([BUILD / "bin" / program, *given[program],
                                            f"{option}={value}"], text=True, timeout=20,
                                           capture_output=True, check=False)
                    self.assertEqual(ended.returncode, BAD_INPUT, ended.stderr)
                    self.assertEqual(len(ended.stderr.splitlines()), 1, ended.stderr)
                    self.assertIn(f"{program}: {option}: value '{value}': expected ", ended.stderr)


if __name__ == "__main__":
    unittest.main()
