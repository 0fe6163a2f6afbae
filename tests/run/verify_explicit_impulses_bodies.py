# labels: run
# timeout: 120
# processors: 1
"""Impulses of explicit steps beside rigid bodies with mass: the plastic impact of two rigid blocks and the friction in it against
closed forms, a mass that hits a rod (Saint-Venant and Boussinesq), a ball that spins in space, a body that is driven beside an
obstacle that moves as told, a square that tumbles; momenta, energies, restart, ranks."""
import numpy
from _runs import check, check_between, finish, mesh, require, run
from _whole import check_goes_on

RHO = 1000.0
STEPS = {"ts_type": "central_difference", "contacts": "face", "contact_face_enforce": "impulse", "ics": "flight"}
BLOCKS = {**STEPS, "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 6, "mesh_set_n_upper": 5, "mesh_set_gap": 0.017,
          "mesh_set_inset": 0.1, "materials": "lower,upper", "material_lower_rho": RHO, "material_upper_model": "rigid",
          "material_upper_rho": 300, "ic_flight_on": "upper", "contact_face_secondary": "upper_bottom",
          "contact_face_primary": "lower_top"}
SOFT = {"material_lower_E": 1e6, "material_lower_nu": 0.3}


def largest(values):
    return abs(values).max()


def kept(name, r, one, other, axes="xy"):
    """Momenta of both bodies, and the energy that is theirs."""
    for axis in axes:
        whole = r[f"momentum_{one}_{axis}"] + r[f"momentum_{other}_{axis}"]
        check(f"{name}: momentum in {axis}, change", numpy.ptp(whole) / largest(r[f"momentum_{one}_y"]), 0, 1e-12, relative=False)
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check(f"{name}: highest energy over the start's", energy.max() / energy[0], 1, 1e-12)


print("two rigid blocks: one velocity after the impact, whatever the step")
HARD = {**BLOCKS, "material_lower_model": "rigid", "ts_max_time": 0.03}
LOWER, UPPER = RHO, 300 * 0.8
for dt, options in ((1e-3, {}), (2e-4, {"contact_face_secondary": "lower_top", "contact_face_primary": "upper_bottom"})):
    r = run("hard", {**HARD, **options, "ts_dt": dt, "ic_flight_vy": -1})
    for body in ("lower", "upper"):
        check(f"velocity of {body}", r[f"rigid_{body}_vy"][-1], -UPPER / (UPPER + LOWER), 1e-8)
        check(f"spin of {body}", r[f"rigid_{body}_wz"][-1], 0, 1e-10, relative=False)
    check("the gap that is left over the first", r["contact_face_gap_min"][-1] / 0.017, 0, 1e-9, relative=False)
    check("energy lost", r["dissipated_contact"][-1], UPPER * LOWER / (UPPER + LOWER) / 2, 1e-10)
    check("nothing else", largest(r["dissipated_numerical"]), 0, 1e-9, relative=False)
    kept("blocks", r, "upper", "lower")
r = run("rub", {**HARD, "ts_dt": 1e-3, "ic_flight_vy": -1, "ic_flight_vx": 0.3, "contact_face_friction": 0.1})
P, T = r["impulse_face_y"][-1], r["impulse_face_x"][-1]
check("tangential over normal impulse", -T / P, 0.1, 1e-9)
speed = [numpy.array([r[f"rigid_{b}_v{a}"][-1] for a in "xy"] + [r[f"rigid_{b}_wz"][-1]]) for b in ("lower", "upper")]
check("the faces turn alike", speed[0][2] / speed[1][2], 1, 1e-6)
slip = [0.3, speed[1][0] + speed[1][2] / 2 - speed[0][0] + speed[0][2] / 2]
check("heat over impulse times mean slip", r["dissipated_friction"][-1] / (-T * sum(slip) / 2), 1, 2e-3)
kept("with friction", r, "upper", "lower")
check("moment of momentum, change", numpy.ptp(r["spin_upper_z"] + r["spin_lower_z"]) / UPPER, 0, 1e-12, relative=False)

print("a mass hits a rod: its velocity falls as exp(-rho c A t/M) until the wave is back, the better the finer")
E, M, AREA = 1e9, 25.0, 0.05
ROD = {**STEPS, "mesh": mesh("block.geo"), "mesh_set_n": 1, "mesh_set_lx": 0.1, "mesh_set_ly": 1, "thickness": 0.5, "materials": "rod",
       "material_rod_region": "solid", "material_rod_E": E, "material_rod_nu": 0, "material_rod_rho": RHO,
       "contact_face_secondary": "bottom", "contact_face_primary": "plane", "contact_face_rigid_mass": M,
       "contact_face_rigid_ux": 0, "ic_flight_on": "obstacle_face", "ic_flight_vy": 1, "ts_max_time": 1.9e-3}
errors = []
for n in (50, 200):
    r = run("rod", {**ROD, "mesh_set_ny": n})
    errors.append(largest(r["rigid_obstacle_face_vy"] - numpy.exp(-RHO * (E / RHO)**0.5 * AREA / M * r["time"])))
check("velocity of the mass, worst", errors[1], 0, 0.01, relative=False)
check_between("order of the error in the cells", numpy.log2(errors[0] / errors[1]) / 2, 0.8, 1.3)
check("impulse over what the mass lost", r["impulse_face_y"][-1] / (M * (1 - r["rigid_obstacle_face_vy"][-1])), 1, 1e-12)
kept("rod", r, "obstacle_face", "rod", "y")

print("a ball that spins falls on a slab in space")
BALL = {**STEPS, "mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 6, "mesh_set_ny": 2, "mesh_set_ly": 0.4,
        "materials": "slab", "material_slab_region": "solid", "material_slab_E": 1e6, "material_slab_nu": 0.3,
        "material_slab_rho": RHO, "contact_face_secondary": "top", "contact_face_primary": "rigid_sphere",
        "contact_face_centre": "0.45,0.91,0.5", "contact_face_radius": 0.5, "contact_face_rigid_mass": 200,
        "contact_face_friction": 0.1, "ic_flight_on": "obstacle_face", "ic_flight_vx": "0-10*(y-0.91)",
        "ic_flight_vy": "10*(x-0.45)-1", "ts_max_time": 0.16}
r = run("ball", BALL)
kept("ball", r, "obstacle_face", "slab", "xyz")
for axis in "xyz":
    check(f"moment of momentum about {axis}, change",
          numpy.ptp(r["spin_slab_" + axis] + r["spin_obstacle_face_" + axis]) / largest(r["spin_obstacle_face_z"]), 0, 1e-12,
          relative=False)
check_between("tangential over normal impulse", abs(r["impulse_face_x"][-1] / r["impulse_face_y"][-1]), 0.08, 0.12)

print("driven bodies are obstacles that move as told")
PRESS = {**STEPS, "mesh": mesh("block.geo"), "mesh_set_n": 4, "materials": "block", "material_block_region": "solid",
         "material_block_E": 1e6, "material_block_nu": 0.3, "material_block_rho": RHO, "contact_face_secondary": "top",
         "contact_face_primary": "plane", "contact_face_plane_point": "0.5,1.001", "contact_face_plane_normal": "0,-1",
         "bcs": "hold", "bc_hold_on": "bottom", "bc_hold_type": "fix", "ts_max_time": 0.05, "contact_face_friction": 0.2}
PRESS.pop("ics")
DRIVE = {"contact_face_rigid_ux": "0.4*t", "contact_face_rigid_uy": "(0-2)*t"}
told = run("told", {**PRESS, **DRIVE})
mass = run("mass", {**PRESS, **DRIVE, "contact_face_rigid_mass": 50, "contact_face_rigid_inertia": 5, "contact_face_rigid_rz": 0,
                    "ts_dt": "auto"})
for column in ("contact_face_force_x", "contact_face_force_y", "energy_elastic", "dissipated_friction", "work_external"):
    check(f"{column}: with mass and without", largest(told[column] - mass[column]) / largest(told[column]), 0, 1e-9, relative=False)

print("a square tumbles on a block")
TUMBLE = {**BLOCKS, **SOFT, "mesh_set_n_lower": 10, "mesh_set_gap": 0.4, "mesh_set_inset": 0.3, "ic_flight_vx": "0.3-8*(y-1.9)",
          "ic_flight_vy": "8*(x-0.5)-3", "contact_face_secondary": "upper_sides", "contact_face_friction": 0.3, "ts_max_time": 0.4,
          "checkpoint_every": 20}
whole = run("tumble", TUMBLE)
kept("square", whole, "upper", "lower")
check("moment of momentum, change", numpy.ptp(whole["spin_upper_z"] + whole["spin_lower_z"]) / largest(whole["spin_upper_z"]), 0,
      1e-12, relative=False)
require("it turned, and back", whole["rigid_upper_rz"].max() > 1.5 and whole["rigid_upper_wz"].min() < -3)
check_goes_on("", TUMBLE, whole, int(whole["step"][-1]) * 2 // 3, 1e-6)
finish()
