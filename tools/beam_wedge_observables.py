#!/usr/bin/env python3
"""Print what a run of options/beam_wedge.opts shows beside its limits; exit status 1 when one is missed.

    tools/beam_wedge_observables.py demo-output/beam_wedge

The limits describe the paper's figure 5: a crack that begins at the slit and runs upwards, brittle in an elasto-plastic
beam. Lengths in mm, forces in N per mm of thickness, times in s; the sizes are the ones of meshes/beam_wedge.geo.
"""
import argparse
import os
import sys

import numpy as np
from fields import Fields

import plot_history

NOTCH, DEPTH, TOUCH, EDGE = 10.0, 6.0, 51.0, 1.2
FACET = 0.2  # of the wedge's upper edge; the contact's tolerance is a thousandth of it
ROOT_REACH, CONTACT_REACH = 1.0, 0.5
MM, N_PER_MM = 1e3, 1e-3  # from m and N/m


def first(time, values, level):
    """The time at which the values first exceed the level; nan when they never do."""
    above = np.flatnonzero(values > level)
    return time[above[0]] if above.size else np.nan


def distance_to_root(x):
    """From the upper edge of the slit."""
    aside = np.maximum(np.abs(x[:, 0] - NOTCH) - 0.125, 0)
    return np.hypot(aside, x[:, 1] - DEPTH)


def read_fields(folder):
    """Times, node coordinates [node][2], phi [time][node], cell centres [cell][2], alpha [time][cell]."""
    fields = Fields(os.path.join(folder, "vis.xdmf"))
    x = MM * fields.places(fields.grids[0])[:, :2]
    phi = np.array([fields.field(grid, "phi")[0][:, 0] for grid in fields.grids])
    alpha = np.array([fields.field(grid, "alpha")[0][:, 0] for grid in fields.grids])
    centre = np.empty((alpha.shape[1], 2))
    for _, nodes, index in fields.cells(fields.grids[0]):
        centre[index] = x[nodes].mean(axis=1)
    return fields.times, x, phi, centre, alpha


def observables(folder):
    """Rows (what, measured, low, high)."""
    history, _ = plot_history.read(os.path.join(folder, "history.csv"))
    time = history["time"]
    force = N_PER_MM * np.abs(history["reaction_push_y"])
    peak = int(force.argmax())
    times, x, phi, centre, alpha = read_fields(folder)
    rows = []

    def row(what, value, low, high):
        rows.append((what, float(value), low, high))

    row("time of the largest force", time[peak], 0.08, 0.16)
    row("largest force", force[peak], 0, np.inf)
    row("time of phi > 0.5", first(time, history["phi_max"], 0.5), 0.10, 0.16)
    row("time of phi > 0.95", first(time, history["phi_max"], 0.95), 0.10, 0.18)
    row("force at t = 0.24 over the largest", np.interp(0.24, time, force) / force[peak], 0, 0.2)

    broken = np.flatnonzero((phi > 0.9).any(axis=1))
    begin = phi[broken[0]] if broken.size else phi[-1]
    row("first phi > 0.9: distance to the slit", distance_to_root(x[[begin.argmax()]])[0] if broken.size else np.nan,
        0, 0.75)

    # The crack's middle on each row of nodes in the ligament.
    levels = np.unique(np.round(x[np.abs(x[:, 0] - NOTCH) < 0.05][:, 1], 4))
    levels = levels[levels > DEPTH - 1e-6]
    aside, reached = [], 0
    for level in levels:
        on = (np.abs(x[:, 1] - level) < 1e-3) & (phi[-1] > 0.95)
        if on.any():
            reached += 1
            aside.append(abs(np.average(x[on, 0], weights=phi[-1][on]) - NOTCH))
    row("part of the ligament with phi > 0.95", reached / len(levels), 0.7, 1)
    row("crack's largest distance from its vertical", max(aside, default=np.nan), 0, 0.35)

    under = np.maximum(np.abs(centre[:, 0] - (TOUCH - EDGE / 2)) - EDGE / 2, 0)
    away = (distance_to_root(centre) > ROOT_REACH) & (np.hypot(under, centre[:, 1]) > CONTACT_REACH)
    row("alpha 1 mm from the root, 0.5 mm from contact", alpha[:, away].max(), 0, 1e-4)
    row("largest alpha", alpha.max(), 1e-3, np.inf)
    row("deepest penetration over its tolerance", -MM * history["contact_tip_gap_min"].min() / (1e-3 * FACET), -np.inf, 1)
    # Before the crack opens 2e-4; the crack's jump, which no step resolves, loses the rest.
    start = np.searchsorted(time, first(time, history["phi_max"], 0.6)) - 1
    row("first-law residual before the crack opens", np.abs(history["balance_first_law"][start]), 0, 1e-3)
    row("first-law residual over the external work", np.abs(history["balance_first_law"][-1]), 0, 5e-3)
    row("largest momentum balance", np.abs(history["balance"]).max(), 0, 1e-10)
    # The two reactions differ by the inertia of the bodies; what they leave in a step is momentum. The force of closing cracks
    # acts on the clamp over a step as a whole: the mean of both ends leaves out half a step of it.
    left = history["reaction_push_y"] + history["reaction_clamp_y"]
    impulse = np.append(0, np.cumsum((left[1:] + left[:-1]) / 2 * np.diff(time)))
    gained = history["momentum_beam_y"] + history["momentum_wedge_y"]
    row("impulse of the reactions against the momentum", np.abs(impulse - (gained - gained[0])).max() * N_PER_MM
        / (force[peak] * time[-1]), 0, 1e-6)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output_dir")
    folder = parser.parse_args().output_dir
    missed = 0
    for what, value, low, high in observables(folder):
        good = low <= value <= high
        missed += not good
        limit = f"<= {high:g}" if low in (0, -np.inf) else f">= {low:g}" if high == np.inf else f"{low:g} to {high:g}"
        print(f"{'ok  ' if good else 'FAIL'} {what:48s} {value:12.5g}   {limit}")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
