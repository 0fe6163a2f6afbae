# labels: run
# timeout: 600
# long: 300
"""Coulomb friction: a block that slides on a rigid plane stops after v^2/(2 mu g) and
stays, by Gauss points and mortar and by each enforcement, on cells of first and of second order, and on a round rigid
body that is almost a plane; on a slope it stays below mu and slides above with g (sin - mu cos); what is lost goes into
dissipated_friction, by explicit steps too."""
import math

import numpy
from _runs import check, check_between, finish, long, mesh, run

MU, G, V = 0.3, 10.0, 1.0
RHO, E = 1000.0, 1e8


def block(**more):
    """A unit block on the rigid plane y = 0, moving at V, pressed down by its weight from the start."""
    return {
        "mesh": mesh("block.geo"), "materials": "block", "material_block_region": "solid", "material_block_E": E,
        "material_block_nu": 0.3, "material_block_rho": RHO,
        "bcs": "weight", "bc_weight_on": "solid", "bc_weight_type": "body_force", "bc_weight_uy": -G,
        "ics": "flight", "ic_flight_on": "solid", "ic_flight_vx": V,
        "contacts": "face", "contact_face_secondary": "bottom", "contact_face_primary": "plane",
        "contact_face_friction": MU, "ts_dt": 2.5e-3, "ts_max_time": 0.4, "ts_newmark_rho": 0.5,
        "measures": "place", "measure_place_on": "solid", "measure_place_fields": "u", "measure_place_of": "mean", **more,
    }


def comes_to_rest(name, r):
    """Newton's method does, where the block does too: both ways of sliding overshoot into the other one."""
    check_between(f"{name}: most iterations of a solve", r["newton_most"].max(), 1, 12)
    check_between(f"{name}: tries of a step", r["tries"].max(), 1, 1)


def stop(name, r, distance_column, ratio_within=1e-6):
    normal, tangential = r["contact_face_force_y"], r["contact_face_force_x"]
    sliding = (r["time"] > 0.02) & (r["time"] < 0.3) & (normal > 0)
    ratio = abs(tangential[sliding] / normal[sliding])
    check(f"{name}: tangential over normal force while sliding", ratio.max(), MU, ratio_within)
    check(f"{name}: the same, smallest", ratio.min(), MU, ratio_within)
    distance = r[distance_column]
    check(f"{name}: distance v^2/(2 mu g)", distance[-1], V**2 / (2 * MU * G), 0.02)
    late = r["time"] > V / (MU * G) + 0.03
    check(f"{name}: motion after the stop over the distance", numpy.ptp(distance[late]) / distance[-1], 0, 1e-3,
          relative=False)
    lost = r["dissipated_friction"][-1]
    check(f"{name}: heat of friction over the kinetic energy", lost / (RHO * V**2 / 2), 1, 0.02)
    check(f"{name}: first law", abs(r["balance_first_law"]).max(), 0, 1e-6, relative=False)
    comes_to_rest(name, r)


for enforce in ("penalty", "auglag", "semismooth")[0 if long() else 2:]:
    r = run(f"plane_{enforce}", block(contact_face_enforce=enforce, **({"contact_face_pressure_tol": 1e-4} if enforce == "auglag" else {})))
    stop(f"rigid plane, {enforce}", r, "measure_place_ux")
stop("rigid plane, mortar", run("plane_mortar", block(contact_face_method="mortar")), "measure_place_ux")
POINTS, MORTAR = {"contact_face_method": "gpts"}, {"contact_face_method": "mortar"}
SECOND = {"boxes": {"order": 2}, "serendipity": {"order": 2, "mesh_serendipity": 1},
          "triangles": {"order": 2, "mesh_set_simplex": 1}}
for (cells, extra), enforce in zip(SECOND.items(), ("auglag", "penalty", "semismooth")):
    if not long():
        continue
    stop(f"rigid plane, {cells} of second order, {enforce}", run(f"plane_{cells}", block(contact_face_enforce=enforce, **POINTS, **extra)),
         "measure_place_ux")
# Its ends are lower by 1e-4 than its middle.
ROUND = {"contact_face_primary": "rigid_cylinder", "contact_face_radius": 1e3, "contact_face_centre": "0.5,-1e3,0"}
if long():
    stop("rigid plane, triangles of second order, mortar", run("plane_second_mortar", block(**SECOND["triangles"], **MORTAR)),
         "measure_place_ux")
for name, extra in (("Gauss points", POINTS), ("second order", {**SECOND["boxes"], **POINTS}),
                    ("second order, mortar", {**SECOND["boxes"], **MORTAR, "ts_dt": 1.25e-3}))[: 3 if long() else 1]:
    stop(f"rigid cylinder that is almost a plane, {name}", run(f"round_{name}", block(**ROUND, **extra)), "measure_place_ux", 2e-3)

# The work of friction by the trapezoidal rule, as central differences do it: what is left is of second order.
for name, extra in (("boxes", {}), ("boxes of second order", SECOND["boxes"]))[: 2 if long() else 1]:
    options = {**block(**extra), "ts_type": "central_difference", "ts_dt": "auto"}
    del options["ts_newmark_rho"]
    errors = [abs(run(f"explicit_{name}_{cfl}", {**options, "ts_dt_cfl": cfl})["balance_first_law"]).max() for cfl in (0.8, 0.4)]
    check_between(f"explicit steps, {name}: first law", errors[0], 0, 4e-3)
    check_between(f"explicit steps, {name}: with half the step, over it", errors[1] / errors[0], 0, 0.35)

print("slope: the weight turns slowly to the angle once the block rests")
REST, TURNED, END = 0.1, 0.2, 0.4
for tangent, moves in ((0.99 * MU, False), (1.3 * MU, True)):
    angle = math.atan(tangent)
    along, across = G * math.sin(angle), G * math.cos(angle)
    ramp = f"(t<{REST}?0:(t<{TURNED}?(t-{REST})/{TURNED - REST}:1))"
    r = run(f"slope_{moves}", {**block(contact_face_enforce="semismooth"), "ic_flight_vx": 0, "ts_max_time": END,
                               "bc_weight_ux": f"{along!r}*{ramp}", "bc_weight_uy": f"-{across!r}"})
    way = r["measure_place_ux"][-1]
    # A rigid block: at rest while the weight along the slope is less than mu times that across it.
    t = numpy.linspace(0, END, 400001)
    push = along * numpy.clip((t - REST) / (TURNED - REST), 0, 1)
    speed = numpy.cumsum(numpy.maximum(push - MU * across, 0)) * t[1]
    if moves:
        check("above the threshold: way of a rigid block", way, speed.sum() * t[1], 0.02)
    else:
        free = numpy.cumsum(push).sum() * t[1] ** 2
        check_between("below the threshold: way over that without friction", way / free, -1e-3, 1e-3)
print("edge: a block is drawn over the edge of another one; the part of its nodes that faces something falls in each step")
for dim, enforce in ((2, "semismooth"), (2, "auglag"), (3, "semismooth"))[:: 1 if long() else 2]:
    r = run(f"edge_{dim}_{enforce}", {
        "mesh": mesh("two_blocks.geo"), "mesh_set_dim": dim, "mesh_set_n_lower": 10 if dim == 2 else 3, "mesh_set_n_upper": 7 if dim == 2 else 2,
        "mesh_set_inset": 0.03, "materials": "lower,upper", "material_lower_E": 1e9, "material_lower_nu": 0.3, "material_upper_like": "lower",
        "bcs": "hold,draw", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_draw_on": "upper_top",
        "bc_draw_ux": "0.7*ramp(t,1,2)", "bc_draw_uy": "(-1e-4)*ramp(t,0,1)", **({"bc_draw_uz": 0} if dim == 3 else {}), "contacts": "face",
        "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top", "contact_face_friction": MU,
        "contact_face_enforce": enforce, "ts_type": "static", "ts_dt": 0.04, "ts_max_time": 2}, refused=None)
    slides = r["time"] > 1.1
    tangential, normal = abs(r["reaction_hold_x"])[slides], r["reaction_hold_y"][slides]
    check(f"edge, {dim}D, {enforce}: tangential over normal reaction, largest", (tangential / normal).max(), MU, 1e-3)
    check(f"edge, {dim}D, {enforce}: the same, smallest", (tangential / normal).min(), MU, 5e-3)
    for axis in "xy":
        apart = abs(abs(r[f"contact_face_force_{axis}"]) - abs(r[f"reaction_hold_{axis}"]))[slides] / normal
        check(f"edge, {dim}D, {enforce}: force of the contact column and reaction along {axis}, over the normal one", apart.max(), 0, 1e-4, relative=False)
print("slot: a block is drawn over a slot, on to its far side")
with open("slot.geo", "w") as file:
    file.write("""x[] = {0, 1.2, 1.6, 2.8};
y[] = {0, 0.4, 0.5};
nx[] = {12, 4, 12};
ny[] = {4, 1};
For j In {0 : 2}
  For i In {0 : 3}
    Point(10 * j + i + 1) = {x[i], y[j], 0};
  EndFor
EndFor
For j In {0 : 2}
  For i In {0 : 3}
    If (i < 3 && (i != 1 || j < 2))
      Line(100 + 10 * j + i) = {10 * j + i + 1, 10 * j + i + 2};
      Transfinite Curve {100 + 10 * j + i} = nx[i] + 1;
    EndIf
    If (j < 2)
      Line(200 + 10 * j + i) = {10 * j + i + 1, 10 * j + i + 11};
      Transfinite Curve {200 + 10 * j + i} = ny[j] + 1;
    EndIf
  EndFor
EndFor
For j In {0 : 1}
  For i In {0 : 2}
    If (i != 1 || j < 1)
      Curve Loop(1 + 10 * j + i) = {100 + 10 * j + i, 200 + 10 * j + i + 1, -(110 + 10 * j + i), -(200 + 10 * j + i)};
      Plane Surface(1 + 10 * j + i) = {1 + 10 * j + i};
    EndIf
  EndFor
EndFor
px[] = {0.1, 1.04, 1.04, 0.1};
py[] = {0.5, 0.5, 1.1, 1.1};
n[] = {10, 6, 10, 6};
For i In {0 : 3}
  Point(50 + i) = {px[i], py[i], 0};
EndFor
For i In {0 : 3}
  Line(300 + i) = {50 + i, 50 + (i + 1) % 4};
  Transfinite Curve {300 + i} = n[i] + 1;
EndFor
Curve Loop(50) = {300 : 303};
Plane Surface(50) = {50};
Transfinite Surface "*";
Recombine Surface {1, 2, 3, 11, 13, 50};
Physical Surface("lower") = {1, 2, 3, 11, 13};
Physical Surface("upper") = {50};
Physical Curve("floor") = {100, 101, 102};
Physical Curve("top") = {120, 122, 211, 212, 111};
Physical Curve("foot") = {300};
Physical Curve("head") = {302};
""")
for dt in (0.02, 0.01) if long() else (0.02,):
    r = run(f"slot_{dt}", {
        "mesh": "slot.geo", "materials": "lower,upper", "material_lower_E": 1e9, "material_lower_nu": 0.3, "material_upper_like": "lower",
        "bcs": "hold,draw", "bc_hold_on": "floor", "bc_hold_type": "fix", "bc_draw_on": "head", "bc_draw_ux": "1.6*ramp(t,1,2)",
        "bc_draw_uy": "(-2e-4)*ramp(t,0,1)", "contacts": "face", "contact_face_secondary": "foot", "contact_face_primary": "top",
        "contact_face_friction": MU, "ts_type": "static", "ts_dt": dt, "ts_max_time": 2}, refused=3)
    slides = r["time"] > 1.1
    ratio = (abs(r["reaction_hold_x"]) / r["reaction_hold_y"])[slides]
    # A facet that comes to face something has no friction in that step.
    check_between(f"slot, steps of {dt}: largest tangential over normal reaction", ratio.max(), 0.99 * MU, 1.002 * MU)
    check(f"slot, steps of {dt}: the mean of it, of first order", ratio.mean(), MU, 1.5 * dt)

print("a disc of 24 facets that spins on a slab, by Gauss points: what overlaps as points come to face another facet stays until it parts (78'), and no column has a force of it")
SPIN = {"mesh": mesh("roller.geo"), "mesh_set_n": 24, "mesh_set_n_slab": 24, "materials": "disc,slab", "material_disc_model": "rigid", "material_disc_rho": 1,
        "material_slab_E": 1e4, "material_slab_nu": 0.2, "material_slab_rho": 1, "bcs": "hold,weight,axle", "bc_hold_on": "slab_bottom", "bc_hold_type": "fix",
        "bc_weight_on": "disc", "bc_weight_type": "body_force", "bc_weight_uy": -10, "bc_axle_on": "disc", "bc_axle_ux": 0, "ics": "turn", "ic_turn_on": "disc",
        "ic_turn_vx": "-10*(y-2)", "ic_turn_vy": "10*(x-3)", "contacts": "face", "contact_face_secondary": "slab_top", "contact_face_primary": "disc_side",
        "contact_face_method": "gpts", "contact_face_friction": 0.3, "ts_dt": 5e-3, "ts_max_time": 0.5}
r = run("spin", SPIN, refused=None)
force, rate = abs(r["contact_face_force_y"][1:]), abs(numpy.diff(r["impulse_face_y"]) / numpy.diff(r["time"]))
check_between("steps with an overlap of more than 1e-3 facets", (r["contact_face_gap_min"] < -1e-3 * 2 * math.pi / 24).sum(), 10, 100)
check_between("largest force over the largest impulse by time", force.max() / rate.max(), 0.5, 1.02)
at = r["contact_face_active"][1:] > 0
point = r["contact_face_pressure_max"][1:][at] * r["contact_face_length"][1:][at] / r["contact_face_active"][1:][at]
check_between("largest pressure times the length of a point over the force", (point / force[at]).max(), 0.1, 1.5)
finish()
