# labels: run
# timeout: 60
"""Mass scaling of explicit steps: the stable step is the one asked for, a wave is as slow as the mass says, body forces act on
the true mass, the limit is kept, restart and ranks."""
import filecmp
import re

import numpy
from _histories import difference
from _runs import check, finish, mesh, option_file, require, run

EXPLICIT = {"ts_type": "central_difference"}


def largest(values):
    return abs(values).max()


def said(r):
    """Stable step, added mass, cells, share of the log."""
    found = re.search(r"stable step of the cells is (\S+), .* mass scaling adds (\S+) kg to (\d+) cells, (\S+) of", r.log)
    return [float(number) for number in found.groups()]


print("a bar whose cells are all scaled to twice their step")
# nu = 0: a cell's highest frequency is 2 c/h and the front is exact at the step h/c' = 2 h/c, c' = c/2.
L, C, V = 0.1, 5000.0, 70 / (2800 * 5000.0)
r = run("wave", {**EXPLICIT, "ts_dt_cfl": 1, "ts_mass_scaling_dt": 2e-7, "ts_mass_scaling_limit": 3.001, "ts_dt": 2e-7,
                 "bc_load_value": "70 Pa", "output_vis_every": 100000}, files=[option_file("bar_wave.opts")])
step, added, cells, share = said(r)
check("stable step of the log", step, 2e-7, 1e-3)
check("mass that is added, three times that of the bar", added / (2800 * 0.1 * 2e-3), 3, 1e-3)
check("the column has it", r["mass_added"][-1], added, 1e-3)
check("its share", share, 3, 1e-3)
require("all cells", cells == 400)
time, v = r["time"], r["probe_middle_vx"]
before, behind = time < L / C - 1e-9, time > L / C + 3e-7
check("velocity ahead of the front, over p/(rho' c')", largest(v[before]) / (V / 2), 0, 1e-9, relative=False)
check("velocity behind the front", largest(v[behind] / (V / 2) - 1), 0, 1e-8, relative=False)
check("kinetic energy is that of the mass in use: half of the work", r["energy_kinetic"][-1] / r["work_external"][-1], 0.5, 5e-3)

print("the cells of one body alone")
E, RHO = 1e6, 1000.0
BLOCKS = {**EXPLICIT, "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 4, "mesh_set_n_upper": 8, "mesh_set_inset": 0,
          "mesh_set_gap": 0.05, "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": 0.3,
          "material_lower_rho": RHO, "material_upper_like": "lower", "ics": "flight", "ic_flight_on": "upper", "ic_flight_vy": -1,
          "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top", "bcs": "weight",
          "bc_weight_on": "lower,upper", "bc_weight_type": "body_force", "bc_weight_uy": -9.81, "ts_max_time": 0.1,
          "checkpoint_every": 10}
free = run("free", BLOCKS)
coarse = float(re.search(r"stable step of the cells is (\S+),", free.log).group(1)) * 2
WHOLE = {**BLOCKS, "ts_mass_scaling_dt": 0.99 * coarse, "ts_mass_scaling_limit": 2}
r = run("whole", WHOLE)
step, added, cells, share = said(r)
check("stable step", step, 0.99 * coarse, 1e-3)
check("mass that is added", added / RHO, 4 * 0.99**2 - 1, 2e-3)
check("as the kinetic energy of the start has it", r["energy_kinetic"][0], (RHO + r["mass_added"][0]) / 2, 1e-12)
check("steps are 0.8 of it", r["dt"][1], 0.8 * 0.99 * coarse, 1e-3)
momentum = r["momentum_lower_y"] + r["momentum_upper_y"]
check("body forces act on the true mass", (momentum[-1] - momentum[0]) / (-9.81 * 2 * RHO * r["time"][-1]), 1, 1e-11)
check("balance", largest(r["balance"]), 0, 1e-10, relative=False)
check("first law", largest(r["balance_first_law"]), 0, 2e-2, relative=False)
worst, where = difference(r.history, run("ranks", WHOLE, ranks=2).history)
check(f"two ranks, in {where}", worst, 0, 1e-8, relative=False)
run("halves", {**WHOLE, "ts_max_steps": int(r["step"][-1]) // 2})
run("halves", {**WHOLE, "restart": "auto"})
require("restart in the middle is bitwise", filecmp.cmp("whole/history.csv", "halves/history.csv", shallow=False))
none = run("none", {**BLOCKS, "ts_mass_scaling_dt": 0.1 * coarse})
require("a step that all cells have anyway adds nothing", largest(none["mass_added"]) == 0 and said(none)[2] == 0)
require("and changes nothing", all((none[c] == free[c]).all() for c in free.history if numpy.isfinite(free[c]).all()))

print("viscosity")
VISCOUS = {**WHOLE, "material_lower_b_d": 300, "contacts": None, "contact_face_secondary": None, "contact_face_primary": None}
VISCOUS = {k: v for k, v in VISCOUS.items() if v is not None}
check("stable step of damped cells", said(run("viscous", {**VISCOUS, "ts_mass_scaling_limit": 50}))[0], 0.99 * coarse, 1e-3)

print("what is refused")
for more, words in (({"ts_mass_scaling_limit": 1}, ["-ts_mass_scaling_dt", "-ts_mass_scaling_limit 1", "stable step"]),
                    ({"ts_mass_scaling_limit": None}, ["-ts_mass_scaling_limit 0.05"]),
                    ({"ts_mass_scaling_dt": None}, ["-ts_mass_scaling_limit", "-ts_mass_scaling_dt"]),
                    ({"ts_type": "newmark", "ts_dt": 1e-3, "ts_mass_scaling_limit": None}, ["-ts_mass_scaling_dt", "central_difference"])):
    options = {k: v for k, v in {**WHOLE, **more}.items() if v is not None}
    refused = run("refused", options, code=2)
    lines = [line for line in refused.log.splitlines() if line.startswith("impact: ") and "no title" not in line]
    require(f"{more}: {lines[-1:]}", bool(lines) and all(word in lines[-1] for word in words))
finish()
