"""A restart goes on with the mesh in its checkpoint: the .geo may be gone or changed and gmsh may be another one or none.
The same bits on the same ranks, 1e-8 on more; a changed file is refused unless it is allowed by name."""
# labels: run
# timeout: 120
import os
import shutil
import stat

import numpy

import _runs
from _runs import TWO_BLOCKS, check, finish, mesh, require, run

FULL = 0.044
OPTIONS = {**TWO_BLOCKS, "mesh": os.path.abspath("blocks.geo"), "mesh_set_n_lower": 3, "mesh_set_n_upper": 3, "dm_refine": 1}

shutil.copy(mesh("two_blocks.geo"), "blocks.geo")
whole = run("whole", {**OPTIONS, "ts_max_time": FULL, "checkpoint_every": 15})
half = run("half", {**OPTIONS, "order": 1, "ts_max_time": FULL, "ts_max_steps": 15, "checkpoint_every": 15})  # later without
require("the run has a checkpoint half way", os.path.exists("half/checkpoints"))

# From here on a gmsh that makes no mesh stands first on the path, and leaves a trace where it is run.
os.mkdir("bin")
with open("bin/gmsh", "w") as file:
    file.write(f'#!/bin/sh\ntouch "{os.path.abspath("gmsh_was_run")}"\nexit 1\n')
os.chmod("bin/gmsh", stat.S_IRWXU)
_runs.ENVIRONMENT["PATH"] = os.path.abspath("bin") + os.pathsep + os.environ["PATH"]


def resume(name, ranks=1, code=0, **changes):
    """The second half from a copy of the first one's folder."""
    shutil.copytree("half", name)
    return run(name, {**OPTIONS, "ts_max_time": FULL, "checkpoint_every": 15, "restart": "auto", **changes}, ranks=ranks, code=code)


def difference(a, b):
    """Largest difference of the columns of position and force, over the largest of each."""
    names = [name for name in a.history if name.startswith(("reaction_", "energy_")) or name == "time"]
    return max(numpy.abs(a[n] - b[n]).max() / max(numpy.abs(a[n]).max(), 1e-300) for n in names
               if numpy.abs(a[n]).max() > 1e-12)


def rows(name):
    with open(os.path.join(name, "history.csv")) as file:
        return [line for line in file if not line.startswith("#")]


with open("blocks.geo", "a") as file:
    file.write("\n// a word more\nnonsense that no gmsh takes\n")
refused = resume("changed", code=2)
require("a changed file is refused by name, with what allows it",
        "-mesh_content: the file of -mesh has changed" in refused.log and "-restart_allow mesh_content" in refused.log)
allowed = resume("allowed", restart_allow="mesh_content")
require("allowed, it is passed over with a word", "restart with a changed option: -mesh_content the file of -mesh has changed"
        in allowed.log and "resumed from" in allowed.log)
require("to the same bits", rows("allowed") == rows("whole"))

os.remove("blocks.geo")
gone = resume("gone")
require("with the file gone: resumed", "resumed from" in gone.log)
require("to the same bits", rows("gone") == rows("whole"))
two = resume("two", ranks=2)
check("on two ranks: largest difference", difference(whole, two), 0, 1e-8, relative=False)
require("gmsh was not run", not os.path.exists("gmsh_was_run"))
anew = run("anew", {**OPTIONS, "ts_max_time": FULL, "restart": "auto"}, code=4)
require("without a checkpoint the missing file is named", "blocks.geo: no such file" in anew.log)
finish()
