# SPDX-License-Identifier: MIT
"""Drives on which nothing happens: what closing loops makes of the odometry, and what it costs."""
import pathlib

from degeneracy.bench import Bench, Item, Section, Wanted, catalogue_text, duration_of, group_of
from mapping_measures.common import (CLOSURE_HEAD, back_end_share, closure_words, failures, good, is_worse, line,
                                     measured)
from measure_scenarios import SCENARIOS, fingerprint, metres, twin_of

FAR = "five_km"  # the long drive, until it has gone 5 km


def items(wanted: Wanted) -> list[Item]:
    return [item for method in wanted.methods for seed in wanted.seeds for item in drives(method, seed)]


def drives(method: str, seed: int) -> list[Item]:
    """The catalogue without its events; scenarios that differ in nothing else are one. Short ones first."""
    found: dict[str, Item] = {}
    names = [path.stem for path in sorted(SCENARIOS.glob("*_*.yaml"))]
    for name in [name for name in names if name.startswith(("dev_", "heldout_"))] + ["long_drive"]:
        text = twin_of(catalogue_text(name))
        if text not in found:
            found[text] = item_of(name, text, method, seed)
    far = item_of(FAR, catalogue_text("long_drive"), method, seed)
    found[FAR] = far._replace(settings=(*far.settings, "duration=775"))
    return sorted(found.values(), key=lambda item: duration_of(item.scenario))


def item_of(name: str, text: str, method: str, seed: int) -> Item:
    return Item(f"{name}-{seed}-{method}", group_of(name), text, seed_settings(text, seed), method=method,
                about={"scenario": name, "seed": seed, "twin": fingerprint(text)})


def seed_settings(text: str, seed: int) -> tuple[str, ...]:
    """The first is the scenario's own."""
    own = next(int(row.split(":")[1]) for row in text.splitlines() if row.startswith("seed:"))
    return () if seed == 1 else (f"seed={own + 10000 * (seed - 1)}",)


def measure(bench: Bench, item: Item) -> dict:
    with bench.recording_of(item) as made:
        return measured(bench, item, made)


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    chosen = sorted(good(all_figures), key=lambda f: (f["path_m"], f["name"]))
    lines = ["| set | drives | km | worse than odometry by more than 2 % | false closures | maps split | most memory [MiB] |",
             "|---|---|---|---|---|---|---|", *(set_row(group, chosen) for group in sorted({f["group"] for f in chosen})), ""]
    lines += [f"| drive | path | ATE of odometry.tum [m] | of trajectory.tum | ratio | {CLOSURE_HEAD} | false | "
              "run [s] | back end, share of the drive's time | peak [MiB] |", "|" + "---|" * 10]
    return lines + [row_of(f) for f in chosen] + failures(all_figures)


def set_row(group: str, all_figures: list[dict]) -> str:
    chosen = [f for f in all_figures if f["group"] == group]
    return (f"| {group} | {len(chosen)} | {sum(f['path_m'] for f in chosen) / 1000:.1f} | {sum(map(is_worse, chosen))} | "
            f"{sum(len(f['false_closures']) for f in chosen)} | {sum(f['maps'] > 1 for f in chosen)} | "
            f"{max(f['peak_mib'] for f in chosen):.0f} |")


def row_of(f: dict) -> str:
    errors = f["ate_m"]
    return (f"| `{f['about']['scenario']}`, {f['about']['seed']} | {f['path_m']:.0f} m, {f['duration_s']:.0f} s | "
            f"{errors['odometry']:.4f} | {errors['trajectory']:.4f} | {errors['trajectory'] / errors['odometry']:.2f} | "
            f"{closure_words(f)} | {len(f['false_closures'])} | {f['wall_s']:.0f} | {back_end_share(f)} | {f['peak_mib']:.0f} |")


def twin_ates(cache: pathlib.Path, figures_of_folder) -> dict[tuple[str, int], float]:
    """ATE of the drives without events, by fingerprint and seed."""
    return {(f["about"]["twin"], f["about"]["seed"]): f["ate_m"]["trajectory"]
            for f in good(figures_of_folder(cache / "loops")) if f["method"] == "default"}


SECTION = Section(items, measure, line, table)
