# labels: run
# timeout: 600
# long: 3600
"""R6: what a user may get wrong, made up by chance: damaged meshes and option files, misspelt and impossible options of ours
and of PETSc's, numbers far off. Each run ends within seconds in one clear line with the status that its family asks for: no
signal, no traceback, no internal error; what cannot be meant (a flat cell, a missing group, a name that nobody knows, a
value that PETSc refuses) is never accepted. 120 inputs; `reliability_mutations_long` takes 3000. IMPACT_SEED repeats a run,
IMPACT_FAMILY names one family."""
import os
import random
import re
import time

from _reliability import BOTH, FRACTURE, command, crashed, log_of, run_within, start, with_mesh
from _runs import ENVIRONMENT, check, finish, long, require

WANTED = int(os.environ.get("IMPACT_COUNT", 3000 if long() else 24))
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


def campaign(kind, part, damages, never, statuses, write, kept=None):
    """A share `part` of all inputs: `write` makes options of a damage; those in `never` must not be accepted; other statuses
    than 0 and `statuses` are faults. `kept`: the file that was damaged, set aside with a fault."""
    codes, faults, accepted, late, slowest, count = {}, [], [], 0, 0.0, round(part * WANTED)
    if os.environ.get("IMPACT_FAMILY", kind) != kind:
        return
    for i in range(count):
        name = list(damages)[i % len(damages)]
        options = write(damages[name])
        begun = time.monotonic()
        code = run_within(20, "hurt", options, env=ENVIRONMENT)  # without a daemon of Open MPI
        slowest = max(slowest, time.monotonic() - begun)
        if code is None:
            # A process can also wait for a busy machine or in the start of MPI: a hang of ours comes again.
            late += 1
            code = run_within(20, "hurt", options, env=ENVIRONMENT)  # without a daemon of Open MPI
        log = log_of("hurt")
        said = [line for line in log.splitlines() if line.startswith("impact: ")]
        why = ""
        if code is None:
            why = "no end within 20 s"
        elif crashed(code):
            why = f"signal, status {code}"
        elif code not in (0, *statuses):
            why = f"status {code}: {said[-1:] or log[-200:]}"
        elif code != 0 and (not said or "PETSC ERROR" in log):
            why = f"no clear message: {log[-300:]!r}"
        elif code == 0 and name in never:
            accepted.append(name)
            why = "accepted"
        if why:
            typed = "" if kept else " ".join(command("x", options)[1:-2])[-300:]
            faults.append(f"{kind}, {name}: {why}  {typed}")
            if kept:
                os.replace(kept, f"fault_{len(faults)}_{os.path.basename(kept)}")
        codes[code] = codes.get(code, 0) + 1
    print(f"     {count} {kind}: exit statuses {dict(sorted(codes.items(), key=str))}, slowest {slowest:.2f} s; "
          f"{late} had to be started twice")
    for line in faults[:20]:
        print("     " + line)
    check(f"{kind}: signals, hangs, internal errors, unclear messages", len(faults) - len(accepted), 0, 0, relative=False)
    require(f"{kind}: nothing impossible was accepted {sorted(set(accepted))}", not accepted)
    require(f"{kind}: most are refused, some harmless ones are not", codes.get(0, 0) < count * 0.7 + 3)


hurt_file = {"meshes": os.path.abspath("hurt.msh"), "option files": os.path.abspath("hurt.opts")}


def write_mesh(damage):
    with open(hurt_file["meshes"], "w", encoding="latin-1", newline="") as file:
        file.write(damage(good_mesh))
    return {**SMALL, "mesh": hurt_file["meshes"]}


def write_options(damage):
    with open(hurt_file["option files"], "w", encoding="latin-1", newline="") as file:
        file.write(damage(good_options))
    return {"options_file": hurt_file["option files"], "mesh": SMALL["mesh"], "dry_run": "on"}


def with_letter(name):
    """No name has this letter doubled."""
    i = random.randrange(2, len(name) + 1)
    return name[:i] + "qq" + name[i:]


def without_number():
    return random.choice(["abc", "nan", "1e999", "--1", "1,5", "1 kg.K", "0x1", "1e", "inf", "1 2"])


NUMBERS = ["ts_dt", "ts_max_time", "thickness", "mesh_scale", "energy_tol", "ts_adapt_dphi", "ts_newmark_rho", "ts_adapt_grow",
           "coupling_snes_atol", "crack_level", "material_solid_E", "material_solid_nu", "material_solid_Gc", "material_solid_gamma",
           "checkpoint_wall", "mesh_cells", "material_solid_residual_stiffness"]
CHOICES = ["ts_type", "units", "plane", "damage_form", "damage_bounds", "energy_action", "material_solid_model", "material_solid_damage",
           "material_solid_split", "bc_push_type", "output_vis_type", "motion_tangent", "motion_mat_type", "test_restep", "dry_run"]
RUN = {**with_mesh(FRACTURE), "ts_max_steps": 2}
TYPED = {
    "a name with letters too much": lambda: {with_letter(random.choice([k for k in RUN] + NUMBERS + CHOICES)): 1},
    "an id that is not declared": lambda: {random.choice(["material_qq_E", "bc_qq_uy", "output_qq_dt", "contact_qq_penalty"]): 1},
    "a number that is none": lambda: {random.choice(NUMBERS): without_number()},
    "a choice that is none": lambda: {random.choice(CHOICES): random.choice(["qq", "1.5", "newmarc", "on,off", "-x"])},
    "a group that is none": lambda: {random.choice(["bc_push_on", "bc_clamp_on", "material_solid_region"]): random.choice(["qq", "lefft", "left,qq"])},
    "an expression that is none": lambda: {"bc_push_ux": random.choice(["q*t", "0.1*(t", "sin()", "t t", "1//2", "x=1", "u", "0.1*t)"])},
    "a file that is none": lambda: {"mesh": random.choice(["qq.msh", ".", "/", "hurt.log", "qq.vtk"])},
    "name=value": lambda: {random.choice(NUMBERS) + "=0.5": ""},
}

SOLVERS = ["snes_rtol", "snes_max_it", "snes_type", "snes_linesearch_type", "ksp_type", "ksp_rtol", "ksp_max_it", "ksp_gmres_restart", "pc_type",
           "pc_factor_mat_solver_type", "pc_factor_levels", "pc_gamg_threshold", "mg_levels_ksp_type", "mg_levels_ksp_max_it", "sub_pc_type"]
KRYLOV = ["cg", "gmres", "fgmres", "bcgs", "minres", "preonly", "richardson", "chebyshev", "tfqmr", "lsqr", "fetidp", "tsirm", "qcg", "pgmres", "fcg"]
CONDITIONERS = ["none", "jacobi", "bjacobi", "sor", "lu", "ilu", "icc", "cholesky", "asm", "gamg", "hypre", "bddc", "shell", "composite", "mg",
                "redundant", "fieldsplit", "vpbjacobi", "nn", "patch", "svd", "kaczmarz", "telescope", "pfmg", "ksp", "eisenstat", "deflation"]
FIELDS = ["motion_", "damage_"]


def solver_type(value):
    name = random.choice([s for s in SOLVERS if s.endswith("_type") and "levels" not in s and "sub" not in s])
    return {"motion_ksp_type": "gmres", "motion_pc_type": "lu", "motion_" + name: value}


PETSC = {
    "a solver's name with letters too much": lambda: {random.choice(FIELDS) + with_letter(random.choice(SOLVERS)): 1},
    "no prefix": lambda: {random.choice([s for s in SOLVERS if not s.startswith(("mg_", "sub_"))]): 1},
    "a type that is none": lambda: solver_type(random.choice(["qq", "gmress", "1", "LU "])),
    "a solver's number that is none": lambda: {random.choice(FIELDS) + random.choice(["ksp_rtol", "snes_rtol", "ksp_max_it", "snes_max_it"]):
                                               random.choice(["abc", "1x", "ten", "1..2"])},
    "what no solver reads": lambda: {"motion_pc_type": "lu", "motion_" + random.choice(["mg_levels_", "sub_", "fieldsplit_0_", "qq_"]) +
                                     random.choice(["ksp_type", "pc_type", "ksp_rtol"]): random.choice(["gmres", "lu", "1e-3"])},
    "what would be displaced": lambda: {"motion_" + random.choice(["snes_fd", "snes_mf_operator", "snes_fd_color", "snes_lag_jacobian"]): 1},
    "any solver": lambda: {"motion_ksp_type": random.choice(KRYLOV), "motion_pc_type": random.choice(CONDITIONERS)},
    "any damage solver": lambda: {"damage_ksp_type": random.choice(KRYLOV), "damage_pc_type": random.choice(CONDITIONERS)},
    "any tolerance": lambda: {random.choice(FIELDS) + random.choice(["ksp_rtol", "ksp_max_it", "snes_rtol", "snes_atol", "snes_max_it"]):
                              random.choice([0, 1, 2, "1e-30", "1e30", 1e-3, 100])},
}


def far_off():
    return random.choice(["1e-300", "1e-30", "1e-12", "1e-3", "1", "1e3", "1e12", "1e30", "1e300"])


FAR = {
    "a number far off": lambda: {random.choice([n for n in NUMBERS if n != "mesh_scale"]): far_off()},
    "a load far off": lambda: {"bc_push_ux": random.choice([f"{far_off()}*t", f"(-{far_off()})*t", f"{far_off()}"])},
    "a load without a value": lambda: {"bc_push_ux": random.choice(["1/(t-0.05)", "log(t-0.05)", "sqrt(0.04-t)", "1/x", "t^(-1)", "0/0", "exp(1e4*t)"])},
    "two numbers far off": lambda: {random.choice(["material_solid_Gc", "material_solid_gamma"]): far_off(), "material_solid_E": far_off()},
    "inertia with numbers far off": lambda: {"ts_type": "newmark", "material_solid_rho": far_off(), "ts_dt": far_off(), "ts_max_time": far_off()},
}
ANY = {"any solver", "any damage solver", "any tolerance"}

for what, options in (("mesh", SMALL), ("option file", write_options(lambda text: text)), ("run", RUN)):
    require(f"the undamaged {what} is accepted", run_within(60, "undamaged", options) == 0)
# A family is one line; signals and restarts have scripts of their own.
campaign("meshes", 0.2, MESH, REFUSED, (2, 3, 4), write_mesh, hurt_file["meshes"])
campaign("option files", 0.2, OPTIONS, {}, (2, 3, 4), write_options, hurt_file["option files"])
campaign("options", 0.25, TYPED, set(TYPED), (2, 3, 4), lambda damage: {**RUN, "dry_run": "on", **damage()})
campaign("PETSc options", 0.25, PETSC, set(PETSC) - ANY, (2, 5), lambda damage: {**RUN, **damage()})
campaign("numerics", 0.1, FAR, {}, (2, 3, 5), lambda damage: {**RUN, **damage()})
finish()
