# labels: run
# processors: 2
# timeout: 300
"""Linear triangles and tetrahedra that share their volume in patches: they do not lock, their pressure does not alternate, and
steps of every kind balance their energy and are the same on other ranks and from a checkpoint."""
import numpy
import _runs as runs
from _fields import pressure_jump
from _histories import difference, fields_difference

STATIC = {"ts_type": "static", "units": "mm_t_s_MPa"}
SOFT = {"material_solid_E": 240.565, "material_solid_nu": 0.4999}
STEEL = {"material_solid_model": "j2", "material_solid_E": "206900 MPa", "material_solid_nu": 0.29, "material_solid_sigma_y": "450 MPa",
         "material_solid_hardening": "voce,linear", "material_solid_voce_r": "265 MPa", "material_solid_voce_s": 16.93,
         "material_solid_linear_h": "129.24 MPa"}


def cook(name, n, force, law, simplices=1, depth=0, **more):
    """Cook's membrane in the plane, or as a slab between smooth walls."""
    space = {"mesh_set_depth": depth, "bcs": "clamp,shear,faces", "bc_faces_on": "faces", "bc_faces_uz": 0} if depth else {}
    return runs.run(name, {
        **STATIC, "mesh": runs.mesh("cook.geo"), "mesh_set_n": n, "mesh_set_simplices": simplices, "materials": "solid", **law,
        "bcs": "clamp,shear", "bc_clamp_on": "left", "bc_clamp_type": "fix", "bc_shear_on": "right", "bc_shear_type": "force",
        "bc_shear_uy": f"{force * (depth or 1)}*t", "ts_dt": 0.1, "ts_max_time": 1, "probes": "p",
        "probe_p_at": f"48,60,{depth / 2}" if depth else "48,60", "probe_p_fields": "u", "outputs": "vis",
        "output_vis_fields": "pressure", **space, **more}, refused=None)


# Nearly incompressible: 6.93 is the limit of quadrilaterals with mean dilatation (6.815, 6.884, 6.911 with 16, 32, 64 cells
# along a side).
for name, n, depth, most in (("tri3", 16, 0, 0.03), ("tri3_fine", 32, 0, 0.012), ("tet4", 12, 3, 0.02)):
    r = cook(name, n, 100, SOFT, depth=depth)
    runs.check(f"Cook, {name}, {n} cells along a side, corner", r["probe_p_uy"][-1], 6.93, most)
    runs.check_between(f"Cook, {name}: no chessboard in the pressure", pressure_jump(name, 4 if depth else 3), 0, 0.5)
    runs.require(f"Cook, {name}: the cure is named", "mean volume of patches of cells" in r.log and " lock, " not in r.log)
locked = cook("locked", 16, 100, {**SOFT, "material_solid_locking": "none"})
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

# A Taylor bar by central differences: the published length, diameter and temperature of quadrilaterals (DynELA, Abaqus).
taylor = runs.run("taylor", {"ts_type": "central_difference", "ts_dt": "auto", "mesh_set_simplices": 1, "output_vis_every": 100000},
                  files=[runs.option_file("taylor_bar.opts")])
runs.check("Taylor bar: final length", 32.4 + taylor["measure_tail_uy"][-1], 26.54, 3e-3)
runs.check("Taylor bar: diameter of the foot", 2 * (3.2 + taylor["probe_edge_ux"][-1]), 11.155, 2e-2)
runs.check("Taylor bar: balance", abs(taylor["balance"]).max(), 0, 1e-10, relative=False)
runs.check("Taylor bar: first law", abs(taylor["balance_first_law"]).max(), 0, 1e-10, relative=False)

# Flow, heat, damage and inertia together: from a checkpoint to the bit, on other numbers of ranks to rounding.
WHOLE = {"mesh": runs.mesh("block.geo"), "mesh_set_simplex": 1, "materials": "solid", "units": "mm_t_s_MPa",
         "material_solid_model": "j2", "material_solid_E": "70 GPa", "material_solid_nu": 0.3,
         "material_solid_rho": "2700 kg/m^3", "material_solid_sigma_y": "300 MPa", "material_solid_damage": "at2",
         "material_solid_Gc": "20 N/mm", "material_solid_gamma": 0.3, "material_solid_c_v": 2.4, "material_solid_conductivity": 200,
         "material_solid_alpha_t": 2e-5, "bcs": "hold,pull", "bc_hold_on": "left", "bc_hold_type": "fix", "bc_pull_on": "right",
         "bc_pull_ux": "2e4*t", "ts_dt": 2e-7, "ts_max_time": 4e-6, "motion_snes_rtol": 1e-12, "damage_snes_rtol": 1e-12,
         "checkpoint_every": 10, "outputs": "vis", "output_vis_every": 5}
for dim in (2, 3):
    more = {**WHOLE, "mesh_set_dim": dim, "mesh_set_n": 6 if dim == 2 else 3}
    one = runs.run(f"whole_{dim}", more)
    runs.check_between(f"{dim}D: it flows and is damaged", min(one["alpha_max"][-1], one["phi_max"][-1]), 1e-3, 1)
    runs.run(f"cut_{dim}", {**more, "ts_max_steps": 10})
    again = runs.run(f"cut_{dim}", {**more, "restart": "auto"})
    worst, where = difference(one.history, again.history, exact=True)
    runs.check(f"{dim}D: from a checkpoint, largest difference, in {where}", worst, 0, 1e-300, relative=False)
    for ranks in (2, 3):
        many = runs.run(f"ranks_{ranks}_{dim}", more, ranks=ranks)
        worst, where = difference(one.history, many.history)
        runs.check(f"{dim}D: on {ranks} ranks, largest difference, in {where}", worst, 0, 1e-8, relative=False)
        worst, where = fields_difference(many.dir, one.dir, by_place=True)
        runs.check(f"{dim}D: on {ranks} ranks, largest difference of a field, {where}", worst, 0, 1e-7, relative=False)
    runs.run(f"moved_on_{dim}", {**more, "ts_max_steps": 10})
    moved_on = runs.run(f"moved_on_{dim}", {**more, "restart": "auto"}, ranks=2)
    worst, where = difference(one.history, moved_on.history)
    runs.check(f"{dim}D: from one rank to two, largest difference, in {where}", worst, 0, 1e-8, relative=False)

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
worst, where = difference(one.history, two.history)
runs.check(f"refined: on two ranks, largest difference, in {where}", worst, 0, 1e-8, relative=False)
log = runs.run("other_parts", {**fine, "petscpartitioner_type": "simple"}, ranks=2, code=2).log
runs.require("another partitioner is refused", "-petscpartitioner_type simple" in log and "metis" in log)
runs.finish()
