#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that every include is one that the table of layers, src/mmlins/CMakeLists.txt, allows.

All layers share one include root, so that the compiler alone would not notice. Also refused: layers
that depend on each other in a circle, third-party headers outside the folder that wraps them,
relative includes, and absolute paths of somebody's machine. Exits with 1 if anything was found.
"""

import argparse
import re
import sys
from pathlib import Path

# Third-party headers and the only folders that may see them; whatever is not listed is free.
WRAPPED = {
    "tbb": ["src/mmlins/base"],
    "yaml-cpp": ["src/mmlins/config"],
    "ceres": ["src/mmlins/graph"],
    "sqlite3.h": ["src/mmlins/atlas"],
    "zlib.h": ["src/mmlins/atlas"],
    "rosbag": ["src/mmlins/io"],
    "ros": ["src/mmlins/io"],
    "nlohmann": ["src/mmlins/pipeline", "src/mmlins/report", "src/mmlins/view", "apps"],
    "boost": ["src/mmlins/view"],
    "png.h": ["src/mmlins/report"],
    "CLI": ["apps"],
}
CODE = {".hpp", ".cpp", ".h", ".cc"}
TEXT = CODE | {".py", ".md", ".txt", ".cmake", ".yaml", ".json", ".sh", ""}
FOLDERS = ["src", "apps", "tests", "benchmarks", "tools", "scripts", "cmake", "docs", "config", "web", ".ci"]
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
MACHINE_PATH = re.compile(r"(?<![\w.~})])/(?:home|root|work|Users)/\w")


def read_layers(root):
    """The table: {layer: [layers it may include]}, and what is wrong with it."""
    table = root / "src/mmlins/CMakeLists.txt"
    layers, findings = {}, []
    for number, line in enumerate(table.read_text().splitlines(), 1):
        match = re.match(r"\s*add_layer\((\w+)([^)]*)\)", line)
        if not match:
            continue
        name, arguments = match.groups()
        deps = re.search(r"\bDEPS\b(.*?)(?:\b(?:PRIVATE_)?PACKAGES\b|$)", arguments)
        deps = deps.group(1).split() if deps else []
        for dep in deps:
            # Only layers above in the table can be named, so that there can be no circle.
            if dep not in layers:
                findings.append(f"{table}:{number}: layer {name} depends on {dep}, which is not declared above it")
        layers[name] = deps
    return layers, findings


def code_files(root, folder):
    return sorted(f for f in (root / folder).rglob("*") if f.suffix in CODE and f.is_file())


def includes_of(file):
    for number, line in enumerate(file.read_text(errors="replace").splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(1)


def check_layer_includes(root, layers):
    base = root / "src/mmlins"
    for file in code_files(root, "src/mmlins"):
        layer = file.relative_to(base).parts[0]
        if layer not in layers:
            yield f"{file}:1: folder {layer} is not in the table of layers"
            continue
        for number, path in includes_of(file):
            parts = path.split("/")
            if path.startswith("."):
                yield f"{file}:{number}: relative include {path}; write \"mmlins/...\""
            elif parts[0] == "mmlins" and parts[1] not in layers:
                yield f"{file}:{number}: {path} is in no layer of the table"
            elif parts[0] == "mmlins" and parts[1] != layer and parts[1] not in layers[layer]:
                yield f"{file}:{number}: layer {layer} may not include {path}; allowed: {' '.join(layers[layer])}"


def check_third_party(root):
    for file in code_files(root, "src") + code_files(root, "apps"):
        place = file.relative_to(root).as_posix()
        for number, path in includes_of(file):
            homes = WRAPPED.get(path.split("/")[0])
            if homes and not any(place.startswith(home + "/") for home in homes):
                yield f"{file}:{number}: {path} belongs into {' or '.join(homes)} only"


def check_machine_paths(root):
    files = [f for folder in FOLDERS for f in (root / folder).rglob("*")] + list(root.glob("*"))
    for file in sorted(f for f in files if f.is_file() and f.suffix in TEXT and f.name != "LICENSE"):
        for number, line in enumerate(file.read_text(errors="replace").splitlines(), 1):
            if MACHINE_PATH.search(line):
                yield f"{file}:{number}: absolute path of one machine"


def check(root):
    layers, findings = read_layers(root)
    if not layers:
        findings.append(f"{root / 'src/mmlins/CMakeLists.txt'}:1: no add_layer(...) found")
    return [*findings, *check_layer_includes(root, layers), *check_third_party(root), *check_machine_paths(root)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parent.parent, help="the repository")
    findings = check(parser.parse_args().root)
    print("\n".join(findings) if findings else "layers: clean")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
