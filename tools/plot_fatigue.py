#!/usr/bin/env python3
"""Crack, its length over cycles and its rate over the range of the stress intensity, of runs of options/fatigue_ct.opts.

    tools/plot_fatigue.py fatigue.png fatigue_ct fatigue_ct_200:200

The crack is the farthest node with phi above -crack_level (crack_strip_tip_x). It moves from node to node, so that a
rate is that of a straight line through `WINDOW` first times at which it has reached a node. K is that of ASTM E647 for
a compact specimen. `load` (N per mm of thickness) is the largest of a cycle, that of the file unless it is given.
The picture of the crack is phi in the strip, mirrored, at the last written time before the final break of the first run.
Prints the life and the fit da/dN = C dK^m of each run and of all together.
"""
import argparse
import os

import numpy as np
from fields import Fields

import plot_history

WIDTH, HEIGHT, LOAD, RATIO, WINDOW, BREAK = 50.0, 1.0, 160.0, 0.1, 7, 1.5  # of options/fatigue_ct.opts; mm, N/mm


def stress_intensity(load, a):
    """K in MPa sqrt(m) at a load per thickness in N/mm and a crack of a mm (ASTM E647, 9.3)."""
    x = a / WIDTH
    shape = (2 + x) / (1 - x)**1.5 * (0.886 + 4.64 * x - 13.32 * x**2 + 14.72 * x**3 - 5.6 * x**4)
    return load / WIDTH**0.5 * shape / 1000**0.5


def growth(folder, load):
    """Cycles and lengths at which the crack reaches a node, up to the break, which jumps; dK and da/dN between them."""
    history, _ = plot_history.read(os.path.join(folder, "history.csv"))
    t, tip = np.array(history["time"]), np.array(history["crack_strip_tip_x"])
    known = ~np.isnan(tip)
    a, first = np.unique(np.round(np.maximum.accumulate(tip[known]), 9), return_index=True)
    cycles = t[known][first]
    jumps = np.flatnonzero(np.diff(a) > BREAK)
    if jumps.size:
        a, cycles = a[:jumps[0] + 1], cycles[:jumps[0] + 1]
    dK, rate = [], []
    for i in range(len(a) - WINDOW + 1):
        part = slice(i, i + WINDOW)
        rate.append(np.polyfit(cycles[part], a[part], 1)[0])
        dK.append((1 - RATIO) * stress_intensity(load, a[part].mean()))
    return cycles, a, np.array(dK), np.array(rate)


def paris(dK, rate):
    """Exponent and factor of da/dN = C dK^m, and the largest distance of a point from it, as a factor."""
    m, logarithm = np.polyfit(np.log(dK), np.log(rate), 1)
    return m, np.exp(logarithm), np.exp(abs(np.log(rate) - logarithm - m * np.log(dK)).max())


def draw_crack(axis, folder):
    """phi in the strip at the last time at which some of the ligament is whole."""
    fields = Fields(os.path.join(folder, "vis.xdmf"))
    x = fields.places(fields.grids[0])
    inside = (x[:, 0] > 15.9) & (x[:, 0] < 42.1) & (x[:, 1] < HEIGHT + 0.1)
    for grid, time in reversed(list(zip(fields.grids, fields.times))):
        phi = fields.field(grid, "phi")[0][:, 0]
        if phi[inside & (x[:, 0] > 36)].max() < 0.5:
            break
    for side in (1, -1):
        filled = axis.tricontourf(x[inside, 0], side * x[inside, 1], phi[inside], levels=np.linspace(0, 1.0001, 11), cmap="magma_r")
    axis.set(xlabel="x (mm)", ylabel="y (mm)", title=f"phi, cycle {time:g}", aspect="equal")
    return filled


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figure")
    parser.add_argument("run", nargs="+", metavar="output_dir[:load]")
    options = parser.parse_args()
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure = plt.figure(figsize=(8.4, 5.2), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(1, 2))
    crack, length, speed = (figure.add_subplot(part) for part in (grid[0, :], grid[1, 0], grid[1, 1]))
    figure.colorbar(draw_crack(crack, options.run[0].partition(":")[0]), ax=crack, ticks=(0, 0.5, 1))
    all_dK, all_rates = [], []
    for k, word in enumerate(options.run):
        folder, _, load = word.partition(":")
        load = float(load or LOAD)
        cycles, a, dK, rate = growth(folder, load)
        m, C, scatter = paris(dK, rate)
        print(f"{folder}: load {load:g} N/mm, first crack after {cycles[0]:g} cycles, {a[-1]:g} mm after {cycles[-1]:g}; "
              f"dK {dK[0]:.2f} to {dK[-1]:.2f} MPa sqrt(m), da/dN {rate[0]:.4g} to {rate[-1]:.4g} mm, m = {m:.2f}, "
              f"C = {C:.3g}, within a factor {scatter:.2f}")
        all_dK.append(dK)
        all_rates.append(rate)
        colour = plot_history.COLOURS[k % 8]
        length.step(cycles, a, where="post", color=colour, label=f"{load:g} N/mm")
        speed.loglog(dK, rate, "os^v"[k % 4], ms=4, mfc="none", color=colour, label=f"{load:g} N/mm")
    m, C, scatter = paris(np.concatenate(all_dK), np.concatenate(all_rates))
    print(f"all: m = {m:.2f}, C = {C:.3g}, within a factor {scatter:.2f}")
    along = np.array([min(map(min, all_dK)), max(map(max, all_dK))])
    speed.loglog(along, C * along**m, "-", lw=1, color="0.4", label=f"m = {m:.2f}")
    length.set(xlabel="cycles", ylabel="crack length (mm)")
    speed.set(xlabel="range of K (MPa m$^{1/2}$)", ylabel="da/dN (mm)")
    for axis in (length, speed):
        axis.legend(frameon=False, loc="lower right")
        axis.grid(True, which="both", lw=0.4, color="0.88")
    figure.savefig(options.figure, dpi=110)


if __name__ == "__main__":
    main()
