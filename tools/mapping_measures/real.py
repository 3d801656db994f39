# SPDX-License-Identifier: MIT
"""Recordings that were not simulated here, as they are and spoilt: maps found again, judged by the truth and by the
run of the whole; and how far the last scan lies from the first, where a recording ends where it begins."""
import pathlib
import sys
import tempfile
from typing import NamedTuple

import numpy as np

from degeneracy.bench import Bench, Failed, Item, Recording, Section, Wanted, spoilt
from mapping_measures import common
from mapping_measures.common import failures, good, judged, measured, worst_merge
from mapping_measures.poses import Track, read_track, rotations, track_at
from mapping_measures.run_files import read_run
from measure_scenarios import ROOT, metres

RETURNS = 1.5  # a recording whose ends are nearer ends where it begins [m]
NEIGHBOURS, REACH, FLAT = 6, 0.5, 0.05  # of planes in the first scans: points, their distance [m], their roughness [m]
FIRST, LAST = 10, 3  # scans


class Named(NamedTuple):
    """NAME=BAG,RIG,TRUTH[,kind:start:duration[:severity]...]"""

    name: str
    made: Recording
    spoil: tuple[str, ...]


def named_of(spec: str) -> Named:
    name, _, rest = spec.partition("=")
    bag, rig, truth, *spoil = rest.split(",")
    return Named(name, Recording(pathlib.Path(bag), pathlib.Path(rig), pathlib.Path(truth), pathlib.Path()), tuple(spoil))


def items(wanted: Wanted) -> list[Item]:
    return [item_of(spec, method) for method in wanted.methods for spec in wanted.recordings]


def item_of(spec: str, method: str) -> Item:
    named = named_of(spec)
    return Item(f"{named.name}-{method}", "recorded", spec, (), named.spoil, method,
                {"recording": named.name, "spoil": ", ".join(named.spoil)})


def measure(bench: Bench, item: Item) -> dict:
    made = named_of(item.scenario).made
    if not item.spoil:
        figures = measured(bench, item, made)
        return figures | closing(bench, item, made)
    with tempfile.TemporaryDirectory(prefix="mapping_") as name:
        work = pathlib.Path(name)
        bad = spoilt(bench.simulator, made, item, work / "spoilt")
        figures = measured(bench, item, bad)
        bench.run("default", made, work / "whole")
        bench.run(item.method, bad, work / "out")
        whole = read_track(work / "whole" / "trajectory.tum")
        against = judged(read_run(work / "out"), whole)
    return figures | {"against_whole": {"ate_m": against["ate_m"], "merges": against["merges"]}}


def closing(bench: Bench, item: Item, made: Recording) -> dict:
    """Distance of the last scans from planes in the first, placed by each trajectory and by the truth."""
    truth = read_track(made.truth)
    if np.linalg.norm(truth.p[-1] - truth.p[0]) > RETURNS:
        return {}
    with tempfile.TemporaryDirectory(prefix="mapping_") as name:
        out = pathlib.Path(name)
        bench.run(item.method, made, out)
        # A copy whose points are as they were: bags are written without compression.
        nothing = item._replace(spoil=("range_cap:0.1:0.001:1000",))
        ends = scans_of(spoilt(bench.simulator, made, nothing, out / "copy").bag, out / "rig.yaml")
        if ends is None:
            return {}
        estimates = {file: read_track(out / f"{file}.tum") for file in ("odometry", "trajectory")}
    return {"closing": {name: plane_distance(*(placed(end, track) for end in ends))
                        for name, track in (*estimates.items(), ("truth", truth))}}


def scans_of(bag: pathlib.Path, rig: pathlib.Path) -> tuple[list, list] | None:
    """(time [s], points in the IMU frame) of the first and the last scans; nothing if the sensor moved during them."""
    sys.path.insert(0, str(ROOT / "tests" / "cli"))
    from raw_bag import Cloud, read_raw
    words = dict(row.split(":", 1) for row in rig.read_text().splitlines() if ":" in row and not row.startswith("#"))
    p, q = (np.array([float(v) for v in words[key].split("#")[0].strip(" []").split(",")])
            for key in ("p_imu_lidar", "q_imu_lidar_xyzw"))
    topic = words["lidar_topic"].split("#")[0].strip(' "')
    clouds = [Cloud(body) for name, _, _, body in read_raw(bag) if name == topic]
    if not clouds or any(np.ptp(column(cloud, "time")) > 0.0 for cloud in clouds[:FIRST]):
        return None
    R = rotations(q[None])[0]
    ends = [[(cloud.stamp * 1e-9, xyz_of(cloud) @ R.T + p) for cloud in part] for part in (clouds[:FIRST], clouds[-LAST:])]
    return ends[0], ends[1]


def column(cloud, name: str) -> np.ndarray:
    rows = np.frombuffer(cloud.data, dtype=np.uint8).reshape(-1, cloud.step)
    at = cloud.offsets[name] if name in cloud.offsets else None
    return np.zeros(1) if at is None else rows[:, at:at + 4].copy().view("<f4").ravel().astype(float)


def xyz_of(cloud) -> np.ndarray:
    points = np.stack([column(cloud, name) for name in "xyz"], axis=1)
    return points[np.isfinite(points).all(axis=1)]


def placed(scans: list, track: Track) -> np.ndarray:
    moved = []
    for time, points in scans:
        if track.time[0] - 0.01 <= time <= track.time[-1] + 0.01:
            at = track_at(track, np.array([time]))
            moved.append(points @ at.R[0].T + at.p[0])
    if not moved:
        raise Failed("no scan at the beginning, or at the end, has a pose")
    return np.concatenate(moved)


def plane_distance(first: np.ndarray, last: np.ndarray) -> dict:
    """Mean distance [m] of the last points from planes through their neighbours among the first."""
    from scipy.spatial import cKDTree
    distances, indices = cKDTree(first).query(last, k=NEIGHBOURS)
    near = distances[:, -1] < REACH
    groups = first[indices[near]]
    middle = groups.mean(axis=1)
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", groups - middle[:, None], groups - middle[:, None]) / NEIGHBOURS)
    flat = (np.sqrt(np.maximum(values[:, 0], 0.0)) < FLAT) & (values[:, 1] > 9.0 * values[:, 0])
    off = np.abs(np.einsum("ni,ni->n", last[near] - middle, vectors[:, :, 0]))[flat]
    if len(off) < 50:
        raise Failed(f"only {len(off)} points of the last scans lie on planes of the first")
    return {"mean_m": float(off.mean()), "points": len(off)}


def line(figures: dict) -> str:
    words = common.line(figures)
    if "closing" in figures:
        words += "; first to last " + ", ".join(f"{k} {v['mean_m']:.4f} m" for k, v in figures["closing"].items())
    if "against_whole" in figures:
        words += f"; against the whole: ATE {metres(figures['against_whole']['ate_m']['trajectory'])} m, merges " + (
            worst_merge(figures["against_whole"]) or "none")
    return words


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    lines = ["| recording | spoilt by | method | maps / worlds | merges: true / false / missed | worst merge against the truth "
             "[m / deg] | against the run of the whole | ATE of odometry.tum [m] | of trajectory.tum | placed scans | end to "
             "end [m] |", "|" + "---|" * 11]
    chosen = good(all_figures)
    lines += [row_of(f) for f in chosen]
    closed = [f for f in chosen if "closing" in f]
    if closed:
        lines += ["", "| recording | method | first to last, point to plane: by odometry.tum [m] | by trajectory.tum | by the truth | "
                  "points |", "|---|---|---|---|---|---|"]
        lines += [f"| {f['about']['recording']} | {f['method']} | " + " | ".join(
            f"{f['closing'][name]['mean_m']:.4f}" for name in ("odometry", "trajectory", "truth"))
            + f" | {f['closing']['trajectory']['points']} |" for f in closed]
    return lines + failures(all_figures)


def row_of(f: dict) -> str:
    false = sum(m["false"] for m in f["merges"])
    whole = worst_merge(f["against_whole"]) if "against_whole" in f else ""
    errors = f["ate_m"]
    return (f"| {f['about']['recording']} | {f['about']['spoil'] or 'nothing'} | {f['method']} | {f['maps']} / {f['worlds']} | "
            f"{len(f['merges']) - false} / {false} / {len(f['missed'])} | {worst_merge(f)} | {whole} | "
            f"{metres(errors['odometry'])} | {metres(errors['trajectory'])} | {metres(errors['placed'])} | {metres(f['end_m'])} |")


SECTION = Section(items, measure, line, table)
