# labels: run
# timeout: 240
# long: 300
"""Cells of second order in whole runs: they do not lock, follow curved boundaries, keep the bounds of damage and energies of
explicit steps, and are the same on two ranks and from a checkpoint."""
import numpy
import _runs as runs
from _cook import cook
from _fields import pressure_jump
from _whole import check_whole
from fields import Fields

STATIC = {"ts_type": "static", "units": "mm_t_s_MPa"}
BLOCK = {"mesh": runs.mesh("block.geo"), "mesh_set_simplex": 1, "order": 2, "materials": "solid"}


def soft(name, n, order, depth=0, simplices=1):
    return cook(name, n, depth=depth, simplices=simplices, refused=6, order=order, material_solid_locking="none")


runs.check("Cook, 16 x 16 Quad9, corner", soft("cook_quad9", 16, 2, simplices=0)["probe_p_uy"][-1], 6.93, 0.026)
runs.check("Cook, 16 x 16 x 2 Tri6, corner", soft("cook_tri6", 16, 2)["probe_p_uy"][-1], 6.93, 0.012)
if runs.long():
    runs.check("Cook, slab of Tet10, corner", soft("cook_tet10", 12, 2, 3)["probe_p_uy"][-1], 6.93, 0.016)
cured = cook("cook_quad9_cured", 4, simplices=0, order=2)
runs.check("Cook, 4 x 4 Quad9 with their cure, which is the default, corner", cured["probe_p_uy"][-1], 6.93, 0.009)
runs.require("which is said", "locking cure of its biquadratic quadrilaterals: volume linear in a cell" in cured.log)
runs.check("Cook, 8 x 8 Quad8, corner", cook("cook_quad8_cured", 8, simplices=0, order=2, mesh_serendipity="on")["probe_p_uy"][-1], 6.93, 0.018)
runs.check("Cook, slab of 4 x 4 Hex27, corner", cook("cook_hex27_cured", 4, depth=12, simplices=0, order=2)["probe_p_uy"][-1], 6.93, 0.009)
if runs.long():
    FLOWS = {"material_solid_E": 200e3, "material_solid_nu": 0.3, "material_solid_model": "j2", "material_solid_sigma_y": 300, "material_solid_hardening": "linear",
             "material_solid_linear_h": 1000}
    many = 32 if runs.long() else 16
    coarse, fine = (cook(f"cook_flows_{n}", n, 8e3, FLOWS, simplices=0, order=2) for n in (8, many))
    runs.check(f"Cook that flows, 8 x 8 Quad9 against {many} x {many}", coarse["probe_p_uy"][-1], fine["probe_p_uy"][-1], 0.02)
linear = soft("cook_tri3", 16, 1)
runs.check_between("Cook, Tri6: no chessboard in the pressure", pressure_jump("cook_tri6"), 0, 0.25)
runs.check_between("as linear triangles have it", pressure_jump("cook_tri3"), 1, 10)
runs.check_between("Cook, linear triangles lock", linear["probe_p_uy"][-1], 0.5, 5)
runs.require("and the remedy is said", " lock, " in linear.log and "-order 2" in linear.log)

# A cantilever ten times as long as high, one row of tetrahedra over its height, beside Timoshenko's beam.
BEAM = {**BLOCK, **STATIC, "mesh_set_dim": 3, "mesh_set_lx": 10, "mesh_set_n": 10, "mesh_set_ny": 1, "mesh_set_nz": 1,
        "material_solid_E": 1000, "material_solid_nu": 0.3, "bcs": "hold,push", "bc_hold_on": "left", "bc_hold_type": "fix",
        "bc_push_on": "right", "bc_push_uy": "1e-4*t", "bc_push_type": "traction", "ts_dt": 1, "ts_max_time": 1, "probes": "p",
        "probe_p_at": "10,0.5,0.5", "probe_p_fields": "u"}
timoshenko = 1e-4 * (10 ** 3 / 3 / (1000 / 12) + 10 / (5 / 6 * 1000 / 2.6))
runs.check("cantilever of Tet10", runs.run("beam_tet10", BEAM)["probe_p_uy"][-1], timoshenko, 0.015)
for name, serendipity, most in runs.some((("Hex27", 0, 0.015), ("Hex20", 1, 0.021)), 2):
    runs.check(f"cantilever of {name}", runs.run(f"beam_{name}", {**BEAM, "mesh_set_simplex": 0, "mesh_serendipity": serendipity})[
        "probe_p_uy"][-1], timoshenko, most)
runs.check_between("cantilever of Tet4, over Timoshenko's", runs.run("beam_tet4", {**BEAM, "order": 1})["probe_p_uy"][-1]
                   / timoshenko, 0.3, 0.5)

# Triangles that gmsh leaves beside quadrilaterals: a body whose outside moves evenly is strained evenly.
with open("mixed.geo", "w") as file:
    file.write("""Point(1) = {0, 0, 0, 0.2}; Point(2) = {1, 0, 0, 0.2}; Point(3) = {1.3, 1, 0, 0.2}; Point(4) = {0, 1.2, 0, 0.1};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1 : 4}; Plane Surface(1) = {1};
Recombine Surface{1}; Mesh.RecombinationAlgorithm = 0; Physical Surface("solid") = {1}; Physical Curve("outside") = {1 : 4};
""")
even = runs.run("mixed", {**STATIC, "mesh": "mixed.geo", "order": 2, "materials": "solid", "material_solid_E": 1000, "material_solid_nu": 0.3, "ts_dt": 1,
                          "ts_max_time": 1, "bcs": "even", "bc_even_on": "outside", "bc_even_ux": "0.02*x+0.01*y", "bc_even_uy": "-0.03*x+0.01*y",
                          "probes": "a,b,c,d", "probe_a_at": "0.3,0.3", "probe_b_at": "0.8,0.4", "probe_c_at": "0.4,0.9", "probe_d_at": "1.1,0.9",
                          **{f"probe_{k}_fields": "u,stress" for k in "abcd"}})
stress = [even[f"probe_{k}_stress_{ij}"][-1] for ij in ("xx", "yy", "xy") for k in "abcd"]
for j in range(3):
    runs.check("mixed cells: the same stress everywhere", max(stress[4 * j:4 * j + 4]) - min(stress[4 * j:4 * j + 4]), 0, 1e-9, relative=False)
runs.check("mixed cells: displacement inside", even["probe_d_ux"][-1], 0.02 * 1.1 + 0.01 * 0.9, 1e-10)

# A tube of radii 1 and 2 under inner pressure (Lame), a quarter of it: curved edges and the pressure on them. Plane strain,
# strains of 1e-7. gmsh bends sides on the boundary alone: the cubic term of a quadrilateral's map there is of the size of
# h^2, which costs half an order; the map of a triangle has none.
TUBE = """Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {2, 0, 0}; Point(4) = {0, 2, 0}; Point(5) = {0, 1, 0};
Line(1) = {2, 3}; Circle(2) = {3, 1, 4}; Line(3) = {4, 5}; Circle(4) = {5, 1, 2};
Curve Loop(1) = {1 : 4}; Plane Surface(1) = {1}; DefineConstant[ n = 1 ];
Transfinite Curve {1, 3} = 3 * n + 1; Transfinite Curve {2, 4} = 5 * n + 1; Transfinite Surface {1};
DefineConstant[ boxes = 0 ]; If (boxes) Recombine Surface {1}; EndIf
Physical Surface("tube") = {1}; Physical Curve("bore") = {4}; Physical Curve("foot") = {1}; Physical Curve("side") = {3};
"""
with open("tube.geo", "w") as file:
    file.write(TUBE)
E, NU, P = 1000.0, 0.3, 1e-4
reference = (1 + NU) / E * P / 3 * ((1 - 2 * NU) + 4)  # u_r at the bore: (1 + nu)/E p a^2/(b^2 - a^2) ((1 - 2 nu) a + b^2/a)


def widened(order, n, boxes=0):
    tube = runs.run(f"tube_{order}_{n}_{boxes}", {
        **STATIC, "mesh": "tube.geo", "mesh_set_n": n, "mesh_set_boxes": boxes, "order": order, "materials": "tube", "material_tube_E": E,
        "material_tube_nu": NU, "bcs": "press,foot,side", "bc_press_on": "bore", "bc_press_type": "pressure",
        "bc_press_value": P, "bc_foot_on": "foot", "bc_foot_uy": 0, "bc_side_on": "side", "bc_side_ux": 0, "ts_dt": 1,
        "ts_max_time": 1, "probes": "bore", "probe_bore_at": "1,0", "probe_bore_fields": "u"})
    return tube["probe_bore_ux"][-1] / reference - 1


for cells, boxes, order in ("quadrilaterals", 1, (5.5, 12)), ("triangles", 0, (6, 12)):
    errors = [widened(2, n, boxes) for n in ((1, 2, 4) if runs.long() else (1, 2))]
    runs.check_between(f"Lame's tube, {cells}, error at the bore", abs(errors[1]), 0, 5e-4)
    for coarse, fine in zip(errors, errors[1:]):
        runs.check_between(f"Lame's tube, {cells}, error over that of cells half as large", coarse / fine, *order)
runs.check_between("Lame's tube, that of linear triangles of half the size", widened(1, 4) / errors[1], 8, 20)

# What is quadratic in space is exact between the nodes too; files name the cells.
for dim, name, kind in runs.some(((3, "Tetrahedron_10", {}), (2, "Triangle_6", {}), (2, "Quadrilateral_9", {"mesh_set_simplex": 0}),
                                  (3, "Hexahedron_27", {"mesh_set_simplex": 0}),
                                  (3, "Hexahedron_20", {"mesh_set_simplex": 0, "mesh_serendipity": 1}),
                                  (2, "Quadrilateral_8", {"mesh_set_simplex": 0, "mesh_serendipity": 1})), 2):
    u = {"bc_every_ux": "1e-3*x*y*t", "bc_every_uy": "1e-3*(y*y-x)*t", **({"bc_every_uz": "1e-3*x*z*t"} if dim == 3 else {})}
    moved = runs.run(f"moved_{name}", {
        **BLOCK, **STATIC, **kind, "mesh_set_dim": dim, "mesh_set_n": 2, "material_solid_E": 1000, "material_solid_nu": 0.3, "bcs": "every",
        "bc_every_on": "solid", **u, "ts_dt": 1, "ts_max_time": 1, "probes": "p", "probe_p_at": "0.37,0.61,0.23"[:9 if dim == 2 else 14],
        "probe_p_fields": "u", "outputs": "vis", "output_vis_fields": "u"})
    runs.check(f"{name}: a quadratic field at a probe", moved["probe_p_ux"][-1], 1e-3 * 0.37 * 0.61, 1e-12)
    runs.require(f"cells of {name} in the output", f'"{name}"' in open(f"moved_{name}/vis.xdmf").read())
    fields = Fields(f"moved_{name}/vis.xdmf")
    x, (u, at_nodes) = fields.places(fields.grids[-1]), fields.field(fields.grids[-1], "u")
    runs.check(f"{name}: nodal values of the output", abs(u[:, 0] - 1e-3 * x[:, 0] * x[:, 1]).max(), 0, 1e-15, relative=False)
    ((_, corners, cells),) = fields.cells(fields.grids[-1])
    sides = abs(x[corners[:, 1]] - x[corners[:, 0]]).max(axis=1)  # of the linear cells that tools see
    runs.check_between(f"{name}: longest side that tools see, in cells", 2 * sides.max(), 0.2,
                       1.01 if name in ("Hexahedron_20", "Quadrilateral_8") else 0.9 if name == "Tetrahedron_10" else 0.51)

# A bar is pulled until it breaks where its toughness is least: damage keeps its bounds at every node.
TEAR = {**BLOCK, **STATIC, "mesh_set_n": 12, "mesh_set_ly": 0.25, "mesh_set_ny": 3, "material_solid_E": 1000,
        "material_solid_nu": 0.3, "material_solid_damage": "at2", "material_solid_Gc": 0.1, "material_solid_gamma": 0.1,
        "bcs": "hold,pull,whole", "bc_hold_on": "left", "bc_hold_ux": 0, "bc_pull_on": "right", "bc_pull_ux": "0.03*t",
        "bc_whole_on": "origin", "bc_whole_uy": 0, "ics": "seed", "ic_seed_on": "solid",
        "ic_seed_phi": "0.3*exp(-((x-0.5)/0.1)^2)", "ts_dt": 0.05, "ts_max_time": 1, "outputs": "vis", "output_vis_every": 1,
        "output_vis_fields": "u,phi"}
torn = runs.run("torn", TEAR, refused=3)
fields = Fields("torn/vis.xdmf")
phi = numpy.array([fields.field(grid, "phi")[0][:, 0] for grid in fields.grids])
runs.check_between("the bar is broken", phi[-1].max(), 0.95, 1)
runs.check_between("phi never falls at a node", numpy.diff(phi, axis=0).min(), -1e-9, 1)
runs.check_between("phi is never below 0", phi.min(), -1e-9, 1)

# Explicit steps: a free block that turns keeps energy, momentum and its spin; the mass at the nodes is the whole mass.
SPIN = {**BLOCK, "material_solid_E": 1000, "material_solid_nu": 0.3, "material_solid_rho": 1, "ics": "go", "ic_go_on": "solid",
        "ic_go_vx": "2-y", "ic_go_vy": "x", "ts_type": "central_difference", "ts_max_time": 0.5}
for cells, dim, n, kind in runs.some((("Tet10", 3, 2, {}), ("Tri6", 2, 4, {}), ("Quad9", 2, 4, {"mesh_set_simplex": 0}),
                                      ("Hex27", 3, 2, {"mesh_set_simplex": 0}),
                                      ("Hex20", 3, 2, {"mesh_set_simplex": 0, "mesh_serendipity": 1})), 2):
    spin = runs.run(f"spin_{cells}", {**SPIN, "mesh_set_dim": dim, "mesh_set_n": n, **kind})
    total = spin["energy_kinetic"] + spin["energy_elastic"]
    runs.check_between(f"explicit, {cells}: drift of the energy of a body that spins", abs(total / total[0] - 1).max(), 0, 1e-6)
    runs.check(f"explicit, {cells}: momentum", spin["momentum_solid_x"][-1], spin["momentum_solid_x"][0], 1e-11)
    runs.check(f"explicit, {cells}: momentum is that of the mass", spin["momentum_solid_x"][0], 1.5, 1e-11)

if runs.long():
    check_whole({2: 4, 3: 2}, (2,), order=2)
check_whole({2: 3, 3: 2} if runs.long() else {2: 3}, (2,), kind="boxes_", order=2, mesh_set_simplex=0)

# What these cells cannot do is refused before the first step.
BODY = {**BLOCK, **STATIC, "material_solid_E": 1000, "material_solid_nu": 0.3, "material_solid_rho": 1e-9, "bcs": "hold",
        "bc_hold_on": "left", "bc_hold_type": "fix", "ts_dt": 1, "ts_max_time": 1}
for name, more, words in (
        ("erosion", {"ts_type": "newmark", "material_solid_erosion": "on", "material_solid_damage": "at2",
                     "material_solid_Gc": 1, "material_solid_gamma": 1}, ("-material_solid_erosion", "central_difference")),
        ("refined", {"dm_refine": 1}, ("-dm_refine", "-order 1"))):
    for ranks in (1, 2) if runs.long() else (2,):
        log = runs.run(f"refused_{name}_{ranks}", {**BODY, **more}, ranks=ranks, code=3).log
        runs.require(f"{name} is refused on {ranks} ranks", all(word in log for word in words))
runs.finish()
