#!/usr/bin/python3
"""An engine beside Stillgrid: what its response gives, and what the same ball does without."""
import random
import subprocess
import unittest

import numpy as np

import daemons

ENGINE = daemons.BUILD / "tests" / "integration" / "ball_engine"
LIMIT_N = 2.0  # the hand holds 1 cm of 0.5 N/mm against a floor half as stiff


class EngineTest(daemons.SessionTest):
    def press(self, period_s, mass_kg, given, seed, duration_s=8.3):
        """The 1 kHz force (ticks, 3) on a measured hand that strokes down to the ball, and back."""
        recording = self.folder / f"{given}-{seed}.csv"
        session = f"{self.session}-{seed}"
        engine = subprocess.Popen([str(word) for word in (ENGINE, session, period_s, mass_kg, given)],
                                  stderr=subprocess.PIPE, text=True)
        haptic_server = self.start(
            daemons.BUILD / "bin" / "haptic_server", "--session", session, "--lockstep", "--duration", duration_s,
            "--device", "phantom:profile=premium15,hand=measured,path=stroke,amplitude_m=0,period_s=2,"
            f"centre_x_m=0.001,centre_y_m=0.0004,centre_z_m=-0.007,depth_m=0.006,noise_m=1e-5,seed={seed}",
            "--record", recording)
        self.assertEqual(haptic_server.wait(), daemons.DONE, haptic_server.lines())
        self.assertEqual(engine.wait(30), 0, engine.stderr.read())
        engine.stderr.close()
        rows = daemons.read_recording(recording)
        return np.column_stack([rows[f"f{axis}_N"] for axis in "xyz"]), haptic_server.lines()

    def test_with_its_response_a_ball_of_any_weight_is_felt_at_any_rate(self):
        for seed in range(8):
            draw = random.Random(seed)
            period_s, mass_kg = 0.005 * 8 ** draw.random(), 0.01 * 50 ** draw.random()
            with self.subTest(seed=seed, period_s=period_s, mass_kg=mass_kg):
                force_N, _ = self.press(f"{period_s:.6f}", f"{mass_kg:.4f}", "response", seed)
                size_N = np.linalg.norm(force_N, axis=1)
                self.assertGreater(size_N.max(), 0.0)
                self.assertLess(size_N.max(), LIMIT_N)

    def test_without_it_a_ball_is_shown_by_its_snapshots(self):
        for seed in range(4):
            force_N, _ = self.press(0.02, 0.1, "nothing", seed, 4.3)
            size_N = np.linalg.norm(force_N, axis=1)
            self.assertGreater(size_N.max(), 0.0)
            self.assertLess(size_N.max(), LIMIT_N)


if __name__ == "__main__":
    unittest.main()
