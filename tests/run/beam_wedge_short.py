# labels: run
# timeout: 120
"""The first 20 steps of beam_wedge.opts, before plasticity and with hardly any damage, against beam theory: a cantilever in
plane strain (bending, shear), the rotation at an edge crack as deep as the slit (Tada, Paris, Irwin: theta = 4 sigma V2(a/W)
/ E'), the shortening of the wedge and the indentation of the beam to its middle (Johnson, Contact mechanics, 5.6). The
wedge's left corner carries. What the theory leaves out (the wedge's own indentation, the width of the slit, the first
damage) makes the bodies softer by a few per cent."""
import math

import numpy

from _runs import check, check_between, finish, option_file, run

r = run("start", {"ts_max_steps": 20, "output_vis_dt": 1, "output_vis_times": 1}, [option_file("beam_wedge.opts")], ranks=2)
force = r["reaction_push_y"]

E, nu, W, a, notch, corner, edge, down = 72e9, 0.33, 21e-3, 6e-3, 10e-3, 49.8e-3, 1.2e-3, 6e-3
plane = E / (1 - nu * nu)
bending = corner**3 / (3 * plane * W**3 / 12)
shear = 1.2 * corner * 2 * (1 + nu) / (E * W)
z = a / W
V2 = (z / (1 - z))**2 * (5.93 - 19.69 * z + 37.14 * z**2 - 35.84 * z**3 + 13.12 * z**4)
slit = 24 * V2 / plane * ((corner - notch) / W)**2
widening = 2.8e-3 / edge
wedge = down / (plane * edge) * math.log(1 + widening) / widening
half = r["contact_tip_length"][8] / 2
indentation = (2 * math.log(W / half) - nu / (1 - nu)) / (math.pi * plane)
# The viscous force is the same in both steps.
slope = (force[12] - force[4]) / (r["mean_push_uy"][12] - r["mean_push_uy"][4])
check("stiffness, N/m per m", slope, 1 / (bending + shear + slit + wedge + indentation), 0.05)



def impulse(reaction):
    return numpy.append(0, numpy.cumsum((reaction[1:] + reaction[:-1]) / 2 * numpy.diff(r["time"])))


# What the contact and the supports leave of each other's impulse is momentum of the body between them. What a split keeps of
# the compression of damaged points acts on the clamp over a step as a whole; the mean of both ends leaves out half of it.
scale = numpy.abs(force).max() * r["time"][-1]
for body, support, sign, tolerance in (("wedge", "push", 1, 1e-10), ("beam", "clamp", -1, 1e-8)):
    left = impulse(r[f"reaction_{support}_y"]) + sign * r["impulse_tip_y"]
    momentum = r[f"momentum_{body}_y"] - r[f"momentum_{body}_y"][0]
    check_between(f"impulse on the {body} against its momentum", numpy.abs(left - momentum).max() / scale, 0, tolerance)
check_between("deepest penetration over a thousandth of a facet", -r["contact_tip_gap_min"].min() / 2e-7, 0, 1)
check_between("smallest pressure over the largest", r["contact_tip_pressure_min"].min() / r["contact_tip_pressure_max"].max(),
              0, 1)
check_between("kinetic over elastic energy", r["energy_kinetic"][-1] / r["energy_elastic"][-1], 0, 1e-3)
check_between("energy gained over the elastic one", r["gain"].max() / r["energy_elastic"][-1], 0, 1e-9)
check_between("largest alpha", r["alpha_max"].max(), 0, 0)
finish()
