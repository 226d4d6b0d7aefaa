#!/usr/bin/python3
"""What the laboratory runs in one process is what the two daemons do."""
import subprocess
import unittest

import daemons

# A device in the measured hand, as the laboratory's own: encoders, friction, a push of 1 N.
DEVICE = ("phantom:profile=premium15,path=still,centre_z_m=0,push_z_N=-1,mass_kg=0.1,"
          "damping_N_s_per_m=1,hand=measured,friction_N=0.02")
DURATION_S, PERIOD_S = 2.0, 0.033
LATENCY_SHARE, JITTER, SEED = 0.3, 0.3, 7


def rows(file):
    """The whole: what it is of stands beside it, and the daemon tells more of its device there."""
    return file.read_bytes()


class StabilityLabTest(daemons.SessionTest):
    def lab(self, *arguments):
        program = daemons.BUILD / "bin" / "stability_lab"
        return subprocess.run([program, *map(str, arguments)], check=True, text=True,
                              capture_output=True, timeout=60 * daemons.PATIENCE).stdout

    def assert_same_as_daemons(self, body, transition):
        text = self.lab("scene", "--scene", body, "--period", PERIOD_S, "--stiffness",
                        1500)
        scene = self.write("lab.toml", text)
        recording = self.folder / "lab.csv"
        self.lab("run", "--scene", scene, "--device", DEVICE, "--transition", transition, "--period",
                 PERIOD_S, "--latency", LATENCY_SHARE, "--jitter", JITTER, "--seed", SEED,
                 "--duration", DURATION_S, "--record", recording)
        sim = ("--latency", LATENCY_SHARE * PERIOD_S, "--jitter", JITTER, "--seed", SEED)
        daemons_recording = self.run_lockstep(scene, DEVICE, DURATION_S, sim=sim,
                                              haptic=("--transition", transition))
        contacts = daemons.read_recording(recording)["contacts"]
        self.assertGreater(contacts.mean(), 0.5, "the tool touched too little")
        self.assertEqual(rows(recording), rows(daemons_recording))

    def test_late_and_jittery_snapshots_of_a_free_body_give_the_same_bytes(self):
        self.assert_same_as_daemons("free:0.1", "linear")

    def test_late_and_jittery_snapshots_of_a_chain_give_the_same_bytes(self):
        self.assert_same_as_daemons("chain", "local")


if __name__ == "__main__":
    daemons.main()
