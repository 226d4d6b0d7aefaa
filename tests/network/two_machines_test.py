#!/usr/bin/python3
"""The bed is what it says: two machines that share nothing but the link, which does as it is told."""
import math
import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest

import two_machines
from two_machines import ADDRESS, PATIENCE, TwoMachines

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "integration"))
import daemons  # after the path it needs

ECHO = pathlib.Path(__file__).with_name("udp_echo.py")
PORT = 5077
CLOCK_OFFSET_S = 1234.5


def near_share(count, share, of):
    return abs(count - share * of) <= 5 * math.sqrt(share * (1 - share) * of)


def networks():
    """Numbers of all processes whose network this process may look at, by network."""
    found = {}
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            found.setdefault(os.readlink(folder / "ns" / "net"), []).append(int(folder.name))
        except OSError:  # it has ended, or is somebody else's
            pass
    return found


class TwoMachinesTest(unittest.TestCase):
    def bed(self, *settings, **options):
        try:
            bed = TwoMachines(*settings, **options)
        except two_machines.NotGranted as missing:
            self.skipTest(str(missing))
        self.addCleanup(lambda: bed.close() if bed.is_open else None)
        return bed

    def python(self, bed, side, *arguments):
        return bed.run(side, [sys.executable, *arguments], stdout=subprocess.PIPE, text=True)

    def receiver(self, bed, *arguments):
        program = self.python(bed, "b", ECHO, *arguments)
        self.addCleanup(program.stdout.close)
        self.assertEqual(program.stdout.readline(), "ready\n")
        return program

    def there_and_back(self, bed, count, spacing_s=0.0002):
        """What side b received, as (number, whole), and what came back to a, as (number, s): both in order of
        arrival."""
        receiver = self.receiver(bed, "receive", PORT)
        sender = self.python(bed, "a", ECHO, "send", ADDRESS["b"], PORT, count, spacing_s)
        back, _ = sender.communicate(timeout=PATIENCE * 30)
        self.assertEqual(sender.returncode, 0)
        receiver.kill()
        there = [tuple(map(int, line.split())) for line in receiver.stdout.read().splitlines()]
        self.assertEqual(bed.dropped_by_kernel("b")["socket"], 0)
        return there, [(int(number), float(s)) for number, s in map(str.split, back.splitlines())]

    def test_a_link_without_settings_brings_each_datagram_once_and_in_order(self):
        bed = self.bed()
        there, back = self.there_and_back(bed, 2000)
        self.assertEqual(there, [(number, 1) for number in range(2000)])
        self.assertEqual([number for number, _ in back], list(range(2000)))
        self.assertEqual(bed.close()["a"]["delivered"], 2000)

    def test_a_datagram_takes_the_delay_there_and_the_delay_back(self):
        bed = self.bed("a delay_ms 11.5", "b delay_ms 6")
        _, back = self.there_and_back(bed, 30, spacing_s=0.0307)  # no other packet wakes the link
        self.assertEqual(len(back), 30)
        shortest_ms = min(1e3 * s for _, s in back)
        self.assertGreaterEqual(shortest_ms, 17.5)
        self.assertLess(shortest_ms, 17.5 + 10.0 * PATIENCE)  # before the next packet wakes the link; programs wait too

    def test_lost_and_doubled_and_overtaken_are_as_many_as_asked(self):
        bed = self.bed("a loss 0.03", "a duplicate 0.05", "a reorder 0.02", "a reorder_ms 5", seed=7)
        numbers = [number for number, _ in self.there_and_back(bed, 5000)[0]]
        kept = len(set(numbers))
        self.assertTrue(near_share(5000 - kept, 0.03, 5000), kept)
        self.assertTrue(near_share(len(numbers) - kept, 0.05, kept), len(numbers))
        newest, overtaken = -1, 0
        for number in numbers:
            overtaken += number < newest
            newest = max(newest, number)
        self.assertTrue(near_share(overtaken, 0.02, len(numbers)), overtaken)
        counters = bed.counters()["a"]
        self.assertEqual(counters["delivered"], len(numbers))
        self.assertEqual(counters["sent"] - counters["lost"], kept)

    def test_corrupted_datagrams_are_as_many_as_asked_and_arrive(self):
        bed = self.bed("a corrupt 0.04")
        there, _ = self.there_and_back(bed, 4000)
        self.assertEqual(len(there), 4000)
        corrupted = bed.counters()["a"]["corrupted"]
        self.assertTrue(near_share(corrupted, 0.04, 4000), corrupted)
        broken = sum(not whole for _, whole in there)
        self.assertLessEqual(broken, corrupted)
        self.assertGreater(broken, 0.9 * corrupted)  # the others' flipped bits are in number and time

    def test_a_partition_stops_what_is_sent_and_ends_when_it_is_told_to(self):
        bed = self.bed()
        receiver = self.receiver(bed, "receive", PORT)
        send = [ECHO, "send", ADDRESS["b"], PORT, 100, 0.0002]
        self.assertEqual(len(self.python(bed, "a", *send).communicate()[0].splitlines()), 100)
        bed.control("partition on")
        self.assertEqual(self.python(bed, "a", *send).communicate()[0], "")
        self.assertEqual(bed.counters()["a"]["partitioned"], 100)
        bed.control("partition off")
        self.assertEqual(len(self.python(bed, "a", *send).communicate()[0].splitlines()), 100)
        receiver.kill()

    def test_a_multicast_of_one_side_reaches_the_other(self):
        bed = self.bed()
        listener = self.receiver(bed, "listen", "239.255.0.1", PORT)
        self.python(bed, "a", ECHO, "cast", "239.255.0.1", PORT, "hello").communicate()
        self.assertEqual(listener.communicate(timeout=PATIENCE * 5)[0], "hello\n")

    def test_a_side_has_shared_memory_a_clock_and_a_network_of_its_own(self):
        bed = self.bed(clock_offset_s=CLOCK_OFFSET_S)
        name = f"test-two-machines-{os.getpid()}"
        program = ("import os, time; name = '/dev/shm/%s'\n"
                   "assert not os.path.exists(name); open(name, 'w').write('x')\n"
                   "print(time.monotonic(), os.readlink('/proc/self/ns/net'))" % name)
        clocks, networks_seen = {}, set()
        for side in "ab":
            before_s = time.monotonic()
            clock_s, network = self.python(bed, side, "-c", program).communicate()[0].split()
            self.assertTrue((bed.shared_memory(side) / name).exists())
            clocks[side] = float(clock_s) - before_s
            self.assertLess(0 if side == "a" else CLOCK_OFFSET_S, clocks[side])
            networks_seen.add(network)
        self.assertLess(clocks["a"], 5 * PATIENCE)
        self.assertLess(clocks["b"], CLOCK_OFFSET_S + 5 * PATIENCE)
        self.assertFalse((pathlib.Path("/dev/shm") / name).exists())
        self.assertEqual(len(networks_seen | {os.readlink("/proc/self/ns/net")}), 3)

    def test_a_setting_that_is_none_is_refused_and_changes_nothing(self):
        bed = self.bed()
        for line in ("loss 2", "los 0.1", "a loss", "partition maybe"):
            with self.subTest(line), self.assertRaisesRegex(ValueError, "expected"):
                bed.control(line)
        with self.assertRaisesRegex(RuntimeError, "link_emulator: loss: value '2': expected"):
            TwoMachines("loss 2")
        self.assertEqual(len(self.there_and_back(bed, 100)[1]), 100)

    def test_a_program_is_killed_and_started_again_beside_the_others(self):
        bed = self.bed()
        for _ in range(3):
            receiver = self.receiver(bed, "receive", PORT)
            self.python(bed, "a", ECHO, "send", ADDRESS["b"], PORT, 10, 0.0002).communicate()
            receiver.kill()
            self.assertEqual(receiver.wait(PATIENCE * 5), -signal.SIGKILL)
            self.assertEqual(len(receiver.stdout.read().splitlines()), 10)

    def assert_nobody_outlives(self, bed, end):
        # A program of a side's that has left its parent, and heeds no signal that it may ignore.
        stray = "import os, signal, time\n" \
                "if os.fork(): os._exit(0)\n" \
                "os.setsid(); [signal.signal(s, signal.SIG_IGN) for s in (1, 2, 15)]\n" \
                "print(os.readlink('/proc/self/ns/net'), flush=True); time.sleep(100)"
        mine = []
        for side in "ab":
            program = self.python(bed, side, "-c", stray)
            mine.append(program.stdout.readline().strip())
            program.stdout.close()
            program.wait()
            self.assertEqual(len(networks()[mine[-1]]), 2, "a holder and a stray")
        end()
        bed.close()
        self.assertFalse(set(mine) & set(networks()))

    def test_nothing_outlives_the_bed_that_is_closed(self):
        bed = self.bed()
        self.assert_nobody_outlives(bed, lambda: None)

    def test_nothing_outlives_the_bed_that_is_killed(self):
        bed = self.bed()
        self.assert_nobody_outlives(bed, bed.kill)


if __name__ == "__main__":
    daemons.main()
