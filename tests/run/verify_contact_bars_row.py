# labels: run
# timeout: 120
"""Bars of unequal length and three equal bars in a row (wave theory, nu = 0, mortar): a short striker stops dead and leaves
its momentum in the long target, a long one keeps half of its velocity; in a row the last bar leaves with the velocity of
the first, 3 L/c after the first touch, and the others rest."""
import numpy
from _runs import check, check_between, finish, option_file, run

L, E, RHO, V, WIDTH, GAP = 0.1, 70e9, 2800.0, 2.0, 1e-3, 1e-5
C = (E / RHO) ** 0.5
FORCE = RHO * C * V / 2 * WIDTH
MOMENTUM = RHO * L * WIDTH * V
# On one rank a direct solver, without the cost of one that is made for many.
SOLVER = {"motion_ksp_type": "gmres", "motion_ksp_rtol": 1e-12, "motion_pc_type": "bjacobi", "motion_sub_pc_type": "lu"}


def pressed(r, contact):
    """Times between which the contact carries more than half of the plateau."""
    on = numpy.flatnonzero(-r[f"contact_{contact}_force_x"] > FORCE / 2)
    return r["time"][on[0]], r["time"][on[-1]]


def plateau(claim, r, contact, first, last):
    middle = (r["time"] > first + (last - first) / 4) & (r["time"] < last - (last - first) / 4)
    check(f"{claim}: plateau rho c v A / 2, largest excursion",
          abs(-r[f"contact_{contact}_force_x"][middle] / FORCE - 1).max(), 0, 0.02, relative=False)


def books(claim, r, bodies):
    total = sum(r[f"momentum_{body}_x"] for body in bodies)
    check(f"{claim}: change of the total momentum, relative", abs(total / MOMENTUM - 1).max(), 0, 1e-10, relative=False)
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check_between(f"{claim}: largest energy over that of the start", energy.max() / energy[0], 0.97, 1 + 1e-9)
    check_between(f"{claim}: energy at the end over that of the start", energy[-1] / energy[0], 0.97, 1)
    check_between(f"{claim}: tries of a step", r["tries"].max(), 1, 1)
    print(f"     Newton iterations per step {r['newton'][1:].mean():.2f}, most {r['newton'].max():.0f}")


START = GAP / V
for name, length, lasts, left, until in (("target twice as long", 2, 2, 0, 4.8e-5),
                                         ("target half as long", 0.5, 1, 0.5, 2.8e-5)):
    r = run(name.replace(" ", "_"), {
        **SOLVER, "mesh_set_gap": GAP * 1e3, "mesh_set_second_length": 100 * length, "mesh_set_n_second": int(200 * length),
        "contact_face_method": "mortar", "output_vis_every": 100000, "ts_max_time": until,
    }, files=[option_file("bars_impact.opts")])
    first, last = pressed(r, "face")
    check(f"{name}: contact time over L/c", (last - first) * C / L, lasts, 0.02)
    plateau(name, r, "face", START, START + lasts * L / C)
    check(f"{name}: momentum left in the striker", r["momentum_striker_x"][-1] / MOMENTUM, left, 0.01, relative=False)
    check(f"{name}: momentum of the target", r["momentum_target_x"][-1] / MOMENTUM, 1 - left, 0.01)
    books(name, r, ("striker", "target"))

r = run("row", {**SOLVER, "output_vis_every": 100000}, files=[option_file("bars_row.opts")])
for contact, begins, ends in (("one", 0, 2), ("two", 1, 3)):
    first, last = pressed(r, contact)
    check(f"row, contact {contact}: begins", (first - START) * C / L, begins, 0.02, relative=False)
    check(f"row, contact {contact}: ends, in L/c", (last - START) * C / L, ends, 0.02)
    plateau(f"row, contact {contact}", r, contact, START + begins * L / C, START + ends * L / C)
for body, left in (("first", 0), ("second", 0), ("third", 1)):
    check(f"row: momentum of the {body} bar", r[f"momentum_{body}_x"][-1] / MOMENTUM, left, 0.01, relative=False)
books("row", r, ("first", "second", "third"))
start = r["energy_kinetic"][0] + r["energy_elastic"][0]
check_between("row: energy of the last bar over that of the start",
              (r["energy_kinetic_third"][-1] + r["energy_elastic_third"][-1]) / start, 0.99, 1)
finish()
