# SPDX-License-Identifier: MIT
"""Trajectories as arrays, and how far two of them lie apart."""
import pathlib
from typing import NamedTuple

import numpy as np


class Track(NamedTuple):
    """Poses T_frame_imu in the order of their times."""

    time: np.ndarray  # n [s]
    R: np.ndarray  # n x 3 x 3
    p: np.ndarray  # n x 3 [m]

    def part(self, chosen) -> "Track":
        return Track(self.time[chosen], self.R[chosen], self.p[chosen])


class Placement(NamedTuple):
    """What maps an estimate's frame to that of the truth."""

    R: np.ndarray
    t: np.ndarray


class Error(NamedTuple):
    metres: float
    degrees: float


def rotations(q: np.ndarray) -> np.ndarray:
    """n x 3 x 3 of n quaternions x y z w."""
    x, y, z, w = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return np.moveaxis(np.array(rows), 2, 0)


def read_track(path: pathlib.Path) -> Track:
    return track_of(np.loadtxt(path, ndmin=2))


def track_of(rows: np.ndarray) -> Track:
    """Of lines time x y z qx qy qz qw."""
    return Track(rows[:, 0], rotations(rows[:, 4:8]), rows[:, 1:4])


def nearest_rotations(M: np.ndarray) -> np.ndarray:
    U, _, Vt = np.linalg.svd(M)
    flip = np.ones(M.shape[:-1])
    flip[..., 2] = np.linalg.det(U @ Vt)
    return (U * flip[..., None, :]) @ Vt


def track_at(track: Track, times: np.ndarray) -> Track:
    """Between two poses in proportion; before the first and after the last one, those."""
    times = np.clip(times, track.time[0], track.time[-1])
    after = np.clip(np.searchsorted(track.time, times), 1, len(track.time) - 1)
    before = after - 1
    share = (times - track.time[before]) / (track.time[after] - track.time[before])
    R = (1 - share)[:, None, None] * track.R[before] + share[:, None, None] * track.R[after]
    p = (1 - share)[:, None] * track.p[before] + share[:, None] * track.p[after]
    return Track(times, nearest_rotations(R), p)


def angle_deg(R: np.ndarray) -> np.ndarray:
    sine = 0.5 * np.linalg.norm(np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0],
                                          R[..., 1, 0] - R[..., 0, 1]]), axis=0)
    return np.degrees(np.arctan2(sine, 0.5 * (np.trace(R, axis1=-2, axis2=-1) - 1.0)))


def placement_of(truth: Track, estimate: Track) -> Placement:
    """By the attitudes as well: positions on a straight line, or on the spot, do not tell the rotation."""
    R = nearest_rotations(np.sum(truth.R @ np.swapaxes(estimate.R, 1, 2), axis=0))
    return Placement(R, truth.p.mean(axis=0) - R @ estimate.p.mean(axis=0))


def apart(a: Placement, b: Placement, where: np.ndarray) -> Error:
    """How far two placements of one estimate differ, at a point of its frame."""
    moved = (a.R - b.R) @ where + a.t - b.t
    return Error(float(np.linalg.norm(moved)), float(angle_deg(a.R.T @ b.R)))


def ate(truth: Track, estimate: Track) -> float:
    """Root mean square of the distances after the best alignment of the positions [m]."""
    a, b = truth.p - truth.p.mean(axis=0), estimate.p - estimate.p.mean(axis=0)
    R = nearest_rotations(a.T @ b)
    return float(np.sqrt(np.mean(np.sum((a - b @ R.T) ** 2, axis=1))))


def between(track: Track, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
    """Pose j in the frame of pose i."""
    return track.R[i].T @ track.R[j], track.R[i].T @ (track.p[j] - track.p[i])


def path_length(track: Track) -> float:
    return float(np.sum(np.linalg.norm(np.diff(track.p, axis=0), axis=1)))
