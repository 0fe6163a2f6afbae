# labels: run
# timeout: 120
"""The energy-conserving contact update with Coulomb friction: what contact does to the bodies is what it stores and what
friction turns into heat, to rounding, and that heat never shrinks; a disc that slides over a rigid plane takes mu times the
normal impulse and the spin and heat of a rigid disc; two discs that stick and slide keep momentum and moment of
momentum; a sliding block stops after v^2/(2 mu g); a block in space, resumed in contact and on other ranks."""
import math
import os
import shutil

import numpy
from _fields import Bodies
from _runs import check, check_between, finish, mesh, option_file, run

CONSERVING = {"contact_face_impact": "conserving", "ts_newmark_rho": 1, "motion_snes_rtol": 1e-11}


def books(name, r, energy_bar):
    heat = r["dissipated_friction"]
    energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"] - r["work_external"]
    print(f"     {name}: {len(r['time']) - 1} steps, contact in {numpy.count_nonzero(r['contact_face_active'])}, sliding in "
          f"{numpy.count_nonzero(r['contact_face_sliding'])}, Newton iterations per step {r['newton'][1:].mean():.2f}, most "
          f"{r['newton'].max():.0f}")
    check(f"{name}: work of contact, energy in contact and heat, sum over the largest energy in contact",
          abs(r["work_contact"] + r["energy_contact"] + heat).max() / r["energy_contact"].max(), 0, 1e-9, relative=False)
    check_between(f"{name}: least heat of a step over all of it", numpy.diff(heat).min() / heat[-1], -1e-14, 1)
    check(f"{name}: energy and heat against the energy of the start", abs((energy + heat) / energy[0] - 1).max(), 0, energy_bar,
          relative=False)
    check_between(f"{name}: tries of a step", r["tries"].max(), 1, 1)


RHO, V, RADIUS = 2700.0, 10.0, 10e-3
MASS, ALONG, DOWN = RHO * math.pi * RADIUS**2, V / 2, V * math.sqrt(0.75)
print("a disc flies obliquely at a plane and slides over it as long as they touch")
MU = 0.1  # below a third of ALONG / DOWN
r = run("disc", {**CONSERVING, "contact_face_secondary": "disc_side", "contact_face_primary": "plane", "mesh_set_second_n": 2,
                 "contact_face_plane_normal": "1,0", "contact_face_plane_point": f"{-1.005 * RADIUS},0",
                 "contact_face_friction": MU, "ic_flight_vx": -DOWN, "ic_flight_vy": ALONG, "ts_dt": 2e-7},
        files=[option_file("discs.opts")])
books("disc", r, 2e-5)
normal, tangential = r["impulse_face_x"][-1], -r["impulse_face_y"][-1]
check("disc: tangential over normal impulse", tangential / normal, MU, 1e-9)
check("disc: normal impulse over 2 m v, less what is left as vibration", normal / (2 * MASS * DOWN), 1, 0.03)
bodies = Bodies(r, RHO)
way = [numpy.sum((p[1:] + p[:-1]) / 2 * numpy.diff(r["time"])) / MASS for p in (r["momentum_disc_x"], r["momentum_disc_y"])]
spin = (bodies.moments(len(bodies.fields.times) - 1)[2] - way[0] * r["momentum_disc_y"][-1]
        + way[1] * r["momentum_disc_x"][-1])
check("disc: spin over that impulse times the radius", spin / (tangential * RADIUS), 1, 0.02)
# The rim slows down by 3 J/m: from ALONG at the first touch, the mean of both ends in the mean.
check("disc: heat over the impulse times the mean speed of the rim",
      r["dissipated_friction"][-1] / (tangential * (ALONG - 1.5 * tangential / MASS)), 1, 0.03)

print("two discs that grip each other")
r = run("discs", {**CONSERVING, "contact_face_method": "gpts", "contact_face_friction": 0.2, "ts_dt": 2e-7},
        files=[option_file("discs.opts")])
books("discs", r, 1e-5)
start = r["momentum_disc_x"][0]
for k in "xy":
    total = r[f"momentum_disc_{k}"] + r[f"momentum_second_{k}"]
    check(f"discs: change of the total momentum in {k}", abs(total - total[0]).max() / start, 0, 1e-10, relative=False)
bodies = Bodies(r, RHO)
moments = numpy.array([bodies.moments(k) for k in range(len(bodies.fields.times))])
check("discs: change of the moment of momentum over momentum times radius",
      abs(moments[:, 2] - moments[0, 2]).max() / (start * RADIUS), 0, 1e-6, relative=False)
on = r["contact_face_active"] > 0
sticking = numpy.count_nonzero(r["contact_face_sliding"][on] < r["contact_face_active"][on])
check_between("discs: share of the steps in contact in which something sticks", sticking / numpy.count_nonzero(on), 0.1, 0.9)

print("a block slides on a plane and stops")
MU, G, SPEED = 0.3, 10.0, 1.0
r = run("block", {
    **CONSERVING, "mesh": mesh("block.geo"), "mesh_set_n": 2, "materials": "block", "material_block_region": "solid",
    "material_block_E": 1e8, "material_block_nu": 0.3, "material_block_rho": 1000.0, "bcs": "weight", "bc_weight_on": "solid",
    "bc_weight_type": "body_force", "bc_weight_uy": f"-{G}*(t<0.02?t/0.02:1)", "ics": "flight", "ic_flight_on": "solid",
    "ic_flight_vx": SPEED, "contacts": "face", "contact_face_secondary": "bottom", "contact_face_primary": "plane",
    "contact_face_friction": MU, "ts_dt": 2.5e-3, "ts_max_time": 0.4, "measures": "place",
    "measure_place_on": "solid", "measure_place_fields": "u", "measure_place_of": "mean"})
books("block", r, 1e-4)
# The weight grows over the first 0.02: as if it came as a whole after half of that, but for 0.02^2 mu g / 24.
rigid = SPEED * 0.01 + SPEED**2 / (2 * MU * G) - MU * G * 0.02**2 / 24
check("block: distance of a rigid block", r["measure_place_ux"][-1], rigid, 0.01)
late = r["time"] > 0.01 + SPEED / (MU * G) + 0.03
check("block: motion after the stop over the distance", numpy.ptp(r["measure_place_ux"][late]) / rigid, 0, 2e-3, relative=False)
check("block: heat over the kinetic energy", r["dissipated_friction"][-1] / (1000 * SPEED**2 / 2), 1, 0.01)

print("a block of tetrahedra flies into one of hexahedra, both free, along a direction of no edge")
FLIGHT = {
    **CONSERVING, "mesh": mesh("two_blocks.geo"), "mesh_set_dim": 3, "mesh_set_angle": 20, "mesh_set_gap": 4e-4,
    "mesh_set_inset": 0.1, "mesh_set_n_lower": 3, "mesh_set_simplices_lower": 0, "mesh_set_n_upper": 2,
    "mesh_set_simplices_upper": 1, "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3,
    "material_lower_rho": 1000, "material_upper_like": "lower", "contacts": "face", "contact_face_secondary": "lower_top",
    "contact_face_primary": "upper_bottom", "contact_face_friction": 0.2, "ics": "flight", "ic_flight_on": "upper",
    "ic_flight_vx": 0.006, "ic_flight_vy": -0.018, "ic_flight_vz": 0.008, "ts_dt": 2e-3, "ts_max_time": 0.13,
}
r = run("flight", {**FLIGHT, "checkpoint_every": 30, "checkpoint_keep": 9})
books("flight", r, 1e-5)
start = numpy.hypot(r["momentum_upper_x"][0], r["momentum_upper_y"][0])
total = [r[f"momentum_lower_{k}"] + r[f"momentum_upper_{k}"] for k in "xyz"]
check("flight: change of the total momentum", max(abs(p - p[0]).max() for p in total) / start, 0, 1e-10, relative=False)


def compare(name, other, tolerance):
    for column in ("dissipated_friction", "contact_face_pressure_max", "energy_elastic", "momentum_lower_z"):
        first = r[column][:len(other["time"])]
        check(f"{name}: {column}", numpy.nanmax(abs(other[column] - first)) / numpy.nanmax(abs(first)), 0, tolerance,
              relative=False)


shutil.copytree("flight", "flight_again")
compare("resumed in contact, each step tried twice", run("flight_again", {
    **FLIGHT, "checkpoint_every": 30, "checkpoint_keep": 9, "test_restep": "",
    "restart": os.path.abspath("flight_again/checkpoints/checkpoint_000001.h5")}), 1e-12)
# Touches after 0.022.
compare("2 ranks", run("flight_2", {**FLIGHT, "ts_max_time": 0.05}, ranks=2), 1e-8)
finish()
