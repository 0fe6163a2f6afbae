# labels: run
# timeout: 120
# long: 200
"""Fatigue by a toughness that falls (Carrara and others 2020). One cell at constant amplitude: the cycles to the threshold, to
the first damage and to the fall of the toughness by closed forms, damage, energies and losses by a recurrence written here;
nothing under pressure, while a load falls or rests, and below the threshold; the first law; ranks, restart, refused steps."""
import math

import numpy

import _fatigue as fatigue
import _runs as runs
from _fatigue import CELL, GC, REST, SOLID, WIDTH, stretched, wave

TOUGH = {"material_solid_fatigue": "asymptotic", "material_solid_damage_gradient": "material"}
THRESHOLD = GC / 12 / WIDTH
STRAIN = 0.012
PSI = stretched(1 + STRAIN)[0]  # the energy of a cell at the top of a cycle, undamaged
KAPPA = 0.8


def left(alpha, law, threshold):
    x = max(alpha / threshold, 1)
    return (2 / (1 + x)) ** 2 if law == "asymptotic" else max(1 - KAPPA * math.log10(x), 0) ** 2


def recurrence(times, law="asymptotic", crack="at2", threshold=THRESHOLD, mean_load=None):
    """phi, the summed energy and the dissipation at these times: phi in balance with the toughness of the step before, never
    falling; then the energy that was added while the degraded one grew."""
    phi, alpha, lost, stored = [0.0], [0.0], [0.0], [0.0]
    for now in times[1:]:
        energy, f = stretched(1 + STRAIN * wave(now))[0], left(alpha[-1], law, threshold)
        drive = 2 * (1 - REST) * energy
        root = drive / (drive + f * GC / WIDTH) if crack == "at2" else 1 - 3 / 8 * f * GC / WIDTH / drive if drive else 0
        phi.append(min(1, max(phi[-1], root)))
        stored.append(((1 - REST) * (1 - phi[-1]) ** 2 + REST) * energy)
        change = stored[-1] - stored[-2]
        alpha.append(alpha[-1] + max(0, change if mean_load is None else change * (stored[-1] + stored[-2]) / 2 / mean_load))
        lost.append(lost[-1] + (f - left(alpha[-1], law, threshold)) * crack_energy(phi[-1], crack))
    return numpy.array(phi), numpy.array(alpha), numpy.array(lost)


def crack_energy(phi, crack):
    return GC / WIDTH * (phi * phi / 2 if crack == "at2" else 3 / 8 * phi)


PULL = {"bc_hold_ux": f"{STRAIN}*cycle(t,1)*x", "ts_dt": 0.25}
for name, law, crack, more, numbers in (
        ("asymptotic", "asymptotic", "at2", {}, {}),
        ("logarithmic", "logarithmic", "at2", {"material_solid_fatigue_kappa": KAPPA}, {}),
        ("threshold", "asymptotic", "at1", {"material_solid_fatigue_threshold": 0.5}, {"threshold": 0.5}),
        ("mean_load", "asymptotic", "at2", {"material_solid_fatigue_mean_load": 0.1}, {"mean_load": 0.1}),
        ("explicit", "asymptotic", "at2", {"ts_type": "central_difference", "bc_hold_ux": f"{STRAIN}*cycle(t,4e-5)*x", "ts_period": 4e-5,
                                           "ts_dt": 1e-5, "material_solid_rho": 1e-6, "ts_max_time": 40 * 4e-5, "outputs": "hist",
                                           "output_hist_type": "csv", "output_hist_every": 1}, {})):
    run = runs.run(name, {**CELL, **TOUGH, **PULL, "material_solid_fatigue": law, "material_solid_damage": crack,
                          "ts_max_time": 40, **more})
    run.history["time"] = (run["time"] / run["time"][-1] * 160).round() / 4  # in cycles
    phi, alpha, lost = recurrence(run["time"], law, crack, **numbers)
    runs.check(f"{name}: largest error of phi over {len(phi) - 1} steps", abs(run["phi_max"] - phi).max(), 0, 1e-8,
               relative=False)
    runs.check(f"{name}: largest error of the summed energy", abs(run["fatigue_max"] - WIDTH * alpha).max(), 0, 1e-8,
               relative=False)
    runs.check_between(f"{name}: phi at the end", run["phi_max"][-1], 0.05, 1)
    f = numpy.array([left(a, law, numbers.get("threshold", THRESHOLD)) for a in alpha])
    crack_energies = numpy.array([crack_energy(p, crack) for p in phi])
    runs.check_between(f"{name}: toughness left", f[-1], 0, 0.9)
    runs.check(f"{name}: energy_fracture is that of the whole toughness", abs(run["energy_fracture"] - crack_energies).max(), 0,
               1e-8, relative=False)
    runs.check(f"{name}: energy_fatigue is what it has lost", abs(run["energy_fatigue"] + (1 - f) * crack_energies).max(), 0,
               1e-8, relative=False)
    runs.check(f"{name}: its fall dissipates", abs(run["dissipated_fatigue"] - lost).max(), 0, 1e-8, relative=False)
    falls = numpy.diff([wave(t) for t in run["time"]]) < 0
    runs.require(f"{name}: nothing while the load falls", (numpy.diff(run["fatigue_max"])[falls] == 0).all())

# AT1 is elastic to 3 Gc/16 gamma: the closed forms of undamaged cycles, and of the first damage.
run = runs.run("life", {**CELL, **TOUGH, **PULL, "ts_dt": 0.5, "material_solid_damage": "at1",
                         "material_solid_fatigue_threshold": 0.5, "ts_max_time": 14})
tops = run["time"] % 1 == 0.5
runs.check("undamaged: each cycle adds its energy", run["fatigue_max"][tops][1], 2 * WIDTH * PSI, 1e-12)
ratio = 16 * WIDTH * (1 - REST) * PSI / 3 / GC  # the toughness at which the top of a cycle damages
first = math.ceil(0.5 * (2 / math.sqrt(ratio) - 1) / PSI)
runs.check_between("life: cycles that damage nothing", first, 8, 12)
runs.check("life: the cycle of the first damage", (run["phi_max"][tops] > 0).argmax(), first, 0, relative=False)
runs.check("life: phi where it begins", run["phi_max"][tops][first], 1 - left(first * PSI, "asymptotic", 0.5) / ratio, 1e-8)

# Pressed, held at rest, and below the threshold.
pressed = runs.run("pressed", {**CELL, **TOUGH, "material_solid_split": "spectral", "bc_hold_ux": "-0.02*cycle(t,1)*x", "ts_dt": 0.25,
                               "ts_max_time": 3})
runs.require("pressed: no fatigue, no damage", not pressed["fatigue_max"].any() and not pressed["phi_max"].any())
held = runs.run("held", {**CELL, **TOUGH, "bc_hold_ux": "0.02*min(t,1)*x", "ts_dt": 0.25, "ts_max_time": 3})
runs.require("held: no more fatigue", numpy.ptp(held["fatigue_max"][held["time"] > 1.2]) == 0)
below = {**SOLID, "mesh_set_n": 4, "material_solid_damage_gradient": "material", "bcs": "clamp,pull", "bc_clamp_on": "left", "bc_clamp_type": "fix",
         "bc_pull_on": "right", "bc_pull_ux": "0.03*t", "ts_dt": 0.1, "ts_max_time": 1}
plain, high = (runs.run(name, {**below, **more}) for name, more in (
    ("plain", {}), ("high", {**TOUGH, "material_solid_fatigue_threshold": 1e3})))
for column in ("phi_max", "energy_elastic", "energy_fracture", "reaction_pull_x"):
    runs.require(f"below the threshold: {column} of a body that does not tire, bit for bit", (plain[column] == high[column]).all())

# A clamped block under a cyclic pull: first law, heat, cells of second order, ranks, a restart, refused steps.
BLOCK = {**below, **TOUGH, "bc_pull_ux": "0.03*cycle(t,1)", "ts_max_time": 2, "coupling_snes_atol": 1e-6}
one = runs.run("block", {**BLOCK, "checkpoint_every": 10})
runs.check_between("block: part of the crack energy that the toughness has lost", -one["energy_fatigue"][-1] / one["energy_fracture"][-1], 0.3, 1)
runs.require("block: dissipation grows", (numpy.diff(one["dissipated_fatigue"]) >= 0).all())
PARTS = (1, 2, 4) if runs.long() else (2, 4)
for name, more in (("", {}), (" with heat", {"material_solid_c_v": 0.05, "material_solid_alpha_t": 1e-5, "material_solid_conductivity": 1}),
                   (" of second order", {"order": 2, "mesh_set_n": 2, "mesh_set_simplex": 1}))[0 if runs.long() else 1:]:
    law = [abs(runs.run(f"law{name}_{n}".replace(" ", "_"), {**BLOCK, **more, "ts_dt": 0.1 / n})["balance_first_law"]).max() for n in PARTS]
    print(f"     block{name}: first law, at last with 20 and 40 steps to a cycle:", law)
    runs.check_between(f"block{name}: its residual falls with the steps", law[-2] / law[-1], 1.6, 4)
    runs.check(f"block{name}: first law with forty steps", law[-1], 0, 1e-2, relative=False)
columns = ("fatigue_max", "phi_max", "energy_fatigue", "dissipated_fatigue", "reaction_pull_x")
two = runs.run("block_two", BLOCK, ranks=2)
for column in columns:
    runs.check(f"2 ranks: {column}", abs(two[column] - one[column]).max() / abs(one[column]).max(), 0, 1e-8, relative=False)
again = runs.run("again", {**BLOCK, "restart": "block/checkpoints/checkpoint_000001.h5"})
tried = runs.run("tried", {**BLOCK, "test_restep": 1}, refused=None)
for column in columns:
    runs.require(f"restart: {column} bit for bit", (again[column][-5:] == one[column][-5:]).all())
    runs.require(f"steps tried twice: {column} bit for bit", (tried[column] == one[column]).all())
runs.finish()
