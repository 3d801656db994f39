#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The measures of tools/measure_degeneracy.py: episodes, truth, delays, needless maps, distances of maps."""

import math
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
sys.dont_write_bytecode = True

from degeneracy.bag_map import compared, placed
from degeneracy.events import Event, delay_of, excused_episodes, false_episodes, must_be_declared, needless_splits
from degeneracy.health import Health, angle_deg, episodes_of, errors_at, steps_of, true_velocity
from measure_scenarios import Pose


def rows_of(states):
    """Scans of 0.1 s; one letter each: T, B, L, and a blank where there is no scan."""
    names = {"T": "TRACKING", "B": "BRIDGING", "L": "LOST"}
    return [Health(0.1 * (i + 1), names[letter], "", 0, (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), None)
            for i, letter in enumerate(states) if letter != " "]


def yawed(time, p, yaw):
    return Pose(time, p, (0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)))


class Episodes(unittest.TestCase):
    def test_shorter_gaps_than_a_second_are_closed_and_longer_ones_are_not(self):
        self.assertEqual(len(episodes_of(rows_of("TTBB" + "T" * 8 + "BLTT"))), 1)
        self.assertEqual(len(episodes_of(rows_of("TTBB" + "T" * 11 + "BLTT"))), 2)

    def test_an_episode_away_from_all_events_is_false(self):
        episodes = episodes_of(rows_of("T" * 20 + "BB" + "T" * 30))
        near, far = (Event("bag", start, start + 1.0, 0.6, True, False) for start in (0.5, 4.0))
        self.assertEqual(len(false_episodes(episodes, [far])), 1)
        self.assertEqual(false_episodes(episodes, [near, far]), [])

    def test_an_episode_of_an_event_that_may_be_declared_is_excused(self):
        episodes = episodes_of(rows_of("T" * 20 + "BB" + "T" * 30))
        for must, excused in ((True, 0), (False, 1)):
            self.assertEqual(len(excused_episodes(episodes, [Event("thin", 1.9, 2.5, 0.1, must, True)])), excused)

    def test_delay_counts_from_the_start_and_without_scans_from_the_end(self):
        blackout = Event("blackout", 1.0, 2.0, 0.0, True, False)
        rows = rows_of("T" * 12 + "B" * 8 + "T" * 5)
        self.assertAlmostEqual(delay_of(blackout, rows, episodes_of(rows)), 0.3)
        rows = rows_of("T" * 10 + " " * 11 + "B" + "T" * 5)
        self.assertAlmostEqual(delay_of(blackout, rows, episodes_of(rows)), 0.2)
        rows = rows_of("T" * 25)
        self.assertIsNone(delay_of(blackout, rows, episodes_of(rows)))

    def test_what_must_be_declared(self):
        self.assertTrue(must_be_declared("bag", 0.6, 0.0, 20))
        self.assertFalse(must_be_declared("packet_loss", 1.0, 5.0, 0))
        self.assertFalse(must_be_declared("thin_to", 30.0, 0.05, 20))
        self.assertTrue(must_be_declared("thin_to", 30.0, 0.5, 20))

    def test_a_map_without_an_event_or_after_a_harmless_one_is_needless(self):
        events = [Event("bag", 10.0, 20.0, 0.6, True, False), Event("thin", 40.0, 45.0, 0.1, False, True)]
        self.assertEqual(needless_splits([21.0, 35.0, 46.0], events), [35.0, 46.0])


class Truth(unittest.TestCase):
    def test_velocity_and_down_are_those_of_the_imu_frame(self):
        # Along the world's y at 2 m/s, looking along y: straight on.
        truth = [yawed(0.01 * i, (0.0, 0.02 * i, 0.0), 0.5 * math.pi) for i in range(100)]
        self.assertLess(math.dist(true_velocity(truth, 0.5), (2.0, 0.0, 0.0)), 1e-9)
        errors = errors_at(rows_of("TTTTTTT"), truth, 0.55)
        self.assertAlmostEqual(errors["speed_m_s"], 1.0)
        self.assertAlmostEqual(errors["tilt_deg"], 0.0)

    def test_angle(self):
        self.assertAlmostEqual(angle_deg((0.0, 0.0, -1.0), (0.0, math.sin(0.01), -math.cos(0.01))), math.degrees(0.01))

    def test_a_correction_is_a_jump_and_a_wrong_velocity_or_heading_is_none(self):
        truth = [yawed(0.1 * i, (0.1 * i, 0.0, 0.0), 0.0) for i in range(50)]
        faster = [yawed(0.1 * i, (0.0, 0.15 * i, 0.0), 0.5 * math.pi) for i in range(50)]
        steps = steps_of(faster, truth)
        self.assertAlmostEqual(steps.worst_excess_m, 0.05)
        self.assertLess(steps.worst_jump_m, 1e-9)
        jumping = [yawed(0.1 * i, (0.1 * i + (0.3 if i >= 20 else 0.0), 0.0, 0.0), 0.0) for i in range(50)]
        self.assertAlmostEqual(steps_of(jumping, truth).worst_jump_m, 0.3)
        self.assertAlmostEqual(steps_of(jumping, truth).jump_at, 2.0)


class Maps(unittest.TestCase):
    WALL = [(0.1 * i, 0.1 * j, 0.0) for i in range(30) for j in range(10)]

    def test_cells_off_the_surface_are_counted_with_their_distance(self):
        ghosts = [(0.1 * i, 0.45, 0.8) for i in range(10)]
        figures = compared([*self.WALL, *ghosts], self.WALL)
        self.assertEqual((figures["cells"], figures["far"]), (310, 10))
        self.assertLess(abs(figures["rms_m"] - 0.8), 0.01)  # the wall has a point every 0.1 m

    def test_the_same_map_has_none(self):
        self.assertEqual(compared(self.WALL, self.WALL)["far"], 0)

    def test_a_map_is_placed_by_one_true_pose(self):
        moved = placed([(2.0, 0.0, 0.0)], yawed(0.0, (1.0, 0.0, 0.0), 0.0), yawed(0.0, (5.0, 5.0, 1.0), 0.5 * math.pi))
        self.assertLess(math.dist(moved[0], (5.0, 6.0, 1.0)), 1e-9)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
