# labels: run
# timeout: 180
"""R6: damaged meshes and option files end in one clear line within 5 s: no signal, no traceback, no internal error; what
cannot be computed (a coordinate that is no number, a flat or inverted cell, a missing group, cells of a higher order) is
never accepted. `reliability_mutations_long` takes 1000 of each kind."""
import os
import random
import re
import time

from _reliability import BOTH, command, crashed, finish_within, log_of, long, start, with_mesh
from _runs import check, finish, require

WANTED = int(os.environ.get("IMPACT_COUNT", 1000 if long() else 40))
seed = int(os.environ.get("IMPACT_SEED", random.randrange(10**6)))
random.seed(seed)
print(f"     IMPACT_SEED={seed}")

SIDES = ("lower", "upper")
SMALL = {**with_mesh(BOTH), "dry_run": "on"}
with open(SMALL["mesh"]) as file:
    good_mesh = file.read()
words = command("x", {k: v for k, v in SMALL.items() if k not in ("mesh", "dry_run")})[1:-2]
good_options = "# a run\n" + "".join(
    f"{words[i]} " + (f'"{words[i + 1]}"' if re.search(r"[ (),]", words[i + 1]) else words[i + 1]) + "\n"
    for i in range(0, len(words), 2))


def sections(text):
    return {name: (text.index("$" + name), text.index("$End" + name)) for name in
            re.findall(r"^\$(?!End)(\w+)", text, re.M)}


def lines_of(text, section):
    a, b = sections(text)[section]
    return text[:a], text[a:b].splitlines(), text[b:]


def join(before, lines, after):
    return before + "\n".join(lines) + "\n" + after


def one_coordinate(text, value):
    before, lines, after = lines_of(text, "Nodes")
    # Lines of three numbers with a point somewhere are coordinates.
    places = [i for i, line in enumerate(lines) if len(line.split()) == 3 and i > 2]
    i = random.choice(places)
    parts = lines[i].split()
    parts[random.randrange(2)] = value
    lines[i] = " ".join(parts)
    return join(before, lines, after)


def element_lines(lines, nodes):
    return [i for i, line in enumerate(lines) if len(line.split()) == nodes + 1 and i > 1]


def bad_cell(text, kind):
    before, lines, after = lines_of(text, "Elements")
    blocks, i = [], 2
    while i < len(lines):
        dim, _, shape, count = map(int, lines[i].split())
        blocks.append((i, dim, shape, count))
        i += count + 1
    head, _, shape, count = random.choice([b for b in blocks if b[1] == 2])
    i = head + 1 + random.randrange(count)
    parts = lines[i].split()
    if kind == "flat":
        parts[2] = parts[1]
    elif kind == "twisted":  # a quadrilateral whose edges cross
        parts[2], parts[3] = parts[3], parts[2]
    elif kind == "order":
        lines[head] = " ".join(lines[head].split()[:2] + ["10" if len(parts) == 5 else "9", str(count)])
        lines[head + 1:head + 1 + count] = [line + " " + " ".join(line.split()[1:])
                                            for line in lines[head + 1:head + 1 + count]]
        return join(before, lines, after)
    elif kind == "foreign":
        parts[1] = "999999999"
    lines[i] = " ".join(parts)
    return join(before, lines, after)


def group_away(text):
    before, lines, after = lines_of(text, "PhysicalNames")
    used = [i for i in range(2, len(lines)) if lines[i].split('"')[1] in SMALL.values() or lines[i].split('"')[1] in SIDES]
    i = random.choice(used)
    lines[i] = re.sub(r'"(\w+)"', r'"\1_gone"', lines[i])
    return join(before, lines, after)


def repeated_node(text):
    before, lines, after = lines_of(text, "Nodes")
    tags = [i for i, line in enumerate(lines) if len(line.split()) == 1 and i > 2]
    i, j = random.sample(tags, 2)
    lines[i] = lines[j]
    return join(before, lines, after)


def any_bytes(text):
    data = bytearray(text, "latin-1")
    for _ in range(random.randint(1, 5)):
        data[random.randrange(len(data))] = random.choice(b"0123456789-+.eE\"$ \n\0\xff,x")
    return data.decode("latin-1")


def any_number(text):
    places = list(re.finditer(r"-?\d+\.?\d*(e-?\d+)?", text))
    place = random.choice(places)
    value = random.choice(["nan", "inf", "-1", "0", "1e308", "9223372036854775808", "-2147483649", "4294967297", "1e999",
                           "", "x"])
    return text[:place.start()] + value + text[place.end():]


def any_line(text):
    lines = text.split("\n")
    i = random.randrange(len(lines))
    kind = random.randrange(4)
    if kind == 0:
        del lines[i]
    elif kind == 1:
        lines.insert(i, lines[i])
    elif kind == 2:
        j = random.randrange(len(lines))
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines[i] = lines[i][:random.randrange(len(lines[i]) + 1)]
    return "\n".join(lines)


def cut(text):
    return text[:random.randrange(len(text))]


REFUSED = {  # damages that must never be accepted
    "coordinate nan": lambda t: one_coordinate(t, "nan"), "coordinate inf": lambda t: one_coordinate(t, "inf"),
    "flat cell": lambda t: bad_cell(t, "flat"), "twisted cell": lambda t: bad_cell(t, "twisted"),
    "cells of order 2": lambda t: bad_cell(t, "order"), "unknown node": lambda t: bad_cell(t, "foreign"),
    "group missing": group_away, "repeated node tag": repeated_node,
}
MESH = {**REFUSED, "bytes": any_bytes, "number": any_number, "line": any_line, "cut": cut}


def quotes(text):
    places = [m.start() for m in re.finditer('"', text)]
    i = random.choice(places)
    return text[:i] + random.choice(["", "'", '""', '" "']) + text[i + 1:]


def letters(text):
    places = [m for m in re.finditer(r"^-(\w+)", text, re.M)]
    place = random.choice(places)
    i = random.randrange(place.start() + 1, place.end())
    return text[:i] + random.choice(["", "x", "_", text[i] * 2]) + text[i + 1:]


def long_value(text):
    place = random.choice(list(re.finditer(r"^-\w+ ", text, re.M)))
    return text[:place.end()] + random.choice("(19a\"-") * random.choice([100, 5000, 100000]) + text[place.end():]


def doubled(text):
    place = random.choice(list(re.finditer(r"^-(?!material_\w+_like)(\w+) (.*)$", text, re.M)))
    return text + f"{place.group(0)}\n"


OPTIONS = {"bytes": any_bytes, "number": any_number, "line": any_line, "cut": cut, "quotes": quotes, "letters": letters,
           "a long value": long_value}


def campaign(kind, damages, write):
    codes, faults, slowest, late = {}, [], 0.0, 0
    accepted = []
    for i in range(WANTED):
        name = list(damages)[i % len(damages)]
        options = write(damages[name])
        begun = time.monotonic()
        code = finish_within(start("hurt", options), 10)
        seconds = time.monotonic() - begun
        slowest = max(slowest, seconds)
        if code is None:
            # A process can also wait for a busy machine or in the start of MPI: a hang of ours comes again.
            late += 1
            code = finish_within(start("hurt", options), 10)
        log = log_of("hurt")
        said = [line for line in log.splitlines() if line.startswith("impact: ")]
        why = ""
        if code is None:
            why = "no end within 10 s"
        elif crashed(code):
            why = f"signal, status {code}"
        elif code not in (0, 2, 3, 4):
            why = f"status {code}: {said[-1:] or log[-200:]}"
        elif code != 0 and (not said or "PETSC ERROR" in log):
            why = f"no clear message: {log[-300:]!r}"
        if why:
            faults.append(f"{kind}, {name}: {why}")
            os.replace(hurt_file[kind], f"fault_{len(faults)}_{os.path.basename(hurt_file[kind])}")
        elif code == 0 and damages is MESH and name in REFUSED:
            accepted.append(name)
            os.replace(hurt_file[kind], f"accepted_{len(accepted)}_{os.path.basename(hurt_file[kind])}")
        codes[code] = codes.get(code, 0) + 1
    print(f"     {WANTED} damaged {kind}: exit statuses {dict(sorted(codes.items(), key=str))}, "
          f"slowest {slowest:.2f} s; {late} had to be started twice")
    for line in faults[:20]:
        print("     " + line)
    check(f"{kind}: signals, hangs, internal errors, unclear messages", len(faults), 0, 0, relative=False)
    require(f"{kind}: nothing impossible was accepted {sorted(set(accepted))}", not accepted)
    require(f"{kind}: most are refused, some harmless ones are not", codes.get(0, 0) < WANTED * 0.7)


hurt_file = {"meshes": os.path.abspath("hurt.msh"), "option files": os.path.abspath("hurt.opts")}


def write_mesh(damage):
    with open(hurt_file["meshes"], "w", encoding="latin-1", newline="") as file:
        file.write(damage(good_mesh))
    return {**SMALL, "mesh": hurt_file["meshes"]}


def write_options(damage):
    with open(hurt_file["option files"], "w", encoding="latin-1", newline="") as file:
        file.write(damage(good_options))
    return {"options_file": hurt_file["option files"], "mesh": SMALL["mesh"], "dry_run": "on"}


for what, options in (("mesh", SMALL), ("option file", write_options(lambda text: text))):
    require(f"the undamaged {what} is accepted", finish_within(start("undamaged", options), 20) == 0)
campaign("meshes", MESH, write_mesh)
campaign("option files", OPTIONS, write_options)
finish()
