#!/usr/bin/python3
"""segment_inspect shows what stands in shared memory, and the servers notice nothing of it."""
import json
import pathlib
import signal
import subprocess
import threading
import time
import unittest

import daemons
from daemons import BAD_INPUT, COULD_NOT_START, DONE

PROGRAM = daemons.BUILD / "bin" / "segment_inspect"
SHARED_MEMORY = daemons.SHM
PRESSING_HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=1"
SPHERES = 405  # of tissue_and_blocks


def inspect(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=30 * daemons.PATIENCE, check=False)


class InspectTest(daemons.SessionTest):
    def show(self, *arguments):
        result = inspect(*arguments)
        self.assertEqual(result.returncode, DONE, result.stderr)
        self.assertEqual(result.stderr, "")
        return result.stdout

    def show_json(self, *arguments):
        return json.loads(self.show("--json", *arguments))

    def rows(self, session=None):
        """The listing's rows of a session, by kind."""
        return {row["kind"]: row for row in self.show_json("--watch-s", 0)
                if row["session"] == (session or self.session)}

    def start_both(self, *haptic):
        sim = self.sim_server("tissue_and_blocks")
        hand = self.haptic_server(PRESSING_HAND, *haptic)
        self.wait_until(lambda: [bool(row["snapshot_id"]) for row in self.rows().values()] == [True] * 2,
                        5.0, "both servers at work")
        return sim, hand

    def kill(self, daemon):
        daemon.signal(signal.SIGKILL)
        daemon.process.wait()

    def leave_dead_scene(self):
        sim = self.sim_server("wall")
        self.wait_until(lambda: self.rows().get("scene", {}).get("state") == "alive", 5.0, "a scene")
        self.kill(sim)


    def second_session(self):
        """Makes another session the test's own. Returns the first."""
        first, self.session = self.session, f"{self.session}-second"
        self.addCleanup(self.remove_objects, first)
        return first

    @staticmethod
    def remove_objects(session):
        for left in SHARED_MEMORY.glob(f"{session}-*"):
            left.unlink()


class ShowTest(InspectTest):
    def test_beside_both_servers_it_shows_what_they_declare_and_do(self):
        sim, hand = self.start_both()
        before, began_s = self.rows(), time.monotonic()
        listing = self.show_json("--watch-s", 1)
        rows = {row["kind"]: row for row in listing if row["session"] == self.session}
        watched_s = time.monotonic() - began_s
        scene, tool = rows["scene"], rows["tool"]
        for row, daemon in ((scene, sim), (tool, hand)):
            self.assertEqual(row["state"], "alive")
            self.assertEqual(row["writer_pid"], daemon.pid)
            self.assertEqual(row["clock"], "monotonic")
            self.assertIsNone(row["refusal"])
        self.assertAlmostEqual(scene["declared_rate_hz"], 1000.0, delta=0.01)
        self.assertAlmostEqual(tool["declared_rate_hz"], 1000.0, delta=0.01)
        # By the count beside it: a busy machine holds the servers up.
        for row in (scene, tool):
            rate_hz = (row["snapshot_id"] - before[row["kind"]]["snapshot_id"]) / watched_s
            self.assertAlmostEqual(row["measured_rate_hz"], rate_hz, delta=4.0 + 0.25 * rate_hz)
        self.assertEqual((scene["moving_spheres"], scene["static_spheres"]), (SPHERES, 0))
        for row in (scene, tool):
            self.assertTrue(0.0 <= row["age_s"] < 2.0, row["age_s"])
        for row in (scene, tool):
            file = SHARED_MEMORY / f"{self.session}-{row['kind']}"
            self.assertEqual(row["size_bytes"], file.stat().st_size)

    def test_a_table_has_a_line_for_each_segment(self):
        sim, hand = self.start_both()
        lines = [line for line in self.show().splitlines() if line.startswith(self.session)]
        self.assertEqual(len(lines), 2, lines)
        for line, words in zip(lines, ((f"pid {sim.pid}", "1000.0 Hz", f"{SPHERES}+0"),
                                       (f"pid {hand.pid}", "1000.0 Hz"))):
            for word in words:
                self.assertIn(word, line)

    def test_a_session_is_shown_in_detail(self):
        self.start_both()
        self.wait_until(lambda: self.rows()["scene"]["snapshot_id"] >= 2, 10.0, "a full history")
        text = self.show("--session", self.session)
        for words in ("name: tissue_and_blocks", "materials 2: ", "planes 0: ", f"moving_spheres: {SPHERES}",
                      "occupied_cells: ", "history_count: 2", "step_ns: ", "position_m: ", "force_N: "):
            self.assertIn(words, text)

    def test_a_session_as_JSON_holds_each_sphere_and_the_tool(self):
        self.start_both()
        session = self.show_json("--session", self.session, "--history", "--watch-s", 0)
        fixed, snapshot = session["scene"]["fixed"], session["scene"]["snapshot"]
        self.assertEqual(fixed["name"], "tissue_and_blocks")
        self.assertEqual(fixed["planes"][0]["normal"], [0.0, 0.0, 1.0])
        self.assertEqual(fixed["planes"][0]["offset_m"], -0.1)
        self.assertEqual(len(snapshot["spheres"]), SPHERES)
        self.assertEqual(snapshot["spheres_left_out"], 0)
        for sphere in snapshot["spheres"]:
            for coordinate_m in sphere["position_m"]:
                self.assertLess(abs(coordinate_m), 1.0)
            self.assertTrue(0.0 < sphere["radius_m"] < 0.1)
            self.assertLess(sphere["material"], len(fixed["materials"]))
            self.assertEqual(len(sphere["history"]), snapshot["history_count"] - 1)
        self.assertEqual(snapshot["publish_time_ns"],
                         sorted(snapshot["publish_time_ns"], reverse=True))
        self.assertGreater(snapshot["grid"]["occupied_cells"], 0)
        self.assertGreater(fixed["model_bytes"], 0)
        self.assertTrue(0 < snapshot["state"]["bytes"] <= fixed["state_capacity"])
        tool = session["tool"]["latest_state"]
        self.assertLess(tool["time_ns"], session["now_ns"])
        self.assertGreaterEqual(tool["snapshot_id"], 1)
        self.assertAlmostEqual(sum(q * q for q in tool["orientation_xyzw"]), 1.0, delta=1e-6)

    def test_two_sessions_at_once_are_both_listed_each_with_its_own_scene(self):
        self.start_both()
        first = self.second_session()
        self.sim_server("wall")
        self.wait_until(lambda: self.rows().get("scene", {}).get("snapshot_id"), 5.0, "the second")
        self.assertEqual(set(self.rows(first)), {"scene", "tool"})
        self.assertEqual(set(self.rows()), {"scene"})
        names = [self.show_json("--session", session, "--watch-s", 0)["scene"]["fixed"]["name"]
                 for session in (first, self.session)]
        self.assertEqual(names, ["tissue_and_blocks", "wall"])

    def test_a_strange_object_is_a_row_and_the_listing_goes_on(self):
        self.sim_server("wall")
        strange = SHARED_MEMORY / f"{self.session}-tool"
        strange.write_bytes(b"x" * 8192)
        self.wait_until(lambda: self.rows().get("scene", {}).get("snapshot_id"), 5.0, "the scene")
        rows = self.rows()
        self.assertEqual(rows["tool"]["state"], "refused")
        self.assertIn("not a Stillgrid segment", rows["tool"]["refusal"])
        self.assertEqual(rows["scene"]["state"], "alive")
        self.assertIn("state: refused", self.show("--session", self.session))


class RefusalTest(InspectTest):
    def assert_refused(self, result, status, word):
        self.assertEqual(result.returncode, status)
        self.assertEqual(result.stdout, "")
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertTrue(result.stderr.startswith("segment_inspect: "), result.stderr)
        self.assertIn(word, result.stderr)

    def test_a_session_that_is_not_there_is_named(self):
        for option in ((), ("--json",), ("--remove-dead",)):
            result = inspect("--session", self.session, *option)
            self.assert_refused(result, COULD_NOT_START, self.session)

    def test_a_bad_option_is_named(self):
        for option, value in (("--session", "../a"), ("--watch-s", "nan"), ("--colour", "red")):
            self.assert_refused(inspect(option, value), BAD_INPUT, option)


class RemoveTest(InspectTest):
    def test_after_a_kill_it_says_dead_and_shows_the_last_snapshot(self):
        sim, _ = self.start_both()
        self.kill(sim)
        rows = self.rows()
        self.assertEqual(rows["scene"]["state"], "dead")
        self.assertEqual(rows["tool"]["state"], "alive")
        self.assertIn(" dead ", self.show("--watch-s", 0))
        session = self.show_json("--session", self.session, "--watch-s", 0)
        self.assertEqual(len(session["scene"]["snapshot"]["spheres"]), SPHERES)

    def test_what_the_dead_left_is_removed_and_what_lives_is_not(self):
        sim, hand = self.start_both()
        self.kill(sim)
        removed = self.show("--session", self.session, "--remove-dead")
        self.assertEqual(removed, f"removed the scene segment of session {self.session}\n")
        self.assertEqual(set(self.rows()), {"tool"})
        self.assertEqual(self.show("--session", self.session, "--remove-dead"),
                         "nothing to remove\n")
        self.assertTrue(hand.runs(), hand.lines())
        self.assertEqual([file.name for file in SHARED_MEMORY.glob(f"*{self.session}-scene*")], [])

    def test_with_a_session_only_its_own_is_removed(self):
        self.leave_dead_scene()
        first = self.second_session()
        self.leave_dead_scene()
        self.assertEqual(self.show_json("--session", self.session, "--remove-dead"),
                         [{"session": self.session, "kind": "scene"}])
        self.assertEqual(self.rows(), {})
        self.assertEqual(self.rows(first)["scene"]["state"], "dead")


class ReaderTest(InspectTest):
    def test_readers_that_poll_hard_change_no_byte_of_a_recording(self):
        def record():
            return self.run_lockstep("tissue_and_blocks", PRESSING_HAND, 2.0).read_bytes()

        alone = record()
        done = threading.Event()
        snapshots = [[] for _ in range(4)]

        def poll(seen):
            while not done.is_set():
                result = inspect("--session", self.session, "--json", "--watch-s", 0)
                if result.returncode != DONE:
                    continue  # before the start, or after the end
                session = json.loads(result.stdout)
                if session["scene"] and session["scene"].get("snapshot"):
                    seen.append(session["scene"]["snapshot"]["snapshot_id"])

        readers = [threading.Thread(target=poll, args=(seen,)) for seen in snapshots]
        for reader in readers:
            reader.start()
        try:
            watched = record()
        finally:
            done.set()
            for reader in readers:
                reader.join()

        self.assertEqual(alone, watched)
        for seen in snapshots:
            self.assertEqual(seen, sorted(seen), "a snapshot went back")
        self.assertGreater(len(set().union(*snapshots)), 3, "the readers saw it move")


if __name__ == "__main__":
    daemons.main()
