#!/usr/bin/python3
"""A short run in real time. Gates on counts: a shared machine stalls now and then, so that one run of
three must be whole; a loop that is late by itself is late in each."""
import unittest

import daemons
from daemons import DONE

HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=1"


RUNS, WHOLE_TICKS, MOST_MISSED = 3, 2970, 30


class RealTimeTest(daemons.SessionTest):
    def run_once(self, files):
        sim_server = self.sim_server("tissue_and_blocks", "--report", files["sim.json"])
        haptic_server = self.haptic_server(HAND, "--duration", 3, "--report", files["haptic.json"],
                                           "--record", files["record.csv"])
        self.assertEqual(haptic_server.wait(15.0), DONE, haptic_server.lines())
        self.assertEqual(sim_server.stop(), DONE, sim_server.lines())
        return daemons.read_report(files["haptic.json"])

    def test_three_seconds_have_three_thousand_ticks_and_two_reports(self):
        files = {name: self.folder / name for name in ("sim.json", "haptic.json", "record.csv")}
        counts = []
        for _ in range(RUNS):
            haptic = self.run_once(files)
            counts.append((haptic["ticks"], haptic["missed_ticks"]))
            if counts[-1][0] >= WHOLE_TICKS and counts[-1][1] <= MOST_MISSED:
                break
        else:
            self.fail(f"no run of {RUNS} was whole, ticks and missed ones: {counts}")
        self.assertLessEqual(haptic["ticks"], 3102, "the force may fade after the end")
        self.assertEqual(haptic["rate_hz"], 1000.0)
        self.assertGreater(haptic["force_N"]["max"], 0.1)
        self.assertEqual(haptic["scene"], "tissue_and_blocks")
        recording = daemons.read_recording(files["record.csv"])
        self.assertEqual(len(recording["time_s"]) + haptic["lost_rows"], haptic["ticks"])

        sim = daemons.read_report(files["sim.json"])
        self.assertGreater(sim["steps"], 40)  # of 99
        self.assertEqual(sim["snapshots"], sim["steps"] + 1)
        self.assertEqual(sim["moving_spheres"], 405)


if __name__ == "__main__":
    daemons.main()
