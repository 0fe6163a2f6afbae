# labels: run
# timeout: 300
# long: 300
# processors: 1
"""Meshed rigid bodies: a free top against Euler's equations, free flight, a block that falls on a held rigid body and on a
rigid plane, an elastic block on a free rigid one, two equal rigid masses, a punch with prescribed motion; momenta, energies,
ranks, repeated steps and restarts."""
import numpy
from _runs import check, check_between, finish, long, mesh, require, run

RHO = 1000.0


def total(r, column, of):
    return sum(r[f"{column}_{name}"] for name in of)


def same(name, a, b, tolerance, columns):
    worst = max(abs(a[c] - b[c]).max() / max(abs(a[c]).max(), 1e-12) for c in columns)
    check(name, worst, 0, tolerance, relative=False)


print("a block that stands on its support is no run to stop for rounding errors")
for rho in (0, 0.8):
    still = run("still", {"mesh": mesh("block.geo"), "materials": "box", "material_box_region": "solid", "material_box_model": "rigid",
                          "material_box_rho": RHO, "bcs": "stand,weight", "bc_stand_on": "bottom", "bc_stand_ux": 0, "bc_stand_rz": 0,
                          "bc_stand_uy": "0.1*ramp(t,0.5,0.8)", "bc_weight_on": "solid", "bc_weight_type": "body_force",
                          "bc_weight_uy": -10, "ts_dt": 0.03, "ts_max_time": 1, "ts_newmark_rho": rho})
    check(f"rho {rho}: reaction, at rest", still["reaction_stand_y"][-1], 10 * RHO, 1e-6)

print("a free box that tumbles about its middle axis")
SIZE = numpy.array([1.0, 2.0, 3.0])
OMEGA = numpy.array([0.2, 3.0, 0.3])
TOP = {
    "mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 2, "mesh_set_lx": 1, "mesh_set_ly": 2, "mesh_set_lz": 3,
    "materials": "box", "material_box_region": "solid", "material_box_model": "rigid", "material_box_rho": RHO,
    "ics": "spin", "ic_spin_on": "solid",
    "ic_spin_vx": f"1+{OMEGA[1]}*(z-1.5)-{OMEGA[2]}*(y-1)", "ic_spin_vy": f"{OMEGA[2]}*(x-0.5)-{OMEGA[0]}*(z-1.5)",
    "ic_spin_vz": f"{OMEGA[0]}*(y-1)-{OMEGA[1]}*(x-0.5)", "ts_max_time": 2, "motion_snes_rtol": 1e-13,
}
INERTIA = SIZE.prod() * RHO / 12 * (SIZE @ SIZE - SIZE**2)


def euler(end, n=20000):
    """Spin in space at the end by the classical Runge-Kutta method, in the axes of the body."""
    def rates(state):
        w, R = state[:3], state[3:].reshape(3, 3)
        W = numpy.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return numpy.concatenate([numpy.cross(INERTIA * w, w) / INERTIA, (R @ W).ravel()])
    state, h = numpy.concatenate([OMEGA, numpy.eye(3).ravel()]), end / n
    for _ in range(n):
        k1 = rates(state)
        k2 = rates(state + h / 2 * k1)
        k3 = rates(state + h / 2 * k2)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(state + h * k3))
    return state[3:].reshape(3, 3) @ state[:3]


exact = euler(2.0, 4000)
errors = []
for dt in (0.04, 0.02):
    r = run("top", {**TOP, "ts_dt": dt})
    spin = numpy.array([r["rigid_box_w" + axis][-1] for axis in "xyz"])
    errors.append(numpy.linalg.norm(spin - exact) / numpy.linalg.norm(exact))
check("error of the spin after 40 steps against Euler's equations over that after 80", errors[0] / errors[1], 4, 0.15)
check("the latter", errors[1], 0, 5e-3, relative=False)
for axis, start in zip("xyz", INERTIA * OMEGA):
    check(f"moment of momentum about {axis}, change over the whole", numpy.ptp(r["rigid_box_l" + axis]) /
          numpy.linalg.norm(INERTIA * OMEGA), 0, 1e-12, relative=False)
    check(f"and its value over I omega", r["rigid_box_l" + axis][0] / start, 1, 1e-12)
check("kinetic energy, change", numpy.ptp(r["energy_kinetic"]) / r["energy_kinetic"][0], 0, 1e-11, relative=False)
check("way of the centre", r["rigid_box_ux"][-1], 2, 1e-11)

print("a square that turns and falls")
r = run("fall", {
    "mesh": mesh("block.geo"), "mesh_set_n": 3, "materials": "block", "material_block_region": "solid",
    "material_block_model": "rigid", "material_block_rho": RHO, "ics": "flight", "ic_flight_on": "solid",
    "ic_flight_vx": "1-3*(y-0.5)", "ic_flight_vy": "2+3*(x-0.5)", "bcs": "weight", "bc_weight_on": "solid",
    "bc_weight_type": "body_force", "bc_weight_uy": -10, "ts_dt": 0.02, "ts_max_time": 2.2, "motion_snes_rtol": 1e-13})
check("height", r["rigid_block_uy"][-1], 2 * 2.2 - 5 * 2.2**2, 1e-11)
check("angle, which counts turns, of the chords", r["rigid_block_rz"][-1], 110 * 2 * numpy.arctan(0.03), 1e-11)
check("spin", r["rigid_block_wz"][-1], 3, 1e-11)
check("kinetic energy minus the work of the weight", r["energy_kinetic"][-1] - r["work_external"][-1],
      RHO * (5 / 2 + 9 / 12), 1e-10)

print("an elastic block falls on a rigid one")
BLOCKS = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 3, "mesh_set_n_upper": 4, "mesh_set_gap": 0.017, "mesh_set_inset": 0.1,
    "materials": "lower,upper", "material_lower_model": "rigid", "material_lower_rho": RHO, "material_upper_E": 1e6,
    "material_upper_nu": 0.3, "material_upper_rho": RHO, "ics": "flight", "ic_flight_on": "upper", "ic_flight_vx": 0.3,
    "ic_flight_vy": -1, "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "contact_face_method": "mortar", "contact_face_friction": 0.2, "ts_dt": 2e-3, "ts_max_time": 0.08,
}
held = {"bcs": "hold", "bc_hold_on": "lower", "bc_hold_type": "fix"}
r = run("held", {**BLOCKS, **held})
plane = run("plane", {**BLOCKS, **held, "contact_face_primary": "plane", "contact_face_plane_point": "0,1,0"})
# The mortar measures gaps along the block's own normals, which are not quite those of the plane.
same("held, as on the rigid plane: force, momentum, energy", r, plane, 1e-4,
     ["contact_face_force_x", "contact_face_force_y", "momentum_upper_y", "energy_elastic", "energy_kinetic"])
# With the contact-stabilised update the forces of the history stand along the gradients of the end, reactions along those
# that acted in the step.
r = run("held_as_it_is", {**BLOCKS, **held, "contact_face_impact": "none", "energy_stop": 0})
check("impulse of its support, which the contact hands on", sum(r["reaction_hold_y"] * r["dt"]),
      sum(r["contact_face_force_y"] * r["dt"]), 1e-9)
r = run("free", {**BLOCKS, "checkpoint_every": 20})
for axis, scale in (("x", 240), ("y", 800)):
    check(f"free: change of the momentum in {axis} over the start's",
          numpy.ptp(total(r, "momentum", [f"{body}_{axis}" for body in ("lower", "upper")])) / scale, 0, 1e-8, relative=False)
check_between("most Newton iterations of a step", r["newton"].max(), 2, 8)
COLUMNS = ["contact_face_force_y", "momentum_upper_y", "rigid_lower_vy", "rigid_lower_rz", "energy_kinetic", "energy_elastic",
           "dissipated_friction", "dissipated_numerical", "dissipated_contact", "energy_numerical"]
ranks = run("ranks", BLOCKS, ranks=3 if long() else 2)
same("on other ranks", r, ranks, 1e-8, COLUMNS)
# Nothing but strains is left in it: a part of the energy.
check("on other ranks: first law", abs(r["balance_first_law"] - ranks["balance_first_law"]).max(), 0, 1e-10, relative=False)
COLUMNS.append("balance_first_law")
same("every step refused once and repeated", r, run("restep", {**BLOCKS, "checkpoint_every": 20, "test_restep": 1}), 1e-14, COLUMNS)
run("restart", {**BLOCKS, "ts_max_steps": 20, "checkpoint_every": 20})
same("stopped in the middle and resumed", r, run("restart", {**BLOCKS, "checkpoint_every": 20, "restart": "auto"}), 1e-12,
     COLUMNS)
r = run("conserving", {**BLOCKS, "contact_face_friction": 0, "contact_face_impact": "conserving"})
energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
check("conserving update: change of the energy", numpy.ptp(energy) / energy[0], 0, 1e-3, relative=False)
check("loss of the integrator", abs(r["dissipated_numerical"]).max() / energy[0], 0, 1e-10, relative=False)

print("two equal rigid masses")
r = run("equal", {**{k: v for k, v in BLOCKS.items() if not k.startswith("material")}, "mesh_set_inset": 0, "materials": "mass",
                  "material_mass_region": "lower,upper", "material_mass_model": "rigid", "material_mass_rho": RHO,
                  "ic_flight_vx": 0, "contact_face_method": "gpts", "contact_face_friction": 0,
                  "contact_face_impact": "conserving", "contact_face_penalty": 1e8, "ts_dt": 2e-4, "ts_max_time": 0.025})
check("speed of the one that stood", r["rigid_mass_1_vy"][-1], -1, 1e-9)
check("speed of the one that came", r["rigid_mass_2_vy"][-1], 0, 1e-9, relative=False)
half = numpy.pi * (RHO / 2 / 1e8) ** 0.5
on = r["time"][numpy.nonzero(r["contact_face_force_y"])[0]]
check("time of contact, half a period of the penalty's spring", numpy.ptp(on) + 2e-4, half, 0.05)

BOTH_RIGID = {**{k: v for k, v in BLOCKS.items() if not k.startswith("material_upper")}, "material_upper_like": "lower", "contact_face_penalty": 1e8}
r = run("stabilised", {**BOTH_RIGID, "contact_face_impact": "stabilised"}, code=2)
require("two rigid sides: the contact-stabilised update is refused", "-contact_face_impact" in r.log and "conserving" in r.log)
# They left with 2.07 times the speed they came with.
r = run("multipliers", {**BOTH_RIGID, "contact_face_enforce": "semismooth"}, code=2)
require("two rigid sides: multipliers are refused", "-contact_face_enforce semismooth" in r.log and "take penalty" in r.log)

print("a block on a rigid cylinder 1e5 times as large")
WIDE = {"mesh": mesh("block.geo"), "materials": "b", "material_b_region": "solid", "material_b_E": 1e6, "material_b_nu": 0.3,
        "bcs": "p", "bc_p_on": "top", "bc_p_ux": 0, "bc_p_uy": "-0.02*t", "contacts": "f", "contact_f_secondary": "bottom",
        "contact_f_primary": "rigid_cylinder", "contact_f_radius": 1e5, "contact_f_centre": "0.5,-1e5,0",
        "contact_f_method": "mortar", "contact_f_initial": "allow", "ts_type": "static", "ts_dt": 0.5, "ts_max_time": 1}
r, flat = run("wide", WIDE), run("flat", {**WIDE, "contact_f_primary": "plane"})
check("force, against that of a plane", r["contact_f_force_y"][-1], flat["contact_f_force_y"][-1], 1e-4)
check_between("most Newton iterations of a step", r["newton"].max(), 1, 5)

print("prescribed motion")
DRIVEN = {"mesh": mesh("block.geo"), "mesh_set_n": 2, "materials": "block", "material_block_region": "solid",
          "material_block_model": "rigid", "material_block_rho": RHO, "bcs": "drive", "bc_drive_on": "left", "ts_dt": 0.02,
          "ts_max_time": 1}
for kind, place, turn in (("displacement", "0.1*t^2", "t^2"), ("velocity", "0.2*t", "2*t")):
    r = run("driven", {**DRIVEN, "bc_drive_type": kind, "bc_drive_ux": place, "bc_drive_rz": turn})
    check(f"{kind}: force", r["reaction_drive_x"][-1], RHO * 0.2, 1e-9)
    check(f"{kind}: moment", r["moment_drive_z"][-1], RHO / 6 * 2, 1e-3)
    check(f"{kind}: angle", r["rigid_block_rz"][-1], 1, 1e-12)
    check(f"{kind}: work", r["work_external"][-1], r["energy_kinetic"][-1], 1e-12)
    check(f"{kind}: what is left out stays free", abs(r["rigid_block_uy"]).max(), 0, 1e-12, relative=False)
r = run("symmetric", {**DRIVEN, "mesh_set_dim": 3, "mesh_set_ly": 2, "bc_drive_type": "symmetry", "ics": "flight",
                      "ic_flight_on": "solid", "ic_flight_vx": 3, "ic_flight_vy": "1-2*(z-0.5)", "ic_flight_vz": "2*(y-1)"})
check("beside a plane of symmetry: way along it", r["rigid_block_uy"][-1], 1, 1e-11)
check("spin about its normal", r["rigid_block_wx"][-1], 2, 1e-11)
arm = [c + r["rigid_block_u" + k] for k, c in (("x", 0.5), ("y", 1), ("z", 0.5))]
p = [r["momentum_block_" + k] for k in "xyz"]
check("angular momentum about the origin", abs(r["spin_block_x"] - r["rigid_block_lx"] - arm[1] * p[2] + arm[2] * p[1]).max(), 0,
      1e-9 * abs(r["spin_block_x"]).max(), relative=False)
check("motion across it", abs(r["rigid_block_ux"]).max() + abs(r["rigid_block_ry"]).max(), 0, 1e-12, relative=False)
r = run("clash", {**DRIVEN, "bcs": "drive,other", "bc_drive_ux": "t", "bc_other_on": "right", "bc_other_ux": "2*t"}, code=3)
require("two conditions that contradict each other are named", "-bc_drive and -bc_other prescribe different ux" in r.log)

# By default multipliers gained energy here without a bound, and the rounding of places ended the run after a third of a turn.
print("all bodies are rigid: a disc rolls down a slope")
with open("disc.geo", "w") as file:
    file.write('''R = 0.05; d = R*Sqrt(0.5); c = 0.35*R;
Point(1) = {0, R, 0}; Point(2) = {-c, R-c, 0}; Point(3) = {c, R-c, 0}; Point(4) = {c, R+c, 0}; Point(5) = {-c, R+c, 0};
Point(6) = {-d, R-d, 0}; Point(7) = {d, R-d, 0}; Point(8) = {d, R+d, 0}; Point(9) = {-d, R+d, 0};
Line(1) = {2, 3}; Line(2) = {3, 4}; Line(3) = {4, 5}; Line(4) = {5, 2};
Circle(5) = {6, 1, 7}; Circle(6) = {7, 1, 8}; Circle(7) = {8, 1, 9}; Circle(8) = {9, 1, 6};
Line(9) = {2, 6}; Line(10) = {3, 7}; Line(11) = {4, 8}; Line(12) = {5, 9};
Curve Loop(1) = {1, 2, 3, 4}; Curve Loop(2) = {5, -10, -1, 9}; Curve Loop(3) = {6, -11, -2, 10};
Curve Loop(4) = {7, -12, -3, 11}; Curve Loop(5) = {8, -9, -4, 12};
For i In {1:5}
Plane Surface(i) = {i};
EndFor
Transfinite Curve {1:8} = 25; Transfinite Curve {9:12} = 5; Transfinite Surface {1:5}; Recombine Surface {1:5};
Physical Surface("disc") = {1:5}; Physical Curve("rim") = {5:8};
''')
ROLLS = {"mesh": "disc.geo", "materials": "disc", "material_disc_model": "rigid", "material_disc_rho": 1000, "bcs": "weight",
         "bc_weight_on": "disc", "bc_weight_type": "body_force", "bc_weight_ux": 4.905, "bc_weight_uy": -8.49571, "contacts": "floor",
         "contact_floor_secondary": "rim", "contact_floor_primary": "plane", "contact_floor_penalty": 1e8,
         "contact_floor_friction": 0.3, "ts_dt": 1e-3, "ts_max_time": 0.8}
for name, more, lost in (("by default", {} if long() else {"ts_max_time": 0.2}, 1e-8),
                         ("in damped steps", {"ts_newmark_rho": 0.9, "ts_max_time": 0.4}, 0.02))[: 2 if long() else 1]:
    r = run("rolls", {**ROLLS, **more})
    late = r["time"] > 0.1
    roll, turn = (numpy.polyfit(r["time"][late], r[column][late], 1)[0] for column in ("rigid_disc_vx", "rigid_disc_wz"))
    check(f"{name}: acceleration 2/3 g sin", roll, 4.905 * 2 / 3, 0.02)
    check(f"{name}: angular acceleration times R over acceleration", turn * 0.05 / roll, -1, 0.02)
    check(f"{name}: first law", abs(r["balance_first_law"]).max(), 0, lost, relative=False)

print("a rigid punch, static")
PUNCH = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 4, "mesh_set_n_upper": 3, "mesh_set_inset": 0.1,
    "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3, "material_upper_model": "rigid",
    "bcs": "hold,push", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_push_on": "upper", "bc_push_ux": 0,
    "bc_push_uy": "-0.02*t", "bc_push_rz": "0.01*t", "contacts": "face", "contact_face_secondary": "lower_top",
    "contact_face_primary": "upper_bottom", "contact_face_method": "mortar", "ts_type": "static", "ts_dt": 0.25,
    "ts_max_time": 1,
}
r = run("punch", PUNCH)
check("reaction of the punch against that of the support", r["reaction_push_y"][-1], -r["reaction_hold_y"][-1], 1e-9)
check("work of force and moment over the elastic energy", r["work_external"][-1], r["energy_elastic"][-1], 2e-3)
require("a moment holds its angle", r["moment_push_z"][-1] > 1)
finer = run("finer", {**PUNCH, "ts_dt": 0.05})
check_between("the work's error falls at least by 4 with steps of a fifth",
              abs(r["balance_first_law"][-1] / finer["balance_first_law"][-1]), 4, 1e9)
loose = {k: v for k, v in PUNCH.items() if k not in ("bc_push_ux", "bc_push_rz")}
r = run("loose", {**loose, "mesh_set_gap": 0.01})
check("one that contact alone holds in x and against turning, above a gap: reaction against that of the support",
      r["reaction_push_y"][-1], -r["reaction_hold_y"][-1], 1e-9)
r = run("unheld", {**loose, "mesh_set_gap": 5}, code=3)
require("a body that can move is named", "region upper" in r.log and "translation in x, rotation" in r.log)

finish()
