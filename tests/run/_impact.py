"""Hertz's impact of elastic spheres: the closed form, and what a run of options/sphere_impact.opts says beside it."""
import numpy
from _runs import check


def hertz(radius, modulus, mass, speed):
    """Time, largest force and approach of an elastic impact (Johnson, Contact Mechanics, 11.4)."""
    stiffness = 4 / 3 * modulus * radius**0.5
    approach = (15 * mass * speed**2 / (16 * modulus * radius**0.5)) ** 0.4
    return 2.9432 * approach / speed, stiffness * approach**1.5, approach


def compare(r, reference, approach):
    """`reference`: what hertz returns; `approach`: the largest one of the run."""
    force = r["contact_foot_force_y"]
    on = numpy.nonzero(force)[0]
    dt = r["time"][1] - r["time"][0]
    check("time of contact", (on[-1] - on[0] + 1) * dt, reference[0], 0.03)
    check("largest force", force.max(), reference[1], 0.03)
    check("largest approach", approach, reference[2], 0.03)
