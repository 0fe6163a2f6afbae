# labels: run
# timeout: 300
# processors: 1
"""Plane stress against scalar solves of the three-dimensional law: uniaxial, equibiaxial and held stretches, simple shear,
uniaxial flow (C1), the damage of a homogeneous bar (D2), free thermal expansion; the thickness is part of the state."""
import math

import numpy
from _runs import check, check_between, finish, mesh, require, run

E, NU = 1000.0, 0.3
K, G = E / (3 * (1 - 2 * NU)), E / (2 * (1 + NU))


def principal(l):
    """Kirchhoff stresses of K/2 [(J^2-1)/2 - ln J] + G/2 (J^(-2/3) tr C - 3) at principal stretches."""
    J, trace = l[0] * l[1] * l[2], sum(x * x for x in l)
    return [K / 2 * (J * J - 1) + G * J ** (-2 / 3) * (x * x - trace / 3) for x in l]


def root(f, low, high):
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (low, middle) if f(middle) > 0 else (middle, high)
    return (low + high) / 2


def base(n=1, **more):
    """A unit block, its left and lower side on rollers; quadrilaterals, or triangles."""
    words = {
            "mesh": mesh("block.geo"), "mesh_set_n": n, "plane": "stress", "materials": "solid", "material_solid_E": E,
            "material_solid_nu": NU, "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0,
            "bc_pull_on": "right", "bc_pull_ux": "t", "ts_type": "static", "ts_dt": 0.25, "ts_max_time": 0.5,
            "motion_snes_rtol": 1e-13, "probes": "p", "probe_p_at": "0.4,0.3", "probe_p_fields": "u,stress", **more}
    given = words["bcs"].split(",")
    return {key: value for key, value in words.items() if not key.startswith("bc_") or key.split("_")[1] in given}


for simplex in (0, 1):
    for a in (1.5, 0.7):  # uniaxial: both lateral stretches are free
        r = run(f"uniaxial_{simplex}_{a}", base(2, mesh_set_simplex=simplex, bc_pull_ux=f"{a - 1!r}*t", ts_max_time=1))
        lateral = root(lambda x: principal((a, x, x))[1], 0.5, 1.5)
        stress = principal((a, lateral, lateral))[0]
        check(f"uniaxial {a}: force", r["reaction_pull_x"][-1], stress / a, 1e-9)
        check(f"uniaxial {a}: lateral stretch", 1 + r["probe_p_uy"][-1] / 0.3, lateral, 1e-9)
        check(f"uniaxial {a}: Cauchy stress", r["probe_p_stress_xx"][-1], stress / (a * lateral**2), 1e-9)
        for component in ("yy", "zz", "xy"):
            check(f"uniaxial {a}: stress {component}", r[f"probe_p_stress_{component}"][-1] / stress, 0, 1e-9, relative=False)
a = 1.4
r = run("biaxial", base(bcs="x,y,pull,up", bc_pull_ux="0.4*t", bc_up_on="top", bc_up_uy="0.4*t", ts_max_time=1))
across = root(lambda x: principal((a, a, x))[2], 0.1, 1)
check("equibiaxial: force", r["reaction_pull_x"][-1], principal((a, a, across))[0] / a, 1e-9)
check("equibiaxial: force of the other side", r["reaction_up_y"][-1], principal((a, a, across))[1] / a, 1e-9)
check("equibiaxial: energy", r["energy_elastic"][-1],
      K / 2 * ((a**4 * across**2 - 1) / 2 - math.log(a * a * across)) + G / 2 * ((a * a * across) ** (-2 / 3) * (2 * a * a + across**2) - 3), 1e-9)
shear = 0.6
r = run("shear", base(bcs="rim", bc_rim_on="left,right,top,bottom", bc_rim_ux=f"{shear}*y*t", bc_rim_uy=0, ts_max_time=1))
# C = [[1, g], [g, 1 + g^2]] in the plane, det 1: principal stretches a, 1/a with a - 1/a = g; J = F_33.
a = (shear + math.sqrt(shear**2 + 4)) / 2
across = root(lambda x: principal((a, 1 / a, x))[2], 0.5, 1.5)
check("simple shear: stress", r["probe_p_stress_xy"][-1], G * across ** (-2 / 3) * shear / across, 1e-9)
check("simple shear: no stress across", r["probe_p_stress_zz"][-1] / G, 0, 1e-11, relative=False)
for plane, modulus in (("stress", E / (1 - NU**2)), ("strain", E * (1 - NU) / ((1 + NU) * (1 - 2 * NU)))):
    r = run(f"held_{plane}", base(bcs="x,sides,pull", bc_sides_on="bottom,top", bc_sides_uy=0, bc_pull_ux="1e-7*t",
                                  ts_max_time=1, plane=plane))
    check(f"held sideways, plane {plane}: modulus at small strain", r["reaction_pull_x"][-1] / 1e-7, modulus, 1e-6)

# C1: uniaxial flow of the paper's aluminium, 200 steps to a stretch of 1.2; the quadrature of the flow rule has no steps.
VOCE = {"units": "mm_t_s_MPa", "material_solid_model": "j2", "material_solid_E": "72 GPa", "material_solid_nu": 0.33,
        "material_solid_sigma_y": "368 MPa", "material_solid_hardening": "voce", "material_solid_voce_r": "78 MPa",
        "material_solid_voce_s": 32}
flow = {steps: run(f"c1_{steps}", base(**VOCE, ts_dt=0.2 / steps, ts_max_time=0.2, motion_snes_rtol=1e-10))
        for steps in (100, 200)}
require("C1: no step was cut", all(len(r["step"]) == steps + 1 for steps, r in flow.items()))
for stretch, sigma, alpha in ((1.02, 396.0151, 0.01437278), (1.05, 425.5033, 0.04309682), (1.10, 440.6550, 0.08965515),
                              (1.20, 444.7950, 0.17708508)):
    fine, coarse = flow[200], flow[100]
    i, j = round((stretch - 1) * 1000), round((stretch - 1) * 500)
    check(f"C1 stretch {stretch}: Cauchy stress", fine["probe_p_stress_xx"][i], sigma, 2e-4)
    check(f"C1 stretch {stretch}: Cauchy stress, extrapolated", 2 * fine["probe_p_stress_xx"][i] -
          coarse["probe_p_stress_xx"][j], sigma, 5e-6)
    check(f"C1 stretch {stretch}: plastic strain, extrapolated", 2 * fine["alpha_max"][i] - coarse["alpha_max"][j], alpha, 5e-6,
          relative=False)

# D2: a homogeneous bar of AT2, rate-independent: phi = 2 psi l/(G_c + 2 psi l) with psi = E eps^2/2, small strains.
GC, L = 1e-6, 0.01
top = math.sqrt(GC / (3 * E * L))
r = run("d2", base(material_solid_damage="at2", material_solid_Gc=GC, material_solid_gamma=L, material_solid_split="none",
                   material_solid_residual_stiffness=0, bc_pull_ux=f"{top!r}*t", ts_dt=0.05, ts_max_time=2,
                   coupling_snes_max_it=400, coupling_snes_atol=1e-10))
strain = top * r["time"][1:]
phi = 2 * (E * strain**2 / 2) * L / (GC + 2 * (E * strain**2 / 2) * L)
check("D2: stress at every step", abs(r["reaction_pull_x"][1:] / ((1 - phi) ** 2 * E * strain) - 1).max(), 0, 2e-3, relative=False)
check("D2: damage at every step", abs(r["phi_max"][1:] - phi).max(), 0, 1e-3, relative=False)
check("D2: strength 9/16 sqrt(E G_c/(3 l))", r["reaction_pull_x"].max(), 9 / 16 * math.sqrt(E * GC / (3 * L)), 2e-3)

# A sheet that is warmed as a whole expands without stress, its thickness too.
WARM = {"material_solid_c_v": 2, "material_solid_alpha_t": 1e-3, "material_solid_conductivity": 1, "material_solid_theta0": 300}
r = run("free", base(bcs="x,y,warm", **WARM, bc_warm_on="solid", bc_warm_type="temperature", bc_warm_value="300+80*t",
                     coupling_snes_max_it=20, coupling_snes_atol=1e-13, ts_max_time=1))
check("free expansion: stretch", 1 + r["probe_p_ux"][-1] / 0.4, math.exp(1e-3 * 80), 1e-9)
for component in ("xx", "yy", "zz", "xy"):
    check(f"free expansion: stress {component}", r[f"probe_p_stress_{component}"][-1] / E, 0, 1e-9, relative=False)

# Everything at once: flow, damage, viscosity, heat, inertia. First law of the energy form, ranks, restart.
ALL = base(4, **{**WARM, "material_solid_alpha_t": 1e-4}, material_solid_model="j2", material_solid_sigma_y=20, material_solid_hardening="linear",
           material_solid_linear_h=50, material_solid_damage="at2", material_solid_Gc=1, material_solid_gamma=0.3,
           material_solid_b_d=0.05, material_solid_rho=1e-3, heat_form="energy", heat_snes_rtol=1e-13, thickness=0.7,
           bc_pull_ux="0.2*t*t", ts_type="newmark", ts_dt=0.02, ts_max_time=0.4, motion_snes_rtol=1e-12,
           bcs="x,y,pull,hold", bc_hold_on="right", bc_hold_uy=0)
one = run("all_1", {**ALL, "checkpoint_every": 7})
require("flows, breaks and cools in dilation",
        one["alpha_max"][-1] > 0.005 and one["phi_max"][-1] > 0.1 and one["theta_max"][-1] < 299.9)
check("first law of the energy form", abs(one["balance_first_law"]).max(), 0, 1e-8, relative=False)
more = run("all_2", ALL, ranks=2)
for column in ("energy_elastic", "energy_thermal", "reaction_pull_x", "alpha_max"):
    check(f"2 ranks: {column}", abs(more[column] - one[column]).max() / abs(one[column]).max(), 0, 1e-9, relative=False)
again = run("all_1", {**ALL, "checkpoint_every": 7, "restart": "all_1/checkpoints/checkpoint_000002.h5"})
require("restart: the same to the last digit",
        "resumed from" in again.log and all(
            numpy.array_equal(again[column], one[column], equal_nan=True) for column in one.history))
viscous = run("viscous", base(material_solid_b_d=5, bc_pull_ux="0.1*t", ts_dt=0.1, ts_max_time=1))
elastic = run("elastic", base(bc_pull_ux="0.1*t", ts_dt=0.1, ts_max_time=1))
# Of an incompressible rate 4 b_d eps' in plane strain; here sigma = 2 b_d (2 eps'_x + ...): more than without, and paid for.
check_between("viscosity resists", viscous["reaction_pull_x"][5] - elastic["reaction_pull_x"][5], 1, 4)
check("viscosity: work is energy and loss", abs(viscous["work_external"] - viscous["energy_elastic"] -
      viscous["dissipated_viscous"]).max() / viscous["work_external"][-1], 0, 5e-3, relative=False)

for name, change, text in (
        ("locking", {"material_solid_model": "j2", "material_solid_sigma_y": 1, "material_solid_hardening": "none",
                     "material_solid_locking": "mean"}, "-material_solid_locking \"mean\": has no meaning"),
        ("space", {"mesh_set_dim": 3}, "-plane \"stress\": the mesh has dimension 3"),
        ("thick", {"mesh_set_dim": 3, "plane": "strain", "thickness": 2}, "-thickness \"2\": the mesh has dimension 3"),
        ("time", {"material_solid_E_factor": "1+t"}, "-material_solid_E_factor \"1+t\": does not change with t")):
    r = run(f"refused_{name}", base(**change), code=None)
    require(f"refused, {name}: exit {r.code}, one line that names the option",
            r.code in (2, 3) and sum(text in line for line in r.log.splitlines()) == 1)
finish()
