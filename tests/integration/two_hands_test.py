#!/usr/bin/python3
"""Several hands in one session: repeatable in lockstep, none touched by what becomes of another."""
import itertools
import signal
import time
import unittest

import daemons
import numpy
from daemons import BAD_INPUT, COULD_NOT_START, DONE, SCENES

HANDS = ("left", "right")
PROFILE = "phantom:profile=touchx,path="
# The scene of two hands and a wall for each, far from one another: what one does cannot reach the other.
APART = """format = 2
[world]
gravity_m_s2 = [0.0, 0.0, 0.0]
[simulation]
rate_hz = 60.0
[[hand]]
name = "left"
device = { position_m = [-1.0, 0.0, 0.0] }
[[hand]]
name = "right"
device = { position_m = [1.0, 0.0, 0.0] }
tool = { radius_m = 0.008 }
[[material]]
name = "soft"
contact_stiffness_N_per_m = 300.0
[[body]]
name = "left_ball"
kind = "sphere"
radius_m = 0.02
mass_kg = 0.1
position_m = [-1.0, 0.0, 0.0]
material = "soft"
[[body]]
name = "right_ball"
kind = "sphere"
radius_m = 0.02
mass_kg = 0.1
position_m = [1.0, 0.0, 0.0]
material = "soft"
"""
# Two hands press a free ball between them.
SQUEEZED = """format = 2
[world]
gravity_m_s2 = [0.0, 0.0, 0.0]
[simulation]
rate_hz = 33.0
integrator = "velocity_verlet"
[[hand]]
name = "left"
device = { position_m = [-0.05, 0.0, 0.0] }
tool = { radius_m = 0.008 }
[[hand]]
name = "right"
device = { position_m = [0.05, 0.0, 0.0] }
tool = { radius_m = 0.008 }
[[material]]
name = "m"
contact_stiffness_N_per_m = 500.0
contact_damping_N_s_per_m = 1.0
friction = 0.5
[[body]]
name = "ball"
kind = "sphere"
radius_m = 0.02
mass_kg = 0.1
material = "m"
"""


def path_of(scene, hand):
    return f"{PROFILE}{SCENES / f'{scene}.{hand}.csv'}"


class HandsTest(daemons.SessionTest):
    def hand(self, name, device, *arguments):
        return self.haptic_server(device, "--hand", name, *arguments)

    def run_hands(self, scene, devices, duration_s, sim=(), durations=None):
        """Lockstep to the end. The recordings by hand, as bytes, and the final state."""
        count = next(self.counter)
        sim_server = self.sim_server(scene, "--lockstep", "--duration", duration_s, "--final-state",
                                     self.folder / f"{count}.end.csv", "--report", self.report(count, "sim"),
                                     *sim)
        started = {}
        for name, device in devices.items():
            started[name] = self.hand(name, device, "--lockstep", "--duration",
                                      (durations or {}).get(name, duration_s), "--record",
                                      self.folder / f"{count}.{name}.csv", "--report", self.report(count, name))
        for name, daemon in started.items():
            self.assertEqual(daemon.wait(), DONE, (name, daemon.lines()))
        self.assertEqual(sim_server.wait(), DONE, sim_server.lines())
        self.last = count
        files = [*(f"{count}.{name}.csv" for name in devices), f"{count}.end.csv"]
        return [(self.folder / file).read_bytes() for file in files]

    def report(self, count, name):
        return self.folder / f"{count}.{name}.json"

    def setUp(self):
        super().setUp()
        self.counter = itertools.count(1)


class LockstepTest(HandsTest):
    def test_two_hands_in_lockstep_repeat_byte_for_byte(self):
        for scene in ("block_pinched", "cloth_held_by_two"):
            devices = {name: path_of(scene, name) for name in HANDS}
            sim = ("--rate", 250, "--jitter", 0.2, "--seed", 7, "--latency", 0.002)
            self.assertEqual(self.run_hands(scene, devices, 4.1, sim), self.run_hands(scene, devices, 4.1, sim),
                             scene)

    def test_what_one_hand_does_changes_no_byte_of_another_that_it_cannot_reach(self):
        scene = self.write("apart.toml", APART)
        still = {"left": "phantom:path=press,centre_z_m=0.01,depth_m=0.03", "right": "phantom:path=tap"}
        left, right, _ = self.run_hands(scene, still, 3.3)
        for device in ("phantom:path=circle,hand=measured", "phantom:path=press,centre_z_m=0.02,delay_ticks=3"):
            other_left, other_right, _ = self.run_hands(scene, {**still, "right": device}, 3.3)
            self.assertNotEqual(other_right, right)
            self.assertEqual(other_left, left)
        touched = daemons.read_report(self.report(self.last, "left"))
        self.assertGreater(touched["contact_ticks"], 20)

    def test_a_recording_of_each_hand_replayed_gives_the_same_forces(self):
        scene, seconds = "block_pinched", 4.1
        self.run_hands(scene, {name: path_of(scene, name) for name in HANDS}, seconds)
        first = {name: daemons.read_recording(self.folder / f"{self.last}.{name}.csv") for name in HANDS}
        frames = {"left": -0.07, "right": 0.07}  # of block_pinched: x of each device in the scene
        replays = {name: f"replay:file={self.folder}/{self.last}.{name}.csv,offset_x_m={-frames[name]},"
                         "offset_z_m=-0.038" for name in HANDS}
        self.run_hands(scene, replays, seconds)
        for name in HANDS:
            again = daemons.read_recording(self.folder / f"{self.last}.{name}.csv")
            apart = daemons.vectors(again, "rendered_f", "N") - daemons.vectors(first[name], "rendered_f", "N")
            self.assertLess(numpy.abs(apart).max(), 0.05)

    def test_a_hand_that_is_done_lets_the_others_go_on(self):
        scene = self.write("apart.toml", APART)
        devices = {name: "phantom:path=press,centre_z_m=0.01" for name in HANDS}
        self.run_hands(scene, devices, 2.0, durations={"left": 0.7})
        ticks = {name: daemons.read_report(self.report(self.last, name))["ticks"] for name in HANDS}
        self.assertEqual(ticks, {"left": 700, "right": 2000})

    def test_a_hand_that_dies_in_lockstep_ends_the_run_with_one_line(self):
        scene = self.write("apart.toml", APART)
        sim = self.sim_server(scene, "--lockstep")
        left, right = (self.hand(name, "phantom", "--lockstep") for name in HANDS)
        time.sleep(0.3)
        left.kill()
        self.assert_refused(sim, COULD_NOT_START, "haptic_server", "+left", "died")
        right.wait(5.0)

    def test_four_hands_share_a_session(self):
        names = ("a", "b_2", "c-3", "D")
        hands = "".join(f'[[hand]]\nname = "{name}"\n' for name in names)
        scene = self.write("four.toml", APART[:APART.index("[[hand]]")] + hands
                           + APART[APART.index("[[material]]"):])
        devices = {name: "phantom:path=press" for name in names}
        recordings = self.run_hands(scene, devices, 0.5)
        self.assertEqual(len(recordings), 5)
        self.assertEqual(len({recording for recording in recordings[:4]}), 1)
        hands = daemons.read_report(self.report(self.last, "sim"))["hands"]
        self.assertEqual([hand["name"] for hand in hands], list(names))


class ShippedScenesTest(HandsTest):
    """Laws of the scenes for two hands, over seeds and past the moment of interest."""

    SEEDS = range(1, 9)
    SECONDS = 16.3  # of which the hands' deed takes 10
    SCENES = {"block_pinched": 1e-5, "cloth_held_by_two": 1e-5}  # J that the method may err: contacts round to floats

    def runs(self, scene, seeds=SEEDS, device=""):
        for seed in seeds:
            devices = {name: f"{path_of(scene, name)},hand_mass_kg={0.083 + 0.009 * seed + 0.004 * i},"
                       f"hand_stiffness_N_per_m={247 + 19 * seed + 7 * i}{device}" for i, name in enumerate(HANDS)}
            self.run_hands(scene, devices, self.SECONDS, ("--jitter", 0.2, "--seed", seed))
            yield {name: daemons.read_report(self.report(self.last, name)) for name in ("sim", *HANDS)}

    def test_energy_of_the_block_is_accounted_and_no_limit_is_met(self):
        for reports in self.check_accounts("block_pinched"):
            self.assertLess(reports["sim"]["energy"]["kinetic_J"], 1e-5)

    def test_energy_of_the_cloth_is_accounted_and_no_limit_is_met(self):
        for _ in self.check_accounts("cloth_held_by_two"):
            pass

    def check_accounts(self, scene):
        for reports in self.runs(scene):
            sim = reports["sim"]
            energy = sim["energy"]
            self.assertLess(abs(energy["numerical_J"]), self.SCENES[scene], scene)
            self.assertAlmostEqual(sum(hand["tool_work_J"] for hand in sim["hands"]),
                                   energy["tool_work_J"], delta=1e-12)
            self.assertEqual(sim["solver"]["not_converged"], 0, scene)
            self.assertEqual(sim["crossings_left"], 0, scene)
            for name in HANDS:
                self.check_hand(reports[name], name, (scene, name))
            yield reports

    def check_hand(self, report, name, what):
        flags = {flag for flag, count in report["safety"].items() if count}
        self.assertLessEqual(flags, {"ramped"}, what)
        self.assertLess(report["force_N"]["max"], 1.75, what)  # what a touchx bears for long

    # The engine takes a sample of the tool each tick. The hand feels it later than a held force by that:
    # 3.2 mJ made, 2.2 mJ allowed, and with noise 18 and 7.3. Until both processes run one simulation.
    @unittest.expectedFailure
    def test_a_held_force_makes_no_more_than_its_change(self):
        for scene in self.SCENES:
            for reports in self.runs(scene):
                for name in HANDS:
                    self.check_made(reports[name]["interface"], name, (scene, name))

    def check_made(self, interface, name, what):
        """A force that is held for a tick and shown a tick late makes no more than its change along the motion."""
        recording = daemons.read_recording(self.folder / f"{self.last}.{name}.csv")
        changes_N = numpy.diff(daemons.vectors(recording, "rendered_f", "N"), axis=0)
        steps_m = numpy.diff(numpy.stack([recording[f"{axis}_m"] for axis in "xyz"], axis=1), axis=0)
        allowed_J = numpy.abs((changes_N * steps_m).sum(axis=1)).sum()
        self.assertLess(interface["made_J"], allowed_J, what)
        self.assertLess(interface["most_made_in_a_second_J"], allowed_J, what)

    def test_a_cloth_that_was_let_go_only_loses_energy(self):
        """Its dampers act along its springs: it swings on for long, like any cloth without air."""
        devices = {name: path_of("cloth_held_by_two", name) for name in HANDS}
        left_J = []
        for seconds in (11.3, 16.3, 31.3):
            self.run_hands("cloth_held_by_two", devices, seconds)
            energy = daemons.read_report(self.report(self.last, "sim"))["energy"]
            left_J.append(sum(energy[f"{part}_J"] for part in ("kinetic", "gravity", "springs", "contacts")))
        self.assertLess(left_J[1], left_J[0])
        self.assertLess(left_J[2], left_J[1])

    @unittest.expectedFailure
    def test_what_noise_of_the_positions_makes_is_told_apart(self):
        """At least half: the simulation's tool has the noise too, a tick later, which no hand's tick knows."""
        for reports in self.runs("block_pinched", self.SEEDS[::3], ",noise_m=1e-5"):
            for name in HANDS:
                interface = reports[name]["interface"]
                self.check_made(interface, name, name)
                self.assertGreater(interface["noise_J"], 0.5 * interface["made_J"])
                self.assertGreater(interface["made_J"], interface["noise_J"])

    def test_two_hands_bear_the_pinched_block(self):
        """Momentum: what the hands press cancels, what they bear is its weight, and it is off its stand."""
        weight_N = 0.05 * 9.81
        for _ in self.runs("block_pinched"):
            felt = [daemons.read_recording(self.folder / f"{self.last}.{name}.csv") for name in HANDS]
            held = (felt[0]["time_s"] > 4.3) & (felt[0]["time_s"] < 5.4)
            on_hands = sum(daemons.vectors(recording, "rendered_f", "N")[held].mean(0) for recording in felt)
            self.assertAlmostEqual(on_hands[0], 0.0, delta=0.02)
            self.assertAlmostEqual(on_hands[2], -weight_N, delta=0.05 * weight_N)
            pressed = daemons.vectors(felt[0], "rendered_f", "N")[held].mean(0)[0]
            self.assertLess(pressed, -0.2)


class LocalTest(HandsTest):
    """All hands step copies of the simulation: the default."""

    def felt(self, scene, devices, seconds, sim, durations=None):
        """What each hand did and felt, by column, as the recordings tell it."""
        self.run_hands(scene, devices, seconds, sim, durations)
        recordings = (daemons.read_recording(self.folder / f"{self.last}.{name}.csv") for name in devices)
        skipped = ("snapshot", "alpha", "age", "tick", "flags")
        return [{column: values for column, values in recording.columns.items() if not column.startswith(skipped)}
                for recording in recordings]

    def assert_equal(self, ours, theirs):
        for a, b in zip(ours, theirs, strict=True):
            self.assertEqual(a.keys(), b.keys())
            self.assertIn("rendered_fx_N", a)
            for column, values in a.items():
                numpy.testing.assert_array_equal(values, b[column], column)

    def test_two_hands_squeeze_a_free_ball_steadily_at_any_rate(self):
        scene = self.write("squeezed.toml", SQUEEZED)
        devices = {name: f"phantom:profile=premium15,hand=light,path=still,centre_x_m={x_m},centre_z_m=0"
                   for name, x_m in zip(HANDS, (0.03, -0.03))}
        seconds = 6.1
        often = self.felt(scene, devices, seconds, ("--rate", 100))
        seldom = self.felt(scene, devices, seconds, ("--rate", 10, "--jitter", 0.3, "--latency", 0.07))
        self.assert_equal(often, seldom)
        for felt, sign in zip(seldom, (-1.0, 1.0)):
            pressed_N = sign * felt["fx_N"][felt["time_s"] > 3.0]
            self.assertAlmostEqual(pressed_N.mean(), 1.48, delta=0.02)
            self.assertLess(numpy.ptp(pressed_N), 0.01 * 1.48)

    def test_the_shipped_scenes_feel_alike_at_1000_and_30_hz(self):
        for scene in ("block_pinched", "cloth_held_by_two"):
            devices = {name: path_of(scene, name) for name in HANDS}
            often, seldom = (self.felt(scene, devices, 6.3, ("--rate", rate)) for rate in (1000, 30))
            self.assert_equal(often, seldom)

    def test_a_hand_that_is_done_leaves_the_other_to_feel_alike(self):
        scene = self.write("squeezed.toml", SQUEEZED)
        devices = {name: f"phantom:profile=premium15,hand=light,path=still,centre_x_m={x_m},centre_z_m=0"
                   for name, x_m in zip(HANDS, (0.03, -0.03))}
        runs = [self.felt(scene, devices, 2.3, ("--rate", rate), {"left": 0.7}) for rate in (100, 10)]
        self.assert_equal(*runs)


class RefusalTest(HandsTest):
    def start_simulation(self, text):
        sim = self.sim_server(self.write("scene.toml", text))
        self.wait_until(lambda: any(daemons.SHM.glob(f"{self.session}*-scene")), 5.0, "a scene")
        return sim

    def test_a_scene_with_hands_wants_one_of_them(self):
        sim = self.start_simulation(APART)
        self.assert_refused(self.haptic_server("phantom"), COULD_NOT_START, "'left', 'right'", "--hand")
        self.assert_refused(self.hand("middle", "phantom"), COULD_NOT_START, "'left', 'right'", "'middle'")
        self.assertTrue(sim.runs())

    def test_a_scene_without_hands_wants_none(self):
        self.start_simulation((SCENES / "wall.toml").read_text().replace(
            '[hand]\nfile = "wall.hand.csv"\n', ""))
        self.assert_refused(self.hand("left", "phantom"), COULD_NOT_START, "without a name", "--hand")

    def test_a_session_has_one_simulation_whether_its_hands_have_names_or_not(self):
        self.start_simulation(APART)
        self.assert_refused(self.sim_server("wall"), COULD_NOT_START, self.session, "writer")

    def test_names_and_sessions_that_cannot_be_are_refused(self):
        for hand in ("", "a b", "x" * 17, "a+b", "a/b"):
            self.assert_refused(self.hand(hand, "phantom"), BAD_INPUT, "--hand", "1 to 16")
        self.session += "+left"
        self.assert_refused(self.haptic_server("phantom"), BAD_INPUT, "--session", "without a hand")


class RealTimeTest(HandsTest):
    def test_a_stopped_hand_is_nothing_to_the_other(self):
        sim, right = self.start_pair()
        left = self.hand("left", path_of("block_pinched", "left"))
        time.sleep(0.5)
        left.signal(signal.SIGSTOP)
        time.sleep(1.0)
        left.signal(signal.SIGCONT)
        left.stop()
        self.assert_untouched(sim, right)

    def start_pair(self):
        sim = self.sim_server("block_pinched")
        right = self.hand("right", path_of("block_pinched", "right"), "--report", self.report(0, "right"))
        return sim, right

    def assert_untouched(self, sim, right):
        self.assertTrue(sim.runs(), sim.lines())
        self.assertEqual(right.stop(), DONE, right.lines())
        self.assertEqual(right.lines(), [])
        report = daemons.read_report(self.report(0, "right"))
        flags = {flag for flag, count in report["safety"].items() if count}
        self.assertLessEqual(flags, {"ramped", "faded"})
        self.assertEqual(report["device_stops"], 0)


if __name__ == "__main__":
    daemons.main()
