#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks what keeps files readable: length of files and functions, licence line, #pragma once.

Exits with 1 if anything was found. Functions are found by counting braces, which is enough for
formatted code.
"""

import argparse
import re
import sys
from pathlib import Path

MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
FOLDERS = ["src", "apps", "tests", "benchmarks", "tools"]
LICENCE = "SPDX-License-Identifier: MIT"

# Comments, raw strings, strings and characters: braces in them do not count.
NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
SCOPE = re.compile(r"\b(namespace|class|struct|enum|union|extern)\b")


def without_noise(text):
    return NOISE.sub(lambda m: " " + "\n" * m.group().count("\n"), text)


def opens_scope(head):
    """Whether what stands before a brace begins a namespace or type: functions may be inside."""
    previous = None
    while previous != head:  # template <class T> is no class
        previous, head = head, re.sub(r"<[^<>]*>", " ", head)
    return bool(SCOPE.search(head)) and "(" not in head.split("requires")[0]


def functions_in(text):
    """(first line, number of lines, name) of every function that is not inside another one."""
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda m: "\n" * m.group().count("\n"), without_noise(text),
                  flags=re.MULTILINE)
    kinds, starts, head_begin = [], [], 0
    for position, character in enumerate(text):
        if character == "{":
            head = text[head_begin:position]
            inside = "body" in kinds
            kind = "scope" if not inside and opens_scope(head) else "body"
            kinds.append(kind)
            starts.append((head_begin + len(head) - len(head.lstrip()), head.strip(), inside))
        elif character == "}" and kinds:
            kind, (begin, head, inside) = kinds.pop(), starts.pop()
            if kind == "body" and not inside and "(" in head:
                first = text.count("\n", 0, begin) + 1
                name = re.search(r"([\w:~]+)\s*\(", head)
                yield first, text.count("\n", 0, position) + 2 - first, name.group(1) if name else "?"
        if character in "{};" and "body" not in kinds:
            head_begin = position + 1


def check_file(file):
    text = file.read_text(errors="replace")
    lines = text.splitlines()
    if not any(LICENCE in line for line in lines[:3]):
        yield f"{file}:1: no line \"{LICENCE}\""
    if len(lines) > MAX_FILE_LINES:
        yield f"{file}:{MAX_FILE_LINES + 1}: {len(lines)} lines; at most {MAX_FILE_LINES}"
    if file.suffix == ".hpp" and "#pragma once" not in lines:
        yield f"{file}:1: no #pragma once"
    if file.suffix in {".hpp", ".cpp"}:
        for first, count, name in functions_in(text):
            if count > MAX_FUNCTION_LINES:
                yield f"{file}:{first}: {name} has {count} lines; at most {MAX_FUNCTION_LINES}"


def check(root):
    files = sorted(f for folder in FOLDERS for f in (root / folder).rglob("*") if f.suffix in {".hpp", ".cpp", ".py"})
    return [finding for file in files for finding in check_file(file)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parent.parent, help="the repository")
    findings = check(parser.parse_args().root)
    print("\n".join(findings) if findings else "sizes: clean")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
