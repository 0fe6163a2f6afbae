# labels: run
# timeout: 240
# long: 200
# processors: 1
"""Damped steps (-ts_newmark_rho below 1) beside contact-stabilised contact: nodes that contact holds have the velocity of what
they touch and no acceleration, kinetic energies are those of the motion, and no impact gains energy, in steps of 30 to 200 h/c_p,
for every rho; a run resumed from a static one stays at rest; restarts and other numbers of ranks give the same."""
import glob

import numpy
from _runs import check, check_between, finish, long, mesh, require, run

E, NU, RHO, SPEED = 1000, 0.3, 1e-9, 0.02  # MPa, t/mm^3, mm/s
RADII = (0, 0.5, 0.8, 0.9, 1) if long() else (0, 0.8, 1)
SOLID = {"material_solid_E": E, "material_solid_nu": NU, "material_solid_rho": RHO}
PRESSED = {
    "units": "mm_t_s_MPa", "mesh": mesh("block.geo"), "mesh_set_n": 6, "materials": "solid", **SOLID,
    "bcs": "hold,side", "bc_hold_on": "bottom", "bc_hold_type": "symmetry", "bc_side_on": "left", "bc_side_type": "symmetry",
    "contacts": "plate", "contact_plate_secondary": "top", "contact_plate_primary": "plane", "contact_plate_plane_point": "0,1",
    "contact_plate_plane_normal": "0,-1", "contact_plate_rigid_uy": f"(-{SPEED})*t^2/(t+1e-4)", "ts_dt": 2e-5, "ts_max_time": 2e-3,
    "measures": "least,most", "motion_snes_rtol": 1e-10,
    **{f"measure_{m}_{key}": value for m, of in (("least", "min"), ("most", "max"))
       for key, value in (("on", "top"), ("fields", "v,a"), ("of", of))},
}

print("a plane that presses a block at a speed, in steps of 140 h/c_p")
for name, extra, rows in (("mortar", {"contact_plate_method": "mortar"}, RADII),
                          ("second order", {"order": 2, "mesh_set_n": 3}, (0, 0.8) if long() else (0.8,))):
    for rho in rows:
        r = run(f"pressed_{name}_{rho}", {**PRESSED, **extra, "ts_newmark_rho": rho})
        require("the update is at work", "contact-stabilised" in r.log)
        what, t = f"{name}, rho {rho}", r["time"][-1]
        speed = SPEED * (t**2 + 2e-4 * t) / (t + 1e-4) ** 2
        for place in "least", "most":
            check(f"{what}: velocity of the touching nodes, {place}", r[f"measure_{place}_vy"][-1], -speed, 2e-3)
            if rho < 1:
                check(f"{what}: their acceleration over speed by time, {place}", r[f"measure_{place}_ay"][-1] * t / speed, 0, 0.05, relative=False)
        # A homogeneous block: its velocity is linear in its height, and across.
        check(f"{what}: kinetic energy", r["energy_kinetic"][-1], RHO * speed**2 / 6 * (1 + (NU / (1 - NU)) ** 2),
              1e-4 if rho < 1 else 0.02)  # nothing damps what rings from the start on
        check_between(f"{what}: gain", r["gain"].max() / r["energy_elastic"].max(), 0, 1e-9)

print("a block that lands on another one in steps of 31 h/c: no impact gains energy")
LANDS = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 8, "mesh_set_n_upper": 7, "mesh_set_gap": 0.05, "materials": "lower,upper",
    "material_lower_E": 1e9, "material_lower_nu": 0.3, "material_lower_rho": 1000, "material_upper_like": "lower",
    "bcs": "hold", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "ics": "fly", "ic_fly_on": "upper", "ic_fly_vy": -1,
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top", "ts_dt": 3.3e-3, "ts_max_time": 0.18,
}
for rho in RADII:
    r = run(f"lands_{rho}", {**LANDS, "ts_newmark_rho": rho})
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check_between(f"rho {rho}: largest energy over that of the start", energy.max() / energy[0], 1, 1 + 1e-9)
    check_between(f"rho {rho}: what the block keeps", energy[-1] / energy[0], 0.1, 0.9)
# The contact's momentum is that of the block.
check("its impulse", r["impulse_face_y"][-1], r["momentum_upper_y"][-1] + 1000, 1e-9)

print("a static state that goes on in damped steps stays at rest; the same in two runs and on two ranks")
STATIC = {**PRESSED, "contact_plate_rigid_uy": "(-0.01)*min(1,t/1e-3)", "ts_max_time": 1e-3, "ts_dt": 2.5e-4, "checkpoint_every": 4}
run("held", {**STATIC, "ts_type": "static"})
r = run("held_on", {**STATIC, "ts_newmark_rho": 0.8, "ts_dt": 2e-5, "ts_max_time": 1.4e-3, "restart": max(glob.glob("held/checkpoints/*.h5")),
                    "restart_allow": "ts_type"})
check("kinetic energy over the elastic one", r["energy_kinetic"].max() / r["energy_elastic"].max(), 0, 1e-12, relative=False)
PARTS = {**PRESSED, "ts_newmark_rho": 0.8, "ts_max_time": 4e-4, "checkpoint_every": 10}
whole = run("whole", PARTS)
run("parts", {**PARTS, "ts_max_steps": 10})
parts = run("parts", {**PARTS, "restart": "auto"})
require("resumed, bit by bit", all(numpy.array_equal(whole[c], parts[c]) for c in whole.history if c != "wall"))
two = run("two", PARTS, ranks=2)
check("on two ranks: kinetic energy", two["energy_kinetic"][-1], whole["energy_kinetic"][-1], 1e-6)
finish()
