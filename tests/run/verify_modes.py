# Homogeneous modes (A7) and rotations (A2) of elastic and plastic bodies against closed forms.
# labels: run
# timeout: 180
# long: 200
import math

import _runs as runs

E, NU = 210e3, 0.3
G, K = E / 2 / (1 + NU), E / 3 / (1 - 2 * NU)
ELASTIC = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "materials": "solid",
           "material_solid_E": E, "material_solid_nu": NU, "motion_snes_rtol": 1e-13, "motion_snes_atol": 1e-8,
           "ts_dt": 0.25, "ts_max_time": 1}
CELLS = {"one quadrilateral": {"mesh_set_n": 1}, "triangles": {"mesh_set_n": 3, "mesh_set_simplex": 1},
         "one hexahedron": {"mesh_set_dim": 3, "mesh_set_n": 1},
         "tetrahedra": {"mesh_set_dim": 3, "mesh_set_simplex": 1, "mesh_set_n": 2}}


def in_space(cells):
    return "mesh_set_dim" in CELLS[cells]


def at_middle(cells, fields):
    return {"probes": "p", "probe_p_at": "0.4,0.3,0.35" if in_space(cells) else "0.4,0.3", "probe_p_fields": fields}


def stress(F):
    """Cauchy stress of a principal or shear state F (3x3) of the compressible neo-Hookean law."""
    b = [[sum(F[i][k] * F[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    J = (F[0][0] * F[1][1] - F[0][1] * F[1][0]) * F[2][2]
    mean = (b[0][0] + b[1][1] + b[2][2]) / 3
    return [[(G * J ** (-2 / 3) * (b[i][j] - (mean if i == j else 0)) + (K / 2 * (J * J - 1) if i == j else 0)) / J
             for j in range(3)] for i in range(3)]


def root(f, low, high):
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if f(middle) * f(low) > 0 else (low, middle)
    return (low + high) / 2


def diagonal(*stretch):
    return [[stretch[i] if i == j else 0 for j in range(3)] for i in range(3)]


# A7: simple shear of 0.5 by the displacement of the whole boundary: tau_12 = G gamma, tau_11 - tau_22 = G gamma^2.
for cells, mesh in CELLS.items():
    sides = "left,right,bottom,top" + (",back,front" if in_space(cells) else "")
    held = {"bc_hull_ux": "0.5*t*y", "bc_hull_uy": 0, **({"bc_hull_uz": 0} if in_space(cells) else {})}
    run = runs.run(f"shear_{cells.replace(' ', '_')}", {**ELASTIC, **mesh, "bcs": "hull", "bc_hull_on": sides, **held,
                                                       **at_middle(cells, "stress")})
    runs.check(f"A7 simple shear, {cells}: shear stress / G", run["probe_p_stress_xy"][-1] / G, 0.5, 1e-10)
    runs.check(f"A7 simple shear, {cells}: normal stress difference / G",
               (run["probe_p_stress_xx"][-1] - run["probe_p_stress_yy"][-1]) / G, 0.25, 1e-10)

# A7: stretched by 20 % with free sides.
PLANES = {"bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right",
          "bc_pull_ux": "0.2*t"}
for cells, mesh in CELLS.items():
    options = {**ELASTIC, **mesh, **PLANES, **at_middle(cells, "stress")}
    if in_space(cells):
        options.update({"bcs": "x,y,z,pull", "bc_z_on": "back", "bc_z_uz": 0})
        lateral = root(lambda s: stress(diagonal(1.2, s, s))[1][1], 0.5, 1.2)
        F, kind = diagonal(1.2, lateral, lateral), "uniaxial stress"
    else:
        lateral = root(lambda s: stress(diagonal(1.2, s, 1))[1][1], 0.5, 1.2)
        F, kind = diagonal(1.2, lateral, 1), "plane strain tension"
    run = runs.run(f"tension_{cells.replace(' ', '_')}", options)
    runs.check(f"A7 {kind}, {cells}: Cauchy stress", run["probe_p_stress_xx"][-1], stress(F)[0][0], 1e-9)
    area = lateral * (lateral if in_space(cells) else 1)
    runs.check(f"A7 {kind}, {cells}: force", run["reaction_pull_x"][-1], stress(F)[0][0] * area, 1e-9)

# A7: equibiaxial stretch of 15 %.
thickness = root(lambda s: stress(diagonal(1.15, 1.15, s))[2][2], 0.5, 1.2)
run = runs.run("biaxial", {**ELASTIC, **CELLS["tetrahedra"], **at_middle("tetrahedra", "stress"), **PLANES,
                           "bcs": "x,y,z,pull,lift", "bc_z_on": "back", "bc_z_uz": 0, "bc_pull_ux": "0.15*t",
                           "bc_lift_on": "top", "bc_lift_uy": "0.15*t"})
runs.check("A7 equibiaxial stretch, tetrahedra: Cauchy stress", run["probe_p_stress_yy"][-1],
           stress(diagonal(1.15, 1.15, thickness))[1][1], 1e-9)

# A2: an unstressed body is turned by 90 degrees in 10 steps by its left side alone.
TURN = {"bc_left_ux": "(cos(pi/2*t)-1)*x-sin(pi/2*t)*y", "bc_left_uy": "sin(pi/2*t)*x+(cos(pi/2*t)-1)*y"}
for cells, mesh in CELLS.items():
    options = {**ELASTIC, **mesh, "mesh_set_n": 2, "bcs": "left", "bc_left_on": "left", **TURN, "ts_dt": 0.1,
               **at_middle(cells, "stress,u")}
    if in_space(cells):
        options["bc_left_uz"] = 0
    run = runs.run(f"turn_{cells.replace(' ', '_')}", options)
    runs.require(f"A2 {cells}: 10 steps, none cut", len(run["step"]) == 11 and max(run["tries"][1:]) == 1)
    largest = max(abs(run[c]).max() for c in run.history if "_stress_" in c)
    runs.check(f"A2 turned by 90 degrees, {cells}: largest stress / E", largest / E, 0, 1e-10, relative=False)
    runs.check(f"A2 turned by 90 degrees, {cells}: u_x of the point", run["probe_p_ux"][-1], -0.3 - 0.4, 1e-9)

# A2: stretched by 10 % and turned; the sides left and right move with the stretched body. Stress invariants, energy and
# plastic strain stay what they are.
ANGLE, STRETCH = "pi/2*ramp(t,1,2)", "1+0.1*ramp(t,0,1)"
STRETCH_AND_TURN = {"bc_ends_ux": f"cos({ANGLE})*x*({STRETCH})-sin({ANGLE})*y-x",
                    "bc_ends_uy": f"sin({ANGLE})*x*({STRETCH})+cos({ANGLE})*y-y"}
for model in ("elastic", "j2") if runs.long() else ("j2",):
    for cells, mesh in CELLS.items():
        options = {**ELASTIC, **mesh, "mesh_set_n": 2, "bcs": "ends", "bc_ends_on": "left,right", "ts_max_time": 2,
                   "ts_dt": 0.1, "material_solid_model": model, **STRETCH_AND_TURN,
                   **at_middle(cells, "von_mises,pressure,alpha")}
        if in_space(cells):
            options["bc_ends_uz"] = 0
        if model == "j2":
            options.update({"material_solid_sigma_y": 400, "material_solid_hardening": "linear",
                            "material_solid_linear_h": 1000})
        run = runs.run(f"stretch_turn_{model}_{cells.replace(' ', '_')}", options, refused=9)
        middle = min(range(len(run["time"])), key=lambda i: abs(run["time"][i] - 1))
        for column in ("probe_p_von_mises", "probe_p_pressure", "energy_elastic"):
            runs.check(f"A2 stretched, then turned, {model}, {cells}: {column}", run[column][-1], run[column][middle],
                       1e-10)
        if model == "j2":
            runs.check_between(f"A2 {cells}: plastic strain of the stretch", run["alpha_max"][middle], 0.05, 0.5)
            runs.check(f"A2 stretched, then turned, {cells}: plastic strain", run["alpha_max"][-1],
                       run["alpha_max"][middle], 1e-12, relative=False)
runs.finish()
