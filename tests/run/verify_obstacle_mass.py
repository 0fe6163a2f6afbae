# labels: run
# timeout: 300
# processors: 1
"""Rigid planes, spheres and cylinders with mass: the impact of a mass on a rod (Saint-Venant and Boussinesq), a plane as a
meshed rigid box of the same mass, free rotation, friction that turns a disc, a ball in space on any ranks, a cylinder that
rests by its weight, a dent; momenta, energies."""
import numpy
from _runs import check, check_between, finish, long, mesh, option_file, require, run

RHO = 1000.0


def largest_change(values, scale):
    return numpy.ptp(values) / scale


print("a mass hits a rod: its velocity falls as exp(-rho c A t/M) until the wave is back")
E, M = 1e9, 25.0
C = (E / RHO) ** 0.5
ROD = {"mesh": mesh("block.geo"), "mesh_set_n": 1, "mesh_set_ny": 50, "mesh_set_lx": 0.1, "mesh_set_ly": 1, "materials": "rod",
       "material_rod_region": "solid", "material_rod_E": E, "material_rod_nu": 0, "material_rod_rho": RHO, "contacts": "hit",
       "contact_hit_secondary": "bottom", "contact_hit_primary": "plane", "contact_hit_rigid_mass": M,
       "contact_hit_rigid_ux": 0, "ics": "start", "ic_start_on": "obstacle_hit", "ic_start_vy": 1, "ts_dt": 1e-5,
       "ts_max_time": 1.9e-3}
for name, area, options in (("plane strain, half thick, points", 0.05, {"thickness": 0.5}),
                            ("axisymmetric, mortar", numpy.pi * 0.01, {"plane": "axisymmetric", "contact_hit_method": "mortar"})):
    r = run("rod", {**ROD, **options})
    decay = numpy.exp(-RHO * C * area / M * r["time"])
    check(f"{name}: velocity of the mass, worst", abs(r["rigid_obstacle_hit_vy"] - decay).max(), 0, 0.01, relative=False)
    check(f"{name}: impulse of the mass over what it lost", r["impulse_hit_y"][-1] / (M * (1 - r["rigid_obstacle_hit_vy"][-1])), 1,
          1e-9)
    check(f"{name}: change of the momentum", largest_change(r["momentum_rod_y"] + r["momentum_obstacle_hit_y"], M), 0, 1e-9,
          relative=False)
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check(f"{name}: highest energy over the start's", energy.max() / (M / 2), 1, 1e-9)

print("a plane with mass and a meshed rigid box of the same mass")
FALL = {"material_upper_E": 1e6, "material_upper_nu": 0.3, "material_upper_rho": RHO, "ics": "flight", "ic_flight_vx": 0.3,
        "ic_flight_vy": -1, "contacts": "face", "contact_face_method": "gpts", "contact_face_enforce": "penalty", "ts_dt": 2e-3,
        "ts_max_time": 0.08, "motion_snes_rtol": 1e-12}
box = run("box", {**FALL, "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 3, "mesh_set_n_upper": 4, "mesh_set_gap": 0.017,
                  "mesh_set_inset": 0.1, "materials": "lower,upper", "material_lower_model": "rigid", "material_lower_rho": RHO,
                  "ic_flight_on": "upper", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
                  "bcs": "guide", "bc_guide_on": "lower", "bc_guide_rz": 0})
UPPER = {**FALL, "mesh": mesh("block.geo"), "mesh_set_lx": 0.8, "materials": "upper", "material_upper_region": "solid",
         "ic_flight_on": "solid", "contact_face_secondary": "bottom", "contact_face_primary": "plane",
         "contact_face_plane_point": "0.4,-0.017", "contact_face_rigid_mass": RHO}
plane = run("plane", UPPER)
for column in ("rigid_{}_vy", "rigid_{}_uy", "contact_face_force_y", "energy_elastic", "momentum_upper_y"):
    a, b = box[column.format("lower")], plane[column.format("obstacle_face")]
    check(column.format("<it>"), abs(a - b).max() / abs(a).max(), 0, 1e-10, relative=False)

print("a block falls on bodies that turn, with friction")
FREE = {**UPPER, "contact_face_enforce": "auto", "contact_face_plane_point": "0.1,-0.017", "contact_face_rigid_inertia": 100,
        "contact_face_friction": 0.3}
CYLINDER = {"contact_face_primary": "rigid_cylinder", "contact_face_centre": "0.3,-1.017", "contact_face_radius": 1}
for name, options in (("plane, points", {}), ("plane, mortar", {"contact_face_method": "mortar"}),
                      ("cylinder, mortar", {"contact_face_method": "mortar", **CYLINDER}))[:: 1 if long() else 2]:
    r = run("free", {**FREE, **options})
    for axis in "xy":
        check(f"{name}: change of the momentum in {axis}",
              largest_change(r["momentum_upper_" + axis] + r["momentum_obstacle_face_" + axis], 640), 0, 1e-10, relative=False)
    energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
    check(f"{name}: highest energy over the start's", energy.max() / energy[0], 1, 1e-9)
    check_between(f"{name}: angle", abs(r["rigid_obstacle_face_rz"][-1]), 0.002, 0.1)
    r = run("conserving", {**FREE, **options, "contact_face_impact": "conserving"})
    closed = r["contact_face_work"] + r["energy_contact"] + r["dissipated_friction"]
    check(f"{name}, conserving: work of contact, its energy, heat", abs(closed).max() / r["energy_kinetic"][0], 0, 1e-9,
          relative=False)
    check(f"{name}, conserving: loss of the integrator", abs(r["dissipated_numerical"]).max() / r["energy_kinetic"][0], 0, 1e-9,
          relative=False)

print("an obstacle with mass that is driven into a block and stops: its velocity is that of the data, whatever steps damp")
TOLD = {"units": "mm_t_s_MPa", "mesh": mesh("block.geo"), "mesh_set_n": 8, "mesh_set_lx": 4, "mesh_set_ny": 2, "materials": "solid",
        "material_solid_E": 1000, "material_solid_nu": 0.3, "material_solid_rho": 1e-9, "bcs": "hold,drive", "bc_hold_on": "bottom",
        "bc_hold_type": "fix", "bc_drive_on": "obstacle_p", "contacts": "p", "contact_p_secondary": "top", "contact_p_primary": "rigid_cylinder", "contact_p_centre": "2,6",
        "contact_p_radius": 5, "contact_p_rigid_mass": 1e-4, "bc_drive_ux": 0, "bc_drive_uy": "(-0.02)*min(1,t/0.2)",
        "bc_drive_rz": "3*t", "ts_dt": 0.02, "ts_max_time": 0.4}
# With friction contact's heat of the first steps is twice its work: no reason to stop.
for name, options in (("rho 0", {"ts_newmark_rho": 0}), ("rho 0.5, friction", {"ts_newmark_rho": 0.5, "contact_p_friction": 0.3}),
                      ("rho 1", {"ts_newmark_rho": 1})):
    r = run("told", {**TOLD, **options})
    moves = r["time"] < 0.2 + 1e-9
    check(f"{name}: speed down", abs(r["rigid_obstacle_p_vy"] + 0.1 * moves).max(), 0, 1e-9, relative=False)
    check(f"{name}: speed across", abs(r["rigid_obstacle_p_vx"]).max(), 0, 1e-9, relative=False)
    check(f"{name}: spin", abs(r["rigid_obstacle_p_wz"] - 3).max(), 0, 1e-9, relative=False)
    check(f"{name}: support against contact, at rest", r["reaction_drive_y"][-1], r["contact_p_force_y"][-1], 1e-6)

print("a rigid block that its weight presses on another one: its nodes keep their distances, whatever steps damp")
PRESSED = {"units": "mm_t_s_MPa", "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 3, "mesh_set_n_upper": 4, "mesh_set_gap": 0, "mesh_set_inset": 0.1,
           "materials": "lower,upper", "material_lower_E": 1000, "material_lower_nu": 0.3, "material_lower_rho": 1e-9,
           "material_upper_model": "rigid", "material_upper_rho": 1e-9, "contacts": "face", "contact_face_secondary": "upper_bottom",
           "contact_face_primary": "lower_top", "bcs": "hold,weight", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix",
           "bc_weight_on": "upper", "bc_weight_type": "body_force", "bc_weight_uy": "(-1e10)*min(1,t/0.1)", "ts_dt": 0.02, "ts_max_time": 0.2}
for rho in (0, 0.5):
    r = run("pressed", {**PRESSED, "ts_newmark_rho": rho})
    # 0.8 mm by 1 mm
    twice = 0.8e-9 * (r["rigid_upper_vx"] ** 2 + r["rigid_upper_vy"] ** 2 + (0.8**2 + 1) / 12 * r["rigid_upper_wz"] ** 2)
    check(f"rho {rho}: kinetic energy over that of the rigid motion", 2 * r["energy_kinetic_upper"].max() / twice.max(), 1, 1e-3)

print("a disc that spins is let down on a slab: friction slows the spin and drives it along")
WEIGHT, SPIN, RADIUS, MASS = 10.0, 20.0, 0.5, 100.0
DISC = {"mesh": mesh("block.geo"), "mesh_set_n": 60, "mesh_set_ny": 2, "mesh_set_lx": 1.5, "mesh_set_ly": 0.1,
        "materials": "slab", "material_slab_region": "solid", "material_slab_E": 1e6, "material_slab_nu": 0.3,
        "material_slab_rho": RHO, "bcs": "hold,weight", "bc_hold_on": "bottom", "bc_hold_type": "fix",
        "bc_weight_on": "obstacle_foot", "bc_weight_type": "body_force", "bc_weight_uy": -WEIGHT, "contacts": "foot",
        "contact_foot_secondary": "top", "contact_foot_primary": "rigid_cylinder", "contact_foot_centre": "0.75,0.6",
        "contact_foot_radius": RADIUS, "contact_foot_rigid_mass": MASS, "contact_foot_friction": 0.3,
        "contact_foot_method": "mortar", "contact_foot_initial": "allow", "ics": "spin", "ic_spin_on": "obstacle_foot",
        "ic_spin_vx": f"-{SPIN}*(y-0.6)", "ic_spin_vy": f"{SPIN}*(x-0.75)", "ts_dt": 2e-3, "ts_max_time": 0.16,
        "ts_newmark_rho": 0.8}
r = run("disc", DISC)
check("its moment of inertia", r["rigid_obstacle_foot_lz"][0] / r["rigid_obstacle_foot_wz"][0], MASS * RADIUS**2 / 2, 1e-12)
# The pressure of the slab, which friction drags along, has a part along it, but none about the centre.
check("it slides all the time: change of its moment of momentum over mu R times the normal impulse",
      MASS * RADIUS**2 / 2 * (r["rigid_obstacle_foot_wz"][-1] - SPIN) / (0.3 * RADIUS * r["impulse_foot_y"][-1]), 1, 5e-3)
check_between("speed along", abs(r["rigid_obstacle_foot_vx"][-1]), 0.3, 0.6)
check("first law", abs(r["balance_first_law"]).max() / (MASS * RADIUS**2 / 4 * SPIN**2), 0, 1e-8, relative=False)

S = 1e-5
small = run("small_disc", {**DISC, "mesh_scale": S, "bc_weight_uy": -WEIGHT / S, "contact_foot_centre": f"{0.75 * S},{0.6 * S}",
                           "contact_foot_radius": RADIUS * S, "contact_foot_rigid_mass": MASS * S**2, "ts_dt": 2e-3 * S, "ts_max_time": 0.04 * S,
                           "ic_spin_vx": f"-{SPIN / S}*(y-{0.6 * S})", "ic_spin_vy": f"{SPIN / S}*(x-{0.75 * S})"})
n = len(small["time"])
for column, size in (("rigid_obstacle_foot_vx", 1), ("rigid_obstacle_foot_rz", 1), ("rigid_obstacle_foot_wz", S), ("impulse_foot_y", 1 / S**2)):
    check(f"ten micrometres wide: {column}", abs(size * small[column] - r[column][:n]).max() / abs(r[column][:n]).max(), 0, 1e-8, relative=False)

print("a spinning ball in space")
# Dual functions see a node nearer to a round body than it is, by h^2/6R: facets of 0.25 would begin 12 mm in the ball, which is 5 mm
# above them, and such a run's energy is not judged.
BALL = {"mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 8, "mesh_set_ny": 2, "mesh_set_ly": 0.4, "materials": "slab",
        "material_slab_region": "solid", "material_slab_E": 1e6, "material_slab_nu": 0.3, "material_slab_rho": RHO,
        "contacts": "foot", "contact_foot_secondary": "top", "contact_foot_primary": "rigid_sphere",
        "contact_foot_centre": "0.45,0.905,0.5", "contact_foot_radius": 0.5, "contact_foot_rigid_mass": MASS,
        "contact_foot_friction": 0.3, "ics": "flight", "ic_flight_on": "obstacle_foot", "ic_flight_vx": "0.5+10*(z-0.5)",
        "ic_flight_vy": -1, "ic_flight_vz": "-10*(x-0.45)", "ts_dt": 4e-3, "ts_max_time": 0.08, "motion_snes_rtol": 1e-12}
r = run("ball", BALL)
check_between("weighted gap at the start, m", r["contact_foot_gap_min"][0], 0, 5e-3)
for axis in "xyz":
    check(f"change of the momentum in {axis}",
          largest_change(r["momentum_slab_" + axis] + r["momentum_obstacle_foot_" + axis], MASS), 0, 1e-10, relative=False)
check("its moment of inertia", r["rigid_obstacle_foot_ly"][0] / r["rigid_obstacle_foot_wy"][0], 0.4 * MASS * 0.25, 1e-12)
check_between("friction turned it about z", -r["rigid_obstacle_foot_wz"][-1], 0.05, 2)
more = run("ranks", BALL if long() else {**BALL, "ts_max_time": 0.04}, ranks=3 if long() else 2)
for column in ("rigid_obstacle_foot_wx", "rigid_obstacle_foot_vy", "contact_foot_force_y", "energy_elastic"):
    check(f"other ranks: {column}", abs(r[column][:len(more["time"])] - more[column]).max() / abs(r[column]).max(), 0, 1e-8, relative=False)

print("a cylinder rests by its weight")
REST = {**DISC, "mesh_set_n": 30, "contact_foot_friction": 0, "contact_foot_centre": "0.75,0.5995", "contact_foot_rigid_ux": 0,
        "contact_foot_rigid_rz": 0, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
REST = {key: value for key, value in REST.items() if not key.startswith(("ic", "ts_newmark"))}
r = run("rest", REST)
check("force of the contact over its weight", -r["contact_foot_force_y"][-1] / (MASS * WEIGHT), 1, 1e-8)
require("what holds it is said", "the body of region obstacle_foot" in r.log and "by contact alone against translation in y" in r.log)
r = run("hangs", {**REST, "contact_foot_centre": "0.75,0.7"})
check("from above the slab it comes down: force over the weight", -r["contact_foot_force_y"][-1] / (MASS * WEIGHT), 1, 1e-8)
check("by the gap and what it presses", r["rigid_obstacle_foot_uy"][-1], -0.1, 2e-2)

print("a driven roller: pressed on the slab and turned on the spot, all of its motion told")
ROLL = {**REST, "bcs": "hold", "contact_foot_friction": 0.3, "contact_foot_centre": "0.75,0.6", "contact_foot_rigid_uy": "(-0.005)*ramp(t,0,1)",
        "contact_foot_rigid_rz": "0.2*ramp(t,1,2)", "ts_dt": 0.1, "ts_max_time": 2}
r = run("roller", {key: value for key, value in ROLL.items() if not key.startswith("bc_weight")})
# It rubs along itself, with all that presses: that is more than its vertical part N, by 1/8 (a/R)^2 with Hertz's pressures.
wide = 1 + (r["contact_foot_length"][-1] / 2 / RADIUS) ** 2 / 8
check("it slides: moment over mu N R", abs(r["moment_obstacle_foot_z"][-1]) / (0.3 * RADIUS * abs(r["contact_foot_force_y"][-1])), wide, 1e-3)
check("moment times the turn of a step over its heat", abs(r["moment_obstacle_foot_z"][-1]) * 0.02 / numpy.diff(r["dissipated_friction"])[-1], 1, 1e-3)

# As it leaves: one step is cut, and seven solves go on by backtracking, where five steps had been cut and two solves repeated.
print("a ball leaves a dent (options/drop_ball.opts, coarse)")
r = run("drop", {"mesh_set_n": 6, "mesh_set_grow": 1.6, "ts_dt": 1e-6}, files=[option_file("drop_ball.opts")], refused=8)
check_between("speed that comes back", r["rigid_obstacle_foot_vy"][-1] / 5000, 0.4, 0.6)

print("what makes no sense is refused in one line")
for name, code, options, words in (
        ("whole motion prescribed of what cannot turn", 2, {"contact_foot_primary": "plane", "contact_foot_plane_point": "0,0.1",
         "contact_foot_plane_normal": "0,-1", "contact_foot_rigid_uy": "t", "contact_foot_centre": None, "contact_foot_radius": None,
         "contact_foot_rigid_rz": None}, "-contact_foot_rigid_mass"),
        ("prescribed twice", 3, {"bcs": "hold,weight,lift", "bc_lift_on": "obstacle_foot", "bc_lift_ux": 1}, "prescribe different ux"),
        ("rotation out of the plane", 3, {"contact_foot_rigid_rx": 0}, "-contact_foot_rigid_rx"),
        ("cylinder in space without a length", 2, {"mesh_set_dim": 3, "mesh_set_nz": 1}, "-contact_foot_rigid_length: missing")):
    r = run("refused", {key: value for key, value in {**REST, **options}.items() if value is not None}, code=code)
    lines = [line for line in r.log.splitlines() if line.startswith("impact: -") and words in line]
    require(f"{name}: exit {code}, {words}", len(lines) == 1)
finish()
