# labels: run
# long: 300
# timeout: 240
"""Damage and temperature of first order on cells of second order (-damage_order 1, -heat_order 1). On rectangles their spaces are
those of cells of first order: whole runs of heat and of damage alone are the same to rounding. With motion: the load of a
notched plate between those of both orders, fewer unknowns of the damage at work, ranks, restart, steps tried twice, explicit
steps, what cannot be; that it is the default where quadratic damage has no bounds."""
import numpy

import _runs as runs

BODY = {"units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "materials": "solid", "material_solid_E": 1000, "material_solid_nu": 0.3,
        "ts_type": "static"}
WARM = {**BODY, "physics": "heat", "material_solid_c_v": 1, "material_solid_conductivity": 1, "mesh_set_n": 6, "bcs": "hot,wind,sun",
        "bc_hot_on": "left", "bc_hot_type": "temperature", "bc_hot_value": "300+20*y*t", "bc_wind_on": "right,top", "bc_wind_type": "convection",
        "bc_wind_h": 2, "bc_wind_value": 280, "bc_sun_on": "bottom", "bc_sun_type": "heat_flux", "bc_sun_value": "5*x",
        "ics": "start", "ic_start_on": "solid", "ic_start_theta": "298+3*x*x", "ts_dt": 0.1, "ts_max_time": 0.5,
        "probes": "a,b", "probe_a_at": "0.5,0.5", "probe_b_at": "0.75,0.25", "probe_a_fields": "theta", "probe_b_fields": "theta",
        "heat_form": "energy", "heat_capacity": "consistent", "heat_snes_rtol": 1e-12}
for dim, more in ((2, {}), (3, {"mesh_set_dim": 3, "mesh_set_n": 4, "probe_a_at": "0.5,0.5,0.5", "probe_b_at": "0.75,0.25,0.5"})):
    for name, serendipity in (("with middles", 0), ("serendipity", 1)):
        one = runs.run(f"heat_{dim}_linear", {**WARM, **more, "order": 1})
        two = runs.run(f"heat_{dim}_lowered_{serendipity}", {**WARM, **more, "order": 2, "mesh_serendipity": serendipity, "heat_order": 1})
        for column in ("probe_a_theta", "probe_b_theta", "energy_thermal", "heat_supplied"):
            runs.check(f"heat, {dim}D, {name}: {column} of cells of first order",
                       abs(two[column] - one[column]).max() / abs(one[column]).max(), 0, 1e-8, relative=False)
        runs.require(f"heat, {dim}D, {name}: one iteration", two["heat_its"].max() <= max(one["heat_its"].max(), 1))

# A crack profile from a broken side, and one broken corner.
BROKEN = {**BODY, "physics": "damage", "material_solid_damage": "at2", "material_solid_Gc": 1, "material_solid_gamma": 0.3,
          "mesh_set_n": 6, "bcs": "side", "bc_side_on": "left", "bc_side_type": "damage", "bc_side_value": "1-0.5*y", "ts_dt": 1, "ts_max_time": 1,
          "probes": "a,b", "probe_a_at": "0.25,0.5", "probe_b_at": "0.5833333333333333,0.25", "probe_a_fields": "phi", "probe_b_fields": "phi",
          "damage_ksp_rtol": 1e-13, "damage_snes_rtol": 1e-13}
one = runs.run("damage_linear", {**BROKEN, "order": 1})
two = runs.run("damage_lowered", {**BROKEN, "order": 2, "damage_order": 1})
for column in ("probe_a_phi", "probe_b_phi", "energy_fracture", "work_damage"):
    runs.check(f"damage: {column} of cells of first order", two[column][-1], one[column][-1], 1e-8)

# A plate with a slit, quadratic in u.
PLATE = {**BODY, "mesh": runs.mesh("edge_crack.geo"), "mesh_set_width": 1, "mesh_set_height": 1, "mesh_set_slit": 0.5, "mesh_set_n": 20,
         "material_solid_region": "plate", "material_solid_E": 210e3, "material_solid_damage": "at2", "material_solid_Gc": 2.7,
         "material_solid_gamma": 0.1, "bcs": "hold,pull", "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_pull_on": "top",
         "bc_pull_ux": 0, "bc_pull_uy": "t", "ts_dt": 5e-4, "ts_max_time": 5e-3}
loads = {}
for name, more in (("quadratic", {"order": 2}), ("lowered", {"order": 2, "damage_order": 1}), ("linear", {"order": 1})):
    run = runs.run(f"plate_{name}", {**PLATE, **more, "checkpoint_every": 5})
    loads[name] = run["reaction_pull_y"][-1]
    if name == "lowered":
        one = run
runs.check("plate: load beside that of quadratic damage", loads["lowered"], loads["quadratic"], 0.02)
runs.check_between("plate: stays below that of cells of first order", loads["lowered"] / loads["linear"], 0.9, 1)
runs.check("plate: first law", abs(one["balance_first_law"]).max(), 0, 1e-2, relative=False)
LOW = {**PLATE, "order": 2, "damage_order": 1}
two = runs.run("plate_two", LOW, ranks=2)
again = runs.run("again", {**LOW, "restart": "plate_lowered/checkpoints/checkpoint_000001.h5"})
tried = runs.run("tried", {**LOW, "test_restep": 1}, refused=None) if runs.long() else None
for column in ("phi_max", "energy_fracture", "reaction_pull_y"):
    runs.check(f"plate, 2 ranks: {column}", abs(two[column] - one[column]).max() / abs(one[column]).max(), 0, 1e-7, relative=False)
    runs.require(f"plate, restart: {column} bit for bit", (again[column][-5:] == one[column][-5:]).all())
    if tried:
        runs.require(f"plate, steps tried twice: {column} bit for bit", (tried[column] == one[column]).all())

# Tetrahedra with damage and heat, flow and explicit steps.
TETS = {**BODY, "mesh_set_dim": 3, "mesh_set_simplex": 1, "mesh_set_n": 3, "order": 2, "damage_order": 1, "heat_order": 1, "material_solid_damage": "at2",
        "material_solid_Gc": 1, "material_solid_gamma": 0.5, "material_solid_c_v": 0.05, "material_solid_alpha_t": 1e-5,
        "material_solid_conductivity": 1, "bcs": "hold,pull", "bc_hold_on": "left", "bc_hold_type": "fix", "bc_pull_on": "right",
        "bc_pull_ux": "0.05*t", "ts_dt": 0.1, "ts_max_time": 1}
law = [abs(runs.run(f"tets_{n}", {**TETS, "ts_dt": 0.1 / n})["balance_first_law"]).max() for n in (1, 2)]
runs.check_between("tetrahedra with heat: residual of the first law falls with the steps", law[0] / law[1], 1.6, 4)
for option in ("bc_pull_on", "bc_pull_ux"):
    del TETS[option]
fast = runs.run("fast", {**TETS, "ts_type": "central_difference", "material_solid_rho": 1e-9, "bcs": "hold", "ics": "flight",
                         "ic_flight_on": "solid", "ic_flight_vx": "5e4*x", "ts_max_time": 1e-6, "ts_dt": "auto", "outputs": "hist",
                         "output_hist_type": "csv", "output_hist_every": 1})
runs.check("explicit: energy is kept", abs(fast["balance_first_law"]).max(), 0, 1e-2, relative=False)
runs.check_between("explicit: damage", fast["phi_max"][-1], 0.05, 1)

# Corners of tetrahedra and serendipity cells have shape functions that integrate to less than nothing: by default phi is of first order
# there, and nothing damages below the strength of 20. Unloading, which asks for the bound itself, leaves phi as it was.
BAR = {**BODY, "material_solid_nu": 0, "material_solid_Gc": 1, "material_solid_gamma": 0.25, "material_solid_split": "volumetric", "mesh_set_n": 3,
       "bcs": "hold,pull", "bc_hold_on": "left", "bc_hold_type": "fix", "bc_pull_on": "right", "bc_pull_ux": "0.015*t", "ts_dt": 0.5, "ts_max_time": 1, "order": 2}
WHOLE = {"material_solid_damage": "wu", "material_solid_ge": "linear", "material_solid_strength": 20}
FREE = {"material_solid_damage": "at2", "bc_pull_ux": "0.05*(t<0.5?2*t:2-2*t)", "ts_dt": 0.125}
for cells, more in runs.some((("tetrahedra", {"mesh_set_dim": 3, "mesh_set_simplex": 1}), ("hexahedra", {"mesh_set_dim": 3, "mesh_serendipity": 1}),
                              ("quadrilaterals", {"mesh_serendipity": 1})), 3):
    sound = runs.run(f"sound_{cells}", {**BAR, **WHOLE, **more})
    runs.check(f"sound bar of {cells}: largest phi", sound["phi_max"].max(), 0, 0, relative=False)
    whole = runs.run(f"whole_{cells}", {**BAR, "material_solid_damage": "none", **more})
    runs.check(f"sound bar of {cells}: force of one without damage", sound["reaction_pull_x"][-1], whole["reaction_pull_x"][-1], 1e-7)
    free = runs.run(f"free_{cells}", {**BAR, **FREE, **more})
    runs.check_between(f"unloaded {cells}: phi at the peak", free["phi_max"][4], 0.05, 1)
    runs.check(f"unloaded {cells}: phi in the end", free["phi_max"][-1], free["phi_max"][4], 1e-10)
    runs.check_between(f"unloaded {cells}: energy of the cracks does not fall", numpy.diff(free["energy_fracture"]).min(), -1e-12, numpy.inf)
    refused = runs.run("refused", {**BAR, **WHOLE, **more, "damage_order": 2}, code=3)
    runs.require(f"{cells}: damage_order 2 is refused, with a remedy", "allowed: 1, cells without -mesh_serendipity" in refused.log)

for more, words in (({"order": 1, "damage_order": 2}, "damage_order \"2\""), ({"damage_order": 3}, "damage_order")):
    refused = runs.run("refused", {**PLATE, **more}, code=2)
    runs.require(f"refused, with a reason: {words}", words in refused.log)
runs.finish()
