# SPDX-License-Identifier: MIT
"""What a run wrote about places, closures and maps (docs/formats.md)."""
import csv
import json
import pathlib
from typing import NamedTuple

import numpy as np

from degeneracy.bench import Failed
from degeneracy.health import PLACED, read_health
from mapping_measures.poses import Track, read_track, rotations

SAME = 1e-4  # a keyframe is the scan that lies where it does, but for rounding [m]


class Closure(NamedTuple):
    id: int
    source: int
    target: int
    source_map: int
    target_map: int
    state: str
    reason: str
    R: np.ndarray  # T_target_source
    t: np.ndarray
    weak: np.ndarray  # k x 3: directions in the source's frame that it leaves open
    is_judgeable: bool = True  # what it leaves open is known


class Run(NamedTuple):
    odometry: Track
    trajectory: Track
    placed: np.ndarray  # for each scan, whether it was matched
    map: np.ndarray  # of each scan
    summary: dict
    merges: list[dict]
    closures: list[Closure]
    keyframe_times: np.ndarray

    @property
    def worlds(self) -> dict[int, int]:
        return {m["id"]: m["world"] for m in self.summary["maps"]}


def read_run(out: pathlib.Path) -> Run:
    trajectory, rows = read_track(out / "trajectory.tum"), read_health(out / "health.csv")
    if len(rows) != len(trajectory.time):
        raise Failed(f"health.csv has {len(rows)} scans, trajectory.tum {len(trajectory.time)}")
    keyframes, information = read_graph(out / "graph.g2o")
    return Run(read_track(out / "odometry.tum"), trajectory, np.array([row.state in PLACED for row in rows]),
               np.array([row.map for row in rows]), json.loads((out / "summary.json").read_text()),
               json.loads((out / "merges.json").read_text()) if (out / "merges.json").exists() else [],
               read_closures(out / "closures.csv", information), times_of(keyframes, trajectory))


def read_graph(path: pathlib.Path) -> tuple[np.ndarray, dict[tuple[int, int], np.ndarray]]:
    """Positions of the keyframes, and the information of the edges, translation before rotation."""
    positions, information = [], {}
    for line in path.read_text().splitlines() if path.exists() else []:
        words = line.split()
        if words[0] == "VERTEX_SE3:QUAT":
            positions.append([float(word) for word in words[2:5]])
        elif words[0] == "EDGE_SE3:QUAT":
            upper = np.zeros((6, 6))
            upper[np.triu_indices(6)] = [float(word) for word in words[10:31]]
            information[int(words[1]), int(words[2])] = upper + np.triu(upper, 1).T
    return np.array(positions).reshape(-1, 3), information


def times_of(keyframes: np.ndarray, trajectory: Track) -> np.ndarray:
    """Every keyframe is a scan and lies where that does; they are in the order of their times."""
    times, first = [], 0
    for keyframe in keyframes:
        distances = np.linalg.norm(trajectory.p[first:] - keyframe, axis=1)
        near = np.flatnonzero(distances < SAME)
        if len(near) == 0:
            raise Failed(f"keyframe {len(times)} of graph.g2o is no scan of trajectory.tum")
        first += int(near[0])
        times.append(trajectory.time[first])
    return np.array(times)


def read_closures(path: pathlib.Path, information: dict[tuple[int, int], np.ndarray]) -> list[Closure]:
    if not path.exists():
        return []
    with path.open() as file:
        return [closure_of(row, information) for row in csv.DictReader(file)]


def closure_of(row: dict, information: dict[tuple[int, int], np.ndarray]) -> Closure:
    source, target = int(row["source"]), int(row["target"])
    q = np.array([[float(row[key]) for key in ("qx", "qy", "qz", "qw")]])
    return Closure(int(row["id"]), source, target, int(row["source_map"]), int(row["target_map"]), row["state"],
                   row["reason"], rotations(q)[0], np.array([float(row[key]) for key in "xyz"]),
                   weak_directions(information.get((target, source))),
                   (target, source) in information or "0 of 6 directions undetermined" in row["reason"])


def weak_directions(information: np.ndarray | None, weak_std: float = 0.3) -> np.ndarray:
    """Directions in which an edge of the graph says that it does not know its position better than weak_std [m]."""
    if information is None:
        return np.zeros((0, 3))
    covariance = np.linalg.inv(information + 1e-9 * np.eye(6))[:3, :3]
    values, vectors = np.linalg.eigh(covariance)
    return vectors[:, values > weak_std**2].T
