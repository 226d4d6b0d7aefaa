#!/usr/bin/python3
"""scene_viewer beside the daemons, asked over HTTP."""
import json
import os
import signal
import subprocess
import threading

import numpy

from daemons import (BAD_INPUT, BUILD, COULD_NOT_START, DONE, PATIENCE, SCENES, SessionTest, copy_for_others, main,
                     read_recording)
from viewer_client import Page

PRESS = "phantom:path=press,centre_z_m=0,depth_m=0.05,period_s=0.5,hand=light"


class ViewerTest(SessionTest):
    """With viewers, each with the address that it printed."""

    def viewer(self, *arguments, port=("--port", "0")):
        """The page of a viewer that is ready."""
        read, write = os.pipe()
        with open(self.folder / f"viewer-{len(self.daemons)}.stderr", "w") as stderr:
            process = subprocess.Popen(
                ["setpriv", "--pdeathsig", "KILL", BUILD / "bin" / "scene_viewer", *port,
                 *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=write, stderr=stderr)
        os.close(write)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        late = threading.Timer(20.0, process.kill)
        late.start()
        with open(read) as printed:
            address = printed.readline().strip()
        late.cancel()
        self.assertRegex(address, r"^http://127\.0\.0\.1:[0-9]+/[0-9a-f]{32}/$")
        page = Page(address)
        self.addCleanup(page.close)
        page.process = process
        return page

    def live_viewer(self, *arguments):
        return self.viewer("--session", self.session, *arguments)

    def wait_for_frame(self, page, condition, what, timeout_s=20.0):
        """The first frame that is as wanted."""
        found = []

        def is_there():
            found[:] = page.frame()
            return condition(*found)
        self.wait_until(is_there, timeout_s, what)
        return found


class Session(ViewerTest):
    def test_a_running_scene_is_shown_with_its_tool_and_its_ticks(self):
        page = self.live_viewer()
        self.assertEqual(page.frame()[0]["sim"], "absent")
        self.assertIn("waiting", page.status()["note"])
        self.sim_server("tissue_and_blocks")
        self.haptic_server(PRESS, "--transition", "linear")
        frame, arrays = self.wait_for_frame(
            page, lambda frame, _: frame["tool"] and frame["tool"]["contacts"] > 0
            and frame["display"] and frame["ticks"]["seen"] > 100, "a touch that is shown")
        scene = page.scene()
        self.assertEqual(scene["name"], "tissue_and_blocks")
        self.assertEqual(scene["scene_key"], frame["scene_key"])
        count = scene["spheres"]["count"]
        self.assertEqual(count, 405)
        self.assertEqual(len(scene["spheres"]["radius_m"]), count + scene["spheres"]["static_count"])
        for name in ("newest", "previous", "displayed"):
            self.assertEqual(arrays[name].size, 3 * count, name)
            self.assertTrue(numpy.isfinite(arrays[name]).all(), name)
        self.assertEqual(arrays["voxel_count"].sum(), count)
        self.assertEqual(arrays["voxels"].size, 4 * arrays["voxel_count"].size)
        self.assertEqual((frame["sim"], frame["hand"]), ("alive", "alive"))
        self.assertLess(frame["snapshot"]["age_s"], 2.0)
        # What is displayed is near the newest snapshot, but not it: a transition is under way.
        apart_m = numpy.abs(arrays["displayed"] - arrays["newest"])
        self.assertLess(apart_m.max(), 0.1)
        self.assertGreater(apart_m.max(), 0.0)

        ticks = page.ticks(first=1)
        self.assertTrue((numpy.diff(ticks["tick"]) > 0).all())
        self.assertTrue((numpy.diff(ticks["time_s"]) > 0).all())
        self.assertEqual(ticks["position_m"].size, 3 * ticks["tick"].size)
        self.assertGreater(ticks["tick_us"].max(), 0.0)
        self.assertGreater(ticks["contacts"].max(), 0)
        later = page.ticks(first=int(ticks["tick"][5]), most=3)
        self.assertEqual(list(later["tick"]), list(ticks["tick"][5:8]))

    def test_of_several_hands_one_is_shown_in_full_and_every_tool(self):
        self.sim_server("block_pinched")
        for name in ("left", "right"):
            self.haptic_server("phantom:profile=touchx,path=still", "--hand", name)
        page = self.live_viewer("--hand", "right")
        frame, _ = self.wait_for_frame(page, lambda frame, _: frame["tool"] and frame["others"], "both hands")
        self.assertGreater(frame["tool"]["position_m"][0], 0.0)
        (other,) = frame["others"]
        self.assertEqual((other["name"], len(other["tool_spheres"])), ("left", 4))
        self.assertLess(other["tool"]["position_m"][0], 0.0)
        self.assertEqual(page.scene()["session"], f"{self.session}+right")

        whole = self.live_viewer()
        self.wait_until(lambda: "'left', 'right'" in whole.status()["note"], 5.0, "a note that names the hands")
        wrong = subprocess.run([BUILD / "bin" / "scene_viewer", "--session", self.session, "--hand", "third"],
                               capture_output=True, text=True, timeout=10)
        self.assertNotEqual(wrong.returncode, 0)
        self.assertIn("not 'third'", wrong.stderr)

    def test_a_killed_simulation_is_shown_as_dead_and_comes_back(self):
        page = self.live_viewer()
        first = self.sim_server("moving_sphere")
        haptic = self.haptic_server(self.still_device(0, 0, 0.02))
        frame, _ = self.wait_for_frame(page, lambda frame, _: frame["hand"] == "alive"
                                       and frame["snapshot_id"], "both alive")
        first.kill()
        dead, _ = self.wait_for_frame(page, lambda frame, _: frame["sim"] == "dead", "death shown")
        self.assertGreaterEqual(dead["snapshot_id"], frame["snapshot_id"])  # the last snapshot stands
        self.assertEqual(page.status()["sim"], "dead")
        self.sim_server("moving_sphere")
        back, _ = self.wait_for_frame(
            page, lambda frame, _: frame["sim"] == "alive" and frame["snapshot_id"], "life shown")
        self.assertNotEqual(back["scene_key"], dead["scene_key"])
        self.assertEqual(page.scene()["scene_key"].partition("-")[0],
                         back["scene_key"].partition("-")[0])
        last_tick = page.frame()[0]["tool"]["tick"]
        haptic.kill()
        self.wait_for_frame(page, lambda frame, _: frame["hand"] == "dead", "the hand's death")
        self.haptic_server(self.still_device(0, 0, 0.02))
        again, _ = self.wait_for_frame(
            page, lambda frame, _: frame["hand"] == "alive", "the hand's return")
        self.assertGreaterEqual(again["tool"]["tick"], last_tick)  # numbered on

    def test_a_server_whose_relay_hears_nothing_is_silent_and_what_a_relay_counts_is_told(self):
        page = self.live_viewer()
        self.sim_server("moving_sphere")
        self.haptic_server(self.still_device(0, 0, 0.02))
        frame, _ = self.wait_for_frame(page, lambda frame, _: (frame["sim"], frame["hand"]) == ("alive", "alive"),
                                       "both alive")
        self.assertEqual((frame["sim_relay"], frame["hand_relay"]), (None, None))
        self.set_relay_figures("scene", connected=1, received=12345, lost=12)
        self.set_relay_figures("tool", connected=0, partitions=2)
        frame, _ = self.wait_for_frame(page, lambda frame, _: frame["hand"] == "silent", "a hand that is not heard")
        self.assertEqual(frame["sim"], "alive")
        self.assertEqual((frame["sim_relay"]["received"], frame["sim_relay"]["lost"]), (12345, 12))
        self.assertEqual((frame["hand_relay"]["connected"], frame["hand_relay"]["partitions"]), (False, 2))
        self.assertEqual(page.status()["hand"], "silent")
        self.set_relay_figures("scene", connected=0, received=12346)
        self.set_relay_figures("tool", connected=1, late=2**60)  # which no relay counts
        frame, _ = self.wait_for_frame(page, lambda frame, _: frame["sim"] == "silent" and frame["hand"] == "alive",
                                       "a simulation that is not heard")
        self.assertIsNone(frame["hand_relay"])

    def test_a_viewer_without_a_session_shows_any_that_runs(self):
        surfaces = self.folder / "surfaces.json"
        made = self.start(BUILD / "bin" / "sim_server", "--scene", SCENES / "block_pinched.toml",
                          "--surfaces", surfaces)
        self.assertEqual(made.wait(), DONE, made.lines())
        page = self.viewer("--surfaces", surfaces)
        status, _, body = page.ask("/api/status?session=" + self.session)
        self.assertEqual((status, body), (404, b"no session of that name runs\n"))
        self.assertEqual(page.ask("/api/status")[0], 404)
        first = self.sim_server("moving_sphere")
        other = self.first_session + "-2"
        self.session = other
        self.sim_server("block_pinched")
        self.session = self.first_session
        names = {self.session, other + "+left", other + "+right"}

        def running():
            told = json.loads(page.ask("/api/sessions")[2])
            self.assertEqual(told["named"], "")
            return names <= set(told["running"])
        self.wait_until(running, 20.0, "all three")
        scenes = {}
        for name in names:
            page.session = name
            self.wait_for_frame(page, lambda frame, _: frame["snapshot_id"], "a snapshot of " + name)
            scenes[name] = page.scene()
            self.assertEqual(scenes[name]["session"], name)
        # The surfaces are of the one scene, and not of the other.
        self.assertIsNone(scenes[self.session]["surfaces"])
        self.assertEqual(scenes[other + "+left"]["surfaces"]["names"], ["floor", "stand", "block"])
        first.kill()
        page.session = self.session
        self.wait_for_frame(page, lambda frame, _: frame["sim"] == "dead", "death shown")
        command = page.status()["sim_command"]
        self.assertTrue(command.endswith(f"/sim_server --scene {SCENES}/moving_sphere.toml --session {self.session}"),
                        command)
        told = json.loads(page.ask("/api/sessions")[2])
        self.assertNotIn(self.session, told["running"])

    def test_in_virtual_time_the_last_tick_is_shown_where_it_was(self):
        """In lockstep nothing moves on when the hand has ended."""
        page = self.live_viewer("--frames-per-s", 100)
        recording = self.folder / "recording.csv"
        self.sim_server("moving_sphere", "--lockstep")
        haptic = self.haptic_server(self.still_device(0, 0, 0.02), "--lockstep", "--record", recording)
        self.wait_for_frame(page, lambda frame, _: frame["tool"] and frame["snapshot_id"], "a tick")
        self.assertEqual(haptic.stop(), DONE, haptic.lines())
        frame, _ = self.wait_for_frame(page, lambda frame, _: frame["hand"] == "absent", "the end")
        rows = read_recording(recording)
        tick = frame["tool"]["tick"]
        self.assertGreater(tick, 0)
        self.assertAlmostEqual(frame["tool"]["time_s"], 1e-3 * (tick - 1), places=9)
        self.assertAlmostEqual(frame["tool"]["force_N"][2], rows["fz_N"][tick - 2], places=12)
        self.assertAlmostEqual(frame["tool"]["age_s"], rows["age_s"][tick - 2], places=12)

    def test_a_saved_view_opens_without_servers_and_gives_the_same_frames(self):
        file = self.folder / "run.view"
        page = self.live_viewer("--save", file)
        self.sim_server("moving_sphere")
        self.haptic_server(self.still_device(0, 0, 0.02))
        self.wait_for_frame(page, lambda frame, _: frame["ticks"]["seen"] > 200, "ticks")
        last = page.status()["last_frame"]
        seen = {number: page.frame_bytes(number) for number in range(1, last)}
        scene, ticks = page.scene(), page.ticks(first=1, most=100)
        page.process.send_signal(signal.SIGINT)
        self.assertEqual(page.process.wait(10), DONE)

        def check(opened):
            status = opened.status()
            self.assertFalse(status["live"])
            self.assertGreaterEqual(status["last_frame"], last - 1)
            for number, message in seen.items():
                self.assertEqual(opened.frame_bytes(number), message)
            self.assertEqual(opened.scene() | {"source": "session"}, scene)
            again = opened.ticks(first=int(ticks["tick"][0]), most=100)
            numpy.testing.assert_array_equal(again["tick"], ticks["tick"])
            numpy.testing.assert_array_equal(again["force_N"], ticks["force_N"])
        check(self.viewer("--open", file))
        os.truncate(file, file.stat().st_size - 7)
        check(self.viewer("--open", file))

    def test_a_recording_is_shown_without_bodies(self):
        recording = self.run_lockstep("wall", self.still_device(0, 0, -0.001), 2.0)
        page = self.viewer("--recording", recording)
        rows = read_recording(recording)
        status = page.status()
        self.assertEqual((status["first_frame"], status["last_frame"]), (1, 60))
        self.assertEqual(page.scene()["source"], "recording")
        frame, arrays = page.frame(31)
        self.assertEqual(arrays["newest"].size, 0)
        self.assertEqual(frame["tool"]["force_N"][2], rows["fz_N"][1000])
        ticks = page.ticks(first=1)
        numpy.testing.assert_array_equal(ticks["tick"], numpy.arange(1, 2001))
        numpy.testing.assert_allclose(ticks["force_N"][2::3], rows["fz_N"], rtol=1e-6)

    def test_surfaces_of_the_scene_are_passed_on_and_others_left_out(self):
        surfaces = self.folder / "surfaces.json"
        made = self.start(BUILD / "bin" / "sim_server", "--scene", SCENES / "tissue_and_blocks.toml",
                          "--surfaces", surfaces)
        self.assertEqual(made.wait(), DONE, made.lines())
        page = self.live_viewer("--surfaces", surfaces)
        self.sim_server("tissue_and_blocks")
        _, arrays = self.wait_for_frame(page, lambda frame, _: frame["snapshot_id"], "a snapshot")
        scene = page.scene()
        self.assertEqual(scene["surfaces"], json.loads(surfaces.read_text()))
        centres_m = arrays["newest"].reshape(-1, 3)
        for body in scene["surfaces"]["bodies"]:
            for vertex in body["vertices"]:
                owners = {scene["spheres"]["body"][number] for number in vertex["spheres"]}
                self.assertEqual(owners, {body["body"]})
                self.assertAlmostEqual(sum(vertex["weights"]), 1.0, places=5)
                place_m = numpy.asarray(vertex["weights"]) @ centres_m[vertex["spheres"]]
                self.assertLess(numpy.abs(place_m).max(), 1.0)


class Options(ViewerTest):
    def test_what_only_a_run_needs_is_refused_beside_surfaces(self):
        surfaces = self.folder / "wall.json"
        for option in (("--duration", 1), ("--report", "r.json"), ("--session", "a"), ("--cpu", 0),
                       ("--final-state", "s.csv"), ("--seed", 2), ("--rate", 30), ("--explain",)):
            result = subprocess.run(
                [BUILD / "bin" / "sim_server", "--scene", SCENES / "wall.toml", "--surfaces",
                 surfaces, *map(str, option)], capture_output=True, text=True, timeout=20 * PATIENCE)
            self.assertEqual(result.returncode, BAD_INPUT, option)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertIn(option[0], result.stderr)
            self.assertFalse(surfaces.exists())

    def test_a_thread_that_the_system_refuses_is_told_in_one_line(self):
        if os.geteuid() != 0:
            self.skipTest("needs root, to be a user who has no process left")
        result = subprocess.run(
            ["prlimit", "--nproc=1", "setpriv", "--reuid=64323", "--regid=64323", "--clear-groups",
             copy_for_others(self, "scene_viewer") / "bin" / "scene_viewer", "--session", "a", "--port", "0"],
            stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20 * PATIENCE,
            env={**os.environ, "ASAN_OPTIONS": "detect_leaks=0"})  # which would need a process too
        self.assertEqual(result.returncode, BAD_INPUT)
        self.assertEqual(result.stderr.splitlines(), [
            "scene_viewer: cannot make a thread (ulimit -u): Resource temporarily unavailable"])

    def test_viewers_that_are_told_no_port_take_one_each_and_print_it(self):
        pages = [self.viewer("--session", self.session, port=()) for _ in range(2)]
        self.assertNotEqual(pages[0].host, pages[1].host)
        for page in pages:
            self.assertIn("sim", page.status())

    def test_a_bad_option_is_refused_in_one_line(self):
        page = self.live_viewer()
        taken = page.status() and page.host.partition(":")[2]
        odd = self.write("odd.json", '{"spheres": 1, "bodies": [{}]}')
        text = self.write("text.view", "no view")
        rows = self.write("rows.csv", "time_s,x_m,y_m,z_m\n0,1,2,three\n")
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)
        for arguments, words in (
                (("--hand", "left"), ("--hand", "--session")),
                (("--save", "b.view"), ("--save", "--session")),
                (("--open", text, "--surfaces", odd), ("--surfaces",)),
                (("--session", "a/b"), ("--session", "a/b")),
                (("--session", "a", "--port", "70000"), ("--port", "70000")),
                (("--session", "a", "--port", taken, "--save", self.write("kept.view", "kept")),
                 ("--port", taken, "free port")),
                (("--session", "a", "--frames-per-s", "nan"), ("--frames-per-s", "nan")),
                (("--session", "a", "--open", text), ("--open",)),
                (("--open", text), ("text.view", "expected a view")),
                (("--open", text, "--save", "b.view"), ("--save",)),
                (("--open", self.folder / "none.view"), ("none.view", "No such file")),
                (("--open", pipe), ("pipe", "expected a view")),
                (("--recording", pipe), ("pipe", "expected a regular file")),
                (("--recording", "/dev/zero"), ("/dev/zero", "expected a regular file")),
                (("--recording", rows), ("rows.csv:2", "z_m", "three")),
                (("--session", "a", "--surfaces", odd), ("odd.json", "bodies[0]")),
                (("--session", "a", "--surfaces", self.folder), (self.folder.name, "cannot be read")),
                (("--session", "a", "--save", self.folder / "no" / "b.view"), ("--save", "b.view"))):
            result = subprocess.run([BUILD / "bin" / "scene_viewer", *map(str, arguments)],
                                    stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                    timeout=20 * PATIENCE)
            self.assertEqual(result.returncode, BAD_INPUT, arguments)
            lines = result.stderr.splitlines()
            self.assertEqual(len(lines), 1, lines)
            for word in ("scene_viewer: ", *words):
                self.assertIn(word, lines[0])
            self.assertEqual(result.stdout, "")
        self.assertEqual((self.folder / "kept.view").read_text(), "kept")


if __name__ == "__main__":
    main()
