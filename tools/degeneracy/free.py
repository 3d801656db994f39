# SPDX-License-Identifier: MIT
"""Drives on which nothing happens: no map may end."""
import json
import pathlib
import tempfile

from degeneracy.bench import Bench, Item, Section, Wanted, catalogue_text, group_of
from degeneracy.health import episodes_of, read_health, steps_of
from measure_scenarios import SCENARIOS, metres, read_tum, twin_of

WALK = ("style: route, speed: 1.3, stand_still: 3.0, ramp: 2.0, corner_ratio: 0.6, corner_smoothing: 1.0, "
        "height: 1.3, rise: 0.06, bob: 0.014, bob_hz: 1.75, sway_deg: 2.6, sway_hz: 0.44, look_deg: 10.0, "
        "look_hz: 0.16, mount_yaw_deg: 12.0")
CAR = ("style: route, speed: {speed}, stand_still: 4.0, ramp: 5.0, corner_ratio: 0.5, corner_smoothing: 1.7, "
       "height: 1.6, rise: 0.05, bob: 0.006, bob_hz: 1.4, sway_deg: 0.9, sway_hz: 0.5, look_deg: 0.0, "
       "mount_yaw_deg: 9.0")
STOPS = "stops: [{at: 25, duration: 6}, {at: 60, duration: 10}]"
# scene, movers, sensor, columns, IMU, carrier (walk, or speed of a car), stops
DRIVES = [
    ("street", 60, "vlp16", 600, "bmi088", 8.0, True), ("street", 60, "hdl32e", 360, "consumer", 8.0, True),
    ("street", 80, "rs16", 600, "bmi088", 6.0, True), ("urban", 100, "vlp16", 600, "consumer", 9.0, True),
    ("tunnel", 20, "vlp16", 600, "bmi088", 9.0, True), ("tunnel", 20, "rs16", 600, "consumer", 7.0, True),
    ("corridor", 0, "mid360", 0, "consumer", None, True), ("corridor", 10, "hdl32e", 360, "bmi088", None, False),
    ("corridor", 0, "os1_64", 256, "consumer", None, False), ("field", 0, "hdl32e", 360, "consumer", None, True),
    ("field", 0, "mid360", 0, "bmi088", None, False), ("office", 6, "vlp16", 600, "bmi088", None, True),
    ("office", 6, "hdl32e", 360, "consumer", None, False), ("hall", 80, "vlp16", 600, "consumer", None, True),
    ("hall", 80, "os1_64", 256, "bmi088", None, True), ("yard", 30, "vlp16", 600, "consumer", None, True),
    ("campus", 150, "mid360", 0, "consumer", None, True), ("floors", 4, "vlp16", 600, "bmi088", None, False),
    ("floors", 0, "mid360", 0, "consumer", None, False), ("decoy", 10, "vlp16", 600, "bmi088", None, True),
]
LONG = 100.0  # duration of these [s]


def items(wanted: Wanted) -> list[Item]:
    return [item._replace(name=f"{item.name}-{method}", method=method)
            for method in wanted.methods for item in [*drives(wanted.seeds), *twins()]]


def drives(seeds: list[int]) -> list[Item]:
    made = []
    for seed in seeds:
        for number, drive in enumerate(DRIVES):
            # Two of three are for development; the rest, of other worlds, is for reporting alone.
            group = "held out" if number % 3 == 2 else "development"
            scene, movers, sensor = drive[:3]
            name = f"{scene}-{sensor}-{movers}-{seed}"
            made.append(Item(name, group, drive_text(number, seed, *drive), about={"scene": scene, "sensor": sensor}))
    return made


def drive_text(number: int, seed: int, scene: str, movers: int, sensor: str, columns: int, imu: str,
               speed: float | None, stops: bool) -> str:
    trajectory = WALK if speed is None else CAR.format(speed=speed)
    return "\n".join([
        f"duration: {LONG:g}", f"seed: {2000 + 100 * seed + number}",
        f"world: {{scene: {scene}, seed: {300 + number}, yaw_deg: {37 * number % 180}, movers: {movers}}}",
        f"sensor: {{model: {sensor}, columns: {columns}, p_imu_lidar: [0.05, 0.02, 0.15]}}",
        f"imu: {{model: {imu}, vibration: 0.4}}",
        f"trajectory: {{{trajectory}, start_lap: {number * 0.137 % 1.0:.3f}{', ' + STOPS if stops else ''}}}"])


def twins() -> list[Item]:
    """The catalogue without its events; scenarios that differ in nothing else are one. Short ones first."""
    found: dict[str, Item] = {}
    for path in sorted(SCENARIOS.glob("*_*.yaml")):
        text = twin_of(catalogue_text(path.stem))
        if path.stem.startswith(("dev_", "heldout_")) and text not in found:
            found[text] = Item(path.stem, group_of(path.stem), text, about={"scene": "", "sensor": ""})
    return sorted(found.values(), key=lambda item: float(item.scenario.split("duration: ")[1].split()[0]))


def measure(bench: Bench, item: Item) -> dict:
    with bench.recording_of(item) as made, tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name)
        bench.run(item.method, made, out)
        rows, truth = read_health(out / "health.csv"), read_tum(made.truth)
        summary = json.loads((out / "summary.json").read_text())
        evaluation = bench.evaluated(made.truth, out / "odometry.tum")
        steps = steps_of(read_tum(out / "odometry.tum"), truth)
    origin = truth[0].time
    return {"duration_s": evaluation["duration_s"], "path_m": evaluation["path_length_m"],
            "ate_m": evaluation["ate_m"]["rmse"], "ate_max_m": evaluation["ate_m"]["max"],
            "states": summary["scans_by_state"], "maps": len(summary.get("maps", [0])),
            "began": [m["began"] for m in summary.get("maps", [])],
            "episodes": [[e.start - origin, e.end - origin, *e.causes, *e.states] for e in episodes_of(rows)],
            "steps": steps._asdict() | {"jump_at": steps.jump_at - origin}}


def doubted(figures: dict) -> int:
    return sum(figures["states"].get(state, 0) for state in ("BRIDGING", "LOST", "RELOCATING"))


def line(figures: dict) -> str:
    episodes = "; ".join(f"{e[0]:.1f} to {e[1]:.1f} s {' '.join(e[2:])}" for e in figures["episodes"][:6])
    return (f"{'SPLIT, ' if figures['maps'] != 1 else ''}{figures['maps']} maps, {doubted(figures)} scans doubted, "
            f"ATE {metres(figures['ate_m'])} m, jump {figures['steps']['worst_jump_m']:.3f} m; {episodes}")


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    good = [f for f in all_figures if "failed" not in f]
    lines = ["| set | method | drives | minutes | km | split | scans not believed | worst ATE [m] |",
             "|---|---|---|---|---|---|---|---|"]
    for key in sorted({(f["group"], f["method"]) for f in good}):
        chosen = [f for f in good if (f["group"], f["method"]) == key]
        minutes, way = sum(f["duration_s"] for f in chosen) / 60.0, sum(f["path_m"] for f in chosen) / 1000.0
        lines.append(f"| {key[0]} | {key[1]} | {len(chosen)} | {minutes:.0f} | {way:.1f} | "
                     f"{sum(f['maps'] != 1 for f in chosen)} | {sum(map(doubted, chosen))} of "
                     f"{sum(sum(f['states'].values()) for f in chosen)} | "
                     f"{metres(max(f['ate_m'] for f in chosen))} |")
    lines += ["", "| drive | method | path | ATE [m] | maps | DEGRADED / not believed, of scans |", "|---|---|---|---|---|---|"]
    lines += [f"| `{f['name'].rsplit('-', 1)[0]}` | {f['method']} | {f['path_m']:.0f} m, {f['duration_s']:.0f} s | "
              f"{metres(f['ate_m'])} | {f['maps']} | {f['states']['DEGRADED']} / {doubted(f)} of "
              f"{sum(f['states'].values())} |" for f in good]
    return lines


SECTION = Section(items, measure, line, table)
