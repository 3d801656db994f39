#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""mmlins run as a user runs it: its files, determinism, interruption, and one clear line for what is wrong."""

import csv
import filecmp
import json
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from program import MMLINS, mmlins, shared

FILES = ["atlas", "closures.csv", "config.yaml", "graph.g2o", "health.csv", "map.pcd", "merges.json", "odometry.tum", "report.html", "rig.yaml", "summary.json", "trajectory.tum"]


def text_of(path):
    with open(path) as file:
        return file.read()


def poses_of(path):
    return [line.split() for line in text_of(path).splitlines() if not line.startswith("#")]


def ns_of(stamp):
    seconds, fraction = stamp.split(".")
    return int(seconds) * 10**9 + int(fraction.ljust(9, "0"))


def setUpModule():
    """A recording of 6 s with few points, and one of 40 s with many: that takes a while to run."""
    for name, duration, columns in (("short", 6, 160), ("long", 40, 900)):
        result = mmlins("simulate", "demo", "--out", shared(name), "--set", f"duration={duration}",
                        "--set", "trajectory.stand_still=1.5", "--set", f"sensor.columns={columns}")
        assert result.returncode == 0, result.stderr


class Run(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.bag = shared("short/recording.bag")
        self.rig = shared("short/rig.yaml")

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)
        return self.path(name)

    def run_into(self, name, *options):
        result = mmlins("run", self.bag, "--rig", self.rig, "--out", self.path(name), *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def assert_same_bytes(self, a, b, names=("odometry.tum", "trajectory.tum", "map.pcd", "config.yaml", "rig.yaml")):
        for name in names:
            self.assertTrue(filecmp.cmp(self.path(f"{a}/{name}"), self.path(f"{b}/{name}"), shallow=False), name)

    def assert_refused(self, result, *words):
        """Exit code 1, one line that holds all words, and no output."""
        self.assertEqual(result.returncode, 1, result.stderr)
        lines = [line for line in result.stderr.splitlines() if line.strip()]
        self.assertEqual(len(lines), 1, result.stderr)
        for word in words:
            self.assertIn(word, lines[0])
        self.assertFalse(os.path.exists(self.path("out")), "something was left behind")


class Output(Run):
    def test_writes_its_files_and_nothing_else(self):
        result = self.run_into("out")
        self.assertEqual(sorted(os.listdir(self.path("out"))), FILES)
        self.assertIn(self.path("out"), result.stdout)

    def test_trajectories_have_one_pose_per_scan_in_order_with_nine_decimals(self):
        self.run_into("out")
        poses = poses_of(self.path("out/odometry.tum"))
        self.assertEqual(len(poses), json.loads(text_of(self.path("out/summary.json")))["scans"])
        self.assertGreater(len(poses), 55)  # of the 59 whole scans of 6 s
        for pose in poses:
            self.assertEqual(len(pose), 8)
            self.assertRegex(pose[0], r"^\d+\.\d{9,}$")
            self.assertAlmostEqual(sum(float(q) ** 2 for q in pose[4:]), 1.0, places=9)
        stamps = [ns_of(pose[0]) for pose in poses]
        self.assertTrue(all(a < b for a, b in zip(stamps, stamps[1:])))
        self.assertTrue(filecmp.cmp(self.path("out/odometry.tum"), self.path("out/trajectory.tum"), shallow=False))

    def test_the_trajectory_is_that_of_the_truth(self):
        self.run_into("out")
        result = mmlins("evaluate", shared("short/truth.tum"), self.path("out/odometry.tum"), "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        # The scenario tests hold it to less; this is about having understood the recording at all.
        self.assertLess(json.loads(result.stdout)["ate_m"]["rmse"], 0.05)

    def test_health_has_a_row_per_scan_with_finite_numbers(self):
        self.run_into("out")
        with open(self.path("out/health.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        poses = poses_of(self.path("out/odometry.tum"))
        self.assertEqual([row["time"] for row in rows], [pose[0] for pose in poses])
        for row in rows:
            self.assertNotIn(None, row)
            self.assertIn(row["state"], ("INITIALIZING", "TRACKING", "DEGRADED"))
            self.assertEqual(row["map"], "0")
            for name, value in row.items():
                if re.fullmatch("[tr][123]_[xyz]|down_[xyz]", name):
                    self.assertLessEqual(abs(float(value)), 1.0, name)
                elif re.fullmatch("v_[xyz]_m_s", name):
                    self.assertLess(abs(float(value)), 3.0, name)  # the robot's speed is 1.4 m/s
                elif name not in ("time", "state", "cause"):
                    self.assertGreaterEqual(float(value), 0.0, name)
                    self.assertLess(float(value), 1e6, name)
            self.assertAlmostEqual(sum(float(row["down_" + axis]) ** 2 for axis in "xyz"), 1.0, places=5)
            self.assertLess(float(row["down_z"]), -0.9)  # the robot does not lie on its side
            self.assertLessEqual(float(row["explained"]), 1.0)
            stages = sum(float(row[name]) for name in row if name.endswith("_ms") and name != "total_ms")
            self.assertAlmostEqual(float(row["total_ms"]), stages, delta=0.005)  # each rounded to 1 us

    def test_summary_counts_what_the_other_files_hold(self):
        self.run_into("out")
        summary = json.loads(text_of(self.path("out/summary.json")))
        self.assertEqual(summary["scans"], len(poses_of(self.path("out/odometry.tum"))))
        self.assertEqual(sum(summary["scans_by_state"].values()), summary["scans"])
        self.assertEqual([(m["id"], m["began"], m["fell_asleep"]) for m in summary["maps"]], [(0, "at rest", "")])
        self.assertNotIn("gap", summary["maps"][0])
        self.assertEqual(summary["recording"], self.bag)
        self.assertFalse(summary["interrupted"])
        self.assertEqual(summary["read_error"], "")
        self.assertAlmostEqual(summary["duration_s"], 5.8, delta=0.11)
        self.assertGreater(summary["path_length_m"], 1.0)
        self.assertGreater(summary["peak_memory_mib"], 1.0)
        for name, stage in summary["stages"].items():
            self.assertLessEqual(stage["median_ms"], stage["p99_ms"], name)
            self.assertLessEqual(stage["p99_ms"], stage["max_ms"], name)
        self.assertIn("map_voxel", summary["config"])

    def test_map_is_a_binary_pcd_with_intensity(self):
        self.run_into("out")
        with open(self.path("out/map.pcd"), "rb") as file:
            head, data = file.read().split(b"DATA binary\n", 1)
        fields = dict(line.split(" ", 1) for line in head.decode().splitlines() if not line.startswith("#"))
        self.assertEqual(fields["FIELDS"], "x y z intensity")
        count = int(fields["POINTS"])
        self.assertEqual(count, json.loads(text_of(self.path("out/summary.json")))["map_points"])
        self.assertEqual(len(data), 16 * count)
        points = list(struct.iter_unpack("<4f", data))
        self.assertLess(max(abs(value) for point in points for value in point[:3]), 200.0)  # the hall is smaller
        self.assertGreater(max(point[3] for point in points), 0.0)

    def test_larger_map_voxels_leave_fewer_points(self):
        counts = []
        for voxel in ("0.1", "1"):
            self.run_into("v" + voxel, "--set", "output.map_voxel=" + voxel)
            counts.append(json.loads(text_of(self.path(f"v{voxel}/summary.json")))["map_points"])
        self.assertLess(counts[1], counts[0])

    def test_progress_has_a_line_for_each_scan(self):
        self.run_into("out", "--progress", self.path("progress.txt"))
        with open(self.path("out/health.csv"), newline="") as file:
            rows = [f"{row['time']} {row['state']}" for row in csv.DictReader(file)]
        self.assertEqual(text_of(self.path("progress.txt")).splitlines(), rows)

    def test_a_second_run_replaces_the_first(self):
        self.run_into("out", "--set", "output.map_voxel=1")
        self.run_into("out", "--set", "output.map_voxel=0.5")
        self.run_into("fresh", "--set", "output.map_voxel=0.5")
        self.assertEqual(sorted(os.listdir(self.path("out"))), FILES)
        self.assert_same_bytes("out", "fresh")


    def test_an_earlier_run_stays_if_the_next_comes_to_nothing(self):
        self.run_into("out")
        before = {name: os.path.getmtime(self.path("out/" + name)) for name in FILES}
        rig = self.write("rig.yaml", "lidar_time_offset: -10\n")
        self.assertEqual(mmlins("run", self.bag, "--rig", rig, "--out", self.path("out")).returncode, 1)
        self.assertEqual({name: os.path.getmtime(self.path("out/" + name)) for name in sorted(os.listdir(self.path("out")))}, before)
        self.assertEqual(mmlins("maps", self.path("out"), "check").returncode, 0)

    def test_an_earlier_run_is_whole_after_the_next_was_killed(self):
        self.run_into("out")
        self.run_into("fresh")
        with subprocess.Popen([MMLINS, "run", shared("long/recording.bag"), "--out", self.path("out")], stderr=subprocess.DEVNULL) as killed:
            while not all(os.path.exists(self.path(f"out/{name}")) for name in ("earlier_run", "atlas/points_0000.chunk")):
                self.assertIsNone(killed.poll())
                time.sleep(0.01)
            killed.kill()
        self.assertEqual(sorted(os.listdir(self.path("out"))), ["atlas", "earlier_run"])
        self.assertEqual(sorted(os.listdir(self.path("out/earlier_run"))), FILES)
        self.assert_same_bytes("out/earlier_run", "fresh")
        self.run_into("out")
        self.assertEqual(sorted(os.listdir(self.path("out"))), FILES)

    def test_does_not_touch_what_is_no_part_of_a_run(self):
        os.makedirs(self.path("out/earlier_run"))
        self.write("out/earlier_run/diary.txt", "dear diary")
        result = mmlins("run", self.bag, "--out", self.path("out"))
        self.assertEqual(result.returncode, 1)
        self.assertIn("diary.txt", result.stderr)
        self.assertEqual(os.listdir(self.path("out")), ["earlier_run"])


class Determinism(Run):
    def test_same_bytes_whatever_the_number_of_threads_and_again(self):
        self.run_into("one", "--threads", "1")
        self.run_into("two", "--threads", "2")
        self.run_into("again", "--threads", "2")
        self.assert_same_bytes("one", "two")
        self.assert_same_bytes("two", "again")

    def test_its_config_and_rig_passed_back_reproduce_the_run(self):
        self.run_into("first", "--set", "output.map_voxel=0.37", "--set", "odometry.scan.target_keypoints=300")
        result = mmlins("run", self.bag, "--rig", self.path("first/rig.yaml"), "--config",
                        self.path("first/config.yaml"), "--out", self.path("second"))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assert_same_bytes("first", "second")
        # The settings do matter.
        self.run_into("default")
        self.assertFalse(filecmp.cmp(self.path("first/odometry.tum"), self.path("default/odometry.tum"), shallow=False))


class BadInput(Run):
    def refuse(self, *words, bag=None, options=()):
        self.assert_refused(mmlins("run", bag or self.bag, "--out", self.path("out"), *options), *words)

    def test_misspelt_rig_key(self):
        rig = self.write("rig.yaml", "min_range: 0.4\nlidar_topik: /points\n")
        self.refuse("rig.yaml:2", "lidar_topik", "lidar_topic", options=["--rig", rig])

    def test_quaternion_that_is_no_rotation(self):
        rig = self.write("rig.yaml", "q_imu_lidar_xyzw: [0, 0, 0.5, 0.5]\n")
        self.refuse("rig.yaml", "q_imu_lidar_xyzw", options=["--rig", rig])

    def test_config_value_out_of_range_and_of_the_wrong_type(self):
        config = self.write("config.yaml", "output:\n  map_voxel: -1\n")
        self.refuse("config.yaml:2", "map_voxel", options=["--config", config])
        config = self.write("config.yaml", "output:\n  map_voxel: fine\n")
        self.refuse("config.yaml:2", "map_voxel", options=["--config", config])
        self.refuse("map_voxel", options=["--set", "output.map_voxel=0"])
        self.refuse("map_voxels", "map_voxel", options=["--set", "output.map_voxels=1"])

    def test_missing_files(self):
        self.refuse("nowhere.bag", bag=self.path("nowhere.bag"))
        self.refuse("nowhere.yaml", options=["--rig", self.path("nowhere.yaml")])
        self.refuse("nowhere.yaml", options=["--config", self.path("nowhere.yaml")])

    def test_files_that_are_no_bags(self):
        self.refuse("empty.bag", bag=self.write("empty.bag", ""))
        self.refuse("text.bag", bag=self.write("text.bag", "this is no bag\n" * 100))

    def test_topic_that_is_not_there(self):
        self.refuse("/velodyne", "/points", options=["--rig", self.write("rig.yaml", "lidar_topic: /velodyne\n")])

    def test_truncated_bag(self):
        with open(self.bag, "rb") as whole, open(self.path("cut.bag"), "wb") as cut:
            cut.write(whole.read()[:os.path.getsize(self.bag) * 2 // 3])
        self.refuse("cut.bag", "truncated", bag=self.path("cut.bag"))

    def test_recording_of_which_no_scan_can_be_used(self):
        # The clock of the LiDAR is said to be so far behind that the IMU begins only after its end.
        rig = self.write("rig.yaml", "lidar_time_offset: -10\n")
        result = mmlins("run", self.bag, "--rig", rig, "--out", self.path("out"))
        self.assertEqual(result.returncode, 1)
        self.assertIn("no scan", result.stderr.splitlines()[-1])
        self.assertFalse(os.path.exists(self.path("out")), "something was left behind")

    def test_output_below_a_file(self):
        self.write("file", "")
        result = mmlins("run", self.bag, "--out", self.path("file/sub"))
        self.assert_refused(result, "file/sub")

    @unittest.skipIf(os.geteuid() == 0, "root may write anywhere")
    def test_output_folder_without_permission(self):
        os.mkdir(self.path("locked"), 0o555)
        self.assert_refused(mmlins("run", self.bag, "--out", self.path("locked")), "locked")
        self.assertEqual(os.listdir(self.path("locked")), [])

    def test_damage_in_the_middle_keeps_what_came_before(self):
        with open(self.bag, "rb") as whole:
            data = bytearray(whole.read())
        middle = len(data) // 2
        data[middle:middle + len(data) // 10] = b"\xff" * (len(data) // 10)
        with open(self.path("damaged.bag"), "wb") as file:
            file.write(data)
        result = mmlins("run", self.path("damaged.bag"), "--rig", self.rig, "--out", self.path("out"))
        self.assertEqual(result.returncode, 1, result.stderr)
        for word in ("damaged.bag", "saved"):
            self.assertIn(word, result.stderr.splitlines()[-1])
        self.assertEqual(sorted(os.listdir(self.path("out"))), FILES)
        summary = json.loads(text_of(self.path("out/summary.json")))
        self.assertEqual(summary["scans"], len(poses_of(self.path("out/odometry.tum"))))
        self.assertGreater(summary["scans"], 10)
        self.assertLess(summary["scans"], 50)
        self.assertNotEqual(summary["read_error"], "")


class CarriedByTheImuAlone(Run):
    def setUp(self):
        super().setUp()
        result = mmlins("degrade", self.bag, self.path("dark.bag"), "--event", "blackout:4:0.8", "--rig", self.rig)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.command = ["run", self.path("dark.bag"), "--rig", self.rig, "--out", self.path("out")]

    def test_run_says_at_its_end_how_many_scans_that_were(self):
        result = mmlins(*self.command)
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(self.path("out/health.csv"), newline="") as file:
            states = [row["state"] for row in csv.DictReader(file)]
        bridging = states.count("BRIDGING")
        self.assertGreaterEqual(bridging, 7)  # the whole scans of 0.8 s
        self.assertEqual(result.stderr.splitlines()[-1],
                         f"warning: {bridging} of {len(states)} scans were carried by the IMU alone; "
                         f"{self.path('out')}/health.csv says which and why")

    def test_run_says_nothing_if_there_were_none(self):
        self.assertNotIn("warning", self.run_into("out").stderr)

    def test_on_a_terminal_a_warning_erases_the_line_of_progress(self):
        try:
            terminal, stderr = pty.openpty()
        except OSError as error:
            self.skipTest(f"no terminal can be made here: {error}")
        self.addCleanup(os.close, terminal)
        process = subprocess.Popen([MMLINS, *self.command], stdout=subprocess.DEVNULL, stderr=stderr)
        os.close(stderr)
        shown = b""
        try:
            while part := os.read(terminal, 4096):
                shown += part
        except OSError:  # how Linux says that the other end is closed
            pass
        self.assertEqual(process.wait(timeout=120), 0, shown)
        self.assertGreater(shown.count(b"warning: "), 0, shown)
        self.assertEqual(shown.count(b"\r\x1b[Kwarning: "), shown.count(b"warning: "), shown)


class Interruption(Run):
    def test_ctrl_c_saves_what_there_is_and_says_so(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=number):
                out = self.path("out%d" % number)
                # One thread and every point: some seconds of work. Lines of progress come at every tenth.
                command = [MMLINS, "run", shared("long/recording.bag"), "--rig", shared("long/rig.yaml"), "--out", out,
                           "--threads", "1", "--set", "odometry.scan.target_keypoints=20000"]
                process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                self.addCleanup(process.kill)
                seen = ""
                while "%" not in seen:
                    line = process.stderr.readline()
                    self.assertNotEqual(line, "", "ended before any progress was shown: " + seen)
                    seen += line
                process.send_signal(number)
                _, rest = process.communicate(timeout=120)
                self.assertEqual(process.returncode, 130, seen + rest)
                last = rest.splitlines()[-1]
                self.assertIn("interrupted", last)
                self.assertIn(out, last)
                self.assertEqual(sorted(os.listdir(out)), FILES)
                summary = json.loads(text_of(os.path.join(out, "summary.json")))
                self.assertTrue(summary["interrupted"])
                self.assertEqual(summary["scans"], len(poses_of(os.path.join(out, "odometry.tum"))))
                self.assertIn(str(summary["scans"]), last)
                self.assertGreater(summary["scans"], 0)
                self.assertLess(summary["scans"], 390)  # of 399


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
