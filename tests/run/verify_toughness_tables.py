# labels: run
# timeout: 240
"""A toughness that follows the rate of strain and the temperature (T1). One cell: damage, cost of the crack and the factor by a
recurrence written here, in statics, with heat and in explicit steps; a table that is constant is another Gc; first law, cells
of second order, ranks, a restart, refused steps; words for what cannot be."""
import math

import numpy

import _fatigue as fatigue
import _runs as runs
from _fatigue import CELL, GC, REST, SOLID, WIDTH, stretched


def table(name, rows):
    path = f"{name}.csv"
    with open(path, "w") as file:
        file.write("at,factor\n" + "".join(f"{a},{b}\n" for a, b in rows))
    return path


RATES, HEATS = ((0, 1), (0.01, 1.5), (0.02, 3)), ((200, 1.4), (400, 0.8))
BY_RATE = {"material_solid_Gc_rate": table("rates", RATES), "material_solid_damage_gradient": "material"}
BY_HEAT = {"material_solid_Gc_temperature": table("heats", HEATS), "material_solid_damage_gradient": "material",
           "material_solid_c_v": 1.0}


def factor(rows, at):
    return float(numpy.interp(at, *zip(*rows)))


def recurrence(times, stretch, theta=None, rates=True, unit=1.0):
    """phi in balance with the toughness that the step before left, never falling, and what the crack has cost."""
    phi, cost, f = [0.0], [0.0], 1.0 if theta is None else factor(HEATS, theta(0))
    for i in range(1, len(times)):
        drive = 2 * (1 - REST) * stretched(stretch(times[i]))[0]
        phi.append(max(phi[-1], drive / (drive + f * GC / WIDTH)))
        cost.append(cost[-1] + f * GC / WIDTH * (phi[-1] ** 2 - phi[-2] ** 2) / 2)
        f = 1.0
        if rates:
            f *= factor(RATES, abs(math.log(stretch(times[i]) / stretch(times[i - 1]))) / (times[i] - times[i - 1]) * unit)
        if theta is not None:
            f *= factor(HEATS, theta(times[i]))
    return numpy.array(phi), numpy.array(cost)


# The cell is stretched ever faster; warmed up besides; and in explicit steps, by a clock that runs 1e5 times as fast.
fast = 1e-5
for name, more, law in (
        ("rate", BY_RATE, {}),
        ("temperature", {**BY_HEAT, "ics": "cold", "ic_cold_on": "solid", "ic_cold_theta": 250, "bcs": "hold,warm", "bc_warm_on": "solid",
                         "bc_warm_type": "temperature", "bc_warm_value": "250+100*t"}, {"theta": lambda t: 250 + 100 * t, "rates": False}),
        ("both", {**BY_RATE, **BY_HEAT, "bcs": "hold,warm", "bc_warm_on": "solid", "bc_warm_type": "temperature",
                  "bc_warm_value": "298.15+100*t"}, {"theta": lambda t: 298.15 + 100 * t})):
    stretch = lambda t: 1 + 0.01 * t * t
    run = runs.run(name, {**CELL, **more, "bc_hold_ux": "0.01*t*t*x", "ts_dt": 0.1, "ts_max_time": 2})
    phi, cost = recurrence(run["time"], stretch, **law)
    runs.check_between(f"{name}: phi at the end", run["phi_max"][-1], 0.3, 0.9)
    runs.check(f"{name}: largest error of phi", abs(run["phi_max"] - phi).max(), 0, 1e-8, relative=False)
    runs.check(f"{name}: largest error of what the crack costs", abs(run["energy_fracture"] - cost).max(), 0, 1e-8, relative=False)
    plain = GC / WIDTH * phi[-1] ** 2 / 2
    runs.check_between(f"{name}: that is not what Gc says", abs(cost[-1] / plain - 1), 0.05, 3)
slow = table("fast", [(a / fast, b) for a, b in RATES])
run = runs.run("explicit", {**CELL, **BY_RATE, "material_solid_Gc_rate": slow, "bc_hold_ux": f"0.01*(t/{fast})^2*x",
                            "ts_type": "central_difference", "ts_dt": 0.1 * fast, "material_solid_rho": 1e-9, "ts_max_time": 2 * fast,
                            "outputs": "hist", "output_hist_type": "csv", "output_hist_every": 1})
times = (run["time"] / fast).round(9)
phi, cost = recurrence(times, lambda t: 1 + 0.01 * t * t)
runs.check("explicit: largest error of phi", abs(run["phi_max"] - phi).max(), 0, 1e-8, relative=False)
runs.check("explicit: largest error of what the crack costs", abs(run["energy_fracture"] - cost).max(), 0, 1e-8, relative=False)

# A constant table is another Gc, in a body whose damage differs from place to place.
BLOCK = {**SOLID, "mesh_set_n": 4, "material_solid_damage_gradient": "material", "bcs": "clamp,pull", "bc_clamp_on": "left",
         "bc_clamp_type": "fix", "bc_pull_on": "right", "bc_pull_ux": "0.03*t*t", "ts_dt": 0.1, "ts_max_time": 1, "coupling_snes_atol": 1e-8}
twice = runs.run("twice", {**BLOCK, "material_solid_Gc": 2 * GC})
same = runs.run("same", {**BLOCK, "material_solid_Gc_rate": table("two", ((0, 2), (1, 2)))})
for column in ("phi_max", "energy_elastic", "energy_fracture", "reaction_pull_x"):
    runs.check(f"factor 2: {column} of twice the toughness", abs(same[column] - twice[column]).max() / abs(twice[column]).max(), 0, 1e-6,
               relative=False)

# First law, second order, heat, ranks, a restart, refused steps.
BLOCK.update(BY_RATE, bc_pull_ux="0.03*t*t", coupling_snes_atol=1e-6)
HEAT = {"material_solid_Gc_temperature": BY_HEAT["material_solid_Gc_temperature"], "material_solid_c_v": 0.05, "material_solid_alpha_t": 1e-5, "material_solid_conductivity": 1}
for name, more in (("", {}), (" with heat", HEAT), (" of second order", {"order": 2, "mesh_set_n": 2, "mesh_set_simplex": 1})):
    law = [abs(runs.run(f"law{name}_{n}".replace(" ", "_"), {**BLOCK, **more, "ts_dt": 0.1 / n})["balance_first_law"]).max() for n in (1, 2, 4)]
    runs.check_between(f"block{name}: residual of the first law falls with the steps", law[1] / law[2], 1.6, 5)
    runs.check(f"block{name}: first law with forty steps", law[2], 0, 2e-2, relative=False)
BLOCK.update(HEAT)
one = runs.run("block", {**BLOCK, "checkpoint_every": 5})
two = runs.run("block_two", BLOCK, ranks=2)
again = runs.run("again", {**BLOCK, "restart": "block/checkpoints/checkpoint_000001.h5"})
tried = runs.run("tried", {**BLOCK, "test_restep": 1}, refused=None)
for column in ("phi_max", "energy_fracture", "reaction_pull_x", "theta_max"):
    runs.check(f"2 ranks: {column}", abs(two[column] - one[column]).max() / abs(one[column]).max(), 0, 1e-8, relative=False)
    runs.require(f"restart: {column} bit for bit", (again[column][-5:] == one[column][-5:]).all())
    runs.require(f"steps tried twice: {column} bit for bit", (tried[column] == one[column]).all())

bad = table("bad", ((0, 1), (1, -1)))
for more, words in (({"material_solid_Gc_rate": bad}, "row 2"), ({"material_solid_damage_gradient": "spatial"}, "damage_gradient"),
                    ({"material_solid_fatigue": "asymptotic"}, "goes without"), ({"material_solid_c": 1}, "damage rate")):
    refused = runs.run("refused", {**CELL, **BY_RATE, "ts_dt": 1, "ts_max_time": 1, **more}, code=2)
    runs.require(f"refused, with a reason: {words}", words in refused.log)
runs.finish()
