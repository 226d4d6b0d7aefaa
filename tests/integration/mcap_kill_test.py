#!/usr/bin/python3
"""What is recorded as MCAP survives a kill and a full disk, for the readers of MCAP's makers too."""
import random
import signal
import subprocess

import numpy

import daemons
import imports
import mcap_files
from daemons import DONE, INCOMPLETE

PRESS = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0.02,depth_m=0.025,period_s=1"


class McapKillTest(daemons.SessionTest):
    def wait_for_bytes(self, file, bytes_):
        self.wait_until(lambda: file.exists() and file.stat().st_size > bytes_, 10.0, f"{bytes_} bytes")

    def test_a_kill_leaves_the_beginning_of_what_an_undisturbed_run_writes(self):
        both = ("--lockstep", "--duration", 4)
        files = {name: self.folder / name for name in ("whole.mcap", "whole.csv")}
        for file in files.values():
            sim = self.sim_server("tissue_and_blocks", *both)
            hand = self.haptic_server(PRESS, *both, "--record", file)
            self.assertEqual((hand.wait(), sim.wait()), (DONE, DONE))
        whole, csv = files["whole.mcap"].read_bytes(), daemons.read_recording(files["whole.csv"])
        moments = random.Random(24)
        for kill in range(3):
            file = self.folder / f"killed-{kill}.mcap"
            sim = self.sim_server("tissue_and_blocks", *both)
            hand = self.haptic_server(PRESS, *both, "--record", file)
            self.wait_for_bytes(file, moments.randrange(len(whole) // 2))
            hand.signal(signal.SIGKILL)
            hand.wait()
            sim.wait()
            left = file.read_bytes()
            self.assertEqual(left, whole[:len(left)])
            # Cut anywhere, as where the machine loses power.
            file.write_bytes(left[:moments.randrange(len(left) // 2, len(left))])
            reader = mcap_files.Read(file, "streamed")
            rows = reader.rows()
            self.assertEqual(reader.is_whole, False)
            mcap_files.assert_same_bits(self, rows, csv, len(rows["time_s"]))

    def test_a_kill_in_real_time_loses_what_came_since_the_last_chunk(self):
        self.sim_server("wall")
        file = self.folder / "killed.mcap"
        hand = self.haptic_server(PRESS, "--record", file)
        self.wait_for_bytes(file, 60_000)
        seen = file.with_name("seen.mcap")
        seen.write_bytes(file.read_bytes())
        before = len(mcap_files.Read(seen, "streamed").rows()["time_s"])
        hand.signal(signal.SIGKILL)
        hand.wait()
        reader = mcap_files.Read(file, "streamed")
        time_s = reader.rows()["time_s"]
        self.assertGreaterEqual(len(time_s), before)
        self.assertGreater(before, 100)
        self.assertTrue((numpy.diff(time_s) > 0.0).all())
        self.assertTrue(reader.messages("/scene/fixed"), "the scene is there from the start")
        stamps_ns = [stamp for stamp, _ in reader.messages(mcap_files.TICK_TOPIC)]
        self.assertGreater(stamps_ns[0], 1.6e18, "since 1970")
        trajectory = self.folder / "trajectory.csv"
        done = subprocess.run([imports.IMPORT, file, "--accept", "gaps", "--out", trajectory], text=True,
                              capture_output=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (DONE, ""))
        self.assertIn("the file was cut off", done.stdout)
        self.assertEqual(len(imports.read(trajectory)["time_s"]), len(time_s))

    def test_a_simulation_that_is_replaced_is_shown_anew(self):
        file = self.folder / "run.mcap"
        sim = self.sim_server("wall")
        hand = self.haptic_server(PRESS, "--record", file)
        self.wait_for_bytes(file, 20_000)
        sim.stop()
        self.sim_server("moving_sphere")
        self.wait_for_bytes(file, file.stat().st_size + 100_000)
        self.assertEqual(hand.stop(), DONE, hand.lines())
        reader = mcap_files.Read(file, "indexed")
        self.assertEqual(len(reader.messages("/scene/fixed")), 2)
        self.assertTrue(reader.messages("/scene/moving")[-1][1]["entities"])

    def test_a_full_disk_leaves_whole_chunks_and_a_count_of_the_other_rows(self):
        report, file = self.folder / "haptic.json", self.folder / "full.mcap"
        both = ("--lockstep", "--duration", 3)
        sim = self.sim_server("tissue_and_blocks", *both)
        hand = self.start("prlimit", "--fsize=400000", daemons.BUILD / "bin" / "haptic_server", "--session",
                          self.session, "--device", PRESS, *both, "--record", file, "--report", report)
        self.assertEqual((hand.wait(), sim.wait()), (INCOMPLETE, DONE), hand.lines())
        reader = mcap_files.Read(file, "streamed")
        rows, figures = len(reader.rows()["time_s"]), daemons.read_report(report)
        self.assertGreater(rows, 200)
        self.assertEqual(rows + figures["lost_rows"], figures["ticks"])
        self.assertIn(f"{figures['lost_rows']} of {figures['ticks']} ticks are missing", hand.lines()[-1])
        self.assertFalse(reader.is_whole)
        refused = self.haptic_server(PRESS, "--record", self.folder / "no" / "where.mcap")
        self.sim_server("wall")
        self.assert_refused(refused, daemons.BAD_INPUT, "where.mcap", "expected a file that can be written")


if __name__ == "__main__":
    daemons.main()
