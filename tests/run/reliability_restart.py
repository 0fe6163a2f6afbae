# labels: run
# timeout: 120
"""What may change on restart, and what a run that starts over or goes back does to what was there: free options pass, guarded
ones need -restart_allow, frozen ones are refused with the key and both values, before the mesh is read; no time is
doubled or missing in the outputs; checkpoints of an abandoned run are never taken up. R7: an option twice in one file."""
import os

from _reliability import BOTH, field_times, fields_fault, history, largest_difference, log_of, run_within, with_mesh
from _runs import check, finish, require

OPTIONS = {**with_mesh(BOTH), "ts_max_time": 0.04}


def attempt(folder, more, code):
    options = {**OPTIONS, **more}
    for key in [key for key, value in options.items() if value is None]:
        del options[key]
    status = run_within(60, folder, options)
    said = [line for line in log_of(folder).splitlines() if line.startswith("impact: ")]
    require(f"{folder} {more}: status {status}, expected {code}", status == code)
    return said


def refused(more, *words):
    said = attempt("run", {"restart": "auto", **more}, 2)
    require(f"  the line names key, both values and the remedy: {said[-1:]}",
            len(said) == 1 and all(word in said[0] for word in words))


attempt("whole", {}, 0)
attempt("run", {"ts_max_steps": 12}, 0)  # checkpoints of steps 5 and 10

refused({"mesh_scale": 2}, "-mesh_scale", '"2"', '"1"', "cannot change")
refused({"plane": "axisymmetric"}, "-plane", '"axisymmetric"', '"strain"', "cannot change")
refused({"material_lower_E": 2e6}, "-material_lower_E", "2e+06", "1e+06", "-restart_allow material_lower_E")
refused({"contact_face_penalty": 1e7}, "-contact_face_penalty", '"1e+07"', '"auto"', "-restart_allow")
refused({"bc_hold_type": "displacement", "bc_hold_ux": 0}, "-bc_hold_type", "-bc_hold_ux", "(not given)", "-restart_allow")
refused({"ts_newmark_rho": 0.8}, "-ts_newmark_rho", '"0.8"', '"0.9"', "-restart_allow ts_newmark_rho")
refused({"ic_flight_vx": 0.4}, "-ic_flight_vx", '"0.4"', '"0.3"', "-restart_allow")
said = attempt("run", {"restart": "auto", "restart_allow": "bc_hodl"}, 2)
require(f"  an entry that fits nothing is refused: {said}", len(said) == 1 and "bc_hodl" in said[0])

for nothing in ({"restart": "auto"}, {}):  # neither a checkpoint nor a request to go on from one
    said = attempt("empty", {**nothing, "restart_allow": "bc_hodl"}, 2)
    require(f"  and when there is nothing to resume: {said}", len(said) == 1 and "bc_hodl" in said[0]
            and "bc_hold" in said[0] and "material_lower" in said[0])

# Free ones: the end, the output, the solver, the checkpoints.
said = attempt("run", {"restart": "auto", "checkpoint_every": 4, "title": "again", "motion_ksp_rtol": 1e-8}, 0)
check("free options changed: difference from the uninterrupted run", largest_difference("run", "whole")[0], 0, 1e-12,
      relative=False)
require(f"free options changed: field output is whole {fields_fault('run')}",
        not fields_fault("run") and field_times("run") == field_times("whole"))

# Back to an earlier checkpoint, by name: what came after it is cut off, and no later one is taken up by auto.
names = sorted(os.listdir("run/checkpoints"))
first = [name for name in names if name.endswith(".h5")][0]
said = attempt("run", {"restart": "run/checkpoints/" + first, "ts_max_steps": 17, "checkpoint_every": 0}, 0)
times = history("run")["time"]
require(f"back to {first}: no time doubled or missing, {len(times)} rows",
        len(times) == 18 and abs(times - history("whole")["time"][:18]).max() == 0)
require("back: later checkpoints no longer count, with a word", any("no longer count" in line for line in said))
attempt("run", {"restart": "auto"}, 0)
require("back, then auto: from the end of the run that went back", ", step 17\n" in log_of("run"))
check("back, then auto: difference from the uninterrupted run", largest_difference("run", "whole")[0], 0, 1e-12,
      relative=False)

# A new run in the same folder: auto does not take up the old one.
said = attempt("run", {"ts_max_steps": 3, "output_overwrite": "on"}, 0)
require("anew: older checkpoints no longer count, with a word", any("no longer count" in line for line in said))
said = attempt("run", {"restart": "auto"}, 0)
require("anew, then auto: from the end of the new run", ", step 3\n" in log_of("run"))

# Guarded, allowed: goes on, and says what changed.
attempt("changed", {"ts_max_steps": 12}, 0)
said = attempt("changed", {"restart": "auto", "restart_allow": "material_lower_Gc,material_upper_Gc,material_lower_E",
                           "material_lower_Gc": 60}, 0)
require(f"guarded and allowed: {said[:1]}", any("-material_lower_Gc" in line and "60" in line for line in said))
said = attempt("changed", {"restart": "auto", "material_lower_Gc": 60}, 0)
late = attempt("changed", {"restart": "auto", "material_lower_Gc": 60, "ic_flight_vx": 0.4, "restart_allow": "ic_flight"}, 0)
require("initial conditions at a restart are told", any("-ic_flight_vx" in line and "without effect, for the state is" in line for line in late))
require("the change is part of the later checkpoints", not any("material_lower_Gc" in line for line in said))

# R7: twice in one file.
with open("twice.opts", "w") as file:
    file.write("-ts_dt 1e-3\n# a comment\n  -title x\n-TS_dt 2e-3\n")
said = attempt("twice", {"options_file": "twice.opts"}, 2)
require(f"an option twice in a file: {said}", len(said) == 1 and "-ts_dt: given twice in twice.opts, lines 1 and 4" in said[0])
with open("once.opts", "w") as file:
    file.write("-title x\n")
attempt("once", {"options_file": "once.opts", "title": "the command line wins", "dry_run": "on"}, 0)
finish()
