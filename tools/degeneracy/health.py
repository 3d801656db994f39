# SPDX-License-Identifier: MIT
"""What a run says of itself (health.csv), and what the truth says to that. Times in seconds."""
import bisect
import csv
import math
import pathlib
from typing import NamedTuple

from measure_scenarios import Pose, Vector, pose_at, rotate

FLAGGED = ("BRIDGING", "LOST", "RELOCATING")
PLACED = ("TRACKING", "DEGRADED")
CLOSED_GAP = 1.0  # episodes that are no farther apart are one [s]
LONGEST_STEP = 0.5  # where scans are missing for longer, there is no step to judge [s]
HALF_STEP = 0.01  # of the differences that make the true velocity [s]


class Health(NamedTuple):
    time: float
    state: str
    cause: str
    map: int
    v_imu: Vector | None  # [m/s]; nothing where the program does not tell
    down_imu: Vector | None
    tilt_std_deg: float | None  # of down_imu


class Episode(NamedTuple):
    """A run of scans of which none is believed."""

    start: float
    end: float
    causes: tuple[str, ...]
    states: tuple[str, ...]


def read_health(path: pathlib.Path) -> list[Health]:
    with path.open() as file:
        return [health_of(row) for row in csv.DictReader(file)]


def health_of(row: dict) -> Health:
    v = tuple(float(row[key]) for key in ("v_x_m_s", "v_y_m_s", "v_z_m_s")) if "v_x_m_s" in row else None
    down = tuple(float(row[key]) for key in ("down_x", "down_y", "down_z")) if "down_x" in row else None
    tilt = math.degrees(float(row["std_tilt_rad"])) if "std_tilt_rad" in row else None
    return Health(float(row["time"]), row["state"], row.get("cause", ""), int(row.get("map", 0)), v, down, tilt)


def episodes_of(rows: list[Health]) -> list[Episode]:
    found: list[Episode] = []
    for row in rows:
        if row.state not in FLAGGED:
            continue
        if found and row.time - found[-1].end < CLOSED_GAP:
            last = found[-1]
            found[-1] = Episode(last.start, row.time, merged(last.causes, row.cause), merged(last.states, row.state))
        else:
            found.append(Episode(row.time, row.time, (row.cause,), (row.state,)))
    return found


def merged(words: tuple[str, ...], word: str) -> tuple[str, ...]:
    return words if word in words else (*words, word)


def row_at(rows: list[Health], time: float) -> Health | None:
    """The last scan that ends by then."""
    number = bisect.bisect_right([row.time for row in rows], time + 1e-6)
    return rows[number - 1] if number > 0 else None


# ---- truth


def true_velocity(truth: list[Pose], time: float) -> Vector:
    """In the IMU frame [m/s]."""
    before, after = pose_at(truth, time - HALF_STEP), pose_at(truth, time + HALF_STEP)
    span = after.time - before.time
    v = tuple((b - a) / span for a, b in zip(before.p, after.p))
    return in_body(pose_at(truth, time), v)


def true_down(truth: list[Pose], time: float) -> Vector:
    return in_body(pose_at(truth, time), (0.0, 0.0, -1.0))


def in_body(pose: Pose, v: Vector) -> Vector:
    x, y, z, w = pose.q
    return rotate((-x, -y, -z, w), v)


def angle_deg(a: Vector, b: Vector) -> float:
    cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return math.degrees(math.atan2(math.hypot(*cross), sum(u * v for u, v in zip(a, b))))


def turn_rate_deg_s(truth: list[Pose], start: float, end: float) -> float:
    """Mean, over steps of 0.1 s."""
    total, steps = 0.0, max(1, round((end - start) / 0.1))
    for step in range(steps):
        a, b = (pose_at(truth, start + (end - start) * (step + i) / steps) for i in (0, 1))
        product = abs(sum(u * v for u, v in zip(a.q, b.q)))
        total += 2.0 * math.degrees(math.acos(min(1.0, product)))
    return total / (end - start)


def errors_at(rows: list[Health], truth: list[Pose], time: float) -> dict | None:
    """Of the last scan that ends by then: nothing if it says nothing."""
    row = row_at(rows, time)
    if row is None or row.v_imu is None or row.down_imu is None:
        return None
    return {"state": row.state, "cause": row.cause, "map": row.map, "age_s": time - row.time,
            "tilt_deg": angle_deg(true_down(truth, row.time), row.down_imu), "tilt_std_deg": row.tilt_std_deg,
            "speed_m_s": math.dist(true_velocity(truth, row.time), row.v_imu)}


# ---- continuity


class Steps(NamedTuple):
    poses: int
    worst_excess_m: float  # length of a step minus that of the true one
    worst_jump_m: float  # change of a step's error from one scan to the next
    jump_at: float


def steps_of(odometry: list[Pose], truth: list[Pose]) -> Steps:
    """Errors of steps are taken in the IMU frame, so that an old error of heading is none."""
    excess, jump, jump_at, last = 0.0, 0.0, 0.0, None
    for a, b in zip(odometry, odometry[1:]):
        if b.time - a.time > LONGEST_STEP:
            last = None
            continue
        true_a, true_b = pose_at(truth, a.time), pose_at(truth, b.time)
        excess = max(excess, math.dist(a.p, b.p) - math.dist(true_a.p, true_b.p))
        error = tuple(u - v for u, v in zip(step_in_body(a, b), step_in_body(true_a, true_b)))
        if last is not None and math.dist(error, last) > jump:
            jump, jump_at = math.dist(error, last), b.time
        last = error
    return Steps(len(odometry), excess, jump, jump_at)


def step_in_body(a: Pose, b: Pose) -> Vector:
    return in_body(a, tuple(v - u for u, v in zip(a.p, b.p)))


# ---- statistics


def quantile(values: list[float], share: float) -> float:
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else math.nan


def percent(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.0f} %" if whole else "none"
