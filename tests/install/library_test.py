#!/usr/bin/python3
"""libstillgrid as it is installed: what it exports, and programs and engines built against it are felt."""
import os
import pathlib
import re
import signal
import subprocess
import sys
import time
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "integration"))
import daemons  # after the path it needs

MUJOCO = pathlib.Path("/usr/include/mujoco/mujoco.h")
BULLET = pathlib.Path("/usr/include/bullet/btBulletDynamicsCommon.h")
FADE_S = 0.1


class LibraryTest(daemons.SessionTest):
    def setUp(self):
        super().setUp()
        installed = self.folder / "first place"
        self.run_quietly("cmake", "--install", daemons.BUILD, "--prefix", installed)
        self.prefix = installed.rename(self.folder / "prefix")  # it may be moved

    def run_quietly(self, *command, **options):
        result = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, **options)
        self.assertEqual(result.returncode, 0, result.stdout)
        return result.stdout.strip()

    def example(self, name):
        return self.prefix / "share" / "stillgrid" / "examples" / name

    def build(self, name):
        build = self.folder / f"build-{name}"
        self.run_quietly("cmake", "-S", self.example(name), "-B", build, "-G", "Ninja",
                         f"-DCMAKE_PREFIX_PATH={self.prefix}", "-DCMAKE_BUILD_TYPE=Release",
                         "-DCMAKE_COMPILE_WARNING_AS_ERROR=ON")
        self.run_quietly("cmake", "--build", build)
        return build

    def engine(self, *command):
        """A publisher of this session, by whoever wrote it."""
        return self.start(*command)

    def feel(self, publisher, device, duration_s, *arguments):
        """The recording of a run in virtual time, to its end."""
        recording = self.folder / f"recording-{len(self.daemons)}.csv"
        haptic_server = self.haptic_server(device, "--lockstep", "--duration", duration_s, "--record",
                                           recording, *arguments)
        self.assertEqual(haptic_server.wait(60.0), daemons.DONE, haptic_server.lines())
        self.assertEqual(publisher.wait(), daemons.DONE, publisher.lines())
        return daemons.read_recording(recording)

    def assert_ball_is_felt(self, program):
        recording = self.feel(self.engine(program, self.session), self.still_device(0, 0, -0.007), 0.3)
        self.assertAlmostEqual(recording["fz_N"].max(), 1.0, delta=1e-3)  # 2 mm deep

    def test_the_page_of_readers_shows_the_logger_that_is_tested(self):
        page = (ROOT / "docs" / "library_reader.md").read_text()
        logger = ROOT / "tests" / "shared" / "library" / "logger.c"
        self.assertIn(f"```c\n{logger.read_text()}```", page)

    def test_the_library_exports_what_its_header_declares(self):
        header = (self.prefix / "include" / "stillgrid" / "stillgrid.h").read_text()
        declared = set(re.findall(r"^STILLGRID_API [^(]*?(stillgrid_\w+)\(", header, re.MULTILINE))
        symbols = self.run_quietly("nm", "--dynamic", "--defined-only",
                                   self.prefix / "lib" / "libstillgrid.so.1").splitlines()
        exported = {line.split()[-1].split("@")[0] for line in symbols} - {"STILLGRID_1"}
        self.assertGreater(len(declared), 10)
        self.assertEqual(exported, declared)

    def test_a_program_in_C11_built_by_pkg_config_is_felt(self):
        environment = dict(os.environ, PKG_CONFIG_PATH=self.prefix / "lib" / "pkgconfig")
        flags = self.run_quietly("pkg-config", "--cflags", "--libs", "stillgrid", env=environment).split()
        program = self.folder / "publish_ball"
        self.run_quietly("cc", "-std=c11", "-Wall", "-Wextra", "-Werror",
                         self.example("publish_ball") / "publish_ball.c", "-o", program, *flags,
                         f"-Wl,-rpath,{self.prefix / 'lib'}")
        self.assert_ball_is_felt(program)

    def test_a_program_in_CPP20_built_by_find_package_is_felt_and_moves_with_the_prefix(self):
        self.run_quietly("cmake", "--install", self.build("publish_ball"), "--prefix", self.prefix)
        self.prefix = self.prefix.rename(self.folder / "second place")
        self.assert_ball_is_felt(self.prefix / "bin" / "publish_ball")

    def need(self, header):
        if not header.exists():
            self.skipTest(f"skipped: {header} is not installed, see scripts/setup")

    def pressing_hand(self):
        """Down on the ball and off it, three times in 4 s; the ball's top is at -12 mm, the tool's bottom
        5 mm below what is written."""
        time_s = numpy.arange(0.0, 4.0, 0.001)
        z_m = -0.004 - 0.003 * (1.0 - numpy.cos(2.0 * numpy.pi * numpy.maximum(0.0, time_s - 1.0)))
        rows = "".join(f"{t:.4f},0,0,{z:.9f}\n" for t, z in zip(time_s, z_m))
        return f"replay:file={self.write('press.csv', 'time_s,x_m,y_m,z_m' + chr(10) + rows)}"

    def test_a_ball_in_MuJoCo_is_felt_as_the_same_ball_in_sim_server(self):
        self.need(MUJOCO)
        program, folder = self.build("mujoco") / "publish_mujoco", self.example("mujoco")
        hand = self.pressing_hand()
        ours = self.feel(self.sim_server(folder / "ball_on_floor.toml", "--lockstep", "--duration", 4), hand, 4)
        theirs = self.feel(self.engine(program, folder / "ball_on_floor.xml", self.session, "--lockstep"), hand, 4)
        ours_N, theirs_N = ours["fz_N"], theirs["fz_N"]
        self.assertGreater(ours_N.max(), 0.5)
        # In the period in which the tool meets the ball nothing tells yet that a floor is under it.
        self.assertLess(abs(theirs_N - ours_N).max(), 0.3)
        self.assertLess(numpy.sqrt(numpy.mean((theirs_N - ours_N) ** 2)), 0.05)
        self.assertLess(abs(numpy.diff(theirs_N)).max(), 0.06)

    def test_a_pile_in_Bullet_is_felt_for_10_s_without_jumps_and_gives_the_hand_no_energy(self):
        self.need(BULLET)
        report = self.folder / "report.json"
        engine = self.engine(self.build("bullet") / "publish_bullet", self.session, "--lockstep")
        hand = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0.03,depth_m=0.01,limits=0"
        felt = self.feel(engine, hand, 10, "--report", report)
        force_N = daemons.vectors(felt, "f", "N")
        contacts = felt["contacts"].reshape(5, -1) > 0  # it presses five times
        self.assertTrue((contacts.mean(axis=1) > 0.2).all(), contacts.mean(axis=1))
        self.assertGreater(felt["fz_N"].max(), 0.5)
        self.assertLess(numpy.linalg.norm(numpy.diff(force_N, axis=0), axis=1).max(), 0.25)
        self.assertLess(daemons.read_report(report)["interface"]["made_J"], 1e-3)

    def test_the_force_of_a_killed_engine_fades_and_returns_with_the_next(self):
        self.need(MUJOCO)
        command = (self.build("mujoco") / "publish_mujoco", self.example("mujoco") / "ball_on_floor.xml",
                   self.session)
        engine, recording = self.engine(*command), self.folder / "recording.csv"
        hand = self.haptic_server(self.still_device(0, 0, -0.009), "--record", recording)
        self.wait_until(lambda: recording.exists() and recording.stat().st_size > 100_000, 20.0, "a second")
        engine.signal(signal.SIGKILL)
        time.sleep(0.6)
        self.assertTrue(hand.runs(), hand.lines())
        size = recording.stat().st_size
        self.engine(*command)
        self.wait_until(lambda: recording.stat().st_size > size + 150_000, 20.0, "more than a second")
        self.assertEqual(hand.stop(), daemons.DONE, hand.lines())
        felt = daemons.read_recording(recording)
        time_s, force_N = felt["time_s"], felt.force_norm_N()
        is_faded = numpy.array(["faded" in flags for flags in felt["flags"]])
        first = numpy.flatnonzero(force_N > 0.2)[0]
        faded = first + numpy.flatnonzero((is_faded & (force_N == 0.0))[first:])[0]
        began = numpy.flatnonzero(~is_faded[:faded])[-1]
        late_s = numpy.diff(time_s[:faded + 1]).max()
        self.assertLess(time_s[faded] - time_s[began], FADE_S + 0.01 + late_s)
        self.assertGreater(force_N[faded + 1:].max(), 0.2, "it is back")


if __name__ == "__main__":
    daemons.main()
