#!/usr/bin/python3
"""What may stand in /dev/shm when a daemon starts or while it runs: one clear line, and nobody's
files but its own are touched."""
import fcntl
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import time
import unittest

import daemons
from daemons import BAD_INPUT, COULD_NOT_START, DONE, NOBODY, SHM, copy_for_others, heeds

LONG = ("--duration", "60")
WRITE_LOCK = struct.pack("hhqqi", fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0)  # struct flock: a whole file
VERSION_AT = 8  # bytes from a segment's start: docs/protocol.md


class SharedMemoryTest(daemons.SessionTest):
    def scene_file(self):
        return SHM / f"{self.session}-scene"

    def announced_sim_server(self, *arguments):
        sim = self.sim_server("wall", *arguments)
        self.wait_until(lambda: self.is_announced(sim), 5.0, "sim_server's segment")
        return sim

    def is_announced(self, sim):
        self.assertTrue(sim.runs(), sim.lines())
        try:
            return self.scene_file().read_bytes()[:8] == b"STLGRID1"
        except FileNotFoundError:
            return False

    def assert_both_refuse(self, *words):
        before = self.scene_file().read_bytes()
        self.assert_refused(self.sim_server("wall", *LONG), COULD_NOT_START, *words)
        self.assert_refused(self.haptic_server("phantom", *LONG), COULD_NOT_START, *words)
        self.assertEqual(self.scene_file().read_bytes(), before)

    def require_root(self):
        if os.geteuid() != 0:
            self.skipTest("needs root")

    def test_a_full_shared_memory_is_named_with_the_bytes_that_are_missing(self):
        self.require_root()
        # Kept to itself by its own mount: the file system's root is none where a folder was made the root.
        own = ("unshare", "--mount", "--propagation", "unchanged", "sh", "-c",
               'mount --make-private /dev/shm && mount -t tmpfs -o size=64k tmpfs /dev/shm && exec "$@"', "sh")
        if subprocess.run([*own, "true"], capture_output=True, check=False).returncode:
            self.skipTest("skipped: no mount of its own over /dev/shm")
        daemon = self.start(*own, daemons.BUILD / "bin" / "sim_server", "--session", self.session,
                            "--scene", daemons.SCENES / "tissue_and_blocks.toml", *LONG)
        self.assert_refused(daemon, BAD_INPUT, "tissue_and_blocks.toml:", "body 'tissue': memory: ",
                            "expected at most 0.1 MB, what /dev/shm has left")

    def test_a_session_of_another_user_is_refused_unless_it_is_opened_to_a_group(self):
        self.require_root()
        self.addCleanup(shutil.rmtree, "/dev/shm/stillgrid-65534", ignore_errors=True)
        hand = [*NOBODY, copy_for_others(self, "haptic_server") / "bin" / "haptic_server", "--session", f"root/{self.session}",
                "--device", "phantom", "--duration", 0.3]
        sim = self.announced_sim_server()
        self.assert_refused(self.start(*hand), COULD_NOT_START, "Permission denied: expected its writer to have --group")
        without_user = [self.session if word == f"root/{self.session}" else word for word in hand]
        self.assert_refused(self.start(*without_user), COULD_NOT_START,
                            f"after 10 s; another user has it: expected --session 0/{self.session}", timeout_s=20.0)
        sim.stop()
        self.announced_sim_server("--group", "nogroup")
        daemon = self.start(*hand)
        self.assertEqual(daemon.wait(), DONE, daemon.lines())

    def test_a_stranger_who_takes_the_names_first_keeps_nobody_out(self):
        self.require_root()
        for name in ("stillgrid-64322", "stillgrid-64322.1", "stillgrid-64322.1.1"):
            self.addCleanup(shutil.rmtree, SHM.parent / name, ignore_errors=True)
        taken = SHM.parent / "stillgrid-64322"
        self.assertEqual(self.start(*NOBODY, "mkdir", "-m", "777", taken).wait(), DONE)
        user = ("setpriv", "--reuid=64322", "--regid=64322", "--clear-groups")
        folder = copy_for_others(self, "haptic_server", "sim_server")
        both = [self.start(*user, folder / "bin" / server, "--session", self.session, *arguments)
                for server, arguments in (
                    ("haptic_server", ("--device", "phantom", "--duration", 0.3)),
                    ("sim_server", ("--scene", folder / "wall.toml", "--duration", 3)))]
        for daemon in both:
            self.assertEqual(daemon.wait(), DONE, daemon.lines())
            self.assertEqual(daemon.lines(), [])
        self.assertEqual(list(taken.iterdir()), [])
        self.assertEqual((SHM.parent / "stillgrid-64322.1").stat().st_uid, 64322)

    def test_a_group_that_does_not_exist_is_named(self):
        daemon = self.sim_server("wall", "--group", "no-such-group")
        self.assert_refused(daemon, daemons.BAD_INPUT, "--group", "no-such-group")

    def test_another_version_is_refused_and_both_are_named(self):
        self.announced_sim_server()
        with self.scene_file().open("r+b") as segment:
            segment.seek(VERSION_AT)
            own = struct.unpack("<I", segment.read(4))[0]
            segment.seek(VERSION_AT)
            segment.write(struct.pack("<I", 4711))
        self.assert_refused(self.haptic_server("phantom", *LONG), COULD_NOT_START,
                            "version 4711", f"version {own}")

    def test_a_truncated_segment_is_refused(self):
        self.announced_sim_server().stop()
        other = self.session
        self.session += "-whole"
        self.announced_sim_server()
        whole = self.scene_file().read_bytes()
        self.session = other
        self.scene_file().write_bytes(whole[:4096])
        self.assert_refused(self.haptic_server("phantom", *LONG), COULD_NOT_START,
                            f"says {len(whole)} bytes", "has 4096")
        sim = self.announced_sim_server()  # what a killed writer cut off is taken away
        self.assertEqual(sim.lines(), [])

    def test_a_foreign_file_under_the_name_is_refused_and_kept(self):
        self.scene_file().write_text("somebody's notes, of more than a header's length\n" * 20)
        self.assert_both_refuse(self.scene_file().name)

    def test_what_a_killed_writer_left_is_replaced_without_a_word(self):
        sim = self.announced_sim_server()
        sim.signal(signal.SIGKILL)
        sim.wait()
        left = self.scene_file().stat().st_ino
        self.assertTrue(self.scene_file().with_suffix(".lock").exists())
        again = self.sim_server("wall")
        self.wait_until(lambda: self.scene_file().exists() and
                        self.scene_file().stat().st_ino != left, 5.0, "a fresh segment")
        hand = self.haptic_server("phantom", "--duration", 0.3)
        self.assertEqual(hand.wait(), DONE, hand.lines())
        self.assertEqual(again.stop(), DONE)
        self.assertEqual(again.lines(), [])

    def test_a_stop_ends_the_wait_for_another_writer_with_the_device_untouched(self):
        self.assertEqual(self.sim_server("wall", "--duration", 0.1).wait(), DONE)  # makes the folder
        lock = (SHM / f"{self.session}-tool.lock").open("w")
        self.addCleanup(lock.close)
        fcntl.fcntl(lock, fcntl.F_OFD_SETLK, WRITE_LOCK)
        hand = self.haptic_server("phantom", *LONG)
        self.wait_until(lambda: hand.pid != hand.process.pid and heeds(hand.pid, signal.SIGTERM),
                        5.0, "its handlers")
        time.sleep(0.1)
        self.assertNotIn("phantom.so", pathlib.Path(f"/proc/{hand.pid}/maps").read_text())
        begin = time.monotonic()
        hand.signal(signal.SIGTERM)
        self.assertEqual(hand.wait(5.0), DONE, hand.lines())
        self.assertLess(time.monotonic() - begin, daemons.PATIENCE * 0.2)
        self.assertEqual(hand.lines(), [])

    def test_daemons_that_end_leave_nothing_and_other_sessions_alone(self):
        others = [SHM / f"{self.session}-other-{kind}" for kind in
                  ("scene", "tool", "scene.lock", "tool.lock")]
        for file in others:
            file.write_text("another session's\n")
        sim = self.announced_sim_server()
        hand = self.haptic_server("phantom", "--duration", 0.3)
        self.assertEqual(hand.wait(), DONE, hand.lines())
        sim.stop()
        for file in others:
            self.assertEqual(file.read_text(), "another session's\n")
        left = set(SHM.glob(f"{self.session}-*")) - set(others)
        self.assertEqual(left, set())

    def test_a_scene_shrunk_while_it_is_felt_fades_with_one_line_and_a_restart_is_felt_again(self):
        sim = self.announced_sim_server()
        recording = self.folder / "recording.csv"
        hand = self.haptic_server(self.still_device(0, 0, 0.003), "--record", recording)
        last_N = lambda: self.last_force_N(recording)
        self.wait_until(lambda: last_N() > 1.9, 5.0, "contact")
        os.truncate(self.scene_file(), 0)
        self.wait_until(lambda: last_N() == 0.0, 2.0, "fade")
        self.assertTrue(hand.runs(), hand.lines())
        self.wait_until(hand.lines, 2.0, "its line")
        self.assertEqual(len(hand.lines()), 1, hand.lines())
        self.assertIn("was shrunk by another program", hand.lines()[0])
        self.assert_refused(sim, COULD_NOT_START, "was shrunk by another program")
        self.announced_sim_server()
        self.wait_until(lambda: last_N() > 1.9, 5.0, "contact again")
        self.assertEqual(hand.stop(), DONE)
        force_N = daemons.read_recording(recording).force_norm_N()
        gone = (force_N == 0.0).nonzero()[0]
        fade = force_N[:gone[gone > (force_N > 1.9).argmax()][0]][-1000:]
        on_the_way = ((fade > 0.1) & (fade < 1.9)).sum()
        # A force that drops passes no value between; one that fades passes many, however late a tick is.
        self.assertGreater(on_the_way, 10)

    def test_a_tool_segment_shrunk_while_in_use_ends_haptic_server_with_one_line(self):
        self.announced_sim_server()
        hand = self.haptic_server("phantom")
        tool = SHM / f"{self.session}-tool"
        self.wait_until(lambda: tool.exists() and tool.stat().st_size > 0, 5.0, "haptic_server at work")
        os.truncate(tool, 0)
        self.assert_refused(hand, COULD_NOT_START, "was shrunk by another program")

    @staticmethod
    def last_force_N(file):
        """Of the last whole row; 0 before the first."""
        rows = file.read_text().splitlines()[:-1] if file.exists() else []
        if len(rows) < 5:
            return 0.0
        return sum(float(x) ** 2 for x in rows[-1].split(",")[7:10]) ** 0.5


if __name__ == "__main__":
    daemons.main()
