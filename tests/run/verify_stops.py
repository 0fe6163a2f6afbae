# labels: run
# timeout: 120
"""Runs that stop by themselves (-stops): when, with what is left behind, and that the peaks survive a restart on
another number of ranks."""
import glob

import numpy

import _runs as runs

BAR = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_n": 3,
       "materials": "solid", "material_solid_E": 210e3, "material_solid_nu": 0.3, "material_solid_damage": "at2", "material_solid_split": "volumetric",
       "material_solid_Gc": 2.7, "material_solid_gamma": 0.015, "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0,
       "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right", "bc_pull_ux": "0.04*t", "ts_dt": 0.04,
       "ts_max_time": 1.6, "checkpoint_every": 16, "checkpoint_keep": 9}
HALF = {"stops": "late,broken", "stop_late_when": "t > 100",
        "stop_broken_when": "reaction_pull_x < 0.6*peak(reaction_pull_x) && step > 2"}
TEXT = '-stop_broken_when "reaction_pull_x < 0.6*peak(reaction_pull_x) && step > 2"'


def same(claim, a, b):
    for column in ("time", "reaction_pull_x", "phi_max", "energy_elastic"):
        runs.check(f"{claim}: {column}", abs(a[column] - b[column]).max() / abs(b[column]).max(), 0, 1e-8, relative=False)


whole = runs.run("whole", BAR)
force = whole["reaction_pull_x"]
end = next(i for i in range(3, len(force)) if force[i] < 0.6 * force[:i + 1].max())
runs.check_between("the checkpoint stands between the peak and the stop", 16, force.argmax() + 1, end - 1)
runs.check_between("the force falls to six tenths before the end", end, force.argmax() + 5, len(force) - 5)

stopped = runs.run("stopped", {**BAR, **HALF})
runs.require("stopped: the history up to the step at which it holds", all(
    numpy.array_equal(stopped[c], whole[c][:end + 1], equal_nan=True) for c in whole.history))
runs.require("stopped: says by what", f"stopped by {TEXT}; the state is in" in stopped.log
             and f"stopped at t = {whole['time'][end]:.10g} after {end} steps" in stopped.log)
points = sorted(glob.glob("stopped/checkpoints/*.h5"))
runs.check("stopped: a checkpoint between peak and stop, and one at the stop", len(points), 2, 0)

# Without the criterion the run goes on as if it had not been there.
gone_on = runs.run("gone_on", {**BAR, "restart": points[1]}, code=0)
both = {c: numpy.concatenate([stopped[c], gone_on[c]]) for c in ("time", "reaction_pull_x", "phi_max", "energy_elastic")}
same("gone on after the stop", both, whole)
# From a checkpoint after the peak, on two ranks: the peak came with it.
for ranks in (1, 2):
    again = runs.run(f"again_{ranks}", {**BAR, **HALF, "restart": points[0]}, ranks=ranks)
    runs.check(f"resumed on {ranks}: stops at the same time", again["time"][-1], whole["time"][end], 0)
    runs.require(f"resumed on {ranks}: by the same criterion", f"stopped by {TEXT}" in again.log)
# A criterion that the first run did not have counts from the restart.
other = runs.run("other", {**BAR, "stops": "low", "stop_low_when": "phi_max > 0.5 && peak(time-0) > 0.5",
                           "restart": points[0]})
runs.require("a new criterion: its peak is counted from the restart", "does not know peak(time-0)" in other.log)

wrong = runs.run("wrong", {**BAR, "stops": "broken", "stop_broken_when": "reaction_pul_x < 1"}, code=2)
runs.require("a name that is no column: exit 2 before anything is written, with the nearest one",
             "the history has no column 'reaction_pul_x'; did you mean reaction_pull_x?" in wrong.log
             and not wrong.history)
runs.finish()
