#!/usr/bin/python3
"""scene_viewer attacked over loopback, by those who know the page's address and those who do not."""
import contextlib
import json
import os
import re
import signal
import socket
import threading
import time

import numpy

import viewer_test
from daemons import DONE, PATIENCE, main

MOST_MIB = 256 * PATIENCE  # of memory, at any time: many times what a viewer of a small scene has


class Strangers(viewer_test.ViewerTest):
    """What is not for them, or not asked well."""

    def test_only_this_machine_and_only_the_pages_own_files_are_served(self):
        page = self.live_viewer()
        for host, expected in (("evil.example", 403), ("evil.example:80", 403),
                               ("127.0.0.1.evil.example", 403), ("localhost:9000", 200),
                               ("127.0.0.1", 200)):
            status, headers, body = page.ask("/api/status", headers={"Host": host})
            self.assertEqual(status, expected, host)
            self.assertNotIn("Access-Control-Allow-Origin", headers)
            self.assertEqual(b"now_s" in body, expected == 200)
        for path in ("/../../../../../../../etc/passwd", "/%2e%2e/%2e%2e/bin/scene_viewer",
                     "/..%2f..%2fbin/scene_viewer", "/three/../../../../CMakeCache.txt",
                     "/api/nothing", "/api"):
            status, _, body = page.ask(path)
            self.assertEqual(status, 404, path)
            self.assertLess(len(body), 100)
        for method in ("POST", "PUT", "DELETE", "OPTIONS"):
            self.assertGreaterEqual(page.ask("/api/status", method)[0], 400, method)
        for path, expected in (("/api/frame", 400), ("/api/frame?number=-1", 400),
                               ("/api/frame?number=1e3", 400), ("/api/frame?number=999999", 404),
                               ("/api/frame?number=0", 404), ("/api/ticks?from=1", 400),
                               ("/api/ticks?from=x&most=1", 400), ("/api/scene?key=none", 404),
                               ("/api/ticks?from=1&most=99999999999999999999999", 400)):
            self.assertEqual(page.ask(path)[0], expected, path)

    def test_nothing_is_compressed_whoever_accepts_it(self):
        """Brotli takes seconds of a processor for a page that is on this machine already."""
        page = self.live_viewer()
        for path in ("/main.js", "/three/three.core.js", "/api/status"):
            status, headers, body = page.ask(path, headers={"Accept-Encoding": "gzip, deflate, br"})
            self.assertEqual(status, 200, path)
            self.assertNotIn("Content-Encoding", headers)
            self.assertEqual(len(body), int(headers["Content-Length"]))

    def test_who_does_not_know_the_key_gets_nothing(self):
        page, other = self.live_viewer(), self.live_viewer()
        key = page.root[1:]
        self.assertNotEqual(page.root, other.root)
        for root in ("", "/", "//", f"/{key[:-1]}", f"/{key}0", f"/{key.upper()}x", f"/{key[:-1]}g",
                     f"/{'0' * 32}", f"/./{key}", f"/?{key}", other.root):
            page.root = root
            for path in ("/", "/api/status", "/api/scene", "/main.js"):
                status, headers, body = page.ask(path)
                self.assertEqual(status, 403, root + path)
                self.assertEqual(headers["Connection"], "close")
                self.assertIn(b"open the address", body)
                self.assertNotIn(key.encode(), body)
        page.root = f"/{key}"
        self.assertEqual(page.ask("/")[0], 200)


class Mice(viewer_test.ViewerTest):
    """Who would move the tool by the mouse of a page, and may not."""

    def held_page(self):
        """A session whose tool a page holds."""
        page = self.live_viewer()
        self.sim_server("wall")
        self.haptic_server("mouse")
        self.wait_for_frame(page, lambda frame, _: frame["tool"], "a tool")
        self.assertEqual(page.move_mouse("owner"), (200, ""))
        return page

    def assert_at(self, page, position_m):
        """The tool comes there, or has stayed there."""
        def is_there():
            self.assertEqual(page.move_mouse("owner", position_m=position_m)[0], 200)
            tool = page.frame()[0]["tool"]
            return numpy.abs(numpy.subtract(tool["position_m"], position_m)).max() < 1e-3
        self.wait_until(is_there, 20.0 * PATIENCE, f"the tool at {position_m}")

    def test_none_but_the_page_that_holds_the_hand_moves_it(self):
        page = self.held_page()
        self.assert_at(page, [0.05, 0, 0.03])
        key, far = page.root, {"position_m": [-0.2, 0, 0.03]}
        status, line = page.move_mouse("thief", **far)
        self.assertEqual((status, line), (409, "another page holds the hand: let it go there, or close it\n"))
        self.assertEqual(page.move_mouse("thief", release=True)[0], 200)
        other = self.live_viewer()
        self.assertEqual(other.move_mouse("thief", **far)[0], 409)
        page.root = f"/{'0' * 32}"
        self.assertEqual(page.move_mouse("owner", **far)[0], 403)
        page.root = key
        message = json.dumps({"holder": "owner", "orientation_xyzw": [0, 0, 0, 1], "buttons": 0} | far)
        for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}, {"Origin": "null"}):
            self.assertEqual(page.ask("/api/mouse", "POST", headers, message)[0], 403, headers)
        for method in ("GET", "PUT", "DELETE", "OPTIONS"):
            self.assertEqual(page.ask("/api/mouse", method, body=message)[0], 405, method)
        self.assertEqual(page.ask("/api/mouse?session=another", "POST", body=message)[0], 404)
        self.assert_at(page, [0.05, 0, 0.03])

    def test_what_is_no_pose_moves_nothing(self):
        page = self.held_page()
        good = '{"holder":"owner","position_m":[0,0,0.03],"orientation_xyzw":[0,0,0,1],"buttons":0}'
        for old, new in (("0.03", "NaN"), ("0.03", "Infinity"), ("0.03", "1e999"), ("0.03", "10.5"), ("0.03", "null"),
                         ("0.03", "[]"), ("0.03", '"0.03"'), ("[0,0,0.03]", "[0,0]"), ("0,1]", "0,0]"),
                         ('"owner"', '"' + "a" * 33 + '"'), ('"owner"', "null"), (":0}", ":-1}"), (":0}", ":1e3}"),
                         (good, ""), (good, "[" * 900), (good, "\0" * 900), ("}", "")):
            self.assertEqual(page.ask("/api/mouse", "POST", body=good.replace(old, new))[0], 400, (old, new))
        for size in (1025, 100_000):
            with contextlib.suppress(ConnectionError):  # cut off while it sends
                self.assertEqual(page.ask("/api/mouse", "POST", body=good + " " * size)[0], 413)
        self.assert_at(page, [0, 0, 0.03])

    def test_a_page_that_ends_frees_the_hand_and_takes_the_force_away(self):
        page = self.held_page()
        self.wait_for_frame(page, lambda frame, _: "not_enabled" in frame["tool"]["flags"], "that nobody holds it")
        self.wait_until(lambda: page.move_mouse("next")[0] == 200, 20.0 * PATIENCE, "the next page")
        self.assertEqual(page.move_mouse("next", release=True)[0], 200)
        self.assertEqual(page.move_mouse("owner")[0], 200)


class Attackers(viewer_test.ViewerTest):
    """Who wants its memory, or that it answers nobody else."""

    def connect(self, page):
        host, _, port = page.host.partition(":")
        client = socket.create_connection((host, int(port)), timeout=20 * PATIENCE)
        self.addCleanup(client.close)
        return client

    def assert_stays_small(self, page):
        """Its memory, at the most that it ever had."""
        with open(f"/proc/{page.process.pid}/status") as status:
            most_KiB = int(re.search(r"VmHWM:\s+([0-9]+) kB", status.read())[1])
        self.assertLess(most_KiB / 1024, MOST_MIB)

    def assert_answers(self, page, times=20):
        """By a connection of its own, each time."""
        for _ in range(times):
            page.close()
            self.assertEqual(page.ask("/api/status")[0], 200)

    def send_without_end(self, page, begin, more, count, most_bytes=16 << 20):
        """Until it is cut off, by so many connections. The most that one could send."""
        sent = []

        def send():
            with contextlib.suppress(OSError):
                client = self.connect(page)
                client.settimeout(10.0 * PATIENCE)
                client.sendall(begin)
                for i in range(most_bytes // len(more)):
                    client.sendall(more)
                    sent.append(i * len(more))
        threads = [threading.Thread(target=send) for _ in range(count)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return max(sent, default=0)

    def test_no_part_of_an_answer_is_served_nor_what_lies_beyond_it(self):
        page = self.live_viewer()
        self.sim_server("wall")
        self.wait_for_frame(page, lambda frame, _: frame["snapshot_id"], "a snapshot")
        key = page.frame()[0]["scene_key"]
        for path in (f"/api/scene?key={key}", "/api/frame?number=1", "/api/ticks?from=0&most=10", "/",
                     "/main.js", "/three/three.core.js"):
            whole = page.ask(path)[2]
            size = len(whole)
            for part in (f"{size}-{size + 60000}", f"{size - 1}-{size + 60000}", f"{10 * size}-", "0-9",
                         "-5", "5-2", f"-{10 * size}", f"0-{2 ** 64}", "0-0,5-9", "0-," * 2000 + "0-",
                         ",".join(f"{i}-" for i in range(1000)), "-", "0-" + "9" * 4000):
                status, headers, body = page.ask(path, headers={"Range": f"bytes={part}"})
                self.assertEqual(status, 200, part[:40])
                self.assertNotIn("Content-Range", headers)
                self.assertEqual(int(headers["Content-Length"]), size)
                self.assertTrue(body == whole, f"{path} {part[:40]}")
        self.assertEqual(page.ask("/", headers={"Range": "bytes=" + "0-," * 2600 + "0-"})[0], 200)
        self.assertEqual(page.ask("/", headers={"Range": "bytes=" + "0-," * 9000 + "0-"})[0], 431)
        self.assert_stays_small(page)

    def test_lines_and_fields_without_end_are_cut_off(self):
        page = self.live_viewer()
        ask = f"GET {page.root}/api/status HTTP/1.1\r\nHost: 127.0.0.1\r\n".encode()
        for begin, more in ((b"", b"G" * 65536), (b"GET /", b"a" * 65536), (ask, b"x" * 65536),
                            (ask + b"Odd: ", b"x" * 65536), (ask, b"A:b\r\n" * 8192),
                            (ask + b"Content-Length: 9999999999\r\n\r\n", b"x" * 65536),
                            (ask + b"Transfer-Encoding: chunked\r\n\r\n", b"4000\r\n" + b"x" * 16384 + b"\r\n"),
                            (b"", b"\r\n" * 32768), (b"", b"\0" * 65536)):
            most = self.send_without_end(page, begin, more, 16)
            self.assertLess(most, 15 << 20, begin + more[:20])  # what lies in buffers of the system
        self.assert_answers(page)
        self.assert_stays_small(page)

    def test_a_request_of_many_fields_is_answered_or_refused_but_never_held(self):
        page = self.live_viewer()
        for count, expected in ((100, 200), (1000, 200), (3000, 431), (100000, 431)):
            client = self.connect(page)
            client.settimeout(10.0 * PATIENCE)
            with contextlib.suppress(ConnectionError):  # cut off within the last case
                client.sendall(f"GET {page.root}/api/status HTTP/1.1\r\nHost: 127.0.0.1\r\n".encode()
                               + b"a:b\r\n" * count + b"\r\n")
            with contextlib.suppress(ConnectionError):
                self.assertIn(str(expected).encode(), client.recv(12)[9:])
        self.assert_stays_small(page)

    def test_hundreds_of_slow_connections_leave_the_page_to_its_user(self):
        page = self.live_viewer()
        known, asked_s = self.connect(page), time.monotonic()
        ask = f"GET {page.root}/api/status HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode()
        for begin in (b"", b"G", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nOdd: "):
            slow = []
            for _ in range(600):  # more than are held
                slow.append(self.connect(page))
                with contextlib.suppress(OSError):
                    slow[-1].sendall(begin)
                if len(slow) % 20 == 0:
                    rested_s, asked_s = time.monotonic() - asked_s, time.monotonic()
                    if rested_s > 1.0:  # a machine that stalls: one that rests for 2 s is ended
                        known = self.connect(page)
                    known.sendall(ask)
                    self.assertIn(b"now_s", known.recv(1 << 16))
                if len(slow) % 100 == 0:
                    self.assert_answers(page, 5)
            self.assert_answers(page)
            self.assertLess(len(os.listdir(f"/proc/{page.process.pid}/fd")), 256 + 16 + 30)
            for client in slow:
                client.close()
        self.assert_stays_small(page)

    def test_who_asks_much_and_takes_nothing_holds_little(self):
        page = self.live_viewer()
        for _ in range(60):
            self.lazy_client(page)
        self.assert_answers(page)
        self.assert_stays_small(page)

    def slow_client(self, page):
        """Sends a request, a byte now and then, that never ends; or until it is cut off."""
        client = self.connect(page)

        def send():
            with contextlib.suppress(OSError):
                client.sendall(f"GET {page.root}/api/status HTTP/1.1\r\nHost: 127.0.0.1\r\nOdd: ".encode())
                while True:
                    client.sendall(b"x")
                    time.sleep(0.1)
        threading.Thread(target=send, daemon=True).start()
        return client

    def lazy_client(self, page):
        """Asks for much, and reads nothing."""
        client = self.connect(page)
        client.settimeout(0.2)
        with contextlib.suppress(OSError):
            for _ in range(20000):
                client.sendall(f"GET {page.root}/main.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode())
        return client

    def test_slow_clients_are_cut_off_and_do_not_hinder_the_end(self):
        page = self.live_viewer()
        slow = [self.slow_client(page) for _ in range(20)]
        self.lazy_client(page)
        self.assert_answers(page)
        for client in slow:
            client.settimeout(20.0 * PATIENCE)
            with contextlib.suppress(ConnectionResetError):
                while client.recv(1 << 16):  # to its end: they are cut off
                    pass
        for _ in range(3):
            self.slow_client(page)
        self.lazy_client(page)
        page.process.send_signal(signal.SIGTERM)
        self.assertEqual(page.process.wait(10 * PATIENCE), DONE)


if __name__ == "__main__":
    main()
