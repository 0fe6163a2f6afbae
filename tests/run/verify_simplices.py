# labels: run
# timeout: 300
# long: 200
"""Linear triangles and tetrahedra that share their volume in patches: they do not lock, their pressure does not alternate, and
steps of every kind balance their energy and are the same on other ranks and from a checkpoint."""
import numpy
import _runs as runs
from _cook import cook
from _fields import pressure_jump
from _whole import WHOLE, check_whole, compare

STEEL = {"material_solid_model": "j2", "material_solid_E": "206900 MPa", "material_solid_nu": 0.29, "material_solid_sigma_y": "450 MPa",
         "material_solid_hardening": "voce,linear", "material_solid_voce_r": "265 MPa", "material_solid_voce_s": 16.93,
         "material_solid_linear_h": "129.24 MPa"}

for name, n, depth, most in (("tri3", 16, 0, 0.03), ("tet4", 12, 3, 0.02), ("tri3_fine", 32, 0, 0.012))[: 3 if runs.long() else 2]:
    r = cook(name, n, depth=depth)
    runs.check(f"Cook, {name}, {n} cells along a side, corner", r["probe_p_uy"][-1], 6.93, most)
    runs.check_between(f"Cook, {name}: no chessboard in the pressure", pressure_jump(name, 4 if depth else 3), 0, 0.5)
    runs.require(f"Cook, {name}: the cure is named", "mean volume of patches of cells" in r.log and " lock, " not in r.log)
locked = cook("locked", 16, material_solid_locking="none")
runs.check_between("Cook without the cure", locked["probe_p_uy"][-1], 0.5, 5)
runs.require("what locks is said, and the remedy", " lock, " in locked.log and "-material_<id>_locking mean" in locked.log)

# Elasto-plastic (Simo and Armero 1992): quadrilaterals on the same nodes.
quads, triangles = (cook(f"steel_{simplices}", 16, 5e3, STEEL, simplices) for simplices in (0, 1))
print(f"     {quads['probe_p_uy'][-1]:.4f} {triangles['probe_p_uy'][-1]:.4f}")
runs.check("Cook, elasto-plastic, triangles beside quadrilaterals", triangles["probe_p_uy"][-1], quads["probe_p_uy"][-1], 0.02)
runs.check("Cook, elasto-plastic: balance", abs(triangles["balance"]).max(), 0, 1e-10, relative=False)

# A bar that necks (Simo and Miehe 1992) without heat, on the nodes of 10 x 36 quadrilaterals. Those give 77.28 kN at most and 68.9 at
# 4 mm, 65.9 with cells half as large, triangles of second order 68.5: flow localises in the cells of the neck, sooner in smaller ones.
neck = runs.run("neck", {"physics": "motion", "mesh_set_simplices": 1, "ts_max_time": 4.55, "output_vis_times": 4.55,
                         "output_vis_fields": "pressure", "probes": "centre", "probe_centre_fields": "u"},
                files=[runs.option_file("necking.opts")])
force = neck["reaction_grip_y"] / 1e3
runs.check("necking: largest force in kN", force.max(), 77.28, 1e-3)
runs.check("necking: force at 4 mm in kN", numpy.interp(4, neck["time"], force), 68.5, 0.02)

# Its flat quadrilaterals, stretched so far that the mean volume lets corners of cells pass each other.
if runs.long():
    for locking in "mean", "fbar":
        r = runs.run(f"flat_{locking}", {"physics": "motion", "mesh_set_nr": 24, "mesh_set_nz": 90, "mesh_set_grading": 0.965, "material_bar_locking": locking,
                                         "ts_dt": 0.1, "ts_max_time": 6, "probes": "none", "output_vis_times": 6,
                                         "output_vis_fields": "u"}, files=[runs.option_file("necking.opts")])
        runs.require(f"flat quadrilaterals that neck, {locking}: that cells are inside out is{'' if locking == 'mean' else ' not'} told",
                     ("cells of material bar are turned inside out at a corner" in r.log) == (locking == "mean"))

# A Taylor bar by central differences: the published length, diameter and temperature of quadrilaterals (DynELA, Abaqus).
if runs.long():
    taylor = runs.run("taylor", {"ts_type": "central_difference", "ts_dt": "auto", "mesh_set_simplices": 1, "output_vis_every": 100000},
                      files=[runs.option_file("taylor_bar.opts")])
    runs.check("Taylor bar: final length", 32.4 + taylor["measure_tail_uy"][-1], 26.54, 3e-3)
    runs.check("Taylor bar: diameter of the foot", 2 * (3.2 + taylor["probe_edge_ux"][-1]), 11.155, 2e-2)
    runs.check("Taylor bar: balance", abs(taylor["balance"]).max(), 0, 1e-10, relative=False)
    runs.check("Taylor bar: first law", abs(taylor["balance_first_law"]).max(), 0, 1e-10, relative=False)

check_whole({2: 6, 3: 3} if runs.long() else {3: 3}, (2, 3) if runs.long() else (3,))

# Cells that leave: their patches go on, and the energy balances.
worn = runs.run("worn", {"mesh": runs.mesh("block.geo"), "mesh_set_n": 8, "mesh_set_simplex": 1, "materials": "solid", **STEEL,
                         "units": "mm_t_s_MPa", "material_solid_rho": "7800 kg/m^3", "material_solid_erosion": "on",
                         "material_solid_erosion_strain": 0.3, "bcs": "hold,pull", "bc_hold_on": "left", "bc_hold_type": "fix",
                         "bc_pull_on": "right", "bc_pull_ux": "5e4*t", "ts_type": "central_difference", "ts_max_time": 1e-5})
runs.check_between("cells leave", worn["eroded_cells"][-1], 5, 100)
runs.check("cells leave: balance", abs(worn["balance"]).max(), 0, 1e-13, relative=False)

# A refined mesh has patches of its own, the same on two ranks; another partitioner would part them.
fine = {**WHOLE, "mesh_set_n": 3, "dm_refine": 1, "ts_max_steps": 5}
one, two = (runs.run(f"fine_{ranks}", fine, ranks=ranks) for ranks in (1, 2))
compare("refined: on two ranks", one, two)
log = runs.run("other_parts", {**fine, "petscpartitioner_type": "simple"}, ranks=2, code=2).log
runs.require("another partitioner is refused", "-petscpartitioner_type simple" in log and "metis" in log)
runs.finish()
