# labels: run
# timeout: 300
# processors: 1
# long: 900
"""Coulomb friction in space: a block that slides along no edge of the mesh on a rigid plane or on a block of another
mesh is braked against its velocity and stops after v^2/(2 mu g); on a slope it stays below mu and
slides above with g (sin - mu cos); a block led along a circle loses mu N times the way; a rigid plane drawn along a block
works for heat and what the block stores; a pair that turns as one keeps its traction; a restarted run and other numbers
of ranks give the same. The long form takes each enforcement everywhere."""
import math
import os

import numpy
from _fields import Fields
from _runs import check, check_between, finish, long, mesh, require, run

LONG = long()  # all enforcements, meshes, slopes and numbers of ranks
ENFORCEMENTS = ("penalty", "auglag", "semismooth") if LONG else ("semismooth",)
MU, G, V = 0.3, 10.0, 1.0
RHO, E = 1000.0, 1e8
DIRECTION = numpy.array([math.cos(0.6), math.sin(0.6)])  # in x and z, along no edge
STEP, RHO_INFINITY = 4e-3, 0.5
# Part of the kinetic energy of a block with unit speed that damped steps give it as friction begins (theory.md, S4).
GIVEN = (2 / (1 + RHO_INFINITY) - 1) ** 2 * MU * G * STEP


def block(**more):
    """A unit block on the rigid plane y = 0, moving at V, pressed down by its weight from the start."""
    return {
        "mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 2,
        "materials": "block", "material_block_region": "solid", "material_block_E": E,
        "material_block_nu": 0.3, "material_block_rho": RHO,
        "bcs": "weight", "bc_weight_on": "solid", "bc_weight_type": "body_force", "bc_weight_uy": -G,
        "ics": "flight", "ic_flight_on": "solid", "ic_flight_vx": V * DIRECTION[0], "ic_flight_vz": V * DIRECTION[1],
        "contacts": "face", "contact_face_secondary": "bottom", "contact_face_primary": "plane",
        "contact_face_friction": MU, "ts_dt": STEP, "ts_max_time": 0.4, "ts_newmark_rho": RHO_INFINITY,
        "measures": "place", "measure_place_on": "solid", "measure_place_fields": "u", "measure_place_of": "mean", **more,
    }


def place(r):
    return numpy.stack([r["measure_place_ux"], r["measure_place_uz"]])


def tangential(r):
    return numpy.stack([r["contact_face_force_x"], r["contact_face_force_z"]])


def counts(name, r):
    print(f"     {name}: {len(r['time']) - 1} steps, Newton iterations per step {r['newton'][1:].mean():.2f}, "
          f"most {r['newton'].max():.0f}, tries {r['tries'].max():.0f}")


def stop(name, r, speed, mass, tolerance_of_ratio, first_law=1e-5):
    counts(name, r)
    force, normal, way = tangential(r), r["contact_face_force_y"], place(r)
    sliding = (r["time"] > 0.02) & (r["time"] < 0.8 * speed / (MU * G)) & (normal > 0)
    size = numpy.hypot(*force)
    ratio = size[sliding] / normal[sliding]
    # Nodes of a vibrating block do not slide quite in parallel: their forces may sum to less.
    check(f"{name}: tangential over normal force while sliding, smallest", ratio.min(), MU, tolerance_of_ratio)
    check(f"{name}: the same, largest", ratio.max(), MU, tolerance_of_ratio)
    against = -(DIRECTION @ force)[sliding] / size[sliding]
    check(f"{name}: cosine of the angle to what opposes the velocity", against.min(), 1, 1e-4)
    check(f"{name}: distance v^2/(2 mu g)", DIRECTION @ way[:, -1], speed**2 / (2 * MU * G), 0.02)
    check(f"{name}: motion across the velocity over the distance",
          abs(way[0] * DIRECTION[1] - way[1] * DIRECTION[0]).max() / (DIRECTION @ way[:, -1]), 0, 2e-3, relative=False)
    late = way[:, r["time"] > speed / (MU * G) + 0.03]
    check(f"{name}: motion after the stop over the distance", numpy.ptp(late, axis=1).max() / (DIRECTION @ way[:, -1]),
          0, 2e-3, relative=False)
    check_between(f"{name}: heat of friction over the kinetic energy",
                  r["dissipated_friction"][-1] / (mass * speed**2 / 2), 0.95, 1 + GIVEN / speed)
    check(f"{name}: first law", abs(r["balance_first_law"]).max(), 0, first_law, relative=False)


POINTS = {"contact_face_method": "gpts"}
for enforce in ENFORCEMENTS:
    stop(f"rigid plane, {enforce}", run(f"plane_{enforce}", block(contact_face_enforce=enforce)), V, RHO, 1e-5)
stop("rigid plane, hexahedra of second order", run("plane_second", block(order=2, mesh_set_n=1, **POINTS)), V, RHO, 1e-5)

BALL = {"contact_face_primary": "rigid_sphere", "contact_face_radius": 1e3, "contact_face_centre": "0.5,-1e3,0.5"}
if LONG:
    # The weighted gap begins with an overlap of 4e-5, which the first step pushes out: a gain of energy that is real.
    stop("rigid sphere that is almost a plane", run("ball", block(**BALL)), V, RHO, 2e-3, first_law=3e-4)
    stop("the same, tetrahedra of second order", run("ball_second", block(**BALL, **POINTS, order=2, mesh_set_simplex=1)), V, RHO, 2e-3,
         first_law=3e-4)

# A block on a longer one that is held below; meshes that do not match. Its weight comes softly, so that it does not
# bounce; a rigid block then goes on for v/2 until it weighs, from which on it is braked.
MASS, SOFT = RHO * 0.64, 0.08
WEIGHT = f"(t<{SOFT}?0.5*(1-cos({math.pi / SOFT!r}*t)):1)"
instants = numpy.linspace(0, 0.3, 300001)
weight = numpy.where(instants < SOFT, 0.5 * (1 - numpy.cos(math.pi / SOFT * instants)), 1)
RIGID = (numpy.maximum(V / 2 - MU * G * numpy.cumsum(weight) * instants[1], 0)).sum() * instants[1]
SLAB = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_dim": 3, "mesh_set_n_lower": 3, "mesh_set_n_upper": 2,
    "mesh_set_inset": 0.1,
    "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": 0.3, "material_lower_rho": RHO,
    "material_upper_like": "lower",
    "bcs": "hold,weight", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_weight_on": "upper",
    "bc_weight_type": "body_force", "bc_weight_uy": f"-{G}*{WEIGHT}",
    "ics": "flight", "ic_flight_on": "upper", "ic_flight_vx": V / 2 * DIRECTION[0],
    "ic_flight_vz": V / 2 * DIRECTION[1],
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "contact_face_friction": MU, "ts_dt": STEP, "ts_max_time": 0.28, "ts_newmark_rho": RHO_INFINITY,
    "measures": "place", "measure_place_on": "upper", "measure_place_fields": "u", "measure_place_of": "mean",
}
SLABS = {"dual, hexahedra": {"contact_face_multipliers": "dual"}}
if LONG:
    # Augmentations leave energy in proportion to their tolerance (theory.md, Uzawa).
    CLOSE = {**POINTS, "contact_face_pressure_tol": 1e-5}
    SLABS |= {"hexahedra of second order, mortar": {"order": 2, "mesh_set_n_lower": 2, "mesh_set_n_upper": 1},
              "tetrahedra of second order": {"order": 2, **CLOSE, "mesh_set_simplices_lower": 1, "mesh_set_simplices_upper": 1},
              "standard, tetrahedra": {"contact_face_multipliers": "standard", "mesh_set_simplices_upper": 1},
              "hexahedra of second order": {"order": 2, **CLOSE, "mesh_set_n_lower": 2, "mesh_set_n_upper": 1},
              "serendipity": {"order": 2, **CLOSE, "mesh_serendipity": 1}}
for kind, extra in SLABS.items():
    name = f"slab, {kind}"
    r = run(f"slab_{kind}", {**SLAB, **extra})
    counts(name, r)
    force, normal, way = tangential(r), r["contact_face_force_y"], place(r)
    sliding = (r["time"] > 0.02) & (r["time"] < 0.2) & (normal > 0)
    mean = force[:, sliding].sum(axis=1) / normal[sliding].sum()
    check(f"{name}: tangential over normal force, mean", numpy.hypot(*mean), MU, 3e-3)
    check(f"{name}: cosine of the angle to what opposes the velocity", -(DIRECTION @ mean) / numpy.hypot(*mean), 1, 1e-6)
    check(f"{name}: distance of a rigid block", DIRECTION @ way[:, -1], RIGID, 0.005)
    check_between(f"{name}: heat of friction over the kinetic energy",
                  r["dissipated_friction"][-1] / (MASS * (V / 2) ** 2 / 2), 0.99, 1)
    check(f"{name}: heat of the pair against that of the ledger", r["contact_face_dissipated"][-1],
          r["dissipated_friction"][-1], 1e-12)
    check(f"{name}: first law", abs(r["balance_first_law"]).max(), 0, 1e-6, relative=False)
    check(f"{name}: gain over the kinetic energy, of friction that begins", r["gain"].max() / r["energy_kinetic"].max(),
          GIVEN / (V / 2), 0.15)

print("the same slide resumed, and on other numbers of ranks; a coefficient of rounding is none")
SHORT = {**SLAB, "mesh_set_simplices_upper": 1, "ts_max_time": 0.096, "checkpoint_every": 12, "motion_snes_rtol": 1e-11,
         "outputs": "vis", "output_vis_every": 12}
COLUMNS = ("measure_place_ux", "measure_place_uz", "contact_face_force_x", "contact_face_force_y", "dissipated_friction",
           "energy_elastic")


def agree(name, a, b, tolerance):
    worst = {c: abs(a[c] - b[c]).max() / abs(a[c]).max() for c in COLUMNS if abs(a[c]).max() > 0}
    column = max(worst, key=worst.get)
    check(f"{name}, worst column {column}", worst[column], 0, tolerance, relative=False)


whole = run("whole", SHORT)
for ranks in (2, 4) if LONG else (3,):
    other = run(f"ranks_{ranks}", {**SHORT, "ts_max_time": 0.048}, ranks=ranks)
    agree(f"{ranks} ranks against 1", {c: whole[c][:len(other["time"])] for c in COLUMNS}, other, 1e-8)
for ranks in (1, 2) if LONG else (1,):
    run(f"cut_{ranks}", {**SHORT, "ts_max_time": 0.048})
    resumed = run(f"cut_{ranks}", {**SHORT, "restart": "auto"}, ranks=ranks)
    require("the run was resumed", "resumed from" in resumed.log)
    agree(f"resumed on {ranks} ranks against the whole run", whole, resumed, 1e-11 if ranks == 1 else 1e-8)
none, rounding = (run(f"coefficient_{mu}", {**SHORT, "contact_face_friction": mu, "ts_max_time": 0.048})
                  for mu in (0, 1e-15))
require("without friction no column of its heat", "dissipated_friction" not in none.history)
check("a coefficient of 1e-15 against none", max(abs(none[c] - rounding[c]).max() / abs(none[c]).max() for c in COLUMNS
                                                   if c in none.history), 0, 1e-10, relative=False)
check("which loses no speed", none["measure_place_ux"][-1], V / 2 * DIRECTION[0] * 0.048, 1e-4)

print("damped steps give nothing to a contact whose force grows, and to friction that begins by the step, as theory has it")
FREE = {**SHORT, "contact_face_friction": 0, "ts_max_time": 0.048}
trapezoidal = run("trapezoidal", {**FREE, "ts_newmark_rho": 1})
check("gain without friction, that of the trapezoidal rule", none["gain"].max(), trapezoidal["gain"].max(), 1e-3)
check_between("what the integrator exchanges", none["exchange_numerical"].min(), 0, math.inf)
half = run("half_step", {**SHORT, "ts_dt": STEP / 2})
check("gain with friction, of the step over that of half of it", whole["gain"].max() / half["gain"].max(), 2, 0.15)

print("fields: Coulomb's law at every node")
fields = Fields(os.path.join(whole.dir, "vis.xdmf"))
status, pressure, traction, slip, u = (
    fields.field(fields.grids[-1], name)[0]
    for name in ("contact_status", "contact_pressure", "contact_traction", "contact_slip", "u"))
pressed = status[:, 0] > 0
check_between("nodes that press", numpy.count_nonzero(pressed), 6, 9)
check("all of them slide", status[pressed].min(), 2, 0)
# Facets that meet in a node are not quite in one plane.
check("traction over pressure", abs(numpy.linalg.norm(traction, axis=1)[pressed] / pressure[pressed, 0] / MU - 1).max(), 0,
      1e-6, relative=False)
along = (traction * slip).sum(axis=1)[pressed]
check("cosine of traction and slip", (along / (numpy.linalg.norm(traction, axis=1) * numpy.linalg.norm(slip, axis=1))
                                      [pressed]).max(), -1, 1e-3)
check("slip against the way of the block", numpy.linalg.norm(slip[pressed], axis=1).mean(),
      numpy.hypot(*place(whole)[:, -1]), 1e-2)

print("slope: the weight turns slowly to the angle once the block rests, along no edge")
REST, TURNED, END = 0.1, 0.2, 0.4
for tangent, moves in ((0.99 * MU, False), (1.01 * MU, True)) + (((1.3 * MU, True),) if LONG else ()):
    angle = math.atan(tangent)
    along, across = G * math.sin(angle), G * math.cos(angle)
    ramp = f"(t<{REST}?0:(t<{TURNED}?(t-{REST})/{TURNED - REST}:1))"
    soft = f"(t<{SOFT}?0.5*(1-cos({math.pi / SOFT!r}*t)):1)"
    r = run(f"slope_{tangent:.3f}", {
        **block(), "ic_flight_vx": 0, "ic_flight_vz": 0, "ts_dt": 5e-3, "ts_max_time": END,
        "bc_weight_ux": f"{along * DIRECTION[0]!r}*{ramp}", "bc_weight_uy": f"-{across!r}*{soft}",
        "bc_weight_uz": f"{along * DIRECTION[1]!r}*{ramp}"})
    way = DIRECTION @ place(r)
    # A rigid block: at rest while the weight along the slope is less than mu times that across it.
    t = numpy.linspace(0, END, 400001)
    push = along * numpy.clip((t - REST) / (TURNED - REST), 0, 1)
    speed = numpy.cumsum(numpy.maximum(push - MU * across, 0)) * t[1]
    if tangent > 1.1 * MU:
        late = r["time"] > TURNED + 0.02
        measured = 2 * numpy.polyfit(r["time"][late], way[late], 2)[0]
        check("above the threshold: acceleration g (sin - mu cos)", measured, along - MU * across, 1e-3)
    elif moves:
        late = r["time"] > TURNED + 0.02
        measured = 2 * numpy.polyfit(r["time"][late], way[late], 2)[0]
        check("a hundredth above: acceleration over g", measured / G, (along - MU * across) / G, 2e-4, relative=False)
        require("a hundredth above: it moves", way[-1] > 0.8 * speed.sum() * t[1] > 0)
    else:
        free = numpy.cumsum(push).sum() * t[1] ** 2
        # The elastic block sways when the weight has turned, then rests.
        check_between("a hundredth below: way over that without friction", way[-1] / free, -2e-3, 2e-3)
        check_between("a hundredth below: motion after that", numpy.ptp(way[r["time"] > TURNED + 0.1]) / free, 0, 2e-5)
        check("a hundredth below: places that slide in the end", r["contact_face_sliding"][-1], 0, 0, relative=False)

print("led along a circle, pressed: the traction turns with the way")
RADIUS, STEPS = 0.05, 40
STILL = {key: value for key, value in SLAB.items() if not key.startswith(("bc", "ic", "ts_"))}
ROUND = {**STILL, "bcs": "hold,lead", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_lead_on": "upper_top",
         "bc_lead_ux": f"{RADIUS}*sin(2*pi*t)", "bc_lead_uy": "-1e-3*(t<0.05?t/0.05:1)",
         "bc_lead_uz": f"{RADIUS}*(1-cos(2*pi*t))", "ts_type": "static", "ts_dt": 1 / STEPS, "ts_max_time": 1.25}
for enforce in ("penalty", "auglag", "semismooth") if LONG else ("auglag",):
    r = run(f"circle_{enforce}", {**ROUND, "contact_face_enforce": enforce})
    counts(f"circle, {enforce}", r)
    turn = r["time"] > 0.249  # once it slides in full
    force, normal = tangential(r)[:, turn], r["contact_face_force_y"][turn]
    check(f"circle, {enforce}: tangential over normal force", (numpy.hypot(*force) / normal).min(), MU, 0.01)
    # Backward steps along chords: the traction is that of the middle of the step.
    at = 2 * math.pi * (r["time"][turn] - 0.5 / STEPS)
    against = -(force[0] * numpy.cos(at) + force[1] * numpy.sin(at)) / numpy.hypot(*force)
    check(f"circle, {enforce}: cosine of the angle to what opposes the motion", against.min(), 1, 2e-3)
    chord = 2 * RADIUS * math.sin(math.pi / STEPS)
    lost = r["dissipated_friction"][turn]
    check(f"circle, {enforce}: heat of a turn over mu N times the way", (lost[-1] - lost[0]) / (MU * normal[1:].sum() * chord),
          1, 0.01)

print("a rigid plane is pressed against a held block and drawn along it; a cylinder too, across and along its axis")
HELD = {key: value for key, value in block().items() if not key.startswith(("bc", "ic", "ts_newmark", "material_block_rho"))}
CYLINDER = {"contact_face_primary": "rigid_cylinder", "contact_face_radius": 3, "contact_face_centre": "0.5,-3,0.5",
            "contact_face_axis": "1,0,0"}
for name, shape in (("plane", {}), ("cylinder", CYLINDER)):
    r = run(f"drawn_{name}", {
        **HELD, **shape, "bcs": "hold", "bc_hold_on": "top", "bc_hold_type": "fix", "mesh_set_n": 3,
        "contact_face_rigid_uy": "2e-3*(t<0.2?t/0.2:1)",
        **{f"contact_face_rigid_u{k}": f"{0.02 * along!r}*(t<0.2?0:t-0.2)" for k, along in zip("xz", DIRECTION)},
        "ts_type": "static", "ts_dt": 0.02, "ts_max_time": 1.2})
    counts(f"drawn {name}", r)
    # The wall's work is heat and what the block stores.
    check(f"drawn {name}: first law", r["balance_first_law"][-1], 0, 5e-3, relative=False)
    check_between(f"drawn {name}: heat over the work of the rigid body", r["dissipated_friction"][-1] / r["work_external"][-1],
                  0.7, 0.95)
    if name == "plane":
        drawn = tangential(r)[:, -1]
        check("drawn plane: tangential over normal force in the end", numpy.hypot(*drawn) / r["contact_face_force_y"][-1],
              MU, 1e-6)
        check("drawn plane: cosine of force and motion", DIRECTION @ drawn / numpy.hypot(*drawn), 1, 1e-6)

print("pressed and sheared within the limit, then turned as one about an axis of no edge")
AXIS = numpy.array([0.48, 0.6, 0.64])
K = numpy.array([[0, -AXIS[2], AXIS[1]], [AXIS[2], 0, -AXIS[0]], [-AXIS[1], AXIS[0], 0]])
START = ["1e-3*min(t,1)", "-1e-3*min(t,1)", "5e-4*min(t,1)"]


def led(name, on, start):
    """Boundary data of a turn by one radian after t = 1 of a side that was moved by `start` until then."""
    place = [f"({x}+({u}))" for x, u in zip("xyz", start)]
    row = lambda M, k: "(" + "+".join(f"({M[k, j]!r})*{place[j]}" for j in range(3)) + ")"
    angle = "max(t-1,0)"
    return {f"bc_{name}_on": on, **{f"bc_{name}_u{'xyz'[k]}": f"{start[k]}+sin({angle})*{row(K, k)}"
                                    f"+(1-cos({angle}))*{row(K @ K, k)}" for k in range(3)}}


r = run("turn", {**STILL, "bcs": "hold,lead", **led("hold", "lower_bottom", ["0", "0", "0"]),
                 **led("lead", "upper_top", START), "ts_type": "static", "ts_dt": 0.25, "ts_max_time": 2, "motion_snes_rtol": 1e-11})
counts("turn", r)
force = numpy.stack([r[f"contact_face_force_{k}"] for k in "xyz"])
before = force[:, numpy.argmin(abs(r["time"] - 1))]
after = before + math.sin(1) * K @ before + (1 - math.cos(1)) * K @ K @ before
check_between("tangential over normal force before the turn", numpy.hypot(before[0], before[2]) / before[1], 0.05, 0.9 * MU)
check("force after the turn", numpy.linalg.norm(force[:, -1] - after) / numpy.linalg.norm(before), 0, 1e-8, relative=False)
check("places that slide", r["contact_face_sliding"].max(), 0, 0, relative=False)
check("heat of friction over the energy", r["dissipated_friction"][-1] / r["energy_elastic"][-1], 0, 1e-10, relative=False)
finish()
