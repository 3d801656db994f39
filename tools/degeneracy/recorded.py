# SPDX-License-Identifier: MIT
"""Recordings that were not simulated here, blind for a while: the whole, and each side alone."""
import json
import pathlib
import tempfile

from degeneracy.bench import Bench, Failed, Item, Recording, Section, Wanted
from degeneracy.health import episodes_of, read_health
from measure_scenarios import metres, read_tum


def items(wanted: Wanted) -> list[Item]:
    return [item_of(spec, method) for method in wanted.methods for spec in wanted.recordings]


def item_of(spec: str, method: str) -> Item:
    name = pathlib.Path(spec.split(":")[0]).stem
    return Item(f"{name}-{method}", "recorded", spec, method=method, about={"recording": name})


def measure(bench: Bench, item: Item) -> dict:
    bag, rig, truth, start, end = item.scenario.split(":")
    made = Recording(*map(pathlib.Path, (bag, rig, truth, "")))
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name)
        bench.run(item.method, made, out)
        rows, origin = read_health(out / "health.csv"), read_tum(made.truth)[0].time
        first, last = origin + float(start), origin + float(end)
        parts = {"whole": (0.0, 1e18), "before": (0.0, first), "after": (last + 2.0, 1e18)}
        ate = {part: part_ate(bench, made, out, span) for part, span in parts.items()}
        summary = json.loads((out / "summary.json").read_text())
    stages = summary["stages"]
    return {"judging_ms": stages.get("health", {}).get("mean_ms"), "total_ms": stages["total"]["mean_ms"],
            "ate_m": ate, "maps": len(summary.get("maps", [0])), "states": summary["scans_by_state"],
            "episodes": [[e.start - origin, e.end - origin, *e.causes] for e in episodes_of(rows)]}


def part_ate(bench: Bench, made: Recording, out: pathlib.Path, span: tuple[float, float]) -> float:
    lines = [line for line in (out / "odometry.tum").read_text().splitlines()
             if not line.startswith("#") and span[0] <= float(line.split()[0]) <= span[1]]
    if not lines:
        raise Failed("no pose lies on one side of the blindness")
    (out / "part.tum").write_text("\n".join(lines) + "\n")
    return bench.evaluated(made.truth, out / "part.tum")["ate_m"]["rmse"]


def line(figures: dict) -> str:
    words = ", ".join(f"{part} {metres(ate)} m" for part, ate in figures["ate_m"].items())
    return f"{words}; {figures['maps']} maps; {figures['episodes']}"


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    lines = ["| recording | method | maps | ATE, whole [m] | before | from 2 s after | judging, of the time per scan [ms] |",
             "|---|---|---|---|---|---|---|"]
    return lines + [f"| {f['about']['recording']} | {f['method']} | {f['maps']} | " +
                    " | ".join(metres(f["ate_m"][part]) for part in ("whole", "before", "after")) +
                    f" | {judging(f)} |" for f in all_figures if "failed" not in f]


def judging(f: dict) -> str:
    if f.get("judging_ms") is None:
        return ""
    return f"{f['judging_ms']:.3f} of {f['total_ms']:.2f}, {100.0 * f['judging_ms'] / f['total_ms']:.1f} %"


SECTION = Section(items, measure, line, table)
