#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""mmlins degrade: events where asked, everything else byte for byte as it was, one clear line for bad input."""

import math
import os
import struct
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bag_writers import find_library  # noqa: E402
from program import mmlins  # noqa: E402
from raw_bag import Cloud, read_raw  # noqa: E402

LIBRARY = None
START = 1_700_000_000 * 10**9  # [ns] of simulated recordings, and of those made here
MS = 10**6
CLOUD, TEXT, LIVOX = "sensor_msgs/PointCloud2", "std_msgs/String", "livox_ros_driver2/CustomMsg"


def norm(cloud, point):
    return math.sqrt(sum(cloud.value(point, axis)**2 for axis in "xyz"))


class DegradeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.TemporaryDirectory()
        made = mmlins("simulate", "demo", "--out", cls.shared.name, "--set", "duration=4", "--set",
                      "sensor.columns=120")
        assert made.returncode == 0, made.stderr
        cls.bag = os.path.join(cls.shared.name, "recording.bag")
        cls.before = read_raw(cls.bag)

    @classmethod
    def tearDownClass(cls):
        cls.shared.cleanup()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.out = self.folder / "out.bag"

    def degrade(self, *events, bag=None, more=()):
        arguments = [part for event in events for part in ("--event", event)]
        result = mmlins("degrade", bag or self.bag, self.out, *arguments, *more)
        self.assertEqual(result.returncode, 0, result.stderr)
        return read_raw(self.out)

    def assert_refused(self, result, *words):
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertEqual(list(self.folder.glob("*")), [], "nothing half-written")

    def scans(self, messages):
        return {time: Cloud(data) for topic, _, time, data in messages if topic == "/points"}

    def points_with_times(self, cloud):
        return [(cloud.stamp + round(1e9 * cloud.value(point, "time")), point) for point in cloud.points()]

    def test_a_blackout_removes_its_points_and_leaves_all_else_as_it_was(self):
        after = self.degrade("blackout:1.5:1")
        self.assertEqual([m[:3] for m in after], [m[:3] for m in self.before], "connections and record times")
        changed = 0
        for (topic, _, time, was), (_, _, _, now) in zip(self.before, after):
            begins, ends = START + 1500 * MS, START + 2500 * MS
            if topic != "/points" or time < begins or Cloud(was).stamp >= ends:
                self.assertEqual(was, now)
                continue
            changed += 1
            before, left = Cloud(was), Cloud(now)
            expected = [p for t, p in self.points_with_times(before) if not begins <= t < ends]
            self.assertEqual(left.points(), expected)
            self.assertEqual((left.height, left.width, left.row_step),
                             (1, len(expected), len(expected) * before.step))
            self.assertEqual((left.stamp, left.is_dense), (before.stamp, before.is_dense))
        self.assertGreaterEqual(changed, 10)
        self.assertEqual((self.folder / "out.events.csv").read_text(),
                         "kind,start,end,severity\nblackout,1700000001.500000000,1700000002.500000000,1\n")
        self.assertEqual(sorted(p.name for p in self.folder.glob("*")), ["out.bag", "out.events.csv"])

    def test_each_bag_has_a_table_of_events_of_its_own(self):
        own = self.folder / "events.csv"
        own.write_text("of the recording")
        for name, table in (("a.bag", "a.events.csv"), ("b.1.bag", "b.1.events.csv"), ("c", "c.events.csv")):
            result = mmlins("degrade", self.bag, self.folder / name, "--event", "blackout:1:1")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("blackout", (self.folder / table).read_text())
        self.assertEqual(own.read_text(), "of the recording")

    def test_the_folder_of_the_bag_is_made(self):
        self.out = self.folder / "new/folder/out.bag"
        self.degrade("blackout:1:1")
        self.assertTrue((self.out.parent / "out.events.csv").exists())

    def test_a_bag_moves_points_towards_the_sensor_and_keeps_their_other_fields(self):
        moved = 0
        for (topic, _, _, was), (_, _, _, now) in zip(self.before, self.degrade("bag:1:2:0.8")):
            if topic != "/points" or was == now:
                continue
            before, after = Cloud(was), Cloud(now)
            self.assertEqual(len(after.points()), len(before.points()))
            for old, new in zip(before.points(), after.points()):
                self.assertEqual(new[12:], old[12:], "all but x, y, z")
                if new != old:
                    self.assertLess(norm(after, new), 1.6)
                    moved += 1
        self.assertGreater(moved, 1000)

    def test_lost_packets_take_whole_messages(self):
        after = self.scans(self.degrade("packet_loss:1:1"))
        lost = [time for time in self.scans(self.before) if time not in after]
        self.assertTrue(9 <= len(lost) <= 10, lost)
        self.assertTrue(all(START + 1000 * MS < time < START + 2110 * MS for time in lost))

    def test_thinning_keeps_the_number(self):
        after = self.scans(self.degrade("thin_to:1:2:25"))
        whole = [cloud for cloud in after.values() if START + 1000 * MS <= cloud.stamp < START + 2890 * MS]
        self.assertGreaterEqual(len(whole), 17)
        self.assertEqual({len(cloud.points()) for cloud in whole}, {25})

    def test_the_seed_decides_and_the_same_seed_gives_the_same_bytes(self):
        contents = []
        for seed in (1, 1, 2):
            self.degrade("thin:1:2:0.3", "smoke:3:0.5", more=["--seed", seed])
            contents.append(self.out.read_bytes())
        self.assertEqual(contents[0], contents[1])
        self.assertNotEqual(contents[0], contents[2])

    def test_mmlins_reads_what_it_wrote(self):
        self.degrade("blackout:1:1", "bag:3:0.5")
        result = mmlins("info", self.out)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_bad_input_is_refused_with_one_line(self):
        def degrade(event, bag=self.bag, out=self.out, more=()):
            return mmlins("degrade", bag, out, "--event", event, *more)
        self.assert_refused(degrade("fog:1:1"), "fog:1:1", "blackout, bag")
        self.assert_refused(degrade("bag:1"), "bag:1", "kind:start:duration[:severity]")
        self.assert_refused(degrade("bag:3:100"), self.bag, "bag:3:100", "outside of the recording", "within")
        self.assert_refused(degrade("bag:-1:2"), "bag:-1:2", "outside of the recording")
        self.assert_refused(degrade("bag:1:0"), self.bag, "bag:1:0", "duration must be 0.001 to")
        self.assert_refused(degrade("bag:1:-2"), self.bag, "bag:1:-2", "duration must be 0.001 to")
        self.assert_refused(degrade("kidnap:1:1:5"), "kidnap:1:1:5", "cannot be applied to a recording", "simulate it")
        self.assert_refused(degrade("elevator:1:1"), "elevator:1:1", "cannot be applied to a recording", "simulate it")
        self.assert_refused(degrade("bag:1:1:9"), "0.15 to 1.5 m")
        self.assert_refused(degrade("bag:1:1", bag=self.folder / "none.bag"), "none.bag: no such file")
        self.assert_refused(degrade("bag:1:1", bag=__file__), "not a ROS 1 bag")
        self.assert_refused(degrade("bag:1:1", out=Path(self.bag) / "out.bag"), "recording.bag/out.bag", "choose another place")
        self.assert_refused(degrade("blackout:1:2:3"), "event blackout:1:2:3", "blackout has no severity; leave it out")
        self.assert_refused(degrade("bag:1:1", more=["--lidar-topic", "/x"]), "/x", "/points")
        self.assert_refused(degrade("bag:1:1", out=self.bag), "another name")
        truncated = self.folder.parent / (self.folder.name + "_cut.bag")
        self.addCleanup(truncated.unlink)
        truncated.write_bytes(Path(self.bag).read_bytes()[:100_000])
        self.assert_refused(degrade("bag:1:1", bag=truncated), truncated.name)


def cloud_fields(stamp, points, layout, fields, height=1, padding=b""):
    step = struct.calcsize(layout)
    width = len(points) // height
    rows = [b"".join(struct.pack(layout, *p) for p in points[r * width:(r + 1) * width]) + padding for r in range(height)]
    return {"header": {"seq": 1, "stamp": stamp, "frame_id": "lidar"}, "height": height, "width": width,
            "fields": [{"name": n, "offset": o, "datatype": d, "count": 1} for n, o, d in fields],
            "is_bigendian": False, "point_step": step, "row_step": step * width + len(padding),
            "data": b"".join(rows), "is_dense": False}


class OtherLayouts(unittest.TestCase):
    """Bags of an independent writer: other types of fields, organised clouds, Livox messages, other topics."""

    def setUp(self):
        if LIBRARY is None:
            self.skipTest("no library to write bags with")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bag, self.out = Path(folder.name) / "in.bag", Path(folder.name) / "out.bag"

    def degrade(self, messages, *events):
        texts = [("/note", TEXT, START + i * 70 * MS, {"data": "hello %d" % i}) for i in range(14)]
        LIBRARY.write(self.bag, sorted(messages + texts, key=lambda message: message[2]))
        arguments = [part for event in events for part in ("--event", event)]
        result = mmlins("degrade", self.bag, self.out, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        before, after = read_raw(self.bag), read_raw(self.out)
        self.assertEqual([m for m in before if m[0] == "/note"], [m for m in after if m[0] == "/note"])
        return [[m for m in bag if m[0] == "/lidar"] for bag in (before, after)]

    def test_organised_clouds_of_doubles_with_absolute_times_and_beams_without_echo(self):
        layout = "<dddIdH6x"
        fields = [("x", 0, 8), ("y", 8, 8), ("z", 16, 8), ("intensity", 24, 6), ("timestamp", 28, 8), ("ring", 36, 4)]
        messages = []
        for i in range(10):
            stamp = START + i * 100 * MS
            points = [(float("nan"),) * 3 + (k, 1e-9 * stamp + 0.0009 * k, k % 2) if k % 10 == 3 else
                      (3.0 + 0.1 * k, 1 / 3, 0.5, k, 1e-9 * stamp + 0.0009 * k, k % 2) for k in range(100)]
            messages.append(("/lidar", CLOUD, stamp + 100 * MS,
                             cloud_fields(stamp, points, layout, fields, height=2, padding=b"\xee" * 5)))
        before, after = self.degrade(messages, "range_cap:0.35:0.3:8")
        for (_, header, time, was), (_, new_header, new_time, now) in zip(before, after):
            self.assertEqual((header, time), (new_header, new_time))
            stamp = time - 100 * MS
            if stamp >= START + 650 * MS or time < START + 350 * MS:
                self.assertEqual(was, now)
            elif START + 350 * MS <= stamp <= START + 560 * MS:
                left = Cloud(now)
                step = struct.calcsize(layout)
                expected = [struct.unpack(layout, now_point) for now_point in left.points()]
                self.assertEqual((left.height, left.row_step), (1, step * len(expected)))
                # Beams without an echo stay; of the others those up to 8 m.
                numbers = [k for k in range(100) if k % 10 == 3 or math.hypot(3.0 + 0.1 * k, 1 / 3, 0.5) <= 8.0]
                self.assertEqual([point[3] for point in expected], numbers)
                self.assertTrue(all(point[1] == 1 / 3 for point in expected if not math.isnan(point[1])))
        self.assertEqual(len(before), len(after))

    def test_livox_messages(self):
        messages = []
        for i in range(10):
            stamp = START + i * 100 * MS
            points = [{"offset_time": 990_000 * k, "x": 1.0 + k, "y": 2.0, "z": 0.0, "reflectivity": k, "tag": 16,
                       "line": k % 4} for k in range(101)]
            messages.append(("/lidar", LIVOX, stamp + 99 * MS, {
                "header": {"seq": i, "stamp": stamp, "frame_id": "livox"}, "timebase": stamp, "point_num": 101,
                "lidar_id": 3, "rsvd": [1, 2, 3], "points": points}))
        # The recording begins with the first note, at the stamp of the first scan.
        before, after = self.degrade(messages, "blackout:0.2495:0.3")
        self.assertEqual(len(before), len(after))
        for i, ((_, _, _, was), (_, _, _, now)) in enumerate(zip(before, after)):
            head = 16 + len("livox") + 8
            kept = [k for k in range(101) if not 249.5 <= 100 * i + 0.99 * k < 549.5]
            points = b"".join(was[head + 12 + 19 * k:head + 12 + 19 * (k + 1)] for k in kept)
            count = struct.pack("<I", len(kept))
            self.assertEqual(now, was[:head] + count + was[head + 4:head + 8] + count + points)


if __name__ == "__main__":
    LIBRARY = find_library()
    unittest.main(argv=sys.argv[:1])
