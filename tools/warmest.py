#!/usr/bin/env python3
"""Where a body has warmed most: the largest rise of the temperature since the first written time, at each later one.

    tools/warmest.py run/vis.xdmf --at 0.01,0.006 --within 0.001

Places are of the reference bodies, in the lengths of the run. With --at also the distance to that point, and the largest rise farther
from it than `r` (1 without --within), in the length of the run.
"""
import argparse

import numpy as np
from fields import Fields, stop



def rises(path):
    """Places of the nodes, and for each written time but the first (t, rise of theta at the nodes)."""
    fields = Fields(path)
    x = fields.places(fields.grids[0])
    if fields.field(fields.grids[0], "theta") is None:
        stop(f"{path} holds no theta")
    theta = [fields.field(grid, "theta")[0][:, 0] for grid in fields.grids]
    return x, [(t, now - theta[0]) for t, now in zip(fields.times[1:], theta[1:])]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xdmf")
    parser.add_argument("--at")
    parser.add_argument("--within", type=float, default=1.0)
    options = parser.parse_args()
    x, times = rises(options.xdmf)
    away = None
    if options.at:
        point = np.array([float(word) for word in options.at.split(",")])
        away = np.linalg.norm(x[:, :len(point)] - point, axis=1)
    for t, rise in times:
        k = rise.argmax()
        text = f"t = {t:g}: {rise[k]:.4g} K at ({', '.join(f'{c:.4g}' for c in x[k])})"
        if away is not None:
            text += f", {away[k]:.3g} away; {rise[away > options.within].max():.4g} K farther than {options.within:g}"
        print(text)


if __name__ == "__main__":
    main()
