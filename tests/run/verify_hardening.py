# Hardening, thermal softening and rate: the flow curve of Johnson and Cook at a rate and a temperature, a table against the
# law that it was sampled from, an adiabatic bar with linear softening against its closed form, the first law.
# labels: run
# timeout: 120
import math

import numpy

import _runs as runs

BAR = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 1,
       "materials": "solid", "material_solid_model": "j2", "bcs": "x,y,z,pull", "bc_x_on": "left", "bc_x_ux": 0,
       "bc_y_on": "bottom", "bc_y_uy": 0, "bc_z_on": "back", "bc_z_uz": 0, "bc_pull_on": "right", "motion_snes_rtol": 1e-12,
       "probes": "p", "probe_p_at": "1,1,1", "probe_p_fields": "u,stress"}
# Steel 42CrMo4 (T* counts from 20 C to 1540 C).
E, NU, A, B, N, C, RATE_0, M, REF, MELT = 206e3, 0.3, 806, 614, 0.168, 0.0089, 1, 1.1, 293.15, 1813.15
STEEL = {"material_solid_E": E, "material_solid_nu": NU, "material_solid_hardening": "johnson_cook",
         "material_solid_jc_a": A, "material_solid_jc_b": B, "material_solid_jc_n": N, "material_solid_jc_c": C,
         "material_solid_jc_rate0": RATE_0, "material_solid_jc_m": M, "material_solid_jc_theta_melt": MELT,
         "material_solid_jc_theta_ref": REF}


def johnson_cook(alpha, rate, theta):
    warm = min(1, max(0, (theta - REF) / (MELT - REF)))
    return (A + B * alpha**N) * (1 + C * math.log(max(rate / RATE_0, 1))) * (1 - warm**M)


# One cell pulled at a constant rate in a warm room: J sigma = k(alpha, d alpha/dt, theta) in every step that flows.
for rate, theta in ((1e3, 600), (0.5, 900), (1e5, 250)):
    run = runs.run("curve", {**BAR, **STEEL, "material_solid_theta0": theta, "bc_pull_ux": f"exp({rate}*t)-1",
                             "ts_dt": 0.004 / rate, "ts_max_time": 0.12 / rate})
    alpha, time = run["alpha_max"], run["time"]
    J = (1 + run["probe_p_ux"]) * (1 + run["probe_p_uy"]) * (1 + run["probe_p_uz"])
    worst = max(abs(J[i] * run["probe_p_stress_xx"][i] / johnson_cook(
        alpha[i], (alpha[i] - alpha[i - 1]) / (time[i] - time[i - 1]), theta) - 1) for i in range(4, len(time)))
    runs.check(f"Johnson-Cook at {rate:g}/s, {theta} K: largest error of the flow stress", worst, 0, 1e-9, relative=False)
    runs.require(f"Johnson-Cook at {rate:g}/s, {theta} K: the bar flows", alpha[-1] > 0.1)

# A table of the Voce law: as far from it as straight lines of this length are, r (s h)^2 / 8 below.
VOCE = {"material_solid_E": 72e3, "material_solid_nu": 0.33, "material_solid_sigma_y": 368,
        "material_solid_hardening": "voce", "material_solid_voce_r": 78, "material_solid_voce_s": 32}
PULL = {"bc_pull_ux": "t", "ts_dt": 0.01, "ts_max_time": 0.1}
SPACING = 0.002
with open("voce.csv", "w") as file:
    file.write("alpha, k in MPa\n")
    for i in range(101):
        file.write(f"{i * SPACING:.6g}, {368 - 78 * math.expm1(-32 * i * SPACING):.15g}\n")
law = runs.run("voce", {**BAR, **VOCE, **PULL})
table = runs.run("table", {**BAR, "material_solid_E": 72e3, "material_solid_nu": 0.33, **PULL,
                           "material_solid_hardening": "table", "material_solid_hardening_table": "voce.csv"})
below = (law["reaction_pull_x"] - table["reaction_pull_x"])[1:]
runs.check_between("table of Voce: largest force too small / bound of the chords", below.max() / (78 * (32 * SPACING)**2 / 8),
                   0.05, 1)
runs.require("table of Voce: never above the law", below.min() > -1e-9)

# An insulated bar with k = k_0(alpha) (1 - w (theta - theta_0)), without expansion. By the flow rule (67') and
# c_V d theta = chi k d alpha, with x the elastic isochoric stretch along the bar:
#   1 - w (theta - theta_0) = exp(-w chi H_0/c_V), G (x^2 - 1/x) = k, K (J^2 - 1)/2 = k/3,
#   d ln(stretch) = d ln x + d ln J/3 + (x^3 + 2)/(2 x^3 + 1) d alpha
W, CHI, CV = 2e-3, 0.9, 2.43
G, K = 72e3 / 2 / 1.33, 72e3 / 3 / 0.34


def adiabatic(alpha):
    work = 446 * alpha + 78 * numpy.expm1(-32 * alpha) / 32
    soft = numpy.exp(-W * CHI * work / CV)
    k = (368 - 78 * numpy.expm1(-32 * alpha)) * soft
    x = numpy.ones_like(alpha)
    for _ in range(30):
        x -= (G * (x**2 - 1 / x) - k) / (G * (2 * x + 1 / x**2))
    J = numpy.sqrt(1 + 2 * k / 3 / K)
    middle = 0.5 * (x[1:] + x[:-1])
    along = numpy.concatenate(([0], numpy.cumsum((middle**3 + 2) / (2 * middle**3 + 1) * numpy.diff(alpha))))
    return numpy.log(x) + numpy.log(J) / 3 + along, k / J, 298.15 - numpy.expm1(-W * CHI * work / CV) / W


STRETCH = 1.5
strain, stress, theta = adiabatic(numpy.linspace(0, 0.45, 20001))
exact = [numpy.interp(math.log(STRETCH), strain, values) for values in (stress, theta, numpy.linspace(0, 0.45, 20001))]


def bar(steps, **more):
    return runs.run(f"bar_{steps}", {
        **BAR, **VOCE, "material_solid_softening": "linear", "material_solid_softening_w": W,
        "material_solid_taylor_quinney": CHI, "material_solid_c_v": CV, "bc_pull_ux": f"{STRETCH - 1}*t",
        "ts_dt": 1 / steps, "ts_max_time": 1, "coupling_snes_atol": 1e-12, **more})


coarse, fine = bar(60), bar(120)
for name, column, reference in (("stress", "probe_p_stress_xx", exact[0]), ("temperature", "theta_max", exact[1]),
                                ("plastic strain", "alpha_max", exact[2])):
    error = [run[column][-1] / reference - 1 for run in (coarse, fine)]
    runs.check(f"insulated softening bar, {name}, 120 steps", fine[column][-1], reference, 3e-3)
    runs.check(f"insulated softening bar, {name}, order", math.log2(error[0] / error[1]), 1, 0.15)
    runs.check(f"insulated softening bar, {name}, extrapolated", 2 * error[1] - error[0], 0, 3e-5, relative=False)
runs.check_between("stress / that of the cold bar", coarse["probe_p_stress_xx"][-1] / 446, 0.85, 0.9)

# What is stored and what becomes heat: (1 - chi) and chi of the plastic work at rest, all that the rate adds is heat. The
# energy form keeps the first law to rounding whatever softens.
WARM = {**BAR, **STEEL, "material_solid_c_v": 3.6018, "material_solid_theta0": 293.15, "material_solid_alpha_t": 1.2e-5,
        "material_solid_rho": 7.83e-9, "ts_type": "newmark", "heat_form": "energy", "heat_snes_rtol": 1e-13, "heat_ksp_rtol": 1e-13,
        "bc_pull_ux": "1e5*t*t/(t+1e-6)", "ts_dt": 1e-7, "ts_max_time": 5e-6, "coupling_snes_max_it": 1, "motion_snes_rtol": 1e-15, "motion_snes_atol": 1e-11}
run = runs.run("first_law", WARM)
runs.check("first law with Johnson-Cook, inertia, one pass: missed / work", abs(run["balance_first_law"]).max(), 0, 1e-12,
           relative=False)
runs.require("first law: the bar softens", run["theta_max"][-1] > 330 and run["alpha_max"][-1] > 0.2)
slow = runs.run("stored", {**BAR, **STEEL, "material_solid_c_v": 3.6018, "material_solid_theta0": 293.15,
                           "bc_pull_ux": "0.3*t", "ts_dt": 0.02, "ts_max_time": 1, "coupling_snes_max_it": 1})
alpha, theta, time = slow["alpha_max"], slow["theta_max"], slow["time"]
lost = kept = 0
for i in range(1, len(alpha)): # the motion sees the temperature of the start of the step
    step, rate = alpha[i] - alpha[i - 1], (alpha[i] - alpha[i - 1]) / (time[i] - time[i - 1])
    still = johnson_cook(alpha[i], 0, theta[i - 1])
    lost += (johnson_cook(alpha[i], rate, theta[i - 1]) - 0.1 * still) * step
    kept += 0.1 * johnson_cook(0, 0, theta[i - 1]) / A * (
        A * step + B / (1 + N) * (alpha[i]**(1 + N) - alpha[i - 1]**(1 + N)))
runs.check("dissipated: chi of k at rest and all that the rate adds", slow["dissipated_plastic"][-1], lost, 1e-9)
runs.check("stored: the rest, summed at each step's temperature", slow["energy_plastic"][-1], kept, 1e-9)
share = run["dissipated_plastic"][-1] / (run["dissipated_plastic"][-1] + run["energy_plastic"][-1])
R = 1 + C * math.log(run["alpha_max"][-1] / run["time"][-1])
runs.check("part that is dissipated, with rate", share, 1 - 0.1 / R, 1e-3)

# The gallery, shortened. The block of the shear band is uniform at first: force over mean width is 2/sqrt(3) k on the adiabatic
# curve, at the plastic strain that it has at the compression 0.1.
run = runs.run("shear_band", {"mesh_set_n": 4, "mesh_set_ny": 8, "ts_max_time": "100 us", "output_vis_dt": "100 us"},
               files=[runs.option_file("shear_band.opts")])
theta, steps = 293.15, 4000
alpha = numpy.linspace(0, run["alpha_max"][-1], steps + 1)
for i in range(1, steps + 1):
    rate, middle = 2 / math.sqrt(3) * 1e3 / (1 - 0.1 * i / steps), 0.5 * (alpha[i] + alpha[i - 1])
    stress = johnson_cook(middle, rate, theta)
    theta += (stress - 0.1 * johnson_cook(middle, 0, theta)) * (alpha[i] - alpha[i - 1]) / 3.6018
runs.check("shear_band.opts before the band: true stress", -run["reaction_platen_y"][-1] * 0.9 / 0.5, 2 / math.sqrt(3) * stress, 3e-3)
runs.check("shear_band.opts before the band: temperature", run["theta_max"][-1] - 2, theta, 3e-3)
run = runs.run("taylor_bar", {"ts_max_time": "4 us", "output_vis_dt": "4 us"}, files=[runs.option_file("taylor_bar.opts")])
runs.check("taylor_bar.opts: first law", abs(run["balance_first_law"]).max(), 0, 1e-11, relative=False)
runs.require("taylor_bar.opts: the foot flows and warms", run["alpha_max"][-1] > 0.3 and run["theta_max"][-1] > 380)
runs.finish()
