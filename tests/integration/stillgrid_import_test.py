#!/usr/bin/python3
"""scripts/stillgrid_import reads what laboratories write: text, arrays and messages come back as they were."""
import gzip
import shlex
import zlib

import numpy

import daemons
import imports
from imports import COULD_NOT_RUN, DONE, SEEDS, TOLERANCE, Hand, mcap, read

LENGTHS = {"m": 1.0, "mm": 1e3, "cm": 1e2}
TIMES = {"s": 1.0, "ms": 1e3, "us": 1e6}


class TextTest(imports.ImportTest):
    STYLES = (  # delimiter, decimal point, top, names of time, position, orientation (its order), force
        (",", ".", "# of a rig\n", "time_{t}", "{a}_{u}", "q{a}", "xyzw", "f{a}_N"),
        (";", ",", "Rig 3; of a laboratory\n", "Time [{t}]", "Pos{A} [{u}]", "quat_{a}", "wxyz", "F{A} [N]"),
        ("\t", ".", "% more\n%\n", "timestamp ({t})", "tcp_{a} ({u})", "Q{a}", "xyzw", "Force {A} (N)"),
        ("|", ".", "// none\n", "t_{t}", "pose.position.{a}/{u}", "pose.orientation.{a}", "wxyz", "wrench.force.{a}_N"),
        (" ", ".", "", "elapsed_{t}", "tip_{a}_{u}", "q{a}", "wxyz", "F{a}_N"))

    def text(self, hand, style, length, time):
        delimiter, point, top, t, position, turn, order, force = style
        names = [t, *(position.replace("{a}", a).replace("{A}", a.upper()) for a in "xyz"),
                 *(turn.replace("{a}", a) for a in order),
                 *(force.replace("{a}", a).replace("{A}", a.upper()) for a in "xyz")]
        names = ['"' + name.replace("{t}", time).replace("{u}", length) + '"' for name in names]
        turns = hand.turns[:, ["xyzw".index(a) for a in order]]
        values = numpy.hstack([hand.time_s[:, None] * TIMES[time] + 51.3, hand.position_m * LENGTHS[length], turns,
                               hand.force_N])
        rows = (delimiter.join(repr(float(value)).replace(".", point) for value in row) for row in values)
        return top + delimiter.join(names) + "\n" + "\n".join(rows) + "\n"

    def test_text_of_any_style_comes_back_as_it_was_without_an_option(self):
        for seed in SEEDS:
            hand, style = Hand(seed), self.STYLES[seed - 1]
            for length, time in (("mm", "ms"), ("m", "s"), ("cm", "us")):
                with self.subTest(seed=seed, length=length):
                    text = self.text(hand, style, length, time)
                    self.assert_same(self.imported(self.write(f"raw{seed}.dat", text)), hand)
            packed = self.folder / f"raw{seed}.csv.gz"
            packed.write_bytes(gzip.compress(text.replace("\n", "\r\n").encode()))
            self.assert_same(self.imported(packed), hand)

    def test_a_row_of_units_columns_of_any_name_and_whole_nanoseconds_are_read(self):
        for seed in SEEDS:
            hand = Hand(seed)
            hand.time_s = numpy.round(hand.time_s, 9)
            start_ns = 1714550400123456789 + seed
            rows = [f"{start_ns + round(1e9 * t)},{1e3 * x!r},{1e3 * y!r},{1e3 * z!r}" for t, (x, y, z)
                    in zip(hand.time_s.tolist(), hand.position_m.tolist())]
            units = self.write("units.csv", "\n".join(["stamp,tip x,tip y,tip z", "ns,mm,mm,mm", *rows, ""]))
            self.assert_same(self.imported(units), hand, False, False)
            odd = self.write("odd.csv", "\n".join(['A:1,"b, left",c*2,"d ""e"""', *rows, ""]))
            got = self.imported(odd, "--time", '"A:1":ns', "--position", '"b, left"*0.5,"c*2","d ""e""":mm')
            got["x_m"] *= 2.0
            self.assert_same(got, hand, False, False)
            bare = self.write("bare.txt", "\n".join([*rows, ""]))
            self.assert_same(self.imported(bare, "--time", "#1:ns", "--position", "#2,#3,#4:mm"), hand, False, False)

    def test_the_layouts_of_programs_that_many_laboratories_use_are_read(self):
        """rostopic echo -p, Motive, Qualisys: a header behind %, names given twice, numbers above the header."""
        for seed in SEEDS:
            hand = Hand(seed)
            hand.time_s = numpy.round(hand.time_s, 9)
            stamps_ns = (numpy.round(hand.time_s * 1e9).astype(int) + 1714550400 * 10**9).tolist()
            turns, places = ([",".join(map(repr, row)) for row in rows.tolist()]
                             for rows in (hand.turns, hand.position_m))
            pose = ",".join(f"field.pose.{part}" for part in (*(f"position.{a}" for a in "xyz"),
                                                              *(f"orientation.{a}" for a in "xyzw")))
            rows = (f"{t},{k},base,{p},{q}" for k, (t, p, q) in enumerate(zip(stamps_ns, places, turns)))
            ros = self.write("ros.csv", "\n".join([f"%time,field.header.seq,frame_id,{pose}", *rows, ""]))
            options = ("--position", ",".join(pose.split(",")[:3]) + ":m")
            self.assert_same(self.imported(ros, "--time", "time:ns", *options), hand, True, False)
            rows = (f"{k},{t!r},{q},{p}" for k, (t, p, q) in enumerate(zip(hand.time_s.tolist(), places, turns)))
            motive = self.write("motive.csv", "\n".join(
                ["Format Version,1.23,Capture Frame Rate,100.0", ",,Rotation,,,,Position,,",
                 "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z", *rows, ""]))
            self.refused(COULD_NOT_RUN, "position: no column found", motive)  # rather than the first X, Y, Z
            got = self.imported(motive, "--position", "#7,#8,#9:m", "--orientation", "#3,#4,#5,#6:xyzw")
            self.assert_same(got, hand, True, False)
            rows = (f"{k},{t!r},{p}" for k, (t, p) in enumerate(zip(hand.time_s.tolist(), places)))
            text = "\n".join(["NO_OF_FRAMES,300", "TIME_STAMP,2024-05-01 10:00:00.000,123.45",
                              "Frame,Time,tip X,tip Y,tip Z", *rows, ""]).replace(",", "\t")
            tracked = self.write("qualisys.tsv", text)
            got = self.imported(tracked, "--time", "Time:s", "--position", "tip X,tip Y,tip Z:m")
            self.assert_same(got, hand, False, False)

    def test_rows_without_a_time_come_at_a_rate_and_stamps_of_a_clock_are_read(self):
        hand = Hand(7)
        positions = [",".join(map(repr, row)) for row in hand.position_m.tolist()]
        got = self.imported(self.write("even.csv", "\n".join(["x_m,y_m,z_m", *positions, ""])), "--rate", 240.0)
        hand.time_s = numpy.arange(len(positions)) / 240.0
        self.assert_same(got, hand, False, False)
        hand.time_s = numpy.arange(len(positions)) * 0.004
        stamps = [f"2024-05-01 12:00:{second:02d}.{ms:03d}" for second, ms
                  in (divmod(4 * k, 1000) for k in range(len(positions)))]
        clock = self.write("clock.csv", "\n".join(["when,x_m,y_m,z_m", *map(",".join, zip(stamps, positions)), ""]))
        self.assert_same(self.imported(clock), hand, False, False)

    def test_the_command_that_a_look_ends_with_writes_the_trajectory(self):
        for seed in SEEDS:
            hand = Hand(seed)
            values = numpy.hstack([1e3 * hand.time_s[:, None], 1e3 * hand.position_m, hand.force_N])
            rows = "\n".join(",".join(map(repr, row)) for row in values.tolist())
            raw = self.write(f"it is raw {seed}.csv", '"t","x","y","z","F x","F y","F z"\n' + rows + "\n")
            self.refused(COULD_NOT_RUN, r"columns t: value '': time whose unit nobody states: expected --time t:K",
                         raw)
            (self.folder / "trajectory.csv").unlink(missing_ok=True)
            run = self.run_import(raw)
            self.assertEqual(run.returncode, DONE, run.stderr)
            last = shlex.split(run.stdout.splitlines()[-1].removeprefix("to write:"))
            self.assertEqual(last[0], "stillgrid_import")
            self.assertFalse((self.folder / "trajectory.csv").exists())
            run = self.run_import(*last[1:])
            self.assertEqual(run.returncode, DONE, run.stdout + run.stderr)
            self.assert_same(read(self.folder / "trajectory.csv"), hand, False, True)


class ArraysTest(imports.ImportTest):
    def arrays(self, hand):
        """Each way that an orientation is written, and the option that it takes."""
        turns = hand.turns
        return {"xyzw": ({"q": turns}, "q:xyzw"), "wxyz": ({"quat": turns[:, [3, 0, 1, 2]]}, "quat:wxyz"),
                "matrix": ({"R": hand.matrices()}, "R:matrix"),
                "columns": ({"R": hand.matrices().transpose(0, 2, 1)}, "R:matrix_columns"),
                "vector": ({"rotvec": hand.vectors_rad}, "rotvec:rotation_vector"),
                "degrees": ({"rotvec": numpy.degrees(hand.vectors_rad)}, "rotvec:rotation_vector_deg")}

    def others(self, hand):
        return {"time": 1e3 * hand.time_s, "pos": 1e2 * hand.position_m, "force": hand.force_N}

    OPTIONS = ("--time", "time:ms", "--position", "pos:cm", "--force", "force:N")

    def assert_comes_back(self, write):
        """write(arrays) gives the file."""
        for seed in SEEDS:
            hand = Hand(seed)
            for name, (turn, option) in self.arrays(hand).items():
                with self.subTest(seed=seed, orientation=name):
                    raw = write(self.others(hand) | turn)
                    self.assert_same(self.imported(raw, *self.OPTIONS, "--orientation", option), hand)

    def test_npz_and_npy_come_back_as_they_were(self):
        def write(arrays):
            numpy.savez_compressed(self.folder / "raw.npz", **arrays, rig=numpy.array("a name"), other=numpy.zeros(7))
            return self.folder / "raw.npz"

        self.assert_comes_back(write)
        for seed in SEEDS:
            hand = Hand(seed)
            numpy.save(self.folder / "raw.npy", numpy.hstack([hand.time_s[:, None], hand.position_m, hand.turns]).T)
            got = self.imported(self.folder / "raw.npy", "--time", "#1:s", "--position", "#2,#3,#4:m", "--orientation",
                                "#5,#6,#7,#8:xyzw")
            self.assert_same(got, hand, True, False)

    def test_mat_comes_back_as_it_was(self):
        scipy_io = self.package("scipy.io")

        def write(arrays):
            scipy_io.savemat(self.folder / "raw.mat", {"run": {"robot": arrays | {"time": arrays["time"][:, None]},
                                                               "name": "of a test"}, "gains": numpy.eye(3)})
            return self.folder / "raw.mat"

        self.OPTIONS = ("--within", "run.robot", *self.OPTIONS)
        self.assert_comes_back(write)

    def test_hdf5_and_mat_of_7_3_come_back_as_they_were(self):
        h5py = self.package("h5py")

        def write(arrays, is_matlab=False):
            file = self.folder / ("raw73.mat" if is_matlab else "raw.h5")
            with h5py.File(file, "w", userblock_size=512 if is_matlab else 0) as stream:
                for name, array in arrays.items():
                    stream[f"data/demo_3/{name}"] = array.T if is_matlab else array
                stream["data/demo_4/pos"] = numpy.zeros((5000, 3))
            if is_matlab:
                with open(file, "r+b") as stream:
                    stream.write(b"MATLAB 7.3 MAT-file".ljust(512))
            return file

        self.OPTIONS = ("--within", "data/demo_3", *self.OPTIONS)
        self.assert_comes_back(write)
        self.assert_comes_back(lambda arrays: write(arrays, is_matlab=True))

    def test_units_that_hdf5_states_are_taken(self):
        h5py = self.package("h5py")
        hand = Hand(3)
        with h5py.File(self.folder / "units.h5", "w") as stream:
            for name, values, unit in (("time", 1e3 * hand.time_s, "ms"), ("pos", 1e3 * hand.position_m, "mm"),
                                       ("force", 1e3 * hand.force_N, "mN")):
                stream[name] = values
                stream[name].attrs["units"] = unit
        self.assert_same(self.imported(self.folder / "units.h5"), hand, False, True)

    def test_poses_of_four_by_four_are_found_either_way_round(self):
        for seed in SEEDS:
            hand = Hand(seed)
            for name, transforms in (("rows", hand.transforms()), ("columns", hand.transforms().transpose(0, 2, 1))):
                with self.subTest(seed=seed, order=name):
                    numpy.savez(self.folder / "pose.npz", time_s=hand.time_s, O_T_EE=transforms.reshape(-1, 16))
                    look = self.run_import(self.folder / "pose.npz").stdout.splitlines()[-1]
                    run = self.run_import(*shlex.split(look.removeprefix("to write:"))[1:])
                    self.assertEqual(run.returncode, DONE, run.stdout + run.stderr)
                    self.assert_same(read(self.folder / "trajectory.csv"), hand, True, False)


class McapTest(imports.ImportTest):
    def messages(self, hand):
        return [(1714550400 * 10**9 + round(t * 1e9),
                 {"pose": {"position": dict(zip("xyz", p)), "orientation": dict(zip("xyzw", q))}, "frame_id": "world",
                  "force": dict(zip("xyz", f))})
                for t, p, q, f in zip(hand.time_s.tolist(), hand.position_m.tolist(), hand.turns.tolist(),
                                      hand.force_N.tolist())]

    OPTIONS = ("--position", "pose.position.x,pose.position.y,pose.position.z:m", "--force",
               "force.x,force.y,force.z:N")

    def hand(self, seed):
        hand = Hand(seed)
        hand.time_s = numpy.round(hand.time_s, 9)
        return hand

    def test_mcap_comes_back_as_it_was_packed_or_not_and_up_to_where_it_was_cut_off(self):
        zstandard, lz4 = self.package("zstandard"), self.package("lz4.frame")
        bomb = mcap([(0, {})], "/a", lambda inner: zstandard.ZstdCompressor().compress(inner + bytes(10**6)), "zstd")
        (self.folder / "bomb.mcap").write_bytes(bomb)
        self.refused(COULD_NOT_RUN, r"bomb\.mcap: cannot be read: chunk 1 states \d+ bytes and holds more",
                     "bomb.mcap")
        packings = ((None, ""), (bytes, ""), (zstandard.ZstdCompressor().compress, "zstd"), (lz4.compress, "lz4"))
        for seed in SEEDS:
            hand = self.hand(seed)
            for packing, name in packings:
                with self.subTest(seed=seed, packing=name):
                    raw = self.folder / "raw.mcap"
                    raw.write_bytes(mcap(self.messages(hand), "/tool", packing, name))
                    self.assert_same(self.imported(raw, *self.OPTIONS), hand)
            plain = mcap(self.messages(hand), "/tool")
            raw.write_bytes(plain[:len(plain) * 2 // 3])
            got = self.imported(raw, *self.OPTIONS)
            rows = len(got["time_s"])
            self.assertGreater(rows, len(hand.time_s) // 2)
            numpy.testing.assert_allclose(got["x_m"], hand.position_m[:rows, 0], rtol=0, atol=TOLERANCE)
            self.assertIn("the file was cut off", self.run_import(raw).stdout)

    def test_a_byte_that_its_CRC_does_not_know_is_a_line_that_names_the_chunk(self):
        messages, raw = self.messages(self.hand(3))[:40], self.folder / "raw.mcap"
        for packing, place in ((bytes, "chunk 1"), (None, r"all up to byte \d+")):
            whole = mcap(messages, "/tool", packing, crc=zlib.crc32)
            raw.write_bytes(whole)
            self.imported(raw, *self.OPTIONS)
            digit = whole.rindex(b'"position": {"x": ') + len(b'"position": {"x": 0.')
            raw.write_bytes(whole[:digit] + bytes([whole[digit] ^ 1]) + whole[digit + 1:])
            self.refused(COULD_NOT_RUN, rf"raw\.mcap: {place}: CRC-32 \w{{8}}: expected \w{{8}}, as stated", raw)

    def test_a_byte_that_is_wrong_is_a_line_or_a_trajectory_but_no_crash(self):
        random = numpy.random.default_rng(5)
        whole = mcap(self.messages(self.hand(5))[:40], "/tool", bytes, "")
        for trial in range(25):
            broken = bytearray(whole)
            for place in random.integers(8, len(broken), 3):
                broken[place] = random.integers(256)
            raw = self.folder / f"broken{trial}.mcap"
            raw.write_bytes(broken)
            run = self.run_import(raw)
            with self.subTest(trial=trial):
                self.assertIn(run.returncode, (DONE, COULD_NOT_RUN))
                self.assertRegex(run.stderr, r"\A(stillgrid_import: .*\n)?\Z")


if __name__ == "__main__":
    daemons.main()
