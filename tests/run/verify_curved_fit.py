# labels: run
# timeout: 240
# long: 600
"""Curved facets of second order that press all over: a sleeve on a ring, in the plane and in space, by mortar and at Gauss points.
With a clearance far below what facets are curved by nothing presses; with an overlap the pressure is that of the closed form. The
long form takes all cells, both sides as the secondary one and both kinds of multipliers."""
from _runs import check, finish, long, require, run

INNER, FIT, OUTER, LENGTH = 5.0, 10.0, 20.0, 5.0
E, NU = 210e3, 0.3
with open("fit.geo", "w", encoding="ascii") as file:
    file.write(f"""DefineConstant[overlap = 0, n_ring = 7, n_sleeve = 5, simplices = 0, plane = 0];
Point(1000) = {{0, 0, 0}};
ends[] = {{}}; x0[] = {{}}; y0[] = {{}};
For body In {{0 : 1}}
  r = body == 0 ? {INNER} : {FIT} - overlap; R = body == 0 ? {FIT} : {OUTER}; k = 100 * body; n = body == 0 ? n_ring : n_sleeve;
  Point(k + 1) = {{r, 0, 0}}; Point(k + 2) = {{R, 0, 0}}; Point(k + 3) = {{0, R, 0}}; Point(k + 4) = {{0, r, 0}};
  Line(k + 1) = {{k + 1, k + 2}}; Circle(k + 2) = {{k + 2, 1000, k + 3}}; Line(k + 3) = {{k + 3, k + 4}}; Circle(k + 4) = {{k + 4, 1000, k + 1}};
  Curve Loop(k + 1) = {{k + 1 : k + 4}};
  Plane Surface(k + 1) = {{k + 1}};
  Transfinite Curve {{k + 2, k + 4}} = n + 1;
  Transfinite Curve {{k + 1, k + 3}} = 4 + body;
  Transfinite Surface {{k + 1}};
  If (simplices == 0)
    Recombine Surface {{k + 1}};
  EndIf
  If (plane == 1)
    o[] = {{k + 3, k + 1, k + 1, k + 2, k + 3, k + 4}};
  ElseIf (simplices == 0)
    o[] = Extrude {{0, 0, {LENGTH}}} {{ Surface{{k + 1}}; Layers{{2}}; Recombine; }};
  Else
    o[] = Extrude {{0, 0, {LENGTH}}} {{ Surface{{k + 1}}; Layers{{2}}; }};
  EndIf
  ends[] += k + 1; y0[] += o[2]; x0[] += o[4];
  If (plane == 1)
    If (body == 0)
      Physical Surface("ring") = {{o[1]}}; Physical Curve("skin") = {{o[3]}};
    Else
      Physical Surface("sleeve") = {{o[1]}}; Physical Curve("bore") = {{o[5]}};
    EndIf
  ElseIf (body == 0)
    Physical Volume("ring") = {{o[1]}}; Physical Surface("skin") = {{o[3]}};
  Else
    Physical Volume("sleeve") = {{o[1]}}; Physical Surface("bore") = {{o[5]}};
  EndIf
EndFor
If (plane == 1)
  Physical Curve("x0") = x0[]; Physical Curve("y0") = y0[];
Else
  Physical Surface("ends") = ends[]; Physical Surface("x0") = x0[]; Physical Surface("y0") = y0[];
EndIf
""")
SLEEVE = {"mesh": "fit.geo", "order": 2, "units": "mm_t_s_MPa", "materials": "ring,sleeve", "material_ring_E": E, "material_ring_nu": NU,
          "material_sleeve_like": "ring", "bcs": "x,y", "bc_x_on": "x0", "bc_x_ux": 0,
          "bc_y_on": "y0", "bc_y_uy": 0, "contacts": "fit", "contact_fit_secondary": "skin", "contact_fit_primary": "bore",
          "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
SPACE = {"bcs": "ends,x,y", "bc_ends_on": "ends", "bc_ends_uz": 0}
PLANE = {"mesh_set_plane": 1, "plane": "stress", "thickness": LENGTH}
BORE = {"contact_fit_secondary": "bore", "contact_fit_primary": "skin"}
TETS = {"mesh_set_simplices": 1}
AUGLAG = {"contact_fit_enforce": "auglag"}
CASES = {"hexahedra": SPACE, "tetrahedra": {**SPACE, **TETS}, "triangles": {**PLANE, **TETS, "mesh_set_n_ring": 12},
         "triangles, augmented": {**PLANE, **TETS, **AUGLAG}}
if long():
    CASES |= {"hexahedra, bore": {**SPACE, **BORE}, "tetrahedra, bore": {**SPACE, **TETS, **BORE}, "20 nodes": {**SPACE, "mesh_serendipity": "on"},
              "tetrahedra, standard multipliers": {**SPACE, **TETS, "contact_fit_multipliers": "standard"},
              "hexahedra, Gauss points": {**SPACE, "contact_fit_method": "gpts"}, "finer ring": {**SPACE, **BORE, "mesh_set_n_ring": 13},
              "quadrilaterals": PLANE, "quadrilaterals, dual": {**PLANE, "contact_fit_multipliers": "dual"}, "triangles, bore": {**PLANE, **TETS, **BORE},
              "triangles, Gauss points": {**PLANE, **TETS, "contact_fit_method": "gpts"}}

print("a clearance of a ten thousandth of the radius: nothing presses")
for name, options in CASES.items():
    r = run("loose", {**SLEEVE, **options, "mesh_set_overlap": -1e-3})
    require(f"{name}: nothing is strained", r["energy_elastic"][-1] == 0)
    check(f"{name}: clearance, less what chords of curved faces leave", r["contact_fit_gap_min"][-1], 1e-3, 3e-4, relative=False)

print("an overlap of a thousandth: the pressure of rings that may thicken")
overlap = 1e-2
square = [radius**2 for radius in (INNER, FIT, OUTER)]
pressure = overlap * E / FIT / ((square[1] + square[0]) / (square[1] - square[0]) + (square[2] + square[1]) / (square[2] - square[1]))
for name, options in CASES.items():
    r = run("tight", {**SLEEVE, **options, "mesh_set_overlap": overlap, "contact_fit_initial": "allow"})
    force = abs(r["contact_fit_force_x"][-1])
    check(f"{name}: mean pressure", force / (FIT * LENGTH), pressure, 0.015)
    check(f"{name}: first law", abs(r["balance_first_law"]).max(), 0, 1e-2, relative=False)
finish()
