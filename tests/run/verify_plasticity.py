# Plasticity: uniaxial tension with Voce hardening (C1) and a thick tube (C9).
# labels: run
# timeout: 120
import math

import _runs as runs

# C1: tetrahedra stretched to 1.2 in 400 steps, aluminium of the paper. The reference is a quadrature of the flow rule
# of eqs. 64-69 with det b_e = 1 (no time step in it).
ALUMINIUM = {"material_solid_model": "j2", "material_solid_E": "72 GPa", "material_solid_nu": 0.33,
             "material_solid_sigma_y": "368 MPa", "material_solid_hardening": "voce", "material_solid_voce_r": "78 MPa",
             "material_solid_voce_s": 32}


def tension(steps):
    return runs.run(f"c1_{steps}", {
        "ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_dim": 3,
        "mesh_set_simplex": 1, "mesh_set_n": 1, "materials": "solid", **ALUMINIUM, "bcs": "x,y,z,pull",
        "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_z_on": "back", "bc_z_uz": 0,
        "bc_pull_on": "right", "bc_pull_ux": "t", "ts_dt": 0.2 / steps, "ts_max_time": 0.2, "probes": "p",
        "probe_p_at": "0.4,0.3,0.35", "probe_p_fields": "stress,alpha", "motion_snes_rtol": 1e-10})


half, run = tension(200), tension(400)
runs.require("C1: no step was cut", len(run["step"]) == 401 and len(half["step"]) == 201)
for stretch, sigma, alpha in ((1.02, 396.0151, 0.01437278), (1.05, 425.5033, 0.04309682), (1.10, 440.6550, 0.08965515),
                              (1.20, 444.7950, 0.17708508)):
    last, coarse = round((stretch - 1) * 2000), round((stretch - 1) * 1000)
    runs.check(f"C1 stretch {stretch}: Cauchy stress", run["probe_p_stress_xx"][last], sigma, 1e-4)
    runs.check(f"C1 stretch {stretch}: plastic strain", run["alpha_max"][last], alpha, 5e-5, relative=False)
    # Backward Euler is first order: the extrapolation of 200 and 400 steps is the limit.
    runs.check(f"C1 stretch {stretch}: plastic strain, extrapolated", 2 * run["alpha_max"][last] -
               half["alpha_max"][coarse], alpha, 2e-6, relative=False)
    runs.check(f"C1 stretch {stretch}: Cauchy stress, extrapolated", 2 * run["probe_p_stress_xx"][last] -
               half["probe_p_stress_xx"][coarse], sigma, 2e-6)
force = run["reaction_pull_x"]
runs.check("C1 largest nominal stress (Considere)", max(force), 407.097, 1e-4)
runs.check("C1 stretch at the largest nominal stress", 1 + run["time"][force.argmax()], 1.0622, 1e-3)
# An exponential map of the total strain (alpha = ln of the plastic stretch) would give 5942.96 N on 16 mm^2.
runs.check("C1 force at the stretch 1.2 on 16 mm^2, extrapolated", 16 * (2 * force[-1] - half["reaction_pull_x"][-1]),
           5943.07, 5e-6)

# C9: a tube of radii 10 and 20 in plane strain is widened to the bore radius 15. Rigid-plastic:
# p = 2 sy / sqrt(3) ln(b / a) with the current radii; elastic strains are of the order sy / G = 1.3e-4.
A, B, SY = 10.0, 20.0, 0.5
with open("tube.geo", "w") as file:
    file.write("""Point(1) = {10, 0, 0}; Point(2) = {20, 0, 0}; Point(3) = {20, 1, 0}; Point(4) = {10, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 21; Transfinite Curve {2, 4} = 2; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("tube") = {1}; Physical Curve("bore") = {4}; Physical Curve("flat") = {1, 3};
""")
run = runs.run("c9", {
    "ts_type": "static", "units": "mm_t_s_MPa", "mesh": "tube.geo", "plane": "axisymmetric", "materials": "tube",
    "material_tube_model": "j2", "material_tube_K": 40000, "material_tube_G": 3800, "material_tube_sigma_y": SY,
    "material_tube_hardening": "none", "bcs": "flat,push", "bc_flat_on": "tube", "bc_flat_uy": 0, "bc_push_on": "bore",
    "bc_push_ux": "t", "ts_dt": 0.05, "ts_max_time": 5})
for a in (10.2, 12, 15):
    last = min(range(len(run["time"])), key=lambda i: abs(run["time"][i] - (a - A)))
    pressure = abs(run["reaction_push_x"][last]) / (2 * math.pi * a)
    reference = 2 / math.sqrt(3) * math.log(math.sqrt(B * B + a * a - A * A) / a)
    runs.check(f"C9 bore radius {a}: pressure / yield stress", pressure / SY, reference, 0.01)
for a, table in ((10, 0.80038), (12, 0.65010), (15, 0.48919)):
    formula = 2 / math.sqrt(3) * math.log(math.sqrt(B * B + a * a - A * A) / a)
    runs.check(f"C9 the formula has the table's value at {a}", formula, table, 2e-5)
runs.finish()
