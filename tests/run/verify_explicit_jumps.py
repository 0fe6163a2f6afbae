# labels: run
# timeout: 120
# long: 200
"""Penalties of explicit steps where points come to see facets that they lie deep in: bodies that tumble with their corners ahead
gain no energy, what presses and slides over kinks keeps its force; restart, repeated steps, ranks."""
import numpy
from _runs import check, check_between, finish, long, mesh, require, run
from _whole import check_goes_on

RHO = 1000.0
STEPS = {"ts_type": "central_difference", "contacts": "face", "contact_face_enforce": "penalty"}
TUMBLE = {**STEPS, "mesh": mesh("two_blocks.geo"), "mesh_set_gap": 0.5, "mesh_set_inset": 0.3, "materials": "lower,upper",
          "material_lower_rho": RHO, "material_lower_E": 1e6, "material_lower_nu": 0.3, "ics": "flight", "ic_flight_on": "upper",
          "contact_face_secondary": "upper_sides", "contact_face_primary": "lower_top", "ts_max_time": 0.35, "energy_stop": 1e3}
RIGID = {"material_upper_model": "rigid"}
SOFT = {"material_upper_E": 1e6, "material_upper_nu": 0.3}


def flight(w, v):
    """Spin w about (0.5, 1.9, 0.5), velocity v."""
    return {"ic_flight_vx": f"{v[0]}-{w[2]}*(y-1.9)+{w[1]}*(z-0.5)", "ic_flight_vy": f"{v[1]}+{w[2]}*(x-0.5)-{w[0]}*(z-0.5)",
            "ic_flight_vz": f"{w[0]}*(y-1.9)-{w[1]}*(x-0.5)"}


def plane(w, v):
    options = {**flight((0, 0, w), v), "mesh_set_gap": 0.4, "mesh_set_n_lower": 10, "mesh_set_n_upper": 5}
    del options["ic_flight_vz"]
    return {**options, **{key: options[key].replace("(z-0.5)", "0") for key in ("ic_flight_vx", "ic_flight_vy")}}


def swapped():
    return {"contact_face_secondary": "lower_top", "contact_face_primary": "upper_sides"}


def space(w, v, n_lower=6):
    return {**flight(w, v), "mesh_set_dim": 3, "mesh_set_n_lower": n_lower, "mesh_set_n_upper": 4}


CASES = {  # of those that gained most among 64 flights by chance
    "square": {**RIGID, **plane(10.16, (-0.57, -4.46)), "material_upper_rho": 1000},
    "square, with friction": {**RIGID, **swapped(), **plane(-5.62, (-0.64, -2.12)), "material_upper_rho": 3000, "contact_face_friction": 0.3},
    "square that lands flat": {**RIGID, **swapped(), **plane(-1.4, (0, -1.39)), "mesh_set_n_lower": 14, "material_upper_rho": 3000, "ts_max_time": 0.4},
    "soft cube, with friction": {**SOFT, **space((10.64, -3.37, 6.84), (-0.41, -3.37, 0)), "material_upper_rho": 3000, "contact_face_friction": 0.3},
    "soft cube": {**SOFT, **swapped(), **space((-8.16, 2.06, 7.77), (0.37, -2.19, 0)), "material_upper_rho": 1000},
}
print("bodies that tumble on a soft block with their corners ahead")
for name, options in CASES.items():
    r = run("tumble", {**TUMBLE, **options})
    energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
    require(f"{name}: it struck", (r["contact_face_active"] > 0).sum() > 20)
    check_between(f"{name}: highest energy over the start's", energy.max() / energy[0], 1 - 1e-12, 1.02)
    for axis in "xy":
        whole = r[f"momentum_upper_{axis}"] + r[f"momentum_lower_{axis}"]
        check(f"{name}: momentum in {axis}, change", numpy.ptp(whole) / abs(r["momentum_upper_y"]).max(), 0, 1e-12, relative=False)
check_goes_on("", {**TUMBLE, **options, "checkpoint_every": 20}, run("goes_on", {**TUMBLE, **options, "checkpoint_every": 20}), 160, 1e-6)

print("two squares that meet corner to corner: one point presses each, which must not go through")
with open("corners.geo", "w", encoding="ascii") as file:
    file.write("""DefineConstant[m = 12];
q = 0.08;
For k In {0 : 1}
  f = 10 * k; a = (5 + 31 * k) * Pi / 180; x0 = 0.25 + k * 0.03 * Sin(3); y0 = 0.25 + 0.3 * k;
  For i In {0 : 3}
    x = (i == 1 || i == 2) ? q : -q; y = i > 1 ? q : -q;
    Point(f + i + 1) = {x0 + Cos(a) * x - Sin(a) * y, y0 + Sin(a) * x + Cos(a) * y, 0};
  EndFor
  For i In {1 : 4}
    Line(f + i) = {f + i, f + 1 + (i % 4)};
  EndFor
  Curve Loop(k + 1) = {f + 1 : f + 4};
  Plane Surface(k + 1) = {k + 1};
  Transfinite Curve {f + 1 : f + 4} = m + k + 1;
EndFor
Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("lower") = {1}; Physical Surface("upper") = {2}; Physical Curve("skin") = {1 : 4, 11 : 14};
""")
CORNERS = {**STEPS, "mesh": "corners.geo", "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3, "material_lower_rho": RHO,
           "material_upper_like": "lower", "ics": "up,down", "ic_up_on": "lower", "ic_up_vy": 3, "ic_down_on": "upper", "ic_down_vy": -3,
           "contact_face_secondary": "skin", "contact_face_primary": "skin", "ts_max_time": 0.1, "energy_stop": 1e3}
# Points that slip round a corner give or take some, by stiff penalties (1e9) 2 %.
for name, options, tolerance in (("12 cells", {"mesh_set_m": 12}, 1e-2), ("24 cells", {"mesh_set_m": 24}, 6e-2), ("second order", {"mesh_set_m": 6, "order": 2}, 2e-2)):
    r = run("corners", {**CORNERS, **options})
    energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
    require(f"{name}: they press and part", r["contact_face_active"].max() > 0 and r["contact_face_active"][-1] == 0)
    check(f"{name}: energy at the end over the start's", energy[-1] / energy[0], 1, tolerance)
    check(f"{name}: springs lost, of the energy of the start", r["dissipated_contact"][-1] / energy[0], 0, 2e-3, relative=False)

print("a rotor of 12 facets pressed into a slab: what slides over its kinks keeps its force")
SPIN = {**STEPS, "mesh": mesh("roller.geo"), "mesh_set_n": 12, "mesh_set_n_slab": 24, "materials": "disc,slab", "material_disc_model": "rigid",
        "material_disc_rho": 1, "material_slab_E": 1e4, "material_slab_nu": 0.2, "material_slab_rho": 1, "material_slab_b_d": 0.5,
        "bcs": "hold,axle", "bc_hold_on": "slab_bottom", "bc_hold_type": "fix", "bc_axle_on": "disc", "bc_axle_type": "displacement",
        "bc_axle_ux": 0, "bc_axle_uy": "-0.1*min(t/0.1,1)", "bc_axle_rz": "10*t", "contact_face_secondary": "slab_top",
        "contact_face_primary": "disc_side", "ts_max_time": 1.5}
r = run("spin", SPIN)
force, t = abs(r["contact_face_force_y"]), r["time"]
turns = [force[(t > start) & (t <= start + 0.2 * numpy.pi)].mean() for start in (0.15, 1.5 - 0.2 * numpy.pi)]
check("mean force of the last turn over that of the first", turns[1] / turns[0], 1, 5e-3)

print("a block that slides on a longer one, whose surface is the secondary side and stands higher before it")
SLIDE = {**STEPS, "mesh": mesh("brake.geo"), "mesh_set_h": 1, "mesh_set_layers": 6, "materials": "plate,pad", "material_plate_E": 1e10,
         "material_plate_nu": 0.3, "material_plate_rho": 2000, "material_plate_b_d": 1e4, "material_pad_like": "plate", "bcs": "hold,press",
         "bc_hold_on": "plate_bottom", "bc_hold_type": "fix", "bc_press_on": "pad_top", "bc_press_type": "traction",
         "bc_press_uy": "0-2e7*ramp(t,0,0.1)", "ics": "go", "ic_go_on": "pad", "ic_go_vx": 10, "contact_face_secondary": "plate_top",
         "contact_face_primary": "pad_bottom", "ts_max_time": 1}
r = run("slide", SLIDE)
check("velocity of the block at the end over the start's", r["momentum_pad_x"][-1] / r["momentum_pad_x"][0], 1, 5e-3)
r = run("slide_impulse", {**SLIDE, "contact_face_enforce": "impulse", "energy_stop": 1e3})
check_between("by impulses: the deepest place, in facets", r["contact_face_gap_min"].min(), -0.08, -1e-3)
require("what contact gave is told, and what helps", "exchange the sides of the contact" in r.log)
if long():
    exchanged = run("slide_exchanged", {**SLIDE, "contact_face_enforce": "impulse", "contact_face_secondary": "pad_bottom",
                                        "contact_face_primary": "plate_top"})
    check("with the sides exchanged", exchanged["momentum_pad_x"][-1] / exchanged["momentum_pad_x"][0], 1, 5e-3)
    check_between("which gives nothing", exchanged["dissipated_contact"].min(), 0, 1e-9)

print("a tilted shot whose corner breaks its way into a plate: what it met it goes on meeting, as deep as the penalty lets it in")
with open("shot.geo", "w", encoding="ascii") as file:
    file.write("""For k In {0 : 1}
  w = k == 0 ? 40 : 10; t = k == 0 ? 6 : 12; a = k * 25 * Pi / 180; y0 = k == 0 ? -6 : 0.2 + 5 * Sin(a); x0 = 0.13 * k;
  For i In {0 : 3}
    x = ((i == 1 || i == 2) ? w : -w) / 2; y = i > 1 ? t : 0;
    Point(10 * k + i + 1) = {Cos(a) * x - Sin(a) * y + x0, Sin(a) * x + Cos(a) * y + y0, 0};
  EndFor
  For i In {1 : 4}
    Line(10 * k + i) = {10 * k + i, 10 * k + 1 + (i % 4)};
  EndFor
  Curve Loop(k + 1) = {10 * k + 1 : 10 * k + 4};
  Plane Surface(k + 1) = {k + 1};
  h = 1 + 0.3 * k;
  Transfinite Curve {10 * k + 1, 10 * k + 3} = Ceil(w / h) + 1;
  Transfinite Curve {10 * k + 2, 10 * k + 4} = Ceil(t / h) + 1;
EndFor
Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("plate") = {1}; Physical Surface("shot") = {2};
Physical Curve("plate_skin") = {1 : 4}; Physical Curve("shot_skin") = {11 : 14}; Physical Curve("ends") = {2, 4};
""")
SHOT = {"ts_type": "central_difference", "mesh": "shot.geo", "units": "mm_t_s_MPa", "materials": "plate,shot", "material_plate_E": 70e3,
        "material_plate_nu": 0.33, "material_plate_rho": 2.7e-9, "material_plate_model": "j2", "material_plate_sigma_y": 300,
        "material_plate_hardening": "linear", "material_plate_linear_h": 500, "material_plate_erosion": "on", "material_plate_erosion_strain": 0.6,
        "material_shot_model": "j2", "material_shot_sigma_y": 1200, "material_shot_E": 200e3, "material_shot_nu": 0.3,
        "material_shot_rho": 7.8e-9, "bcs": "hold", "bc_hold_on": "ends", "bc_hold_type": "fix", "ics": "go", "ic_go_on": "shot",
        "ic_go_vy": -250e3, "contacts": "face,own", "contact_face_secondary": "shot_skin", "contact_face_primary": "plate_skin",
        "contact_own_secondary": "plate_skin", "contact_own_primary": "plate_skin", "ts_max_time": 1e-4}
soft = run("shot", SHOT)
hard = run("shot_hard", {**SHOT, "contact_face_penalty": 1e6})
for name, r in (("automatic penalty", soft), ("a stiffer one", hard)):
    require(f"{name}: cells leave", r["eroded_cells"][-1] > 4)
    check(f"{name}: first law", abs(r["balance_first_law"]).max(), 0, 5e-3, relative=False)
check("kinetic energy left, of that at the start", *(r["energy_kinetic"][-1] / r["energy_kinetic"][0] for r in (soft, hard)), 0.03, relative=False)
finish()
