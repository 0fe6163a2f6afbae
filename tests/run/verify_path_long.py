# labels: run long
# timeout: 900
"""The notched beam of options/notched_beam.opts through its snap-back: crack length, load and deflection against linear fracture
mechanics, the first law over the path; Griffith's strip followed: the load of its crack, the energy by length, what a ring releases."""
import numpy

import _beam as beam
import _griffith as griffith
import _runs as runs

r = runs.run("beam", {}, [runs.option_file("notched_beam.opts")])
GC, GAMMA, H, NOTCH, CAP = 0.3, 0.6, 0.2, 2.0, 18.0
toughness = GC * (1 + 3 * H / (8 * GAMMA))
s, force = r["load_parameter"], -r["reaction_load_y"]
tip, energy = r["crack_beam_tip_y"], r["energy_fracture"]
runs.require(f"beam: {len(s) - 1} steps, at most 60", len(s) <= 61)
peak = force.argmax()
least = s[peak:].min()
runs.require(f"beam: the deflection falls from {s[peak]:.4f} to {least:.4f} mm and rises to {s[-1]:.4f}", least < 0.75 * s[peak] and s[-1] > 1.2 * least)
grows = (tip > 5) & (tip < 15)
runs.check("beam: energy by length of the crack over Gc (1 + 3h/(8 gamma))",
           numpy.polyfit(tip[grows], energy[grows], 1)[0] / toughness, 1, 0.05)
# Supports at points give way: by what the first step tells.
points = s[1] / force[1] - beam.compliance(numpy.array([NOTCH]))[0]
a = numpy.linspace(NOTCH, CAP, 2000)
deflection, bears = beam.curve(a, toughness)
expected = numpy.interp(-force, -bears, deflection) + points * force
worst = abs(s / expected - 1)[grows].max()
runs.check("beam: deflection over the force against fracture mechanics", worst, 0, 0.03, relative=False)
runs.check("beam: first law over the path", abs(r["balance_first_law"][peak:]).max(), 0, 1e-3, relative=False)
runs.check("beam: balance", abs(r["balance"]).max(), 0, 1e-10, relative=False)

GAMMA, H, LENGTH, SLOT = 0.08, 0.02, 3.0, 1.2
u_c = griffith.start_of_crack(GAMMA, H)
cost = griffith.GC * (1 + H / (2 * GAMMA))
strip = runs.run("strip", {"ts_path_dissipation": 0.03 * cost * (LENGTH - SLOT), "param_uc": u_c, "ts_times": "0,2.4", "ts_dts": 0.05,
                           "coupling_snes_atol": 2e-5, "output_vis_dt": 10, "mesh_set_h": H, "mesh_set_length": LENGTH,
                           "mesh_set_slot": SLOT, "material_strip_gamma": GAMMA, "releases": "tip", "release_tip_at": "1.8,0",
                           "release_tip_inner": 6 * GAMMA, "release_tip_outer": 0.9}, [runs.option_file("griffith_strip.opts")])
s, tip = strip["load_parameter"], strip["crack_strip_tip_x"]
start = numpy.nonzero(tip > SLOT)[0][0]
on_way = (tip > SLOT + 0.4) & (tip < LENGTH - 0.5)
runs.require(f"strip: {len(s) - 1} steps, at most 60, {on_way.sum()} of them far from both ends", len(s) <= 61 and on_way.sum() > 10)
runs.check("strip: largest load before the crack starts over that by energies", s[:start].max(), 1, 0.03)
runs.check("strip: load of the crack on its way over that by energies", abs(s[on_way] - 1).max(), 0, 0.03, relative=False)
# The strip's own damage ahead of the crack stays behind it.
by_length = numpy.polyfit(tip[on_way], strip["energy_fracture"][on_way], 1)[0]
runs.check("strip: energy by length of the crack over Gc (1 + h/(2 gamma))", by_length / cost, 1, 0.05)
runs.check("strip: the same over what the crack costs beyond the damage ahead", by_length / griffith.cost(u_c, GAMMA, H), 1, 0.03)
near = abs(tip - 1.8) < 0.1
runs.check("strip: what a ring around the tip releases over what the strip ahead holds", numpy.mean(
    [g / griffith.released(u_c * load, GAMMA) for g, load in zip(strip["release_tip"][near], s[near])]), 1, 0.01)
runs.check("strip: first law over the path", abs(strip["balance_first_law"]).max(), 0, 1e-3, relative=False)
runs.finish()
