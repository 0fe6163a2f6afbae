#!/usr/bin/env python3
"""Checks that the parts of the source stay small: files of 400 lines, half of them below 90, functions of 60, classes of
12 data members and 20 public functions.

    tools/check_limits.py

A file may be longer whose first comment calls it a table. A class may have more where the comment in front of it says why,
with the word "members" or "functions".
"""
import argparse
import re
import sys
from pathlib import Path

FILE_LINES, MEDIAN_LINES, FUNCTION_LINES, MEMBERS, FUNCTIONS = 400, 90, 60, 12, 20
CLASS = re.compile(r"^(?:template\s*<.*>\s*)?(class|struct)\s+(?:\[\[\w+\]\]\s+)?(\w+)[^;()=]*$", re.DOTALL)
NO_MEMBER = re.compile(r"^(using|friend|typedef|static_assert|enum|static constexpr|inline static constexpr|static inline constexpr)\b")


def blank(text):
    """The text with comments, strings and characters overwritten by spaces, of the same length and lines."""
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^[ \t]*#[^\n]*', re.DOTALL | re.MULTILINE)
    return pattern.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)


def blocks(text, start, end):
    """Yields (head, begin of the head, opening brace, closing brace) of what stands at one level, and (statement, begin,
    None, None) for what ends in a semicolon."""
    begin, depth, opened = start, 0, None
    for i in range(start, end):
        c = text[i]
        if c in "([{":
            if depth == 0 and c == "{":
                opened = i
            depth += 1
        elif c in ")]}":
            depth -= 1
            if depth == 0 and c == "}" and not initialises(text[begin:opened], text[i + 1:end]):
                yield text[begin:opened], begin, opened, i
                begin = i + 1
        elif c == ";" and depth == 0:
            yield text[begin:i], begin, None, None
            begin = i + 1


def initialises(head, rest):
    """Whether braces after this head hold values, or the first members that a constructor sets."""
    word = rest.lstrip()[:1]
    return word in (";", ",", "{") and not re.match(r"\s*(?:\w+:\s*)*(?:template\s*<.*>\s*)?(class|struct|enum|union)\b", head, re.DOTALL) and (
        word != "{" or ")" in head and ":" in head)


def without_angles(text):
    """The text without what stands between matching angle brackets."""
    previous = None
    while previous != text:
        previous, text = text, re.sub(r"<[^<>]*>", "", text)
    return text


def count(text, opened, closed, public):
    """Data members and public functions of the class whose body lies between two braces."""
    members = functions = 0
    for head, begin, inner, _ in blocks(text, opened + 1, closed):
        for label in re.findall(r"\b(public|private|protected)\s*:(?!:)", head):
            public = label == "public"
        head = re.sub(r"\b(public|private|protected)\s*:(?!:)", "", head).strip()
        plain = re.sub(r"^template\s*", "", without_angles(head)).strip()
        if not plain or CLASS.match(plain) or NO_MEMBER.match(plain):
            continue
        if "(" in plain.split("=")[0].split("{")[0] or "operator" in plain:
            functions += public and not re.search(r"=\s*delete$", plain)
        else:
            members += 1 + re.sub(r"\{[^{}]*\}|\([^()]*\)|\[[^\[\]]*\]", "", plain).count(",")
    return members, functions


def walk(text, start, end, source, file, problems):
    """Judges the functions and classes between two places, those inside of namespaces and classes too."""
    for head, begin, opened, closed in blocks(text, start, end):
        if opened is None:
            continue
        first = begin + len(head) - len(head.lstrip())
        line = text.count("\n", 0, first) + 1
        name = " ".join(re.sub(r"\b(public|private|protected)\s*:(?!:)", "", head).split())
        if re.match(r"(inline )?namespace\b|extern\b", name):
            walk(text, opened + 1, closed, source, file, problems)
        elif match := CLASS.match(name):
            members, functions = count(text, opened, closed, match[1] == "struct")
            comment = " ".join(text for text in source[max(0, line - 30):line] if text.lstrip().startswith("//"))
            if members > MEMBERS and match[1] == "class" and "embers" not in comment:
                problems.append(f"{file}:{line}: {match[2]} has {members} data members, at most {MEMBERS}, and no comment says why")
            if functions > FUNCTIONS and "unctions" not in comment:
                problems.append(f"{file}:{line}: {match[2]} has {functions} public functions, at most {FUNCTIONS}, and no comment says why")
            walk(text, opened + 1, closed, source, file, problems)
        elif "(" in name:
            size = text.count("\n", first, closed) + 1
            if size > FUNCTION_LINES:
                problems.append(f"{file}:{line}: {size} lines, at most {FUNCTION_LINES}: {name[:80]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repository", nargs="?", default=Path(__file__).parents[1], help="default: the one of this file")
    root = Path(parser.parse_args().repository).resolve()
    problems, lengths = [], []
    for path in [file for top in ("include", "src") for file in sorted((root / top).rglob("*.[ch]pp"))]:
        file, text = path.relative_to(root), path.read_text(encoding="utf-8")
        source = text.splitlines()
        lengths.append(len(source))
        if len(source) > FILE_LINES and not re.search(r"^//+.*\btable", "\n".join(source[:40]), re.MULTILINE | re.IGNORECASE):
            problems.append(f"{file}:1: {len(source)} lines, at most {FILE_LINES}")
        plain = blank(text)
        walk(plain, 0, len(plain), source, file, problems)
    median = sorted(lengths)[len(lengths) // 2] if lengths else 0
    if median >= MEDIAN_LINES:
        problems.append(f"half of the files have {median} lines or more, wanted below {MEDIAN_LINES}: give large ones one idea each")
    print(*problems, sep="\n", end="\n" if problems else "")
    print(f"limits: {len(lengths)} files of {sum(lengths)} lines, half of them have {median} or less, "
          f"{len(problems)} problems")
    return 1 if problems or not lengths else 0


if __name__ == "__main__":
    sys.exit(main())
