# labels: run long
# timeout: 3600
"""Fatigue of the compact specimen of the gallery under three loads: the higher the load the shorter the life, the crack
grows faster with the range of the stress intensity, and the rates of all loads lie on one line of Paris; by the variable of
the stress power, and by a toughness that falls."""
import os
import sys

import numpy

import _runs as runs

sys.path.insert(0, os.path.join(runs.SOURCE, "tools"))
import plot_fatigue  # noqa: E402

TOUGHNESS = {"material_strip_fatigue_a": 0, "material_strip_fatigue": "asymptotic", "material_strip_fatigue_threshold": "0.15 MPa",
             "material_strip_damage_gradient": "material", "energy_stop": 0}
for kind, more, exponents, scatter_allowed in (("power", {}, (1.5, 3), 1.4), ("toughness", TOUGHNESS, (3.5, 5.5), 1.8)):
    lives, all_dK, all_rates = [], [], []
    for load in (130, 160, 200):
        run = runs.run(f"{kind}_{load}", {"param_load": load, **more}, files=[runs.option_file("fatigue_ct.opts")])
        cycles, a, dK, rate = plot_fatigue.growth(run.dir, load)
        lives.append(cycles[-1])
        m, C, scatter = plot_fatigue.paris(dK, rate)
        print(f"     {kind}, {load} N/mm: first crack after {cycles[0]:g} cycles, {a[-1]:g} mm after {cycles[-1]:g}; m = {m:.2f}, "
              f"within a factor {scatter:.2f}")
        runs.check_between(f"{kind}, {load} N/mm: the rate rises with dK, exponent", m, *exponents)
        all_dK.append(dK)
        all_rates.append(rate)
    slopes = numpy.diff(numpy.log(lives)) / numpy.diff(numpy.log((130, 160, 200)))
    runs.check_between(f"{kind}: lives fall with the load: slope of log N over log load", slopes.max(), -6, -1.5)
    m, C, scatter = plot_fatigue.paris(numpy.concatenate(all_dK), numpy.concatenate(all_rates))
    runs.check_between(f"{kind}, all loads: exponent of Paris's law", m, *exponents)
    runs.check_between(f"{kind}, all loads: largest distance from its line, a factor", scatter, 1, scatter_allowed)
runs.finish()
