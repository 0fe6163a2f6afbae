# labels: run
# timeout: 120
# long: 200
"""Two equal elastic bars exchange their velocities (wave theory, nu = 0): contact lasts 2 L/c, the force
is rho c v A / 2, the energy never exceeds its start, impulses on both bodies are equal and opposite."""
import numpy
from _runs import check, check_between, finish, long, option_file, require, run

L, E, RHO, V, WIDTH = 0.1, 70e9, 2800.0, 2.0, 1e-3
C = (E / RHO) ** 0.5
FORCE = RHO * C * V / 2 * WIDTH
MOMENTUM = RHO * L * WIDTH * V
GAP = 1e-5
# The default of -motion_snes_atol, 1e-12 E h = 3.5e-5 N, leaves 1e-11 of the momentum after 600 steps, and an iteration
# that moves the flying bar by 1e-12 of its way may leave 1e-5 N.
BASE = {"mesh_set_gap": GAP * 1e3, "output_vis_every": 100000, "motion_snes_atol": 1e-7}
# Augmented multipliers. Semismooth ones, the default, follow rounding of the gap: 1e-20 m times the stiffness of their linear
# solves is 1e-5 N in each step.
POINTS = {**BASE, "contact_face_method": "gpts", "contact_face_enforce": "auglag"}


def energy(r):
    total = r["energy_kinetic"] + r["energy_elastic"]
    return total / total[0]


def closed(r):
    """First and last time at which the contact carries a force."""
    on = numpy.nonzero(r["contact_face_force_x"])[0]
    return r["time"][on[0]], r["time"][on[-1]]


def plateau(r):
    start = GAP / V
    middle = (r["time"] > start + L / (2 * C)) & (r["time"] < start + 3 * L / (2 * C))
    return -r["contact_face_force_x"][middle]


def exchange(r, most_uzawa, most_newton, rounding=1e-12):
    start, end = closed(r)
    check("first touch at gap / v, within a step", start, GAP / V, 1.001e-7, relative=False)
    check("contact time 2 L/c", end - start, 2 * L / C, 0.02)
    check("mean plateau force rho c v A / 2", plateau(r).mean(), FORCE, 0.02)
    check("largest excursion from the plateau", abs(plateau(r) - FORCE).max() / FORCE, 0, 0.02, relative=False)
    check("velocity of the target", r["momentum_target_x"][-1] / MOMENTUM * V, V, 0.01)
    check("velocity of the striker", r["momentum_striker_x"][-1] / MOMENTUM * V, 0, 0.01 * V, relative=False)
    total = r["momentum_striker_x"] + r["momentum_target_x"]
    check("change of the total momentum, relative", abs(total / MOMENTUM - 1).max(), 0, 1e-12, relative=False)
    jump = r["momentum_striker_x"] - MOMENTUM + r["momentum_target_x"]
    check("impulses on both bodies add to zero, relative", abs(jump).max() / MOMENTUM, 0, 1e-12, relative=False)
    check("impulse of the contact is the change of momentum, relative",
          abs(r["impulse_face_x"][-1] + r["momentum_target_x"][-1]) / MOMENTUM, 0, rounding, relative=False)
    check_between("most Uzawa passes in a step", r["uzawa"].max(), 1, most_uzawa)
    check_between("most Newton iterations in a step", r["newton"].max(), 1, most_newton)
    check_between("tries of a step", r["tries"].max(), 1, 1)


print("stabilised update, rho = 0.9 (options/bars_impact.opts)")
r = run("damped", POINTS, files=[option_file("bars_impact.opts")])
require("the program says that the update is stabilised", "impact update: contact-stabilised" in r.log)
exchange(r, 6, 14)
check_between("largest energy / energy at the start", energy(r).max(), 0.97, 1 + 1e-9)
check_between("energy at the end / energy at the start", energy(r)[-1], 0.97, 1)

if long():
    print("stabilised update, undamped Newmark, multipliers to 1e-6: the energy decays by theory")
    r = run("undamped", {**POINTS, "ts_newmark_rho": 1, "contact_face_pressure_tol": 1e-6},
            files=[option_file("bars_impact.opts")])
    exchange(r, 9, 12)
    check_between("largest energy / energy at the start", energy(r).max(), 0.97, 1 + 1e-9)
    check_between("energy at the end / energy at the start", energy(r)[-1], 0.97, 1)

if long():
    print("the same by the default form, mortar with semismooth multipliers")
    r = run("default", BASE, files=[option_file("bars_impact.opts")])
    exchange(r, 1, 12, rounding=1e-10)
    check_between("largest energy / energy at the start", energy(r).max(), 0.97, 1 + 1e-9)

if long():  # verify_energy_tol has the gain of a shorter one
    print("without stabilisation, undamped: recorded, it must be worse")
    r = run("bare", {**BASE, "ts_newmark_rho": 1, "contact_face_impact": "none", "energy_stop": 0},
            files=[option_file("bars_impact.opts")])
    open_steps = numpy.count_nonzero(r["contact_face_force_x"][(r["time"] > 1e-5) & (r["time"] < 4e-5)] == 0)
    print(f"     energy grows to {energy(r).max():.3f} times its start, open in {open_steps} of 300 steps, force from "
          f"{-plateau(r).max() / FORCE:.2f} to {plateau(r).max() / FORCE:.2f} times the plateau")
    check_between("largest energy / energy at the start", energy(r).max(), 1.5, 100)
finish()
