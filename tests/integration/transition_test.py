#!/usr/bin/python3
"""What each transition costs, on a sphere that moves at a known speed towards a still tool."""
import unittest

import numpy

import daemons

# Of the scene moving_sphere.
PERIOD_S = 0.033
SPEED_M_S = 0.1
STIFFNESS_N_PER_M = 500.0
CONTACT_DISTANCE_M = 0.015  # radii of sphere and tool
START_M = -0.05
TOUCH_S, CENTRE_S = 0.35, 0.5
TOLERANCE = 1e-3  # relative


class TransitionTest(daemons.SessionTest):
    def with_penalty(self):
        """The scene with the contact of the paper, whose transitions are tried."""
        text = (daemons.SCENES / "moving_sphere.toml").read_text()
        file = self.folder / "moving_sphere.toml"
        file.write_text(text.replace("[tool]\n", '[tool]\ncontact = "penalty"\n').replace(
            'file = "', f'file = "{daemons.SCENES}/'))
        return file

    def record(self, transition=None, duration_s=0.6, sim=()):
        """None: the default."""
        file = self.run_lockstep(self.with_penalty(), self.still_device(0, 0, 0), duration_s, sim=sim,
                                 haptic=("--transition", transition) if transition else ())
        return daemons.read_recording(file)

    def test_hold_jumps_by_k_v_P_at_each_switch_and_is_still_between(self):
        recording = self.record("hold")
        time_s, force_N = recording["time_s"], recording["rendered_fx_N"]
        step_N = numpy.diff(force_N)
        # Touched both before and after, and not yet on the tool's other side.
        touching = (force_N[:-1] > 0.0) & (time_s[1:] < CENTRE_S)
        switching = numpy.diff(recording["snapshot_id"]) == 1
        jumps_N = step_N[touching & switching]
        self.assertEqual(len(jumps_N), 4)
        numpy.testing.assert_allclose(jumps_N, STIFFNESS_N_PER_M * SPEED_M_S * PERIOD_S,
                                      rtol=TOLERANCE)
        self.assertEqual(abs(step_N[~switching]).max(), 0.0)
        self.assertTrue((recording["alpha"] == 1.0).all())

    def test_linear_lags_by_v_P_and_does_not_jump(self):
        self.assert_even(self.record("linear"), PERIOD_S)

    def test_by_default_the_sphere_is_where_it_is_in_the_simulation_however_late_snapshots_come(self):
        for sim in ((), ("--jitter", 0.3, "--latency", 0.03)):
            self.assert_even(self.record(sim=sim), 0.0)

    def test_a_sphere_that_goes_to_a_place_and_stays_is_there_in_each_tick_however_late_snapshots_come(self):
        scene = self.with_penalty()
        moves = "{ time_s = 0.3, displacement_m = [0.04, 0, 0] }"
        scene.write_text(scene.read_text().replace("velocity_m_s = [0.1, 0.0, 0.0]", f"keyframes = [{moves}]"))
        for sim in ((), ("--jitter", 0.3, "--latency", 0.03)):
            recording = daemons.read_recording(
                self.run_lockstep(scene, self.still_device(0, 0, 0), 0.6, sim=sim))
            share = numpy.minimum(recording["time_s"] / 0.3, 1.0)
            sphere_m = START_M + 0.04 * share**2 * (3.0 - 2.0 * share)
            expected_N = STIFFNESS_N_PER_M * numpy.maximum(0.0, CONTACT_DISTANCE_M + sphere_m)
            self.assertAlmostEqual(expected_N[-1], 2.5)
            numpy.testing.assert_allclose(recording["rendered_fx_N"], expected_N, rtol=TOLERANCE, atol=1e-4)

    def assert_even(self, recording, lag_s):
        time_s, force_N = recording["time_s"], recording["rendered_fx_N"]
        touching = (time_s > TOUCH_S + lag_s + 1e-9) & (time_s < CENTRE_S + lag_s - 1e-9)
        displayed_m = force_N[touching] / STIFFNESS_N_PER_M - CONTACT_DISTANCE_M
        lag_m = START_M + SPEED_M_S * time_s[touching] - displayed_m
        numpy.testing.assert_allclose(lag_m, SPEED_M_S * lag_s, rtol=TOLERANCE, atol=1e-8)
        # What a smooth force changes in a tick of 1 ms.
        numpy.testing.assert_allclose(numpy.diff(force_N[touching]),
                                      STIFFNESS_N_PER_M * SPEED_M_S * 1e-3, rtol=TOLERANCE)

    def test_alpha_grows_from_zero_at_a_switch_to_one_a_period_later(self):
        recording = self.record("linear")
        since_switch = numpy.arange(len(recording["alpha"])) % 33
        shown = recording["snapshot_id"] > 1  # the first snapshot has none before it
        numpy.testing.assert_allclose(recording["alpha"][shown], since_switch[shown] / 33,
                                      atol=1e-9)

    def test_alpha_stays_at_one_when_a_snapshot_is_late(self):
        recording = self.record("linear", 3.0, sim=("--jitter", 0.3))
        time_s, alpha = recording["time_s"], recording["alpha"]
        late, switch_s = 0, {}
        for n in range(2, int(recording["snapshot_id"].max())):
            shown = recording["snapshot_id"] == n
            first, second = numpy.flatnonzero(shown)[:2]
            period_s = (time_s[second] - time_s[first]) / (alpha[second] - alpha[first])
            switch_s[n] = time_s[first] - alpha[first] * period_s
            # Without latency it is published at the end of the tick that it is of.
            self.assertTrue(-1e-9 <= switch_s[n] - (time_s[first] - recording["age_s"][first]) < 1e-3)
            if n > 2:
                self.assertAlmostEqual(period_s, switch_s[n] - switch_s[n - 1], delta=1e-9)
            expected = numpy.minimum((time_s[shown] - switch_s[n]) / period_s, 1.0)
            numpy.testing.assert_allclose(alpha[shown], expected, atol=1e-6)
            late += (expected == 1.0).sum()
        self.assertGreater(late, 50)

    def test_a_snapshot_that_waits_for_its_latency_is_older_by_it(self):
        recording = self.record("hold", sim=("--latency", 0.02))
        first_rows = numpy.flatnonzero(numpy.diff(recording["snapshot_id"]) == 1) + 1
        age_s = recording["age_s"][first_rows]
        self.assertGreaterEqual(age_s.min(), 0.02 - 1e-9)
        self.assertLess(age_s.max(), 0.021)


if __name__ == "__main__":
    daemons.main()
