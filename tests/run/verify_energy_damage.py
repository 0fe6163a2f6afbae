# labels: run
# timeout: 120
"""Broken cells that are crushed make no energy, whatever the step, nor does a contact that meets an overlap.

Rubble between two walls: a strip of broken cells with fixed ends. Each cell is as stiff as ever in compression and has
nothing in tension, so that all of them switch to and fro; the energy of the start is all there ever is. The undamped
trapezoidal rule gives 1/2 k c g' to a spring that it lets go from the depth c to the gap g' within a step. With heat the
same, in both forms of its balance; sheets are hardly stiffer in compression, because they get thicker.

Two blocks that overlap by a tenth of a facet, which the contact is told to leave: closing the overlap would do work on
the blocks that nobody put in."""
import numpy
from _runs import check, check_between, finish, long, mesh, require, run

WALLS = {
    "mesh": mesh("strip.geo"), "mesh_set_n": 8, "mesh_set_n_width": 1, "mesh_set_width": 0.125,
    "materials": "rubble", "material_rubble_region": "strip", "material_rubble_E": 1e9, "material_rubble_nu": 0,
    "material_rubble_rho": 1000, "material_rubble_damage": "at2", "material_rubble_split": "volumetric", "material_rubble_Gc": 1e-3, "material_rubble_gamma": 0.25,
    "bcs": "ends,sides", "bc_ends_on": "left,right", "bc_ends_ux": 0, "bc_sides_on": "sides", "bc_sides_uy": 0,
    "ics": "throw", "ic_throw_on": "strip", "ic_throw_phi": 1, "ic_throw_vx": "10*sin(2*pi*x)+3*sin(3*pi*x)",
    "ts_max_time": 0.02, "ts_newmark_rho": 1, "coupling_snes_max_it": 50, "coupling_snes_atol": 1e-6, "motion_snes_rtol": 1e-13,
    "motion_snes_atol": 1e-8, "energy_stop": 0,
}


# As much damping as there is, where a force at the end of a step moves the bodies like one over the step.
damped, like = (run("damped", {**WALLS, "ts_dt": 1.25e-4, "ts_max_time": 2e-3, "ts_newmark_rho": rho}) for rho in (0, 1e-4))
check("energy with rho 0, against that with hardly more", damped["energy_kinetic"][-1], like["energy_kinetic"][-1], 1e-3)


# Crushed in steps of 140 h/c_p, at a speed that rises to a constant one: the kinetic energy is that of a linear velocity.
SPEED, RISE, END = 0.02, 1e-4, 2e-3
CRUSHED = {
    "units": "mm_t_s_MPa", "mesh": mesh("block.geo"), "mesh_set_n": 6, "materials": "solid", "material_solid_E": 1000, "material_solid_nu": 0,
    "material_solid_rho": 1e-9, "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": 1,
    "material_solid_gamma": 0.5, "bcs": "hold,side,push,broken", "bc_hold_on": "bottom", "bc_hold_type": "symmetry",
    "bc_side_on": "left,right", "bc_side_type": "symmetry", "bc_push_on": "top", "bc_push_uy": f"(-{SPEED})*t^2/(t+{RISE})",
    "bc_broken_on": "solid", "bc_broken_type": "damage", "bc_broken_value": 0.9, "ics": "broken", "ic_broken_on": "solid",
    "ic_broken_phi": 0.9, "ts_dt": 2e-5, "ts_max_time": END,
}
for rho in (0, 0.5, 0.8):
    r = run(f"crushed_{rho}", {**CRUSHED, "ts_newmark_rho": rho})
    speed = SPEED * (END**2 + 2 * RISE * END) / (END + RISE) ** 2
    check(f"crushed slowly, rho {rho}: kinetic energy", r["energy_kinetic"][-1], 1e-9 * speed**2 / 6, 1e-4)


def energy(r):
    return (r["energy_kinetic"] + r["energy_elastic"]) / r["energy_kinetic"][0]


HEAT = {"material_rubble_c_v": 1e6, "material_rubble_conductivity": 1e-3, "material_rubble_alpha_t": 1e-5}
KINDS = {"volumetric": {}, "spectral": {"material_rubble_split": "spectral"}, "heat, entropy": {**HEAT, "heat_form": "entropy"},
         "heat, energy": {**HEAT, "heat_form": "energy"}}
for kind, more in KINDS.items():
    for dt in (5e-5, 1.25e-4, 3e-4)[0 if long() else 1:]:  # 0.4, 1 and 2.4 h/c
        r = run(f"{kind}_{dt}".replace(", ", "_"), {**WALLS, **more, "ts_dt": dt})
        name = f"rubble, {kind}, {dt * 8e3:.2g} h/c"
        check_between(f"{name}: largest energy over that of the start", energy(r).max(), 0.99, 1 + 1e-5)
        check_between(f"{name}: largest residual of the first law", abs(r["balance_first_law"]).max(), 0, 1e-4)
        check_between(f"{name}: balance", abs(r["balance"]).max(), 0, 1e-10)
        loss = r["dissipated_closing"] / r["energy_kinetic"][0]
        check_between(f"{name}: smallest loss of a step", numpy.diff(loss).min(), -1e-6, 1)
        if kind == "heat, energy":  # which takes the work of the stress: what closing loses is heat
            check_between(f"{name}: first law", abs(r["balance_first_law"]).max(), 0, 1e-10)
            gained = (r["energy_thermal"] - r["energy_thermal"][0]) / r["energy_kinetic"][0]
            check_between(f"{name}: what closing lost is heat", abs(gained - loss).max(), 0, 1e-4)
for nu in (0, 0.3):
    for dt in (5e-5, 3e-4):
        r = run(f"sheet_{nu}_{dt}", {**WALLS, "plane": "stress", "material_rubble_nu": nu, "ts_dt": dt,
                                     "material_rubble_residual_stiffness": 1e-2})
        check_between(f"sheet, nu {nu}, {dt * 8e3:.2g} h/c: largest energy over that of the start", energy(r).max(), 0.99, 1 + 1e-5)
# What it takes is of first order in the step: one way of a wave, closing and opening.
loss = [run(f"way_{dt}", {**WALLS, "ic_throw_vx": "sin(2*pi*x)", "ts_dt": dt, "ts_max_time": 1e-3})["dissipated_closing"][-1]
        for dt in (1e-5, 5e-6)]
check_between("loss of a step over that of half the step", loss[0] / loss[1], 1.7, 2.3)

BLOCKS = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_inset": 0.1, "mesh_set_gap": -0.03,
    "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3, "material_lower_rho": 1000,
    "material_upper_like": "lower", "bcs": "hold", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix",
    "ics": "fall", "ic_fall_on": "upper", "ic_fall_vy": -1,
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "contact_face_initial": "allow", "contact_face_method": "mortar", "ts_dt": 2e-3, "ts_max_time": 0.4, "energy_stop": 0,
}
for dt in (2e-3, 5e-4) if long() else (2e-3,):
    r = run(f"overlap_{dt}", {**BLOCKS, "ts_dt": dt})
    check_between(f"blocks that overlap, steps of {dt}: largest energy over that of the start", energy(r).max(), 0.9, 1 + 1e-6)
    require("they part again", r["contact_face_active"][-1] == 0 and r["momentum_upper_y"][-1] > 0)
finish()
