#!/usr/bin/env python3
"""Compare two history files column by column.

    tools/compare_histories.py one/history.csv other/history.csv --rtol 1e-9 --exclude 'newton*,linear,*_its' --quiet

The difference of a column is its largest one in any row, relative to the largest magnitude of what is of its kind in either
file: energies to energies, the components of a force to all forces; balances are relative already. Columns that are
rounding beside what they are made of are told as such and do not count. Exit status: 0 all within --rtol, 1 some column
differs, 2 the files cannot be compared.
"""
import argparse
import fnmatch
import sys

import histories
import numpy
from comparison import differences


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
    both = [name for name in a if name in b]
    rows = {len(columns[both[0]]) for columns in (a, b)} if both else {0}
    if len(rows) > 1:
        print(f"{options.a} has {len(a[both[0]])} rows, {options.b} has {len(b[both[0]])}")
        return 1
    bad = False
    for name in names:
        if name not in both:
            print(f"{name}: only in {options.a if name in a else options.b}")
            bad = True
    pair = [{name: numpy.array(columns[name]) for name in both} for columns in (a, b)]
    for name, worst, row in differences(*pair):
        if name not in names:
            continue
        if worst is not None and worst > options.rtol:
            print(f"{name}: {worst:.3e} in row {row} ({a[name][row]:.17g}, {b[name][row]:.17g})")
            bad = True
        elif not options.quiet:
            print(f"{name}: rounding" if worst is None else f"{name}: {worst:.3e}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
