#!/usr/bin/env python3
"""Counts the cracks that run in from the upper side of a plane body, at several depths below it.

    tools/crack_spacing.py run/vis.xdmf --depths 0.05,0.1,0.2 --level 0.9

A crack is a piece of the line at a depth on which phi is above the level; one at an end of the line is half a crack.
Prints for each time the number of cracks and their mean spacing, in the lengths of the run. `count` does it for scripts.
"""
import argparse

import numpy as np
from fields import Fields, triangles



class Slab:
    """Reference places and triangles of the field file of a run."""

    def __init__(self, path):
        self.fields = Fields(path)
        grid = self.fields.grids[0]
        self.x = self.fields.places(grid)[:, :2]
        self.triangles, _ = triangles([(nodes, index) for _, nodes, index in self.fields.cells(grid)])
        self.times = self.fields.times
        self.low, self.high = self.x.min(axis=0), self.x.max(axis=0)

    def along(self, k, depth, points=4001):
        """x and phi on the line at a depth below the upper side, at the k-th time."""
        import matplotlib.tri as tri
        phi = self.fields.field(self.fields.grids[k], "phi")[0][:, 0]
        x = np.linspace(self.low[0], self.high[0], points)
        # within the triangles of the ends
        inside = np.clip(x, self.low[0] + 1e-9 * (x[1] - x[0]), self.high[0] - 1e-9 * (x[1] - x[0]))
        y = np.full(points, self.high[1] - max(depth, 1e-9 * (self.high[1] - self.low[1])))
        line = tri.LinearTriInterpolator(tri.Triangulation(self.x[:, 0], self.x[:, 1], self.triangles), phi)(inside, y)
        return x, np.ma.filled(line, 0.0)

    def count(self, k, depth, level=0.9):
        """Cracks that cross the line at a depth at the k-th time: their number and their places."""
        x, phi = self.along(k, depth)
        change = np.diff(np.concatenate([[False], phi > level, [False]]).astype(int))
        first, last = np.flatnonzero(change == 1), np.flatnonzero(change == -1) - 1
        halves = (first == 0).astype(float) + (last == len(x) - 1)
        return float(np.sum(1 - 0.5 * halves)), 0.5 * (x[first] + x[last])

    def spacing(self, k, depth, level=0.9):
        """Mean distance of cracks at a depth, infinite where there is none."""
        cracks, _ = self.count(k, depth, level)
        return (self.high[0] - self.low[0]) / cracks if cracks else np.inf


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xdmf")
    parser.add_argument("--depths", default="0.05,0.1,0.2,0.3,0.5")
    parser.add_argument("--level", type=float, default=0.9)
    options = parser.parse_args()
    slab = Slab(options.xdmf)
    depths = [float(word) for word in options.depths.split(",")]
    for k, time in enumerate(slab.times):
        cracks = [f"{slab.count(k, depth, options.level)[0]:g} ({slab.spacing(k, depth, options.level):.3g})" for depth in depths]
        print(f"t = {time:g}: " + ", ".join(f"{text} at {depth:g}" for text, depth in zip(cracks, depths)))


if __name__ == "__main__":
    main()
