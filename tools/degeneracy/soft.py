# SPDX-License-Identifier: MIT
"""Places with a weak direction, with and without the soft treatment of it."""
import pathlib

from degeneracy import free
from degeneracy.bench import Item, Section, Wanted
from measure_scenarios import metres

SCENES = ("tunnel", "corridor", "field")
METHODS = ("default", "softened")


def items(wanted: Wanted) -> list[Item]:
    drives = [drive for drive in free.drives(wanted.seeds) if drive.about["scene"] in SCENES]
    return [drive._replace(name=f"{drive.name}-{method}", method=method) for drive in drives for method in METHODS]


def table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    lines = ["| drive | path | scans with a weak direction | ATE without [m] | ATE with [m] | maps without, with |",
             "|---|---|---|---|---|---|"]
    good = {f["name"]: f for f in all_figures if "failed" not in f}
    for name, without in good.items():
        softened = good.get(name.removesuffix("-default") + "-softened")
        if without["method"] == "default" and softened:
            lines.append(f"| `{name.removesuffix('-default')}` | {without['path_m']:.0f} m | "
                         f"{without['states']['DEGRADED']} of {sum(without['states'].values())} | "
                         f"{metres(without['ate_m'])} | {metres(softened['ate_m'])} | "
                         f"{without['maps']}, {softened['maps']} |")
    return lines


SECTION = Section(items, free.measure, free.line, table)
