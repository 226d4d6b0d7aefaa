#!/usr/bin/python3
"""In lockstep no clock decides anything: equal input gives equal bytes."""
import os
import signal
import subprocess
import time
import unittest

import daemons

# Presses through the gap between the blocks into the tissue, within the first second.
PRESSING_HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=1"


class LockstepTest(daemons.SessionTest):
    def record(self, device=PRESSING_HAND, duration_s=1.0, scene="tissue_and_blocks", **options):
        return self.run_lockstep(scene, device, duration_s, **options)

    def assert_same_bytes(self, first, second):
        contacts = daemons.read_recording(first)["contacts"]
        self.assertGreater(contacts.max(), 0, "the tool touched nothing")
        self.assertEqual(first.read_bytes(), second.read_bytes())

    def test_two_runs_write_the_same_bytes(self):
        self.assert_same_bytes(self.record(), self.record())

    def test_a_busy_machine_changes_no_byte(self):
        quiet = self.record()
        hogs = [subprocess.Popen(["setpriv", "--pdeathsig", "KILL", "sh", "-c", "while :; do :; done"])
                for _ in range(2 * os.cpu_count())]
        try:
            busy = self.record()
        finally:
            for hog in hogs:
                hog.kill()
                hog.wait()
        self.assert_same_bytes(quiet, busy)

    def test_a_simulation_that_is_held_up_is_waited_for(self):
        """For longer than a call of the device would be."""
        recording = self.folder / "held_up.csv"
        both = ("--lockstep", "--duration", 1000)
        sim_server = self.sim_server("tissue_and_blocks", *both)
        haptic_server = self.haptic_server(PRESSING_HAND, *both, "--record", recording)
        self.wait_until(lambda: recording.exists() and recording.stat().st_size > 5000, 30, "a recording")
        sim_server.signal(signal.SIGSTOP)
        time.sleep(11)
        self.assertTrue(haptic_server.runs(), haptic_server.lines())
        sim_server.signal(signal.SIGCONT)
        self.assertEqual(haptic_server.stop(), daemons.DONE, haptic_server.lines())

    def test_without_a_duration_it_ends_a_period_after_the_last_snapshot(self):
        recordings = []
        for latency in (0.0, 0.003):
            for _ in range(2):
                recordings.append(self.folder / f"{len(recordings)}.csv")
                sim_server = self.sim_server("tissue_and_blocks", "--lockstep", "--rate", 250, "--duration", 0.2,
                                             "--latency", latency)
                haptic_server = self.haptic_server(PRESSING_HAND, "--lockstep", "--record", recordings[-1])
                self.assertEqual(haptic_server.wait(), daemons.DONE, haptic_server.lines())
                self.assertEqual(sim_server.wait(), daemons.DONE, sim_server.lines())
            time_s = daemons.read_recording(recordings[-1])["time_s"]
            self.assertAlmostEqual(time_s[-1], 0.2 + latency + 0.004 - 0.001)
            self.assertEqual(recordings[-2].read_bytes(), recordings[-1].read_bytes())

    def test_without_a_duration_a_simulation_ends_after_its_hands(self):
        sim_server = self.sim_server("wall", "--lockstep")
        haptic_server = self.haptic_server("phantom", "--lockstep", "--duration", 0.2)
        self.assertEqual(haptic_server.wait(), daemons.DONE, haptic_server.lines())
        self.assertEqual(sim_server.wait(), daemons.DONE, sim_server.lines())

    def test_a_stop_ends_it_though_its_simulation_has_ended(self):
        for end in (signal.SIGINT, signal.SIGTERM):
            recording = self.folder / f"{end.name}.csv"
            self.sim_server("wall", "--lockstep", "--duration", 0.1)
            haptic_server = self.haptic_server("phantom", "--lockstep", "--duration", 1e8, "--record", recording)
            self.wait_until(lambda: recording.exists() and recording.stat().st_size > 100_000, 10, "a recording")
            haptic_server.signal(end)
            self.assertEqual(haptic_server.wait(), daemons.DONE, haptic_server.lines())

    def test_a_jittery_slow_simulation_repeats_by_its_seed(self):
        def jittery(seed):
            return self.record(sim=("--rate", 33, "--jitter", 0.3, "--latency", 0.02, "--seed", seed))

        first, other = jittery(7), jittery(8)
        self.assert_same_bytes(first, jittery(7))
        self.assertNotEqual(first.read_bytes(), other.read_bytes())

    def test_a_recorded_hand_replays_the_same_bytes(self):
        hand = self.record()
        # A recording is in the scene's frame, of which the device's origin is 2 cm above.
        device = f"replay:file={hand},offset_z_m=-0.02"
        first = self.record(device)
        self.assert_same_bytes(first, self.record(device))
        original, replayed = map(daemons.read_recording, (hand, first))
        rows = min(len(original["x_m"]), len(replayed["x_m"]))
        difference_m = (daemons.vectors(original, "", "m")[:rows] -
                        daemons.vectors(replayed, "", "m")[:rows])
        self.assertLess(abs(difference_m).max(), 1e-9)

    def test_a_real_recording_replays_the_same_bytes(self):
        file = daemons.DATA / "trajectories" / "franka_1khz" / "franka_20260223_162545.csv"
        if not file.exists():
            self.skipTest(f"skipped: {file} is absent")
        # The robot's circle of 0.43 x 0.61 m becomes one of 6 x 9 cm that sweeps the tissue.
        device = (f"replay:file={file},scale=0.15,offset_x_m=-0.0852,offset_y_m=-0.0025,"
                  "offset_z_m=-0.042,resample=cubic")
        self.assert_same_bytes(self.record(device, 2.0), self.record(device, 2.0))


if __name__ == "__main__":
    daemons.main()
