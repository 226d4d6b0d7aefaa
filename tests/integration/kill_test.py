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
TICK_S = 1e-3
# A linear fade changes the force by this in a second; a stall longer than 50 ms may cut it at once.
FADE_N_PER_S = FORCE_N / FADE_S
STALL_S = 0.05
FADE_ROWS = 120  # and some more, at the end of a run


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
        self.wait_for_more(file)
        self.wait_for_full_force(file)
        self.assertEqual(hand.stop(), DONE, hand.lines())

        recording = daemons.read_recording(file)
        force_N = recording.force_norm_N()
        full = numpy.flatnonzero(force_N > 0.999 * FORCE_N)
        self.assertTrue((force_N[full[0]:full[-1]] == 0.0).any(), "silent when the scene changes")
        self.assertGreater(full[-1], len(force_N) - FADE_ROWS, "the force returns in full")
        self.assert_smooth(recording)

    def test_the_force_of_a_killed_simulation_fades_and_returns_with_the_next(self):
        sim = self.sim_server("wall")
        hand, file = self.touching_hand("recording.csv")
        sim.signal(signal.SIGKILL)
        time.sleep(0.6)
        self.assertTrue(hand.runs(), hand.lines())
        self.sim_server("wall")
        self.wait_for_full_force(file)
        self.assertEqual(hand.stop(), DONE, hand.lines())

        recording = daemons.read_recording(file)
        time_s, force_N = recording["time_s"], recording.force_norm_N()
        full = force_N > 0.999 * FORCE_N
        gone = force_N == 0.0
        self.assertTrue(full[-FADE_ROWS:].any(), "the force returns in full")
        first = numpy.flatnonzero(full)[0]
        faded = first + numpy.flatnonzero(gone[first:])[0]
        killed = numpy.flatnonzero(full[:faded])[-1]  # the last tick in full
        self.assertTrue((numpy.diff(force_N[killed:faded]) <= 0.0).all(), "it only falls")
        # Not later than the first tick after the fade's end, whenever the machine grants that tick.
        late_s = numpy.diff(time_s[:faded + 1]).max()
        self.assertLess(time_s[faded] - time_s[killed], FADE_S + 0.01 + late_s)
        self.assertLess(recording["age_s"][faded], 2.5 * PERIOD_S + FADE_S + 0.03 + 2 * late_s)
        self.assert_smooth(recording)
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
        self.wait_for_full_force(file)
        self.assertEqual(hand.stop(), DONE, hand.lines())
        self.assertEqual(sim.stop(), DONE, sim.lines())
        recording = daemons.read_recording(file)
        force_N = recording.force_norm_N()
        self.assertGreater(force_N[-FADE_ROWS:].max(), 0.999 * FORCE_N)
        self.assert_smooth(recording)
        self.assertGreater(daemons.read_report(report)["steps"], 20)

    @unittest.skipIf(daemons.SLOWNESS > 1, "skipped: instrumented, the tissue does not keep pace with the hand")
    def test_a_simulation_killed_while_the_tool_is_in_the_tissue_fades_alike(self):
        sim = self.sim_server("tissue_and_blocks")
        file = self.folder / "recording.csv"
        device = ("phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,"
                  "period_s=1")
        hand = self.haptic_server(device, "--record", file)
        self.wait_until(lambda: file.exists() and self.is_touching(file), 5.0, "contact")
        sim.signal(signal.SIGKILL)
        self.wait_for_more(file)
        self.assertEqual(hand.stop(), DONE, hand.lines())
        recording = daemons.read_recording(file)
        force_N = recording.force_norm_N()
        last_switch = numpy.flatnonzero(numpy.diff(recording["snapshot_id"]))[-1] + 1
        self.assertGreater(recording["contacts"][last_switch:].max(), 0, "touching when killed")
        self.assertTrue((force_N[-100:] == 0.0).all())
        # The rendered force may change as the hand moves on; the share that is told may not jump.
        rendered_N = numpy.linalg.norm(daemons.vectors(recording, "rendered_f", "N"), axis=1)
        pressed = rendered_N > 0.1
        told = numpy.where(pressed, force_N / numpy.maximum(rendered_N, 0.1), 0.0)
        passed_s = numpy.diff(recording["time_s"])
        change = abs(numpy.diff(told)) - passed_s / FADE_S
        only_faded = numpy.array([set(flags.split("|")) <= {"faded", "ramped", "", "swept", "contended"}
                                  for flags in recording["flags"]])
        judged = pressed & only_faded
        self.assertGreater(judged.sum(), 10)
        self.assertLess(change[judged[1:] & judged[:-1] & (passed_s < STALL_S)].max(), 0.01)

    def assert_smooth(self, recording):
        """The force changes no faster than a fade and the wall that lets the tool out, which are alike, but for what a
        stall cuts. The hand's copy lets the tool out in whole ticks."""
        passed_s = numpy.diff(recording["time_s"])
        change_N = abs(numpy.diff(recording.force_norm_N()))
        fastest_N = FADE_N_PER_S * (2.0 * passed_s + TICK_S)
        self.assertLess((change_N - fastest_N)[passed_s < STALL_S].max(), 1e-3 * FORCE_N)

    def wait_for_more(self, file):
        size = file.stat().st_size
        self.wait_until(lambda: file.stat().st_size > size + 100_000, 10.0, "half a second of rows")

    def wait_for_full_force(self, file):
        self.wait_until(lambda: self.force_was(file, FORCE_N), 5.0, "full force")

    @classmethod
    def force_was(cls, file, force_N, rows=1):
        """Whether all of the last rows on disk have this force."""
        last = cls.last_rows(file, rows)
        return len(last) == rows and all(
            abs(sum(float(row[i]) ** 2 for i in (7, 8, 9)) ** 0.5 - force_N) < 1e-3 for row in last)

    @classmethod
    def is_touching(cls, file):
        last = cls.last_rows(file, 1)
        return bool(last) and float(last[0][12]) > 0.5

    @staticmethod
    def last_rows(file, count):
        rows = file.read_text().splitlines()[:-1]  # the last may not be whole
        return [row.split(",") for row in rows[-count:] if row[0].isdigit()]


if __name__ == "__main__":
    daemons.main()
