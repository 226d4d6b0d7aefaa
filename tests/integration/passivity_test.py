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

    def test_a_mass_of_nothing_is_refused(self):
        self.assert_refused(self.haptic_server(BUZZING, "--passivity-control", 0),
                            daemons.BAD_INPUT, "--passivity-control")


if __name__ == "__main__":
    daemons.main()
