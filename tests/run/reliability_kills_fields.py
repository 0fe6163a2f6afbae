# labels: run
# processors: 2
# timeout: 180
# long: 1800
"""R1 for the field output: a run that is killed at a call that writes, syncs or renames one of its files loses at most the
time that is being written. The times before stay readable and right; after -restart auto every time is there once, with
the values of an undisturbed run, and no file beside those that the .xdmf names. Tried at every call of one output after a
checkpoint, with a restart for each set of files that a kill left; with IMPACT_LONG=1 at every call of the run, with a
restart after each. And between the checkpoint of the last step and the output at the end, when no step is left to take."""
import os
import re
import shutil

from _reliability import FAULTY, FRACTURE, field_times, fields_difference, fields_fault, run_within, with_mesh
from _runs import check, finish, long, require

OPTIONS = {**with_mesh(FRACTURE), "ts_dt": 0.1, "ts_max_time": 0.4, "checkpoint_every": 2, "output_vis_every": 1,
           "restart": "auto"}
CALLS = range(1, 1000) if long() else range(30, 42)  # a little more than those of the fourth output


def files(folder):
    """Files of the field output, and those that the .xdmf names."""
    there = {os.path.join("vis.fields", name) for name in os.listdir(os.path.join(folder, "vis.fields"))}
    there |= {name for name in os.listdir(folder) if name.startswith("vis.") and name != "vis.fields"}
    with open(os.path.join(folder, "vis.xdmf")) as xdmf:
        return there, {"vis.xdmf"} | set(re.findall(r">([^<>:]+\.h5):", xdmf.read()))


require("undisturbed run", run_within(60, "whole", OPTIONS) == 0 and not fields_fault("whole"))
whole = field_times("whole")
kills, restarts, before, faults, left, worst, where = 0, 0, None, [], [], 0.0, ""
for call in CALLS:
    folder = "killed"
    shutil.rmtree(folder, ignore_errors=True)
    code = run_within(30, folder, OPTIONS, 1, FAULTY, f"kill:{call}:vis.")
    if code == 0 and long():
        break
    if code != -9:
        faults.append(f"call {call}: not killed, status {code}")
        continue
    kills += 1
    times = []
    if os.path.exists(os.path.join(folder, "vis.xdmf")):
        fault, times = fields_fault(folder), field_times(folder)
        gap, place = fields_difference(folder, "whole", partly=True)
        if fault or times != whole[:len(times)]:
            faults.append(f"call {call}, after the kill: {fault or times}")
        worst, where = max((worst, where), (gap, f"{place} after the kill at call {call}"))
    left.append(len(times))
    state = (sorted(os.listdir(os.path.join(folder, "vis.fields"))), sorted(os.listdir(folder)), times)
    if state == before and not long():
        continue
    before, restarts = state, restarts + 1
    code = run_within(30, folder, OPTIONS)
    fault = fields_fault(folder)
    if code != 0 or fault or field_times(folder) != whole:
        faults.append(f"call {call}, resumed: status {code}, {fault or field_times(folder)}")
        continue
    there, named = files(folder)
    if there != named:
        faults.append(f"call {call}, resumed: files {sorted(there ^ named)}")
    gap, place = fields_difference(folder, "whole")
    worst, where = max((worst, where), (gap, f"{place} after the kill at call {call} and restart"))
# The end is at a checkpoint but at no third step: its output is due because the run ends.
at_end = {**OPTIONS, "output_vis_every": 3}
for ranks in (1, 2):
    reference, folder = f"whole_{ranks}", f"killed_{ranks}"
    require(f"undisturbed run on {ranks} rank(s)", run_within(60, reference, at_end, ranks) == 0)
    right = field_times(reference)
    killed = run_within(30, folder, at_end, ranks, FAULTY, f"kill:1:{len(right) - 1:06d}.h5")
    left_then = field_times(folder)
    code = run_within(30, folder, at_end, ranks)
    fault = fields_fault(folder)
    require(f"{ranks} rank(s), killed before the last output: {left_then}, then {field_times(folder)} of {right} {fault}",
            killed != 0 and left_then == right[:-1] and code == 0 and not fault and field_times(folder) == right)
    gap, place = fields_difference(folder, reference)
    worst, where = max((worst, where), (gap, f"{place} after a kill at the end and restart, {ranks} ranks"))
print(f"     {kills} kills, {restarts} restarts; times in the .xdmf after them: {left}")
for fault in faults:
    print("     " + fault)
check("kills after which a time was lost, doubled, wrong or left over", len(faults), 0, 0, relative=False)
check(f"largest difference of a field from the undisturbed run {where}", worst, 0, 1e-12, relative=False)
if long():
    require("the kills went through the whole run", left[0] == 0 and left[-1] >= len(whole) - 1)
else:
    require("the kills went through a whole output", left == sorted(left) and left[-1] - left[0] >= 1)
finish()
