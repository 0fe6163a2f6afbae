# labels: run long
# timeout: 900
# processors: 2
"""The notched beam of options/notched_beam.opts through its snap-back: crack length, load and deflection against linear fracture
mechanics, the first law over the path; Griffith's strip followed: the load of its crack and the energy by length; 1e5 unknowns."""
import numpy

import _beam as beam
import _griffith as griffith
import _runs as runs

r = runs.run("beam", {}, [runs.option_file("notched_beam.opts")], ranks=2)
GC, GAMMA, H, NOTCH, CAP = 0.3, 0.4, 0.1, 2.0, 18.0
toughness = GC * (1 + 3 * H / (8 * GAMMA))
s, force = r["load_parameter"], -r["reaction_load_y"]
tip, energy = r["crack_beam_tip_y"], r["energy_fracture"]
runs.require(f"beam: {len(s) - 1} steps, at most 60", len(s) <= 61)
peak = s.argmax()
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

GAMMA, H, LENGTH, SLOT = 0.06, 0.015, 3.5, 1.2
u_c = griffith.start_of_crack(GAMMA, H)
cost = griffith.GC * (1 + H / (2 * GAMMA))
strip = runs.run("strip", {"ts_path_dissipation": 0.05 * cost * (LENGTH - SLOT), "param_uc": u_c, "ts_times": "0,4", "ts_dts": 0.1,
                           "output_vis_dt": 10}, [runs.option_file("griffith_strip.opts")], ranks=2)
s, tip = strip["load_parameter"], strip["crack_strip_tip_x"]
runs_on = (tip > SLOT + 0.5) & (tip < LENGTH - 0.8)
runs.require(f"strip: {runs_on.sum()} steps on the way", runs_on.sum() >= 5)
runs.check("strip: largest load over that by energies", s[:len(s)][~(tip > SLOT + 0.5)].max(), 1, 0.03)
runs.check("strip: load of the crack on its way over that by energies", s[runs_on].mean(), 1, 0.03)
psi, phi = griffith.damage_ahead(u_c * s[runs_on].mean(), GAMMA)
by_length = numpy.polyfit(tip[runs_on], strip["energy_fracture"][runs_on], 1)[0] + 2 * griffith.HALF * griffith.GC / (2 * GAMMA) * phi**2
runs.check("strip: energy by length, with the strip's own damage, over Gc (1 + h/(2 gamma))", by_length / cost, 1, 0.05)
runs.check("strip: first law over the path", abs(strip["balance_first_law"]).max(), 0, 1e-3, relative=False)
runs.finish()
