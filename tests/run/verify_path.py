# labels: run
# timeout: 300
"""Static steps that follow a crack by what it dissipates (theory.md, 10, (P1)-(P3)): a cohesive bar through its snap-back against
the closed form, against displacement control where both exist; the first law over the path; restarts, ranks, refusals; the energy
release rate by the domain integral against that of a strip."""
import os

import numpy

import _runs as runs

E, STRENGTH, GC, GAMMA = 30e3, 3.0, 0.01, 2.5  # MPa, N/mm, mm: linear softening, w_c = 2 G_c/f_t
RELIEF, COARSE = 0.1 * STRENGTH, 32 if runs.long() else 16


def pulled(name, length, ranks=1, grows="t", per_gamma=COARSE, **more):
    """Half a bar that breaks at its held end, where a body force on a node behind the widest band takes a tenth of the load off. At
    s = 1 it bears its strength: s (stress at the held end) = N L/E + G_c/f_t (1 - N/f_t) over f_t L/E. Returns the run, s and N/f_t."""
    h = GAMMA / per_gamma
    behind = (numpy.ceil(numpy.pi / 2 * per_gamma) + 1) * h  # a node beyond the widest band
    pull = (STRENGTH * length - RELIEF * (length - behind)) / E
    run = runs.run(name, {
        "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_ly": 1, "mesh_set_n": round(length / h),
        "mesh_set_ny": 1, "mesh_set_lx": length, "materials": "solid", "material_solid_E": E, "material_solid_nu": 0,
        "material_solid_rho": 1e-9, "material_solid_damage": "wu", "material_solid_ge": "linear", "material_solid_strength": STRENGTH,
        "material_solid_Gc": GC, "material_solid_gamma": GAMMA, "material_solid_residual_stiffness": 0, "plane": "stress",
        "bcs": "x,y,pull,relief", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right",
        "bc_pull_ux": f"{pull}*{grows}", "bc_relief_on": "solid", "bc_relief_type": "body_force",
        "bc_relief_ux": f"(x>{behind - h / 2} && x<{behind + h / 2} ? {1e9 * RELIEF / h} : 0)*{grows}", "ts_type": "static", "coupling_snes_atol": 1e-5,
        **more}, ranks=ranks)
    load = run["load_parameter"] if "load_parameter" in run.history else run["time"]
    return run, load, -run["reaction_x_x"] / STRENGTH


def closed_form(s, length):
    """N/f_t of the softening branch."""
    brittle = GC * E / (STRENGTH**2 * length)
    return (s - brittle) / (1 - brittle)


LONG, PATH = 60.0, {"ts_path_dissipation": GC / 2 / 25, "ts_dt": 0.2, "ts_max_time": 5.6}
run, s, N = pulled("snap", LONG, per_gamma=32, **PATH)
peak = N.argmax()
runs.check("bar: load of the peak", s[peak], 1, 0.01)
soft = (numpy.arange(len(N)) > peak) & (N > 0.05)
runs.require(f"bar: {soft.sum()} steps down the softening branch, at most 60 in all", soft.sum() >= 15 and len(N) <= 61)
runs.check_between("bar: the load falls back to", s[soft].min(), 0, 0.62)
runs.check("bar: stress on the way back against the closed form", abs(N - closed_form(s, LONG))[soft].max(), 0, 0.01, relative=False)
runs.check("bar: first law over the path", abs(run["balance_first_law"]).max(), 0, 1e-3, relative=False)
grown = numpy.diff(run["energy_fracture"])[peak + 1:][soft[peak + 2:]]
runs.check("bar: energy that a step asks", abs(grown / PATH["ts_path_dissipation"] - 1).max(), 0, 1e-2, relative=False)

# On the way back: a restart, tries that are refused, two ranks. A checkpoint makes solvers forget what serves on.
BACK = 11
whole = pulled("whole", LONG, **{**PATH, "ts_max_time": 3.2, "checkpoint_every": BACK})[0]
for steps, restart in ((BACK, "none"), (16, "auto")):
    again = pulled("again", LONG, **{**PATH, "ts_max_time": 3.2}, ts_max_steps=steps, restart=restart)[0]
runs.require("bar: a restart in the snap-back changes no bit", len(again["time"]) == len(whole["time"]) == 17 and all(
    numpy.array_equal(whole[c], again[c], equal_nan=True) for c in whole.history))
for name, ranks, more, most in runs.some((("two", 2, {}, 1e-8), ("tried", 1, {"test_restep": 1}, 1e-8)), 2):
    other = pulled(name, LONG, ranks=ranks, **{**PATH, "ts_max_time": 3.2 if runs.long() else 2.6}, **more)[0]
    for column in ("load_parameter", "reaction_x_x", "energy_fracture"):
        runs.check(f"bar, {name}: {column} over its largest", abs(other[column] - whole[column][:len(other["time"])]).max() / abs(whole[column]).max(), 0,
                   most, relative=False)

# A load that grows otherwise than t is the same path; by t^2 passes took the load to and fro without end.
if runs.long():
    squared, root, N = pulled("squared", LONG, grows="t^2", **{**PATH, "ts_max_time": 3.2})
    runs.check("bar, by the square of t: iterations", squared["newton"].sum(), whole["newton"].sum(), 0.1)
    back = numpy.arange(len(N)) > N.argmax()
    runs.check("bar, by the square of t: stress on the way back against the closed form", abs(N - closed_form(root**2, LONG))[back].max(), 0, 0.01,
               relative=False)
    runs.require(f"bar, by the square of t: {back.sum()} steps back", back.sum() >= 8)

# Where nothing snaps back, displacement control knows the curve too.
if runs.long():
    SHORT = 20.0
    _, s, N = pulled("path", SHORT, ts_path_dissipation=GC / 2 / 25, ts_dt=0.1, ts_max_time=4)
    _, given, stress = pulled("given", SHORT, ts_dt=0.02, ts_max_time=1.6)
    between = (s > 0) & (s < 1.6)
    differ = abs(N[between] - numpy.interp(s[between], given, stress))
    runs.check("short bar: curve against displacement control, over the strength", differ.max(), 0, 1e-3, relative=False)

# The energy release rate of a slot in a clamped strip by rings of any size: what the strip ahead holds, E (u/H)^2/2 over its height.
RINGS = {"small": (0.1, 0.2), "middle": (0.2, 0.5), "wide": (0.4, 0.9)}
rings = {f"release_{name}_{key}": value for name, (inner, outer) in RINGS.items()
         for key, value in (("at", "3,0"), ("inner", inner), ("outer", outer))}
slot = runs.run("rings", {"mesh": runs.mesh("griffith_strip.geo"), "mesh_set_h": 0.02, "mesh_set_length": 6, "mesh_set_slot": 3, "materials": "strip", "material_strip_E": 70e3,
                          "material_strip_nu": 0, "bcs": "bottom,top", "bc_bottom_on": "bottom", "bc_bottom_ux": 0,
                          "bc_bottom_uy": "0 - 1e-4*t", "bc_top_on": "top", "bc_top_ux": 0, "bc_top_uy": "1e-4*t", "ts_type": "static",
                          "ts_dt": 1, "ts_max_time": 1, "releases": ",".join(RINGS), **rings})
for name in RINGS:
    runs.check(f"energy release rate by the {name} ring", slot[f"release_{name}"][-1], 2 * 70e3 * 1e-8 / 2, 0.01)
runs.check("energy release rate: small and wide ring", slot["release_small"][-1], slot["release_wide"][-1], 0.003)

# In space of a plate that its front crosses: the length of the front is the thickness, which the default does not know.
with open("plate.geo", "w") as file:
    file.write("""Point(1) = {0, -1, 0}; Point(2) = {2, -1, 0}; Point(3) = {4, -1, 0}; Point(4) = {4, 0, 0}; Point(5) = {2, 0, 0}; Point(6) = {0, -0.01, 0};
Point(7) = {0, 0.01, 0}; Point(8) = {4, 1, 0}; Point(9) = {2, 1, 0}; Point(10) = {0, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1}; Line(7) = {5, 2};
Line(8) = {7, 5}; Line(9) = {4, 8}; Line(10) = {8, 9}; Line(11) = {9, 10}; Line(12) = {10, 7}; Line(13) = {5, 9};
Curve Loop(1) = {1, -7, 5, 6}; Curve Loop(2) = {2, 3, 4, 7}; Curve Loop(3) = {8, 13, 11, 12}; Curve Loop(4) = {-4, 9, 10, -13};
For s In {1 : 4}
  Plane Surface(s) = {s};
EndFor
Transfinite Curve {1 : 13} = 15; Transfinite Surface {1 : 4}; Recombine Surface {1 : 4};
Extrude {0, 0, 0.3} { Surface {1 : 4}; Layers {3}; Recombine; }
Physical Volume("strip") = {1 : 4};
e = 1e-6;
Physical Surface("bottom") = Surface In BoundingBox {-1, -1-e, -1, 5, -1+e, 1}; Physical Surface("top") = Surface In BoundingBox {-1, 1-e, -1, 5, 1+e, 1};
""")
ball = {key: value for name, more in (("told", {"length": 0.3}), ("default", {}))
        for key, value in {f"release_{name}_at": "2,0,0", f"release_{name}_inner": 0.3, f"release_{name}_outer": 0.6,
                           **{f"release_{name}_{k}": v for k, v in more.items()}}.items()}
plate = runs.run("plate", {"mesh": "plate.geo", "materials": "strip", "material_strip_E": 70e3, "material_strip_nu": 0, "material_strip_model": "j2",
                           "material_strip_sigma_y": 1e9, "bcs": "bottom,top", "bc_bottom_on": "bottom", "bc_bottom_ux": 0,
                           "bc_bottom_uy": "0 - 1e-4*t", "bc_bottom_uz": 0, "bc_top_on": "top", "bc_top_ux": 0, "bc_top_uy": "1e-4*t", "bc_top_uz": 0,
                           "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "releases": "told,default", **ball})
runs.check("energy release rate of a plate in space", plate["release_told"][-1], 2 * 70e3 * 1e-8 / 2, 0.02)
runs.check("of the default length, over it", plate["release_default"][-1] / plate["release_told"][-1], 0.3 / 0.9, 1e-9)
runs.require("the default length is told to be too long, that which was given is not",
             "-release_default: " in plate.log and "-release_told: " not in plate.log)
runs.require("rates of a body that flows are told", "-releases: material strip flows" in plate.log)

# What has no load to find, or a time that means something, is refused.
BOX = {"mesh": runs.mesh("block.geo"), "materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3, "bcs": "pull",
       "bc_pull_on": "right", "bc_pull_ux": "t", "ts_type": "static", "ts_path_dissipation": 1, "ts_dt": 0.1, "ts_max_time": 1}
with open("rates.csv", "w") as file:
    file.write("at,factor\n0,1\n1,2\n")
CRACKS = {"material_solid_damage": "at2", "material_solid_Gc": 1, "material_solid_gamma": 0.5}
for name, more, word in runs.some((("elastic", {}, "is for motion and damage with -ts_type static"),
                         ("inertia", {**CRACKS, "ts_type": "newmark", "material_solid_rho": 1}, "is for motion and damage"),
                         ("heat", {**CRACKS, "material_solid_c_v": 1}, "knows no heat"),
                         ("rate", {**CRACKS, "material_solid_c": 1}, "has no time for rates to be of (-material_solid_c)"),
                         ("toughness", {**CRACKS, "material_solid_Gc_rate": "rates.csv", "material_solid_damage_gradient": "material"},
                          "(-material_solid_Gc_rate)"),
                         ("viscous", {**CRACKS, "material_solid_b_d": 1}, "(-material_solid_b_d)"),
                         ("flow", {**CRACKS, "material_solid_model": "j2", "material_solid_sigma_y": 1}, "-material_solid_model j2"),
                         ("single", {**CRACKS, "coupling_snes_max_it": 1}, "wants passes"),
                         ("bounds", {**CRACKS, "damage_bounds": "history"}, "-damage_bounds vi"),
                         ("touch", {**CRACKS, "contacts": "a", "contact_a_secondary": "left", "contact_a_primary": "rigid_plane",
                                    "contact_a_plane_point": "0,0", "contact_a_plane_normal": "1,0"}, "knows no contact")), 3):
    refused = runs.run(f"refused_{name}", {**BOX, **more}, code=2)
    said = next((line for line in refused.log.splitlines() if "ts_path_dissipation" in line), "nothing")
    runs.require(f"refused: {name}: {said[:110]}", word in said)
runs.finish()
