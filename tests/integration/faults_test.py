#!/usr/bin/python3
"""Each fault at the start gives one line and its exit status, and never a hang."""
import os
import signal
import time
import unittest
import unittest.mock

import daemons
from daemons import BAD_INPUT, COULD_NOT_START, DEVICE_FAULT, DONE

LONG = ("--duration", "60")


class BadInputTest(daemons.SessionTest):
    def assert_scene_refused(self, text, *words):
        file = self.write("scene.toml", text)
        daemon = self.sim_server(file, *LONG)
        self.assert_refused(daemon, BAD_INPUT, "scene.toml:", *words)

    def assert_device_refused(self, device, *words):
        self.assert_refused(self.haptic_server(device, *LONG), BAD_INPUT, *words)

    def test_a_bad_scene_is_named_with_its_key_and_line(self):
        self.assert_scene_refused("format = 2\n[tool]\nradius_m = -1.0\n", ":3:", "radius_m", "-1")

    def test_an_unknown_key_of_a_scene_is_named(self):
        self.assert_scene_refused("format = 2\n[world]\ngravity = [0, 0, -9.81]\n", "gravity")

    def test_a_scene_that_is_no_TOML_is_refused_at_its_line(self):
        self.assert_scene_refused("format = 2\n[world\n", ":2:")

    def test_a_missing_scene_is_named(self):
        daemon = self.sim_server(self.folder / "absent.toml", *LONG)
        self.assert_refused(daemon, BAD_INPUT, "absent.toml")

    def test_a_bad_row_of_a_recording_is_named_with_its_line(self):
        file = self.write("hand.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n1,0,zero,0\n")
        self.assert_device_refused(f"replay:file={file}", "hand.csv:3", "y_m", "zero")

    def test_time_that_goes_back_in_a_recording_is_refused(self):
        file = self.write("hand.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,0\n0.5,0,0,0\n")
        self.assert_device_refused(f"replay:file={file}", "hand.csv:4", "time_s", "0.5")

    def test_a_recording_without_a_needed_column_is_refused(self):
        file = self.write("hand.csv", "time_s,x_m,y_m\n0,0,0\n")
        self.assert_device_refused(f"replay:file={file}", "hand.csv", "z_m")

    def test_a_missing_recording_is_named(self):
        self.assert_device_refused("replay:file=/absent.csv", "/absent.csv")

    def test_a_missing_plugin_is_named(self):
        self.assert_device_refused("touch_9000", "touch_9000")

    def test_a_file_that_is_no_plugin_is_refused(self):
        file = self.write("text.so", "not a library\n")
        self.assert_device_refused(str(file), "text.so")

    def test_an_unknown_option_of_a_plugin_is_named(self):
        self.assert_device_refused("phantom:colour=red", "colour")

    def test_a_bad_value_of_a_plugins_option_is_named(self):
        self.assert_device_refused("phantom:hand=heavy", "hand", "heavy")

    def test_an_unknown_transition_is_named(self):
        daemon = self.haptic_server("phantom", *LONG, "--transition", "magic")
        self.assert_refused(daemon, BAD_INPUT, "--transition", "magic")

    def test_an_unknown_option_of_a_program_is_named(self):
        self.assert_refused(self.haptic_server("phantom", "--colour"), BAD_INPUT, "--colour")
        self.assert_refused(self.sim_server("wall", "--colour"), BAD_INPUT, "--colour")

    def test_a_session_that_cannot_be_a_name_is_refused(self):
        self.session = "../other"
        for daemon in (self.sim_server("wall", *LONG), self.haptic_server("phantom", *LONG)):
            self.assert_refused(daemon, BAD_INPUT, "--session", "../other")

    def test_a_number_that_is_none_is_refused(self):
        for option in ("--max-force", "--max-slew", "--rate", "--duration"):
            daemon = self.haptic_server("phantom", option, "nan")
            self.assert_refused(daemon, BAD_INPUT, option, "nan")
        for option in ("--rate", "--duration", "--jitter"):
            self.assert_refused(self.sim_server("wall", option, "nan"), BAD_INPUT, option, "nan")

    def test_a_record_that_cannot_be_written_is_refused(self):
        self.sim_server("wall", *LONG)
        daemon = self.haptic_server("phantom", *LONG, "--record", "/absent/record.csv")
        self.assert_refused(daemon, BAD_INPUT, "/absent/record.csv")


class SessionFaultTest(daemons.SessionTest):
    def test_a_second_sim_server_is_refused_and_disturbs_nothing(self):
        first = self.sim_server("wall")
        recording = self.folder / "recording.csv"
        hand = self.haptic_server(self.still_device(0, 0, 0.003), "--duration", 1.5, "--record",
                                  recording)
        self.wait_until(recording.exists, 5.0, "haptic_server at work")
        self.assert_refused(self.sim_server("wall", *LONG), COULD_NOT_START, self.session)
        self.assertEqual(hand.wait(), DONE, hand.lines())
        self.assertEqual(first.stop(), DONE)
        forces_N = daemons.read_recording(recording).force_norm_N()
        self.assertAlmostEqual(forces_N[-120:].max(), 2.0, delta=1e-3)  # it fades at the end

    def test_a_second_haptic_server_is_refused(self):
        self.sim_server("wall")
        recording = self.folder / "recording.csv"
        first = self.haptic_server("phantom", "--record", recording)
        self.wait_until(recording.exists, 5.0, "haptic_server at work")
        self.assert_refused(self.haptic_server("phantom", *LONG), COULD_NOT_START, self.session)
        self.assertTrue(first.runs())
        self.assertEqual(first.stop(), DONE)

    def test_a_run_whose_device_was_never_believed_is_a_device_fault(self):
        report = self.folder / "report.json"
        for centre_m, reason in ((20.0, "too_far"), (1.0, "outside")):
            sim = self.sim_server("wall", "--lockstep", "--duration", 0.3)
            hand = self.haptic_server(f"phantom:path=still,centre_z_m={centre_m}", "--lockstep",
                                      "--duration", 0.3, "--report", report)
            self.assertEqual(hand.wait(), DEVICE_FAULT, hand.lines())
            sim.stop()
            lines = hand.lines()
            self.assertEqual(sum("; the force fades" in line for line in lines), 1, lines)
            self.assertEqual(sum(f"in 300 of 300 ticks, {reason} 300" in line for line in lines), 1,
                             lines)
            safety = daemons.read_report(report)["safety"]
            self.assertEqual((safety["bad_device"], safety[reason]), (300, 300))

    def test_a_run_whose_device_was_mostly_not_believed_is_a_device_fault(self):
        for leaves_s, status in ((0.12, DEVICE_FAULT), (0.18, DONE)):
            file = self.write("leaves.csv", f"time_s,x_m,y_m,z_m\n0,0,0,0\n{leaves_s},0,0,0\n"
                                            f"{leaves_s + 0.001},0,0,20\n1,0,0,20\n")
            self.sim_server("wall", "--lockstep", "--duration", 0.3)
            hand = self.haptic_server(f"replay:file={file}", "--lockstep", "--duration", 0.3)
            self.assertEqual(hand.wait(), status, hand.lines())

    def test_a_driver_that_changes_what_is_the_process_s_is_seen(self):
        self.sim_server("wall")
        driver = daemons.BUILD / "tests" / "shared" / "tools" / "hostile_drivers" / "hostile.so"
        for fault, what in (("opens_umask", "the umask"), ("rounds_up", "the rounding mode"),
                            ("masks_signals", "the signal mask")):
            with unittest.mock.patch.dict(os.environ, STILLGRID_HOSTILE_FAULT=fault):
                hand = self.haptic_server(str(driver), "--duration", 1.2)
            self.assertEqual(hand.wait(), DONE, hand.lines())
            said = [line for line in hand.lines() if what in line]
            self.assertEqual(len(said), 2, hand.lines())  # at the first, and how often
            self.assertIn("has changed since the device was opened", said[0])
            self.assertIn(f"seen changed, {what} ", said[1])

    def test_haptic_server_waits_for_its_sim_server(self):
        hand = self.haptic_server("phantom", "--duration", 0.5)
        time.sleep(1.0)
        self.assertTrue(hand.runs(), hand.lines())
        self.sim_server("wall")
        self.assertEqual(hand.wait(5.0), DONE, hand.lines())

    def test_Ctrl_C_ends_a_haptic_server_that_still_waits(self):
        hand = self.haptic_server("phantom")
        time.sleep(0.5)
        self.assertEqual(hand.stop(), DONE, hand.lines())

    def test_Ctrl_C_ends_a_lockstep_sim_server_that_still_waits(self):
        sim = self.sim_server("wall", "--lockstep")
        time.sleep(0.5)
        self.assertEqual(sim.stop(), DONE, sim.lines())

    def test_without_its_peer_each_gives_up_after_ten_seconds(self):
        start_s = time.monotonic()
        hand = self.haptic_server("phantom")
        self.session += "-other"
        sim = self.sim_server("wall", "--lockstep")
        for daemon in (hand, sim):
            self.assert_refused(daemon, COULD_NOT_START, self.session[:-6], timeout_s=12.0)
        self.assertGreater(time.monotonic() - start_s, 9.0)

    def test_clocks_that_differ_are_refused(self):
        self.sim_server("wall")
        self.assert_refused(self.haptic_server("phantom", "--lockstep"), COULD_NOT_START,
                            "lockstep")

    def test_lockstep_ends_when_its_peer_is_killed(self):
        for victim in ("sim_server", "haptic_server"):
            recording = self.folder / f"{victim}.csv"
            sim = self.sim_server("tissue_and_blocks", "--lockstep")
            hand = self.haptic_server("phantom", "--lockstep", "--record", recording)
            # Rows: a peer that is killed before it was seen is waited for, for 10 s.
            self.wait_until(lambda file=recording: file.exists() and file.read_bytes().count(b"\n") > 1, 5.0,
                            "lockstep under way")
            killed, other = (sim, hand) if victim == "sim_server" else (hand, sim)
            killed.signal(signal.SIGKILL)
            self.assert_refused(other, COULD_NOT_START, victim)
            killed.wait()  # or the next hand may join what is about to be gone


if __name__ == "__main__":
    daemons.main()
