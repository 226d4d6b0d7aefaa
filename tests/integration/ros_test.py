#!/usr/bin/python3
"""What scene_relay ros publishes is what a ROS 2 node would, as a second implementation of DDS hears it."""
import hashlib
import json
import os
import re
import signal
import subprocess
import time
import unittest

import daemons
import numpy
from daemons import BAD_INPUT, BUILD, DONE, ROOT, SCENES

RELAY = BUILD / "bin" / "scene_relay"
SUBSCRIBER = BUILD / "tests" / "network" / "ros_subscriber_fastdds"
PAGE = ROOT / "docs" / "ros.md"
IDL = ROOT / "proto" / "ros" / "geometry_msgs.idl"
PROFILES = ("default", "sensor_data")
WALL_HAND = f"replay:loop=1,file={SCENES / 'wall.hand.csv'}"
NEAR_S = 4e-4  # of the tick that is meant; most others are a millisecond away
WRENCH = 6  # numbers: a force and a torque
# REP 2016: numbers of the types that a field has.
TYPE_IDS = {"long": 6, "unsigned long": 7, "double": 11, "string": 17}


def ros_type(name):
    """geometry_msgs::msg::dds_::Pose_ as ROS says it: geometry_msgs/msg/Pose."""
    return name.removesuffix("_").replace("::dds_::", "/").replace("::", "/")


def idl_types():
    """Fields of every type of our IDL: [(name, type), ...] by the type's name in ROS."""
    types, module = {}, ""
    text = re.sub(r"//.*", "", IDL.read_text())
    for begin in re.finditer(r"module (\w+) \{ module (\w+) \{|struct (\w+)_ \{([^}]*)\}", text):
        if begin[1]:
            module = f"{begin[1]}/{begin[2]}"
        else:
            fields = re.findall(r"([\w:]+(?: \w+)?) (\w+)_;", begin[4])
            types[f"{module}/{begin[3]}"] = [(name, kind) for kind, name in fields]
    return types


def type_hash(name, types):
    """As rosidl computes it: SHA-256 of the type and of all it is made of, as JSON in one fixed form."""
    def describe(of):
        return {"type_name": of, "fields": [
            {"name": field, "type": {"type_id": TYPE_IDS.get(kind, 1), "capacity": 0, "string_capacity": 0,
                                     "nested_type_name": "" if kind in TYPE_IDS else ros_type(kind)}}
            for field, kind in types[of]]}

    def parts(of):
        direct = {ros_type(kind) for _, kind in types[of] if kind not in TYPE_IDS}
        return direct.union(*(parts(part) for part in direct))
    whole = {"type_description": describe(name), "referenced_type_descriptions": [*map(describe, sorted(parts(name)))]}
    return "RIHS01_" + hashlib.sha256(json.dumps(whole).encode()).hexdigest()


class Subscriber:
    """The other implementation, with a profile of ROS 2, on the loopback as our page says. Its lines are kept in a file."""

    def __init__(self, file, domain, space, profile):
        self.file = file
        network = file.with_suffix(".xml")
        network.write_text(re.search(r"```xml\n(.*?)```", PAGE.read_text(), re.S)[1])
        with open(file, "w") as stdout:
            self.process = subprocess.Popen(
                ["setpriv", "--pdeathsig", "KILL", SUBSCRIBER, str(domain), profile,
                 f"rt{space}/tool_pose", f"rt{space}/tool_wrench"], stdin=subprocess.DEVNULL, stdout=stdout,
                env={**os.environ, "FASTRTPS_DEFAULT_PROFILES_FILE": str(network)})

    def messages(self, kind):
        lines = [line for line in self.file.read_text().split("\n")[:-1] if f'"kind": "{kind}"' in line]
        return [json.loads(line) for line in lines]

    def count(self, kind="pose"):
        return self.file.read_text().count(f'"kind": "{kind}"')

    def stop(self):
        self.process.terminate()
        self.process.wait(10 * daemons.PATIENCE)

    def kill(self):
        self.process.kill()
        self.process.wait()


def stamps_s(messages):
    return numpy.array([message["stamp"][0] + message["stamp"][1] * 1e-9 for message in messages])


def values(messages):
    return numpy.array([message["values"] for message in messages])


def moves(messages, count):
    """Whether each of the first so many of their numbers does."""
    return bool((numpy.ptp(values(messages)[:, :count], axis=0) > 1e-4).all())


@unittest.skipUnless(SUBSCRIBER.exists(), "no Fast DDS 2 (libfastrtps-dev): its subscriber was not built")
class RosTest(daemons.SessionTest):
    domains = 0

    def setUp(self):
        super().setUp()
        self.first_session = self.session = self.session.replace("-", "_")
        RosTest.domains += 1
        self.domain = 1 + (os.getpid() * 7 + RosTest.domains) % 200
        self.space = f"/stillgrid/{self.session}"
        self.subscribers = 0

    def relay(self, *arguments):
        return self.start(RELAY, "ros", "--session", self.session, "--domain", self.domain, *arguments)

    def subscriber(self, profile="default", space=None):
        self.subscribers += 1
        made = Subscriber(self.folder / f"{self.subscribers}.messages", self.domain, space or self.space, profile)
        self.addCleanup(made.kill)
        return made

    def wait_for(self, subscriber, count, what="messages"):
        self.wait_until(lambda: min(map(subscriber.count, ("pose", "wrench"))) >= count, 20.0, what)

    def wait_for_a_force(self, subscriber, sim):
        """A busy machine may have simulated nothing yet that is felt."""
        def is_felt():
            self.assertTrue(sim.runs(), sim.lines())
            time.sleep(0.3)  # it reads all that came
            return moves(subscriber.messages("wrench"), WRENCH)
        self.wait_until(is_felt, 20.0, "a force")

    def note_a_tick(self):
        """Number and wall time of some tick, by the segment and the two clocks."""
        shown = subprocess.run([BUILD / "bin" / "segment_inspect", "--session", self.session, "--json"],
                               capture_output=True, check=True)
        state = json.loads(shown.stdout)["tool"]["latest_state"]
        return state["tick"], state["time_ns"] * 1e-9 + time.time() - time.monotonic()

    def assert_recorded(self, subscriber, recording, noted):
        """Every message is a tick of the recording: its pose, what it did to the hand, and when."""
        tick, wall_s = noted
        start_s = wall_s - recording["time_s"][tick - 1]
        poses = numpy.hstack([daemons.vectors(recording, "", "m"),
                              numpy.stack([recording[f"q{axis}"] for axis in "xyzw"], axis=1)])
        wrenches = numpy.hstack([daemons.vectors(recording, "f", "N"), daemons.vectors(recording, "t", "N_m")])
        wrenches = numpy.vstack([numpy.zeros(6), wrenches[:-1]])  # over the tick before
        for kind, expected, moving in (("pose", poses, 5), ("wrench", wrenches, WRENCH)):  # the shaft never rolls
            messages = subscriber.messages(kind)
            last = -1
            for message, since_start_s in zip(messages, stamps_s(messages) - start_s):
                first, end = numpy.searchsorted(recording["time_s"], (since_start_s - NEAR_S, since_start_s + NEAR_S))
                rows = [row for row in range(max(first, last + 1), end) if (expected[row] == message["values"]).all()]
                self.assertTrue(rows, f"{kind}: no tick after row {last} at {since_start_s} s: {message}")
                last = rows[0]
            self.assertEqual({message["frame"] for message in messages}, {f"stillgrid/{self.session}"})
            received_s = numpy.array([message["received_ns"] for message in messages]) * 1e-9
            self.assertTrue((stamps_s(messages) <= received_s).all(), f"{kind}: stamped after it came")
            self.assertTrue(moves(messages, moving), f"{kind}: a still number")


class MessagesTest(RosTest):
    def test_both_profiles_of_ros_get_pose_and_force_of_the_recording_at_its_stamps(self):
        relay = self.relay()  # first of all: it waits for the servers
        subscribers = [self.subscriber(profile) for profile in PROFILES]
        file = self.folder / "recording.csv"
        sim = self.sim_server("laparoscopy")  # an instrument that turns, and is turned
        hand = self.haptic_server(f"replay:loop=1,file={SCENES / 'laparoscopy.hand.csv'}", "--record", file)
        for subscriber in subscribers:
            self.wait_for(subscriber, 1500)
            self.wait_for_a_force(subscriber, sim)
        noted = self.note_a_tick()
        for daemon in (relay, hand):
            self.assertEqual(daemon.stop(), DONE, daemon.lines())
        recording = daemons.read_recording(file)
        for subscriber in subscribers:
            subscriber.stop()
            self.assert_recorded(subscriber, recording, noted)
        published = int(re.search(r"(\d+) poses and forces published", "\n".join(relay.lines()))[1])
        self.assertLessEqual(subscribers[0].count("pose"), published)
        self.assertLessEqual(published, len(recording["time_s"]))

    def test_topics_types_and_quality_are_those_of_a_ros_node(self):
        self.relay()
        subscriber = self.subscriber()
        self.wait_until(lambda: subscriber.count("publisher") >= 2, 10.0, "discovery")
        found = sorted(subscriber.messages("publisher"), key=lambda publisher: publisher["topic"])
        types = idl_types()
        expected = [
            {"kind": "publisher", "topic": f"rt{self.space}/tool_{topic}",
             "type": f"geometry_msgs::msg::dds_::{name}_", "reliable": True, "volatile": True,
             "has_type_information": False,
             "user_data": f"typehash={type_hash(f'geometry_msgs/msg/{name}', types)};"}
            for topic, name in (("pose", "PoseStamped"), ("wrench", "WrenchStamped"))]
        self.assertEqual(found, expected)

    def test_no_more_messages_come_than_the_rate_asked_for(self):
        rate_hz = 87.0
        self.sim_server("wall")
        self.haptic_server(WALL_HAND)
        relay, subscriber = self.relay("--rate", rate_hz), self.subscriber()
        self.wait_for(subscriber, 60)
        relay.stop()
        subscriber.stop()
        for kind in ("pose", "wrench"):
            due = stamps_s(subscriber.messages(kind)) * rate_hz
            ahead = numpy.arange(len(due)) - (due - due[0])  # of the rate, in messages
            # From any one on: the late one whose successor is in time, and half a tick.
            self.assertLess((ahead - numpy.minimum.accumulate(ahead)).max(), 1 + rate_hz * 6e-4, kind)
        self.assertRegex("\n".join(relay.lines()), r" [1-9]\d+ were spared by --rate")

    def test_each_hand_of_a_scene_has_topics_of_its_own(self):
        self.sim_server("block_pinched")
        hands = ("left", "right")
        for name in hands:
            path = SCENES / f"block_pinched.{name}.csv"
            self.haptic_server(f"phantom:profile=touchx,path={path}", "--hand", name)
        self.wait_until(lambda: all((daemons.SHM / f"{self.session}+{name}-tool").exists() for name in hands), 10.0,
                        "both hands")
        heard = {}
        for name in hands:
            self.relay("--hand", name)
            heard[name] = self.subscriber(space=f"{self.space}/{name}")
        for subscriber in heard.values():
            self.wait_for(subscriber, 100)
            subscriber.stop()
            self.assertEqual({message["frame"] for message in subscriber.messages("pose")}, {f"stillgrid/{self.session}"})
        left, right = (values(heard[name].messages("pose"))[:, 0] for name in hands)
        self.assertLess(left.max(), right.min())  # on either side of the block


class FaultsTest(RosTest):
    def test_a_killed_or_stopped_haptic_server_is_silence_and_its_successor_is_heard(self):
        self.sim_server("wall")
        self.relay()
        subscriber = self.subscriber()
        for fault in (signal.SIGKILL, signal.SIGSTOP):
            heard = subscriber.count()
            hand = self.haptic_server(WALL_HAND)
            self.wait_until(lambda: subscriber.count() >= heard + 100, 20.0, "a successor")
            hand.signal(fault)
            time.sleep(0.3)  # what is on its way
            heard = subscriber.count()
            time.sleep(0.5)
            self.assertEqual(subscriber.count(), heard)
            hand.kill()
        subscriber.stop()
        self.assertGreater(numpy.diff(stamps_s(subscriber.messages("pose"))).min(), 0.0)

    def test_a_subscriber_that_stops_reading_holds_up_no_other(self):
        self.sim_server("wall")
        self.haptic_server(WALL_HAND)
        relay = self.relay()
        stopped, other = self.subscriber(), self.subscriber()
        for subscriber in (stopped, other):
            self.wait_for(subscriber, 50)
        stopped.process.send_signal(signal.SIGSTOP)
        heard = other.count()
        self.wait_for(other, heard + 2000, "messages beside a stopped subscriber")
        self.assertEqual(relay.stop(), DONE)
        self.assertIn(" 0 not sent", relay.lines()[-1])

    def test_what_cannot_be_published_is_refused_in_a_line(self):
        cases = ((("--session", "two-parts"), "--session: value 'two-parts' is no part of a ROS topic's name"),
                 (("--session", "a", "--hand", "1st"), "--hand: value '1st' is no part of a ROS topic's name"),
                 (("--session", "a", "--rate", "0"), "--rate"), (("--session", "a", "--rate", "nan"), "--rate"),
                 (("--session", "a", "--domain", "233"), "--domain"), ((), "--session"))
        for arguments, words in cases:
            relay = self.start(RELAY, "ros", *arguments)
            self.assertEqual(relay.wait(5.0), BAD_INPUT, arguments)
            self.assertEqual(len(relay.lines()), 1, relay.lines())
            self.assertIn(words, relay.lines()[0])

    def test_a_session_in_lockstep_is_said_to_have_no_time_of_ros(self):
        self.sim_server("wall", "--lockstep")
        self.haptic_server(WALL_HAND, "--lockstep")
        relay, subscriber = self.relay(), self.subscriber()
        self.wait_until(lambda: any("lockstep" in line for line in relay.lines()), 10.0, "a line")
        self.wait_until(lambda: subscriber.count("publisher") >= 2, 10.0, "discovery")
        time.sleep(0.3)
        self.assertEqual(subscriber.count(), 0)
        self.assertEqual(len([line for line in relay.lines() if "lockstep" in line]), 1)


if __name__ == "__main__":
    daemons.main()
