# labels: run long
# timeout: 3600
"""Fatigue of the compact specimen of the gallery under three loads: the higher the load the shorter the life, the crack
grows faster with the range of the stress intensity, and the rates of all loads lie on one line of Paris."""
import os
import sys

import numpy

import _runs as runs

sys.path.insert(0, os.path.join(runs.SOURCE, "tools"))
import plot_fatigue  # noqa: E402

lives, all_dK, all_rates = [], [], []
for load in (130, 160, 200):
    run = runs.run(f"load_{load}", {"param_load": load}, files=[runs.option_file("fatigue_ct.opts")])
    cycles, a, dK, rate = plot_fatigue.growth(run.dir, load)
    lives.append(cycles[-1])
    m, C, scatter = plot_fatigue.paris(dK, rate)
    print(f"     {load} N/mm: first crack after {cycles[0]:g} cycles, {a[-1]:g} mm after {cycles[-1]:g}; m = {m:.2f}, "
          f"within a factor {scatter:.2f}")
    runs.check_between(f"{load} N/mm: the rate rises with dK, exponent", m, 1.5, 3)
    all_dK.append(dK)
    all_rates.append(rate)
slopes = numpy.diff(numpy.log(lives)) / numpy.diff(numpy.log((130, 160, 200)))
runs.check_between("lives fall with the load: slope of log N over log load", slopes.max(), -6, -1.5)
m, C, scatter = plot_fatigue.paris(numpy.concatenate(all_dK), numpy.concatenate(all_rates))
runs.check_between("all loads: exponent of Paris's law", m, 1.7, 3)
runs.check_between("all loads: largest distance from its line, a factor", scatter, 1, 1.4)
runs.finish()
