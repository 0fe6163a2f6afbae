# labels: run
# timeout: 120
# long: 200
"""-log_view tells where the time of a run goes: each event that options/README.md explains is met, on one rank and on two; the
events of the steps add up to nearly all of their time; a search that looks too far shows in its event; what ends a run early
leaves no scope open; tools/measure_messages.py counts what ranks send."""
import csv
import re
import subprocess
import sys

from _runs import BREAKING_BLOCKS, ENVIRONMENT, PROGRAM, SOURCE, TWO_BLOCKS, check_between, finish, long, option_file, require, run

ALL = {**BREAKING_BLOCKS, "contact_face_conductance": 1e5, "ts_max_time": 0.02, "checkpoint_every": 8,
       **{f"material_{body}_{key}": value for body in ("lower", "upper")
          for key, value in {"c_v": 1e6, "conductivity": 50}.items()}}
STEPS = ("Steps", "Motion", "Damage", "Heat")
# Of ours and of PETSc's, none inside of another one.
PARTS = ("MotionResidual", "MotionTangent", "MotionMatrix", "MotionPoints", "ContactSearch", "DamageResidual",
         "DamageTangent", "DamagePoints", "HeatResidual", "HeatTangent", "HeatLoads", "Balances", "KSPSolve", "PCSetUp")


def log(name, options, **more):
    """[(seconds, count) of each rank] by stage and event."""
    run(name, {**options, "log_view": f":{name}.csv:ascii_csv"}, **more)
    times = {}
    with open(f"{name}.csv") as file:
        for row in csv.reader(file):
            if len(row) > 4 and row[2].isdigit():
                times.setdefault((row[0], row[1]), []).append((float(row[4]), int(row[3])))
    return times


def share(times, events):
    """Of the time of the step stages, on rank 0."""
    part = {of: sum(by_rank[0][0] for (stage, event), by_rank in times.items() if stage in STEPS and event in of)
            for of in (events, ("summary",))}
    return part[events] / part["summary",]


with open(f"{SOURCE}/options/README.md") as file:
    page = re.search(r"\n## Where the time goes\n(.*?)\n## ", file.read(), re.S)[1]
told = set(re.findall(r"`([A-Z][a-z]+[A-Z]\w+|Balances|History)`", page))
with open(f"{SOURCE}/src/petsc/log.cpp") as file:
    names = set(re.findall(r'"(\w+)"', re.search(r"event_names = \{(.*?)\};", file.read(), re.S)[1]))
require(f"the page names the {len(names)} events, but for {sorted(names - told)}", names <= told)

for ranks in (1, 2) if long() else (2,):
    resumed = {**ALL, "restart": f"all_{ranks}/checkpoints/checkpoint_000001.h5", "ts_max_time": 0.022}
    read = {k: v for k, v in ALL.items() if not k.startswith("mesh_set_")}
    logs = (log(f"all_{ranks}", ALL, ranks=ranks), log(f"resumed_{ranks}", resumed, ranks=ranks),
            log(f"read_{ranks}", {**read, "mesh": f"all_{ranks}/two_blocks.msh", "ts_max_time": 2e-3}, ranks=ranks))
    met = {event for times in logs for (_, event), by_rank in times.items()
           if len(by_rank) == ranks and all(count > 0 for _, count in by_rank)}
    require(f"events that {ranks} ranks never met: {sorted(names - met) or 'none'}", names <= met)

beam = {"ts_max_steps": 12, "outputs": "none"}
check_between("part of the steps' time that lies in events, cracking beam with heat",
              share(log("beam", beam, files=[option_file("beam_wedge_heat.opts")]), PARTS), 0.8, 1.0)

many = {**TWO_BLOCKS, "mesh_set_n_lower": 120, "mesh_set_n_upper": 117, "ts_max_steps": 1}
near, far = (sum(by_rank[0][0] for (_, event), by_rank in log(name, {**many, "contact_face_search_radius": radius}).items()
                 if event == "ContactSearch") for name, radius in (("near", "auto"), ("far", 1)))
check_between("seconds of a search that looks a body far over those of one by the facets' sizes", far / near, 1.4, 100)

# An exception in a step: what ran until then is told, and each stage was left.
lost = log("lost", {**ALL, "energy_action": "stop", "energy_tol": 1e-9}, code=5)
require("a run that fails in a step tells its events", lost["Motion", "MotionResidual"][0][1] > 0)

def table(text):
    """{part: [(messages, kB, reductions) for each number of ranks]} of lines of a table."""
    rows = (line.strip("|").split("|") for line in text.splitlines() if re.match(r"\| [a-z].*\d", line))
    return {part.strip(): [tuple(map(float, cell.split(","))) for cell in cells] for part, *cells in rows if "ranks" not in cells[0]}


counted = subprocess.run([sys.executable, f"{SOURCE}/tools/measure_messages.py", PROGRAM, "--ranks", "1", "2", "--steps", "1"],
                         stdout=subprocess.PIPE, text=True, env=ENVIRONMENT)
messages = table(counted.stdout)
with open(f"{SOURCE}/src/scaling.md") as file:
    said = table(file.read().split("\n## ")[1])
require("messages are counted, of the parts that src/scaling.md has", counted.returncode == 0 and list(messages) == list(said) != [])
require("one rank sends none in its steps", all(one[0] == 0 for part, (one, _) in messages.items() if part != "whole set-up"))
require("two ranks send some in residuals, solvers and checkpoints",
        all(messages[part][1][0] > 0 for part in ("residual of the motion", "its linear solver", "damage", "heat", "checkpoint")))
finish()
