#!/usr/bin/python3
"""A session whose simulation is on another machine: felt as one beside, over a good link and over a bad one."""
import json
import subprocess
import time

import numpy

import relayed
from relayed import BUILD, CLOCK_OFFSET_S, SCENES, RelayedTest, daemons

BAD_LINK = ("delay_ms 20", "jitter_ms 8", "loss 0.05", "duplicate 0.03", "reorder 0.02", "reorder_ms 10")
PRESSING = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=1"


class RelaySessionTest(RelayedTest):
    def inspect(self, side, kind):
        """The row of the segment on that side, noted in rows; an empty list where there is none."""
        listed = subprocess.run(self.bed.argv(side, [BUILD / "bin" / "segment_inspect", "--json", "--watch-s", "0"]),
                                capture_output=True, text=True, timeout=30 * relayed.PATIENCE, check=True).stdout
        rows = [row for row in json.loads(listed) if (row["session"], row["kind"]) == (self.session, kind)]
        self.rows.update({kind: row for row in rows})
        return rows

    def run_session(self, scene, device, *settings, seconds=4.0, awaits_tool=True):
        """Reports by name and the recording, of a session that runs to the hand's end."""
        self.open_bed(*settings)
        reports = {name: self.folder / f"{name}.json" for name in ("sim", "hand", "sim_relay", "hand_relay")}
        sim = self.sim_server(scene, "--report", reports["sim"])
        relays = (self.relay("simulation", "--report", reports["sim_relay"]),
                  self.relay("hand", "--report", reports["hand_relay"]))
        hand, file = self.hand(device, "--duration", seconds, "--report", reports["hand"])
        self.wait_until(lambda: file.exists() and file.stat().st_size > 200_000, 10.0, "a second of rows")
        self.rows = {}
        for side, kind in (("b", "scene"), ("a", "tool"))[:2 if awaits_tool else 1]:
            self.wait_until(lambda at=side, of=kind: self.inspect(at, of), 5.0, f"a {kind} over the link")
        self.assertEqual(hand.wait(), daemons.DONE, hand.lines())
        self.stop_all(*relays, sim)
        self.said = {"sim": sim.lines(), "hand": hand.lines()}
        return {name: daemons.read_report(file) for name, file in reports.items()}, daemons.read_recording(file)

    def test_a_scene_of_another_machine_is_felt_and_neither_server_knows(self):
        reports, recording = self.run_session("wall", None)
        self.assertEqual(self.said, {"sim": [], "hand": []})
        self.assert_safe(recording)
        self.assertGreater(numpy.median(recording.force_norm_N()), 0.999 * relayed.FORCE_N)
        self.assertEqual(reports["hand"]["device_stops"], 0)

    def test_the_other_clock_is_known_within_the_bound_that_is_told(self):
        reports, _ = self.run_session("wall", None, "a delay_ms 6", "b delay_ms 2")  # as bad as half a round trip
        for name, offset_s in (("sim_relay", CLOCK_OFFSET_S), ("hand_relay", -CLOCK_OFFSET_S)):
            told = reports[name]
            self.assertLessEqual(abs(told["clock_offset_s"] - offset_s), told["clock_bound_s"] + 1e-6, name)
            self.assertLess(told["clock_bound_s"], 0.5 * told["round_trip_s"] + 1e-3)
            self.assertGreaterEqual(told["round_trip_s"], 0.008)

    def test_both_sides_tell_how_what_they_read_came(self):
        reports, _ = self.run_session("wall", None, "delay_ms 3")
        for kind, offset_s in (("scene", -CLOCK_OFFSET_S), ("tool", CLOCK_OFFSET_S)):
            relay = self.rows[kind]["relay"]
            self.assertTrue(relay["connected"])
            self.assertAlmostEqual(1e-9 * relay["clock_offset_ns"], offset_s, delta=1e-9 * relay["clock_bound_ns"])
            self.assertGreater(relay["received"], 0)
        for server, relay in (("hand", "hand_relay"), ("sim", "sim_relay")):
            told = reports[server]["relay"]
            self.assertGreater(told["received"], 20, server)
            self.assertLessEqual(told["received"], reports[relay]["received"])

    def test_fewer_snapshots_a_second_are_felt_as_evenly(self):
        self.open_bed("delay_ms 2")
        self.start_session(of_simulation=("--rate", 5))
        time.sleep(2.0)
        recording = self.stop_session()
        force_N = recording.force_norm_N()[:-300]
        felt = force_N[numpy.argmax(force_N > 0.999 * relayed.FORCE_N):]
        self.assertGreater(len(felt), 1500)
        self.assertGreater(felt.min(), 0.999 * relayed.FORCE_N, "no pulse between two snapshots")
        self.assertLess(len(set(recording["snapshot_id"])), 6 * len(recording.time_s) / 1000)

    def test_samples_that_are_kept_back_are_led_on(self):
        self.open_bed("delay_ms 2")
        report = self.folder / "hand_relay.json"
        self.start_session(self.wall_without_model(), of_hand=("--deadband", 0.07, "--report", report))
        began_s = time.monotonic()
        time.sleep(2.0)
        states = [change for change in self.tool_watch.changes if change[0] > began_s]
        self.assert_safe(self.stop_session())
        told = daemons.read_report(report)
        self.assertGreater(told["withheld"], 10 * told["sent"], "a still hand has little to say")
        # Every 2 ms it is looked at the simulation's tool has gone on.
        self.assertGreater(len(states), 500)

    def test_a_scene_is_stepped_at_the_hand_too(self):
        """The local copy goes on in each tick once it has caught up; lost packets do not replace it."""
        reports, recording = self.run_session("tissue_and_blocks", PRESSING, "delay_ms 20", "jitter_ms 2", "loss 0.01")
        self.assert_safe(recording)
        hand = reports["hand"]
        self.assertGreater(hand["local"]["ticks"], 0.8 * hand["ticks"])
        self.assertLess(hand["local"]["swaps"], 5)
        self.assertGreater(hand["contact_ticks"], 500)

    def test_the_local_copy_goes_on_while_the_link_is_cut_for_less_than_a_second(self):
        self.open_bed("delay_ms 5")
        self.start_session()
        self.bed.control("partition on")
        time.sleep(0.6)
        self.bed.control("partition off")
        self.wait_for_return(time.monotonic())
        recording = self.stop_session()
        self.assert_safe(recording)
        self.assertGreater(relayed.silences_s(recording).max(), 0.5)
        force_N = recording.force_norm_N()[:-300]
        self.assertGreater(force_N[numpy.argmax(force_N > 0.999 * relayed.FORCE_N):].min(), 0.999 * relayed.FORCE_N)

    def test_the_energy_of_a_hand_that_presses_is_booked_on_both_sides_and_joins(self):
        """The simulation books what the tool gave its scene, the hand's server what the hand gave the tool: their
        difference is told, and is small beside what went to and fro."""
        reports, recording = self.run_session("tissue_and_blocks", PRESSING, "delay_ms 5")
        self.assert_safe(recording)
        self.assertGreater(reports["hand"]["contact_ticks"], 500)
        interface = reports["hand"]["interface"]
        self.assertIsNotNone(interface["made_J"])
        self.assertNotEqual(interface["booked_J"], 0.0)
        went_J = numpy.abs(numpy.diff(recording.position_m, axis=0) * recording.force_N[1:]).sum()
        self.assertLess(abs(interface["made_J"]), went_J)

    def test_over_a_bad_link_nothing_older_is_shown_and_the_session_goes_on(self):
        reports, recording = self.run_session("moving_sphere", self.still_device(0, 0, 0), *BAD_LINK)
        self.assertEqual(self.said, {"sim": [], "hand": []})
        self.assert_safe(recording)
        hand, hand_relay, sim_relay = (reports[name] for name in ("hand", "hand_relay", "sim_relay"))
        self.assertLessEqual(hand["contended"], 0.01 * hand["ticks"])
        self.assertGreater(hand["snapshots"], 60)  # of 120
        self.assertGreater(len(set(recording["snapshot_id"])), 60)
        self.assertGreater(sim_relay["lost"], 0)  # DDS itself drops what is repeated, and what was overtaken
        self.assertGreater(sim_relay["received"], 0.7 * hand_relay["sent"])
        self.assertLess(sim_relay["lost"], 0.3 * hand_relay["sent"])
        counters = self.bed.counters()
        for side in "ab":
            self.assertGreater(counters[side]["lost"], 0)

    def test_over_a_link_that_also_corrupts_nothing_older_is_shown(self):
        """It need not go on: a flipped bit in a sequence number of DDS itself ends a stream (relay_hostile_test)."""
        reports, recording = self.run_session("moving_sphere", self.still_device(0, 0, 0), *BAD_LINK, "corrupt 0.02",
                                              awaits_tool=False)
        self.assertEqual(self.said, {"sim": [], "hand": []})
        self.assert_safe(recording)
        self.assertLess(reports["sim_relay"]["lost"], 2**17 * 10)
        counters = self.bed.counters()
        self.assertGreater(counters["a"]["corrupted"] + counters["b"]["corrupted"], 20)


if __name__ == "__main__":
    daemons.main()
