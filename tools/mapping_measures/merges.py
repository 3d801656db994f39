# SPDX-License-Identifier: MIT
"""The catalogue with its events: which maps are joined, how well, and what becomes of the trajectory."""
import pathlib

from degeneracy.bench import Item, Section, Wanted, all_figures as figures_in, catalogue_text, group_of
from degeneracy.health import percent
from mapping_measures.common import (back_end_share, failures, good, is_close, is_worse, line, median, work_shares,
                                     worst_merge)
from mapping_measures.loops import measure, seed_settings, twin_ates
from measure_scenarios import SCENARIOS, fingerprint, metres, twin_of

END = 0.05  # asked of the end-to-end error where the paper states one [m]
TWIN = 1.2  # times the ATE without events are asked of the ATE


def items(wanted: Wanted) -> list[Item]:
    names = [path.stem for path in sorted(SCENARIOS.glob("*_*.yaml")) if path.stem.startswith(("dev_", "heldout_"))]
    return [item_of(name, seed, method) for method in wanted.methods for seed in wanted.seeds for name in names
            if catalogue_text(name) != twin_of(catalogue_text(name))]


def item_of(name: str, seed: int, method: str) -> Item:
    text = catalogue_text(name)
    return Item(f"{name}-{seed}-{method}", group_of(name), text, seed_settings(text, seed), method=method,
                about={"scenario": name, "seed": seed, "twin": fingerprint(twin_of(text))})


def table(all_figures: list[dict], cache: pathlib.Path) -> list[str]:
    chosen = good(all_figures)
    twins = twin_ates(cache, figures_in)
    lines = [summary_head(), "|" + "---|" * 14]
    for key in sorted({(f["group"], f["method"]) for f in chosen}):
        lines.append(summary_row(f"{key[0]} | {key[1]}", [f for f in chosen if (f["group"], f["method"]) == key], twins))
    lines += ["", "| scenario, seed | method | maps / worlds | merges: true / false / missed | worst merge [m / deg] | "
              "end to end [m] | ATE of trajectory.tum, all scans [m] | placed scans | without events | odometry.tum | "
              "false closures | back end |", "|" + "---|" * 12]
    return lines + [row_of(f, twins) for f in chosen] + failures(all_figures)


def summary_head() -> str:
    return ("| set | method | runs | merges: true / false / missed | found | within 0.1 m and 0.3 deg | "
            "transform error, median [m / deg] | end to end within 0.05 m | placed ATE within 1.2 times that without "
            "events | ATE, median [m] | of odometry.tum | worse than odometry.tum | detection / initialisation / fusion, of all work [%] | of the recordings' time [%] |")


def counts(chosen: list[dict]) -> tuple[int, int, int]:
    merges = [m for f in chosen for m in f["merges"]]
    return (sum(not m["false"] for m in merges), sum(m["false"] for m in merges), sum(len(f["missed"]) for f in chosen))


def summary_row(head: str, chosen: list[dict], twins: dict) -> str:
    true, false, missed = counts(chosen)
    merges = [m for f in chosen for m in f["merges"] if m["metres"] is not None and not m["false"]]
    errors = f"{median([m['metres'] for m in merges]):.3f} / {median([m['degrees'] for m in merges]):.3f}" if merges else ""
    with_twin = [(f, twins[key_of(f)]) for f in chosen if key_of(f) in twins]
    good_as_twin = sum(f["ate_m"]["placed"] <= TWIN * twin for f, twin in with_twin)
    return (f"| {head} | {len(chosen)} | {true} / {false} / {missed} | {percent(true, true + missed)} | "
            f"{percent(sum(map(is_close, merges)), len(merges))} | {errors} | "
            f"{percent(sum(f['end_m'] <= END for f in chosen), len(chosen))} | {percent(good_as_twin, len(with_twin))} | "
            f"{metres(median([f['ate_m']['trajectory'] for f in chosen]))} | "
            f"{metres(median([f['ate_m']['odometry'] for f in chosen]))} | {sum(map(is_worse, chosen))} | {work_shares(chosen)} |")


def key_of(f: dict) -> tuple[str, int]:
    return f["about"]["twin"], f["about"]["seed"]


def row_of(f: dict, twins: dict) -> str:
    true, false, missed = counts([f])
    errors, twin = f["ate_m"], twins.get(key_of(f))
    return (f"| `{f['about']['scenario']}`, {f['about']['seed']} | {f['method']} | {f['maps']} / {f['worlds']} | "
            f"{true} / {false} / {missed} | {worst_merge(f)} | {metres(f['end_m'])} | {metres(errors['trajectory'])} | "
            f"{metres(errors['placed'])} | {'' if twin is None else metres(twin)} | {metres(errors['odometry'])} | "
            f"{len(f['false_closures'])} | {back_end_share(f)} |")


SECTION = Section(items, measure, line, table)
