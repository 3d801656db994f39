# SPDX-License-Identifier: MIT
"""Parts of the back end alone: recognition on simulated revisits (bench_place) and pose graphs (bench_graph)."""
import json
import pathlib
import re

from degeneracy.bench import Bench, Failed, Item, Section, Wanted, call
from mapping_measures.common import failures, good

SCENES = ["campus", "urban", "hall"]
SENSORS = [("vlp16", "vlp16"), ("hdl32e", "hdl32e"), ("os1_64", "os1_64"), ("mid360", "mid360"), ("vlp16", "mid360")]
OFFSETS = [0, 5, 10]
PARTS = ["Describe", "Query", "CompareScanContexts", "Prepare", "Register", "SearchAround", "Verify"]
GRAPHS = ["optimize_laps/3000", "optimize_laps/10000", "optimize_with_false_loops/3000/1",
          "optimize_with_false_loops/3000/30", "covariance/3000", "covariance/10000"]
FILE_LINE = re.compile(r"(\d+) nodes, (\d+) edges, chi2 (\S+) -> (\S+) \((\d+) rejected\), (\d+) iterations, (\S+) s, (.*)")


def results_of(bench: Bench, method: str, pattern: str) -> list[dict]:
    said = call(bench.program_of(method), f"--benchmark_filter={pattern}", "--benchmark_format=json")
    return json.JSONDecoder().raw_decode(said[said.index("{"):])[0]["benchmarks"]


# ---- recognition


def recognition_items(wanted: Wanted) -> list[Item]:
    recalls = [f"Recall/{scene}/{old}/{new}/{way}/{offset}m" for scene in SCENES for old, new in SENSORS
               for way in ("same", "opposite") for offset in OFFSETS]
    return [bench_item(name, "bench_place") for name in [*(f"BM_{part}" for part in PARTS), *recalls]]


def bench_item(name: str, method: str) -> Item:
    return Item(name.replace("/", "-"), "benchmark", "", (), (), method, {"benchmark": name})


def measure_place(bench: Bench, item: Item) -> dict:
    name = item.about["benchmark"]
    return {"results": [{key: value for key, value in result.items() if key in
                         ("name", "real_time", "time_unit", "recall", "scan_context", "queries", "places")}
                        for result in results_of(bench, item.method, f"^{name}" + ("(/|$)" if name.startswith("BM_") else "/"))]}


def place_line(figures: dict) -> str:
    return ", ".join(f"{r['name']} " + (f"recall {r['recall']:.2f}, Scan Context {r['scan_context']:.2f}, {r['queries']:.0f} "
                                        "queries" if "recall" in r else f"{r['real_time']:.3g} {r['time_unit']}")
                     for r in figures["results"])


def place_table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    results = {r["name"]: r for f in good(all_figures) for r in f["results"]}
    head = [f"{way}, {offset} m" for way in ("same", "opposite") for offset in OFFSETS]
    lines = ["| place | first drive | second | queries | " + " | ".join(head) + " |", "|" + "---|" * (4 + len(head))]
    for scene in SCENES:
        for old, new in SENSORS:
            cells = [recall_of(results, scene, old, new, way, offset) for way in ("same", "opposite") for offset in OFFSETS]
            if any(cells):
                queries = sum(cell["queries"] for cell in cells if cell)
                lines.append(f"| {scene} | {old} | {new} | {queries:.0f} | " + " | ".join(map(recall_words, cells)) + " |")
    lines += ["", "| part | time of one, in one thread |", "|---|---|"]
    lines += [f"| {name.removeprefix('BM_')} | {r['real_time']:.3g} {r['time_unit']} |" for name, r in sorted(results.items())
              if name.startswith("BM_")]
    return lines + failures(all_figures)


def recall_of(results: dict, scene: str, old: str, new: str, way: str, offset: int) -> dict | None:
    wanted = f"Recall/{scene}/{old}/{new}/{way}/{offset}m"
    return next((r for name, r in results.items() if name == wanted or name.startswith(wanted + "/")), None)


def recall_words(result: dict | None) -> str:
    return "" if not result or not result["queries"] else f"{100 * result['recall']:.0f} % ({100 * result['scan_context']:.0f} %)"


# ---- graphs


def graph_items(wanted: Wanted) -> list[Item]:
    files = [Item(pathlib.Path(path).stem, "benchmark", path, (), (), "bench_graph", {"file": pathlib.Path(path).name})
             for path in wanted.recordings if path.endswith(".g2o")]
    return [*(bench_item(name, "bench_graph") for name in GRAPHS), *files]


def measure_graph(bench: Bench, item: Item) -> dict:
    if "file" in item.about:
        said = call(bench.program_of(item.method), item.scenario)
        found = FILE_LINE.search(said)
        if not found:
            raise Failed(f"bench_graph says nothing of {item.about['file']}")
        numbers = [float(word) for word in found.groups()[:7]]
        return dict(zip(("nodes", "edges", "chi2_first", "chi2_last", "rejected", "iterations", "seconds"), numbers)) | {
            "verdict": found[8]}
    result = results_of(bench, item.method, f"^{item.about['benchmark']}$")[0]
    per_second = {"ns": 1e9, "us": 1e6, "ms": 1e3, "s": 1.0}[result["time_unit"]]
    # Where the graph is not optimised, `iterations` are those of the benchmark.
    keys = ("edges", "chi2_first", "chi2_last", "rejected", "iterations") if "edges" in result else ()
    return {key: result[key] for key in keys} | {"seconds": result["real_time"] / per_second}


def graph_line(figures: dict) -> str:
    words = ", ".join(f"{key} {figures[key]:.6g}" for key in ("nodes", "edges", "chi2_first", "chi2_last", "rejected", "iterations")
                      if key in figures)
    return f"{words}, {figures['seconds']:.3f} s"


def graph_table(all_figures: list[dict], _: pathlib.Path) -> list[str]:
    lines = ["| graph | edges | chi², first | last | rejected edges | iterations | seconds |", "|---|---|---|---|---|---|---|"]
    for f in good(all_figures):
        name = f["about"].get("file") or f["about"]["benchmark"]
        cells = [f"{f[key]:.6g}" if key in f else "" for key in ("edges", "chi2_first", "chi2_last", "rejected", "iterations")]
        lines.append(f"| `{name}` | " + " | ".join(cells) + f" | {f['seconds']:.2f} |")
    return lines + failures(all_figures)


RECOGNITION = Section(recognition_items, measure_place, place_line, place_table)
GRAPH = Section(graph_items, measure_graph, graph_line, graph_table)
