# labels: run
# timeout: 120
"""Two blocks of non-matching meshes pressed together between frictionless plates (Gauss-point contact, Uzawa): mean
pressure against the closed form, penetration and multipliers at the tolerances, no influence of the penalty; the
deviation from a uniform pressure is reported and shrinks with the number of points."""
from _press import press
from _runs import check, check_between, finish, mesh, require, run

E, NU, PRESS = 1e6, 0.3, 0.02
TOP = 2 * PRESS  # the stack of two unit blocks becomes shorter by this
STRETCH, FORCE = press(E, NU, 1 - PRESS)
PRESSURE = FORCE / STRETCH
PROBES = {"a": 0.1, "b": 0.3, "c": 0.5}
BASE = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 5, "mesh_set_n_upper": 4,
    "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": NU, "material_upper_like": "lower",
    "bcs": "plate,press",
    "bc_plate_on": "lower_bottom", "bc_plate_uy": 0, "bc_plate_ux": f"{STRETCH - 1!r}*x*t",
    "bc_press_on": "upper_top", "bc_press_uy": f"-{TOP!r}*t", "bc_press_ux": f"{STRETCH - 1!r}*x*t",
    "contacts": "face", "contact_face_secondary": "lower_top", "contact_face_primary": "upper_bottom",
    "contact_face_method": "gpts",
    # The middles of the cells below the interface, one half of them.
    "probes": ",".join(PROBES), **{f"probe_{k}_at": f"{x},0.9" for k, x in PROBES.items()},
    **{f"probe_{k}_fields": "stress" for k in PROBES},
    "ts_type": "static", "ts_dt": 1, "ts_max_time": 1,
}
TIGHT = {"contact_face_gap_tol": 1e-6, "contact_face_pressure_tol": 1e-3, "uzawa_snes_max_it": 200}

print(f"closed form: lateral stretch {STRETCH:.8f}, force {FORCE:.8g}, pressure {PRESSURE:.8g}")
print("extremes over the closed form, by the number of points per facet, default tolerances")
scatter, spread = {}, {}
for points in (2, 3, 4, 5):
    # Odd numbers put the middle point of the middle facet on a node of the other surface, where the normal jumps.
    r = run(f"points_{points}", {**BASE, "contact_face_points": points})
    low, high = r["contact_face_pressure_min"][-1] / PRESSURE, r["contact_face_pressure_max"][-1] / PRESSURE
    stresses = sorted(-r[f"probe_{name}_stress_yy"][-1] / PRESSURE for name in PROBES)
    mean = abs(r["contact_face_force_y"][-1]) / r["contact_face_length"][-1]
    scatter[points] = max(stresses[-1] - 1, 1 - stresses[0])
    spread[points] = max(high - 1, 1 - low)
    print(f"     {points}: point pressures {low:.5f} to {high:.5f}, stress below {stresses[0]:.5f} to "
          f"{stresses[-1]:.5f}, Uzawa passes {r['uzawa'][-1]:.0f}, Newton {r['newton'][-1]:.0f}, "
          f"smallest gap {r['contact_face_gap_min'][-1]:.2e}")
    check(f"mean pressure, {points} points", mean, PRESSURE, 1e-3)
    check(f"balance of the plates, {points} points", r["reaction_plate_y"][-1] / r["reaction_press_y"][-1], -1, 1e-9)
    check_between("tries of the step", r["tries"].max(), 1, 1)
    check_between("Uzawa passes", r["uzawa"][-1], 2, 15)
    check_between("Newton iterations of a pass", r["newton"][-1] / r["uzawa"][-1], 1, 8)
check_between("deviation of the stress below the surface, 2 points", scatter[2], 0, 1e-2)
check_between("scatter of the point pressures, 4 points", spread[4], 0, 0.05)
check_between("scatter of the point pressures, 4 points over 2 points", spread[4] / spread[2], 0, 0.5)

print("penalty over four decades, the multipliers converged")
reference = None
for penalty in ("1e6", "1e7", "1e8", "1e9", "1e10"):
    r = run(f"penalty_{penalty}", {**BASE, **TIGHT, "contact_face_penalty": penalty,
                                   "contact_face_penalty_increment": penalty, "contact_face_penalty_max": "1e12"})
    mean = abs(r["contact_face_force_y"][-1]) / r["contact_face_length"][-1]
    reference = reference or mean
    print(f"     eps {penalty}: Uzawa passes {r['uzawa'][-1]:.0f}, Newton {r['newton'][-1]:.0f}, tries "
          f"{r['tries'][-1]:.0f}, smallest gap {r['contact_face_gap_min'][-1]:.2e}")
    check(f"mean pressure at eps {penalty}", mean, reference, 1e-4)
    check_between(f"penetration at eps {penalty}", -r["contact_face_gap_min"][-1], -1, 1e-6)
    check_between(f"smallest pressure at eps {penalty}", r["contact_face_pressure_min"][-1], 0, PRESSURE)

print("the paper's tolerances: gap 0.01 (of a length of 1), stresses 1e-2, eps = 1e8 + 1e8 at every augmentation")
r = run("paper", {**BASE, "contact_face_penalty": "1e8", "contact_face_penalty_increment": "1e8",
                  "contact_face_penalty_max": "1e12", "contact_face_penalty_growth": "always",
                  "contact_face_gap_tol": 0.01, "contact_face_pressure_tol": 0.01})
mean = abs(r["contact_face_force_y"][-1]) / r["contact_face_length"][-1]
print(f"     Uzawa passes {r['uzawa'][-1]:.0f}, smallest gap {r['contact_face_gap_min'][-1]:.2e}")
check("mean pressure", mean, PRESSURE, 1e-2)
check_between("penetration", -r["contact_face_gap_min"][-1], -1, 0.01)
require("no multiplier is negative", r["contact_face_pressure_min"][-1] >= 0)

print("the automatic penalty is that of the bodies that touch, whatever lies elsewhere")
THREE = {"mesh": mesh("three_blocks.geo"), "materials": "b0,b1,b2", "material_b0_E": E, "material_b0_nu": NU, "material_b1_like": "b0",
         "material_b2_nu": NU, "bcs": "plate,press,aside", "bc_plate_on": "bottom0", "bc_plate_type": "fix", "bc_press_on": "top1", "bc_press_ux": 0,
         "bc_press_uy": "-0.1*t", "bc_aside_on": "bottom2", "bc_aside_type": "fix", "contacts": "face", "contact_face_secondary": "bottom1",
         "contact_face_primary": "top0", "contact_face_enforce": "penalty", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
soft, hard = (run(f"aside_{name}", {**THREE, "material_b2_E": modulus}) for name, modulus in (("soft", E * 1e-4), ("hard", E)))
for column in ("force_y", "gap_min"):
    check(f"a soft body aside: {column}", soft[f"contact_face_{column}"][-1], hard[f"contact_face_{column}"][-1], 1e-8)
finish()
