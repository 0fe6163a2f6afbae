# labels: run
# timeout: 600
# long: 300
"""Coulomb friction between two meshes: a block that slides on another one stops after v^2/(2 mu g), by Gauss points and mortar, on
cells of first and of second order; the heat of friction is the energy of motion but for what the blocks vibrate with, and all of it
with shorter steps; the ranks do not matter. The force of the contact is all of it where nodes of both sides are led."""
from _runs import check, check_between, finish, long, mesh, run

MU, G, V = 0.3, 10.0, 1.0
RHO, E = 1000.0, 1e8
POINTS, MORTAR = {"contact_face_method": "gpts"}, {"contact_face_method": "mortar"}

# A unit block on a longer one that is held below; meshes that do not match.
SLAB = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 7, "mesh_set_n_upper": 5, "mesh_set_inset": 0.1,
    "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": 0.3, "material_lower_rho": RHO,
    "material_upper_like": "lower",
    "bcs": "hold,weight", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_weight_on": "upper",
    "bc_weight_type": "body_force", "bc_weight_uy": -G,
    "ics": "flight", "ic_flight_on": "upper", "ic_flight_vx": V / 2,
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "contact_face_friction": MU, "ts_dt": 2.5e-3, "ts_max_time": 0.25, "ts_newmark_rho": 0.5,
    "measures": "place", "measure_place_on": "upper", "measure_place_fields": "u", "measure_place_of": "mean",
}
MASS = RHO * 0.8
TRIANGLES = {"mesh_set_simplices_lower": 1, "mesh_set_simplices_upper": 1}
for method, extra in (("boxes of second order", {"order": 2, **POINTS, "contact_face_enforce": "semismooth"}),
                      ("triangles of second order", {"order": 2, **TRIANGLES, **POINTS, "contact_face_enforce": "semismooth"}),
                      ("triangles of second order by mortar", {"order": 2, **TRIANGLES}), ("gpts", POINTS), ("mortar", MORTAR))[0 if long() else 3:]:
    r = run(f"slab_{method}", {**SLAB, **extra})
    normal, tangential = r["contact_face_force_y"], r["contact_face_force_x"]
    sliding = (r["time"] > 0.02) & (r["time"] < 0.15) & (normal > 0)
    print(f"     {method}: Newton iterations per step {r['newton'][1:].mean():.2f}, most {r['newton'].max():.0f}, "
          f"tries {r['tries'].max():.0f}")
    check_between(f"slab, {method}: most iterations of a solve", r["newton_most"].max(), 1, 12)
    check_between(f"slab, {method}: tries of a step", r["tries"].max(), 1, 1)
    check(f"slab, {method}: tangential over normal force, mean", abs(tangential[sliding].sum() / normal[sliding].sum()),
          MU, 1e-2)
    check(f"slab, {method}: distance v^2/(2 mu g)", r["measure_place_ux"][-1], (V / 2) ** 2 / (2 * MU * G), 0.02)
    # Both blocks are elastic: the stop leaves a part in their vibration.
    check_between(f"slab, {method}: heat of friction over the kinetic energy",
                  r["dissipated_friction"][-1] / (MASS * (V / 2) ** 2 / 2), 0.85, 1)
    check(f"slab, {method}: first law", abs(r["balance_first_law"]).max(), 0, 1e-5, relative=False)
    if ("order" in extra or extra is MORTAR) and not long():
        continue
    two = run(f"slab_{method}_two", {**SLAB, **extra, **({} if extra is MORTAR and long() else {"ts_max_steps": 40 if long() else 20})}, ranks=2)  # one of them beyond the stop
    for column in ("measure_place_ux", "dissipated_friction", "energy_kinetic"):
        check(f"slab, {method}: 2 ranks against 1, {column}",
              abs(two[column] - r[column][:len(two["time"])]).max() / abs(r[column]).max(), 0, 1e-6, relative=False)

if long():
    short = run("slab_short_steps", {**SLAB, "contact_face_method": "mortar", "ts_dt": SLAB["ts_dt"] / 4})
    check_between("slab, mortar: loss of the integrator and of closing gaps with a fourth of the step over that with the whole one",
                  (short["dissipated_numerical"][-1] + short["dissipated_contact"][-1])
                  / (r["dissipated_numerical"][-1] + r["dissipated_contact"][-1]), 0, 0.4)
    check("slab, mortar: heat with a fourth of the step over the kinetic energy",
          short["dissipated_friction"][-1] / (MASS * (V / 2) ** 2 / 2), 1, 0.04)

# Nodes of both sides are led: what rubs there is in the force of the contact, too.
LED = {key: value for key, value in SLAB.items() if key[:3] not in ("bc_", "ic_", "ts_") and "rho" not in key and key != "ics"}
LED |= {"mesh_set_inset": 0, "mesh_set_n_lower": 2, "mesh_set_n_upper": 2, "bcs": "floor,walls,press,draw", "bc_floor_on": "lower_bottom", "bc_floor_uy": 0, "bc_walls_on": "lower_sides",
        "bc_walls_ux": 0, "bc_press_on": "upper_top", "bc_press_uy": "-0.01*ramp(t,0,1)", "bc_draw_on": "upper_sides",
        "bc_draw_ux": "0.1*ramp(t,1,2)", "ts_type": "static", "ts_dt": 0.25, "ts_max_time": 2.5}
for method, extra in (("mortar", MORTAR), ("gpts", POINTS)):
    r = run(f"led_{method}", {**LED, **extra})
    for when, step in (("at the end of the way", -3), ("at rest", -1)):
        check(f"led, {method}: force of the contact beside that of what draws, {when}", -r["contact_face_force_x"][step] / r["reaction_draw_x"][step],
              1, 1e-8)
finish()
