# labels: run
# timeout: 120
# long: 200
"""Bodies that hardly change their volume take large steps at their first try (SoftVolume): a bonded bush whose core turns by a
radian, against the closed form of azimuthal shear, and is pushed aside by half the thickness, against the same in steps that
Newton's method takes without stages."""
from math import cos, log, pi, sin

from _runs import check, check_between, finish, long, mesh, require, run

E, NU, TURN = 3e6, 0.49999, 1.0
G = E / (2 * (1 + NU))
BUSH = {"mesh": mesh("bush.geo"), "materials": "bush", "material_bush_E": E, "material_bush_nu": NU,
        "bcs": "hold,core", "bc_hold_on": "outside", "bc_hold_type": "fix", "bc_core_on": "inside", "ts_type": "static", "ts_max_time": 1}
TURNED = {"bc_core_ux": f"cos({TURN}*t)*x-sin({TURN}*t)*y-x", "bc_core_uy": f"sin({TURN}*t)*x+cos({TURN}*t)*y-y"}
ASIDE = {"mesh_set_n": 12 if long() else 8, "bc_core_ux": "0.5*t", "bc_core_uy": 0}


def bush(name, steps, options, flat=True, **more):
    r = run(name, {**BUSH, **({"plane": "strain"} if flat else {}), "ts_dt": 1 / steps, **options}, **more)
    require(f"{name}: {len(r['time']) - 1} steps, {r['tries'].max():.0f} tries at most", len(r["time"]) == steps + 1)
    check(f"{name}: each step at its first try", r["tries"].max(), 1, 0)
    return r


# A circle of radius r turns by M (1/r^2 - 1/b^2)/(4 pi G), whatever the angle, and nothing changes its volume.
energy = 2 * pi * G * TURN**2 / (1 - 1 / 4)
errors = []
for n in (12, 24):
    r = bush(f"turned_{n}", 4, {**TURNED, "mesh_set_n": n})
    errors.append(r["energy_elastic"][-1] / energy - 1)
    check(f"energy of the bush turned by a radian, {n} cells", r["energy_elastic"][-1], energy, 2e-2)
check_between("error of the one over the other", errors[0] / errors[1], 3.5, 4.5)

steps = 10
whole = bush("aside", steps, ASIDE)
check_between("iterations to push the core aside, K/G of 5e4", whole["newton"].sum(), 1, 25 * steps)
if long():
    small = bush("aside_small", 100, ASIDE)
    check("energy against small steps", whole["energy_elastic"][-1], small["energy_elastic"][-1], 1e-9)
    check("force against small steps", whole["reaction_core_x"][-1], small["reaction_core_x"][-1], 1e-8)
check("energy on two ranks", bush("aside_ranks", steps, ASIDE, ranks=2)["energy_elastic"][-1], whole["energy_elastic"][-1], 1e-10)
bush("half", 5, {**ASIDE, "ts_dt": 0.1, "ts_max_steps": 5})
again = run("half", {**BUSH, **ASIDE, "plane": "strain", "ts_dt": 0.1, "ts_max_steps": 100, "restart": "auto"})
check("energy after a restart", again["energy_elastic"][-1], whole["energy_elastic"][-1], 0)

# Patches of triangles and of tetrahedra, hexahedra.
bush("triangles", 4, {**ASIDE, "mesh_set_simplices": 1, "bc_core_ux": "0.4*t"})
SPACE = {"mesh_set_length": 0.5, "mesh_set_n": 4, "mesh_set_n_long": 2, "bcs": "hold,core,ends", "bc_ends_on": "ends",
         "bc_ends_uz": 0, "bc_core_uz": 0, "bc_core_ux": "0.4*t"}
plane = bush("plane", 4, {**ASIDE, "mesh_set_n": 4, "bc_core_ux": "0.4*t"})
space = bush("space", 4, {**ASIDE, **SPACE}, flat=False)
check("hexahedra between planes bear what quadrilaterals do", space["energy_elastic"][-1], 0.5 * plane["energy_elastic"][-1], 1e-8)
bush("tetrahedra", 4, {**ASIDE, **SPACE, "mesh_set_simplices": 1, "bc_core_ux": "0.3*t"}, flat=False)

# Those of second order by the mean volume of a cell, their default here: 6 and 18 % too stiff without.
r = bush("triangles_2", 4, {**TURNED, "mesh_set_n": 6, "mesh_set_simplices": 1, "order": 2})
check("energy of the bush turned by a radian, triangles of second order", r["energy_elastic"][-1], energy, 2e-3)
if long():
    r = run("tetrahedra_2", {**BUSH, **SPACE, **TURNED, "mesh_set_simplices": 1, "order": 2, "ts_dt": 0.125, "mesh_set_n_long": 2})
    check("the same, tetrahedra of second order", r["energy_elastic"][-1], 0.5 * energy, 1e-2)

# What flows keeps its volume: a bar whose ends are held is pulled by 4 or 10 % in its first step, F = A (sigma_y + H ln s)/s.
BAR = {"mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_lx": 30, "mesh_set_ly": 3, "mesh_set_lz": 3, "mesh_set_n": 60, "mesh_set_ny": 6,
       "mesh_set_nz": 6, "materials": "bar", "material_bar_region": "solid", "material_bar_model": "j2", "material_bar_E": 200e9, "material_bar_nu": 0.3,
       "material_bar_sigma_y": 300e6, "material_bar_hardening": "linear", "material_bar_linear_h": 400e6, "bcs": "left,bottom,back,pull",
       "bc_left_on": "left", "bc_left_ux": 0, "bc_bottom_on": "bottom", "bc_bottom_uy": 0, "bc_back_on": "back", "bc_back_uz": 0,
       "bc_pull_on": "right", "bc_pull_ux": "12*t", "bc_pull_uy": 0, "bc_pull_uz": 0, "ts_type": "static", "ts_max_steps": 1, "ts_max_time": 1,
       "energy_tol": 0, "energy_stop": 0}
for dt in (0.1, 0.25) if long() else (0.25,):
    r = run(f"bar_{dt}", {**BAR, "ts_dt": dt})
    stretch = 1 + 12 * dt / 30
    check(f"bar stretched to {stretch} in a step, its tries", r["tries"].max(), 1, 0)
    check("its force", r["reaction_pull_x"][-1], 9 * (300e6 + 400e6 * log(stretch)) / stretch, 0.01)
    check_between("its Newton iterations, in all stages", r["newton"][-1], 1, 40)

# A cantilever under a split by principal stretches: without a cure it bore four times as much.
CANTILEVER = {"mesh": mesh("block.geo"), "mesh_set_n": 24, "mesh_set_ny": 6, "mesh_set_lx": 4, "units": "mm_t_s_MPa", "materials": "solid",
              "material_solid_E": 1000, "material_solid_nu": 0.499, "material_solid_damage": "at2", "material_solid_Gc": 0.3,
              "material_solid_gamma": 0.5, "material_solid_split": "spectral", "bcs": "left,right", "bc_left_on": "left",
              "bc_left_type": "fix", "bc_right_on": "right", "bc_right_uy": "0.1*t", "ts_type": "static", "ts_dt": 0.25, "ts_max_time": 1}
first, second = (run(f"cantilever_{order}", {**CANTILEVER, "order": order})["reaction_right_y"][-1] for order in (1, 2))
check("force on a cantilever with a spectral split, quadrilaterals of first over those of second order", first / second, 1, 0.03)
finish()
