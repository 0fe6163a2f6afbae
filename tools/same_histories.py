#!/usr/bin/python3
"""Whether two builds compute the same: runs every file of options/ with both on one rank and compares their
history.csv, number by number. A change of structure must leave every bit; where an order of summation had to
change, the largest difference of each column over its largest value is printed.

    tools/same_histories.py old/impact build/release/impact --steps 20
    tools/same_histories.py old/impact build/release/impact beam_wedge cook
"""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

import histories

OPTIONS = pathlib.Path(__file__).resolve().parent.parent / "options"


def history(program, name, steps, folder):
    command = [program, "-options_file", OPTIONS / f"{name}.opts", "-output_dir", folder, "-outputs", "none", "-checkpoint_wall", "0"]
    if steps:
        command += ["-ts_max_steps", str(steps)]
    run = subprocess.run([str(word) for word in command], cwd=OPTIONS.parent, capture_output=True, text=True)
    path = folder / "history.csv"
    return run.returncode, histories.read(path)[0] if path.exists() else {}


def differences(old, new):
    """[(column, largest difference over the column's largest value)] of what is not the same number."""
    if list(old) != list(new) or any(len(old[column]) != len(new[column]) for column in old):
        return [("rows or columns", float("inf"))]
    found = []
    for column in old:
        pairs = [(a, b) for a, b in zip(old[column], new[column]) if a != b and not (math.isnan(a) and math.isnan(b))]
        if pairs:
            found.append((column, max(abs(a - b) for a, b in pairs) / max(map(abs, old[column] + new[column]))))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("names", nargs="*", help="files of options/ without .opts (all)")
    parser.add_argument("--steps", type=int, default=0, help="steps of each run at most (all)")
    asked = parser.parse_intermixed_args()
    names = asked.names or sorted(path.stem for path in OPTIONS.glob("*.opts"))
    changed = 0
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            old, new = (history(pathlib.Path(program).resolve(), name, asked.steps, folder / which)
                        for which, program in (("old", asked.old), ("new", asked.new)))
        found = differences(old[1], new[1])
        if old[0] != new[0]:
            found.insert(0, (f"exit status {old[0]} -> {new[0]}", float("inf")))
        changed += bool(found)
        print(f"{name}: {len(new[1].get('time', ()))} rows, " + ("the same" if not found else "; ".join(f"{c} {d:.1e}" for c, d in found)), flush=True)
    sys.exit(1 if changed else 0)


if __name__ == "__main__":
    main()
