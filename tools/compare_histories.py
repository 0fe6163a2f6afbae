#!/usr/bin/env python3
"""Compare two history files column by column.

The difference of a column is its largest difference in any row, relative to the column's largest magnitude in
either file. Exit status: 0 all within --rtol, 1 some column differs, 2 the files cannot be compared.
"""
import argparse
import fnmatch
import math
import sys

import histories


def stop(message):
    print(f"compare_histories.py: {message}", file=sys.stderr)
    sys.exit(2)


def read(path):
    """Columns by name, each a list of numbers."""
    try:
        columns, _ = histories.read(path)
    except (OSError, ValueError) as error:
        stop(f"cannot read {path}: {error}" if isinstance(error, (OSError, UnicodeDecodeError)) else error)
    if not next(iter(columns.values())):
        stop(f"{path} has no rows")
    return columns


def difference(a, b):
    """Largest difference relative to the largest magnitude, and its row; infinite when nan meets a number."""
    scale = max((abs(x) for x in a + b if math.isfinite(x)), default=0.0)
    worst, where = 0.0, 0
    for row, (x, y) in enumerate(zip(a, b)):
        if x == y or (math.isnan(x) and math.isnan(y)):
            continue
        d = abs(x - y) / scale if math.isfinite(x) and math.isfinite(y) else math.inf
        if d > worst:
            worst, where = d, row
    return worst, where


def chosen(names, columns, exclude):
    def matches(name, patterns):
        return any(fnmatch.fnmatchcase(name, p) for p in patterns)

    for pattern in columns:
        if not any(fnmatch.fnmatchcase(n, pattern) for n in names):
            stop(f"no column matches {pattern}; there are: {', '.join(names)}")
    return [n for n in names if (not columns or matches(n, columns)) and not matches(n, exclude)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("a")
    parser.add_argument("b")
    parser.add_argument("--rtol", type=float, default=1e-12, help="largest allowed difference (default %(default)g)")
    parser.add_argument("--columns", default="", help="comma list of names or patterns (default: all)")
    parser.add_argument("--exclude", default="", help="comma list of names or patterns, e.g. 'newton,balance*'")
    parser.add_argument("--quiet", action="store_true", help="print only what differs")
    options = parser.parse_args()

    a, b = read(options.a), read(options.b)
    split = lambda text: [p.strip() for p in text.split(",") if p.strip()]
    names = chosen(list(dict.fromkeys([*a, *b])), split(options.columns), split(options.exclude))
    if not names:
        stop("no column is left to compare")
    bad = False
    for name in names:
        if name not in a or name not in b:
            print(f"{name}: only in {options.a if name in a else options.b}")
            bad = True
            continue
        if len(a[name]) != len(b[name]):
            print(f"{options.a} has {len(a[name])} rows, {options.b} has {len(b[name])}")
            return 1
        worst, row = difference(a[name], b[name])
        within = worst <= options.rtol
        bad = bad or not within
        if not within:
            print(f"{name}: {worst:.3e} in row {row} ({a[name][row]:.17g}, {b[name][row]:.17g})")
        elif not options.quiet:
            print(f"{name}: {worst:.3e}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
