# labels: run
# timeout: 180
# long: 200
"""Surfaces that overlap at the start (-contact_<id>_initial): refused with the depth and the place, left as they are, or
moved apart without stress, flat and round, in the plane and in space, by names and under one name; a restart on other
ranks goes on with the moved mesh; overlap of rounding size is none."""
import re
import shutil

import numpy
from _runs import check, finish, long, mesh, option_file, read_history, require, run

DEPTH = 1e-4
BLOCKS = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_inset": 0.1, "mesh_set_gap": -DEPTH,
    "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3, "material_upper_like": "lower",
    "bcs": "hold,push", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix",
    "bc_push_on": "upper_top", "bc_push_ux": 0, "bc_push_uy": "-1e-3*t",
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "contact_face_method": "mortar", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1,
}
ADJUST = {**BLOCKS, "contact_face_initial": "adjust"}
MOVED = re.compile(r"contact (\w+): (\d+) nodes of `(\w+)` overlapped `(\w+)` and were moved out, by up to ([0-9.e-]+);")


def moved(r):
    return [(contact, int(nodes), float(way)) for contact, nodes, _, _, way in MOVED.findall(r.log)]


def free_of_stress(claim, r, contact="face", facet=0.25):
    check(f"{claim}: elastic energy at the start", r["energy_elastic"][0], 0, 0, relative=False)
    gap = r[f"contact_{contact}_gap_min"][0]
    check(f"{claim}: gap at the start over the facet", 0 if numpy.isnan(gap) else min(gap, 0) / facet, 0, 1e-9, relative=False)


# What `allow` leaves presses in a static run and not with inertia, which is told; from the one the other goes on at rest.
FIT = {**BLOCKS, "mesh_set_gap": -1e-2, "mesh_set_inset": 0, "material_lower_nu": 0, "contact_face_initial": "allow", "material_lower_rho": 1000, "bc_push_uy": 0,
       "outputs": "hist", "output_hist_type": "csv"}
LEFT = "-contact_face_initial allow leaves it so"
fit = run("fit", FIT)
require("a static run presses what overlaps and says nothing", LEFT not in fit.log)
check("a static run presses what overlaps: energy of two bars, each shorter by half of it", fit["energy_elastic"][-1], 1e6 * 0.005**2, 0.02)
for enforce, effect in (("semismooth", "nothing presses there until they part"), ("penalty", "springs throw them apart")):
    free = run("free", {**FIT, "ts_type": "newmark", "ts_dt": 1e-3, "ts_max_steps": 1, "contact_face_enforce": enforce}, refused=None, code=None)
    require(f"with inertia it is told, {enforce}", LEFT in free.log and effect in free.log)
on = run("fit", {**FIT, "ts_type": "newmark", "ts_dt": 1e-3, "ts_max_time": 1.02, "restart": "auto", "restart_allow": "ts_type",
                 "output_hist_file": "on.csv"})
require("a run that goes on from statics says nothing", LEFT not in on.log)
check("it stays at rest: energy", read_history("fit/on.csv")["energy_elastic"][-1], fit["energy_elastic"][-1], 1e-9)

touching = run("touching", {**BLOCKS, "mesh_set_gap": 0})
adjusted = run("adjusted", ADJUST)
require("adjust: four nodes by the depth", moved(adjusted) == [("face", 4, DEPTH)])
free_of_stress("adjust", adjusted)
check("adjust: force as without overlap (the block is shorter by 1e-4)", adjusted["contact_face_force_y"][-1],
      touching["contact_face_force_y"][-1], 2e-4)
solid = run("solid", {**ADJUST, "mesh_set_dim": 3, "bc_push_uz": 0, "mesh_set_angle": 0})
require("in space: sixteen nodes by the depth", moved(solid) == [("face", 16, DEPTH)])
free_of_stress("in space", solid)

refused = run("refused", BLOCKS, code=3)
require("error: names depth and place", "`upper_bottom` overlaps `lower_top` by 0.0001 at (0.1, 0.9999)" in refused.log)
deep = run("deep", {**ADJUST, "contact_face_initial_tol": 0.9 * DEPTH}, code=3)
require("adjust: deeper than the tolerance is refused", "adjust with a larger _initial_tol (now 9e-05)" in deep.log)
allowed = run("allowed", {**BLOCKS, "contact_face_initial": "allow"})
require("allow: nothing moves", not moved(allowed))
check("allow: the overlap adds to the push", allowed["contact_face_force_y"][-1],
      (1 + DEPTH / 1e-3) * touching["contact_face_force_y"][-1], 2e-3)
rounding = run("rounding", {**BLOCKS, "mesh_set_gap": -1e-15, "mesh_set_angle": 37, "ts_max_steps": 1, "bcs": "hold,push",
                            "bc_push_uy": "-1e-3*t"})
require("overlap of rounding size is none", not moved(rounding))

# Round sides: the way out is along the other side's facets. Bodies in flight, so that what a stress would do shows.
# Their sides are polygons, 0.02 mm within the circles.
# Deeper than the pairs of the search reach: refused too, not passed over with no force.
for ranks in (1, 2) if long() else (2,):
    far = run(f"far_{ranks}", {**BLOCKS, "mesh_set_n_lower": 20, "mesh_set_n_upper": 20, "mesh_set_gap": -0.5}, ranks=ranks, code=3)
    require(f"an overlap of half a block is refused, {ranks} ranks", "inside the body of `lower_top`" in far.log)

# Facets that lie along the normal of a plane do not face it, and are inside it all the same.
ROD = {"mesh": mesh("block.geo"), "mesh_set_lx": 4, "mesh_set_n": 8, "mesh_set_ny": 2, "materials": "solid", "material_solid_E": 1, "material_solid_nu": 0,
       "bcs": "hold", "bc_hold_on": "right", "bc_hold_type": "fix", "contacts": "wall", "contact_wall_secondary": "top", "contact_wall_primary": "plane",
       "contact_wall_plane_point": "1.8,0", "contact_wall_plane_normal": "1,0", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
for order in (1, 2):
    for method in ("mortar", "gpts") if long() else ("mortar" if order == 1 else "gpts",):
        across = run(f"across_{order}_{method}", {**ROD, "order": order, "contact_wall_method": method}, code=3)
        require(f"a plane across a rod of order {order} is refused, {method}", "`top` overlaps `plane` by 1.8 at (0, 1)" in across.log)

DISCS = {"mesh_set_gap": -0.04, "contact_face_initial_tol": "0.05 mm", "mesh_set_offset": 3, "ts_max_time": "4 us", "output_vis_dt": 1,
         "contact_face_initial": "adjust",
         "checkpoint_every": 10, "motion_snes_rtol": 1e-12, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
         "motion_pc_factor_mat_solver_type": "mumps"}
discs = run("discs", DISCS, files=[option_file("discs.opts")])
(_, nodes, way), = moved(discs)
print(f"     discs: {nodes} nodes by up to {way:.3g} m")
require("discs: some nodes moved, at most by the overlap", nodes > 0 and 0 < way < 4e-5)
free_of_stress("discs", discs, facet=1e-3)
run("half", {**DISCS, "ts_max_time": "2 us"}, files=[option_file("discs.opts")])
shutil.copytree("half", "same")
same = run("same", {**DISCS, "restart": "auto"}, files=[option_file("discs.opts")])
check("restart on the same rank, before the discs touch: force", abs(same["contact_face_force_x"] - discs["contact_face_force_x"]).max(),
      0, 0, relative=False)
if long():
    resumed = run("half", {**DISCS, "restart": "auto"}, files=[option_file("discs.opts")], ranks=2)
    for column in ("energy_kinetic", "contact_face_force_x", "momentum_disc_y"):
        check(f"restart on two ranks: {column}", abs(resumed[column] - discs[column]).max() / abs(discs[column]).max(), 0, 1e-8,
              relative=False)

# Three contacts in a row, then one name for all of them.
PILE = {"ts_max_steps": 1, "output_vis_dt": 1, "mesh_set_gap": -DEPTH, **{f"contact_{c}_initial": "adjust" for c in ("floor", "first", "second")}}
pile = run("pile", PILE, files=[option_file("pile.opts")])
require("a pile: every contact moves its nodes by the overlap",
        [c for c, _, _ in moved(pile)] == ["floor", "first", "second"] and all(abs(w / DEPTH - 1) < 1e-3 for _, _, w in moved(pile)))
require("a pile: nothing presses before it falls", (pile["energy_elastic"][0] == 0))
lines = [line.replace("../meshes", option_file("../meshes")) for line in open(option_file("pile.opts"))
         if not line.startswith(("-contact_second", "-contacts"))]
with open("pile_one.opts", "w") as file:
    file.writelines(lines)
skin = {k: v for k, v in PILE.items() if k != "contact_second_initial"}
one = run("one", {**skin, "mesh_set_skin": 1, "contacts": "floor,first", "contact_floor_secondary": "skin",
                  "contact_first_secondary": "skin", "contact_first_primary": "skin"}, files=["pile_one.opts"])
require("a pile under one name: both contacts move nodes", [c for c, _, _ in moved(one)] == ["floor", "first"])

# Faces of second order touch by their curves: a pin that touches its hole overlaps nothing, one that stands 0.01 in it does by that.
with open("pin.geo", "w") as file:
    file.write("""SetFactory("OpenCASCADE"); DefineConstant[h = 2.5, deep = 0]; R = 10.1; e = 1e-3;
Box(1) = {-15, -15, 0, 30, 30, 3}; Cylinder(2) = {0, 0, -1, 0, 0, 5, R}; BooleanDifference(3) = {Volume{1}; Delete;}{Volume{2}; Delete;};
Cylinder(4) = {-0.1 - deep, 0, -1, 0, 0, 5, 10};
hole[] = Surface In BoundingBox{-R - e, -R - e, -e, R + e, R + e, 3 + e};
pin[] = Boundary{ Volume{4}; }; ends[] = Surface In BoundingBox{-12, -12, -1 - e, 12, 12, -1 + e}; ends[] += Surface In BoundingBox{-12, -12, 4 - e, 12, 12, 4 + e};
For i In {0:#pin[]-1}
  pin[i] = Abs(pin[i]);
EndFor
pin[] -= ends[];
Physical Volume("plate") = {3}; Physical Volume("pin") = {4}; Physical Surface("hole") = {hole[]}; Physical Surface("shank") = {pin[]};
Mesh.MeshSizeMin = h; Mesh.MeshSizeMax = h;
""")
PIN = {"mesh": "pin.geo", "order": 2, "materials": "plate,pin", "material_plate_E": 7e4, "material_plate_nu": 0.3, "material_pin_like": "plate", "bcs": "hold",
       "bc_hold_on": "plate,pin", "bc_hold_type": "fix", "contacts": "face", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1,
       "dry_run": "on"}
for secondary, primary in (("hole", "shank"), ("shank", "hole"))[: 2 if long() else 1]:
    pin = {**PIN, "contact_face_secondary": secondary, "contact_face_primary": primary}
    run("touches", pin)
    deep = run("deep", {**pin, "mesh_set_deep": 0.01}, code=3)
    depth = float(re.search(r"overlaps `\w+` by (\S+)", deep.log).group(1))
    check(f"a pin 0.01 in its hole, {secondary} secondary: depth", depth, 0.01, 0.1)
finish()
