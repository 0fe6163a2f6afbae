# The equation of state of Mie and Grueneisen: pressure and energy of copper in uniaxial strain against closed forms, with heat
# along the isentrope, the shock of two plates that meet at 300 m/s, and the end of the law.
# labels: run
# timeout: 120
import math

import numpy

import _runs as runs

RHO, C0, S, GAMMA, C_V, THETA_0 = 8930.0, 3940.0, 1.489, 2.02, 8930 * 385.0, 293.0
K, G = RHO * C0**2, 47.7e9
COPPER = {"units": "SI", "materials": "solid", "material_solid_eos": "mie_grueneisen", "material_solid_eos_c0": C0,
          "material_solid_eos_s": S, "material_solid_rho": RHO, "material_solid_G": G}
PRESS = {**COPPER, "ts_type": "static", "mesh": runs.mesh("block.geo"), "mesh_set_n": 2, "bcs": "wall,push,side",
         "bc_wall_on": "left", "bc_wall_ux": 0, "bc_push_on": "right", "bc_side_on": "bottom,top", "bc_side_uy": 0,
         "motion_snes_rtol": 1e-13, "ts_dt": 0.1, "ts_max_time": 1}


def hugoniot(eta):
    return K * eta / (1 - S * numpy.maximum(eta, 0)) ** 2


def deviator(J):
    """First Piola-Kirchhoff stress and energy of the isochoric neo-Hookean part for F = diag(J, 1, 1)."""
    return 2 / 3 * G * (J**2 - 1) * J ** (-5 / 3), G / 2 * ((J**2 + 2) * J ** (-2 / 3) - 3)


# Pressed by 0.3 and pulled by 0.2, with each cure of locking, in space and around an axis (along which it is pressed there).
AXIAL = {"plane": "axisymmetric", "bc_wall_on": "bottom", "bc_push_on": "top", "bc_side_on": "left,right", "bc_side_ux": 0,
         "bc_wall_ux": "", "bc_wall_uy": 0, "bc_side_uy": ""}
for name, strain, more, axis, area in (
        ("none", -0.3, {"material_solid_locking": "none"}, "x", 1), ("mean", -0.3, {"material_solid_locking": "mean"}, "x", 1),
        ("fbar", -0.3, {"material_solid_locking": "fbar"}, "x", 1), ("pulled", 0.2, {}, "x", 1),
        ("space", -0.3, {"mesh_set_dim": 3, "bcs": "wall,push,side,depth", "bc_depth_on": "back,front", "bc_depth_uz": 0}, "x", 1),
        ("axial", -0.3, AXIAL, "y", math.pi)):
    options = {**PRESS, **more, f"bc_push_u{axis}": f"{strain}*t"}
    run = runs.run(name, {key: value for key, value in options.items() if value != ""})
    eta = -strain * run["time"][1:]
    stress, energy = deviator(1 - eta)
    p = hugoniot(eta)
    t = numpy.maximum(S * eta, 1e-300)
    stored = numpy.where(eta > 0, K / S**2 * (numpy.log1p(-t) + t / (1 - t)), K * eta**2 / 2) if strain < 0 else K * eta**2 / 2
    reaction = run[f"reaction_push_{axis}"][1:] / area
    runs.check(f"{name}: largest error of the stress over K", max(abs(reaction - (stress - p))) / K, 0, 1e-11, relative=False)
    runs.check(f"{name}: largest error of the energy over K", max(abs(run["energy_elastic"][1:] / area - stored - energy)) / K, 0,
               1e-11, relative=False)

# With heat and without conduction: along the isentrope, where theta = theta_0 exp(Gamma eta) and dE/deta = p.
HOT = {"material_solid_c_v": C_V, "material_solid_eos_gamma": GAMMA, "material_solid_theta0": THETA_0,
       "coupling_snes_max_it": 50, "coupling_snes_atol": 1e-13}
run = runs.run("isentrope", {**PRESS, **HOT, "bc_push_ux": "-0.3*t"})
fine = numpy.linspace(0, 0.3, 3001)
E = numpy.zeros_like(fine)


def slope(x, e):
    return hugoniot(x) * (1 - GAMMA * x / 2) + GAMMA * e


for i, h in enumerate(numpy.diff(fine)):  # Runge-Kutta
    a = slope(fine[i], E[i])
    b = slope(fine[i] + h / 2, E[i] + h / 2 * a)
    c = slope(fine[i] + h / 2, E[i] + h / 2 * b)
    E[i + 1] = E[i] + h / 6 * (a + 2 * b + 2 * c + slope(fine[i] + h, E[i] + h * c))
eta = 0.3 * run["time"][1:]
stress, energy = deviator(1 - eta)
runs.check("isentrope: largest error of ln(theta)", max(abs(numpy.log(run["theta_max"][1:] / THETA_0) - GAMMA * eta)), 0, 1e-9,
           relative=False)
p = slope(fine, E)[300::300]
runs.check("isentrope: largest error of the stress over K", max(abs(run["reaction_push_x"][1:] - (stress - p))) / K, 0, 1e-9,
           relative=False)
stored = run["energy_elastic"][1:] + run["energy_thermal"][1:] - run["energy_thermal"][0]
runs.check("isentrope: largest error of the internal energy over K", max(abs(stored - energy - E[300::300])) / K, 0, 1e-9,
           relative=False)

# Two copper plates meet at 300 m/s: half of it, against a wall. The material hardly resists shear, so that the stress is the
# pressure rho (c0 + s u) u of the shock.
SPEED, LENGTH, N = 150.0, 0.05, 200
front = C0 + S * SPEED
run = runs.run("shock", {
    **COPPER, "material_solid_G": 1e-4 * K, "mesh": runs.mesh("block.geo"), "mesh_set_n": N, "mesh_set_ny": 1, "mesh_scale": LENGTH,
    "mesh_set_ly": 1 / N, "bcs": "wall,side", "bc_wall_on": "left", "bc_wall_ux": 0, "bc_side_on": "solid", "bc_side_uy": 0,
    "ics": "fly", "ic_fly_on": "solid", "ic_fly_vx": -SPEED, "ts_newmark_rho": 0.5,
    "ts_dt": 0.25 * LENGTH / N / front, "ts_max_time": 0.9 * LENGTH / front, "probes": "p", "probe_p_at": f"{LENGTH / 2},0",
    "probe_p_fields": "u,v,pressure"})
time, force = run["time"], abs(run["reaction_wall_x"]) / (LENGTH / N)
late = time > 0.3 * time[-1]
runs.check("shock: pressure at the wall, GPa", force[late].mean() / 1e9, 5.58, 0.01)
runs.check("shock: pressure at the wall over rho (c0 + s u) u", force[late].mean() / (RHO * front * SPEED), 1, 0.003)
arrival = time[numpy.argmax(run["probe_p_vx"] > -SPEED / 2)]
runs.check("shock: its speed through the material, m/s", LENGTH / 2 / arrival, front, 0.01)
inside = run["probe_p_pressure"][time > 0.75 * time[-1]]
runs.check("shock: pressure inside over rho (c0 + s u) u", inside.mean() / (RHO * front * SPEED), 1, 0.01)

# At 2000 m/s with heat: the viscosity heats what the shock passes, and the pressure is that of the shock, 4 % above that of the
# isentrope at the same volume. The energy form keeps the first law.
SPEED, N = 1000.0, 60
front = C0 + S * SPEED
run = runs.run("hot_shock", {
    **COPPER, **HOT, "material_solid_G": 1e-4 * K, "material_solid_b_d": 2.5e4, "heat_form": "energy", "coupling_snes_atol": 1e-6,
    "mesh": runs.mesh("block.geo"), "mesh_set_n": N, "mesh_set_ny": 1, "mesh_scale": LENGTH, "mesh_set_ly": 1 / N,
    "bcs": "wall,side", "bc_wall_on": "left", "bc_wall_ux": 0, "bc_side_on": "solid", "bc_side_uy": 0, "ics": "fly",
    "ic_fly_on": "solid", "ic_fly_vx": -SPEED, "ts_dt": 0.5 * LENGTH / N / front, "ts_max_time": 0.9 * LENGTH / front})
force = abs(run["reaction_wall_x"][run["time"] > 0.5 * run["time"][-1]]) / (LENGTH / N)
runs.check("hot shock: pressure at the wall over rho (c0 + s u) u", force.mean() / (RHO * front * SPEED), 1, 0.005)
runs.check("hot shock: balance of the first law", abs(run["balance_first_law"]).max(), 0, 1e-9, relative=False)

# The law ends at eta = 1/s = 0.67: a cell beyond it is a broken one.
log = runs.run("beyond", {**PRESS, "bc_push_ux": "-0.75*t", "ts_dt": 1}, code=None).log
runs.require("a cell beyond the end of the law is named", "cell compressed beyond the end of its equation of state (J=" in log)
runs.require("there is no nan in the log", " nan" not in log)
# Two plates of copper meet by explicit steps: up to 6 km/s by the defaults of contact and steps, with half of the velocity behind the
# shock and the pressure of the Hugoniot, U = c_0 + s u. Steps and penalties that know nothing of the velocity ended the run, or let the
# plates pass through each other.
FLYER = {"units": "mm_t_s_MPa", "mesh": runs.mesh("bar.geo"), "mesh_set_length": 2, "mesh_set_second_length": 4, "mesh_set_n": 100, "mesh_set_n_second": 200,
         "mesh_set_width": 0.02, "mesh_set_gap": 1e-6, "materials": "flyer,target", "material_flyer_region": "bar", "material_flyer_model": "j2",
         "material_flyer_sigma_y": 100, "material_flyer_G": 47700, "material_flyer_rho": 8.93e-9, "material_flyer_eos": "mie_grueneisen",
         "material_flyer_eos_c0": 3.94e6, "material_flyer_eos_s": 1.489, "material_target_like": "flyer", "material_target_region": "second_bar",
         "bcs": "sides", "bc_sides_on": "bar_sides,second_sides", "bc_sides_uy": 0, "ics": "flight", "ic_flight_on": "bar", "contacts": "face",
         "contact_face_secondary": "bar_right", "contact_face_primary": "second_left", "ts_type": "central_difference", "ts_bulk_viscosity_linear": 0.06,
         "ts_bulk_viscosity_quadratic": 1.2, "ts_max_time": 1.8e-7, "outputs": "hist", "output_hist_type": "csv", "output_hist_every": 1, "probes": "p",
         "probe_p_at": "2.6,0.01", "probe_p_on": "second_bar", "probe_p_fields": "v,stress"}
for speed in (2, 4, 6):
    for enforce in ("penalty", "impulse"):
        r = runs.run("flyer", {**FLYER, "ic_flight_vx": f"{speed} km/s", "contact_face_enforce": enforce})
        runs.check(f"flyer at {speed} km/s, {enforce}: velocity behind the shock", r["probe_p_vx"][-1] / (speed * 1e6), 0.5, 0.01)
        pressure = 8.93e-9 * (3.94e6 + 1.489 * speed / 2 * 1e6) * speed / 2 * 1e6  # and 2/3 of the yield stress beside 49 to 226 GPa
        runs.check(f"flyer at {speed} km/s, {enforce}: stress", -r["probe_p_stress_xx"][-1] / pressure, 1, 0.015)
        runs.require("and nothing is said of depths", "as deep as" not in r.log)
deep = runs.run("deep", {**FLYER, "ic_flight_vx": "6 km/s", "contact_face_penalty": 1e7})
runs.require("a penalty that lets one body pass through the other says so", "WARNING: a contact is as deep as surfaces are seen" in deep.log)
# A piston starts at once: viscous forces are there at t = 0 already, and count in the work of the first step.
SPEED, WIDTH = 7e5, 0.02
PISTON = {"units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_lx": 2, "mesh_set_ly": WIDTH, "mesh_set_n": 100, "mesh_set_ny": 1, "materials": "solid",
                             **{key.replace("flyer", "solid"): FLYER[key] for key in ("material_flyer_rho", "material_flyer_eos", "material_flyer_eos_c0", "material_flyer_eos_s")},
                             "material_solid_G": 1, "bcs": "sides,push", "bc_sides_on": "bottom,top", "bc_sides_uy": 0, "bc_push_on": "left", "bc_push_type": "velocity",
                             "bc_push_ux": SPEED, "ts_type": "central_difference", "ts_bulk_viscosity_linear": 0.06, "ts_bulk_viscosity_quadratic": 1.2, "ts_max_time": 3e-7,
                             "outputs": "hist", "output_hist_type": "csv", "output_hist_every": 1}
piston = runs.run("piston", PISTON)
runs.check("piston: balance", abs(piston["balance"]).max(), 0, 1e-12, relative=False)
late = piston["time"] > 1.5e-7
runs.check("piston: its pressure, that of the Hugoniot", piston["reaction_push_x"][late].mean() / WIDTH, 8.93e-9 * (3.94e6 + 1.489 * SPEED) * SPEED, 5e-3)

# What bulk viscosity takes up is heat in either form: behind a shock from 300 K, with Gamma rho constant and c_V of a volume, the
# temperature is that of the isentrope, theta_0 exp(Gamma eta), and what its energy lacks to half of p eta, over c_V.
GAMMA, C_V, THETA_0 = 2.0, 3.45, 300
eta = SPEED / (3.94e6 + 1.489 * SPEED)


def hugoniot(x):
    p = 8.93e-9 * 3.94e6**2 * x / (1 - 1.489 * x) ** 2
    return p, p * x / 2


isentrope, count = 0.0, 2000
for i in range(count):  # dE/deta = p_H + Gamma (E - E_H), by the rule of the middle
    x, h = (i + 0.5) * eta / count, eta / count
    p, e = hugoniot(x)
    isentrope += h * (p + GAMMA * (isentrope - e)) / (1 - h * GAMMA / 2)
behind = THETA_0 * numpy.exp(GAMMA * eta) + (hugoniot(eta)[1] - isentrope) / C_V
for form, of_theta, of_energy in (("energy", 0.01, 1e-9), ("entropy", 0.03, 0.04)):
    hot = runs.run(f"piston_{form}", {**PISTON, "heat_form": form, "material_solid_eos_gamma": GAMMA, "material_solid_c_v": f"{C_V}e6 J/(m^3.K)",
                                      "material_solid_theta0": THETA_0, "probes": "p", "probe_p_at": f"0.6,{WIDTH / 2}", "probe_p_fields": "theta"})
    runs.check(f"hot piston, {form} form: temperature behind the shock", hot["probe_p_theta"][-1] - THETA_0, behind - THETA_0, of_theta)
    runs.check(f"hot piston, {form} form: first law", abs(hot["balance_first_law"]).max(), 0, of_energy, relative=False)
runs.finish()
