#!/usr/bin/python3
"""What a relay tells of a segment that it writes: shown by every program, and believed by none that computes."""
import json
import subprocess

from daemons import BUILD, DONE, RELAY_FIGURES, SessionTest, main, read_report

TOLD = {"connected": 1, "clock_offset_ns": -1234567890123, "clock_bound_ns": 104000, "round_trip_ns": 20340000,
        "received": 12345, "received_bytes": 9876543, "lost": 12, "repeated": 3, "out_of_order": 4, "late": 5,
        "refused": 6, "partitions": 2, "longest_silence_ns": 3140000000}
HOSTILE = {name: 2**64 - 1 for name in RELAY_FIGURES}


def inspect(session, *arguments):
    return subprocess.run([BUILD / "bin" / "segment_inspect", "--session", session, "--watch-s", "0", *arguments],
                          capture_output=True, text=True, timeout=30, check=True).stdout


class RelayFiguresTest(SessionTest):
    def run_both(self, scene, tool):
        """The reports of two servers whose segments are written into while they run; None writes nothing."""
        reports = self.folder / "sim.json", self.folder / "haptic.json"
        sim = self.sim_server("wall", "--report", reports[0])
        haptic = self.haptic_server(self.still_device(0, 0, 0.05), "--report", reports[1])
        for kind in "scene", "tool":
            self.wait_until(lambda kind=kind: self.row(kind) and self.row(kind)["snapshot_id"], 10.0, f"a {kind}")
        for kind, figures in ("scene", scene), ("tool", tool):
            if figures is not None:
                self.set_relay_figures(kind, **figures)
        self.rows = {kind: self.row(kind) for kind in ("scene", "tool")}
        self.text = inspect(self.session)
        for daemon in haptic, sim:
            self.assertEqual(daemon.stop(), DONE, daemon.lines())
        return tuple(map(read_report, reports))

    def row(self, kind):
        listed = subprocess.run([BUILD / "bin" / "segment_inspect", "--json", "--watch-s", "0"], capture_output=True,
                                text=True, timeout=30, check=True).stdout
        rows = [row for row in json.loads(listed) if (row["session"], row["kind"]) == (self.session, kind)]
        return rows[0] if rows else None

    def test_each_server_reports_how_what_it_read_came_over_a_relay(self):
        told = {**TOLD, "connected": True}
        sim, haptic = self.run_both(scene=TOLD, tool={**TOLD, "lost": 77})
        self.assertEqual(haptic["relay"], told)
        self.assertEqual(sim["relay"], {**told, "lost": 77})
        self.assertEqual(self.rows["scene"]["relay"], told)
        self.assertEqual(self.rows["tool"]["relay"], {**told, "lost": 77})
        self.assertEqual(self.text.count("    connected: true\n    round_trip_ns: 20340000\n"), 2)

    def test_of_a_segment_that_no_relay_writes_nothing_is_told(self):
        sim, haptic = self.run_both(scene=None, tool=None)
        self.assertNotIn("relay", sim)
        self.assertNotIn("relay", haptic)
        self.assertEqual([self.rows[kind]["relay"] for kind in ("scene", "tool")], [None, None])
        self.assertEqual(self.text.count("relay: none\n"), 2)

    def test_figures_that_no_relay_writes_are_shown_by_nobody(self):
        sim, haptic = self.run_both(scene=HOSTILE, tool={**TOLD, "lost": 2**53 + 1})
        self.assertNotIn("relay", sim)
        self.assertNotIn("relay", haptic)
        self.assertEqual([self.rows[kind]["relay"] for kind in ("scene", "tool")], [None, None])
        self.assertGreater(haptic["snapshots"], 0)

    def test_each_hand_has_its_own_relay(self):
        report = self.folder / "sim.json"
        sim = self.sim_server("block_pinched", "--report", report)
        hands = [self.haptic_server("phantom:profile=touchx,path=still", "--hand", name) for name in ("left", "right")]
        session = self.session
        for name in "left", "right":
            self.session = f"{session}+{name}"
            self.wait_until(lambda: self.row("tool") and self.row("tool")["snapshot_id"], 10.0, name)
        self.set_relay_figures("tool", **TOLD)
        self.session = session
        for daemon in *hands, sim:
            self.assertEqual(daemon.stop(), DONE, daemon.lines())
        left, right = read_report(report)["hands"]
        self.assertNotIn("relay", left)
        self.assertEqual(right["relay"]["received"], TOLD["received"])


if __name__ == "__main__":
    main()
