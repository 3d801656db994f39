# SPDX-License-Identifier: MIT
"""Starts with nothing known, in motion: many short recordings."""
import json
import pathlib
import random
import tempfile

from degeneracy.bench import Bench, Item, Section, Wanted
from degeneracy.health import PLACED, errors_at, percent, quantile, read_health, turn_rate_deg_s
from measure_scenarios import path_length, read_tum

DURATION = 8.0  # of a recording [s]
NUMBER = 120  # of recordings for one seed of the noise
WAIT = 1.0  # from the declared start to the comparison [s]
MAX_TILT_DEG, MAX_SPEED = 1.0, 0.1
SENSORS = [("vlp16", 900), ("hdl32e", 600), ("mid360", 0), ("os1_64", 360), ("rs16", 900)]
IMUS = ["bmi088", "consumer"]
# scene, style, slowest and fastest speed [m/s], height of the IMU [m], sway [deg]
PLACES = [("hall", "route", 0.5, 2.0, 1.3, 2.5), ("hall", "ellipse", 0.8, 3.0, 1.3, 2.5),
          ("office", "route", 0.5, 1.2, 1.3, 2.0), ("street", "route", 3.0, 12.0, 1.6, 0.8),
          ("campus", "route", 1.0, 8.0, 1.3, 0.9), ("yard", "route", 0.7, 3.0, 1.4, 3.0),
          ("urban", "route", 5.0, 12.0, 1.6, 0.8)]


def items(wanted: Wanted) -> list[Item]:
    return [item_of(number, seed, method) for method in wanted.methods for seed in wanted.seeds
            for number in range(NUMBER)]


def item_of(number: int, seed: int, method: str) -> Item:
    # Every third is held out: other worlds and other ways.
    group = "held out" if number % 3 == 2 else "development"
    draw = random.Random(1000 + number)
    sensor, columns = SENSORS[number % len(SENSORS)]
    scene, style, slow, fast, height, sway = PLACES[number % len(PLACES)]
    speed, imu = round(slow * (fast / slow) ** draw.random(), 2), IMUS[number // 2 % 2]
    scenario = "\n".join([
        f"duration: {DURATION:g}", f"seed: {5000 + 1000 * seed + number}",
        f"world: {{scene: {scene}, seed: {500 + number}, yaw_deg: {draw.uniform(-180, 180):.1f}}}",
        f"sensor: {{model: {sensor}, columns: {columns}, p_imu_lidar: [0.1, -0.03, 0.2]}}",
        f"imu: {{model: {imu}, vibration: 0.4}}",
        f"trajectory: {{style: {style}, speed: {speed}, start_in_motion: true, start_lap: {draw.random():.3f}, "
        f"reverse: {'true' if draw.random() < 0.5 else 'false'}, corner_ratio: {draw.uniform(0.4, 0.7):.2f}, "
        f"corner_smoothing: {1.7 if fast > 4 else 1.0}, height: {height}, rise: 0.05, bob: 0.01, bob_hz: 1.6, "
        f"sway_deg: {sway}, sway_hz: 0.5, look_deg: {8 if fast < 4 else 0}, look_hz: 0.16, "
        f"semi_axis_x: 9.0, semi_axis_y: 6.0, mount_yaw_deg: {draw.uniform(-30, 30):.1f}}}"])
    return Item(f"{number:03}-{scene}-{sensor}-{seed}-{method}", group, scenario, method=method,
                about={"scene": scene, "sensor": sensor, "imu": imu, "speed": speed})


def measure(bench: Bench, item: Item) -> dict:
    with bench.recording_of(item) as made, tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name)
        bench.run(item.method, made, out)
        rows, truth = read_health(out / "health.csv"), read_tum(made.truth)
        summary = json.loads((out / "summary.json").read_text())
    origin, last = truth[0].time, rows[-1].time
    started = max((row.time for row in rows if row.state == "INITIALIZING"), default=None)
    figures = {"speed_m_s": path_length(truth, origin, last) / (last - origin),
               "turn_deg_s": turn_rate_deg_s(truth, origin, min(last, origin + 3.0)),
               "began": [m["began"] for m in summary["maps"]], "states": summary["scans_by_state"]}
    if started is None or started + WAIT > last:
        return figures | {"start_s": None, "errors": None, "end": errors_at(rows, truth, last), "right": False}
    errors = errors_at(rows, truth, started + WAIT)
    right = (errors["state"] in PLACED and errors["tilt_deg"] <= MAX_TILT_DEG and errors["speed_m_s"] <= MAX_SPEED
             and len(summary["maps"]) == 1)
    return figures | {"start_s": started - origin, "at_start": errors_at(rows, truth, started), "errors": errors,
                      "end": errors_at(rows, truth, last), "right": right}


def line(figures: dict) -> str:
    words = f"{figures['speed_m_s']:.1f} m/s, {figures['turn_deg_s']:.0f} deg/s, {figures['began'][0]}"
    if figures["start_s"] is None:
        return f"NEVER started; {words}"
    errors, end = figures["errors"], figures["end"]
    hidden = has_speed(figures) and errors["tilt_deg"] <= 3.0 * errors["tilt_std_deg"]
    verdict = "right" if figures["right"] else "tilt in doubt, as it says," if hidden else "WRONG"
    return (f"{verdict} after {figures['start_s']:.1f} s, {errors['state']} "
            f"{errors['tilt_deg']:.2f} deg (std {errors['tilt_std_deg']:.2f}) {errors['speed_m_s']:.3f} m/s, at the end {end['state']} "
            f"{end['tilt_deg']:.2f} deg {end['speed_m_s']:.3f} m/s; maps {len(figures['began'])}; {words}")


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    lines = ["| set | method | sensor or IMU | n | velocity right | and tilt | tilt within 3 of its own deviations | "
             "never started | time to start, median / most [s] | tilt, median / 95 % [deg] | its own deviation, median [deg] | "
             "velocity, median / 95 % [m/s] |", "|" + "---|" * 12]
    good = [f for f in all_figures if "failed" not in f]
    for group, method in sorted({(f["group"], f["method"]) for f in good}):
        chosen = [f for f in good if (f["group"], f["method"]) == (group, method)]
        for part in ("sensor", "imu"):
            kinds = sorted({f["about"][part] for f in chosen})
            lines += [row_of(group, method, kind, [f for f in chosen if f["about"][part] == kind]) for kind in kinds]
        lines.append(row_of(group, method, "all", chosen))
    return lines


def row_of(group: str, method: str, kind: str, chosen: list[dict]) -> str:
    started = [f for f in chosen if f["start_s"] is not None]
    swift = sum(has_speed(f) for f in started)
    honest = sum(f["errors"]["tilt_deg"] <= 3.0 * f["errors"]["tilt_std_deg"] for f in started)
    times = [f["start_s"] for f in started]
    tilt, own, speed = ([f["errors"][name] for f in started] for name in ("tilt_deg", "tilt_std_deg", "speed_m_s"))
    return (f"| {group} | {method} | {kind} | {len(chosen)} | {percent(swift, len(chosen))} | "
            f"{percent(sum(f['right'] for f in chosen), len(chosen))} | {percent(honest, len(started))} | "
            f"{len(chosen) - len(started)} | {quantile(times, 0.5):.1f} / {quantile(times, 1.0):.1f} | "
            f"{quantile(tilt, 0.5):.2f} / {quantile(tilt, 0.95):.2f} | {quantile(own, 0.5):.2f} | "
            f"{quantile(speed, 0.5):.3f} / {quantile(speed, 0.95):.3f} |")


def has_speed(figures: dict) -> bool:
    errors = figures["errors"]
    return errors["state"] in PLACED and errors["speed_m_s"] <= MAX_SPEED and len(figures["began"]) == 1


SECTION = Section(items, measure, line, table)
