# labels: run
# timeout: 120
"""Half a run, then -restart auto from its end, equals the uninterrupted run; outputs go on without doubled times."""
from _histories import difference, field_times, fields_difference
from _reliability import fields_fault
from _runs import BREAKING_BLOCKS, check, finish, option_file, require, run

BLOCKS = {**BREAKING_BLOCKS, "checkpoint_every": 5}
BEAM = {"output_vis_dt": 0.02, "ts_dt": 0.01, "mesh_set_h_factor": 2, "checkpoint_every": 4, "output_vis_times": 0.13}


def compare(claim, a, b, exact):
    worst, where = difference(a.history, b.history, exact=exact)
    check(f"{claim}: largest difference, in {where}", worst, 0, 1e-12, relative=False)
    worst, where = fields_difference(b.dir, a.dir)
    check(f"{claim}: largest difference of a field, {where}", worst, 0, 1e-12, relative=False)
    require(f"{claim}: field output at more than two times, none doubled", not fields_fault(b.dir) and len(field_times(b.dir)) > 2)


for name, options, files, half, full, ranks in (
        ("blocks", BLOCKS, [], 15, 0.06, 1), ("blocks", BLOCKS, [], 15, 0.06, 2),
        ("beam", BEAM, [option_file("beam_push.opts")], 8, 0.14, 1)):
    whole = run(f"{name}_{ranks}_whole", {**options, "ts_max_time": full}, files=files, ranks=ranks)
    cut = f"{name}_{ranks}_cut"
    run(cut, {**options, "ts_max_time": full, "ts_max_steps": half}, files=files, ranks=ranks)
    resumed = run(cut, {**options, "ts_max_time": full, "restart": "auto"}, files=files, ranks=ranks)
    require("from the last step before", f", step {half}\n" in resumed.log)
    print(f"     {name}, {ranks} ranks: phi {whole['phi_max'][-1]:.3f}, alpha {whole['alpha_max'][-1]:.2e}")
    compare(f"{name}, {ranks} ranks", whole, resumed, exact=ranks == 1)
finish()
