#!/usr/bin/env python3
"""Counts the pieces into which cracks cut a body.

    tools/fragments.py run/vis.xdmf --level 0.95 --least 1e-3

Nodes with phi below the level hang together where a cell joins them; a piece is what hangs together, with its part of the
cells, unless that is less than `least` of all of them. Prints for each time how many there are, and the largest and the
smallest part. `parts` does it for scripts.
"""
import argparse

import numpy as np
from fields import Fields


def parts(fields, grid, level=0.95, least=1e-3):
    """Parts of all cells that the pieces have, the largest first."""
    phi = fields.field(grid, "phi")[0][:, 0]
    whole = phi < level
    cells = [nodes for _, nodes, _ in fields.cells(grid)]
    label = np.arange(len(phi))
    while True:
        before = label.copy()
        for nodes in cells:
            least_label = np.where(whole[nodes], label[nodes], len(phi)).min(axis=1)
            for column in nodes.T:
                joined = whole[column]
                np.minimum.at(label, column[joined], least_label[joined])
        label = label[label]  # halves the way to the least one
        if np.array_equal(label, before):
            break
    number = sum(len(nodes) for nodes in cells)
    count = np.zeros(len(phi))
    for nodes in cells:
        best = np.take_along_axis(nodes, phi[nodes].argmin(axis=1)[:, None], axis=1)[:, 0]
        np.add.at(count, label[best][whole[best]], 1 / number)
    return np.sort(count[count >= least])[::-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xdmf")
    parser.add_argument("--level", type=float, default=0.95)
    parser.add_argument("--least", type=float, default=1e-3)
    options = parser.parse_args()
    fields = Fields(options.xdmf)
    for time, grid in zip(fields.times, fields.grids):
        found = parts(fields, grid, options.level, options.least)
        print(f"t = {time:g}: {len(found)} pieces" + (f", {found[0]:.3g} to {found[-1]:.3g} of the body" if len(found) else ""))


if __name__ == "__main__":
    main()
