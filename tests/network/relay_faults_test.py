#!/usr/bin/python3
"""What breaks between two machines is felt as a simulation that was killed: the force fades, and comes back."""
import signal
import time

import numpy

import relayed
from relayed import FADE_S, PATIENCE, RelayedTest, daemons

LONGEST_RETURN_S = 1.0  # from when the cause is over to the first snapshot, as far as the machine keeps time
TOOL_STAYS_S = 0.25  # the tool's segment beside the simulation, after the last sample


class SnapshotsTest(RelayedTest):
    """A hand that is shown snapshots alone, so that its force fades soon after the last."""
    fade_s = FADE_S

    def scene(self):
        return self.wall_without_model()


class PartitionTest(SnapshotsTest):
    """A still hand on a wall, felt over a link of 5 ms that is cut for a while."""

    def cut(self, seconds):
        """Recording; s from the cut's end to the first snapshot, and to the first tool sample."""
        self.open_bed("delay_ms 5")
        self.start_session()
        self.bed.control("partition on")
        self.cut_s = time.monotonic()
        time.sleep(seconds)
        self.bed.control("partition off")
        mended_s = time.monotonic()
        returns_s = self.wait_for_return(mended_s), self.wait_for_return(mended_s, self.tool_watch)
        self.wait_until(self.is_felt, 5.0, "the whole force")
        return self.stop_session(), *returns_s

    def assert_faded_and_returned(self, seconds):
        recording, *returns_s = self.cut(seconds)
        self.assert_safe(recording)
        self.assert_returned(recording)
        silent_s = relayed.silences_s(recording).max()
        self.assertGreater(silent_s, seconds - 0.1)
        force_N = recording.force_norm_N()
        old = relayed.since_snapshot_s(recording) > FADE_S + 0.02
        self.assertTrue(old.any())
        self.assertEqual(force_N[old].max(), 0.0)
        gone_s = self.tool_watch.first_absent(self.cut_s)
        self.assertIsNotNone(gone_s, "the tool beside the simulation ends")
        self.assertLess(gone_s - self.cut_s, TOOL_STAYS_S + 0.1 * PATIENCE)
        for return_s in returns_s:
            self.assertLess(return_s, LONGEST_RETURN_S * PATIENCE)

    def test_a_link_that_is_cut_for_a_fifth_of_a_second_lets_the_force_fade_and_return(self):
        recording, return_s, _ = self.cut(0.2)
        self.assert_safe(recording)
        self.assert_returned(recording)
        self.assertLess(return_s, LONGEST_RETURN_S * PATIENCE)
        self.assertLess(recording.force_norm_N()[relayed.since_snapshot_s(recording) > FADE_S - 0.03].max(initial=0.0),
                        0.5 * relayed.FORCE_N)

    def test_a_link_that_loses_all_of_the_hand_alone_takes_the_force_away(self):
        """The simulation then has no tool, and would be pressed without giving way."""
        self.open_bed("delay_ms 5")
        self.start_session()
        self.bed.control("b partition on")
        time.sleep(2.5)
        self.bed.control("b partition off")
        self.wait_until(self.is_felt, 5.0, "the whole force")
        recording = self.stop_session()
        self.assert_safe(recording)
        self.assert_returned(recording)
        self.assertGreater((recording.force_norm_N()[:-300] == 0.0).sum(), 800)
        self.assertEqual(len([line for line in self.hand_relay.lines() if "hears nothing" in line]), 1)

    def test_a_link_that_is_cut_for_a_second_takes_force_and_tool_away_and_gives_them_back(self):
        self.assert_faded_and_returned(1.0)

    def test_a_link_that_is_cut_for_three_seconds_takes_force_and_tool_away_and_gives_them_back(self):
        self.assert_faded_and_returned(3.0)

    def test_a_link_that_is_cut_for_longer_than_the_middleware_remembers_comes_back(self):
        self.assert_faded_and_returned(12.0)  # a lease of DDS is 10 s

    def test_a_link_that_is_cut_one_way_only_is_cut(self):
        """What the hand sends gets through: it feels nothing all the same."""
        self.open_bed()
        self.start_session()
        self.bed.control("a partition on")
        time.sleep(0.6)
        self.assertEqual(relayed.last_force_N(self.recording_file), 0.0)
        self.bed.control("a partition off")
        self.assertLess(self.wait_for_return(time.monotonic()), LONGEST_RETURN_S * PATIENCE)
        self.wait_until(self.is_felt, 5.0, "the whole force")
        self.assert_safe(self.stop_session())


class KillTest(SnapshotsTest):
    """A still hand on a wall, felt over a link of 2 ms while one program or another is killed."""

    def setUp(self):
        super().setUp()
        self.open_bed("delay_ms 2")
        self.start_session()

    def assert_goes_on(self, since_s, watch=None):
        """Something is published anew in time, and a force felt in full."""
        self.assertLess(self.wait_for_return(since_s, watch), LONGEST_RETURN_S * PATIENCE)
        self.wait_until(self.is_felt, 5.0, "the whole force")

    def assert_faded(self, recording):
        self.assert_safe(recording)
        self.assert_returned(recording)
        felt = numpy.flatnonzero(recording.force_norm_N() > 0.999 * relayed.FORCE_N)
        self.assertTrue((recording.force_norm_N()[felt[0]:felt[-1]] == 0.0).any(), "silent in between")

    def replace(self, killed, begin):
        """Kills, waits until the force is gone, and starts anew; when that was, s."""
        killed.kill()
        time.sleep(FADE_S + 0.1)
        self.wait_until(lambda: relayed.last_force_N(self.recording_file) == 0.0, 2.0, "no force")
        begun_s = time.monotonic()
        return begin(), begun_s

    def test_a_relay_beside_the_hand_that_is_killed_and_started_again_goes_on(self):
        self.hand_relay, begun_s = self.replace(self.hand_relay, lambda: self.relay("hand"))
        self.assert_goes_on(begun_s)
        self.assert_faded(self.stop_session())

    def test_a_relay_beside_the_simulation_that_is_killed_and_started_again_goes_on(self):
        self.sim_relay, begun_s = self.replace(self.sim_relay, lambda: self.relay("simulation"))
        self.assert_goes_on(begun_s)
        self.assert_faded(self.stop_session())

    def test_both_relays_that_are_killed_at_once_and_started_again_go_on(self):
        self.hand_relay.kill()
        self.sim_relay, begun_s = self.replace(self.sim_relay, lambda: self.relay("simulation"))
        self.hand_relay = self.relay("hand")
        self.assert_goes_on(begun_s)
        self.assert_faded(self.stop_session())

    def test_a_relay_that_is_replaced_at_once_is_taken_up(self):
        before = len(self.hand_relay.lines())
        self.sim_relay.kill()
        self.sim_relay = self.relay("simulation")
        self.wait_until(lambda: any("takes over" in line for line in self.hand_relay.lines()[before:]), 5.0,
                        "the next relay")
        self.assert_goes_on(time.monotonic())
        self.assertEqual(sum("takes over" in line for line in self.hand_relay.lines()[before:]), 1,
                         self.hand_relay.lines())
        self.assert_safe(self.stop_session())

    def test_a_simulation_that_is_killed_takes_its_scene_along_and_the_next_is_another(self):
        self.sim.kill()
        killed_s = time.monotonic()
        self.wait_until(lambda: self.scene_watch.first_absent(killed_s), 2.0, "no scene beside the hand")
        self.assertLess(self.scene_watch.first_absent(killed_s) - killed_s, 0.2 * PATIENCE)
        time.sleep(FADE_S + 0.1)
        self.assertEqual(relayed.last_force_N(self.recording_file), 0.0)
        begun_s = time.monotonic()
        self.sim = self.sim_server()
        self.assert_goes_on(begun_s)
        epochs = [epoch for epoch in self.scene_watch.epochs() if epoch]
        self.assertEqual(len(epochs), 2, epochs)
        self.assert_faded(self.stop_session())

    def test_a_simulation_that_ends_takes_its_scene_along(self):
        self.assertEqual(self.sim.stop(), daemons.DONE)
        ended_s = time.monotonic()
        self.wait_until(lambda: self.scene_watch.first_absent(ended_s), 2.0, "no scene beside the hand")
        self.sim = self.sim_server()
        self.assert_goes_on(time.monotonic())
        self.assert_faded(self.stop_session())

    def test_a_hand_that_is_killed_takes_its_tool_along_and_the_next_joins(self):
        first = daemons.read_recording(self.recording_file)
        self.haptic.kill()
        killed_s = time.monotonic()
        self.wait_until(lambda: self.tool_watch.first_absent(killed_s), 2.0, "no tool beside the simulation")
        self.haptic, self.recording_file = self.hand()
        self.assert_goes_on(killed_s, self.tool_watch)
        self.assertEqual(len([epoch for epoch in self.tool_watch.epochs() if epoch]), 2)
        self.assert_safe(first)
        recording = self.stop_session()
        self.assert_safe(recording)
        self.assert_returned(recording)

    def test_both_servers_that_are_killed_at_once_and_started_again_go_on(self):
        self.haptic.kill()
        self.sim.kill()
        self.sim = self.sim_server()
        self.haptic, self.recording_file = self.hand()
        self.assert_goes_on(time.monotonic())
        recording = self.stop_session()
        self.assert_safe(recording)
        self.assert_returned(recording)

    def test_a_relay_that_is_stopped_for_a_second_is_a_cut_of_a_second(self):
        for relay in self.sim_relay, self.hand_relay:
            relay.signal(signal.SIGSTOP)
            time.sleep(1.0)
            self.assertEqual(relayed.last_force_N(self.recording_file), 0.0)
            relay.signal(signal.SIGCONT)
            self.assert_goes_on(time.monotonic())
        self.assert_faded(self.stop_session())


class SecondRelayTest(SnapshotsTest):
    """Two relays of a side would carry one session."""

    def setUp(self):
        super().setUp()
        self.open_bed("delay_ms 2")
        self.start_session()

    def elsewhere(self, side, *arguments):
        """A program on that side with a shared memory of its own, as another machine at the same address has."""
        own = 'mount -t tmpfs tmpfs /dev/shm && exec "$@"'
        return self.start(*self.bed.argv(side, ["unshare", "--mount", "sh", "-c", own, "sh", *arguments]))

    def relay_elsewhere(self, role):
        side = "a" if role == "simulation" else "b"
        return self.elsewhere(side, relayed.BUILD / "bin" / "scene_relay", role, "--session", self.session,
                              "--interface", relayed.INTERFACE, "--open")

    def assert_told_once(self, relay, *words):
        told = [line for line in relay.lines() if all(word in line for word in words)]
        self.assertEqual(len(told), 1, relay.lines())

    def assert_first_is_kept_to(self, first, second, hears):
        """first, second: of one side; hears: the relay of the other."""
        self.wait_until(lambda: any("two relays" in line for line in hears.lines()), 5.0, "a line on two relays")
        time.sleep(0.5)
        self.assertTrue(self.is_felt())
        self.assert_told_once(hears, "two relays", self.session)
        self.assert_told_once(second, "keeps to another")
        first.kill()

    def test_of_two_simulations_the_first_is_felt_until_it_dies(self):
        self.elsewhere_sim = self.relay_elsewhere("simulation")
        self.assert_first_is_kept_to(self.sim_relay, self.elsewhere_sim, self.hand_relay)
        self.wait_until(lambda: any("takes over" in line for line in self.hand_relay.lines()), 5.0, "the second")
        self.assert_told_once(self.hand_relay, "takes over")
        self.wait_until(lambda: self.scene_watch.look()[0] == 0, 5.0, "no scene, for it has none")
        self.stop_all(self.haptic, self.hand_relay, self.elsewhere_sim, self.sim)
        self.assert_safe(daemons.read_recording(self.recording_file))

    def test_of_two_hands_the_first_is_heard_until_it_dies(self):
        second = self.relay_elsewhere("hand")
        self.assert_first_is_kept_to(self.hand_relay, second, self.sim_relay)
        self.wait_until(lambda: any("takes over" in line for line in self.sim_relay.lines()), 5.0, "the second")
        self.assert_told_once(self.sim_relay, "takes over")
        self.wait_until(lambda: self.tool_watch.look()[0] == 0, 5.0, "no tool, for it has none")
        self.stop_all(self.haptic, second, self.sim_relay, self.sim)
        self.assert_safe(daemons.read_recording(self.recording_file))

    def test_a_second_relay_on_one_machine_is_refused_in_a_line(self):
        second = self.relay("hand")
        self.assertEqual(second.wait(5.0), daemons.COULD_NOT_START, second.lines())
        self.assertEqual(len(second.lines()), 1, second.lines())
        self.assertIn(self.session, second.lines()[0])
        self.assertTrue(self.is_felt())
        self.assert_safe(self.stop_session())


if __name__ == "__main__":
    daemons.main()
