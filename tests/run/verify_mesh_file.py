"""A mesh that -mesh_convert wrote as HDF5 gives the run of the .msh or .geo that it came from: bitwise on one rank, within the
comparison of ranks on more; ASCII and binary .msh give the same bits; a file that cannot be used ends with one clear message."""
# labels: run
# timeout: 240
# long: 300
# processors: 1
import os
import shutil
import subprocess

from _histories import difference
from _runs import ENVIRONMENT, PROGRAM, TWO_BLOCKS, check, cores, finish, long, mesh, option_file, require, run

SHORT = {"ts_max_steps": 8, "outputs": "none"}
LU = {"motion_snes_rtol": 1e-12, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
      "motion_pc_factor_mat_solver_type": "mumps"}
BLOCKS = {**TWO_BLOCKS, **LU, **SHORT}


def rows(name):
    with open(os.path.join(name, "history.csv")) as file:
        return [line for line in file if not line.startswith("#")]


def bits(name):
    with open(name, "rb") as file:
        return file.read()


def convert(options, name, files=(), ranks=1):
    log = run("convert", {**options, "mesh_convert": name}, files=files, ranks=ranks).log
    require(f"{name}: what was written is said", "cells written" in log and f"-mesh {name} reads it" in log)


# Plane and in space, cells of two shapes, refined and scaled, a rigid obstacle whose body is a cell beside those of the file.
CASES = {
    "plane": (BLOCKS, []),
    "refined": ({**BLOCKS, "dm_refine": 1, "mesh_set_simplices_upper": 1, "mesh_scale": 0.5}, []),
    "space": ({**BLOCKS, "mesh_set_dim": 3, "mesh_set_n_lower": 2, "mesh_set_n_upper": 2, "dim": 3}, []),
    "ball": ({**LU, **SHORT}, [option_file("drop_ball.opts")]),
}
for case, (options, files) in CASES.items():
    convert(options, f"{case}.h5", files)
    stored = {key: value for key, value in options.items() if not key.startswith("mesh_set_")}
    stored["mesh"] = f"{case}.h5"
    whole = run(f"{case}_msh", options, files=files, refused=None)
    again = run(f"{case}_h5", stored, files=files, refused=None)
    require(f"{case}: the same bits on one rank", len(rows(f"{case}_msh")) > 3 and rows(f"{case}_msh") == rows(f"{case}_h5"))
    if case in ("plane", "ball") and not long():
        continue
    ranks = 3 if case == "space" else 2
    other = run(f"{case}_h5_{ranks}", stored, files=files, ranks=ranks, refused=None)
    worst, where = difference(whole.history, other.history)
    check(f"{case} on {ranks} ranks: largest difference, in {where}", worst, 0, 1e-8, relative=False)
convert(CASES["refined"][0], "three.h5", ranks=3)
require("three ranks write the same file as one", bits("three.h5") == bits("refined.h5"))
convert({"mesh": "refined.h5"}, "copy.h5", ranks=2)  # neither materials nor an end: there is no run yet
require("a copy is the same file", bits("copy.h5") == bits("refined.h5"))

# A restart on other ranks goes on with the mesh in its checkpoint, the stored file gone.
PLANE = {key: value for key, value in BLOCKS.items() if not key.startswith("mesh_set_")}
stored = {**PLANE, "mesh": os.path.abspath("once.h5"), "ts_max_steps": 3}
shutil.copy("plane.h5", "once.h5")
run("resumed", stored)
os.remove("once.h5")
resumed = run("resumed", {**stored, "restart": "auto", "ts_max_steps": 8}, ranks=2)
worst, where = difference(run("anew", {**PLANE, "mesh": "plane.h5"}).history, resumed.history)
check(f"resumed without the file: largest difference, in {where}", worst, 0, 1e-8, relative=False)

# The same numbers as text and as bytes.
subprocess.run(["gmsh", "-2", "-format", "msh41", "-setnumber", "angle", "10", "-o", "text.msh", mesh("two_blocks.geo")],
               check=True, stdout=subprocess.DEVNULL)
subprocess.run(["gmsh", "text.msh", "-bin", "-format", "msh41", "-save", "-o", "binary.msh"], check=True, stdout=subprocess.DEVNULL)
require("the one is text, the other is not", bits("text.msh")[:20].split()[2] == b"0" and bits("binary.msh")[:20].split()[2] == b"1")
for kind in ("text", "binary"):
    run(kind, {**PLANE, "mesh": f"{kind}.msh"})
    convert({"mesh": f"{kind}.msh"}, f"{kind}.h5")
require("text and bytes give the same bits", rows("text") == rows("binary") and bits("text.h5") == bits("binary.h5"))

# Nothing of these hangs, and every one says what, where and what to do.
good = bits("plane.h5")


def write(name, content):
    with open(name, "wb") as file:
        file.write(content)


def once(old, new):
    require(f"{old} stands once in the file", good.count(old) == 1)
    return good.replace(old, new)


write("short.h5", good[:-100])
write("empty.h5", b"")
write("text.h5", b"$MeshFormat\n4.1 0 8\n")
write("newer.h5", once(b"impact mesh 1\n", b"impact mesh 9\n"))
write("other.h5", once(b"impact mesh 1\n", b"a mesh of mine"))
write("without.h5", once(b"cells\0", b"cellz\0"))
write("groups.h5", once(b"\n1 0\n", b"\n1 9\n"))
ANEW = "-mesh_convert of this version wrote: make it anew from the .msh or .geo"
REFUSED = [
    ({"mesh": "short.h5"}, 4, ["cannot read short.h5: open: "]),
    ({"mesh": "empty.h5"}, 4, ["cannot read empty.h5: open: "]),
    ({"mesh": "text.h5"}, 4, ["cannot read text.h5: open: "]),
    ({"mesh": "newer.h5"}, 4, ["cannot use newer.h5: it was written by another version of impact (mesh 9, this one reads mesh 1)", ANEW]),
    ({"mesh": "other.h5"}, 4, ["cannot use other.h5: it holds no mesh of impact", ANEW]),
    ({"mesh": "without.h5"}, 4, ["cannot use without.h5: /mesh/cells is missing", ANEW]),
    ({"mesh": "groups.h5"}, 4, ["cannot use groups.h5: no list of the sets of groups", ANEW]),
    ({"mesh": "plane.h5", "mesh_set_n_lower": 5}, 2, ["plane.h5: -mesh_set_n_lower needs a .geo file"]),
    ({"mesh": "plane.h5", "mesh_convert": "x.msh"}, 2, ['-mesh_convert "x.msh": allowed: a name that ends with .h5']),
    ({"mesh": "plane.h5", "mesh_convert": "no/such/x.h5"}, 4, ["cannot write no/such/x.h5"]),
    ({"mesh": "plane.h5", "mesh_convert": "x.h5", "restart": "auto"}, 2, ["-mesh_convert and -restart"]),
    ({"mesh": "plane.h5", "mesh_convert": "x.h5", "bc_hold_on": "floor"}, 3, ['-bc_hold_on "floor": no such physical group']),
]
for place, (wrong, code, words) in enumerate(REFUSED):
    options = {**PLANE, **wrong}
    command = [PROGRAM, "-output_dir", "refused"] + [word for key, value in options.items() for word in ("-" + key, str(value))]
    for ranks in (1, 2, 3) if long() else (1 if place % 6 else 2,):
        with cores(ranks):
            done = subprocess.run((["mpirun", "-n", str(ranks)] if ranks > 1 else []) + command, capture_output=True, text=True,
                                  env=ENVIRONMENT, timeout=60)
        said = [line for line in done.stderr.splitlines() if line.startswith("impact: ")]
        good_words = len(said) == 1 and all(word in said[0] for word in words)
        if not require(f"{wrong} on {ranks} ranks: exit status {code} and one message", done.returncode == code and good_words):
            print(done.returncode, done.stdout[-500:], done.stderr[-1500:])
require("nothing was left of what could not be written", not [name for name in os.listdir(".") if name.endswith(".tmp")])
finish()
