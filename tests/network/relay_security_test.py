#!/usr/bin/python3
"""Who may join a session over a network is said by who runs the relay, and nobody else is heard."""
import shutil
import subprocess
import time

import relayed
from dds_security import Authority
from relayed import INTERFACE, RelayedTest, daemons


class WhoMayJoinTest(RelayedTest):
    def setUp(self):
        super().setUp()
        self.open_bed()

    def assert_line(self, relay, *words, status=daemons.COULD_NOT_START):
        self.assertEqual(relay.wait(10.0), status, relay.lines())
        self.assertEqual(len(relay.lines()), 1, relay.lines())
        self.assertRegex(relay.lines()[0], "^scene_relay: ")
        for word in words:
            self.assertIn(word, relay.lines()[0])

    def relay_at(self, address, *joins):
        """A relay at an interface of an Ethernet, made for it on side b."""
        make = f"ip tuntap add dev lan0 mode tap && ip addr add {address}/24 dev lan0 && ip link set lan0 up"
        made = subprocess.run(self.bed.argv("b", ["sh", "-c", make]), capture_output=True, text=True, check=False)
        if made.returncode:
            self.skipTest(f"an Ethernet interface: {made.stderr.strip()}")
        return self.start_on("b", relayed.BUILD / "bin" / "scene_relay", "hand", "--session", self.session,
                             "--interface", "lan0", "--duration", 0.3, *joins)

    def test_on_a_private_network_it_is_to_be_said_who_may_join(self):
        self.assert_line(self.relay_at("192.168.77.1"), "--interface lan0 (192.168.77.1)", "who may join?", "--open",
                         "--security")

    def test_on_a_private_network_whoever_is_there_may_join_if_that_is_said(self):
        relay = self.relay_at("192.168.77.1", "--open")
        self.assertEqual(relay.wait(), daemons.DONE, relay.lines())
        self.assertEqual(relay.lines(), [])

    def test_at_an_address_that_anyone_may_send_to_an_open_door_is_refused(self):
        self.assert_line(self.relay_at("203.0.113.1", "--open"), "--interface lan0 (203.0.113.1)", "--security")

    def test_a_tunnel_says_itself_who_may_join(self):
        for role in "simulation", "hand":
            relay = self.relay(role, "--duration", 0.3, joins=())
            self.assertEqual(relay.wait(), daemons.DONE, relay.lines())

    def test_an_interface_that_is_not_there_is_named_with_those_that_are(self):
        relay = self.start_on("b", relayed.BUILD / "bin" / "scene_relay", "hand", "--session", self.session,
                              "--interface", "eth7", "--open")
        self.assert_line(relay, "eth7", "lo", INTERFACE)

    def test_without_an_interface_it_keeps_to_its_machine(self):
        """Two that run so on two machines never meet, and send no packet."""
        relays = [self.start_on(side, relayed.BUILD / "bin" / "scene_relay", role, "--session", self.session,
                                "--duration", 2) for side, role in (("a", "simulation"), ("b", "hand"))]
        for relay in relays:
            self.assertEqual(relay.wait(), daemons.DONE, relay.lines())
            self.assertEqual(relay.lines(), [])
        counters = self.bed.counters()
        self.assertEqual([counters[side]["sent"] for side in "ab"], [0, 0])

    def test_neither_open_and_secure_nor_a_folder_that_is_none(self):
        folder = str(self.folder)
        self.assert_line(self.relay("hand", joins=("--open", "--security", folder)), "--open",
                         status=daemons.BAD_INPUT)
        self.assert_line(self.relay("hand", joins=("--security", folder + "/absent")), "absent",
                         status=daemons.BAD_INPUT)


class OtherInterfaceTest(RelayedTest):
    def on(self, side, line):
        made = subprocess.run(self.bed.argv(side, ["sh", "-c", line]), capture_output=True, text=True)
        if made.returncode != 0:
            self.skipTest(made.stderr.strip())

    def test_who_comes_by_another_interface_is_not_heard(self):
        """The middleware receives on all addresses of a machine: of a tunnel who has its key may join, and nobody
        who reaches its address otherwise."""
        if not shutil.which("ip"):
            self.skipTest("no ip")
        self.open_bed("delay_ms 1")
        self.on("a", "ip tuntap add mode tun name wg9 && ip addr add 10.99.0.1/24 dev wg9 && ip link set wg9 up")
        self.on("b", f"ip route add 10.99.0.0/24 dev {INTERFACE}")
        tool_watch, scene_watch = self.watch("a", "tool"), self.watch("b", "scene")
        self.sim = self.sim_server()
        inside = self.start_on("a", relayed.BUILD / "bin" / "scene_relay", "simulation", "--session", self.session,
                               "--interface", "wg9")
        outside = self.relay("hand", "--peer", "10.77.0.1", joins=("--open",))
        haptic, _ = self.hand()
        time.sleep(3.0)
        haptic.kill()
        self.assertTrue(inside.runs(), inside.lines())
        self.stop_all(outside, inside, self.sim)
        for relay in outside, inside:
            self.assertEqual([line for line in relay.lines() if "joined" in line], [])
        self.assertEqual((tool_watch.epochs(), scene_watch.epochs()), ([0], [0]))


class SecurityTest(RelayedTest):
    def setUp(self):
        super().setUp()
        if not shutil.which("openssl"):
            self.skipTest("no openssl")
        self.open_bed("delay_ms 2")
        self.authority = Authority(self.folder / "ours", "ours")

    def secured(self, role, folder, *arguments):
        return self.relay(role, *arguments, joins=("--security", folder))

    def start_secured(self):
        self.scene_watch, self.tool_watch = self.watch("b", "scene"), self.watch("a", "tool")
        self.sim = self.sim_server()
        self.sim_relay = self.secured("simulation", self.authority.identity("workstation"))
        self.hand_relay = self.secured("hand", self.authority.identity("hand"))
        self.haptic, self.recording_file = self.hand()

    def test_two_relays_that_one_authority_vouches_for_join(self):
        self.start_secured()
        self.wait_until(self.is_felt, 10.0, "a force over the link")
        self.assert_safe(self.stop_session())

    def test_who_says_nothing_or_is_vouched_for_by_another_is_not_heard(self):
        stranger = Authority(self.folder / "theirs", "theirs").identity("hand")
        self.sim = self.sim_server()
        self.sim_relay = self.secured("simulation", self.authority.identity("workstation"))
        watch = self.watch("b", "scene")
        for joins in ("--open",), ("--security", stranger):
            hand = self.relay("hand", joins=joins)
            time.sleep(3.0)
            self.assertEqual(hand.stop(), daemons.DONE, hand.lines())
            self.assertEqual([line for line in hand.lines() if "joined" in line], [])
        self.assertEqual([line for line in self.sim_relay.lines() if "joined" in line], [])
        self.assertEqual(watch.epochs(), [0])
        self.stop_all(self.sim_relay, self.sim)

    def test_a_stranger_beside_two_that_are_vouched_for_disturbs_nothing(self):
        self.start_secured()
        self.wait_until(self.is_felt, 10.0, "a force over the link")
        own = 'mount -t tmpfs tmpfs /dev/shm && exec "$@"'
        self.start(*self.bed.argv("a", ["unshare", "--mount", "sh", "-c", own, "sh", relayed.BUILD / "bin" /
                                        "scene_relay", "simulation", "--session", self.session, "--interface",
                                        INTERFACE, "--open"]))
        time.sleep(1.5)
        self.assertEqual([line for line in self.hand_relay.lines() if "two relays" in line], [])
        recording = self.stop_session()
        self.assert_safe(recording)
        self.assert_returned(recording)

    def test_a_folder_that_lacks_a_file_or_holds_a_wrong_one_is_refused_in_a_line(self):
        for name, text in (("key.pem", None), ("identity.pem", None), ("governance.p7s", None),
                           ("permissions.p7s", "no signature\n"), ("identity_ca.pem", "no certificate\n")):
            with self.subTest(name):
                folder = self.authority.identity(f"without_{name.replace('.', '_')}")
                if text is None:
                    (folder / name).unlink()
                else:
                    (folder / name).write_text(text)
                relay = self.secured("hand", folder)
                self.assertEqual(relay.wait(10.0), daemons.COULD_NOT_START, relay.lines())
                self.assertEqual(len(relay.lines()), 1, relay.lines())
                self.assertIn(str(folder), relay.lines()[0])


if __name__ == "__main__":
    daemons.main()
