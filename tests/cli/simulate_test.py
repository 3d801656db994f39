# SPDX-License-Identifier: MIT
"""mmlins simulate as a user runs it: files, determinism, and one clear line for everything that is wrong."""

import filecmp
import os
import subprocess
import sys
import tempfile
import unittest

MMLINS = sys.argv[1]
FILES = ["events.csv", "map.svg", "recording.bag", "rig.yaml", "scenario.yaml", "truth.tum"]
# Small enough for a second: 2 s, few columns.
SHORT = ["--set", "duration=2", "--set", "trajectory.stand_still=0.5", "--set", "sensor.columns=120"]


def text_of(path):
    with open(path) as file:
        return file.read()


def simulate(*arguments):
    return subprocess.run([MMLINS, "simulate", *arguments], capture_output=True, text=True, timeout=120)


class Simulate(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)

    def assert_refused(self, result, *words):
        self.assertNotEqual(result.returncode, 0)
        lines = [line for line in result.stderr.splitlines() if line.strip()]
        self.assertEqual(len(lines), 1, result.stderr)
        for word in words:
            self.assertIn(word, lines[0])

    def test_writes_recording_truth_rig_and_scenario(self):
        result = simulate("demo", "--out", self.path("a"), *SHORT)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(sorted(os.listdir(self.path("a"))), FILES)
        rows = [line.split() for line in text_of(self.path("a/truth.tum")).splitlines()]
        self.assertEqual(len(rows), 201)  # 100 Hz, both ends
        self.assertTrue(all(len(row) == 8 for row in rows))
        self.assertEqual(rows[0][0], "1700000000.000000000")
        self.assertEqual(rows[-1][0], "1700000002.000000000")

    def test_same_seed_gives_the_same_bytes_and_another_seed_others(self):
        for name, seed in (("a", "5"), ("b", "5"), ("c", "6")):
            result = simulate("demo", "--out", self.path(name), *SHORT, "--set", "seed=" + seed)
            self.assertEqual(result.returncode, 0, result.stderr)
        for name in FILES:
            self.assertTrue(filecmp.cmp(self.path("a/" + name), self.path("b/" + name), shallow=False), name)
        self.assertFalse(filecmp.cmp(self.path("a/recording.bag"), self.path("c/recording.bag"), shallow=False))

    def test_the_scenario_that_it_writes_makes_the_same_recording(self):
        self.assertEqual(simulate("dev_office_mid360", "--out", self.path("a"), *SHORT).returncode, 0)
        self.assertEqual(simulate(self.path("a/scenario.yaml"), "--out", self.path("b")).returncode, 0)
        for name in FILES:
            self.assertTrue(filecmp.cmp(self.path("a/" + name), self.path("b/" + name), shallow=False), name)

    def test_a_path_through_a_wall_and_a_missing_cloud_are_refused_and_leave_nothing(self):
        through = simulate("demo", "--out", self.path("a"), "--set", "trajectory.semi_axis_x=30")
        self.assert_refused(through, "demo", "leads through a surface after", "s, at x", "choose another course")
        cloud = ["demo", "--out", self.path("a"), "--set", "world.scene=cloud", "--set"]
        self.assert_refused(simulate(*cloud, "world.file=/missing.pcd"), "/missing.pcd")
        self.assertFalse(os.path.exists(self.path("a")))

    def test_a_cloud_becomes_a_world(self):
        with open(self.path("site.ply"), "w", encoding="ascii") as file:  # the floor and four walls of a hall
            points = [(0.1 * i, 0.1 * k, 0.0) for i in range(-200, 201) for k in range(-200, 201)]
            for z in range(60):
                for i in range(-200, 201):
                    points += [(0.1 * i, 20, 0.1 * z), (0.1 * i, -20, 0.1 * z)]
                    points += [(20, 0.1 * i, 0.1 * z), (-20, 0.1 * i, 0.1 * z)]
            header = "ply\nformat ascii 1.0\nelement vertex %d\n" % len(points)
            file.write(header + "".join("property float %s\n" % axis for axis in "xyz") + "end_header\n")
            file.writelines("%.2f %.2f %.2f\n" % point for point in points)
        options = ["--set", "world.scene=cloud", "--set", "world.file=" + self.path("site.ply")]
        result = simulate("demo", "--out", self.path("a"), *SHORT, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn(" 0 points", result.stdout)

    def test_events_are_written_with_absolute_times(self):
        event = "events=[{kind: bag, start: 0.5, duration: 1}, {kind: packet_loss, start: 1.75, duration: 0.1}]"
        self.assertEqual(simulate("demo", "--out", self.path("a"), *SHORT, "--set", event).returncode, 0)
        self.assertEqual(
            text_of(self.path("a/events.csv")),
            "kind,start,end,severity\n"
            "bag,1700000000.500000000,1700000001.500000000,0.6\n"
            "packet_loss,1700000001.750000000,1700000001.850000000,1\n",
        )

    def assert_setting_refused(self, setting, *words):
        with self.subTest(setting=setting):
            self.assert_refused(simulate("demo", "--out", self.path("a"), *SHORT, "--set", setting), *words)
            self.assertFalse(os.path.exists(self.path("a")))

    def test_an_event_outside_of_the_recording_is_refused(self):
        self.assert_setting_refused("events=[{kind: bag, start: 1.5, duration: 1}]", "bag:1.5:1", "2.000 s",
                                    "let it begin and end within")
        self.assert_setting_refused("events=[{kind: bag, start: -1, duration: 1}]", "events[0].start", "0 to")

    def test_events_without_length_of_unknown_kind_or_impossible_severity_are_refused(self):
        for duration in ("0", "-0.5"):
            self.assert_setting_refused("events=[{kind: bag, start: 1, duration: %s}]" % duration,
                                        "events[0].duration is " + duration, "accepted", "0.001 to")
        self.assert_setting_refused("events=[{kind: fog, start: 1, duration: 0.5}]", "events[0].kind is fog", "smoke")
        self.assert_setting_refused("events=[{kind: bag, start: 1, duration: 0.5, severity: 9}]", "bag:1:0.5:9",
                                    "distance of the membrane", "0.15 to 1.5 m")

    def test_an_unknown_part_is_refused_with_a_list_of_those_there_are(self):
        self.assert_setting_refused("sensor.model=vlp17", "sensor.model", "'vlp17'", "vlp16", "avia", ".yaml")
        self.assert_setting_refused("sensor.model=mine.yaml", "mine.yaml", "no such file")
        self.assert_setting_refused("world.scene=moon", "world.scene is moon", "street", "decoy")
        self.assert_setting_refused("trajectory.carrier=horse", "trajectory.carrier is horse", "quadruped")
        self.assert_setting_refused("imu.model=abacus", "imu.model is abacus", "bmi088")

    def test_stops_that_overlap_or_lie_outside_are_refused(self):
        longer = "duration=60", "--set"
        both = "trajectory.stops=[{at: 20, duration: 5}, {at: 28, duration: 2}]"
        self.assert_refused(simulate("demo", "--out", self.path("a"), "--set", *longer, both),
                            "demo: trajectory.stops: the stop at 28 s overlaps the stop at 20 s", "begin at 29 s")
        self.assert_setting_refused("trajectory.stops=[{at: 30, duration: 5}]", "the stop at 30 s", "lasts 2 s")

    def test_two_rides_at_once_are_refused(self):
        events = "events=[{kind: kidnap, start: 0.5, duration: 1}, {kind: kidnap, start: 1, duration: 0.5}]"
        self.assert_setting_refused(events, "kidnap:1:0.5", "overlaps kidnap:0.5:1", "one ride at a time")

    def test_a_cloud_without_points_is_refused(self):
        head = "ply\nformat ascii 1.0\nelement vertex 0\n"
        self.write("empty.ply", head + "".join("property float %s\n" % axis for axis in "xyz") + "end_header\n")
        self.write("empty.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 1\n"
                   "POINTS 0\nDATA ascii\n")
        self.write("nothing.ply", "")
        for name, words in (("empty.ply", "holds no points"), ("empty.pcd", "holds no points"),
                            ("nothing.ply", "no PLY file")):
            cloud = ("--set", "world.scene=cloud", "--set", "world.file=" + self.path(name))
            self.assert_refused(simulate("demo", "--out", self.path("a"), *cloud), name, words)
        self.assert_setting_refused("world.scene=cloud", "world.file", ".pcd or .ply")

    def test_lists_the_scenarios_with_what_they_are(self):
        result = simulate("--list")
        self.assertEqual(result.returncode, 0)
        scenarios, parts = result.stdout.split("\n\n")
        names = [line.split()[0] for line in scenarios.splitlines()]
        for name in ("demo", "dev_hall16", "heldout_street32", "long_drive"):
            self.assertIn(name, names)
        self.assertTrue(all(len(line.split()) > 3 for line in scenarios.splitlines()))
        for part in ("floors", "os1_64", "consumer", "quadruped", "elevator"):
            self.assertIn(part, parts)

    def test_an_unknown_scenario_gets_the_nearest_name(self):
        self.assert_refused(simulate("dmo", "--out", self.path("a")), "dmo", "'demo'")
        self.assertFalse(os.path.exists(self.path("a")))

    def test_a_missing_file_is_named(self):
        self.assert_refused(simulate(self.path("none.yaml"), "--out", self.path("a")), "none.yaml")

    def test_an_unknown_key_is_named_with_file_and_line(self):
        self.write("bad.yaml", "duration: 3\ntrajectory: {sped: 2}\n")
        self.assert_refused(simulate(self.path("bad.yaml"), "--out", self.path("a")), "bad.yaml", "2", "sped", "speed")

    def test_a_value_out_of_range_is_refused(self):
        self.assert_refused(simulate("demo", "--out", self.path("a"), "--set", "duration=-1"), "duration")
        self.assertFalse(os.path.exists(self.path("a")))

    def test_an_unwritable_folder_is_named(self):
        self.write("file", "in the way")
        self.assert_refused(simulate("demo", "--out", self.path("file/out"), *SHORT), "file/out")

    def test_an_existing_file_as_folder_is_refused_and_kept(self):
        self.write("file", "in the way")
        self.assert_refused(simulate("demo", "--out", self.path("file"), *SHORT), "file")
        self.assertEqual(text_of(self.path("file")), "in the way")

    def test_nothing_is_said_twice_when_arguments_are_missing(self):
        self.assert_refused(simulate("demo"), "--out")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
