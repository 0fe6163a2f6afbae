# labels: run
# timeout: 120
# long: 200
"""Numbers of a material that differ from place to place: a bar of two halves by expressions is that of two materials, in
implicit and explicit steps; Weibull's numbers have his mean and modulus, do not depend on ranks, a restart or the order of
the cells; a bar breaks where it is weakest, at that strength."""
import math
import os

import numpy

import _runs as runs
from _fields import Fields

BAR = """
For k In {0 : 1}
  Point(4 * k + 1) = {2 * k, 0, 0};
  Point(4 * k + 2) = {2 * k + 2, 0, 0};
  Point(4 * k + 3) = {2 * k + 2, 1, 0};
  Point(4 * k + 4) = {2 * k, 1, 0};
EndFor
Line(1) = {1, 2}; Line(2) = {2, 6}; Line(3) = {6, 7}; Line(4) = {7, 3}; Line(5) = {3, 4}; Line(6) = {4, 1}; Line(7) = {2, 3};
Curve Loop(1) = {1, 7, 5, 6}; Plane Surface(1) = {1};
Curve Loop(2) = {2, 3, 4, -7}; Plane Surface(2) = {2};
Transfinite Curve {1, 2, 4, 5} = 9;
Transfinite Curve {3, 6, 7} = 5;
Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("soft") = {1};
Physical Surface("stiff") = {2};
Physical Curve("left") = {6};
Physical Curve("right") = {3};
"""
with open("halves.geo", "w") as file:
    file.write(BAR)
E, GC, GAMMA = 1000.0, 1.0, 0.5
SHARED = {"units": "mm_t_s_MPa", "mesh": "halves.geo", "bcs": "clamp,pull", "bc_clamp_on": "left", "bc_clamp_type": "fix",
          "bc_pull_on": "right", "bc_pull_uy": 0, "coupling_snes_atol": 1e-8}
LAW = {"E": E, "nu": 0.2, "rho": 1e-9, "damage": "at2", "Gc": GC, "gamma": GAMMA}


def material(name, **more):
    return {f"material_{name}_{key}": value for key, value in {**LAW, **more}.items()}


ONE = {**SHARED, "materials": "bar", **material("bar", region="soft,stiff", E_factor="x<2 ? 0.25 : 1", Gc_factor="x<2 ? 2 : 0.5")}
TWO = {**SHARED, "materials": "soft,stiff", **material("soft", E=0.25 * E, Gc=2 * GC), **material("stiff", Gc=0.5 * GC)}
STATIC = {"ts_type": "static", "bc_pull_ux": "0.1*t", "ts_dt": 0.1, "ts_max_time": 0.5}
EXPLICIT = {"ts_type": "central_difference", "bc_pull_ux": "2e3*t", "ts_max_time": 1e-5, "outputs": "hist", "output_hist_type": "csv",
            "output_hist_every": 1}
for name, steps in (("static", STATIC), ("explicit", EXPLICIT)):
    one, two = (runs.run(f"{name}_{kind}", {**options, **steps}) for kind, options in (("one", ONE), ("two", TWO)))
    runs.require(f"{name}: as many steps", len(one["time"]) == len(two["time"]) > 5)
    for column in ("time", "phi_max", "energy_elastic", "energy_fracture", "reaction_pull_x"):
        runs.check(f"{name}: {column} of two halves is that of two materials", abs(one[column] - two[column]).max() / abs(two[column]).max(),
                   0, 1e-11, relative=False)
    runs.check_between(f"{name}: damage", one["phi_max"][-1], 1e-4, 1)

# A field of chance.
MODULUS, N = 8, 60
CHANCE = {"units": "mm_t_s_MPa", "ts_type": "static", "mesh": runs.mesh("block.geo"), "mesh_set_n": N, "materials": "solid", **material("solid"),
          "material_solid_E_weibull": MODULUS, "material_solid_Gc_weibull": MODULUS, "material_solid_weibull_seed": 3,
          "bcs": "hold", "bc_hold_on": "solid", "bc_hold_ux": "1e-3*t*x", "bc_hold_uy": 0, "ts_dt": 0.5, "ts_max_time": 1,
          "outputs": "vis", "output_vis_fields": "E,Gc"}


def numbers(run, name, by_place=True):
    """A field of the cells over the value of the material, in the order of their middles."""
    fields = Fields(os.path.join(run.dir, "vis.xdmf"))
    grid = fields.grids[-1]
    values = fields.field(grid, name)[0][:, 0] / {"E": E, "Gc": GC}[name]
    middles = numpy.concatenate([fields.places(grid)[cells].mean(axis=1) for _, cells, _ in fields.cells(grid)]).round(9)
    return values[numpy.lexsort(middles.T)], middles[numpy.lexsort(middles.T)]


def likeliest_modulus(x):
    """Of Weibull's distribution, by Newton's method on the equation of maximum likelihood."""
    k, logs = 1.0, numpy.log(x)
    for _ in range(100):
        power = x**k
        mean = (power * logs).sum() / power.sum()
        slope = (power * logs**2).sum() / power.sum() - mean**2 + 1 / k**2
        k -= (mean - 1 / k - logs.mean()) / slope
    return k


run = runs.run("chance", {**CHANCE, "checkpoint_every": 1})
both = []
for name in ("E", "Gc"):
    x, middles = numbers(run, name)
    both.append(x)
    mean, second = math.gamma(1 + 1 / MODULUS), math.gamma(1 + 2 / MODULUS)
    runs.check(f"{name}: mean over its standard error", (x.mean() - mean) / math.sqrt((second - mean**2) / len(x)), 0, 2.5, relative=False)
    runs.check(f"{name}: modulus over its standard error", (likeliest_modulus(x) / MODULUS - 1) / (0.78 / math.sqrt(len(x))), 0, 2.5,
               relative=False)
    square = x.reshape(N, N)
    for along, pairs in (("x", (square[:, 1:], square[:, :-1])), ("y", (square[1:], square[:-1]))):
        runs.check(f"{name}: neighbours along {along} do not know each other",
                   numpy.corrcoef(*(p.ravel() for p in pairs))[0, 1] * N, 0, 3, relative=False)
runs.check("E and Gc do not know each other", numpy.corrcoef(*both)[0, 1] * N, 0, 3, relative=False)
for name, more, ranks in (("two", {}, 2), ("three", {}, 3), ("again", {"restart": "chance/checkpoints/checkpoint_000001.h5"}, 1),
                          ("again_two", {"restart": "chance/checkpoints/checkpoint_000001.h5"}, 2))[:: 1 if runs.long() else 2]:
    other = runs.run(name, {**CHANCE, **more}, ranks=ranks)
    runs.require(f"{name}: the same numbers", all((numbers(other, field)[0] == x).all() for field, x in zip(("E", "Gc"), both)))
    for column in ("energy_elastic", "energy_fracture"):
        runs.check(f"{name}: {column}", other[column][-1], run[column][-1], 1e-10)
seed = runs.run("seed", {**CHANCE, "material_solid_weibull_seed": 4})
runs.check("another seed: another field", numpy.corrcoef(numbers(seed, "E")[0], both[0])[0, 1] * N, 0, 3, relative=False)
cubes, middles = numbers(runs.run("cubes", {**CHANCE, "material_solid_E_weibull": 2, "material_solid_weibull_length": 0.25}), "E")
of_cube = numpy.floor(middles[:, 0] / 0.25) + 4 * numpy.floor(middles[:, 1] / 0.25)
runs.require("cubes: one number in each, of three digits", all(len(set(cubes[of_cube == k])) == 1 for k in range(16)) and len(set(cubes)) > 13)

# A bar of twenty cubes of their own strength: its force is highest at the least one, and there it breaks.
STRENGTH, LENGTH = 3.0, 20.0
PULL = {"units": "mm_t_s_MPa", "ts_type": "static", "plane": "stress", "mesh": runs.mesh("block.geo"), "mesh_set_lx": LENGTH, "mesh_set_n": 100, "mesh_set_ny": 1,
        "materials": "solid", "material_solid_E": 30e3, "material_solid_nu": 0.0, "material_solid_damage": "wu", "material_solid_ge": "linear",
        "material_solid_Gc": 0.05, "material_solid_gamma": 0.4, "material_solid_strength": STRENGTH, "material_solid_strength_weibull": 6,
        "material_solid_weibull_length": 1, "bcs": "left,bottom,pull", "bc_left_on": "left", "bc_left_ux": 0, "bc_bottom_on": "bottom",
        "bc_bottom_uy": 0, "bc_pull_on": "right", "bc_pull_ux": "0.0022*t", "ts_dt": 0.01, "ts_max_time": 1,
        "outputs": "vis", "output_vis_fields": "phi,strength"}
run = runs.run("weakest", PULL, refused=None)
fields = Fields("weakest/vis.xdmf")
strength = fields.field(fields.grids[-1], "strength")[0][:, 0]
((_, cells, _),) = fields.cells(fields.grids[-1])
x = fields.places(fields.grids[-1])[:, 0]
weakest = math.floor(x[cells[strength.argmin()]].mean())
phi = fields.field(fields.grids[-1], "phi")[0][:, 0]
runs.check_between("weakest: of the strength of the bar", strength.min() / STRENGTH, 0.3, 0.95)
runs.check_between("weakest: where phi is largest, from the edge of its cube", x[phi.argmax()] - weakest, 0, 1)
force = run["reaction_pull_x"]
begins = (run["phi_max"] > 0).argmax()
runs.check_between("weakest: damage begins within a step of its strength", force[begins - 1] / strength.min(), 0.98, 1.0001)
runs.finish()
