# labels: run
# timeout: 120
# long: 300
"""Cells that leave their bodies: what they take along in closed form, momentum and balances to rounding, faces that come free in
the plane and in space, cells that lose their volume, restart, ranks and repeated steps, what is refused."""
import filecmp
import re

import numpy
from _histories import difference
from _runs import check, check_between, finish, long, mesh, require, run, some

# A step of 0.004 is as long as the stable one, within a tenth.
SCHEMES = {"explicit": {"ts_type": "central_difference"}, "implicit": {"ts_type": "newmark", "ts_dt": 0.004}}
SECOND = {"explicit, second order": {**SCHEMES["explicit"], "order": 2}}
BY_PENALTY = {"contact_hit_method": "gpts", "contact_hit_enforce": "penalty"}
EXPLICIT = SCHEMES["explicit"]
E, RHO = 1e6, 1000.0


def largest(values):
    return abs(values).max()


def material(name, **more):
    return {f"material_{name}_{key}": value for key, value in {"E": E, "nu": 0, "rho": RHO, **more}.items()}


BOXES = """// Boxes one on the other, x from 0 to `lx` but for the last one, which stands in the middle above a gap.
DefineConstant[dim = 2, lx = 4, h = 0.25, gap = 0.02];
y[] = {%s};
For k In {0 : #y[] - 2}
  left = 0; right = lx; low = y[k]; high = y[k + 1];
  If (k == #y[] - 2)
    left = lx / 2 - 0.5; right = lx / 2 + 0.5; low += gap; high += gap;
  EndIf
  If (k == 0 || k == #y[] - 2)
    a = newp; Point(a) = {left, low, 0}; Point(a + 1) = {right, low, 0};
    bottom = newl; Line(bottom) = {a, a + 1};
    Transfinite Curve {bottom} = Round((right - left) / h) + 1;
  Else
    bottom = top; a = c;
  EndIf
  If (k == 0)
    first = bottom;
  EndIf
  If (k == #y[] - 2)
    foot = bottom;
  EndIf
  c = newp; Point(c) = {left, high, 0}; Point(c + 1) = {right, high, 0};
  If (k < #y[] - 2)
    skin = newl;
  EndIf
  top = newl; Line(top) = {c, c + 1}; Transfinite Curve {top} = Round((right - left) / h) + 1;
  If (k < #y[] - 2)
    skin = top;
  EndIf
  up = newl; Line(up) = {a, c}; Line(up + 1) = {a + 1, c + 1};
  Transfinite Curve {up, up + 1} = Round((high - low) / h) + 1;
  Curve Loop(k + 1) = {bottom, up + 1, -top, -up}; Plane Surface(k + 1) = {k + 1};
  Transfinite Surface {k + 1}; Recombine Surface {k + 1};
EndFor
If (dim == 2)
  For k In {1 : #y[] - 1}
    Physical Surface(Sprintf("box%%g", k)) = {k};
  EndFor
  Physical Curve("skin") = {skin}; Physical Curve("foot") = {foot};
Else
  For k In {1 : #y[] - 1}
    depth = (k == #y[] - 1) ? 0.5 : 1;
    out[] = Extrude {0, 0, depth} { Surface{k}; Layers{depth / h}; Recombine; };
    Physical Volume(Sprintf("box%%g", k)) = {out[1]};
    If (k == #y[] - 1)
      Physical Surface("foot") = {out[2]};
    EndIf
    If (k == #y[] - 2)
      Physical Surface("skin") = {out[4]};
    EndIf
  EndFor
EndIf
"""

BAR = """x[] = {0, 4, 5, 9};
For k In {0 : 3}
  Point(2 * k + 1) = {x[k], 0, 0}; Point(2 * k + 2) = {x[k], 1, 0};
  Line(10 + k) = {2 * k + 1, 2 * k + 2}; Transfinite Curve {10 + k} = 3;
EndFor
For k In {0 : 2}
  Line(20 + k) = {2 * k + 1, 2 * k + 3}; Line(30 + k) = {2 * k + 2, 2 * k + 4};
  Transfinite Curve {20 + k, 30 + k} = 4 * (x[k + 1] - x[k]) + 1;
  Curve Loop(k + 1) = {20 + k, 11 + k, -(30 + k), -(10 + k)}; Plane Surface(k + 1) = {k + 1};
  Transfinite Surface {k + 1}; Recombine Surface {k + 1};
EndFor
Physical Surface("left") = {1}; Physical Surface("middle") = {2}; Physical Surface("right") = {3};
"""

print("a bar pulled apart")
# Without lateral strain the middle is stretched evenly until the waves from the ends arrive.
RATE, LIMIT = 0.4, 1.02
with open("bar.geo", "w", encoding="ascii") as file:
    file.write(BAR)
PULL = {"mesh": "bar.geo", "materials": "left,middle,right", **material("left"), **material("middle"), **material("right"),
        "bcs": "sides", "bc_sides_on": "left,middle,right", "bc_sides_uy": 0, "ics": "pull", "ic_pull_on": "left,middle,right",
        "ic_pull_vx": f"{RATE}*(x-4.5)", "ts_max_time": 0.6, "outputs": "hist,vis",
        "output_hist_type": "csv", "output_hist_every": 1, "output_vis_every": 100000, "output_vis_fields": "u"}
WEAK = {"material_middle_erosion": "on", "material_middle_erosion_stretch": LIMIT}
for scheme, steps in [*SCHEMES.items(), *(SECOND.items() if long() else ())]:
    bar = run(f"bar_{scheme}", {**{k: v for k, v in PULL.items() if k != "output_vis_fields"}, **steps, **WEAK})
    cells, time = bar["eroded_cells"], bar["time"]
    first = numpy.nonzero(cells)[0][0]
    K, G, stretch = E / 3, E / 2, 1 + RATE * time[first]
    density = K / 2 * ((stretch ** 2 - 1) / 2 - numpy.log(stretch)) + G / 2 * (stretch ** (-2 / 3) * (stretch ** 2 + 2) - 3)
    print(f"     {scheme}: {cells[-1]:.0f} cells leave at the stretch {stretch:.5f}")
    require(f"{scheme}: the middle leaves in the first step at the limit", cells[first] == cells[-1] == 8 and 1 + RATE * time[first - 1] < LIMIT <= stretch)
    check(f"{scheme}: its energy", bar["dissipated_erosion"][-1] / density, 1, 1e-9 if "explicit" in scheme else 1e-6)  # Newmark ends where Newton's method does
    check(f"{scheme}: its mass", bar["eroded_mass"][-1] / RHO, 1, 1e-12)
    whole = run(f"bar_whole_{scheme}", {**PULL, **steps})
    with open(f"bar_{scheme}/vis.xdmf", encoding="utf-8") as file:
        require(f"{scheme}: fields of bodies that erode show by default what has left", 'Name="eroded"' in file.read())
    require(f"{scheme}: the log tells of them", re.search(r"step \d+: cells that have left: 8, their mass 1000, the energy", bar.log) is not None)
    require(f"{scheme}: no column tells of cells that leave where none may", not any("ero" in c for c in whole.history))
    momentum = sum(bar[f"momentum_{part}_x"] for part in ("left", "middle", "right"))
    check(f"{scheme}: momentum", largest(momentum) / bar["momentum_right_x"][0], 0, 1e-12, relative=False)
    check(f"{scheme}: balance", largest(bar["balance"]), 0, 1e-10, relative=False)
    check(f"{scheme}: first law", largest(bar["balance_first_law"]), 0, 1e-2, relative=False)
    half = bar["momentum_right_x"]
    check_between(f"{scheme}: the halves go on flying apart: momentum of one in the end, over the first", half[-1] / half[0], 0.4, 1)
    require(f"{scheme}: that of a bar which holds swings back", whole["momentum_right_x"].min() < -0.1 * half[0] and bar["momentum_right_x"].min() > 0)
if long():
    fine, finer = (run(f"bar_{parts}", {**PULL, **WEAK, "ts_type": "newmark", "ts_dt": 0.004 / parts, "ts_max_time": 0.3})["balance_first_law"][-1]
                   for parts in (4, 16))
    check_between("implicit: what the first law misses with steps four times as long, first order", fine / finer, 2.5, 5)

# With their mass go momentum and kinetic energy; the bar flies to the right as a whole. Lumped masses stand at x = 4, 4.25, .. 5.
FLY = 1.0
flying = {**PULL, **EXPLICIT, **WEAK, "ic_pull_vx": f"{RATE}*(x-4.5)+{FLY}"}
kept, gone = (run(f"bar_{word}", {**flying, "material_middle_erosion_mass": word, "checkpoint_every": 10}) for word in ("keep", "remove"))
places, share = numpy.linspace(4, 5, 5), RHO / 4 * numpy.array([0.5, 1, 1, 1, 0.5])
mass = gone["eroded_mass"][-1]
left = numpy.nonzero(gone["eroded_cells"])[0][0]
check("remove: momentum that goes", gone["eroded_momentum_x"][-1], mass * FLY, 1e-9)
check("remove: kinetic energy that goes, beside what the integrator held", gone["dissipated_erosion"][-1] - kept["dissipated_erosion"][-1],
      (share / 2 * (RATE * (places - 4.5) + FLY) ** 2).sum(), 1e-3)
check("remove: kinetic energy, before and after", gone["energy_kinetic"][left] - kept["energy_kinetic"][left],
      -(share / 2 * (RATE * (places - 4.5) + FLY) ** 2).sum(), 1e-9)
momentum = sum(gone[f"momentum_{part}_x"] for part in ("left", "middle", "right"))
check("remove: momentum with that", largest((momentum + gone["eroded_momentum_x"]) / momentum[0] - 1), 0, 1e-12, relative=False)
check("remove: the middle has none left", largest(gone["momentum_middle_x"][left:]), 0, 0, relative=False)
for name in ("balance", "balance_first_law"):
    check(f"remove: {name}", largest(gone[name]), 0, {"balance": 1e-10}.get(name, 1e-2), relative=False)
require("keep: no column tells of momentum that goes", not any("eroded_momentum" in c for c in kept.history))
fly = {**flying, "material_middle_erosion_mass": "remove", "checkpoint_every": 10}
run("bar_again", {**fly, "ts_max_steps": int(gone["step"][left]) + 3})
run("bar_again", {**fly, "restart": "auto"})
require("remove: restart after that is bitwise", filecmp.cmp("bar_remove/history.csv", "bar_again/history.csv", shallow=False))
two = run("bar_two", {**flying, "material_middle_erosion_mass": "remove"}, ranks=2)
worst, where = difference(gone.history, two.history)
check(f"remove: two ranks, in {where}", worst, 0, 1e-8, relative=False)

print("a block strikes one that erodes: what nodes that lose all their mass were to get goes with it")
STRIKE = {"mesh": mesh("two_blocks.geo"), "mesh_set_gap": 0.002, "mesh_scale": 0.1, "mesh_set_n_lower": 6, "mesh_set_n_upper": 4,
          "mesh_set_inset": 0.2, "materials": "lower,upper", "material_lower_E": 7e10, "material_lower_nu": 0.3, "material_lower_rho": 2700,
          "material_lower_model": "j2", "material_lower_sigma_y": 1e8, "material_lower_hardening": "none", "material_lower_erosion": True,
          "material_lower_erosion_strain": 0.15, "material_lower_erosion_mass": "remove", "material_upper_E": 2e11, "material_upper_nu": 0.3,
          "material_upper_rho": 7800, "ics": "f", "ic_f_on": "upper", "ic_f_vy": -300, "contacts": "c", "contact_c_secondary": "lower_top",
          "contact_c_primary": "upper_bottom", "ts_type": "central_difference", "ts_max_time": 6e-5}
for name, options in (("plane", {}), ("two ranks", {"ranks": 2})):
    struck = run("struck", STRIKE, **options)
    for axis in "xy":
        whole = struck[f"momentum_lower_{axis}"] + struck[f"momentum_upper_{axis}"] + struck[f"eroded_momentum_{axis}"]
        check(f"{name}: momentum {axis}", largest(whole - whole[0]) / abs(struck["momentum_upper_y"][0]), 0, 1e-12, relative=False)
require("cells leave", struck["eroded_cells"][-1] > 4)

print("faces that come free")
HIT = {}
for dim, y in ((2, "0, 1, 1.5, 2.5"), (3, "0, 0.5, 1, 1.5")):
    with open(f"boxes{dim}.geo", "w", encoding="ascii") as file:
        file.write(BOXES % y)
    hit = HIT[dim] = {"mesh": f"boxes{dim}.geo", "mesh_set_dim": dim, "mesh_set_lx": 4 if dim == 2 else 2, "mesh_set_h": 0.25,
           "materials": "base,layer,shot", **material("base"), **material("layer", E=E / 20), **material("shot"),
           "material_base_region": "box1", "material_layer_region": "box2", "material_shot_region": "box3",
           "material_layer_erosion": "on", "material_layer_erosion_J": 0.5,
           "ics": "flight", "ic_flight_on": "box3", "ic_flight_vy": -6, "ts_max_time": (0.5, 0.2)[dim - 2],
           "contacts": "hit", "contact_hit_secondary": "foot", "contact_hit_primary": "skin"}
    for scheme, steps in [*SCHEMES.items(), *(SECOND.items() if long() else ())]:
        if dim == 3 and scheme != "explicit" and (scheme == "implicit" or not long()):
            continue
        r = run(f"hit{dim}_{scheme}", {**hit, **steps, **BY_PENALTY}, ranks=dim - 1)
        total = sum(r[f"momentum_{part}_y"] for part in ("base", "layer", "shot"))
        shot = r["momentum_shot_y"] / abs(r["momentum_shot_y"][0])
        begin = numpy.nonzero(r["eroded_cells"])[0]
        print(f"     {dim}D, {scheme}: {r['eroded_cells'][-1]:.0f} cells leave, the shot ends with {shot[-1]:.3f} of its momentum")
        require(f"{dim}D, {scheme}: cells beneath the shot leave", len(begin) > 0 and r["eroded_cells"][-1] >= (4, 8)[dim - 2])
        check(f"{dim}D, {scheme}: momentum", largest(total / total[0] - 1), 0, 1e-10, relative=False)
        check(f"{dim}D, {scheme}: balance", largest(r["balance"]), 0, 1e-10, relative=False)
        # What comes free stops it: through cells that are gone it would fly on with all that it had left.
        left = begin[0] + 2
        check_between(f"{dim}D, {scheme}: the shot at the end, over its momentum as the first cells were gone", shot[-1] / shot[left], -0.5, 0.5)
        require(f"{dim}D, {scheme}: it presses on what has come free", largest(r["contact_hit_force_y"][left:]) > 0)
        check(f"{dim}D, {scheme}: first law", largest(r["balance_first_law"]), 0, 0.1, relative=False)

print("friction, with which the shot comes in sideways; restart, ranks, repeated steps")
RUB = {"contact_hit_friction": 0.3, "ic_flight_vx": 4}
MORE = {"explicit": {"ts_bulk_viscosity_linear": 0.06}, "implicit": {}, "explicit, second order": {"ts_dt_cfl": 0.5}}
for scheme, steps in [*SCHEMES.items(), *(SECOND.items() if long() else ())]:
    chain = {**HIT[2], **BY_PENALTY, **steps, **MORE.get(scheme, {}), **RUB, "checkpoint_every": 10}
    whole = run(f"whole_{scheme}", chain)
    drift = max(numpy.ptp(sum(whole[f"momentum_{part}_{k}"] for part in ("base", "layer", "shot"))) for k in "xy")
    check(f"{scheme}: momentum", drift / abs(whole["momentum_shot_y"][0]), 0, 1e-10, relative=False)
    check(f"{scheme}: balance", largest(whole["balance"]), 0, 1e-10, relative=False)
    check(f"{scheme}: first law", largest(whole["balance_first_law"]), 0, 0.1, relative=False)
    rate = numpy.diff(whole["dissipated_friction"])
    # (82''') takes the mean of both ends of a step, which misses where slip turns round in it.
    require(f"{scheme}: friction turns a part of the energy into heat, and gives none but what a step misses",
            whole["dissipated_friction"][-1] > 0.02 * whole["energy_kinetic"][0] and rate.min() >= -1e-3 * whole["energy_kinetic"][0])
    if scheme == "implicit" and not long():  # verify_erosion_friction goes on with such a run
        continue
    half_of = int(whole["step"][-1]) // 2
    run(f"halves_{scheme}", {**chain, "ts_max_steps": half_of})
    halves = run(f"halves_{scheme}", {**chain, "restart": "auto"})
    require(f"{scheme}: cells have left before the restart and after it",
            0 < whole["eroded_cells"][numpy.searchsorted(whole["step"], half_of)])
    require(f"{scheme}: restart in the middle is bitwise", filecmp.cmp(f"whole_{scheme}/history.csv", f"halves_{scheme}/history.csv", shallow=False))
    if scheme != "explicit" and not long():
        continue
    restep = run(f"restep_{scheme}", {**chain, "test_restep": 1}, refused=None)
    worst, where = max((largest(restep[c] - whole[c]) / max(largest(whole[c]), 1e-300), c) for c in whole.history
                       if c != "tries" and numpy.isfinite(whole[c]).all())
    check(f"{scheme}: every step refused once and repeated, in {where}", worst, 0, 0, relative=False)
    two = run(f"ranks_{scheme}", chain, ranks=2)
    worst, where = difference(whole.history, two.history)
    check(f"{scheme}: two ranks, in {where}", worst, 0, 1e-8, relative=False)
    run(f"moved_{scheme}", {**chain, "ts_max_steps": half_of}, ranks=2)
    moved = run(f"moved_{scheme}", {**chain, "restart": "auto"})
    worst, where = difference(whole.history, moved.history)
    check(f"{scheme}: from two ranks to one, in {where}", worst, 0, 1e-8, relative=False)

print("a cell that loses its volume")
CORNER = {**EXPLICIT, "mesh": mesh("block.geo"), "mesh_set_n": 4, "materials": "solid", **material("solid"), "ics": "corner",
          "ic_corner_on": "solid", "ic_corner_vx": "-300*exp(-1e4*((x-1)^2+(y-1)^2))", "ic_corner_vy": "-300*exp(-1e4*((x-1)^2+(y-1)^2))",
          "ts_max_time": 0.02, "outputs": "hist", "output_hist_type": "csv", "output_hist_every": 1}
cut = run("corner_cut", CORNER, code=None, refused=None)
require("without erosion its steps are refused", "cell inverted" in cut.log)
gone = run("corner", {**CORNER, "material_solid_erosion": "on"})
require("with it the cell leaves in that step", gone["eroded_cells"][1] == 1 and gone["tries"].max() == 1)
check("balance", largest(gone["balance"]), 0, 1e-10, relative=False)
total = gone["momentum_solid_x"]
check("momentum", largest(total / total[0] - 1), 0, 1e-12, relative=False)
# Newton's method tries shorter steps first.
slow = {**CORNER, **SCHEMES["implicit"], "ts_dt": 0.002}
cut = run("slow_cut", slow, code=None, refused=None)
require("without erosion implicit steps are refused", "cell inverted" in cut.log)
gone = run("slow", {**slow, "material_solid_erosion": "on", "energy_stop": 0}, refused=5)
first = numpy.nonzero(gone["eroded_cells"])[0][0]
require("with it a cell leaves after three cuts, and not before", gone["eroded_cells"][-1] >= 1 and gone["tries"][first] >= 4)
check("balance", largest(gone["balance"]), 0, 1e-10, relative=False)
total = gone["momentum_solid_x"]
check("momentum", largest(total / total[0] - 1), 0, 1e-10, relative=False)

# Its friction has no memory: what would stick creeps, by what turns into the force of a step.
for scheme, steps in some(SCHEMES.items(), 2):
    r = run(f"slide_{scheme}", {
        "mesh": mesh("block.geo"), "materials": "solid", **material("solid", E=1e8), "material_solid_erosion": "on", "material_solid_erosion_J": 0.1,
        "bcs": "weight", "bc_weight_on": "solid", "bc_weight_type": "body_force", "bc_weight_uy": -10, "ics": "flight",
        "ic_flight_on": "solid", "ic_flight_vx": 1, "contacts": "floor", "contact_floor_secondary": "bottom",
        "contact_floor_primary": "plane", "contact_floor_friction": 0.3, "contact_floor_method": "gpts", "contact_floor_enforce": "penalty", "ts_max_time": 0.4,
        "measures": "way", "measure_way_on": "solid", "measure_way_fields": "u", "measure_way_of": "mean", **steps})
    check(f"{scheme}: a block stops after v^2/(2 mu g)", r["measure_way_ux"][-1], 1 / 6, 0.02)
    late = r["measure_way_ux"][r["time"] > 1 / 3 + 0.03]
    check(f"{scheme}: and stays", numpy.ptp(late) * 6, 0, 1e-2, relative=False)

print("a rod eats its way into a block, and shorter steps do not let it through")
with open("rod.geo", "w") as file:
    file.write("""// A rod above a block, half their section, x = R, y = Z.
For k In {0 : 1}
  w = k == 0 ? 3 : 20; z = k == 0 ? 0.01 : -20; h = 20;
  Point(4 * k + 1) = {0, z, 0};
  Point(4 * k + 2) = {w, z, 0};
  Point(4 * k + 3) = {w, z + h, 0};
  Point(4 * k + 4) = {0, z + h, 0};
  For i In {1 : 4}
    Line(4 * k + i) = {4 * k + i, 4 * k + 1 + (i % 4)};
  EndFor
  Curve Loop(k + 1) = {4 * k + 1 : 4 * k + 4};
  Plane Surface(k + 1) = {k + 1};
EndFor
Transfinite Curve {1, 3} = 7;
Transfinite Curve {2, 4} = 41;
Transfinite Curve {5} = 36 Using Progression 1.025;
Transfinite Curve {-7} = 36 Using Progression 1.025;
Transfinite Curve {6, 8} = 31;
Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("rod") = {1};
Physical Surface("block") = {2};
Physical Curve("rod_skin") = {1, 2, 3};
Physical Curve("block_skin") = {7};
Physical Curve("axis") = {4, 8};
Physical Curve("bottom") = {5};
""")
METAL = {"model": "j2", "nu": 0.3, "erosion": "on", "erosion_points": 0.25, "erosion_step": 0.1, "erosion_strain": 1.5}
ROD = {"units": "mm_t_s_MPa", "plane": "axisymmetric", "mesh": "rod.geo", "materials": "rod,block",
       **material("rod", **{**METAL, "E": 400e3, "rho": 17.6e-9, "sigma_y": 1200}), **material("block", **{**METAL, "E": 200e3, "rho": 7.85e-9, "sigma_y": 1000}),
       "bcs": "axis,bottom", "bc_axis_on": "axis", "bc_axis_ux": 0, "bc_bottom_on": "bottom", "bc_bottom_type": "fix", "ics": "flight", "ic_flight_on": "rod",
       "ic_flight_vy": -1.5e6, "contacts": "hit", "contact_hit_secondary": "rod_skin", "contact_hit_primary": "block_skin", **EXPLICIT, "ts_dt": "auto",
       "ts_bulk_viscosity_linear": 0.06, "ts_bulk_viscosity_quadratic": 1.2, "ts_max_time": 10e-6}
default = run("rod", ROD)
check("first law, energies of springs that last booked as such", largest(default["balance_first_law"]), 0, 0.02, relative=False)
for cfl in (0.3, 0.15) if long() else ():
    r = run("rod_slow", {**ROD, "ts_dt_cfl": cfl})
    check(f"first law, steps of {cfl}", largest(r["balance_first_law"]), 0, 0.02, relative=False)
    check(f"impulse on the rod after 10 us, steps of {cfl} of the stable one, over that of 0.8", r["impulse_hit_y"][-1] / default["impulse_hit_y"][-1], 1, 0.1)

print("a rigid ball breaks its way through a plate: one so heavy that nothing stops it as one that is told its way")
BALL = {"units": "mm_t_s_MPa", "plane": "axisymmetric", "mesh": mesh("block.geo"), "mesh_set_lx": 20, "mesh_set_ly": 2, "mesh_set_n": 40, "mesh_set_ny": 4,
        "materials": "solid", **material("solid", **{**METAL, "E": 70e3, "rho": 2.7e-9, "sigma_y": 300, "erosion_strain": 0.8}), "bcs": "axis,rim", "bc_axis_on": "left",
        "bc_axis_ux": 0, "bc_rim_on": "right", "bc_rim_type": "fix", "contacts": "hit", "contact_hit_secondary": "top", "contact_hit_primary": "rigid_sphere",
        "contact_hit_radius": 5, "contact_hit_centre": "0,7", **EXPLICIT, "ts_dt": "auto", "ts_bulk_viscosity_linear": 0.06, "ts_bulk_viscosity_quadratic": 1.2,
        "ts_max_time": 12e-6}
told = run("told", {**BALL, "contact_hit_rigid_uy": "(-3e5*t)"})
heavy = run("heavy", {**BALL, "contact_hit_rigid_mass": 1e3, "ics": "flight", "ic_flight_on": "obstacle_hit", "ic_flight_vy": -3e5})
require(f"cells leave: {told['eroded_cells'][-1]:.0f}", told["eroded_cells"][-1] > 10)
check("impulse on the plate, over that of the ball that is told its way", heavy["impulse_hit_y"][-1] / told["impulse_hit_y"][-1], 1, 1e-6)

print("triangles and tetrahedra that share their volumes: what is left of a patch goes on from the ratio that it had")
for dim, n in (2, 16), (3, 5):
    name, ice = f"hail{dim}", material("solid", **{**METAL, "E": 9e3, "nu": 0.33, "rho": 9e-10, "sigma_y": 10, "erosion_strain": 0.3})
    hail = {"units": "mm_t_s_MPa", "mesh": mesh("block.geo"), "mesh_set_dim": dim, "mesh_set_simplex": 1, "mesh_set_lx": n, "mesh_set_ly": n, "mesh_set_lz": n,
            "mesh_set_n": n, "materials": "solid", **ice, "contacts": "hit", "contact_hit_secondary": "bottom", "contact_hit_primary": "plane", "ics": "flight",
            "ic_flight_on": "solid", "ic_flight_vy": -6e4, **EXPLICIT, "ts_dt": "auto", "ts_max_time": 3e-5}
    r = run(name, hail)
    require(f"{name}: cells leave: {r['eroded_cells'][-1]:.0f}", r["eroded_cells"][-1] > 10)
    check_between(f"{name}: energy that goes with cells, the least over that of the start", r["dissipated_erosion"].min() / r["energy_kinetic"][0], 0, 1)
    check(f"{name}: first law", largest(r["balance_first_law"]), 0, 0.01, relative=False)
    if dim == 3 and not long():
        continue
    half_of = int(numpy.searchsorted(r["eroded_cells"], r["eroded_cells"][-1] / 2)) + 1
    run(f"{name}_again", {**hail, "ts_max_steps": half_of})
    run(f"{name}_again", {**hail, "restart": "auto"})
    require(f"{name}: restart among them is bitwise", filecmp.cmp(f"{name}/history.csv", f"{name}_again/history.csv", shallow=False))
    run(f"{name}_moved", {**hail, "ts_max_steps": half_of}, ranks=2)
    moved = run(f"{name}_moved", {**hail, "restart": "auto"})
    worst, where = difference(r.history, moved.history)
    check(f"{name}: from two ranks to one, in {where}", worst, 0, 1e-7, relative=False)

print("when no cell is left steps stay as long as they were")
r = run("all", {**hail, "mesh_set_n": 2, "mesh_set_simplex": 0, "material_solid_erosion_strain": 1e-3, "ts_max_time": 2e-4})
require(f"all cells leave: {r['eroded_cells'][-1]:.0f}", r["eroded_cells"][-1] == 8)
check("the time at the end", r["time"][-1], 2e-4, 0.05)

print("a plate that spins loses cells, whose mass stays at its nodes")
spin = run("spin", {**material("solid", model="j2", sigma_y=1e3, erosion="on", erosion_strain=0.01, erosion_points=0.25), "materials": "solid",
                    "mesh": mesh("block.geo"), "mesh_set_n": 8, "mesh_set_ly": 0.4, "mesh_set_ny": 3, "ics": "v", "ic_v_on": "solid",
                    "ic_v_vx": "(-30*y)", "ic_v_vy": "30*x", **EXPLICIT, "ts_max_time": 0.05})
require(f"{spin['eroded_cells'][-1]:.0f} cells leave", spin["eroded_cells"][-1] > 3)
check("angular momentum", largest(spin["spin_solid_z"] / spin["spin_solid_z"][0] - 1), 0, 1e-9, relative=False)

print("what it cannot do is refused")
FLOOR = {"contacts": "floor", "contact_floor_secondary": "bottom", "contact_floor_primary": "plane"}
for more, words in some((({"ts_type": "static", "ts_dt": 1e-3}, ["-material_middle_erosion", "newmark"]),
                    ({"material_middle_erosion": "off", "options_strict": "on"}, ["-material_middle_erosion_stretch", "without effect"]),
                    ({"material_middle_erosion_strain": 0.5}, ["-material_middle_erosion_strain", "j2"]),
                    ({"material_middle_erosion_failure": "on"}, ["-material_middle_erosion_failure", "jc_failure"]),
                    ({**FLOOR, "contact_floor_enforce": "impulse"}, ["-contact_floor_enforce", "penalty"]),
                    ({**SCHEMES["implicit"], "material_middle_erosion_mass": "remove"}, ["-material_middle_erosion_mass", "keep"]),
                    ({"material_middle_erosion": "off", "material_middle_erosion_stretch": "none", "material_middle_erosion_mass": "remove",
                      "options_strict": "on"}, ["-material_middle_erosion_mass", "without effect"]),
                    ({**SCHEMES["implicit"], **FLOOR}, ["-contact_floor_method", "gpts"]),
                    ({**SCHEMES["implicit"], **FLOOR, "contact_floor_method": "gpts"}, ["-contact_floor_enforce", "penalty"])), 3):
    refused = run("refused", {**PULL, **EXPLICIT, **WEAK, **more}, code=2)
    said = [line for line in refused.log.splitlines() if line.startswith("impact: ")]
    require(f"{more}: {said[-1:]}", bool(said) and all(re.search(re.escape(word), said[-1]) for word in words))
finish()
