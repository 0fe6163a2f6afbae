#!/usr/bin/env python3
"""Draw the contact pressure of runs of options/hertz.opts or hertz_sphere.opts beside Hertz's closed form.

    tools/plot_hertz.py hertz.png coarse fine

The load of the closed form is that of each run's last time: twice that of the half cylinder, four times that of the
quarter of the sphere.
"""
import argparse
import os

import numpy as np
from fields import Fields

import plot_history

RADIUS, MODULI, NU = 50.0, (70e3, 210e3), 0.3  # of options/hertz.opts; mm, MPa
SPHERE, STEEL = 10.0, 210e3  # of options/hertz_sphere.opts


def hertz(load, radius=RADIUS):
    """Largest pressure and half width of a line contact under a load per length (Johnson, Contact Mechanics, 4.2)."""
    modulus = 1 / sum((1 - NU**2) / E for E in MODULI)
    return (load * modulus / (np.pi * radius))**0.5, (4 * load * radius / (np.pi * modulus))**0.5


def hertz_sphere(load):
    """Largest pressure and radius of a sphere on a rigid plane (Johnson, Contact Mechanics, 4.2)."""
    radius = (0.75 * load * SPHERE * (1 - NU**2) / STEEL)**(1 / 3)
    return 1.5 * load / (np.pi * radius**2), radius


def read(folder):
    """Load and unit, distance from the middle and pressure of the pressed nodes at the last time; peak and width of Hertz."""
    history, _ = plot_history.read(os.path.join(folder, "history.csv"))
    fields = Fields(os.path.join(folder, "vis.xdmf"))
    grid = fields.grids[-1]
    x = fields.places(fields.grids[0])
    u, p = fields.field(grid, "u")[0], fields.field(grid, "contact_pressure")[0][:, 0]
    nodes = np.flatnonzero(p > 0)
    if "contact_foot_force_z" in history:
        load = 4 * history["contact_foot_force_y"][-1]
        return f"{load:.1f} N", np.hypot(x[nodes, 0], x[nodes, 2]), p[nodes], hertz_sphere(load)
    nodes = nodes[np.argsort(x[nodes, 0])]
    load = 2 * abs(history["reaction_press_y"][-1])
    return f"{load / 1e3:.2f} kN/mm", (x[:, 0] + u[:, 0])[nodes], p[nodes], hertz(load)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figure")
    parser.add_argument("output_dir", nargs="+")
    options = parser.parse_args()
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axis = plt.subplots(figsize=(6.4, 4))
    for k, folder in enumerate(options.output_dir):
        load, x, p, (peak, width) = read(folder)
        axis.plot(x, p, "os^vD"[k % 5], ms=4, mfc="none", color=plot_history.COLOURS[k % 8],
                  label=f"{os.path.basename(os.path.normpath(folder))}, {load}")
        along = np.linspace(0, width, 400)
        axis.plot(along, peak * np.sqrt(1 - (along / width)**2), "-", lw=1, color=plot_history.COLOURS[k % 8])
    axis.set(xlabel="distance from the middle (mm)", ylabel="contact pressure (MPa)", xlim=(0, None), ylim=(0, None))
    axis.legend(frameon=False, title="points: runs, lines: Hertz")
    axis.grid(True, lw=0.4, color="0.88")
    figure.tight_layout()
    figure.savefig(options.figure, dpi=200)


if __name__ == "__main__":
    main()
