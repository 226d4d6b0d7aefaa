#!/usr/bin/python3
"""The option --passivity-control, and what the report says of energy with and without it."""
import unittest

import daemons

# Against the shipped wall of 1000 N/m: it buzzes from 600 N/m on.
BUZZING = ("phantom:hand=none,path=still,mass_kg=0.1,damping_N_s_per_m=0.3,friction_N=0,resolution_m=0,"
           "centre_z_m=0.005,push_z_N=-1,limits=0")


class PassivityTest(daemons.SessionTest):
    def press(self, *options):
        """The recording's last second, and the report."""
        report = self.folder / "report.json"
        file = self.run_lockstep("wall", BUZZING, 5.0, haptic=("--report", report, *options))
        recording = daemons.read_recording(file)
        return recording["z_m"][-1000:], recording["flags"], daemons.read_report(report)

    def test_a_wall_that_buzzes_is_quiet_with_passivity_control(self):
        z_m, _, report = self.press()
        buzz_m = z_m.max() - z_m.min()
        self.assertGreater(buzz_m, 1e-3)
        self.assertEqual(report["safety"]["passivity"], 0)
        self.assertEqual(report["energy"]["dissipated_by_control_J"], 0.0)
        self.assertAlmostEqual(report["energy"]["given_J"], report["energy_J"], 12)
        buzz_J = report["energy"]["most_given_J"]
        self.assertGreaterEqual(buzz_J, report["energy"]["given_J"])

        z_m, flags, report = self.press("--passivity-control", 0.1)
        self.assertLess(z_m.max() - z_m.min(), 0.1 * buzz_m)
        damped = sum("passivity" in flag.split("|") for flag in flags)
        self.assertGreater(damped, 0)
        self.assertEqual(report["safety"]["passivity"], damped)
        self.assertGreater(report["energy"]["dissipated_by_control_J"], 0.0)
        self.assertLess(report["energy"]["most_given_J"], 0.1 * buzz_J)

    def test_both_reports_tell_of_the_same_work(self):
        # Down through the gap between the blocks into the tissue and out again, before the last snapshot.
        hand = self.write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n0.35,0.003,0.002,-0.037\n0.8,-0.004,0,-0.039\n"
                                      "1.1,0,0,0\n9,0,0,0\n")
        reports = [self.folder / "haptic.json", self.folder / "sim.json"]
        self.run_lockstep("tissue_and_blocks", f"replay:file={hand}", 1.5, haptic=("--report", reports[0]),
                          sim=("--rate", 250, "--report", reports[1], "--latency", 0.003, "--jitter", 0.2))
        haptic, sim = (daemons.read_report(report) for report in reports)
        interface = haptic["interface"]
        self.assertGreater(abs(interface["booked_J"]), 1e-4)
        self.assertAlmostEqual(interface["booked_J"], sim["energy"]["tool_work_J"], 12)
        energy = sim["energy"]
        self.assertAlmostEqual(energy["given_J"], energy["tool_work_J"] + energy["proxies_J"], 12)
        self.assertLess(abs(energy["proxies_J"]), 0.05 * energy["tool_work_J"])
        self.assertAlmostEqual(interface["given_by_hand_J"], -haptic["energy"]["given_J"], 3)
        self.assertAlmostEqual(interface["made_J"], interface["booked_J"] + interface["held_J"] -
                               (interface["given_by_hand_J"] - interface["in_flight_J"]), 12)

    def test_a_mass_of_nothing_is_refused(self):
        self.assert_refused(self.haptic_server(BUZZING, "--passivity-control", 0),
                            daemons.BAD_INPUT, "--passivity-control")


if __name__ == "__main__":
    daemons.main()
