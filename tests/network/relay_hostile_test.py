#!/usr/bin/python3
"""What a stranger, or a broken machine, sends to the relays: none dies, and no hand is harmed."""
import subprocess
import sys
import time

import numpy

import relayed
from relayed import RelayedTest, daemons
from two_machines import ADDRESS

SENDER = relayed.ROOT / "tests" / "network" / "hostile_datagrams.py"


class HostileTest(RelayedTest):
    def setUp(self):
        super().setUp()
        self.open_bed("delay_ms 2")
        self.start_session()

    def attack(self, side, seconds, seed):
        """Datagrams to the relay on the other side, from that one."""
        other = "b" if side == "a" else "a"
        return self.bed.run(side, [sys.executable, SENDER, ADDRESS[other], seconds, seed], stdout=subprocess.PIPE,
                            text=True)

    def assert_unharmed(self):
        """Nobody died, and the force that was felt in all of it kept the limits of a device and of a fade."""
        for program in self.sim, self.sim_relay, self.hand_relay, self.haptic:
            self.assertTrue(program.runs(), program.lines())
        self.wait_until(self.is_felt, 10.0, "the whole force afterwards")
        recording = self.stop_session()
        self.assert_within_limits(recording)
        return recording

    def assert_within_limits(self, recording):
        self.assertTrue(numpy.isfinite(recording.force_norm_N()).all())
        self.assertEqual(relayed.without_snapshot(recording, relayed.FADE_S), 0)
        self.assertLessEqual(relayed.growth_N_per_ms(recording).max(), 1.001 * relayed.MAX_SLEW_N_PER_MS)

    def test_datagrams_that_no_relay_sends_kill_nobody(self):
        for seed in 1, 2:
            attackers = [self.attack(side, 2.0, 10 * seed + number) for number, side in enumerate("ab")]
            for attacker in attackers:
                sent, of_relay = map(int, attacker.communicate(timeout=30 * relayed.PATIENCE)[0].split())
                self.assertGreater(sent, 1000)
                self.assertGreater(of_relay, 500)
        self.assert_unharmed()

    def test_a_link_that_flips_bits_in_a_fifth_of_all_packets_kills_nobody(self):
        self.bed.control("corrupt 0.2")
        time.sleep(4.0)
        self.bed.control("corrupt 0")
        counters = self.bed.counters()
        self.assertGreater(counters["a"]["corrupted"] + counters["b"]["corrupted"], 500)
        self.assert_unharmed()


if __name__ == "__main__":
    daemons.main()
