"""Waves in bodies that warm as they are pressed and conduct nothing: they are as fast as the adiabatic modulus says,
lambda + 2G + theta beta^2/c_eff, beta = 3 alpha K, c_eff = c_V - theta alpha beta 3 (a sheet: with sigma_33 = 0), and keep their
amplitude, by implicit and by explicit steps, under every cure of locking, split and equation of state. A motion that waits for
the temperature of its last step has fed energy into the fastest modes by a fixed factor a step instead: 240 steps of a
cantilever ended by -energy_stop, whatever the step (Armero and Simo, Int. J. Numer. Meth. Engng. 35 (1992)). Zener's damping of
that cantilever."""
# labels: run
# timeout: 180
# long: 300
import glob
import math

import numpy
from _runs import check, check_between, finish, long, mesh, require, run

L, V, PERIODS = 10, 100, 5
E, NU, RHO, ALPHA, C_V, THETA = 210e3, 0.3, 7.8e-9, 5e-5, 3.6, 298.15
K, G = E / (3 * (1 - 2 * NU)), E / (2 * (1 + NU))
BETA = 3 * ALPHA * K
WARM = THETA * BETA**2 / (C_V - 3 * ALPHA * BETA * THETA)
LAME = K - 2 * G / 3 + WARM
STRAIN = LAME + 2 * G
SHEET = 4 * G * (LAME + G) / (LAME + 2 * G)
BAR = {
    "mesh": mesh("block.geo"), "mesh_set_lx": L, "mesh_set_ly": 1, "mesh_set_n": 20, "mesh_set_ny": 2, "units": "mm_t_s_MPa",
    "materials": "solid", "material_solid_E": E, "material_solid_nu": NU, "material_solid_rho": RHO, "material_solid_alpha_t": ALPHA,
    "material_solid_c_v": C_V, "material_solid_conductivity": 0, "material_solid_theta0": THETA,
    "bcs": "left,sides", "bc_left_on": "left", "bc_left_ux": 0, "bc_sides_on": "bottom,top", "bc_sides_uy": 0,
    "ics": "v", "ic_v_on": "solid", "ic_v_vx": f"{V}*sin(pi*x/{2 * L})", "probes": "end", "probe_end_at": f"{L},0", "probe_end_fields": "u",
    "energy_tol": 0.1,
}
SPACE = {"mesh_set_dim": 3, "mesh_set_n": 20, "mesh_set_ny": 1, "mesh_set_nz": 1, "probe_end_at": f"{L},0,0",
         "bcs": "left,sides,faces", "bc_faces_on": "back,front", "bc_faces_uz": 0}
BRITTLE = {"material_solid_damage": "at2", "material_solid_Gc": 1e3, "material_solid_gamma": 2}
EXPLICIT = {"ts_type": "central_difference", "outputs": "hist", "output_hist_type": "csv", "output_hist_every": 1}
CASES = {
    "points": ({"material_solid_locking": "none"}, STRAIN),
    "mean": ({"material_solid_locking": "mean"}, STRAIN),
    "fbar": ({"material_solid_locking": "fbar"}, STRAIN),
    "patches": ({"material_solid_locking": "mean", "mesh_set_simplex": 1}, STRAIN),
    "sheet": ({"plane": "stress"}, SHEET),
    "second_order": ({"order": 2, "mesh_set_n": 10, "mesh_set_ny": 1}, STRAIN),
    "space": (SPACE, STRAIN),
    "volumetric": ({**BRITTLE, "material_solid_split": "volumetric"}, STRAIN),
    "spectral": ({**BRITTLE, "material_solid_split": "spectral"}, STRAIN),
    "spectral_mean": ({**BRITTLE, "material_solid_split": "spectral", "material_solid_locking": "mean"}, STRAIN),
    "spectral_sheet": ({**BRITTLE, "material_solid_split": "spectral", "plane": "stress"}, SHEET),
    "energy": ({"heat_form": "energy"}, STRAIN),
    "explicit": (EXPLICIT, STRAIN),
    "explicit_mean": ({**EXPLICIT, "material_solid_locking": "mean"}, STRAIN),
    "explicit_space": ({**EXPLICIT, **SPACE}, STRAIN),
    "explicit_spectral": ({**EXPLICIT, **BRITTLE, "material_solid_split": "spectral"}, STRAIN),
}


def listen(name, settings, modulus, rho=RHO):
    omega = math.pi / (2 * L) * math.sqrt(modulus / rho)
    period = 2 * math.pi / omega
    r = run(name, {**BAR, "ts_max_time": PERIODS * period, **({} if "ts_type" in settings else {"ts_dt": period / 100}), **settings})
    u, time = r["probe_end_ux"], r["time"]
    check(f"{name}: end of the bar against V/w sin w t, over V/w", abs(u - V / omega * numpy.sin(omega * time)).max() / (V / omega), 0, 0.03,
          relative=False)
    last = time > (PERIODS - 1) * period
    check(f"{name}: amplitude of the last period over that of all", abs(u[last]).max() / abs(u).max(), 1, 5e-3)
    return r, period


TWINS = ("points", "volumetric", "spectral_mean", "spectral_sheet", "space", "explicit", "explicit_mean", "explicit_spectral")  # each is near another one
for name, (settings, modulus) in CASES.items():
    if name in TWINS and not long():
        continue
    listen(name, settings, modulus)

# What is as short as cells keeps its energy too: a bar struck by a jump of the velocity, and the halves on either side of a crack.
CERAMIC = {"mesh": mesh("block.geo"), "mesh_set_lx": 4, "mesh_set_n": 40, "mesh_set_ny": 10, "units": "mm_t_s_MPa", "materials": "solid",
           "material_solid_E": 340e3, "material_solid_nu": 0.22, "material_solid_rho": 3.95e-9, "material_solid_c_v": 3.9, "material_solid_alpha_t": 8e-6,
           "material_solid_theta0": 600, "ic_v_on": "solid", "bcs": "left", "bc_left_on": "left", "bc_left_type": "fix", "ics": "v",
           "ic_v_vx": "step(x,2)*1000*(1+cos(pi*(x-2)/2))", "ts_max_time": 2e-5}
CRACK = {"material_solid_damage": "at1", "material_solid_Gc": 0.024, "material_solid_gamma": 0.2, "ics": "v,w", "ic_w_on": "solid",
         "ic_w_phi": "abs(x-2)<0.06 ? 1 : 0", "energy_tol": 0.1}
for name, settings, lost in (("struck", EXPLICIT, 5e-3), ("struck_lumped", {**EXPLICIT, "heat_capacity": "lumped"}, 5e-3),
                             ("struck_energy", {**EXPLICIT, "heat_form": "energy"}, 5e-3), ("struck_newmark", {"ts_dt": 2e-8}, 5e-3),
                             ("halves", {**EXPLICIT, **CRACK}, 0.12), ("halves_spectral", {**EXPLICIT, **CRACK, "material_solid_split": "spectral"}, 0.07)):
    if name != "struck" and not long():
        continue
    r = run(name, {**CERAMIC, **settings})
    energy, first = r["energy_kinetic"] + r["energy_elastic"], numpy.searchsorted(r["time"], 2e-6)
    check_between(f"{name}: part of the energy that vibrates which is lost", 1 - energy[-1] / energy[first], -lost, lost)
    check(f"{name}: first law over that time", r["balance_first_law"][-1] - r["balance_first_law"][first], 0, lost, relative=False)

print("an equation of state: rho c_0^2 is the adiabatic modulus")
C_0, SHEAR = 3.94e6, 47e3
COPPER = {"material_solid_rho": 8.93e-9, "material_solid_eos": "mie_grueneisen", "material_solid_eos_c0": C_0, "material_solid_eos_s": 1.489,
          "material_solid_eos_gamma": 2.02, "material_solid_c_v": 3.43, "material_solid_alpha_t": None, "material_solid_E": None, "material_solid_nu": None,
          "material_solid_G": SHEAR}
copper = {**BAR, **COPPER}
BAR = {key: value for key, value in copper.items() if value is not None}
for name, settings in {"eos": {}, "explicit_eos": EXPLICIT}.items():
    listen(name, settings, 8.93e-9 * C_0**2 + 4 * SHEAR / 3, 8.93e-9)

print("Zener's damping of a cantilever whose first bending mode is as slow as heat that crosses it")
BEAM = {
    "mesh": mesh("block.geo"), "mesh_set_lx": 50, "mesh_set_ly": 2, "mesh_set_n": 30, "mesh_set_ny": 4, "order": 2, "units": "mm_t_s_MPa",
    "plane": "stress", "materials": "solid", "material_solid_E": E, "material_solid_nu": NU, "material_solid_rho": RHO,
    "material_solid_alpha_t": ALPHA, "material_solid_c_v": C_V, "material_solid_conductivity": 6156, "material_solid_theta0": THETA,
    "bcs": "foot", "bc_foot_on": "left", "bc_foot_type": "fix", "ics": "v", "ic_v_on": "solid", "ic_v_vy": "100*(x/50)^2*(3-x/50)/2",
    "probes": "tip", "probe_tip_at": "50,1", "probe_tip_fields": "u", "ts_dt": 2.5e-5, "ts_max_time": 0.012, "energy_tol": 0.2,
}
ZENER = 0.0217  # for small coupling: E alpha^2 theta/C w tau/(1 + (w tau)^2)
PASSES = {"coupling_snes_max_it": 50, "coupling_theta_tol": 1e-10}
for name, settings, tolerance in (("one_pass", {}, 0.12), ("passes", PASSES, 0.03))[: 2 if long() else 1]:
    r = run(name, {**BEAM, **settings})
    time, u = r["time"], r["probe_tip_uy"]
    turns = [i for i in range(1, len(u) - 1) if (u[i] - u[i - 1]) * (u[i + 1] - u[i]) <= 0][:16]
    slope = numpy.polyfit(time[turns], numpy.log(abs(u[turns])), 1)[0]
    omega = math.pi * (len(turns) - 1) / (time[turns[-1]] - time[turns[0]])
    check(f"{name}: damping 1/Q over Zener's", -2 * slope / omega / ZENER, 1, tolerance)


run("part", {**BEAM, "ts_max_time": 0.002, "ts_max_steps": 40})
rest = run("part", {**BEAM, "ts_max_time": 0.002, "restart": "auto"})
whole = run("whole", {**BEAM, "ts_max_time": 0.002})
pulled = {key: value for key, value in BAR.items() if key not in ("ics", "ic_v_on", "ic_v_vx")}
pulled.update({"bcs": "left,sides,right", "bc_right_on": "right", "bc_right_ux": "1e-3*min(1,t)", "probe_end_at": f"{L / 2},0"})
run("at_rest", {**pulled, "ts_type": "static", "ts_dt": 0.5, "ts_max_time": 1})
at_rest = sorted(glob.glob("at_rest/checkpoints/*.h5"))[-1]
for name, settings in {"rest_newmark": {"ts_type": "newmark", "ts_dt": 1e-7}, "rest_explicit": {**EXPLICIT, "ts_dt": "auto"}}.items():
    r = run(name, {**pulled, **settings, "ts_max_time": 1 + 5e-6, "restart": at_rest, "restart_allow": "ts_type,ts_dt"})
    check(f"{name}: what was pulled at rest stays so with inertia", abs(r["probe_end_ux"] - r["probe_end_ux"][0]).max() / 1e-3, 0, 1e-6,
          relative=False)
require("a restart goes on to the last digit", (rest["probe_tip_uy"] == whole["probe_tip_uy"]).all() and len(whole["time"]) == 81)
finish()
