# labels: run
# timeout: 120
# processors: 1
"""How a staggered step is solved must not change what it finds: extrapolated passes against plain ones, a factorised
tangent that serves on against full Newton. A limit on the growth of phi in a step resolves the crack's jump, which full
steps pass in one, and with it the first law."""
import re

import numpy

from _runs import check_between, finish, option_file, require, run

CRACK = {"material_beam_c": "0.001 m^2/(N.s)", "mesh_set_depth": 1.0, "material_beam_split": "volumetric",
         "bcs": "clamp,push,sound", "bc_sound_on": "beam_left", "bc_sound_type": "damage", "bc_sound_value": 0, "bc_push_uy": "2*t",
         "coupling_snes_max_it": 200, "coupling_snes_atol": 1e-7, "output_vis_dt": 1}
PUSH = [option_file("beam_push.opts")]


def largest_difference(a, b, columns=("reaction_push_y", "phi_max", "alpha_max", "energy_elastic", "energy_fracture")):
    return max(numpy.abs(a[c] - b[c]).max() / numpy.abs(b[c]).max() for c in columns)


def work(r, column):
    return int(r[column].sum())


# While the crack is slow every way of iterating ends at the same state.
SLOW = {**CRACK, "ts_dt": 4e-3, "ts_max_time": 0.06}
plain = run("plain", {**SLOW, "coupling_relaxation": "none", "motion_reuse_tangent": 0}, PUSH)
aitken = run("aitken", {**SLOW, "motion_reuse_tangent": 0}, PUSH)
reuse = run("reuse", {**SLOW, "coupling_relaxation": "none"}, PUSH)
check_between("extrapolated passes against plain ones", largest_difference(aitken, plain), 0, 3e-6)
check_between("their Newton iterations over those of plain ones", work(aitken, "newton") / work(plain, "newton"), 0.1, 0.9)
check_between("tangent that serves on against full Newton", largest_difference(reuse, plain), 0, 1e-7)
require("it takes more iterations than full Newton", work(reuse, "newton") > work(plain, "newton"))

# The jump: one step of 4e-3 s without the limit.
JUMP = {**CRACK, "coupling_snes_atol": 1e-4, "ts_dt": 4e-3, "ts_max_time": 0.166}
whole = run("whole", JUMP, PUSH)
short = run("short", {**JUMP, "ts_adapt_dphi": 0.1}, PUSH, refused=10)
growth = numpy.diff(short["phi_max"])
check_between("largest growth of phi_max without the limit", numpy.diff(whole["phi_max"]).max(), 0.2, 1)
check_between("with a limit of 0.1", growth.max(), 0.01, 0.1)
require("the log names the limit where a step is cut", re.search(r"phi grows by [0-9.]+, -ts_adapt_dphi is 0\.1", short.log))
check_between("first-law residual, limited over unlimited",
              numpy.abs(short["balance_first_law"][-1]) / numpy.abs(whole["balance_first_law"][-1]), 0, 0.7)
check_between("dt grows back: last steps over the smallest", short["dt"][-4:].max() / short["dt"][1:].min(), 10, 1e3)
finish()
