# SPDX-License-Identifier: MIT
"""Does it know again, after being blind in motion, how fast it moves and where down is?"""
import pathlib
import tempfile

from degeneracy.bench import Bench, Item, Section, Wanted, catalogue_text, group_of
from degeneracy.health import PLACED, Health, episodes_of, errors_at, percent, quantile, read_health, row_at
from measure_scenarios import read_events, read_tum

BASES = ["dev_hall32", "dev_event_campus_vlp16", "dev_factory_1", "dev_campus_1",
         "heldout_urbanloco", "heldout_event_campus_vlp16", "heldout_factory_1", "heldout_campus_1"]
IMUS = ["bmi088", "consumer"]
KINDS = {"blackout": "", "bag": ":0.6"}
DURATIONS = [2, 5, 10, 30]
START = 20.0  # of the event [s]
AFTER = [0.5, 1.0, 2.0]  # of its end [s]
MAX_TILT_DEG, MAX_SPEED = 0.5, 0.05
REST = 6.0  # that is driven after the event [s]


def items(wanted: Wanted) -> list[Item]:
    return [item_of(base, imu, kind, seconds, seed, method)
            for method in wanted.methods for seed in wanted.seeds for base in BASES for imu in IMUS
            for kind in KINDS for seconds in DURATIONS]


def item_of(base: str, imu: str, kind: str, seconds: int, seed: int, method: str) -> Item:
    duration = START + max(DURATIONS) + REST
    settings = ("events=[]", f"duration={duration:g}", f"imu.model={imu}", f"seed={seed}")
    return Item(f"{base}-{imu}-{kind}-{seconds}-{seed}-{method}", group_of(base), catalogue_text(base), settings,
                (f"{kind}:{START:g}:{seconds}{KINDS[kind]}",), method,
                {"base": base, "imu": imu, "kind": kind, "seconds": seconds})


def measure(bench: Bench, item: Item) -> dict:
    with bench.recording_of(item) as made, tempfile.TemporaryDirectory() as out:
        bench.run(item.method, made, pathlib.Path(out))
        rows, truth = read_health(pathlib.Path(out) / "health.csv"), read_tum(made.truth)
        event = read_events(made.events, 0.0)[0]
    start, end = event["start_s"], event["end_s"]
    inside = [row for row in rows if start + 0.1 < row.time <= end]
    flagged = [row for row in inside if row.state not in PLACED]
    again = next((row for row in rows if row.time > end + 0.1 and row.state in PLACED), None)
    figures = {"before": errors_at(rows, truth, start), "end": errors_at(rows, truth, end),
               "after": {f"{wait:g}": errors_at(rows, truth, end + wait) for wait in AFTER},
               "declared_s": flagged[0].time - start if flagged else None,
               "believed_inside": len(inside) - len(flagged), "map": way_on(rows, start, end),
               "placed_again_s": again.time - end if again else None,
               "causes": sorted({row.cause for row in flagged}),
               "episodes": [[e.start - truth[0].time, e.end - truth[0].time, *e.causes] for e in episodes_of(rows)]}
    return figures | {"right": is_right(figures["after"]["1"])}


def way_on(rows: list[Health], start: float, end: float) -> str:
    before, after = row_at(rows, start), row_at(rows, end + REST - 1.0)
    if before is None or after is None or after.state not in PLACED:
        return "none"
    return "same" if after.map == before.map else "new"


def is_right(errors: dict) -> bool:
    return errors["state"] in PLACED and errors["tilt_deg"] <= MAX_TILT_DEG and errors["speed_m_s"] <= MAX_SPEED


def line(figures: dict) -> str:
    words = [f"+{wait} s {errors['state']} {errors['tilt_deg']:.2f} deg {errors['speed_m_s']:.3f} m/s"
             for wait, errors in figures["after"].items()]
    declared = "never" if figures["declared_s"] is None else f"{figures['declared_s']:.1f} s"
    return (f"{'right' if figures['right'] else 'WRONG'}, map {figures['map']}, declared {declared}, "
            f"{figures['believed_inside']} believed inside; {'; '.join(words)}")


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    lines = ["| set | method | event | n | right at 1 s | the same map / a new one / none | tilt at 1 s, median / "
             "95 % [deg] | velocity at 1 s [m/s] | right at 2 s | placed again after, median / most [s] |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    keys = sorted({(f["group"], f["method"], f["about"]["kind"], f["about"]["seconds"]) for f in all_figures})
    for key in keys:
        chosen = [f for f in all_figures if "failed" not in f and key ==
                  (f["group"], f["method"], f["about"]["kind"], f["about"]["seconds"])]
        if chosen:
            lines.append(row_of(key, chosen))
    return lines


def row_of(key: tuple, chosen: list[dict]) -> str:
    group, method, kind, seconds = key
    n = len(chosen)
    at_1 = [f["after"]["1"] for f in chosen]
    maps = [f["map"] for f in chosen]
    waits = [f["placed_again_s"] for f in chosen if f["placed_again_s"] is not None]
    tilt, speed = ([e[name] for e in at_1] for name in ("tilt_deg", "speed_m_s"))
    return (f"| {group} | {method} | {kind}, {seconds} s | {n} | {percent(sum(f['right'] for f in chosen), n)} | "
            f"{maps.count('same')} / {maps.count('new')} / {maps.count('none')} | "
            f"{quantile(tilt, 0.5):.2f} / {quantile(tilt, 0.95):.2f} | "
            f"{quantile(speed, 0.5):.3f} / {quantile(speed, 0.95):.3f} | "
            f"{percent(sum(is_right(f['after']['2']) for f in chosen), n)} | "
            f"{quantile(waits, 0.5):.1f} / {quantile(waits, 1.0):.1f} |")


SECTION = Section(items, measure, line, table)
