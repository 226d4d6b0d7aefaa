#!/usr/bin/python3
"""What a stranger, or a broken machine, sends to the relays: none dies, and no hand is harmed."""
import subprocess
import sys
import time

import numpy

import relayed
from relayed import RelayedTest, daemons
from two_machines import ADDRESS

HOSTILE_RELAY = relayed.BUILD / "tests" / "hostile_relay"
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

    def start_relays_again(self, of_simulation=(), of_hand=()):
        """Once all have survived: a wrong sequence number of DDS itself ends a stream until its writer is another
        (docs/network.md)."""
        for program in self.sim, self.sim_relay, self.hand_relay, self.haptic:
            self.assertTrue(program.runs(), program.lines())
        for relay in self.sim_relay, self.hand_relay:
            self.assertEqual(relay.stop(), daemons.DONE, relay.lines())
        self.sim_relay, self.hand_relay = self.relay("simulation", *of_simulation), self.relay("hand", *of_hand)

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
        self.assertEqual(relayed.without_snapshot(recording, self.fade_s), 0)
        self.assertLessEqual(relayed.growth_N_per_ms(recording).max(), 1.001 * relayed.MAX_SLEW_N_PER_MS)

    def test_datagrams_that_no_relay_sends_kill_nobody(self):
        for seed in 1, 2:
            attackers = [self.attack(side, 2.0, 10 * seed + number) for number, side in enumerate("ab")]
            for attacker in attackers:
                sent, of_relay = map(int, attacker.communicate(timeout=30 * relayed.PATIENCE)[0].split())
                self.assertGreater(sent, 1000)
                self.assertGreater(of_relay, 500)
        self.start_relays_again()
        self.assert_unharmed()

    def test_a_link_that_flips_bits_in_a_fifth_of_all_packets_kills_nobody(self):
        self.bed.control("corrupt 0.2")
        time.sleep(4.0)
        self.bed.control("corrupt 0")
        self.start_relays_again()
        counters = self.bed.counters()
        self.assertGreater(counters["a"]["corrupted"] + counters["b"]["corrupted"], 500)
        self.assert_unharmed()

    def hostile_relay(self, side, kind, seconds, *arguments):
        """Of the other side's machine as far as anybody can tell; how many messages it sent."""
        program = self.bed.run(side, [HOSTILE_RELAY, kind, "--session", self.session, "--interface",
                                      relayed.INTERFACE, "--seconds", seconds, *arguments], stdout=subprocess.PIPE,
                               text=True)
        said, _ = program.communicate(timeout=30 * relayed.PATIENCE)
        self.assertEqual(program.returncode, daemons.DONE)
        return int(said)

    def test_a_relay_of_another_protocol_is_told_of_in_a_line_and_disturbs_nothing(self):
        for side, role, hears in (("a", 1, self.hand_relay), ("b", 2, self.sim_relay)):
            self.assertGreater(self.hostile_relay(side, "greeting", 2.0, "--role", role), 5)
            told = [line for line in hears.lines() if "protocol" in line]
            self.assertEqual(len(told), 1, hears.lines())
            self.assertRegex(told[0], r"of Stillgrid 99\.0\?\[2J and speaks protocol 99, this one \d+: run the same release")
        recording = self.assert_unharmed()
        self.assert_safe(recording)
        self.assertEqual((recording.force_norm_N()[2000:-300] == 0.0).sum(), 0, "nobody was disturbed")

    def test_a_relay_of_another_protocol_alone_makes_no_session(self):
        self.hand_relay.kill()
        self.sim_relay.kill()
        time.sleep(0.5)
        begun_s = time.monotonic()
        alone = self.relay("hand")
        self.hostile_relay("a", "greeting", 2.0)
        self.assertEqual(len(alone.lines()), 1, alone.lines())
        self.assertIn("speaks protocol 99", alone.lines()[0])
        self.assertIsNone(self.scene_watch.first_published(begun_s))  # what the killed one left stays as it is
        self.assertEqual(alone.stop(), daemons.DONE)

    def assert_told_of(self, report, *counters):
        told = daemons.read_report(report)
        self.assertGreater(sum(told[counter] for counter in counters), 0, told)

    def with_reports(self):
        """Both relays anew, with reports."""
        reports = self.folder / "sim_relay.json", self.folder / "hand_relay.json"
        self.start_relays_again(*[("--report", report) for report in reports])
        self.wait_for_return(time.monotonic())
        self.wait_until(self.is_felt, 10.0, "the whole force")
        return reports

    def test_samples_of_a_stranger_change_nothing(self):
        for side, seed in (("a", 3), ("b", 4)):
            self.assertGreater(self.hostile_relay(side, "samples", 2.0, "--seed", seed), 100)
        recording = self.assert_unharmed()
        self.assertEqual((recording.force_norm_N()[2000:-300] == 0.0).sum(), 0, "nobody was disturbed")

    def test_samples_in_the_name_of_a_relay_harm_nobody_and_are_counted(self):
        reports = self.with_reports()
        for side, seed in (("a", 5), ("b", 6)):
            self.assertGreater(self.hostile_relay(side, "samples", 3.0, "--seed", seed, "--steal"), 100)
        self.assert_unharmed()
        for report in reports:
            self.assert_told_of(report, "refused", "out_of_order", "repeated", "late")
        for report in reports:
            self.assertLess(daemons.read_report(report)["lost"], 2**53)


if __name__ == "__main__":
    daemons.main()
