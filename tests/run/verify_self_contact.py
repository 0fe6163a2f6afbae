# labels: run
# timeout: 180
"""A surface in contact with itself: a ring under outside pressure buckles and folds (options/ring.opts) until its
opposite sides touch, at 5.247 EI/R^3 (Flaherty, Keller and Rubinow 1972) as the ring gets thin; it closes, opens and
closes again, turned by 90 degrees, on two ranks, and from a checkpoint."""
import shutil

import numpy
from _ring import ring
from _runs import check, check_between, finish, long, require

PRESSURE = {"param_load": 9, "bc_outside_value": "load*stiffness*t", "ts_dt": 0.02, "ts_max_time": 0.75}


def touch(thickness, cells, refused=0):
    r = ring(f"touch_{thickness}_{cells}", {**PRESSURE, "mesh_set_thickness": thickness, "mesh_set_n_around": cells},
             refused=refused)
    force = abs(r["contact_inside_force_y"])
    first, second = numpy.nonzero(force)[0][1:3]
    p = 9 * r["time"]
    return p[first] - force[first] * (p[second] - p[first]) / (force[second] - force[first])


# Quadrilaterals in bending are too stiff by the square of their length.
# The finest ring needs three tries of one step, as ever, and one solve is repeated.
thick, thin = ((4 * touch(h, 2 * n, most) - touch(h, n)) / 3 for h, n, most in ((1, 64, 0), (0.5, 128, 3)))
print(f"     pressure at touch over EI/R^3: {thick:.4f} with R/10, {thin:.4f} with R/20")
check("pressure at touch, thickness to zero", 2 * thin - thick, 5.247, 0.01)

# Closed, open, closed: the way back is the way there.
CYCLE = {"param_load": 8, "bc_outside_value": "load*stiffness*(t<1?t:t<1.5?2-t:t-1)", "ts_max_time": 2, "ts_dt": 0.02}
r = ring("cycle", CYCLE)
pressed = (r["contact_inside_active"] > 0).astype(int)
check_between("times that the ring closes", numpy.count_nonzero(numpy.diff(pressed) == 1), 2, 2)
check_between("steps with pressure", pressed.sum(), 5, 70)
check_between("smallest mean gap over the thickness", numpy.nanmin(r["contact_inside_gap_min"]), -1e-9, 1)
again, before = len(r["time"]) - 1, numpy.argmin(abs(r["time"] - 1))
for column in ("energy_elastic", "contact_inside_force_y", "contact_inside_pressure_max"):
    check(f"the second time as the first: {column}", r[column][again], r[column][before], 1e-6)
check("first law at the end, over the largest work", r["balance_first_law"][-1], 0, 2e-3, relative=False)

COLUMNS = ("energy_elastic", "work_external", "contact_inside_force_y", "contact_inside_pressure_max",
           "contact_inside_length", "contact_inside_active")


def same(claim, other, mine=None, tolerance=1e-8):
    mine = r if mine is None else mine
    if not require(f"{claim}: as many steps", len(mine["time"]) == len(other["time"])):
        return
    worst = max((abs(abs(mine[c]) - abs(other[c])).max() / abs(mine[c]).max(), c) for c in mine.history
                if c in COLUMNS)
    check(f"{claim}: largest difference, in {worst[1]}", worst[0], 0, tolerance, relative=False)


same("2 ranks", ring("cycle_2", CYCLE, ranks=2))
# A run that ends at the checkpoint would have made its last step by the last digit of t shorter.
kept = {**CYCLE, "checkpoint_every": 50, "checkpoint_keep": 100}
whole = ring("whole", kept)
shutil.copytree("whole", "restart")
same("from a checkpoint", ring("restart", {**kept, "restart": "restart/checkpoints/checkpoint_000001.h5"}), whole, 1e-12)
# The names of the two conditions change places with the axes.
if not long():
    finish()
turned = ring("turned", {**CYCLE, "mesh_set_angle": 90, "bc_cut_on": "right", "bc_right_on": "cut"})
turned.history["contact_inside_force_y"] = turned["contact_inside_force_x"]
same("turned by 90 degrees", turned)
finish()
