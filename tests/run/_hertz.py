"""Runs of options/hertz.opts and what they show of the closed form."""
import os
import sys

import numpy
from _fields import pressed
from _runs import SOURCE, check, check_between, option_file, run

sys.path.insert(0, os.path.join(SOURCE, "tools"))
from plot_hertz import hertz  # noqa: E402

LIGHT = {"param_way": 0.0245, "mesh_set_patch": 0.9}  # a hundredth of the load, the fine patch a tenth as wide


class Indentation:
    """A run with its load per length, the closed form for that load and the nodal pressures at the end."""

    def __init__(self, name, options, refused=0):
        self.run = run(name, {"output_vis_every": 1000, "output_vis_dt": 10, **options}, files=[option_file("hertz.opts")],
                       refused=refused)
        self.load = 2 * abs(self.run["reaction_press_y"][-1])
        self.peak, self.width = hertz(self.load)
        self.X, self.x, self.p = pressed(self.run)

    def fitted(self):
        """Largest pressure and half width of the ellipse through the nodal pressures, over those of the closed form."""
        good = self.p > 0.2 * self.p.max()
        slope, top = numpy.polyfit(self.x[good] ** 2, self.p[good] ** 2, 1)
        return top**0.5 / self.peak, (-top / slope) ** 0.5 / self.width

    def scatter(self):
        """Root mean square distance of the nodal pressures from the closed form over its peak, within 0.8 a."""
        inner = self.x < 0.8 * self.width
        profile = self.peak * numpy.sqrt(1 - (self.x[inner] / self.width) ** 2)
        return numpy.sqrt(((self.p[inner] - profile) ** 2).mean()) / self.peak


def full_load(name, i):
    """The benchmark's load and its limits."""
    top, width = i.fitted()
    print(f"     {name}: load {i.load:.1f}, largest nodal pressure {i.p.max() / i.peak:.4f} p0, "
          f"length {i.run['contact_face_length'][-1] / i.width:.4f} a, rms of the profile {i.scatter():.4f} p0, "
          f"Newton iterations per step {i.run['newton'][1:].mean():.1f}, Uzawa passes {i.run['uzawa'].max():.0f}")
    check(f"{name}: load of 35 kN per mm", i.load, 35e3, 0.01)
    check(f"{name}: fitted largest pressure over p0", top, 1, 0.04)
    check(f"{name}: fitted half width over a", width, 1, 0.04)
    near = abs(i.x / i.width - 0.5).argmin()
    profile = (1 - (i.x[near] / i.width) ** 2) ** 0.5
    check(f"{name}: pressure at the node next to a/2 over the closed form there", i.p[near] / i.peak / profile, 1, 0.04)


def light_load(name, runs, falls):
    """Errors at a hundredth of the load, where strains are small, mesh after mesh."""
    errors = [i.scatter() for i in runs]
    for i, error in zip(runs, errors):
        print(f"     {name}: load {i.load:.2f}, rms distance from the closed form {error:.5f} p0, fitted p0 and a "
              f"{i.fitted()[0]:.4f}, {i.fitted()[1]:.4f}")
    for coarse, fine in zip(errors, errors[1:]):
        check_between(f"{name}: error with cells of half the size over that before", fine / coarse, 0.1, falls)
    return errors
