# labels: run
# timeout: 120
"""Rigid bodies and obstacles with mass by central differences: a box that tumbles against Euler's equations, free flight,
impacts beside Newmark's method, prescribed motion, a light body, momenta, energies, restart, ranks, repeated steps."""
import numpy
from _runs import check, check_between, finish, mesh, require, run
from _whole import check_goes_on

RHO = 1000.0
EXPLICIT = {"ts_type": "central_difference"}


def largest(values):
    return abs(values).max()


def balanced(name, r):
    check(f"{name}: balance", largest(r["balance"]), 0, 1e-10, relative=False)


print("a free box that tumbles about its middle axis")
SIZE, OMEGA = numpy.array([1.0, 2.0, 3.0]), numpy.array([0.02, 3.0, 0.03])
TOP = {**EXPLICIT, "mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 2, "mesh_set_lx": 1, "mesh_set_ly": 2,
       "mesh_set_lz": 3, "materials": "box", "material_box_region": "solid", "material_box_model": "rigid",
       "material_box_rho": RHO, "ics": "spin", "ic_spin_on": "solid",
       "ic_spin_vx": f"1+{OMEGA[1]}*(z-1.5)-{OMEGA[2]}*(y-1)", "ic_spin_vy": f"{OMEGA[2]}*(x-0.5)-{OMEGA[0]}*(z-1.5)",
       "ic_spin_vz": f"{OMEGA[0]}*(y-1)-{OMEGA[1]}*(x-0.5)", "ts_max_time": 8, "probes": "p,q", "probe_p_at": "0,0,0",
       "probe_p_fields": "u", "probe_q_at": "1,2,3", "probe_q_fields": "u"}
INERTIA = SIZE.prod() * RHO / 12 * (SIZE @ SIZE - SIZE**2)


def euler(end, n=20000):
    """Spin in space at the end, and the rotation, by the classical Runge-Kutta method in the axes of the body."""
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
    R = state[3:].reshape(3, 3)
    return R @ state[:3], R


exact, R = euler(8.0, 8000)
place = R @ (SIZE / 2) - SIZE / 2 + [8, 0, 0]
errors = []
for dt in (0.02, 0.01, 0.005):
    r = run("top", {**TOP, "ts_dt": dt})
    spin = numpy.array([r["rigid_box_w" + axis][-1] for axis in "xyz"])
    corner = numpy.array([r["probe_q_u" + axis][-1] for axis in "xyz"])
    errors.append([numpy.linalg.norm(spin - exact), numpy.linalg.norm(corner - place)])
errors = numpy.array(errors)
require("it turned over: the axis of rotation swept the body", (R.T @ exact)[1] < -2)
for i, of in enumerate(("spin", "place of a corner")):
    print(f"     errors of the {of}: {errors[:, i]}")
    check(f"order of the {of}", numpy.log2(errors[1, i] / errors[2, i]), 2, 0.05, relative=False)
for axis, start in zip("xyz", INERTIA * OMEGA):
    check(f"moment of momentum about {axis}, change over the whole",
          largest(r["rigid_box_l" + axis] - start) / numpy.linalg.norm(INERTIA * OMEGA), 0, 1e-12, relative=False)
check("kinetic energy, change", numpy.ptp(r["energy_kinetic"]) / r["energy_kinetic"][0], 0, 1e-12, relative=False)
check("its value", r["energy_kinetic"][0], RHO * SIZE.prod() / 2 + INERTIA @ OMEGA**2 / 2, 1e-12)
check("way of the centre", r["rigid_box_ux"][-1], 8, 1e-12)
apart = sum((SIZE[k] + r[f"probe_q_u{axis}"] - r[f"probe_p_u{axis}"])**2 for k, axis in enumerate("xyz"))
check("distance of two corners, change", largest(apart / (SIZE @ SIZE) - 1), 0, 1e-13, relative=False)
balanced("box", r)

print("a square that turns and falls")
FALL = {**EXPLICIT, "mesh": mesh("block.geo"), "mesh_set_n": 3, "materials": "block", "material_block_region": "solid",
        "material_block_model": "rigid", "material_block_rho": RHO, "ics": "flight", "ic_flight_on": "solid",
        "ic_flight_vx": "1-3*(y-0.5)", "ic_flight_vy": "2+3*(x-0.5)", "bcs": "weight", "bc_weight_on": "solid",
        "bc_weight_type": "body_force", "bc_weight_uy": -10, "ts_dt": 0.02, "ts_max_time": 2.2}
r = run("fall", FALL)
check("height", r["rigid_block_uy"][-1], 2 * 2.2 - 5 * 2.2**2, 1e-12)
check("angle, which counts turns", r["rigid_block_rz"][-1], 3 * 2.2, 1e-12)
check("spin", r["rigid_block_wz"][-1], 3, 1e-12)
check("kinetic energy minus the work of the weight", r["energy_kinetic"][-1] - r["work_external"][-1], RHO * (5 / 2 + 9 / 12),
      1e-12)
balanced("square", r)
r = run("auto", {k: v for k, v in FALL.items() if k != "ts_dt"})
check("without a step that is asked for: half a radian in each", r["dt"][1], 0.5 / 3, 1e-12)

print("a rigid block falls on an elastic one, beside Newmark's method")
BLOCKS = {"mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 12, "mesh_set_n_upper": 10, "mesh_set_gap": 0.017,
          "mesh_set_inset": 0.1, "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3,
          "material_lower_rho": RHO, "material_upper_model": "rigid", "material_upper_rho": 300, "ics": "flight",
          "ic_flight_on": "upper", "ic_flight_vx": 0.3, "ic_flight_vy": -1, "contacts": "face",
          "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top", "contact_face_method": "gpts",
          "contact_face_enforce": "penalty", "contact_face_impact": "none", "contact_face_penalty": 1e7, "ts_max_time": 0.15,
          }
r = run("blocks", {**BLOCKS, **EXPLICIT, "ts_dt": 5e-4})
newmark = run("newmark", {**BLOCKS, "ts_dt": 1e-3, "energy_stop": 0})
print(f"     {r['step'][-1]:.0f} steps, {newmark['step'][-1]:.0f} of Newmark's method")
check_between("it rebounds", r["rigid_upper_vy"][-1], 0.05, 1)
for column, scale in (("rigid_upper_vy", 1), ("rigid_upper_vx", 1), ("rigid_upper_uy", 0.15), ("momentum_lower_y", 300)):
    check(f"{column} at the end, over speed, way or momentum without an impact", (r[column][-1] - newmark[column][-1]) / scale, 0, 5e-3, relative=False)
for axis, start in (("x", 0.3), ("y", -1)):
    whole = r["momentum_lower_" + axis] + r["momentum_upper_" + axis]
    check(f"momentum in {axis}, change", numpy.ptp(whole) / largest(r["momentum_upper_y"]), 0, 1e-12, relative=False)
balanced("blocks", r)
check("first law", largest(r["balance_first_law"]), 0, 5e-3, relative=False)
check("loss of the integrator", largest(r["dissipated_numerical"]) / r["energy_kinetic"][0], 0, 2e-3, relative=False)

print("bodies as light as the cells beside them")
light = run("light", {**BLOCKS, **EXPLICIT, "contact_face_penalty": "auto", "material_upper_rho": 10, "ts_dt_cfl": 0.9})
balanced("light", light)
check_between("speed of the light block after the impact", light["rigid_upper_vy"][-1], 0.9, 1.01)
check("first law of the light block", largest(light["balance_first_law"]), 0, 2e-2, relative=False)
REST = {**BLOCKS, **EXPLICIT, "contact_face_penalty": "auto", "material_upper_rho": 50, "ts_dt_cfl": 0.9, "ics": "flight",
        "ic_flight_vx": 0, "ic_flight_vy": 0, "bcs": "weight,hold", "bc_weight_on": "upper", "bc_weight_type": "body_force",
        "bc_weight_ux": 50, "bc_weight_uy": -200, "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "contact_face_friction": 0.6,
        "mesh_set_gap": 0.001, "ts_max_time": 1}
r = run("rest", REST)
print(f"     {r['step'][-1]:.0f} steps, way {r['rigid_upper_uy'].min():.3g}, angle {largest(r['rigid_upper_rz']):.3g}")
check("pressed and rubbed at the longest step: first law", largest(r["balance_first_law"]), 0, 2e-2, relative=False)
balanced("rest", r)
steps = [run("weight", {**BLOCKS, **EXPLICIT, "material_upper_rho": rho, "ts_max_time": 0.02})["dt"][1] for rho in (300, 1e5)]
check("a heavy one takes no shorter steps", steps[1], steps[0], 1e-12)

print("restart, ranks, repeated steps")
CHAIN = {**BLOCKS, **EXPLICIT, "contact_face_friction": 0.3, "ts_max_time": 0.08, "checkpoint_every": 20, "contact_face_penalty": "auto"}
whole = run("whole", CHAIN)
require("it touches and turns", largest(whole["contact_face_force_y"]) > 0 and largest(whole["rigid_upper_rz"]) > 1e-4)
check_goes_on("", CHAIN, whole, int(whole["step"][-1]) // 2, 1e-8)
balanced("friction", whole)

print("prescribed motion")
DRIVEN = {**EXPLICIT, "mesh": mesh("block.geo"), "mesh_set_n": 2, "materials": "block", "material_block_region": "solid",
          "material_block_model": "rigid", "material_block_rho": RHO, "bcs": "drive", "bc_drive_on": "left", "ts_dt": 0.01,
          "ts_max_time": 1}
for kind, way, turn in (("displacement", "0.1*t^2", "t^2"), ("velocity", "0.2*t", "2*t")):
    r = run("driven", {**DRIVEN, "bc_drive_type": kind, "bc_drive_ux": way, "bc_drive_rz": turn})
    check(f"{kind}: force", r["reaction_drive_x"][-1], RHO * 0.2, 1e-9)
    check(f"{kind}: moment", r["moment_drive_z"][-1], RHO / 6 * 2, 1e-9)
    check(f"{kind}: place", largest(r["rigid_block_ux"] - 0.1 * r["time"]**2), 0, 1e-13, relative=False)
    check(f"{kind}: angle", r["rigid_block_rz"][-1], 1, 1e-12)
    check(f"{kind}: work", r["work_external"][-1], r["energy_kinetic"][-1], 1e-11)
    check(f"{kind}: what is left out stays free", largest(r["rigid_block_uy"]), 0, 1e-12, relative=False)
    balanced(kind, r)
SPACE = {**DRIVEN, "mesh_set_dim": 3, "mesh_set_ly": 2}
r = run("told", {**SPACE, "bc_drive_type": "displacement", "bc_drive_rx": "sin(t)", "bc_drive_ry": "t^2", "bc_drive_rz": "0.5*t"})
end = numpy.array([numpy.sin(1), 1, 0.5])
check("rotation vector in space", numpy.linalg.norm([r[f"rigid_block_r{a}"][-1] - e for a, e in zip("xyz", end)]), 0, 1e-12,
      relative=False)
check("work of the moments over the kinetic energy", (r["work_external"][-1] + r["energy_kinetic"][0]) / r["energy_kinetic"][-1], 1, 2e-3)
balanced("told", r)
r = run("symmetric", {**SPACE, "bc_drive_type": "symmetry", "ics": "flight", "ic_flight_on": "solid", "ic_flight_vx": 3,
                      "ic_flight_vy": "1-2*(z-0.5)", "ic_flight_vz": "2*(y-1)"})
check("beside a plane of symmetry: way along it", r["rigid_block_uy"][-1], 1, 1e-12)
check("spin about its normal", r["rigid_block_wx"][-1], 2, 1e-12)
check("motion across it", largest(r["rigid_block_ux"]) + largest(r["rigid_block_ry"]), 0, 1e-12, relative=False)
ring = run("ring", {**{k: v for k, v in DRIVEN.items() if not k.startswith("bc")}, "plane": "axisymmetric", "bcs": "weight", "bc_weight_on": "solid", "bc_weight_type": "body_force",
                    "bc_weight_uy": -10})
check("a ring falls", ring["rigid_block_uy"][-1], -5, 1e-12)
check("its mass", -ring["momentum_block_y"][-1] / 10, numpy.pi * RHO, 1e-12)

print("obstacles with mass")
BALL = {**EXPLICIT, "mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 6, "mesh_set_ny": 2, "mesh_set_ly": 0.4,
        "materials": "slab", "material_slab_region": "solid", "material_slab_E": 1e6, "material_slab_nu": 0.3,
        "material_slab_rho": RHO, "contacts": "foot", "contact_foot_secondary": "top", "contact_foot_primary": "rigid_sphere",
        "contact_foot_centre": "0.45,0.91,0.5", "contact_foot_radius": 0.5, "contact_foot_rigid_mass": 200,
        "contact_foot_friction": 0.3, "ics": "flight", "ic_flight_on": "obstacle_foot", "ic_flight_vx": "0.5+10*(z-0.5)",
        "ic_flight_vy": -1, "ic_flight_vz": "-10*(x-0.45)", "ts_max_time": 0.16}
r = run("ball", BALL)
for axis in "xyz":
    change = r["momentum_slab_" + axis] + r["momentum_obstacle_foot_" + axis]
    check(f"change of the momentum in {axis}", numpy.ptp(change) / 200, 0, 1e-12, relative=False)
check("its moment of inertia", r["rigid_obstacle_foot_ly"][0] / r["rigid_obstacle_foot_wy"][0], 0.4 * 200 * 0.25, 1e-12)
check_between("speed that comes back", r["rigid_obstacle_foot_vy"][-1], -0.5, 1)
check_between("friction turned it about z", largest(r["rigid_obstacle_foot_wz"]), 0.05, 2)
check("first law", largest(r["balance_first_law"]), 0, 1e-2, relative=False)
balanced("ball", r)
PLATE = {**BALL, "contact_foot_primary": "plane", "contact_foot_plane_point": "0.5,0.41,0.5", "contact_foot_plane_normal": "0,-1,0",
         "contact_foot_friction": 0, "ts_dt_cfl": 0.2, "ic_flight_vx": 0, "ic_flight_vz": 0}
PLATE = {k: v for k, v in PLATE.items() if k not in ("contact_foot_centre", "contact_foot_radius")}
r = run("plate", PLATE)
check("plate: change of the momentum", numpy.ptp(r["momentum_slab_y"] + r["momentum_obstacle_foot_y"]) / 200, 0, 1e-12, relative=False)
check("plate: first law", largest(r["balance_first_law"]), 0, 1e-2, relative=False)
balanced("plate", r)
finish()
