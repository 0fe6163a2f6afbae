# The failure measure of Johnson and Cook: a bar in tension and in compression at a rate and a temperature against the sum over
# its steps, a sheet, a sheared cell, the field, several ranks and a restart.
# labels: run
# timeout: 120
import math

import numpy

import _runs as runs

D1, D2, D3, D4, D5 = 0.54, 4.89, -3.03, 0.014, 1.12
RATE_0, REF, MELT = 2.0, 293.0, 1356.0
LAW = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_n": 1, "materials": "solid",
       "material_solid_model": "j2", "material_solid_E": 124e3, "material_solid_nu": 0.34, "material_solid_sigma_y": 90,
       "material_solid_hardening": "linear", "material_solid_linear_h": 300, "material_solid_jc_failure": "on",
       "material_solid_jc_d1": D1, "material_solid_jc_d2": D2, "material_solid_jc_d3": D3, "material_solid_jc_d4": D4,
       "material_solid_jc_d5": D5, "material_solid_jc_rate0": RATE_0, "material_solid_jc_theta_ref": REF,
       "material_solid_jc_theta_melt": MELT, "motion_snes_rtol": 1e-12, "probes": "p", "probe_p_at": "0.5,0.5",
       "probe_p_fields": "jc_failure,alpha,stress"}
BAR = {**LAW, "mesh_set_dim": 3, "bcs": "x,y,z,pull", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0,
       "bc_z_on": "back", "bc_z_uz": 0, "bc_pull_on": "right", "probe_p_at": "0.5,0.5,0.5"}


def measure(run, triaxiality, theta):
    """The sum over the steps, from alpha and the triaxiality at their ends."""
    alpha, time = run["alpha_max"], run["time"]
    growth, sigma = numpy.diff(alpha), numpy.broadcast_to(triaxiality, len(time))[1:]
    rate = growth / numpy.diff(time)
    warm = min(1, max(0, (theta - REF) / (MELT - REF)))
    strain = (D1 + D2 * numpy.exp(D3 * sigma)) * (1 + D4 * numpy.log(numpy.maximum(rate / RATE_0, 1))) * (1 + D5 * warm)
    return numpy.concatenate([[0], numpy.cumsum(growth / strain)])


for name, sign, rate, theta in (("slow", 1, 1, 250), ("fast", 1, 1e4, 293), ("hot", 1, 1, 700), ("pressed", -1, 1e3, 400)):
    run = runs.run(name, {**BAR, "material_solid_theta0": theta, "bc_pull_ux": f"exp({sign * rate}*t)-1", "ts_dt": 0.01 / rate,
                          "ts_max_time": 0.2 / rate})
    D = measure(run, sign / 3, theta)
    runs.check(f"{name}: failure measure at the end", run["jc_failure_max"][-1], D[-1], 1e-9)
    runs.check(f"{name}: in every step", max(abs(run["jc_failure_max"] - D)), 0, 1e-9, relative=False)
    runs.check(f"{name}: the field is that of the points", run["probe_p_jc_failure"][-1], D[-1], 1e-9)
runs.check_between("pressed: measure over that in tension at the same strain",
                   run["jc_failure_max"][-1] / run["alpha_max"][-1] * (D1 + D2 * math.exp(D3 / 3)), 0.05, 0.2)

# A sheared cell, and a sheet that is pulled in one direction: 1/3 there too.
run = runs.run("sheared", {**LAW, "bcs": "hold", "bc_hold_on": "solid", "bc_hold_ux": "0.2*t*y", "bc_hold_uy": 0, "ts_dt": 0.05,
                           "ts_max_time": 1})
sigma = numpy.array([run[f"probe_p_stress_{k}"] for k in ("xx", "yy", "zz", "xy")])
mean = sigma[:3].mean(axis=0)
mises = numpy.sqrt(1.5 * (((sigma[:3] - mean) ** 2).sum(axis=0) + 2 * sigma[3] ** 2))
D = measure(run, mean / numpy.maximum(mises, 1e-300), 298.15)
runs.check("sheared: failure measure", run["jc_failure_max"][-1], D[-1], 1e-9)
sheet = {**LAW, "plane": "stress", "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0,
         "bc_pull_on": "right", "bc_pull_ux": "0.2*t", "ts_dt": 0.05, "ts_max_time": 1}
run = runs.run("sheet", sheet)
runs.check("sheet: failure measure", run["jc_failure_max"][-1], measure(run, 1 / 3, 298.15)[-1], 1e-9)

# A plate with cells of all kinds of stress: ranks and a restart.
plate = {**sheet, "plane": "strain", "mesh_set_n": 6, "bc_x_uy": 0, "bc_pull_uy": 0, "ts_dt": 0.02, "checkpoint_every": 25}
one, two = runs.run("one", plate), runs.run("two", plate, ranks=2)
runs.check("two ranks: failure measure", two["jc_failure_max"][-1], one["jc_failure_max"][-1], 1e-10)
runs.require("it is not uniform", one["jc_failure_max"][-1] > 1.02 * one["probe_p_jc_failure"][-1])
again = runs.run("again", {**plate, "restart": "one/checkpoints/checkpoint_000001.h5"})
runs.check("restart: failure measure", again["jc_failure_max"][-1], one["jc_failure_max"][-1], 1e-15)

# What failure takes of the strength: the bar with a constant eps_f = D1 carries (sigma_y + H alpha)(1 - D_c alpha/D1) up to its
# failure and (1 - D_c) of its strength from there on; D is that of the start of a step, so that what is left falls with the step.
DC, FAILED = 0.6, 0.15
weak = {**LAW, "plane": "axisymmetric", "bcs": "axis,foot,pull", "bc_axis_on": "left", "bc_axis_ux": 0, "bc_foot_on": "bottom",
        "bc_foot_uy": 0, "bc_pull_on": "top", "bc_pull_uy": "exp(t)-1", "material_solid_jc_softening": DC,
        "material_solid_jc_d1": FAILED, "material_solid_taylor_quinney": 0.8,
        **{f"material_solid_jc_d{k}": 0 for k in (2, 3, 4, 5)}, "ts_max_time": 0.2}
gaps = []
for steps in (40, 80):
    run = runs.run(f"weak_{steps}", {**weak, "ts_dt": 0.2 / steps})
    alpha, stress, D = (run[f"probe_p_{name}"] for name in ("alpha", "stress_yy", "jc_failure"))
    start = numpy.concatenate([[0], D[:-1]])
    sound = 90 + 300 * alpha
    bears = sound * (1 - DC * numpy.minimum(start, 1))  # of Kirchhoff's stress, p J = K/2 (J^2 - 1)
    bears /= numpy.sqrt(1 + 2 * bears / (124e3 / (1 - 2 * 0.34)))
    flows = numpy.diff(alpha, prepend=0) > 0
    runs.check(f"{steps} steps: stress by the measure of their start", max(abs(stress / bears - 1)[flows]), 0, 1e-8, relative=False)
    gaps.append(max(abs(stress - sound * (1 - DC * numpy.minimum(alpha / FAILED, 1)))[flows]))
    growth = numpy.diff(alpha, prepend=0)
    lost = math.pi * numpy.cumsum(0.8 * sound * (1 - DC * numpy.minimum(start, 1)) * growth)
    runs.check(f"{steps} steps: what flow dissipates", run["dissipated_plastic"][-1], lost[-1], 1e-9)
runs.check("closed form: the gap falls with the step", gaps[0] / gaps[1], 2, 0.05)
runs.check("closed form: and is small", gaps[1] / 90, 0, 0.03, relative=False)
runs.check("strength that is left after failure", stress[-1] / sound[-1], 1 - DC, 1e-3)

# The plate goes on from a checkpoint to the last digit, and is that of two ranks.
plate = {**plate, "material_solid_jc_softening": 0.3}
one, two = runs.run("weak_one", plate), runs.run("weak_two", plate, ranks=2)
runs.check("weakened plate, two ranks: energy", two["energy_elastic"][-1], one["energy_elastic"][-1], 1e-8)
again = runs.run("weak_again", {**plate, "restart": "weak_one/checkpoints/checkpoint_000001.h5"})
runs.check("weakened plate, restart: energy", again["energy_elastic"][-1], one["energy_elastic"][-1], 1e-15)

# Explicit steps of a bar that is pulled slowly: the same stress.
fast = runs.run("weak_explicit", {**weak, "ts_type": "central_difference", "material_solid_rho": "8960 kg/m^3",
                                  "bc_pull_uy": "exp(1000*t)-1", "ts_max_time": 2e-4})
alpha, stress = fast["probe_p_alpha"], fast["probe_p_stress_yy"]
late = fast["time"] > 1e-4
runs.check("explicit: stress", numpy.mean((stress / ((90 + 300 * alpha) * (1 - DC * numpy.minimum(alpha / FAILED, 1))))[late]), 1,
           0.01)

for change, words in (({"material_solid_jc_softening": 0.3, "material_solid_jc_failure": "off"}, ["jc_softening", "jc_failure"]),
                      ({"material_solid_jc_rate_form": "power", "material_solid_jc_d4": 0}, ["jc_rate_form", "jc_c"]),
                      ({"material_solid_jc_softening": 1.5}, ["jc_softening", "value <= 1"])):
    refused = runs.run("refused", {**sheet, **change}, code=2)
    runs.require(f"{words[0]} is refused", all(word in refused.log for word in words))
runs.finish()
