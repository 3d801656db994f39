# SPDX-License-Identifier: MIT
"""What the truth says to closures and merges."""
from typing import NamedTuple

import numpy as np

from mapping_measures.poses import Error, Track, angle_deg, apart, between, path_length, placement_of, track_at
from mapping_measures.run_files import Closure, Run

FALSE_M, FALSE_DEG = 0.5, 2.0  # what is off by more was joined falsely
CLOSE_M, CLOSE_DEG = 0.1, 0.3  # what is asked of a merge
NEAR, NEAR_HEIGHT, SHARED = 5.0, 1.5, 10.0  # maps that share so much of their ways could have met [m]
FEW = 5  # scans by which no map can be placed


class JudgedMerge(NamedTuple):
    map: int
    into: int
    error: Error | None
    time: float

    @property
    def is_false(self) -> bool:
        return self.error is not None and is_false(self.error)


def is_false(error: Error) -> bool:
    return error.metres > FALSE_M or error.degrees > FALSE_DEG


def judged_merges(run: Run, truth: Track) -> list[JudgedMerge]:
    """Every merge by where its two sides lie in the end, each placed in the truth by its own matched scans. An error
    is told at the middle of the side that moved."""
    groups = {m: {m} for m in run.worlds}
    judged = []
    for merge in (merge for merge in run.merges if "undone" not in merge):
        into, moved = groups.pop(merge["into"]), groups.pop(merge["map"])
        judged.append(JudgedMerge(merge["map"], merge["into"], side_error(run, truth, into, moved), float(merge["time"])))
        groups[min(merge["into"], merge["map"])] = into | moved
    return judged


def side_error(run: Run, truth: Track, into: set[int], moved: set[int]) -> Error | None:
    sides = [run.placed & np.isin(run.map, list(side)) for side in (into, moved)]
    if min(np.count_nonzero(side) for side in sides) < FEW:
        return None
    a, b = (placement_of(track_at(truth, run.trajectory.time[side]), run.trajectory.part(side)) for side in sides)
    return apart(a, b, run.trajectory.p[sides[1]].mean(axis=0))


def missed_worlds(run: Run, truth: Track) -> list[int]:
    """Worlds that stayed apart though the way in them is near that in an earlier one for long enough."""
    missed = []
    worlds = sorted(set(run.worlds.values()))
    ways = {world: way_of(run, truth, world) for world in worlds}
    for number, world in enumerate(worlds):
        if any(shared_way(ways[earlier], ways[world]) >= SHARED for earlier in worlds[:number]):
            missed.append(world)
    return missed


def way_of(run: Run, truth: Track, world: int) -> Track:
    maps = [m for m, w in run.worlds.items() if w == world]
    return track_at(truth, run.trajectory.time[run.placed & np.isin(run.map, maps)])


def shared_way(old: Track, new: Track) -> float:
    """Length of the new way that is near the old one [m]."""
    if len(old.time) < FEW or len(new.time) < FEW:
        return 0.0
    thin = old.p[::3]
    near = np.zeros(len(new.time), dtype=bool)
    for i, p in enumerate(new.p):
        off = thin - p
        near[i] = np.any((np.hypot(off[:, 0], off[:, 1]) < NEAR) & (np.abs(off[:, 2]) < NEAR_HEIGHT))
    steps = np.linalg.norm(np.diff(new.p, axis=0), axis=1)
    return float(np.sum(steps[near[1:] & near[:-1]]))


def closure_error(closure: Closure, run: Run, truth: Track) -> Error:
    """Against the true pose of the one keyframe in the other, along what the closure determines."""
    poses = track_at(truth, run.keyframe_times[[closure.target, closure.source]])
    R, t = between(poses, 0, 1)
    off = closure.R.T @ (t - closure.t)
    for direction in closure.weak:
        off = off - direction * (direction @ off)
    return Error(float(np.linalg.norm(off)), float(angle_deg(closure.R.T @ R)))


def false_closures(run: Run, truth: Track, states: tuple[str, ...]) -> list[dict]:
    found = []
    for closure in run.closures:
        if closure.state in states and closure.is_judgeable and is_false(error := closure_error(closure, run, truth)):
            found.append({"id": closure.id, "state": closure.state, "maps": [closure.source_map, closure.target_map],
                          "metres": error.metres, "degrees": error.degrees, "reason": closure.reason})
    return found


def end_to_end(run: Run, truth: Track) -> float:
    """Error of the way from the first pose to the last [m]. The heading is that of all placed scans: the attitude of
    the first alone may be off where a start in motion was still finding it."""
    at_scans = track_at(truth, run.trajectory.time)
    chosen = run.placed if np.count_nonzero(run.placed) >= FEW else slice(None)
    R = placement_of(at_scans.part(chosen), run.trajectory.part(chosen)).R
    ways = (track.p[-1] - track.p[0] for track in (at_scans, run.trajectory))
    return float(np.linalg.norm(next(ways) - R @ next(ways)))


def length(truth: Track, run: Run) -> float:
    return path_length(track_at(truth, run.trajectory.time))
