# labels: run
# timeout: 300
# processors: 1
# long: 600
"""Contact in space, by mortar: two blocks of non-matching meshes, of hexahedra and of tetrahedra, carry the uniform pressure
of the closed form, with standard and dual multipliers, by each enforcement, whatever the penalty, at any angle; a block
that flies into another one keeps momentum and never gains energy; the ranks do not matter. The same with Gauss points, whose pressures come nearer to the uniform one
with their number."""
import math

import numpy
from _press import press
from _runs import check, check_between, finish, long, mesh, require, run

E, NU, PRESS = 1e6, 0.3, 0.02
TOP = 2 * PRESS
STRETCH, FORCE = press(E, NU, 1 - PRESS, dim=3)
PRESSURE = FORCE / STRETCH**2
PENALTY = 10 * E * 3  # automatic: the secondary facets are a third wide


def blocks(lower, upper, angle=0):
    """Cells along a side, with a t behind where they are tetrahedra."""
    return {"mesh": mesh("two_blocks.geo"), "mesh_set_dim": 3, "mesh_set_angle": angle,
            "mesh_set_n_lower": lower.rstrip("t"), "mesh_set_simplices_lower": int(lower.endswith("t")),
            "mesh_set_n_upper": upper.rstrip("t"), "mesh_set_simplices_upper": int(upper.endswith("t")),
            "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": NU, "material_upper_like": "lower",
            "contacts": "face", "contact_face_secondary": "lower_top", "contact_face_primary": "upper_bottom"}


def patch(lower, upper, angle=0):
    """Both blocks compressed along the press and stretched across it."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    along = f"({c!r}*x+{s!r}*y)*{STRETCH - 1!r}"

    def end(name, down):
        return {f"bc_{name}_ux": f"({c!r}*({along})-{s!r}*({-down!r}))*t",
                f"bc_{name}_uy": f"({s!r}*({along})+{c!r}*({-down!r}))*t", f"bc_{name}_uz": f"{STRETCH - 1!r}*z*t"}

    return {**blocks(lower, upper, angle), "bcs": "plate,press", "bc_plate_on": "lower_bottom",
            "bc_press_on": "upper_top", **end("plate", 0.0), **end("press", TOP),
            "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}


def uniform(name, r, tolerance):
    low, high = r["contact_face_pressure_min"][-1] / PRESSURE, r["contact_face_pressure_max"][-1] / PRESSURE
    check(f"pressure of the closed form at every node, {name}", max(high - 1, 1 - low), 0, tolerance, relative=False)


print(f"closed form: lateral stretch {STRETCH:.8f}, pressure {PRESSURE:.8g}")
CHOSEN = {"standard": slice(1, 3), "dual": slice(3, 5)}
for space in ("standard", "dual"):
    for lower, upper, angle in (("3", "2", 0), ("3", "2t", 0), ("3t", "4", 0), ("2t", "3t", 33), ("3", "4", 33))[slice(None) if long() else CHOSEN[space]]:
        r = run(f"{space}_{lower}_{upper}_{angle}", {**patch(lower, upper, angle), "contact_face_multipliers": space})
        uniform(f"{space}, angle {angle}, {lower} on {upper} facets along a side (t: triangles)", r, 1e-8)
        check_between("tries of the step", r["tries"].max(), 1, 1)
        check_between("Newton iterations", r["newton"][-1], 3, 9)
r = run("auglag", {**patch("3", "2"), "contact_face_enforce": "auglag", "contact_face_gap_tol": 1e-9,
                   "contact_face_pressure_tol": 1e-8, "uzawa_snes_max_it": 100})
uniform("augmented Lagrangian", r, 1e-8)
r = run("penalty", {**patch("3", "2"), "contact_face_enforce": "penalty"})
uniform("penalty, which is soft", r, 2e-2)
check("penalty: minus the smallest gap is p / eps", -r["contact_face_gap_min"][-1] * PENALTY / PRESSURE, 1, 0.05)
for factor in (0.1, 10, 100) if long() else (100,):
    r = run(f"factor_{factor}", {**patch("3", "2"), "contact_face_penalty": factor * PENALTY,
                                 "contact_face_penalty_max": 1e15})
    uniform(f"semismooth, {factor} times the automatic penalty", r, 1e-8)
    check_between("Newton iterations", r["newton"][-1], 3, 12)

print("a narrower block of tetrahedra flies into another one, both free, along a direction of no edge")
RHO, SPEED = 1000.0, 1.0
FLIGHT = {**blocks("3", "2t", 20), "mesh_set_gap": 0.02, "mesh_set_inset": 0.1, "material_lower_rho": RHO,
          "ics": "flight", "ic_flight_on": "upper", "ic_flight_vx": 0.3 * SPEED, "ic_flight_vy": -0.9 * SPEED,
          "ic_flight_vz": 0.1 * SPEED, "ts_dt": 2.5e-3, "ts_max_time": 0.2, "ts_newmark_rho": 1,
          "motion_snes_rtol": 1e-11}
r = run("flight", FLIGHT)
start = RHO * 0.64 * SPEED
total = [r[f"momentum_lower_{k}"] + r[f"momentum_upper_{k}"] for k in "xyz"]
energy = r["energy_kinetic"] + r["energy_elastic"]
on = numpy.count_nonzero(r["contact_face_active"])
print(f"     {len(r['time']) - 1} steps, {on} in contact, most Newton iterations {int(r['newton'].max())}")
check_between("steps in contact", on, 10, 70)
check("change of the total momentum, relative", max(abs(p - p[0]).max() for p in total) / start, 0, 1e-10, relative=False)
check("impulse on the secondary side against its change of momentum",
      max(abs(r[f"impulse_face_{k}"][-1] - r[f"momentum_lower_{k}"][-1]) for k in "xyz") / start, 0, 1e-9, relative=False)
check_between("largest energy over the energy at the start", energy.max() / energy[0], 0.97, 1 + 1e-9)
# The stabilised update takes the motion of the nodes that close across the surface: a layer of these few cells.
check_between("energy at the end over the energy at the start", energy[-1] / energy[0], 0.9, 1)
check_between("tries of a step", r["tries"].max(), 1, 1)
check_between("mean Newton iterations per step", r["newton"][1:].mean(), 1, 4)
for ranks in (2, 3) if long() else (2,):
    other = run(f"flight_{ranks}", FLIGHT if long() else {**FLIGHT, "ts_max_time": 0.06}, ranks=ranks)
    scale = {c: numpy.nanmax(abs(r[c])) for c in ("contact_face_gap_min", "contact_face_pressure_max", "energy_elastic")}
    worst = {c: numpy.nanmax(abs(r[c][:len(other[c])] - other[c])) / s for c, s in scale.items()}
    column = max(worst, key=worst.get)
    check(f"{ranks} ranks against 1, worst column {column}", worst[column], 0, 1e-8, relative=False)
print("Gauss points")
POINTS = {"contact_face_method": "gpts", "contact_face_enforce": "penalty"}


def deviation(points):
    r = run(f"points_{points}", {**patch("3t", "4"), **POINTS, "contact_face_points": points})
    worst = max(abs(r[f"contact_face_pressure_{end}"][-1] / PRESSURE - 1) for end in ("min", "max"))
    print(f"     {points} points: largest deviation {worst:.3f}, Newton iterations {int(r['newton'][-1])}")
    return worst


one, two, four = (deviation(points) for points in (1, 2, 4))
check_between("largest deviation with one point", one, 0.08, 0.2)
check_between("with two points", two, 0.08, 0.2)
check_between("with four points, over that with two", four / two, 0, 0.5)
if long():
    r = run("flight_points", {**FLIGHT, **POINTS})
    total = [r[f"momentum_lower_{k}"] + r[f"momentum_upper_{k}"] for k in "xyz"]
    energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
    check_between("steps in contact", numpy.count_nonzero(r["contact_face_active"]), 10, 70)
    check("change of the total momentum, relative", max(abs(p - p[0]).max() for p in total) / start, 0, 1e-10, relative=False)
    check_between("largest energy over the energy at the start", energy.max() / energy[0], 0.97, 1 + 1e-9)
    other = run("flight_points_2", {**FLIGHT, **POINTS}, ranks=2)
    check("2 ranks against 1, pressure", abs(r["contact_face_pressure_max"] - other["contact_face_pressure_max"]).max()
          / r["contact_face_pressure_max"].max(), 0, 1e-8, relative=False)
print("what is not there says so")
PLANE = {"contact_face_secondary": "upper_bottom", "contact_face_primary": "plane"}
for name, extra, said in (("round", {**PLANE, "contact_face_primary": "rigid_sphere"}, "-contact_face_radius: is missing"),
                          ("normal", {**PLANE, "contact_face_plane_normal": "0,0,0"}, "-contact_face_plane_normal"),
                          ("motion", {**PLANE, "contact_face_rigid_uy": "s*t"}, "-contact_face_rigid_uy")):
    r = run(f"refused_{name}", {**FLIGHT, **extra}, ranks=2, code=2)
    require(f"{name}: one line that names the option", sum(said in line for line in r.log.splitlines()) == 1)
finish()
