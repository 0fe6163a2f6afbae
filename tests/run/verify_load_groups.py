# labels: run
# timeout: 120
"""Loads on groups of a mesh: a body force acts on the cells of its regions alone, whatever lies beside them; what lies in two
groups of a condition is loaded once; lines are loaded alike after refinement. Supports that accelerate start with the initial
velocity. The history has the times that are asked of it and the row that ends a run."""
import numpy
from _runs import check, finish, require, run

with open("two.geo", "w") as file:  # two squares, two cubes in space, that share a side
    file.write("""DefineConstant[ n = 4, deep = 0, simplices = 0 ];
For i In {0:2}
  Point(2*i+1) = {i,0,0}; Point(2*i+2) = {i,1,0}; Line(i+1) = {2*i+1,2*i+2};
EndFor
For i In {0:1}
  Line(10+i) = {2*i+1,2*i+3}; Line(20+i) = {2*i+2,2*i+4};
  Curve Loop(i+1) = {10+i,i+2,-20-i,-i-1}; Plane Surface(i+1) = {i+1};
EndFor
Transfinite Curve{:} = n + 1;
Transfinite Surface{:};
If (simplices == 0)
  Recombine Surface{:};
EndIf
If (deep > 0)
  body[] = Extrude {0,0,1} { Surface{1,2}; Layers{n}; Recombine; };
  Physical Volume("a") = {body[1]}; Physical Volume("b") = {body[7]};
  Physical Surface("bottom") = {body[2],body[8]};
  Physical Curve("edge") = {20};
Else
  Physical Surface("a") = {1}; Physical Surface("b") = {2};
  Physical Curve("bottom") = {10,11}; Physical Curve("left") = {1};
  Physical Curve("right") = {3}; Physical Curve("outer") = {3,21};
EndIf
""")
G = 10.0
BASE = {"mesh": "two.geo", "materials": "a,b", "material_a_E": 1e9, "material_a_nu": 0.3, "material_a_rho": 1000,
        "material_b_like": "a", "material_b_rho": 1e4, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "motion_snes_rtol": 1e-13, "motion_snes_atol": 1e-9,
        "bcs": "hold,g", "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_g_type": "body_force", "bc_g_uy": f"(-{G})"}
MASS = {"a": 1000.0, "b": 1e4, "a,b": 1.1e4}

for on, mass in MASS.items():
    r = run(f"weight_{on.replace(',', '')}", {**BASE, "bc_g_on": on})
    check(f"weight of {on}", r["reaction_hold_y"][-1], mass * G, 1e-9)
for name, extra in {"curved": {"order": 2}, "triangles": {"mesh_set_simplices": 1}, "ring": {"plane": "axisymmetric"},
                    "deep": {"mesh_set_deep": 1, "mesh_set_n": 2}, "ranks": {}}.items():
    ring = numpy.pi if name == "ring" else 1  # the mean radius of a is 1/2
    r = run(f"weight_{name}", {**BASE, **extra, "bc_g_on": "a"}, ranks=2 if name == "ranks" else 1)
    check(f"weight of a, {name}", r["reaction_hold_y"][-1], ring * MASS["a"] * G, 1e-9)
r = run("twice", {**BASE, "bcs": "hold,g,h", "bc_g_on": "a", "bc_h_on": "b", "bc_h_type": "body_force", "bc_h_uy": f"(-{G})"})
check("one condition for each", r["reaction_hold_y"][-1], MASS["a,b"] * G, 1e-9)

for name, extra in {"newmark": {"ts_type": "newmark"}, "explicit": {"ts_type": "central_difference"}}.items():
    fall = {**{k: v for k, v in BASE.items() if not k.startswith("bc_hold")}, **extra, "bcs": "g", "ts_dt": 1e-5, "ts_max_time": 1e-3, "output_hist_type": "csv", "outputs": "hist", "output_hist_every": 1}
    r = run(f"fall_{name}", {**fall, "bc_g_on": "a,b"})
    check(f"{name}: all falls, momentum", r["momentum_a_y"][-1] + r["momentum_b_y"][-1], -MASS["a,b"] * G * 1e-3, 1e-9)
    check(f"{name}: nothing is strained, energy over the kinetic one", r["energy_elastic"][-1] / r["energy_kinetic"][-1], 0, 1e-12, relative=False)
    r = run(f"pull_{name}", {**fall, "bc_g_on": "a"})
    check(f"{name}: a is pulled, momentum", r["momentum_a_y"][-1] + r["momentum_b_y"][-1], -MASS["a"] * G * 1e-3, 1e-9)

LOAD = {**BASE, "bcs": "hold,l", "bc_hold_on": "bottom", "bc_l_on": "right,outer", "bc_l_type": "traction", "bc_l_ux": 1}
LOAD = {key: value for key, value in LOAD.items() if not key.startswith("bc_g_")}
for ranks in (1, 2):
    r = run(f"overlap_{ranks}", LOAD, ranks=ranks)
    check(f"a side in two groups, {ranks} ranks", -r["reaction_hold_x"][-1], 2, 1e-9)
SPACE = {**LOAD, "mesh_set_deep": 1, "mesh_set_n": 2, "bc_l_on": "edge", "bc_l_type": "force", "bc_l_ux": None, "bc_l_uy": "(-3)"}
SPACE = {key: value for key, value in SPACE.items() if value is not None}
plain = run("edge_plain", {**SPACE, "mesh_set_n": 4})
fine = run("edge_refined", {**SPACE, "dm_refine": 1})
check("force on a line of a refined mesh", fine["reaction_hold_y"][-1], 3, 1e-9)
check("its energy, of the same mesh made at once", fine["energy_elastic"][-1], plain["energy_elastic"][-1], 1e-9)

for name in ("newmark", "central_difference"):
    r = run(f"sled_{name}", {**{k: v for k, v in LOAD.items() if not k.startswith("bc_l")}, "bcs": "hold", "bc_hold_type": "acceleration",
                             "bc_hold_ux": "2000*t", "bc_hold_uy": 0, "ics": "v", "ic_v_on": "a,b", "ic_v_vx": 3, "ts_type": name,
                             "ts_dt": 1e-5, "ts_max_time": 1e-3, "probes": "p", "probe_p_at": "0.5,0", "probe_p_fields": "u,v"})
    check(f"{name}: velocity of a support that accelerates", r["probe_p_vx"][-1], 3 + 1000 * 1e-6, 1e-5)
    check("its way", r["probe_p_ux"][-1], 3e-3 + 2000 * 1e-9 / 6, 1e-6)

HISTORY = {**BASE, "bc_g_on": "a", "ts_dt": 0.1, "outputs": "hist", "output_hist_type": "csv"}
r = run("times", {**HISTORY, "output_hist_times": "0.12,0.3"})
require(f"rows at the times that are asked for: {r['time']}", numpy.allclose(r["time"], [0, 0.12, 0.3, 1], atol=1e-12))
r = run("stop", {**HISTORY, "output_hist_every": 5, "stops": "s", "stop_s_when": "time > 0.75"})
require(f"the row that ends a run: {r['time']}", numpy.allclose(r["time"], [0, 0.5, 0.8], atol=1e-12))
r = run("two_histories", {**HISTORY, "outputs": "hist,more", "output_more_type": "csv", "output_more_file": "more.csv"}, code=2)
require("two histories are refused", "there is one history" in r.log)
r = run("axis", {**LOAD, "plane": "axisymmetric", "bc_l_on": "left", "bc_l_type": "force"}, code=3)
require("a force on the axis is refused", "-bc_l_on: has no area" in r.log)
finish()
