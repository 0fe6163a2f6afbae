# labels: run
# timeout: 120
"""Static bodies that contact alone holds (src/theory.md (H1) to (H3)): a round body that touches a block in one point,
pressed by a dead traction in one step, against Hertz; a stack under gravity with friction; a body above a small gap; a disc that may roll; a body
that nothing holds is named. The hold stands in the matrix alone: forces balance to rounding, no work is missing."""
import math

from _held import CYLINDER, METHODS, SPHERE, STACK, cylinder, hertz_error, stack
from _runs import check, check_between, finish, long, mesh, require, run

for method, enforce in METHODS:
    for friction in (0, 0.3) if long() else (0.3,):
        name, what = f"cylinder_{method}_{enforce}_{friction}", f"cylinder, {method}, {enforce}, friction {friction}"
        r = cylinder(name, method, enforce, friction)
        check(f"{what}: force of the contact", r["contact_touch_force_y"][-1], 500, 1e-9)
        check_between(f"{what}: pressure over Hertz's", hertz_error(name), 0.96, 1.04)
        check_between(f"{what}: Newton iterations of the step", r["newton"][1], 1, 25)
        check(f"{what}: balance, no force but the contact's holds it", r["balance"][-1], 0, 1e-9, relative=False)
r = cylinder("two_ranks", "auto", "auto", ranks=2)
check("default form, two ranks: force", r["contact_touch_force_y"][-1], 500, 1e-9)
check_between("default form, two ranks: pressure over Hertz's", hertz_error("two_ranks"), 0.96, 1.04)
# In one step facets come to be covered in part while their nodes press: with other functions their forces are others.
r = run("sphere", {**SPHERE, "contact_touch_method": "mortar", "contact_touch_enforce": "penalty"})
check("sphere, penalty, one step: force of the contact over what the ground carries",
      r["contact_touch_force_y"][-1] / r["reaction_ground_y"][-1], 1, 1e-9)
for friction in (0, 0.3):
    r = stack(f"stack_{friction}", "mortar", "semismooth", friction)
    check(f"stack, friction {friction}: lower force over the weight", r["contact_lower_force_y"][-1] / 4.4145e-3, 1, 1e-9)
    check(f"stack, friction {friction}: upper force over the weight", r["contact_upper_force_y"][-1] / 1.962e-3, 1, 1e-9)
    check_between(f"stack, friction {friction}: Newton iterations of the step", r["newton"][1], 1, 25)
r = cylinder("gap", "auto", "auto", extra={"mesh_set_gap": 0.03})
check("above a gap: force", r["contact_touch_force_y"][-1], 500, 1e-9)
# Rigid blocks above gaps, on and below loose deformable ones: the hold stands in the rows of their unknowns.
FRAMES = (2, 0, "auto", 1), (2, 0.3, "penalty", 2), (3, 0.3, "auto", 1)
for place, (rigid, solid) in enumerate((((1,), (2,)), ((2,), (1,)), ((1, 2), ()))):
    own = {key: value for key, value in STACK.items() if not key.endswith("_like")}
    for b in rigid:
        own.update({f"material_b{b}_model": "rigid", f"material_b{b}_rho": "1000 kg/m^3"})
    for b in solid:
        own[f"material_b{b}_like"] = "b0"
    for dim, friction, enforce, ranks in FRAMES if long() else (FRAMES[place],):
        contact = {f"contact_{c}_{key}": value for c in ("lower", "upper")
                   for key, value in (("friction", friction), ("enforce", enforce))}
        name = f"rigid_{''.join(map(str, rigid))}_{dim}_{friction}"
        r = run(name, {**own, **contact, "mesh_set_gap": 0.05, "mesh_set_d3": dim - 2}, ranks=ranks)
        what = f"above gaps with rigid blocks {rigid} in {dim} dimensions, friction {friction}, {enforce}, {ranks} ranks"
        area = 10 if dim == 3 else 1
        check(f"{what}: lower force over the weight", r["contact_lower_force_y"][-1] / 4.4145e-3 / area, 1, 1e-6)
        if dim == 2 or solid:  # else pressures between two rigid faces hold each other, as large as they like
            check(f"{what}: upper force over the weight", r["contact_upper_force_y"][-1] / 1.962e-3 / area, 1, 1e-6)
        check_between(f"{what}: Newton iterations of the step", r["newton"][1], 1, 25)
# A rigid block of four faces whose edges lie on lines of the mesh below: nodes there are covered by rounding alone, or not at all.
with open("overhang.geo", "w") as out:
    out.write("""SetFactory("OpenCASCADE"); n = 12; e = 1e-4; gap = 0.02;
Box(1) = {0, 0, 0, 4, 4, 2}; Box(2) = {1, 1, 2 + gap, 2, 2, 1};
Transfinite Curve {1:12} = n + 1; Transfinite Curve {1, 3, 5, 7} = n / 2 + 1; Transfinite Curve {13:24} = 3;
Transfinite Surface {1:12}; Recombine Surface {1:12}; Transfinite Volume {1, 2};
Physical Volume("block") = {1}; Physical Volume("die") = {2};
s[] = Surface In BoundingBox {-e, -e, 2 - e, 4 + e, 4 + e, 2 + e}; Physical Surface("top") = {s[]};
s[] = Surface In BoundingBox {-e, -e, -e, 4 + e, 4 + e, e}; Physical Surface("bottom") = {s[]};
s[] = Surface In BoundingBox {1 - e, 1 - e, 2 + gap - e, 3 + e, 3 + e, 2 + gap + e}; Physical Surface("face") = {s[]};
s[] = Surface In BoundingBox {1 - e, 1 - e, 3 + gap - e, 3 + e, 3 + e, 3 + gap + e}; Physical Surface("back") = {s[]};
""")
r = run("overhang", {
    "units": "mm_t_s_MPa", "mesh": "overhang.geo", "materials": "block,die", "material_block_E": 1000, "material_block_nu": 0.3, "material_die_model": "rigid",
    "bcs": "ground,load", "bc_ground_on": "bottom", "bc_ground_type": "fix", "bc_load_on": "back", "bc_load_type": "force", "bc_load_uz": "(-10*t)",
    "contacts": "face", "contact_face_secondary": "top", "contact_face_primary": "face", "contact_face_friction": 0.3, "ts_type": "static", "ts_dt": 1,
    "ts_max_time": 1, "outputs": "hist", "output_hist_type": "csv"})
require("edges on lines of the other mesh: the gap at the start is that of the blocks", "contact face: smallest gap at the start 0.02, 0 points press" in r.log)
check("force of the contact over the load", -r["contact_face_force_z"][-1] / 10, 1, 1e-6)
check("closed area over that of the face", r["contact_face_length"][-1] / 4, 1, 5e-3)
r = run("under", {**STACK, "contact_lower_secondary": "top0", "contact_lower_primary": "bottom1"})
check_between("a secondary side that is longer than what lies on it: closed length over that of the other, whose ends rise", r["contact_lower_length"][-1] / 25, 0.9, 1)
r = run("lies", {
    **{key: value for key, value in CYLINDER.items() if not key.startswith("bc")}, "mesh": mesh("disc_on_plate.geo"),
    "material_block_region": "plate", "bcs": "ground,load", "bc_ground_on": "ground",
    "bc_ground_type": "fix", "bc_load_on": "load", "bc_load_type": "traction", "bc_load_uy": "(-300*t)",
    "contact_touch_primary": "plate_top", "ts_dt": 0.1})
check("a disc that may roll: force over the load", r["contact_touch_force_y"][-1] / (1000 * math.pi), 1, 5e-3)  # on chords
check("it is what the ground carries", r["reaction_ground_y"][-1], r["contact_touch_force_y"][-1], 1e-9)
check_between("Newton iterations of its first step", r["newton"][1], 1, 25)
# A strip that flows between a rough cylinder and its plane of symmetry is held lengthwise by friction alone. At Gauss points it took
# 579 steps, of which 79 were cut.
STRIP = {
    "units": "mm_t_s_MPa", "mesh": mesh("block.geo"), "mesh_set_lx": 16, "mesh_set_ly": 1, "mesh_set_n": 48, "mesh_set_ny": 3,
    "materials": "solid", "material_solid_model": "j2", "material_solid_E": 70e3, "material_solid_nu": 0.33, "material_solid_sigma_y": 100,
    "bcs": "middle", "bc_middle_on": "bottom", "bc_middle_uy": 0, "contacts": "roll", "contact_roll_secondary": "top",
    "contact_roll_primary": "rigid_cylinder", "contact_roll_centre": "14,21", "contact_roll_radius": 20, "contact_roll_friction": 0.15,
    "contact_roll_rigid_mass": 1e-3, "contact_roll_rigid_ux": 0, "contact_roll_rigid_uy": "(-0.2*ramp(t,0,1))",
    "contact_roll_rigid_rz": "0.35*ramp(t,1,2)", "ts_type": "static", "ts_dt": 0.02, "ts_max_time": 1.2}
if long():
    rolled = {method: run(f"strip_{method}", {**STRIP, "contact_roll_method": method}, refused=None) for method in ("gpts", "mortar")}
    check("a rolled strip: the force of both methods", rolled["gpts"]["contact_roll_force_y"][-1], rolled["mortar"]["contact_roll_force_y"][-1], 0.02)
    for method, r in rolled.items():
        check_between(f"a rolled strip, {method}: steps", len(r["time"]) - 1, 60, 150)
r = cylinder("away", "auto", "auto", extra={"bc_load_uy": "50*t"}, code=5)
require("a body that flies away is named", "the body of region disc" in r.log and "meets nothing that holds it" in r.log)
finish()
