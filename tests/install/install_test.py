#!/usr/bin/python3
"""An installed Stillgrid is whole: programs, licences, and what drivers outside the tree are built against."""
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = ROOT / "tests" / "install"
sys.path.append(str(ROOT / "tests" / "integration"))
import daemons  # after the path it needs


class InstallTest(daemons.SessionTest):
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

    def examples(self):
        return self.prefix / "share" / "stillgrid" / "examples"

    def pkg_config(self):
        return dict(os.environ, PKG_CONFIG_PATH=self.prefix / "lib" / "pkgconfig")

    def build(self, example):
        """An example as it is installed, a CMake project of its own, installed beside Stillgrid."""
        build = self.folder / f"build-{example}"
        self.run_quietly("cmake", "-S", self.examples() / example, "-B", build, "-G", "Ninja",
                         f"-DCMAKE_PREFIX_PATH={self.prefix}", "-DCMAKE_BUILD_TYPE=Release",
                         "-DCMAKE_COMPILE_WARNING_AS_ERROR=ON")
        self.run_quietly("cmake", "--build", build)
        self.run_quietly("cmake", "--install", build, "--prefix", self.prefix)
        return self.prefix / "lib" / "stillgrid" / "devices" / f"{example}.so"

    def compile_handle(self, name, header):
        """The C example with another header, by the one line of the page."""
        folder = self.folder / name
        (folder / "stillgrid").mkdir(parents=True)
        (folder / "stillgrid" / "device_plugin.h").write_text(header)
        library = folder / "handle.so"
        flags = self.run_quietly(
            "pkg-config", "--cflags", "--libs", "stillgrid-device", env=self.pkg_config()).split()
        self.run_quietly("cc", "-std=c11", "-O2", f"-I{folder}", self.examples() / "handle" / "handle.c", "-o",
                         library, *flags, "-lm")
        return library

    def check(self, device):
        """Every rule of the interface is kept, but for how long calls took on this machine."""
        rules = self.run_quietly(self.prefix / "bin" / "device_check", "--list").splitlines()
        self.run_quietly(self.prefix / "bin" / "device_check", device, "--seconds", 0.1, "--only",
                         *(rule.split()[0] for rule in rules if not rule.startswith("timing.")))

    def sim_server(self, *arguments):
        scene = self.prefix / "share" / "stillgrid" / "scenes" / "tissue_and_blocks.toml"
        return self.start(self.prefix / "bin" / "sim_server", "--scene", scene, "--session",
                          self.session, *arguments)

    def haptic_server(self, device, *arguments):
        return self.start(self.prefix / "bin" / "haptic_server", "--session", self.session,
                          "--device", device, *arguments)

    def run_in_lockstep(self, device):
        recording = self.folder / f"recording-{len(self.daemons)}.csv"
        both = ("--lockstep", "--duration", 0.5)
        sim_server = self.sim_server(*both)
        haptic_server = self.haptic_server(device, *both, "--record", recording)
        self.assertEqual(haptic_server.wait(), daemons.DONE, haptic_server.lines())
        self.assertEqual(sim_server.wait(), daemons.DONE, sim_server.lines())
        return recording

    def test_every_program_says_its_version_and_of_which_interfaces(self):
        version = (ROOT / "VERSION").read_text().strip()
        segment = re.search(r"kSegmentVersion = (\d+);", (ROOT / "proto" / "segment_header.hpp").read_text())[1]
        segments, drivers = f"segment version {segment}", "device interface 2"
        relay = (ROOT / "shared" / "tools" / "scene_relay" / "messages.hpp").read_text()
        protocol = re.search(r"kProtocol = (\d+);", relay)[1]
        interfaces = {"sim_server": f" ({segments})", "scene_viewer": f" ({segments})",
                      "segment_inspect": f" ({segments})", "haptic_server": f" ({segments}, {drivers})",
                      "device_check": f" ({drivers})", "fit_run": f" ({drivers})",
                      "scene_relay": f" ({segments}, protocol {protocol})",
                      "stability_lab": f" ({drivers})"}
        programs = [file for folder in ("bin", "libexec/stillgrid") for file in (self.prefix / folder).iterdir()]
        self.assertLessEqual(set(interfaces), {program.name for program in programs} | {"stability_lab"})
        programs += [daemons.BUILD / "bin" / "stability_lab", ROOT / "scripts" / "launch"]  # of the tree alone
        for program in programs:
            with self.subTest(program.name):
                self.assertEqual(self.run_quietly(program, "--version"),
                                 f"{program.name} {version}{interfaces.get(program.name, '')}")
        self.assertEqual(self.run_quietly("pkg-config", "--modversion", "stillgrid-device", env=self.pkg_config()),
                         version)

    def test_the_licence_and_the_notices_of_others_are_installed_as_they_stand_in_the_tree(self):
        for name in ("LICENSE", "THIRD_PARTY_NOTICES.md"):
            installed = self.prefix / "share" / "doc" / "stillgrid" / name
            self.assertEqual(installed.read_bytes(), (ROOT / name).read_bytes())
        page = self.prefix / "share" / "stillgrid" / "viewer"
        if page.exists():  # not of a sanitizer's build
            self.assertIn("MIT", (page / "three" / "LICENSE").read_text())

    def test_every_link_of_the_installed_pages_leads_to_an_installed_file(self):
        pages = sorted((self.prefix / "share/doc/stillgrid").rglob("*.md"))
        links = [(page, link) for page in pages
                 for link in re.findall(r'(?:\]\(|src=")(?![a-z]+:)([^)\s#"]+)', page.read_text())]
        self.assertGreater(len(links), 700)
        self.assertEqual([(page.name, link) for page, link in links if not (page.parent / link).exists()], [])

    def test_a_driver_in_C11_built_with_the_package_is_found_by_its_name_and_felt(self):
        library = self.build("handle")
        exported = self.run_quietly("nm", "--dynamic", "--defined-only", library).splitlines()
        self.assertEqual([line.split()[-1] for line in exported], ["stillgrid_device_negotiate"])

        self.check("handle")

        first, second = (self.run_in_lockstep("handle:stiffness_N_per_m=100,rest_z_m=-0.04")
                         for _ in range(2))
        recording = daemons.read_recording(first)
        self.assertGreater(recording["contacts"].max(), 0)
        self.assertGreater(recording["fz_N"].max(), 0.0)  # it is pushed out again
        self.assertLess(recording["z_m"].min(), recording["z_m"][0] - 0.01)
        self.assertEqual(first.read_bytes(), second.read_bytes())

    def test_a_driver_in_CPP20_of_a_real_device_gives_its_positions_and_gets_forces(self):
        self.build("udp_knob")
        probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
        probe.close()
        record, report = self.folder / "recording.csv", self.folder / "report.json"
        self.sim_server()
        answers, may_end = [], threading.Event()

        def knob():
            try:  # a device does not starve on a busy machine
                os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(60))
            except PermissionError:
                pass
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as here:
                here.settimeout(0.005)
                while not may_end.is_set():
                    try:
                        here.sendto(b"0.0 0.0 -0.02", ("127.0.0.1", port))
                        answers.append([float(word) for word in here.recv(100).split()])
                    except OSError:  # nobody there yet, or no answer yet
                        pass
                    may_end.wait(0.001)

        thread = threading.Thread(target=knob)
        thread.start()
        try:
            server = self.haptic_server(f"udp_knob:port={port}", "--record", record, "--report", report)
            self.wait_until(lambda: len(answers) > 20 and any(map(any, answers)) or not server.runs(), 30,
                            "a force")
            server.signal(signal.SIGSTOP)
            threading.Event().wait(0.9)  # longer than the silence that ends a run
            server.signal(signal.SIGCONT)
            seen = len(answers)
            self.wait_until(lambda: len(answers) > seen + 100 or not server.runs(), 30, "answers")
            self.assertEqual(server.stop(), daemons.DONE, server.lines())
            self.wait_until(lambda: not any(answers[-1]), 5, "the force's end")
            self.check(f"udp_knob:port={port}")
            seen = len(answers)
            abandoned = self.haptic_server(f"udp_knob:port={port}")
            self.wait_until(lambda: len(answers) > seen + 20 or not abandoned.runs(), 30, "answers")
        finally:
            may_end.set()
            thread.join()
        self.assertEqual(abandoned.wait(), daemons.DEVICE_FAULT, abandoned.lines())
        self.assertIn("nothing came for 500 ms", "\n".join(abandoned.lines()))
        self.assertLessEqual(max(abs(f) for answer in answers for f in answer), 2.0)
        self.assertIn("haptic_server: device 'udp_knob': the device speaks", server.lines())
        self.assertEqual(daemons.read_report(report)["device_identity"],
                         {"serial": f"127.0.0.1:{port}", "firmware": "", "driver": "udp_knob 1.0"})
        head = daemons.read_recording(record).metadata
        self.assertEqual(head["device_serial"], f"127.0.0.1:{port}")
        self.assertEqual(head["device_driver"], "udp_knob 1.0")
        self.assertNotIn("device_firmware", head)

    def test_a_driver_of_another_header_is_refused_in_one_line(self):
        today = (self.prefix / "include" / "stillgrid" / "device_plugin.h").read_text()
        other = today.replace("STILLGRID_DEVICE_ABI 2u", "STILLGRID_DEVICE_ABI 3u")
        self.assertNotEqual(other, today)
        library = self.compile_handle("other", other)
        self.assert_refused(self.haptic_server(library), daemons.COULD_NOT_START, str(library),
                            "built for another version of the device interface: expected 2")

    def test_the_guard_is_found_and_has_nothing_to_say_of_the_example(self):
        if not (self.prefix / "lib" / "stillgrid" / "librealtime_guard.so").exists():
            self.skipTest("skipped: this build has no guard")
        self.build("handle")
        self.sim_server()
        server = self.haptic_server("handle", "--realtime-guard", "--duration", 0.3)
        self.assertEqual(server.wait(), daemons.DONE, server.lines())


if __name__ == "__main__":
    daemons.main()
