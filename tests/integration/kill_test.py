#!/usr/bin/python3
"""Either daemon may be killed and restarted while the tool touches: forces fade, nothing hangs."""
import signal
import time
import unittest

import numpy

import daemons
from daemons import DONE

# Of the scene wall: 1000 N/m, so that a tool held 2 mm deep feels 2 N.
PERIOD_S = 1.0 / 30.0
DEPTH_POINT = (0, 0, 0.003)
FORCE_N = 2.0
FADE_S = 0.1
# A linear fade changes by FORCE_N / 100 in a tick; a stalled machine stretches a tick.
SMOOTH_N = 5 * FORCE_N / 100


class KillTest(daemons.SessionTest):
    def touching_hand(self, name, *arguments):
        recording = self.folder / name
        hand = self.haptic_server(self.still_device(*DEPTH_POINT), "--record", recording,
                                  *arguments)
        self.wait_until(lambda: recording.exists() and recording.stat().st_size > 50_000, 5.0,
                        "half a second of contact")
        return hand, recording

    def test_a_simulation_that_is_replaced_at_once_fades_out_before_the_next_fades_in(self):
        sim = self.sim_server("wall")
        hand, file = self.touching_hand("recording.csv")
        sim.signal(signal.SIGKILL)
        self.sim_server("wall")
        time.sleep(0.8)
        self.assertEqual(hand.stop(), DONE, hand.lines())

        force_N = daemons.read_recording(file).force_norm_N()
        full = numpy.flatnonzero(force_N > 0.999 * FORCE_N)
        self.assertTrue((force_N[full[0]:full[-1]] == 0.0).any(), "silent when the scene changes")
        self.assertEqual(full[-1], len(force_N) - 1, "the force returns in full")
        self.assertLess(abs(numpy.diff(force_N)).max(), SMOOTH_N)

    def test_the_force_of_a_killed_simulation_fades_and_returns_with_the_next(self):
        sim = self.sim_server("wall")
        hand, file = self.touching_hand("recording.csv")
        sim.signal(signal.SIGKILL)
        time.sleep(0.6)
        self.assertTrue(hand.runs(), hand.lines())
        self.sim_server("wall")
        time.sleep(0.6)
        self.assertEqual(hand.stop(), DONE, hand.lines())

        recording = daemons.read_recording(file)
        time_s, force_N = recording["time_s"], recording.force_norm_N()
        full = force_N > 0.999 * FORCE_N
        gone = force_N == 0.0
        self.assertTrue(full.any() and full[-1], "the force returns in full")
        killed = numpy.flatnonzero(full[:-1] & ~full[1:])[0]  # the last tick in full
        faded = killed + numpy.flatnonzero(gone[killed:])[0]
        self.assertTrue((numpy.diff(force_N[killed:faded]) <= 0.0).all(), "it only falls")
        slack_s = 0.03
        self.assertLess(time_s[faded] - time_s[killed], FADE_S + slack_s)
        self.assertLess(recording["age_s"][faded], 2.5 * PERIOD_S + FADE_S + slack_s)
        self.assertLess(abs(numpy.diff(force_N)).max(), SMOOTH_N)
        self.assertGreater(gone[faded:].sum(), 200, "it stays away while there is no simulation")
        self.assertIn("faded", recording["flags"][faded])

    def test_a_killed_hand_does_not_stop_the_simulation_and_the_next_one_joins(self):
        report = self.folder / "sim.json"
        sim = self.sim_server("wall", "--report", report)
        hand, _ = self.touching_hand("first.csv")
        hand.signal(signal.SIGKILL)
        hand.wait()
        time.sleep(0.3)
        self.assertTrue(sim.runs(), sim.lines())
        hand, file = self.touching_hand("second.csv")
        self.assertEqual(hand.stop(), DONE, hand.lines())
        self.assertEqual(sim.stop(), DONE, sim.lines())
        recording = daemons.read_recording(file)
        force_N = recording.force_norm_N()
        self.assertGreater(force_N[-1], 0.999 * FORCE_N)
        self.assertLess(abs(numpy.diff(force_N)).max(), SMOOTH_N, "it ramps in")
        self.assertGreater(daemons.read_report(report)["steps"], 20)

    def test_a_simulation_killed_while_the_tool_is_in_the_tissue_fades_alike(self):
        sim = self.sim_server("tissue_and_blocks")
        file = self.folder / "recording.csv"
        device = ("phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,"
                  "period_s=1")
        hand = self.haptic_server(device, "--record", file)
        self.wait_until(lambda: file.exists() and self.is_touching(file), 5.0, "contact")
        sim.signal(signal.SIGKILL)
        time.sleep(0.4)
        self.assertEqual(hand.stop(), DONE, hand.lines())
        recording = daemons.read_recording(file)
        force_N = recording.force_norm_N()
        last_switch = numpy.flatnonzero(numpy.diff(recording["generation"]))[-1] + 1
        self.assertGreater(recording["contacts"][last_switch:].max(), 0, "touching when killed")
        self.assertTrue((force_N[-100:] == 0.0).all())
        # The rendered force may change as the hand moves on; the share that is told may not jump.
        rendered_N = numpy.linalg.norm(daemons.vectors(recording, "rendered_f", "N"), axis=1)
        pressed = rendered_N > 0.1
        told = numpy.where(pressed, force_N / numpy.maximum(rendered_N, 0.1), 0.0)
        change = abs(numpy.diff(told))[pressed[1:] & pressed[:-1]]
        self.assertLess(change.max(), 0.02)

    @staticmethod
    def is_touching(file):
        rows = file.read_text().splitlines()[3:-1]  # the last may not be whole
        return bool(rows) and float(rows[-1].split(",")[12]) > 0.5


if __name__ == "__main__":
    daemons.main()
