# labels: run
# processors: 2
# timeout: 120
"""Half a run, then -restart auto, equals the uninterrupted run; outputs go on without doubled times."""
import re

import numpy
from _runs import BREAKING_BLOCKS, check, finish, option_file, require, run

COUNTS = ("newton", "newton_most", "linear", "uzawa", "damage_its", "heat_its", "balance", "balance_first_law")
BLOCKS = {**BREAKING_BLOCKS, "checkpoint_every": 10}
BEAM = {"output_vis_dt": 0.02, "ts_dt": 0.01, "mesh_set_h_factor": 2, "checkpoint_every": 4, "output_vis_times": 0.13}


def compare(claim, a, b, tolerance):
    if not require(f"{claim}: the same columns and rows", list(a.history) == list(b.history)
                   and len(a["time"]) == len(b["time"])):
        return
    worst, where = 0.0, "time"
    for column, values in a.history.items():
        if column in COUNTS:
            continue
        if (numpy.isnan(values) != numpy.isnan(b[column])).any():
            worst, where = numpy.inf, column
            continue
        scale = numpy.nanmax(abs(values), initial=0)
        # A component that is zero but for the solver's tolerance is measured by its vector.
        if column[-2:] in ("_x", "_y") and not column.startswith("crack"):
            scale = max(numpy.nanmax(abs(a[column[:-1] + k]), initial=0) for k in "xy")
        difference = numpy.nanmax(abs(values - b[column]), initial=0) / scale if scale > 0 else 0
        if difference > worst and scale > 1e-13:
            worst, where = difference, column
    check(f"{claim}: largest difference, in {where}", worst, 0, tolerance, relative=False)
    times = [re.findall(r'<Time Value="([^"]*)"', open(f"{r.dir}/vis.xdmf").read()) for r in (a, b)]
    require(f"{claim}: field output at the same times, none doubled",
            times[0] == times[1] and len(times[1]) == len(set(times[1])) > 2)


for name, options, files, half, full, ranks in (
        ("blocks", BLOCKS, [], 0.03, 0.06, 1), ("blocks", BLOCKS, [], 0.03, 0.06, 2),
        ("beam", BEAM, [option_file("beam_push.opts")], 0.08, 0.14, 1)):
    whole = run(f"{name}_{ranks}_whole", {**options, "ts_max_time": full}, files=files, ranks=ranks)
    cut = f"{name}_{ranks}_cut"
    run(cut, {**options, "ts_max_time": half}, files=files, ranks=ranks)
    resumed = run(cut, {**options, "ts_max_time": full, "restart": "auto"}, files=files, ranks=ranks)
    require("the run was resumed", "resumed from" in resumed.log)
    print(f"     {name}, {ranks} ranks: phi {whole['phi_max'][-1]:.3f}, alpha {whole['alpha_max'][-1]:.2e}")
    compare(f"{name}, {ranks} ranks", whole, resumed, 1e-12)
finish()
