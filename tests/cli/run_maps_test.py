#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What mmlins run writes about a recording in which the pose is lost and a second map begins."""

import csv
import json
import sys
import unittest

from program import mmlins, shared


def text_of(path):
    with open(path) as file:
        return file.read()


def poses_of(path):
    return [line.split() for line in text_of(path).splitlines() if not line.startswith("#")]


def ns_of(stamp):
    seconds, fraction = stamp.split(".")
    return int(seconds) * 10**9 + int(fraction.ljust(9, "0"))


class TwoMaps(unittest.TestCase):
    """Dark for 25 s of 40: longer than the IMU can carry the pose within the budget."""

    @classmethod
    def setUpClass(cls):
        for command in (["simulate", "demo", "--out", shared("dark"), "--set", "duration=40", "--set", "sensor.columns=160",
                         "--set", "trajectory.stand_still=1.5",
                         "--set", "events=[{kind: blackout, start: 8, duration: 25}]"],
                        ["run", shared("dark/recording.bag"), "--rig", shared("dark/rig.yaml"), "--out", shared("dark/out")]):
            result = mmlins(*command)
            assert result.returncode == 0, result.stderr

    def rows(self):
        with open(shared("dark/out/health.csv"), newline="") as file:
            return list(csv.DictReader(file))

    def test_health_says_lost_and_which_map(self):
        rows = self.rows()
        self.assertEqual([row["time"] for row in rows], [pose[0] for pose in poses_of(shared("dark/out/odometry.tum"))])
        states = [row["state"] for row in rows]
        order = [state for i, state in enumerate(states) if i == 0 or state != states[i - 1]]
        self.assertEqual(order[:4], ["INITIALIZING", "TRACKING", "BRIDGING", "LOST"])
        self.assertEqual(order[-2:], ["RELOCATING", "TRACKING"])
        self.assertEqual({row["cause"] for row in rows if row["state"] == "BRIDGING"}, {"no points"})
        maps = [int(row["map"]) for row in rows]
        self.assertEqual(maps, sorted(maps))
        self.assertEqual(set(maps), {0, 1})
        self.assertEqual({row["map"] for row in rows if row["state"] in ("BRIDGING", "LOST")}, {"0"})

    def test_summary_tells_how_the_maps_began_and_what_lies_between(self):
        summary = json.loads(text_of(shared("dark/out/summary.json")))
        rows = self.rows()
        states = [row["state"] for row in rows]
        self.assertEqual(summary["scans_by_state"], {name: states.count(name) for name in summary["scans_by_state"]})
        self.assertEqual(sum(summary["scans_by_state"].values()), len(rows))
        first, second = summary["maps"]
        self.assertEqual((first["id"], first["began"], first["fell_asleep"]), (0, "at rest", "no points"))
        self.assertEqual((second["id"], second["began"], second["fell_asleep"]), (1, "after a gap", ""))
        self.assertEqual(first["last_believed"], rows[states.index("BRIDGING") - 1]["time"])
        self.assertEqual(second["last_believed"], rows[-1]["time"])
        gap = second["gap"]
        self.assertEqual(gap["from_map"], 0)
        self.assertTrue(gap["motion_is_known"])
        self.assertAlmostEqual(gap["seconds"], (ns_of(second["begin"]) - ns_of(first["last_believed"])) * 1e-9, places=6)
        self.assertAlmostEqual(gap["seconds"], 25.0, delta=0.2)
        self.assertGreater(gap["std_position_m"], 1.0)  # the budget

    def test_odometry_does_not_jump(self):
        poses = [[float(value) for value in pose] for pose in poses_of(shared("dark/out/odometry.tum"))]
        for a, b in zip(poses, poses[1:]):
            step = sum((p - q) ** 2 for p, q in zip(a[1:4], b[1:4])) ** 0.5
            # 1.4 m/s with sway and steps, what the velocity may be off after 25 s, and 3 cm.
            self.assertLess(step, 2.3 * (b[0] - a[0]) + 0.03, b[0])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
