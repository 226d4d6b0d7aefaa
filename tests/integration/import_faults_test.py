#!/usr/bin/python3
"""scripts/stillgrid_import tells what no hand did, and writes what replay plays."""
import subprocess

import numpy

import daemons
import imports
from imports import COULD_NOT_RUN, FAULTY, SEEDS, TOLERANCE, Hand, read, rotations


class FaultTest(imports.ImportTest):
    def raw(self, hand, name="raw.csv"):
        values = numpy.hstack([hand.time_s[:, None], hand.position_m])
        rows = "".join(",".join(map(repr, row)) + "\n" for row in values.tolist())
        return self.write(name, "time_s,x_m,y_m,z_m\n" + rows)

    def test_a_gap_is_told_with_place_and_size_and_never_accepted_in_silence(self):
        for seed in SEEDS:
            hand, random = Hand(seed), numpy.random.default_rng(seed)
            row, gap_s = int(random.integers(20, 120)), float(random.uniform(0.11, 5.0))
            hand.time_s[row:] += gap_s - (hand.time_s[row] - hand.time_s[row - 1])
            raw = self.raw(hand)
            # The header is line 1, row 0 is line 2.
            line = rf"raw\.csv:{row + 2}: gap of {gap_s:.4g} s from {hand.time_s[row - 1]:.4f} s on"
            self.refused(FAULTY, line + ".*in all 1 gap: expected none, or --accept gaps", raw)
            self.refused(FAULTY, line, raw, "--accept", "jumps")
            self.assertRegex(self.run_import(raw).stdout, line)
            self.assert_same(self.imported(raw, "--accept", "gaps"), hand, False, False)
            self.assertIn("# accepted: 1 gap\n", (self.folder / "out.csv").read_text())
            self.imported(raw, "--max-gap", 1e3 * gap_s + 0.01)
            after = self.imported(raw, "--from", hand.time_s[row] - 0.0005)
            numpy.testing.assert_allclose(after["x_m"], hand.position_m[row:, 0], rtol=0, atol=TOLERANCE)
            self.assertEqual(after["time_s"][0], 0.0)

    def test_a_jump_is_told_with_place_and_size_and_never_accepted_in_silence(self):
        for seed in SEEDS:
            hand, random = Hand(seed), numpy.random.default_rng(seed)
            row, way = int(random.integers(20, 120)), random.normal(size=3)
            size_m = float(random.uniform(0.04, 1.0))
            hand.position_m[row:] += size_m * way / numpy.linalg.norm(way)
            moved_m = numpy.linalg.norm(hand.position_m[row] - hand.position_m[row - 1])
            raw = self.raw(hand)
            line = rf"raw\.csv:{row + 2}: jump of {1e3 * moved_m:.4g} mm in .* ms at {hand.time_s[row]:.4f} s"
            self.refused(FAULTY, line + ".*in all 1 jump: expected none, or --accept jumps", raw)
            self.refused(FAULTY, line, raw, "--accept", "gaps", "--resample", 1000)
            self.assert_same(self.imported(raw, "--accept", "jumps"), hand, False, False)
            speed_m_s = moved_m / (hand.time_s[row] - hand.time_s[row - 1])
            self.imported(raw, "--max-speed", 1.01 * speed_m_s)
            self.refused(FAULTY, line, raw, "--max-speed", 0.9 * (moved_m - 1e-3) / 0.0047)

    def test_poses_that_are_repeated_between_slow_readings_are_no_jumps(self):
        for seed in SEEDS:
            hand = Hand(seed, 800)
            held = numpy.arange(800) // 15 * 15
            hand.position_m = hand.position_m[held]
            self.assert_same(self.imported(self.raw(hand)), hand, False, False)

    def test_an_orientation_that_leaps_is_told(self):
        hand = Hand(2)
        half_turn = numpy.array([1.0, 0.0, 0.0, 0.0])
        values = numpy.hstack([hand.time_s[:, None], hand.position_m, hand.turns])
        values[60, 4:] = half_turn
        names = "time_s,x_m,y_m,z_m,qx,qy,qz,qw\n"
        raw = self.write("raw.csv", names + "".join(",".join(map(repr, row)) + "\n" for row in values.tolist()))
        self.refused(FAULTY, r"raw\.csv:6[23]: turn of \d+.* degrees in .*in all 2 turns: expected none, or --accept "
                     "jumps", raw)

    def test_a_value_that_is_missing_is_a_line_or_a_gap_that_is_judged(self):
        for seed in SEEDS:
            hand = Hand(seed)
            text = self.raw(hand).read_text().splitlines()
            first, count = 30 + seed, 3 + 20 * (seed % 2) * 3
            for line in range(first, first + count):
                text[line] = text[line].rpartition(",")[0] + (",NaN" if seed % 3 else ",")
            raw = self.write("holes.csv", "\n".join([*text, ""]))
            value = "NaN" if seed % 3 else ""
            self.refused(COULD_NOT_RUN, rf"holes\.csv:{first + 1}: column z_m: value '{value}': expected a finite", raw)
            if seed % 2:
                self.refused(FAULTY, rf"holes\.csv:{first + count + 1}: gap of ", raw, "--drop-invalid")
            else:
                got = self.imported(raw, "--drop-invalid")
                kept = numpy.delete(hand.position_m[:, 1], range(first - 1, first - 1 + count))
                numpy.testing.assert_allclose(got["y_m"], kept, rtol=0, atol=TOLERANCE)

    def test_resampled_rows_are_even_and_lie_on_the_path(self):
        for seed in SEEDS:
            hand = Hand(seed)
            values = numpy.hstack([hand.time_s[:, None], hand.position_m, hand.turns])
            names = "time_s,x_m,y_m,z_m,qx,qy,qz,qw\n"
            raw = self.write("raw.csv", names + "".join(",".join(map(repr, row)) + "\n" for row in values.tolist()))
            got = self.imported(raw, "--resample", 730.0)
            numpy.testing.assert_allclose(numpy.diff(got["time_s"]), 1.0 / 730.0, rtol=1e-9)
            self.assertLess(hand.time_s[-1] - got["time_s"][-1], 1.0 / 730.0)
            for k, name in enumerate(("x_m", "y_m", "z_m")):
                straight_m = numpy.interp(got["time_s"], hand.time_s, hand.position_m[:, k])
                numpy.testing.assert_allclose(got[name], straight_m, rtol=0, atol=TOLERANCE)
            turns = numpy.stack([got[name] for name in ("qx", "qy", "qz", "qw")], axis=1)
            numpy.testing.assert_allclose(numpy.linalg.norm(turns, axis=1), 1.0, rtol=0, atol=TOLERANCE)
            # Between two rows it has turned by as large a share of their angle as of their time.
            after = numpy.clip(numpy.searchsorted(hand.time_s, got["time_s"], side="right"), 1, len(hand.time_s) - 1)
            apart_rad = rotations.angles_rad(hand.turns)[after - 1]
            share = (got["time_s"] - hand.time_s[after - 1]) / numpy.diff(hand.time_s)[after - 1]
            for end, turned_rad in ((after - 1, share * apart_rad), (after, (1.0 - share) * apart_rad)):
                inner = numpy.abs((turns * hand.turns[end]).sum(axis=1)).clip(0.0, 1.0)
                numpy.testing.assert_allclose(2.0 * numpy.arccos(inner), turned_rad, rtol=0, atol=1e-6)


class ReplayTest(imports.ImportTest):
    FOLDER = daemons.DATA / "trajectories"
    LEVER = ("--position", "slave_rad*0.075,0,0:m", "--force", "Fe_Nm*13.333333333333334,0,0:N")
    RAW = {"franka_1khz/franka_20260223_162545.csv": (), "teleop_1dof_2khz/m2_question1a_spring.csv": LEVER,
           "teleop_1dof_2khz/question1a_free_motion.csv": LEVER,
           "ku_contour_force/contour_edge_mm.csv": ("--rate", "20", "--position", "#1,#2,#3:mm"),
           **{f"ku_contour_force/demo_{name}.csv": () for name in
              ("a_1", "a_2", "b_1", "b_2", "c_1", "c_2", "d_1", "d_2")}}

    def played(self, file, seconds):
        return read(self.run_lockstep(daemons.SCENES / "wall.toml", f"replay:file={file},offset_z_m=1", seconds))

    def test_what_was_imported_is_played_where_the_hand_was(self):
        for seed in SEEDS[:3]:
            hand = Hand(seed)
            numpy.savez(self.folder / "raw.npz", t=1e3 * hand.time_s, R=hand.matrices(), p=1e3 * hand.position_m)
            self.imported(self.folder / "raw.npz", "--time", "t:ms", "--position", "p:mm", "--orientation", "R:matrix")
            got = self.played(self.folder / "out.csv", round(0.9 * float(hand.time_s[-1]), 3))
            for k, name in enumerate(("x_m", "y_m")):
                there_m = numpy.interp(got["time_s"], hand.time_s, hand.position_m[:, k])
                numpy.testing.assert_allclose(got[name], there_m, rtol=0, atol=1e-9)
            turns = rotations.between(hand.time_s, hand.turns, got["time_s"])
            inner = numpy.abs((turns * numpy.stack([got[name] for name in ("qx", "qy", "qz", "qw")], 1)).sum(axis=1))
            numpy.testing.assert_allclose(inner, 1.0, rtol=0, atol=1e-9)

    def test_each_recording_of_a_laboratory_is_imported_and_played(self):
        if not self.FOLDER.is_dir():
            self.skipTest(f"skipped: {self.FOLDER} is absent")
        others = {str(file.relative_to(self.FOLDER)) for file in self.FOLDER.glob("*/*.csv")} - self.RAW.keys()
        self.assertEqual(others, set())
        for name, options in self.RAW.items():
            with self.subTest(name):
                got = self.imported(self.FOLDER / name, *options)
                played = self.played(self.folder / "out.csv", 0.5)
                there_m = numpy.interp(played["time_s"], got["time_s"], got["x_m"])
                numpy.testing.assert_allclose(played["x_m"], there_m, rtol=0, atol=1e-9)

    def test_an_installed_program_draws_and_writes_the_same(self):
        prefix = self.folder / "prefix"
        subprocess.run(["cmake", "--install", daemons.BUILD, "--prefix", prefix, "--component", "stillgrid_import"],
                       check=True, stdout=subprocess.DEVNULL)
        hand = Hand(4)
        numpy.savez(self.folder / "raw.npz", time_s=hand.time_s, pos_m=hand.position_m)
        options = ("--position", "pos_m:m", "--picture", self.folder / "look.png")
        got = self.imported(self.folder / "raw.npz", *options, program=prefix / "bin" / "stillgrid_import")
        self.assert_same(got, hand, False, False)
        self.assertEqual((self.folder / "look.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        version = self.run_import("--version", program=prefix / "bin" / "stillgrid_import")
        own = (daemons.ROOT / "VERSION").read_text().strip()
        self.assertEqual(version.stdout, f"stillgrid_import {own}\n")


if __name__ == "__main__":
    daemons.main()
