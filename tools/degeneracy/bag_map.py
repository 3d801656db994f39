# SPDX-License-Identifier: MIT
"""What a bag that moves with the sensor leaves in the map, measured against the map without it."""
import math
import pathlib
import re
import struct
import tempfile

from degeneracy.bench import Bench, Item, Recording, Section, Wanted, catalogue_text, group_of
from degeneracy.health import in_body
from measure_scenarios import SCENARIOS, Pose, Vector, pose_at, read_tum, rotate, twin_of

CELL = 0.2  # cells that are judged [m]
FAR = 0.3  # from anything in the other map [m]
MOST = 3.0  # distances count no more than this [m]
SAMPLE = 1500  # of the far cells, whose distance is measured
FIRST = re.compile(r"^events:\n  - \{kind: (bag|torn_bag), start: ([\d.]+), duration: ([\d.]+)", re.MULTILINE)
Key = tuple[int, int, int]


def items(wanted: Wanted) -> list[Item]:
    made = []
    for path in sorted(SCENARIOS.glob("*_*.yaml")):
        text = catalogue_text(path.stem)
        if first := FIRST.search(text):
            made += [item_of(path.stem, text, first, method, part) for method in wanted.methods
                     for part in ("cut", "whole")]
    return made


def item_of(name: str, text: str, first: re.Match, method: str, part: str) -> Item:
    kind, start, duration = first[1], float(first[2]), float(first[3])
    settings = (f"duration={start + duration:g}",) if part == "cut" else ()
    return Item(f"{name}-{part}-{method}", group_of(name), text, settings, method=method,
                about={"scenario": name, "part": part, "kind": kind, "start": start})


def measure(bench: Bench, item: Item) -> dict:
    with bench.recording_of(item) as made:
        spoilt = world_map(bench, item.method, made, item.about["start"])
    with bench.recording_of(item._replace(scenario=twin_of(item.scenario))) as made:
        clean = world_map(bench, "default", made, item.about["start"])
    return compared(thinned(spoilt, CELL), clean)


def world_map(bench: Bench, method: str, made: Recording, start: float) -> list[Vector]:
    """The points of the map, placed by the truth at one moment before the event."""
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name)
        bench.run(method, made, out)
        poses = out / "trajectory.tum" if (out / "trajectory.tum").exists() else out / "odometry.tum"
        truth, estimate = read_tum(made.truth), read_tum(poses)
        moment = max((pose for pose in estimate if pose.time < truth[0].time + start), key=lambda pose: pose.time)
        return placed(read_pcd(out / "map.pcd"), moment, pose_at(truth, moment.time))


def read_pcd(path: pathlib.Path) -> list[Vector]:
    header, data = path.read_bytes().split(b"DATA binary\n", 1)
    width = 4 * sum(map(int, re.search(rb"COUNT ([\d ]+)", header)[1].split()))
    return [point[:3] for point in struct.iter_unpack(f"<{width // 4}f", data[:len(data) // width * width])]


def placed(points: list[Vector], estimate: Pose, truth: Pose) -> list[Vector]:
    moved = (rotate(truth.q, in_body(estimate, tuple(a - b for a, b in zip(p, estimate.p)))) for p in points)
    return [tuple(a + b for a, b in zip(p, truth.p)) for p in moved]


# ---- comparing; pure


def key_of(p: Vector, edge: float) -> Key:
    return (math.floor(p[0] / edge), math.floor(p[1] / edge), math.floor(p[2] / edge))


def thinned(points: list[Vector], edge: float) -> list[Vector]:
    return list({key_of(p, edge): p for p in points}.values())


def grid_of(points: list[Vector], edge: float) -> dict[Key, list[Vector]]:
    grid: dict[Key, list[Vector]] = {}
    for p in points:
        grid.setdefault(key_of(p, edge), []).append(p)
    return grid


def near(grid: dict[Key, list[Vector]], edge: float, p: Vector, reach: int) -> float:
    """Distance to the nearest point within `reach` cells; infinite if there is none."""
    x, y, z = key_of(p, edge)
    span = range(-reach, reach + 1)
    cells = (grid.get((x + i, y + j, z + k), ()) for i in span for j in span for k in span)
    return min((math.dist(p, q) for cell in cells for q in cell), default=math.inf)


def compared(cells: list[Vector], clean: list[Vector]) -> dict:
    grid = grid_of(clean, FAR)
    far = [p for p in cells if near(grid, FAR, p, 1) > FAR]
    coarse = grid_of(thinned(clean, 0.1), 1.0)
    sample = far[::max(1, len(far) // SAMPLE)]
    squares = [min(MOST, near(coarse, 1.0, p, 1 if near(coarse, 1.0, p, 1) <= 1.0 else 3)) ** 2 for p in sample]
    return {"cells": len(cells), "far": len(far), "rms_m": math.sqrt(sum(squares) / len(squares)) if squares else 0.0}


def line(figures: dict) -> str:
    return (f"{figures['far']} of {figures['cells']} cells far ({100.0 * figures['far'] / figures['cells']:.2f} %), "
            f"{100.0 * figures['rms_m']:.0f} cm")


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    lines = ["| scenario | bag | method | up to its end: far cells | rms [cm] | whole recording: far cells | rms [cm] |",
             "|---|---|---|---|---|---|---|"]
    good = {f["name"]: f for f in all_figures if "failed" not in f}
    for name, cut in good.items():
        whole = good.get(name.replace("-cut-", "-whole-"))
        if cut["about"]["part"] == "cut" and whole:
            about = cut["about"]
            lines.append(f"| `{about['scenario']}` | {about['kind']} | {cut['method']} | {share_of(cut)} | {share_of(whole)} |")
    return lines


def share_of(figures: dict) -> str:
    return f"{100.0 * figures['far'] / figures['cells']:.2f} % | {100.0 * figures['rms_m']:.0f}"


SECTION = Section(items, measure, line, table)
