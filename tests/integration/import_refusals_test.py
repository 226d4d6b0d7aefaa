#!/usr/bin/python3
"""scripts/stillgrid_import says in one line what it cannot read, and leaves what was there."""
import gzip
import os
import re
import resource
import signal
import struct
import subprocess
import zipfile

import numpy

import daemons
import imports
from imports import COULD_NOT_RUN, DONE, IMPORT, mcap


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
        with gzip.open(self.folder / "bomb.csv.gz", "wb", 1) as bomb:
            for _ in range(513):
                bomb.write(b"0,1,2,3\n" * (1 << 17))
        with zipfile.ZipFile(self.folder / "bomb.npz", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as bomb:
            with bomb.open("a.npy", "w") as array:
                for _ in range(513):
                    array.write(bytes(1 << 20))
        (self.folder / "liar.mcap").write_bytes(mcap([], "a", lambda inner: inner + b"!"))
        sizes = []
        chunk = mcap([], "a", lambda inner: sizes.append(len(inner)) or inner)
        (self.folder / "claim.mcap").write_bytes(chunk.replace(struct.pack("<QQQ", 0, 0, sizes[0]),
                                                               struct.pack("<QQQ", 0, 0, 10**9)))
        os.mkfifo(self.folder / "pipe.csv")
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
                ("bomb.csv.gz", (), r"bomb\.csv\.gz: cannot be read: unpacks to more: expected at most 512 MiB"),
                ("bomb.npz", (), r"bomb\.npz: cannot be read: unpacks to 513 MiB: expected at most 512 MiB"),
                ("liar.mcap", (), r"liar\.mcap: cannot be read: chunk 1 states \d+ bytes and holds more"),
                ("claim.mcap", (), r"claim\.mcap: cannot be read: chunk 1 states 1000000000 bytes, 536870912 are left"),
                ("pipe.csv", (), r"pipe\.csv: cannot be read: expected a regular file"),
                ("/dev/zero", (), r"/dev/zero: cannot be read: expected a regular file"),
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

    def test_one_row_and_a_time_that_stands_still_are_told_as_what_they_are(self):
        one = self.write("one.csv", "time_s,x_m,y_m,z_m\n3,0,0,0\n")
        self.refused(COULD_NOT_RUN, r"one\.csv:2: the only row: expected 2 at least", one)
        for stamps in ((3, 3, 3), (1, 1, 1, 1, 1, 1, 1, 2)):
            rows = "".join(f"{stamp},0,0,{k}\n" for k, stamp in enumerate(stamps))
            still = self.write("still.csv", "time_s,x_m,y_m,z_m\n" + rows)
            line = rf"still\.csv:3: column time_s: value '{stamps[0]}': expected a time after that of the row above"
            self.refused(COULD_NOT_RUN, line, still)
            self.assertRegex(self.run_import(still).stdout, "lacking: .*" + line)

    def test_columns_that_look_like_an_orientation_are_never_left_out_without_a_word(self):
        matrix = [f"r{row}{column}" for row in "123" for column in "123"]
        for names in (["Roll [deg]", "Pitch [deg]", "Yaw [deg]"], ["rx", "ry", "rz"], matrix, ["q.w", "q.x", "q.y"]):
            head, values = ",".join(["time_s,x_m,y_m,z_m", *names, "yaw_rate"]), ",0" * (4 + len(names))
            raw = self.write("raw.csv", f"{head}\n0{values}\n0.01{values}\n")
            line = rf"orientation  none found; not taken: {re.escape(', '.join(names))}, which look like one: --orient"
            self.assertRegex(self.run_import(raw).stdout, line)
            self.assertRegex(self.run_import(raw, "--out", self.folder / "out.csv").stdout, line)
            self.assertIn("orientation  none found\n", self.run_import(raw, "--orientation", "none").stdout)

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


if __name__ == "__main__":
    daemons.main()
