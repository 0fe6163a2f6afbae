# labels: run
# long: 120
"""The corner of a cantilever that a wedge of another mesh, or a round rigid body, lifts against friction: the wedge's face has the only normal there, so
that the force is Coulomb's, F_x/F_y = tan(angle + atan mu), by mortar and Gauss points, in the plane and in space; the work of friction
is that of the force along the face."""
import math

import numpy
from _runs import check, check_between, finish, long, require, run

MU = 0.2


def geo(angle, dim):
    """A beam 5 x 0.5, and a wedge that reaches two facets below its end, whose face rises by the angle."""
    slope, start = math.tan(math.radians(angle)), 4.78
    low, high = -0.02 - (5 - start) * slope, -0.02 + 1 * slope
    name = f"wedge_{angle}_{dim}.geo"
    lines = ["Point(1) = {0, 0, 0}; Point(2) = {5, 0, 0}; Point(3) = {5, 0.5, 0}; Point(4) = {0, 0.5, 0};",
             f"Point(11) = {{{start}, -2, 0}}; Point(12) = {{6, -2, 0}}; Point(13) = {{6, {high!r}, 0}}; Point(14) = {{{start}, {low!r}, 0}};",
             "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};",
             "Line(11) = {11, 12}; Line(12) = {12, 13}; Line(13) = {13, 14}; Line(14) = {14, 11};",
             "Curve Loop(1) = {1 : 4}; Plane Surface(1) = {1}; Curve Loop(11) = {11 : 14}; Plane Surface(11) = {11};",
             "Transfinite Curve {1, 3} = 51; Transfinite Curve {2, 4} = 3; Transfinite Curve {11 : 14} = 4;",
             "Transfinite Surface \"*\"; Recombine Surface {1, 11};"]
    if dim == 2:
        lines += ["Physical Surface(\"beam\") = {1}; Physical Surface(\"wedge\") = {11};",
                  "Physical Curve(\"foot\") = {1}; Physical Curve(\"clamp\") = {4}; Physical Curve(\"base\") = {11}; Physical Curve(\"face\") = {13};"]
    else:
        lines += ["a[] = Extrude {0, 0, 1} { Surface{1}; Layers{2}; Recombine; };",
                  "b[] = Extrude {0, 0, 1.5} { Surface{11}; Layers{2}; Recombine; };",
                  "Physical Volume(\"beam\") = {a[1]}; Physical Volume(\"wedge\") = {b[1]};",
                  "Physical Surface(\"foot\") = {a[2]}; Physical Surface(\"clamp\") = {a[5]};",
                  "Physical Surface(\"base\") = {b[2]}; Physical Surface(\"face\") = {b[4]};"]
    with open(name, "w") as file:
        file.write("\n".join(lines) + "\n")
    return name


def lifted(name, dim, mesh, **more):
    """The beam, clamped, with a probe at the corner; what lifts it moves by 0.4 to the left."""
    return run(name, {
        "mesh": mesh, "units": "mm_t_s_MPa", "materials": "beam,wedge", "material_beam_E": 2000, "material_beam_nu": 0.3,
        "material_wedge_E": 200e3, "material_wedge_nu": 0.3, "bcs": "clamp,push", "bc_clamp_on": "clamp", "bc_clamp_type": "fix",
        "bc_push_on": "base", "bc_push_ux": "0 - 0.4*t", "bc_push_uy": 0, **({"bc_push_uz": 0} if dim == 3 else {}),
        "contacts": "edge", "contact_edge_secondary": "foot", "contact_edge_friction": MU, "probes": "corner",
        "probe_corner_at": "5,0,0.5" if dim == 3 else "5,0", "ts_type": "static", "ts_dt": 0.05, "ts_max_time": 1, **more}, refused=None)


for dim, angle, form in ((2, 20, {"method": "mortar"}), (2, 45, {"method": "mortar"}), (2, 45, {"method": "gpts"}),
                         (3, 20, {"method": "mortar"}), (3, 30, {"method": "mortar"}), (3, 30, {"method": "gpts", "enforce": "penalty"})):
    name = f"{dim}D, {angle} degrees, {form['method']}"
    r = lifted(name.replace(", ", "_").replace(" ", "_"), dim, geo(angle, dim), contact_edge_primary="face",
               **{f"contact_edge_{key}": value for key, value in form.items()})
    on = r["time"] > 0.4
    force = -r["contact_edge_force_x"][on] / r["contact_edge_force_y"][on]
    exact = math.tan(math.radians(angle) + math.atan(MU))
    check(f"{name}: F_x/F_y, largest", force.max(), exact, 1e-3)
    check(f"{name}: F_x/F_y, smallest", force.min(), exact, 1e-3)
    if form["method"] == "mortar":
        check(f"{name}: Newton iterations a step", r["newton"][on].mean(), 3, 2, relative=False)
    t, n = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    along = abs(r["contact_edge_force_x"] * t + r["contact_edge_force_y"] * n)
    taken = numpy.diff(r["dissipated_friction"])[on[1:]] / along[1:][on[1:]]  # a static step works by the force of its end
    way = numpy.diff(r["probe_corner_ux"] + 0.4 * r["time"]) / t
    check(f"{name}: what friction takes, over its force and the way of the corner along the face", (taken / way[on[1:]]).mean(), 1, 0.01)

# On a round body the normal is that at the place: of the Gauss point next to the corner, or of the corner, the middle of its dual function.
centre = numpy.array([5.02 + math.sqrt(0.5), -math.sqrt(0.5)])
for method, beside in ("mortar", 0), ("gpts", 0.1 * (0.5 - math.sqrt(1 / 12))):
    r = lifted(f"round_{method}", 2, geo(45, 2), contact_edge_primary="rigid_cylinder", contact_edge_centre=f"{centre[0]!r},{centre[1]!r}",
               contact_edge_radius=1, contact_edge_rigid_ux="0 - 0.4*t", contact_edge_method=method)
    on = r["time"] > 0.4
    x, y = 5 - beside + r["probe_corner_ux"] + 0.4 * r["time"] - centre[0], r["probe_corner_uy"] - centre[1]
    exact = numpy.tan(numpy.arctan2(-x, y) + math.atan(MU))
    ratio = -r["contact_edge_force_x"][on] / r["contact_edge_force_y"][on]
    check(f"round body, {method}: F_x/F_y over Coulomb's there", abs(ratio / exact[on] - 1).max(), 0, 0.01, relative=False)

# The directions of friction are those of the last solves: a restart finds them again.
FORMS = {"method": "mortar"}, {"method": "gpts", "enforce": "penalty"}, {"method": "gpts"}
for form in FORMS[: 3 if long() else 2]:
    own = {f"contact_edge_{key}": value for key, value in form.items()}
    name = "_".join(form.values())
    whole = lifted(f"whole_{name}", 2, geo(45, 2), contact_edge_primary="face", checkpoint_every=9, **own)
    lifted(f"again_{name}", 2, geo(45, 2), contact_edge_primary="face", ts_max_steps=9, **own)
    again = lifted(f"again_{name}", 2, geo(45, 2), contact_edge_primary="face", restart="auto", **own)
    require(f"restart, {name}: no bit differs", all(numpy.array_equal(whole[c], again[c], equal_nan=True) for c in whole.history))

# A disc falls with a node right on the end of a block: what lies over the end is next to nothing at first, and augmentations, which no
# pressure there ends, made 22 times the energy of the flight of it.
with open("end.geo", "w") as file:
    file.write("""r = 0.01; gap = 2e-4; w = 0.02;
Point(1) = {0, gap, 0}; Point(2) = {r, r + gap, 0}; Point(3) = {0, 2 * r + gap, 0}; Point(4) = {-r, r + gap, 0}; Point(5) = {0, r + gap, 0};
Circle(1) = {1, 5, 2}; Circle(2) = {2, 5, 3}; Circle(3) = {3, 5, 4}; Circle(4) = {4, 5, 1};
Point(11) = {-w, -r, 0}; Point(12) = {0, -r, 0}; Point(13) = {0, 0, 0}; Point(14) = {-w, 0, 0};
Line(11) = {11, 12}; Line(12) = {12, 13}; Line(13) = {13, 14}; Line(14) = {14, 11};
Curve Loop(1) = {1 : 4}; Plane Surface(1) = {1}; Curve Loop(2) = {11 : 14}; Plane Surface(2) = {2};
Transfinite Curve {1 : 4, 11, 13} = 9; Transfinite Curve {12, 14} = 5; Transfinite Surface {1, 2}; Recombine Surface {1, 2};
Physical Surface("disc") = {1}; Physical Surface("block") = {2};
Physical Curve("round") = {1 : 4}; Physical Curve("top") = {13}; Physical Curve("base") = {11};
""")
for enforce in "auglag", "semismooth":
    r = run(f"end_{enforce}", {
        "mesh": "end.geo", "materials": "disc,block", "material_disc_E": 1e9, "material_disc_nu": 0.3, "material_disc_rho": 1000,
        "material_block_E": 2e9, "material_block_nu": 0.3, "material_block_rho": 2000, "bcs": "base", "bc_base_on": "base", "bc_base_type": "fix",
        "ics": "fall", "ic_fall_on": "disc", "ic_fall_vy": "(-10)", "contacts": "hit", "contact_hit_secondary": "round",
        "contact_hit_primary": "top", "contact_hit_enforce": enforce, "ts_dt": 1e-6, "ts_max_time": 8e-5})
    check_between(f"the end of a block, {enforce}: what the contact takes over the energy of the flight",
                  r["dissipated_contact"][-1] / r["energy_kinetic"][0], 0, 0.01)
    check_between(f"the end of a block, {enforce}: momentum of the disc over that it came with", r["momentum_disc_y"][-1] / r["momentum_disc_y"][0], -1, -0.2)
finish()
