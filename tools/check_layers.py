#!/usr/bin/env python3
"""Checks that includes follow the layers: arrows only downwards, and no PETSc or MPI in a dry layer; and that the files that
the pages name are there.

    tools/check_layers.py
"""
import argparse
import re
import sys
from pathlib import Path

BELOW = {
    "math": [],
    "material": ["math"],
    "element": ["math"],
    "kernel": ["material", "element"],
    "petsc": [],
    "time": ["petsc"],
    "input": ["petsc"],
    "mesh": ["kernel", "petsc"],
    "contact": ["mesh"],
    "problem": ["contact", "time", "input"],
    "io": ["mesh", "input"],
    "solve": ["problem"],
    "scenario": ["problem"],
    "balance": ["solve", "io"],
    "run": ["scenario", "balance"],
}
DRY = {"math", "material", "element", "kernel"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
PAGES = ("README.md", "src/README.md", "src/theory.md", "tests/README.md", "options/README.md")
NAMED = re.compile(r"\b(?:src|include|tests|tools|options|meshes)/[\w/]+\.(?:[ch]pp|py|md|opts|geo)\b")
STANDARD = re.compile(r"^(c?[a-z_]+|bits/[a-z_]+\.h)$")  # the C++ standard library's headers have no suffix


def reachable(layer):
    found = {layer}
    for lower in BELOW[layer]:
        found |= reachable(lower)
    return found


def layer_of(path):
    return next((part for part in path.parts[:-1] if part in BELOW), None)


def complaint(root, path, kind, name):
    """Says what is wrong with one include of one file, or returns None."""
    layer = layer_of(path.relative_to(root))
    if kind == '"':
        target = (path.parent / name).resolve()
        if not target.is_file():
            return f'"{name}" is not beside the file; write <impact/layer/room.hpp>'
        if not target.is_relative_to(root):
            return f'"{name}" lies outside the repository'
        target = target.relative_to(root)
        if target.parts[0] == "include":
            return f'write <{target.relative_to("include")}>'
        target_layer = layer_of(target)
    elif name.startswith("impact/"):
        if not (root / "include" / name).is_file():
            return f"<{name}> does not exist"
        target_layer = layer_of(Path(name))
    else:
        in_tests = path.relative_to(root).parts[0] == "tests"
        if layer in DRY and not STANDARD.match(name) and not (in_tests and name.startswith(("gtest/", "gmock/"))):
            return f"<{name}>: the layer {layer} is dry and sees only the C++ standard library"
        return None
    if layer and target_layer and target_layer not in reachable(layer):
        return f"<{name}>: the layer {layer} must not see the layer {target_layer}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repository", nargs="?", default=Path(__file__).parents[1], help="default: the one of this file")
    root = Path(parser.parse_args().repository).resolve()
    files = [file for top in ("include", "src", "tests") for file in sorted((root / top).rglob("*.[ch]pp"))]
    strangers = sorted(
        str(file.relative_to(root)) for file in files
        if file.relative_to(root).parts[0] != "tests" and not layer_of(file.relative_to(root))
        and file.parent != root / "src")  # the program itself may use everything
    problems = [f"{name}: belongs to no layer" for name in strangers]
    includes = 0
    for file in files:
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            if match := INCLUDE.match(line):
                includes += 1
                if message := complaint(root, file, *match.groups()):
                    problems.append(f"{file.relative_to(root)}:{number}: {message}")
    for page in PAGES:
        for number, line in enumerate((root / page).read_text(encoding="utf-8").splitlines(), 1):
            problems += [f"{page}:{number}: {name} does not exist" for name in NAMED.findall(line) if not (root / name).is_file()]
    print(*problems, sep="\n", end="\n" if problems else "")
    print(f"layers: {len(files)} files, {includes} includes, {len(problems)} problems")
    return 1 if problems or not files else 0


if __name__ == "__main__":
    sys.exit(main())
