#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Bags of independent writers read by mmlins, and bags of mmlins read by independent readers."""

import json
import math
import os
import pwd
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bag_writers import find_library  # noqa: E402

MMLINS = sys.argv[1] if len(sys.argv) > 1 else "mmlins"
SKIPPED = 77
LIBRARY = None

START = 1_700_000_000 * 10**9  # [ns]
PERIOD = 10**8  # [ns] of the scans
TYPES = {"int8": (1, "b"), "uint8": (2, "B"), "int16": (3, "h"), "uint16": (4, "H"), "int32": (5, "i"),
         "uint32": (6, "I"), "float32": (7, "f"), "float64": (8, "d")}
CLOUD, IMU, TEXT = "sensor_msgs/PointCloud2", "sensor_msgs/Imu", "std_msgs/String"


def cloud(stamp, points, fields, padding=0):
    """The fields of a PointCloud2. fields: [(name, type), ...]; points: one tuple of values each."""
    layout = "<" + "".join(TYPES[kind][1] for _, kind in fields)
    offsets = [struct.calcsize("<" + "".join(TYPES[kind][1] for _, kind in fields[:i])) for i in range(len(fields))]
    step = struct.calcsize(layout) + padding
    data = b"".join(struct.pack(layout, *point) + b"\xaa" * padding for point in points)
    return {"header": {"seq": 1, "stamp": stamp, "frame_id": "lidar"}, "height": 1, "width": len(points),
            "fields": [{"name": name, "offset": offset, "datatype": TYPES[kind][0], "count": 1}
                       for (name, kind), offset in zip(fields, offsets)],
            "is_bigendian": False, "point_step": step, "row_step": len(data), "data": data, "is_dense": True}


def imu_messages(topic="/imu", seconds=1.0, gravity=9.81):
    messages = []
    for i in range(int(200 * seconds)):
        stamp = START + i * 5_000_000
        messages.append((topic, IMU, stamp, {
            "header": {"seq": i, "stamp": stamp, "frame_id": "imu"},
            "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
            "orientation_covariance": [0.0] * 9, "angular_velocity": {"x": 0.01, "y": 0.02, "z": 0.03},
            "angular_velocity_covariance": [0.0] * 9,
            "linear_acceleration": {"x": 0.0, "y": 0.0, "z": gravity},
            "linear_acceleration_covariance": [0.0] * 9}))
    return messages


XYZ = [("x", "float32"), ("y", "float32"), ("z", "float32")]


def scans(fields, time_of, topic="/points", num_points=20, padding=0):
    """Ten scans of one ring per point, 99 ms long. time_of(stamp_ns, seconds_after_stamp) gives the time field."""
    messages = []
    for i in range(10):
        stamp = START + i * PERIOD
        points = []
        for k in range(num_points):
            known = {"x": 1.0 + k, "y": 2.0, "z": 0.5, "intensity": 7, "ring": k, "line": k, "tag": 0}
            points.append(tuple(known[name] if name in known else time_of(stamp, 0.099 * k / (num_points - 1))
                                for name, _ in fields))
        messages.append((topic, CLOUD, stamp + 99_000_000, cloud(stamp, points, fields, padding)))
    return messages


def relative(unit, as_type=float):
    return lambda stamp, after: as_type(after * unit)


def livox(driver, topic="/livox/lidar"):
    messages = []
    for i in range(10):
        stamp = START + i * PERIOD
        points = [{"offset_time": 990_000 * k, "x": 1.0 + k, "y": 0.0, "z": 0.0, "reflectivity": 3, "tag": 16,
                   "line": k % 6} for k in range(101)]
        points[5].update(x=0.0)
        messages.append((topic, driver + "/CustomMsg", stamp + 99_000_000, {
            "header": {"seq": i, "stamp": stamp, "frame_id": "livox_frame"}, "timebase": stamp,
            "point_num": len(points), "lidar_id": 0, "rsvd": [0, 0, 0], "points": points}))
    return messages


class BagsTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.bag = Path(self.folder.name) / "a.bag"

    def write(self, *parts):
        LIBRARY.write(self.bag, sorted((m for part in parts for m in part), key=lambda m: m[2]))

    def mmlins(self, *arguments):
        return subprocess.run([MMLINS, *map(str, arguments)], capture_output=True, text=True, timeout=120)

    def info(self, rig=None):
        arguments = ["info", self.bag, "--json"]
        if rig is not None:
            path = Path(self.folder.name) / "rig.yaml"
            path.write_text(rig)
            arguments += ["--rig", path]
        result = self.mmlins(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def refused(self, *arguments):
        """The one line of an error; the program must fail, and not by a crash."""
        result = self.mmlins(*arguments)
        self.assertEqual(result.returncode, 1, result.stderr)
        lines = result.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        return lines[0]


class PointCloudLayouts(BagsTest):
    """What the drivers of common sensors write."""

    def check(self, fields, time_of, unit, reference="relative", stamp="start", rings=20, rig=None, padding=0):
        self.write(imu_messages(), scans(fields, time_of, padding=padding))
        info = self.info(rig)
        self.assertEqual(info["problems"], [])
        lidar = info["lidar"]
        self.assertEqual([(f["name"], f["type"]) for f in lidar["fields"]], fields)
        self.assertEqual((lidar["time"]["unit"], lidar["time"]["reference"], lidar["time"]["stamp"]),
                         (unit, reference, stamp))
        self.assertAlmostEqual(lidar["time"]["span_s"], 0.099, delta=1e-6)
        self.assertFalse(lidar["time"]["instantaneous"])
        self.assertAlmostEqual(lidar["scan_rate_hz"], 10.0, places=6)
        self.assertEqual((lidar["points_per_scan"], lidar["rings"]), (20, rings))

    def test_velodyne_seconds_as_float32(self):
        self.check(XYZ + [("intensity", "float32"), ("ring", "uint16"), ("time", "float32")], relative(1), "s",
                   padding=10)

    def test_velodyne_stamped_at_the_end(self):
        self.check(XYZ + [("time", "float32")], lambda stamp, after: after - 0.099, "s", stamp="end", rings=0)

    def test_ouster_nanoseconds_as_uint32(self):
        self.check(XYZ + [("t", "uint32"), ("ring", "uint8")], relative(1e9, int), "ns")

    def test_microseconds_as_float32(self):
        self.check(XYZ + [("time", "float32"), ("ring", "uint16")], relative(1e6), "us")

    def test_microseconds_as_int32(self):
        self.check(XYZ + [("offset_time", "int32")], relative(1e6, int), "us", rings=0)

    def test_milliseconds_as_float64(self):
        self.check(XYZ + [("timestamps", "float64")], relative(1e3), "ms", rings=0)

    def test_hesai_absolute_seconds_as_float64(self):
        self.check(XYZ + [("intensity", "float32"), ("timestamp", "float64"), ("ring", "uint16")],
                   lambda stamp, after: 1e-9 * stamp + after, "s", "absolute")

    def test_livox_absolute_nanoseconds_as_float64(self):
        self.check(XYZ + [("tag", "uint8"), ("line", "uint8"), ("timestamp", "float64")],
                   lambda stamp, after: stamp + 1e9 * after, "ns", "absolute")

    def test_coordinates_as_float64(self):
        self.check([("z", "float64"), ("time_stamp", "uint32"), ("y", "float64"), ("x", "float64")],
                   relative(1e6, int), "us", rings=0)

    def test_the_rig_overrides_what_was_found(self):
        self.write(imu_messages(), scans(XYZ + [("when", "float32")], relative(1)))
        self.assertIsNone(self.info()["lidar"]["time"])
        time = self.info("time_field: when\ntime_unit: s\nstamp_reference: end\n")["lidar"]["time"]
        self.assertEqual((time["field"], time["unit"], time["stamp"]), ("when", "s", "end"))

    def test_the_same_time_for_all_points_is_an_instantaneous_scan(self):
        self.write(imu_messages(), scans(XYZ + [("time", "float32")], lambda stamp, after: 0.0))
        self.assertTrue(self.info()["lidar"]["time"]["instantaneous"])

    def test_a_cloud_without_time_is_allowed(self):
        self.write(imu_messages(), scans(XYZ, relative(1)))
        info = self.info()
        self.assertIsNone(info["lidar"]["time"])
        self.assertEqual(info["problems"], [])
        self.assertIn("no deskewing", self.mmlins("info", self.bag).stdout)


class OtherMessages(BagsTest):
    def test_livox_messages_of_both_drivers(self):
        for driver in ["livox_ros_driver", "livox_ros_driver2"]:
            self.bag = self.bag.with_name(driver + ".bag")
            self.write(imu_messages(), livox(driver))
            lidar = self.info()["lidar"]
            self.assertEqual(lidar["type"], driver + "/CustomMsg")
            self.assertEqual((lidar["points_per_scan"], lidar["rings"]), (100, 6))  # one has no echo
            self.assertEqual((lidar["time"]["field"], lidar["time"]["unit"]), ("offset_time", "ns"))
            self.assertAlmostEqual(lidar["time"]["span_s"], 0.099, delta=1e-9)

    def test_acceleration_in_g_is_recognised(self):
        self.write(imu_messages(gravity=1.0), scans(XYZ + [("time", "float32")], relative(1)))
        self.assertEqual(self.info()["imu"]["accel_unit"], "g")
        self.assertEqual(self.info("accel_unit: m/s^2")["imu"]["accel_unit"], "m/s^2")

    def test_acceleration_in_si_units_is_recognised(self):
        self.write(imu_messages(), scans(XYZ + [("time", "float32")], relative(1)))
        self.assertEqual(self.info()["imu"]["accel_unit"], "m/s^2")
        self.assertAlmostEqual(self.info()["imu"]["rate_hz"], 200.0, places=6)

    def test_invalid_points_and_empty_clouds_are_read(self):
        messages = scans(XYZ + [("time", "float32")], relative(1))
        bad = [(math.nan, 1.0, 1.0, 0.0), (0.0, 0.0, 0.0, 0.01), (math.inf, 1.0, 1.0, 0.02), (1.0, 1.0, 1.0, 0.05)]
        messages[0] = ("/points", CLOUD, messages[0][2], cloud(START, [], XYZ + [("time", "float32")]))
        messages[1] = ("/points", CLOUD, messages[1][2], cloud(START + PERIOD, bad, XYZ + [("time", "float32")]))
        self.write(imu_messages(), messages)
        info = self.info()
        self.assertEqual(info["problems"], [])
        self.assertEqual(info["lidar"]["points_per_scan"], 20)
        self.assertEqual(info["lidar"]["time"]["unit"], "s")

    def test_gaps_are_counted_and_located(self):
        imu = [m for m in imu_messages(seconds=2.0) if not 0.5e9 < m[2] - START < 0.8e9]
        self.write(imu, scans(XYZ + [("time", "float32")], relative(1)))
        gaps = next(t for t in self.info()["topics"] if t["name"] == "/imu")["gaps"]
        self.assertEqual(gaps["count"], 1)
        self.assertAlmostEqual(gaps["longest_s"], 0.3, places=6)
        self.assertAlmostEqual(gaps["longest_begins_at_s"], 0.5, places=6)


class Home(BagsTest):
    def test_a_home_is_neither_needed_nor_written_to(self):
        """The home that counts is the one in the table of users; who may not write there must not hear of it."""
        self.write(imu_messages(), scans(XYZ + [("time", "float32")], relative(1)))
        temporary = Path(self.folder.name) / "temporary"
        temporary.mkdir(mode=0o777)
        ros = Path(pwd.getpwuid(os.geteuid()).pw_dir) / ".ros"
        before = [(p, p.stat().st_mtime_ns) for p in sorted(ros.glob("rospack*"))]
        environment = {key: value for key, value in os.environ.items() if key != "ROS_HOME"}
        environment |= {"TMPDIR": str(temporary), "ROS_CACHE_TIMEOUT": "0"}  # note it each time
        run = subprocess.run([MMLINS, "info", self.bag], capture_output=True, text=True, env=environment)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual([(p, p.stat().st_mtime_ns) for p in sorted(ros.glob("rospack*"))], before)
        self.assertEqual(list(temporary.iterdir()), [])


class Problems(BagsTest):
    def problems(self, rig=None):
        """The same words from info, which reports them, and from run, which must refuse."""
        problems = self.info(rig)["problems"]
        arguments = ["run", self.bag, "--out", Path(self.folder.name) / "out"]
        if rig is not None:
            arguments += ["--rig", Path(self.folder.name) / "rig.yaml"]
        self.assertIn(problems[0], self.refused(*arguments))
        self.assertFalse((Path(self.folder.name) / "out").exists())
        return problems

    def test_no_lidar_topic(self):
        self.write(imu_messages(), [("/chatter", TEXT, START, {"data": "hello"})])
        problem, = self.problems()
        self.assertIn(str(self.bag), problem)
        self.assertIn("no LiDAR topic", problem)
        self.assertIn("/chatter (std_msgs/String)", problem)

    def test_no_imu_topic(self):
        self.write(scans(XYZ + [("time", "float32")], relative(1)))
        problem, = self.problems()
        self.assertIn("no IMU topic", problem)

    def test_several_candidates_are_listed_and_the_rig_decides(self):
        fields = XYZ + [("time", "float32")]
        self.write(imu_messages(), imu_messages("/imu2"), scans(fields, relative(1)),
                   scans(fields, relative(1), "/other"))
        lidar, imu = self.problems()
        self.assertIn("2 LiDAR topics", lidar)
        self.assertIn("lidar_topic", lidar)
        self.assertIn("/other (sensor_msgs/PointCloud2), /points", lidar)
        self.assertIn("imu_topic", imu)
        info = self.info("lidar_topic: /other\nimu_topic: /imu2\n")
        self.assertEqual(info["problems"], [])
        self.assertEqual((info["lidar"]["topic"], info["imu"]["topic"]), ("/other", "/imu2"))

    def test_a_topic_of_the_rig_that_is_not_there(self):
        self.write(imu_messages(), scans(XYZ + [("time", "float32")], relative(1)))
        problem, = self.problems("lidar_topic: /velodyne\n")
        self.assertIn("/velodyne", problem)
        self.assertIn("/points", problem)

    def test_a_time_field_of_the_rig_that_is_not_there(self):
        self.write(imu_messages(), scans(XYZ + [("time", "float32")], relative(1)))
        problem, = self.problems("time_field: when\n")
        self.assertIn("/points", problem)
        self.assertIn("when (fields: x, y, z, time)", problem)

    def test_clouds_without_coordinates(self):
        self.write(imu_messages(), scans([("x", "float32"), ("y", "float32"), ("time", "float32")], relative(1)))
        problem, = self.problems()
        self.assertIn("/points: no point field z (fields: x, y, time)", problem)

    def test_a_big_endian_cloud(self):
        messages = scans(XYZ + [("time", "float32")], relative(1))
        for message in messages:
            message[3]["is_bigendian"] = True
        self.write(imu_messages(), messages)
        self.assertIn("big-endian", self.problems()[0])


class DamagedFiles(BagsTest):
    def check(self, *words):
        for command in (["info", self.bag], ["run", self.bag, "--out", Path(self.folder.name) / "out"]):
            line = self.refused(*command)
            self.assertIn(str(self.bag), line)
            for word in words:
                self.assertIn(word, line)
        self.assertFalse((Path(self.folder.name) / "out").exists())

    def test_missing_file(self):
        self.check("no such file")

    def test_empty_file(self):
        self.bag.write_bytes(b"")
        self.check("empty")

    def test_a_bag_without_messages(self):
        self.write([])
        self.check("no messages")

    def test_another_file(self):
        self.bag.write_text("time x y z\n" * 100)
        self.check("not a ROS 1 bag")

    def test_a_folder(self):
        self.bag.mkdir()
        self.check("not a file")

    def test_truncated_bag(self):
        self.write(imu_messages(), scans(XYZ + [("time", "float32")], relative(1)))
        whole = self.bag.read_bytes()
        for share in (0.0001, 0.01, 0.5, 0.9, 0.999):
            self.bag.write_bytes(whole[:int(len(whole) * share) + 1])
            line = self.refused("info", self.bag)
            self.assertIn(str(self.bag), line)
        self.check("truncated", "rosbag reindex")

    def test_bag_without_index(self):
        self.write(imu_messages())
        whole = bytearray(self.bag.read_bytes())
        place = whole.index(b"index_pos=") + len(b"index_pos=")
        whole[place:place + 8] = bytes(8)  # as a recorder leaves it that was killed
        self.bag.write_bytes(whole)
        self.check("no index", "rosbag reindex")


class BagsOfMmlins(BagsTest):
    """What mmlins writes, as others see it."""

    def test_a_simulated_bag_is_read_by_others(self):
        result = self.mmlins("simulate", "demo", "--set", "duration=2", "--set", "trajectory.stand_still=0.5", "--out",
                             self.folder.name)
        self.assertEqual(result.returncode, 0, result.stderr)
        messages = LIBRARY.read(Path(self.folder.name) / "recording.bag")
        clouds = [(t, m) for topic, t, m in messages if hasattr(m, "point_step")]
        samples = [(t, m) for topic, t, m in messages if hasattr(m, "linear_acceleration")]
        self.assertEqual(len(clouds) + len(samples), len(messages))
        self.assertGreater(len(clouds), 5)
        self.assertGreater(len(samples), 200)
        for record_ns, message in clouds:
            self.assertEqual(len(message.data), message.width * message.point_step)
            self.assertEqual([f.name for f in message.fields][:5], ["x", "y", "z", "intensity", "time"])
            times = [struct.unpack_from("<f", bytes(message.data), i * message.point_step + 16)[0]
                     for i in range(message.width)]
            self.assertEqual(min(times), 0.0)
            self.assertLess(max(times), 0.2)
            self.assertGreaterEqual(record_ns, LIBRARY.stamp_ns(message))
        accel = samples[0][1].linear_acceleration
        self.assertAlmostEqual(math.hypot(accel.x, accel.y, accel.z), 9.81, delta=1.0)


if __name__ == "__main__":
    LIBRARY = find_library()
    if LIBRARY is None:
        print("skipped: neither the Python package rosbags nor python3-rosbag is installed")
        sys.exit(SKIPPED)
    print(f"bags by {type(LIBRARY).__name__}, {sys.executable}")
    unittest.main(argv=sys.argv[:1])
