#!/usr/bin/python3
"""scripts/stillgrid_import tells what no hand did, says what it cannot do, and writes what replay plays."""
import gzip
import os
import resource
import signal
import subprocess

import numpy

import daemons
import imports
from imports import COULD_NOT_RUN, DONE, FAULTY, IMPORT, SEEDS, TOLERANCE, Hand, mcap, read, rotations


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


class RefusalTest(imports.ImportTest):
    def test_what_cannot_be_read_is_one_line_and_nothing_is_written(self):
        rows = [f"{0.01 * k:.2f},{0.001 * k:.3f},0,0.02,0,0,0,1" for k in range(50)]
        head = "time_s,x_m,y_m,z_m,qx,qy,qz,qw"

        def raw(name, change=None, header=head):
            text = list(rows)
            if change:
                line, old, new = change
                self.assertIn(old, text[line - 2])
                text[line - 2] = text[line - 2].replace(old, new, 1)
            return self.write(f"{name}.csv", "\n".join([header, *text, ""]))

        good = raw("good")
        self.write("empty.csv", "")
        self.write("letters.csv", "dear reader\nthis is, no table\n")
        (self.folder / "bytes.bin").write_bytes(bytes(range(256)) * 9)
        (self.folder / "cut.gz").write_bytes(gzip.compress(good.read_bytes())[:-30])
        (self.folder / "bag.bag").write_bytes(b"#ROSBAG V2.0\n")
        numpy.save(self.folder / "pickled.npy", numpy.array([{"a": 1}], object), allow_pickle=True)
        (self.folder / "cut.npz").write_bytes(b"PK\x03\x04 and no more")
        (self.folder / "cut.mcap").write_bytes(b"\x89MCAP0\r\n")
        (self.folder / "cut.mat").write_bytes(b"MATLAB 5.0 MAT-file".ljust(128) + b"\x0e\0\0\0\xff\xff")
        (self.folder / "cut.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(30))
        for file, options, words in (
                ("none.csv", (), r"none\.csv: cannot be read: No such file"),
                ("empty.csv", (), r"empty\.csv: no row: expected"),
                ("letters.csv", (), r"letters\.csv:1: value 'dear reader': expected columns of numbers"),
                ("bytes.bin", (), r"bytes\.bin: neither text nor a known format"),
                ("cut.gz", (), r"cut\.gz: cannot be unpacked: "),
                ("bag.bag", (), r"bag\.bag: a bag of ROS: expected one of ROS 2 as MCAP"),
                ("pickled.npy", (), r"pickled\.npy: cannot be read: pickled objects"),
                ("cut.npz", (), r"cut\.npz: cannot be read: "),
                ("cut.mcap", (), r"cut\.mcap: no message"),
                ("cut.mat", (), r"cut\.mat: (cannot be read|MAT needs Python's scipy)"),
                ("cut.h5", (), r"cut\.h5: (cannot be read|HDF5 needs Python's h5py)"),
                (raw("letter", (12, ",0.010,", ",0.01x,")), (),
                 r"letter\.csv:12: column x_m: value '0\.01x': expected a finite number"),
                (raw("back", (12, "0.10,", "0.05,")), (),
                 r"back\.csv:12: column time_s: value '0\.05': expected a time not before .*, '0\.09'"),
                (raw("ragged", (12, ",0,0,1", ",0,1")), (), r"ragged\.csv:12: 7 fields: expected 8, as in line 2"),
                (raw("long", (12, ",0,0,1", ",0,0,2")), (),
                 r"long\.csv:12: columns qx, qy, qz, qw: a quaternion of length 2"),
                (raw("twice", None, head.replace("qx", "x_m")), (), r"twice\.csv: position: no column found: expected"),
                (good, ("--time", "tame"), r"--time: column 'tame': missing: expected one of time_s, x_m"),
                (good, ("--time", "time_s:h"), "--time: value 'h': expected one of s, ms"),
                (good, ("--position", "x_m,y_m"), "--position: value 'x_m,y_m': 2 columns: expected 3"),
                (good, ("--position", "x_m*y,0,0:m"), r"--position: value 'x_m\*y': expected a number after the star"),
                (good, ("--position", "x_m,y_m,#9:m"), "--position: column '#9': missing"),
                (good, ("--orientation", "qx,qy,qz,qw:matrix"), "4 columns: expected 9"),
                (good, ("--orientation", "x_m,y_m,z_m,x_m,x_m,x_m,x_m,x_m,x_m:matrix"),
                 r"good\.csv:2: columns .*: a matrix that is no rotation"),
                (good, ("--rate", "0"), "--rate: value '0': expected hertz"),
                (good, ("--rate", "100", "--time", "time_s"),
                 "--rate: value 100: expected no such option beside --time"),
                (good, ("--from", "3", "--to", "2"), "--from: value 3: expected less than --to, 2"),
                (good, ("--from", "3"), r"good\.csv: 0 rows from 3 to inf s"),
                (good, ("--accept", "all"), "--accept: value 'all': expected gaps, jumps or gaps,jumps"),
                (good, ("--within", "a"), "--within: value 'a': expected no such option for a file of text"),
                (good, ("--delimiter", "ab"), "--delimiter: value 'ab': expected one character"),
                (good, ("--resample", "1e-3"), "--resample: value 0.001: 1 rows: expected 2 to")):
            with self.subTest(words):
                self.refused(COULD_NOT_RUN, words, file, *options)

    def test_damaged_metadata_of_a_recording_are_a_line_and_those_of_another_file_are_not_read(self):
        for name, read in (("rendered_fx_N", True), ("fx_N", False)):
            raw = self.write("felt.csv", f"time_s,x_m,y_m,z_m,{name}\n0,0,0,0,0\n0.01,0,0,0,0\n")
            self.write("felt.csv-metadata.json", '{"notes": [{"scene": "wa')
            if read:
                self.refused(COULD_NOT_RUN, r"felt\.csv-metadata\.json: cannot be read: expected metadata as", raw)
            else:
                self.imported(raw)

    def test_neither_the_raw_file_nor_a_folder_is_written_over(self):
        good = self.write("good.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n0.01,0,0,0\n")
        before = good.read_bytes()
        for out, words in ((good, "the raw file itself"), (self.folder, "expected a file that can be written"),
                           (self.folder / "none" / "out.csv", "expected a file that can be written")):
            run = self.run_import(good, "--out", out)
            self.assertEqual(run.returncode, COULD_NOT_RUN)
            self.assertRegex(run.stderr, rf"\Astillgrid_import: .*{words}.*\n\Z")
        self.assertEqual(good.read_bytes(), before)

    def test_a_disk_that_is_full_leaves_what_was_there(self):
        rows = "".join(f"{0.01 * k},0,0,{1e-4 * k}\n" for k in range(900))
        good = self.write("good.csv", "time_s,x_m,y_m,z_m\n" + rows)
        out = self.write("out.csv", "as it was\n")

        def fill():
            resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))

        run = self.run_import(good, "--out", out, preexec_fn=fill)
        self.assertEqual((run.returncode, run.stderr), (COULD_NOT_RUN, f"stillgrid_import: {out}: File too large\n"))
        self.assertEqual(out.read_text(), "as it was\n")
        self.assertEqual(sorted(file.name for file in self.folder.iterdir()), ["good.csv", "out.csv"])

    def test_a_format_whose_package_is_missing_or_crashes_is_a_line(self):
        without = self.folder / "without"
        without.mkdir()
        for name in ("h5py", "scipy", "zstandard", "lz4", "matplotlib"):
            (without / f"{name}.py").write_text("raise ImportError('none')\n")
        environment = {**os.environ, "PYTHONPATH": str(without)}
        (self.folder / "raw.h5").write_bytes(b"\x89HDF\r\n\x1a\n")
        (self.folder / "raw73.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n")
        (self.folder / "raw5.mat").write_bytes(b"MATLAB 5.0 MAT-file".ljust(128))
        for name in ("zstd", "lz4"):
            (self.folder / f"{name}.mcap").write_bytes(mcap([], "/tool", bytes, name))
        for file, words in (("raw.h5", "HDF5 needs Python's h5py.*apt install python3-h5py"),
                            ("raw73.mat", "MAT 7.3 needs Python's h5py.*apt install python3-h5py"),
                            ("raw5.mat", "MAT needs Python's scipy.io.*apt install python3-scipy"),
                            ("zstd.mcap", "packed by zstd needs Python's zstandard.*apt install python3-zstandard"),
                            ("lz4.mcap", "packed by lz4 needs Python's lz4.frame.*apt install python3-lz4")):
            with self.subTest(file):
                self.refused(COULD_NOT_RUN, words, file, env=environment)
        # One that crashes, as those of HDF5 and MAT do on some wrong bytes.
        (without / "h5py.py").write_text("import os\nos.kill(os.getpid(), 9)\n")
        self.refused(COULD_NOT_RUN, r"raw\.h5: cannot be read: its reader crashed", "raw.h5", env=environment)
        good = self.write("good.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n0.01,0,0,0\n")
        run = self.run_import(good, "--picture", "none.png", env=environment)
        self.assertEqual((run.returncode, run.stderr), (DONE, ""))
        self.assertIn("no picture: none\n", run.stdout)

    def test_without_numpy_each_program_is_a_line(self):
        (self.folder / "numpy.py").write_text("raise ImportError('none')\n")
        for name in ("stillgrid_import", "replay_check", "stiffness_fit"):
            run = self.run_import("--version", program=daemons.ROOT / "scripts" / name,
                                  env={**os.environ, "PYTHONPATH": str(self.folder)})
            line = f"{name}: it needs Python's numpy, which is missing: expected apt install python3-numpy\n"
            self.assertEqual((run.returncode, run.stdout, run.stderr), (COULD_NOT_RUN, "", line))

    def test_who_reads_no_further_and_a_disk_that_is_full_end_it_as_other_programs(self):
        good = self.write("good.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n0.01,0,0,0\n")
        command, (unread, closed) = ["/usr/bin/python3", IMPORT, good], os.pipe()
        os.close(unread)
        run = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, text=True, check=False)
        os.close(closed)
        self.assertEqual((run.returncode, run.stderr), (-signal.SIGPIPE, ""))
        with open("/dev/full", "w") as full:
            run = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        line = "stillgrid_import: standard output: No space left on device\n"
        self.assertEqual((run.returncode, run.stderr), (COULD_NOT_RUN, line))


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
