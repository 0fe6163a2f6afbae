#!/usr/bin/env python3
"""Checks that every equation tag cited in the code stands in src/theory.md.

A citation is one or more tags at the end of a comment line: `// (60)`, `// push forward (49)-(53)`, `// (70')`.
An equation is there if the page shows its tag: `\\tag{60}`, `(60)`, or within a range `(49)-(53)`.
Tags that the page defines by \\tag and no code cites are listed, but are not an error.

    tools/check_equations.py
"""
import argparse
import re
import sys
from pathlib import Path

TAG = r"\((?:[A-Z]\.)?\d+[a-z]?'?\)"
CITATION = re.compile(rf"//.*?((?:{TAG}(?:\s*(?:,|-|–|and)\s*)?)+)[.;]?\s*$")
RANGE = re.compile(r"\((\d+)\)\s*[-–]\s*\((\d+)\)")


def tags(text):
    """All tags in a text; the inner ones of a range of plain numbers count."""
    found = {tag[1:-1] for tag in re.findall(TAG, text)}
    for first, last in RANGE.findall(text):
        found |= {str(number) for number in range(int(first), int(last) + 1)}
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repository", nargs="?", default=Path(__file__).parents[1], help="default: the one of this file")
    root = Path(parser.parse_args().repository).resolve()
    page = root / "src/theory.md"
    theory = page.read_text(encoding="utf-8") if page.is_file() else ""
    defined = set(re.findall(r"\\tag\{([^}]+)\}", theory))
    known = defined | tags(theory)
    cited, problems = set(), []
    for file in sorted(file for top in ("include", "src") for file in (root / top).rglob("*.[ch]pp")):
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            if match := CITATION.search(line):
                here = tags(match[1])
                cited |= here
                problems += [f"{file.relative_to(root)}:{number}: equation ({tag}) is not in src/theory.md"
                             for tag in sorted(here - known)]
    print(*problems, sep="\n", end="\n" if problems else "")
    if unused := sorted(defined - cited):
        print("defined, but cited by no code:", *(f"({tag})" for tag in unused))
    print(f"equations: {len(cited)} tags cited, {len(known)} in src/theory.md, {len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
