#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The measures of tools/measure_mapping.py: placements, merges, missed maps, closures, distances of planes."""

import math
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
sys.dont_write_bytecode = True

try:
    import numpy as np
except ImportError:
    print("skipped: numpy is missing")
    sys.exit(77)

from mapping_measures.gaps import back, delay
from mapping_measures.judge import closure_error, end_to_end, false_closures, judged_merges, missed_worlds, shared_way
from mapping_measures.poses import Track, apart, ate, placement_of, rotations, track_at
from mapping_measures.real import plane_distance
from mapping_measures.run_files import Closure, Run, times_of, weak_directions

COUNT = 200


def yaw(angle):
    return rotations(np.array([[0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle)]]))[0]


def drive(count=COUNT, step=0.2):
    """Along x, at 2 m/s, turning a little."""
    time = 0.1 * np.arange(count)
    return Track(time, np.array([yaw(0.3 * math.sin(t)) for t in time]),
                 np.stack([step * np.arange(count), np.zeros(count), np.zeros(count)], axis=1))


def moved(track, R, t):
    return Track(track.time, R @ track.R, track.p @ R.T + t)


def joined(first, second):
    return Track(*(np.concatenate(pair) for pair in zip(first, second)))


def run_of(trajectory, maps, worlds, merges=(), closures=(), keyframe_times=()):
    summary = {"maps": [{"id": m, "world": w} for m, w in worlds.items()]}
    return Run(trajectory, trajectory, np.ones(len(maps), dtype=bool), np.array(maps), summary, list(merges),
               list(closures), np.array(keyframe_times))


def closure(R, t, weak=(), state="counts"):
    return Closure(0, 1, 0, 0, 0, state, "", R, np.array(t), np.array(weak).reshape(-1, 3))


class Poses(unittest.TestCase):
    def test_a_placement_undoes_a_motion(self):
        truth, R, t = drive(), yaw(0.7), np.array([3.0, -2.0, 1.0])
        placement = placement_of(truth, moved(truth, R, t))
        self.assertLess(np.abs(placement.R @ R - np.eye(3)).max(), 1e-12)
        self.assertLess(np.abs(placement.R @ t + placement.t).max(), 1e-12)
        self.assertLess(ate(truth, moved(truth, R, t)), 1e-12)

    def test_half_way_between_two_poses_is_half_the_way_and_half_the_turn(self):
        track = Track(np.array([0.0, 1.0]), np.array([yaw(0.0), yaw(0.2)]), np.array([[0.0, 0, 0], [2.0, 0, 0]]))
        middle = track_at(track, np.array([0.5]))
        self.assertAlmostEqual(middle.p[0, 0], 1.0)
        self.assertLess(np.abs(middle.R[0] - yaw(0.1)).max(), 1e-12)

    def test_ate_is_the_spread_that_no_motion_removes(self):
        truth = drive()
        off = truth.p + np.array([[0.0, 0.0, 0.03 * (-1) ** i] for i in range(COUNT)])
        # Turning it can remove about a millionth of the wiggle.
        self.assertAlmostEqual(ate(truth, Track(truth.time, truth.R, off)), 0.03, delta=1e-4)


class Merges(unittest.TestCase):
    def setUp(self):
        self.truth = drive()
        self.halves = self.truth.part(slice(0, 100)), self.truth.part(slice(100, COUNT))
        self.maps = [0] * 100 + [1] * 100
        self.merges = [{"map": 1, "into": 0, "time": "15.0"}]

    def judged(self, R, t):
        trajectory = joined(self.halves[0], moved(self.halves[1], R, t))
        return judged_merges(run_of(trajectory, self.maps, {0: 0, 1: 0}, self.merges), self.truth)[0]

    def test_a_map_that_lies_right_is_no_false_merge(self):
        merge = self.judged(np.eye(3), np.zeros(3))
        self.assertLess(merge.error.metres, 1e-9)
        self.assertFalse(merge.is_false)

    def test_the_error_is_how_far_the_middle_of_the_map_was_moved(self):
        middle = self.halves[1].p.mean(axis=0)
        R = yaw(math.radians(1.0))
        merge = self.judged(R, middle - R @ middle + np.array([0.0, 0.3, 0.4]))
        self.assertAlmostEqual(merge.error.metres, 0.5, delta=1e-6)
        self.assertAlmostEqual(merge.error.degrees, 1.0, delta=1e-6)
        self.assertTrue(self.judged(np.eye(3), np.array([0.0, 0.0, 0.6])).is_false)
        self.assertTrue(self.judged(yaw(math.radians(2.1)), np.zeros(3)).is_false)

    def test_worlds_are_missed_where_the_ways_lie_together(self):
        back = Track(self.halves[0].time + 10.0, self.halves[0].R, self.halves[0].p[::-1] + np.array([0.0, 4.0, 0.0]))
        for height, found in ((0.0, [1]), (3.0, [])):
            truth = joined(self.halves[0], Track(back.time, back.R, back.p + np.array([0.0, 0.0, height])))
            self.assertEqual(missed_worlds(run_of(truth, self.maps, {0: 0, 1: 1}), truth), found)
            self.assertEqual(missed_worlds(run_of(truth, self.maps, {0: 0, 1: 0}), truth), [])

    def test_a_short_encounter_is_not_enough(self):
        old = drive(100)
        new = Track(old.time, old.R, np.stack([np.full(100, 10.0), 0.2 * np.arange(100) - 10.0, np.zeros(100)], axis=1))
        self.assertAlmostEqual(shared_way(old, new), 9.8, delta=0.3)  # across, 5 m before to 5 m behind


class Closures(unittest.TestCase):
    def setUp(self):
        self.truth = drive()
        self.run = run_of(self.truth, [0] * COUNT, {0: 0}, keyframe_times=[2.0, 12.0])
        poses = track_at(self.truth, np.array([2.0, 12.0]))
        self.R, self.t = poses.R[0].T @ poses.R[1], poses.R[0].T @ (poses.p[1] - poses.p[0])

    def test_the_true_one_has_no_error(self):
        error = closure_error(closure(self.R, self.t), self.run, self.truth)
        self.assertLess(error.metres, 1e-9)
        self.assertLess(error.degrees, 1e-6)

    def test_one_that_is_off_is_false_if_it_is_used(self):
        off = closure(self.R, self.t + np.array([0.0, 0.0, 0.7]))
        for state, count in (("counts", 1), ("refused", 0)):
            run = self.run._replace(closures=[off._replace(state=state)])
            self.assertEqual(len(false_closures(run, self.truth, ("counts", "confirmed"))), count)

    def test_what_it_leaves_open_is_not_held_against_it(self):
        off = closure(self.R, self.t + self.R @ np.array([5.0, 0.1, 0.0]), weak=[[1.0, 0.0, 0.0]])
        self.assertAlmostEqual(closure_error(off, self.run, self.truth).metres, 0.1)
        unknown = self.run._replace(closures=[closure(self.R, self.t + 5.0)._replace(is_judgeable=False)])
        self.assertEqual(false_closures(unknown, self.truth, ("counts", "confirmed")), [])
        information = np.diag([0.01, 1e4, 1e4, 1e6, 1e6, 1e6])
        self.assertLess(np.abs(np.abs(weak_directions(information)) - [[1.0, 0.0, 0.0]]).max(), 1e-6)

    def test_keyframes_are_found_among_the_scans(self):
        times = times_of(self.truth.p[[0, 7, 50]] + 1e-9, self.truth)
        self.assertLess(np.abs(times - [0.0, 0.7, 5.0]).max(), 1e-9)

    def test_end_to_end_is_the_way_from_the_first_pose_to_the_last_whatever_their_attitudes(self):
        bent = Track(self.truth.time, self.truth.R.copy(), self.truth.p.copy())
        bent.p[-1] += [0.0, 0.2, 0.0]
        self.assertAlmostEqual(end_to_end(run_of(bent, [0] * COUNT, {0: 0}), self.truth), 0.2)
        tilted = Track(self.truth.time, self.truth.R.copy(), self.truth.p)
        tilted.R[0] = yaw(0.01)
        # A two-hundredth of the tilt, over 40 m.
        self.assertLess(end_to_end(run_of(tilted, [0] * COUNT, {0: 0}), self.truth), 0.0021)


class Gaps(unittest.TestCase):
    def test_a_map_is_resumed_joined_or_apart(self):
        merge = {"map": 1, "into": 0, "time": 130.0, "false": False}
        self.assertEqual(back({"maps": 1, "worlds": 1, "merges": []}), "resumed")
        self.assertEqual(back({"maps": 2, "worlds": 1, "merges": [merge]}), "joined")
        self.assertEqual(delay({"maps": 2, "worlds": 1, "merges": [merge]}, 120.0), 10.0)
        self.assertEqual(back({"maps": 2, "worlds": 1, "merges": [merge | {"false": True}]}), "apart")
        self.assertEqual(back({"maps": 2, "worlds": 2, "merges": []}), "apart")


class Planes(unittest.TestCase):
    def test_points_beside_a_plane_have_their_distance_from_it(self):
        try:
            import scipy  # noqa: F401
        except ImportError:
            self.skipTest("scipy is missing")
        x, y = np.meshgrid(np.arange(0, 4, 0.1), np.arange(0, 4, 0.1))
        plane = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
        found = plane_distance(plane, plane[::3] + np.array([0.03, 0.02, 0.025]))
        self.assertAlmostEqual(found["mean_m"], 0.025, delta=1e-9)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
