# labels: run
# long: 200
"""Receding contact (J. Dundurs, M. Stippes, J. Appl. Mech. 37 (1970) 965): what touches under a load does so at any size of the load,
and all else is in proportion. A strip on a plane, pressed over its middle, lifts its long ends; three blocks with gaps between them,
held by contact alone, close them, also where they are four facets wide. Loads from 1e-9 E (blocks: 1e-8 E) to 1e-3 E. Rings of any size deform in SI units as they should."""
from _runs import check, check_between, finish, long, mesh, run

E = 1e5
STRIP = """DefineConstant[n = 12];
Point(1) = {0, 0, 0}; Point(2) = {8, 0, 0}; Point(3) = {8, 1, 0}; Point(4) = {0, 1, 0}; Point(5) = {0.25, 1, 0}; Point(6) = {0.25, 0, 0};
Line(1) = {1, 6}; Line(2) = {6, 2}; Line(3) = {2, 3}; Line(4) = {3, 5}; Line(5) = {5, 4}; Line(6) = {4, 1}; Line(7) = {6, 5};
Curve Loop(1) = {1, 7, 5, 6}; Plane Surface(1) = {1}; Curve Loop(2) = {2, 3, 4, -7}; Plane Surface(2) = {2};
Transfinite Curve {1, 5} = n/4 + 1; Transfinite Curve {2, 4} = 31*n/4 + 1; Transfinite Curve {3, 6, 7} = n + 1;
Transfinite Surface {1, 2}; Recombine Surface {1, 2};
Physical Surface("layer") = {1, 2}; Physical Curve("low") = {1, 2}; Physical Curve("axis") = {6}; Physical Curve("pad") = {5};
"""
BLOCKS = """DefineConstant[n = 1];
For b In {0 : 2}
  f = 10*b; o = 1.05*b;
  Point(f+1) = {0, o, 0}; Point(f+2) = {2, o, 0}; Point(f+3) = {2, o+1, 0}; Point(f+4) = {0, o+1, 0};
  For i In {1 : 4}
    Line(f+i) = {f+i, f+1+(i%4)};
  EndFor
  Curve Loop(f+1) = {f+1 : f+4}; Plane Surface(f+1) = {f+1};
  Transfinite Curve {f+1, f+3} = n*(8 + 2*b) + 1; Transfinite Curve {f+2, f+4} = n*(4 + b) + 1; Transfinite Surface {f+1}; Recombine Surface {f+1};
  Physical Surface(Sprintf("b%g", b+1)) = {f+1}; Physical Curve(Sprintf("low%g", b+1)) = {f+1}; Physical Curve(Sprintf("up%g", b+1)) = {f+3};
EndFor
Physical Curve("left") = {4, 14, 24};
"""
for name, text in ("strip.geo", STRIP), ("blocks.geo", BLOCKS):
    with open(name, "w") as file:
        file.write(text)
STATIC = {"units": "mm_t_s_MPa", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "energy_tol": 0}

def strip(name, p, **more):
    """The strip under the traction p, in one step."""
    return run(name, {
        "mesh": "strip.geo", **STATIC, "materials": "layer", "material_layer_E": E, "material_layer_nu": 0.3,
        "bcs": "axis,pad", "bc_axis_on": "axis", "bc_axis_ux": 0, "bc_pad_on": "pad", "bc_pad_type": "traction", "bc_pad_uy": f"(-{p}*t)",
        "contacts": "low", "contact_low_secondary": "low", "contact_low_primary": "plane", **more}, refused=2)


lengths = {}
for p in (1e-4, 1e-3, 1e-2, 0.1, 1, 10, 100)[:: 1 if long() else 2]:
    r = strip(f"strip_{p:g}", p)
    lengths[p] = r["contact_low_length"][-1]
    check(f"strip, p/E = {p / E:g}: force", r["contact_low_force_y"][-1], 0.25 * p, 1e-5)
    check_between(f"strip, p/E = {p / E:g}: iterations of the step", r["newton"][-1], 3, 18)
check("strip: touching length, largest over smallest load", lengths[100], lengths[1e-4], 1e-3)
for p in (1e-3, 0.1) if long() else (1e-3,):  # 26,000 unknowns: springs as stiff as facets throw off more nodes than their iterations bring back
    r = strip(f"fine_{p:g}", p, mesh_set_n=40)
    check(f"fine strip, p/E = {p / E:g}: steps", len(r["time"]) - 1, 1, 0)
    check_between(f"fine strip, p/E = {p / E:g}: iterations", r["newton"][-1], 3, 35)
    check(f"fine strip, p/E = {p / E:g}: force", r["contact_low_force_y"][-1], 0.25 * p, 1e-5)
    check(f"fine strip, p/E = {p / E:g}: touching length, to a cell of the coarse one", r["contact_low_length"][-1], lengths[100], 1 / 12, relative=False)
r = strip("strip_points", 0.01, contact_low_method="gpts")
check("strip: touching length by Gauss points, to half a cell", r["contact_low_length"][-1], lengths[1e-2], 1 / 24, relative=False)

def blocks(name, p, **more):
    r = run(name, {
        "mesh": "blocks.geo", **STATIC, "materials": "b1,b2,b3", "material_b1_E": E, "material_b1_nu": 0, "material_b2_like": "b1",
        "material_b3_like": "b1", "bcs": "floor,left,top", "bc_floor_on": "low1", "bc_floor_uy": 0, "bc_left_on": "left", "bc_left_ux": 0,
        "bc_top_on": "up3", "bc_top_type": "traction", "bc_top_uy": f"(-{p}*t)", "contacts": "c,d", "contact_c_secondary": "up1",
        "contact_c_primary": "low2", "contact_d_secondary": "up2", "contact_d_primary": "low3", "probes": "top", "probe_top_at": "1,3.1", **more}, refused=1)
    for contact in "cd":
        check(f"{name}: force of {contact}", r[f"contact_{contact}_force_y"][-1], -2 * p, 1e-4)
    check(f"{name}: way of the top", r["probe_top_uy"][-1], -0.1 - 3 * p / E, 1e-4)
    return r


for p in (1e-3, 0.1, 1, 100):
    # The absolute tolerance, a part of the stiffness of a body, is near the smallest load.
    blocks(f"blocks_{p:g}", p, **({"motion_snes_atol": 1e-13} if p < 0.01 else {}))
for p in (0.1, 1, 100) if long() else ():  # 14,000 unknowns: the second block is pushed towards what it does not face yet
    r = blocks(f"fine_blocks_{p:g}", p, mesh_set_n=10, contact_c_search_radius=0.2, contact_d_search_radius=0.2)
    check(f"fine blocks, p/E = {p / E:g}: steps", len(r["time"]) - 1, 1, 0)
# A cylinder of aluminium under pressure at one end, in SI units: its forces go with 2 pi R h, not with h.
for size in (1e-8, 1e-5, 1e-2)[:: 1 if long() else 2]:
    for pressure in (10, 1e5):
        r = run(f"rings_{size:g}_{pressure:g}", {
            "mesh": mesh("block.geo"), "mesh_scale": size, "plane": "axisymmetric", "materials": "solid", "material_solid_E": 7e10,
            "material_solid_nu": 0, "bcs": "hold,axis,press", "bc_hold_on": "bottom", "bc_hold_uy": 0, "bc_axis_on": "left", "bc_axis_ux": 0,
            "bc_press_on": "top", "bc_press_type": "pressure", "bc_press_value": pressure, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1,
            "measures": "end", "measure_end_on": "top", "measure_end_fields": "u", "measure_end_of": "mean"})
        check(f"cylinder of {size:g} m under {pressure:g} Pa: shortening", -r["measure_end_uy"][-1] / size, pressure / 7e10, 1e-5)
finish()
