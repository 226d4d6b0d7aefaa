#!/usr/bin/python3
"""A recording as MCAP holds what its CSV holds, and the scene; the libraries of MCAP's makers read it."""
import gzip
import json
import struct
import subprocess
import zlib

import numpy

import daemons
import imports
import mcap_files
from daemons import BAD_INPUT, DONE
from imports import Hand, read

# With a turn, a contact that slips, a limit that clamps, and what is no zero in any column but torque.
PRESS = "phantom:profile=premium15,hand=light,path=stroke,centre_z_m=0.0,depth_m=0.03,amplitude_m=0.02,period_s=0.5"
SECONDS = 1.0

TIME = "================================================================================\nMSG: "
HEADER = (TIME + "std_msgs/Header\n# of all\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
          + TIME + "builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n")
VECTOR = TIME + "geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
POSE = ("# A pose\nstd_msgs/Header header\nPose pose\n" + HEADER
        + TIME + "geometry_msgs/Pose\nPoint position\nQuaternion orientation\n"
        + TIME + "geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
        + TIME + "geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n")
WRENCH = ("std_msgs/Header header\nWrench wrench\n" + HEADER
          + TIME + "geometry_msgs/Wrench\nVector3 force\nVector3 torque\n" + VECTOR)
JOINTS = ("uint8 MODE=3\nbool is_on\nstring[] name\nstd_msgs/Header header\nuint8 flag\nfloat32[<=3] effort\n"
          "float64[2] limit\nint16 count\ngeometry_msgs/Vector3 tip_position\n" + HEADER + VECTOR)


class McapTest(daemons.SessionTest):
    def record(self, scene, device, seconds, name):
        """Of a lockstep run, by the recording's name in this or that form."""
        file = self.folder / name
        both = ("--lockstep", "--duration", seconds)
        sim = self.sim_server(scene, *both)
        hand = self.haptic_server(device, *both, "--record", file, "--max-force", 0.5)
        self.assertEqual(hand.wait(), DONE, hand.lines())
        self.assertEqual(sim.wait(), DONE, sim.lines())
        return file

    def test_every_number_and_flag_of_a_lockstep_run_is_that_of_its_csv_to_the_bit(self):
        file = self.record("tissue_and_blocks", PRESS, SECONDS, "run.mcap")
        csv = daemons.read_recording(self.record("tissue_and_blocks", PRESS, SECONDS, "run.csv"))
        self.assertGreater(len(set(csv["flags"])), 2)
        self.assertGreater(csv.force_norm_N().max(), 0.4)
        indexed, streamed = mcap_files.Read(file, "indexed"), mcap_files.Read(file, "streamed")
        for reader in (indexed, streamed):
            mcap_files.assert_same_bits(self, reader.rows(), csv)
            self.assertEqual(reader.flags(), list(csv["flags"]))
            self.assertTrue(reader.is_whole)
            about = reader.metadata["stillgrid"]
            self.assertEqual(about, csv.metadata)
            self.assertEqual((about["scene"], about["device"], about["clock"]),
                             ("tissue_and_blocks", "phantom", "virtual"))
        self.assertEqual(indexed.found["topics"].keys(), streamed.found["topics"].keys())
        for topic, found in streamed.found["topics"].items():  # the index leads to all, in the order of time
            by_time = sorted(found["messages"], key=lambda message: int(message[0]))
            self.assertEqual(sorted(indexed.found["topics"][topic]["messages"]), sorted(by_time), topic)
        statistics = indexed.found["statistics"]
        counts = {topic: len(found["messages"]) for topic, found in streamed.found["topics"].items()}
        self.assertEqual(statistics["messageCount"], sum(counts.values()))
        self.assertEqual(sorted(statistics["channelMessageCounts"].values()), sorted(counts.values()))
        self.assertEqual((statistics["messageStartTime"], statistics["messageEndTime"]), (0, 999_000_000))
        self.assertEqual(statistics["chunkCount"], len(indexed.found["chunks"]))
        spans_ns = [chunk["messageEndTime"] - chunk["messageStartTime"] for chunk in indexed.found["chunks"]]
        self.assertLessEqual(max(spans_ns), 250_000_000)

    def test_the_same_run_writes_the_same_bytes_and_by_foxgloves_schemas(self):
        first = self.record("tissue_and_blocks", PRESS, 0.6, "first.mcap")
        second = self.record("tissue_and_blocks", PRESS, 0.6, "second.mcap")
        data = first.read_bytes()
        self.assertEqual(data, second.read_bytes())
        # The makers' reader leaves this one checksum unread: of all that stands before the end of the data.
        summary, = struct.unpack_from("<Q", data, len(data) - 8 - 20)
        end, size, crc = struct.unpack_from("<BQI", data, summary - 13)
        self.assertEqual((end, size, crc), (15, 4, zlib.crc32(data[:summary - 13])))
        checked = mcap_files.run("check", first)
        self.assertEqual(checked[mcap_files.TICK_TOPIC], 600)
        for topic in mcap_files.SCENE_TOPICS:
            self.assertGreater(checked[topic], 0, topic)

    def test_spheres_stand_where_their_body_is_at_the_snapshots_rate(self):
        file = self.record("moving_sphere", self.still_device(0.2, 0, 0), SECONDS, "run.mcap")
        moving = mcap_files.Read(file, "streamed").messages("/scene/moving")
        self.assertEqual(len(moving), 1 + int(SECONDS / 0.033))
        for stamp_ns, update in moving:
            (deletion,), (entity,) = update["deletions"], update["entities"]
            self.assertEqual((deletion["type"], entity["frame_id"], entity["id"]), (1, "scene", "body 0"))
            self.assertEqual(1e9 * entity["timestamp"]["sec"] + entity["timestamp"]["nsec"], stamp_ns)
            (sphere,) = entity["spheres"]
            self.assertEqual(set(sphere["size"].values()), {0.02})
            at = sphere["pose"]["position"]
            # A snapshot shows the scene where it is when the next one comes at the latest.
            self.assertLessEqual(abs(at["x"] + 0.05 - 0.1e-9 * stamp_ns), 0.1 * 0.033 + 1e-6)
            self.assertEqual((at["y"], at["z"]), (0.0, 0.0))
        steps_m = numpy.diff([update["entities"][0]["spheres"][0]["pose"]["position"]["x"] for _, update in moving])
        numpy.testing.assert_allclose(steps_m, 0.1 * 0.033, atol=1e-7)

    def test_what_stands_still_is_recorded_once(self):
        file = self.record("wall", self.still_device(0, 0, 0.05), SECONDS, "run.mcap")
        reader = mcap_files.Read(file, "indexed")
        for topic in mcap_files.SCENE_TOPICS:
            self.assertEqual(len(reader.messages(topic)), 1, topic)
        (_, fixed), = reader.messages("/scene/fixed")
        self.assertTrue(fixed["entities"], "a wall is shown")
        (_, tool), = reader.messages("/tool/spheres")
        self.assertEqual(tool["entities"][0]["frame_id"], "tool")

    def test_a_recording_becomes_the_trajectory_that_its_csv_is(self):
        device = "phantom:profile=premium15,hand=light,path=press,period_s=0.4"
        mcap, csv = (self.record("wall", device, SECONDS, name) for name in ("run.mcap", "run.csv"))
        trajectory = self.folder / "trajectory.csv"
        done = subprocess.run([imports.IMPORT, mcap, "--out", trajectory], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (DONE, ""), done.stdout)
        got, there = read(trajectory), daemons.read_recording(csv)
        for name in ("time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", "fx_N", "fy_N", "fz_N"):
            numpy.testing.assert_allclose(got[name], there[name], rtol=0, atol=1e-12 if name == "time_s" else 0)
        played = [self.record("wall", f"replay:file={file}", 0.9, f"{file.stem}-again.csv")
                  for file in (trajectory, csv)]
        forces = [daemons.read_recording(file).force_N for file in played]
        numpy.testing.assert_allclose(*forces, rtol=0, atol=1e-9)
        self.assertGreater(abs(forces[0]).max(), 0.1)

    def assert_no_csv(self, file, of_device, of_viewer, of_python):
        """Each reader of CSV says in a line what the file is."""
        self.assert_refused(self.haptic_server(f"replay:file={file}"), BAD_INPUT, *of_device)
        viewer = self.start(daemons.BUILD / "bin" / "scene_viewer", "--recording", file)
        self.assertEqual(viewer.wait(5), BAD_INPUT)
        self.assertRegex("\n".join(viewer.lines()), of_viewer)
        with self.assertRaisesRegex(ValueError, of_python):
            daemons.read_recording(file)

    def test_who_plays_csv_says_in_a_line_what_an_mcap_file_is(self):
        file = self.folder / "run.mcap"
        file.write_bytes(b"\x89MCAP0\r\n\x01")
        self.sim_server("wall")
        self.assert_no_csv(file, ("run.mcap: an MCAP file", "stillgrid_import"),
                           r"\A.*run\.mcap: an MCAP file: .*stillgrid_import.*\Z",
                           r"run\.mcap: an MCAP file: .*stillgrid_import run\.mcap")

    def test_who_plays_csv_says_in_a_line_that_a_file_is_compressed(self):
        file = self.folder / "run.csv.gz"
        file.write_bytes(gzip.compress(self.run_lockstep("wall", PRESS, 0.1).read_bytes()))
        self.assert_no_csv(file, ("run.csv.gz: compressed by gzip: expected text, as gunzip makes",),
                           r"\A.*run\.csv\.gz: compressed by gzip: .* gunzip makes\Z",
                           r"run\.csv\.gz: compressed by gzip: .* gunzip run\.csv\.gz makes")


def plotjuggler_split(line):
    """PlotJuggler's rule of fields: at commas outside of quotes, blanks around left out; a comma at the end opens one
    more [DataLoadCSV, SplitLine]."""
    return [] if line == "" else [part.strip() for part in line.split(",")]


class CsvTest(daemons.SessionTest):
    def test_a_csv_opens_by_plotjugglers_rules_and_by_numpys(self):
        file = self.run_lockstep("wall", PRESS, 0.5)
        lines = file.read_text().splitlines()
        self.assertNotIn('"', file.read_text())
        names = plotjuggler_split(lines[0])  # the first line names the columns; time is one of them
        self.assertEqual(len(set(names)), len(names))
        self.assertEqual(names[0], "time_s")
        self.assertGreater(lines[0].count(","), max(lines[0].count(other) for other in ";\t "))
        series = {name: [] for name in names}
        for line in lines[1:]:
            parts = plotjuggler_split(line)
            self.assertEqual(len(parts), len(names))  # else it stops
            for name, part in zip(names, parts):
                series[name].append(part)
        times = [float(part) for part in series["time_s"]]
        self.assertTrue((numpy.diff(times) > 0.0).all())
        mine = daemons.read_recording(file)
        table = numpy.genfromtxt(file, delimiter=",", names=True, dtype=None, encoding="utf-8")
        self.assertEqual(table.dtype.names, tuple(names))
        for name in set(names) - {"flags"}:
            self.assertEqual([float(part) for part in series[name]], list(mine[name]), name)
            self.assertEqual(list(table[name]), list(mine[name]), name)
        self.assertEqual(list(table["flags"]), list(mine["flags"]))

    def test_a_recording_with_metadata_above_it_is_read_with_them(self):
        today = self.run_lockstep("wall", PRESS, 0.3)
        metadata = daemons.read_recording(today).metadata
        self.assertEqual((metadata["scene"], metadata["device"]), ("wall", "phantom"))
        before = self.write("before.csv", f"# scene: wall\n# device: phantom\n{today.read_text()}")
        recording = daemons.read_recording(before)
        self.assertEqual(recording.metadata, {"scene": "wall", "device": "phantom"})
        self.assertEqual(list(recording["fz_N"]), list(daemons.read_recording(today)["fz_N"]))
        again = [self.run_lockstep("wall", f"replay:file={file}", 0.25).read_bytes() for file in (today, before)]
        self.assertEqual(*again)
        broken = self.write("broken.csv", today.read_text())
        self.write("broken.csv-metadata.json", '{"notes": 3}')
        with self.assertRaisesRegex(ValueError, r"broken\.csv-metadata\.json: cannot be read: expected"):
            daemons.read_recording(broken)


class BagTest(imports.ImportTest):
    """Bags of ROS 2, written by the libraries of Foxglove."""

    def bag(self, name, **topics):
        file = self.folder / name
        mcap_files.run("bag", file, json.dumps({f"/{topic}": dict(zip(("type", "definition", "messages"), parts))
                                                for topic, parts in topics.items()}))
        return file

    def hand(self, seed):
        hand = Hand(seed, 60)
        hand.time_s = numpy.round(hand.time_s, 9)
        return hand

    def stamped(self, hand, messages):
        start_ns = 1714550400 * 10**9
        header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "world"}
        return [[str(start_ns + round(t * 1e9)), {"header": header, **message}]
                for t, message in zip(hand.time_s.tolist(), messages)]

    def poses(self, hand):
        return self.stamped(hand, ({"pose": {"position": dict(zip("xyz", p)), "orientation": dict(zip("xyzw", q))}}
                                   for p, q in zip(hand.position_m.tolist(), hand.turns.tolist())))

    def wrenches(self, hand):
        return self.stamped(hand, ({"wrench": {"force": dict(zip("xyz", f)), "torque": dict.fromkeys("xyz", 0.5)}}
                                   for f in hand.force_N.tolist()))

    def test_poses_and_wrenches_of_a_bag_come_back_without_a_map(self):
        for seed in (1, 2):
            hand = self.hand(seed)
            raw = self.bag("bag.mcap", pose=("geometry_msgs/msg/PoseStamped", POSE, self.poses(hand)),
                           wrench=("geometry_msgs/msg/WrenchStamped", WRENCH, self.wrenches(hand)))
            self.assert_same(self.imported(raw), hand)
        late = self.hand(3)
        late.time_s[1:] += 1e-4
        raw = self.bag("bag.mcap", pose=("geometry_msgs/msg/PoseStamped", POSE, self.poses(hand)),
                       wrench=("geometry_msgs/msg/WrenchStamped", WRENCH, self.wrenches(late)))
        self.assert_same(self.imported(raw), hand, has_force=False)  # of other stamps: not the same rows
        self.assertIn("left out: topics /wrench (60)", self.run_import(raw).stdout)

    def test_lists_texts_and_small_numbers_of_a_bag_keep_their_places(self):
        hand = self.hand(4)
        messages = self.stamped(hand, ({
            "is_on": True, "name": ["a", "bcd"][:k % 3], "flag": 7, "effort": [1.5], "limit": [-1.0, k], "count": -k,
            "tip_position": dict(zip("xyz", p))} for k, p in enumerate(hand.position_m.tolist())))
        raw = self.bag("bag.mcap", joints=("robot_msgs/msg/Joints", JOINTS, messages))
        run = self.run_import(raw)
        look = run.stdout
        self.assertEqual(run.stderr, "", run.stderr)
        for column in ("flag", "effort[0]", "limit[1]", "count", "tip_position.z"):
            self.assertIn(f" {column} ", look)
        got = self.imported(raw, "--position", "tip_position.x,limit[1],count:m", "--accept", "jumps")
        numpy.testing.assert_allclose(got["x_m"], hand.position_m[:, 0], rtol=0, atol=1e-12)
        self.assertEqual(list(got["y_m"]), list(range(60)))
        self.assertEqual(list(got["z_m"]), [-k for k in range(60)])

    def test_a_bag_that_is_not_as_it_says_is_a_line(self):
        bag = self.bag("bag.mcap", pose=("geometry_msgs/msg/PoseStamped", POSE, self.poses(self.hand(5))))
        whole = imports.without_crcs(bag.read_bytes())
        random = numpy.random.default_rng(7)
        for trial in range(12):
            broken = bytearray(whole)
            for place in random.integers(8, len(broken), 4):
                broken[place] = random.integers(256)
            raw = self.folder / "broken.mcap"
            raw.write_bytes(broken)
            run = self.run_import(raw)
            with self.subTest(trial=trial):
                self.assertIn(run.returncode, (imports.DONE, imports.COULD_NOT_RUN))
                self.assertRegex(run.stderr, r"\A(stillgrid_import: .*\n)?\Z")
        renamed = self.folder / "renamed.mcap"
        renamed.write_bytes(whole.replace(b"geometry_msgs/Quaternion", b"geometry_msgs/Quadernion"))
        self.refused(imports.COULD_NOT_RUN, "topic /pose: a message cannot be read: no definition of Quaternion",
                     renamed)


if __name__ == "__main__":
    daemons.main()
