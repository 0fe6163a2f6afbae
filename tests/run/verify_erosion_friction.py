# labels: run
# timeout: 120
# long: 300
"""Friction in runs in which cells may leave: a pad that sticks stays where it is, by explicit and implicit steps, whether cells leave
elsewhere or none does, and the sheet has the energy of its springs; restart among leaving cells, ranks, repeated steps."""
import numpy
from _runs import check, check_between, finish, long, require, run
from _whole import check_goes_on

GEO = """// A pad on a base, whose meshes do not match, and a strip beside them.
left[] = {0, 0.5, 4}; right[] = {2, 1.5, 5}; low[] = {0, 1, 0}; high[] = {1, 1.5, 0.2}; nx[] = {8, 5, 8}; ny[] = {4, 2, 1};
For k In {0 : 2}
  a = newp; Point(a) = {left[k], low[k], 0}; Point(a + 1) = {right[k], low[k], 0};
  Point(a + 2) = {right[k], high[k], 0}; Point(a + 3) = {left[k], high[k], 0};
  l = newl; Line(l) = {a, a + 1}; Line(l + 1) = {a + 1, a + 2}; Line(l + 2) = {a + 2, a + 3}; Line(l + 3) = {a + 3, a};
  Transfinite Curve {l, l + 2} = nx[k] + 1; Transfinite Curve {l + 1, l + 3} = ny[k] + 1;
  Curve Loop(k + 1) = {l : l + 3}; Plane Surface(k + 1) = {k + 1}; Transfinite Surface {k + 1}; Recombine Surface {k + 1};
EndFor
Physical Surface("base") = {1}; Physical Surface("pad") = {2}; Physical Surface("strip") = {3};
Physical Curve("floor") = {1}; Physical Curve("table") = {3}; Physical Curve("foot") = {5}; Physical Curve("head") = {7};
"""
with open("pad.geo", "w", encoding="ascii") as file:
    file.write(GEO)
MU, PRESS, SHEAR = 0.5, 5.0, 1.0
PAD = {"mesh": "pad.geo", "materials": "base,pad,strip", "contacts": "c", "contact_c_secondary": "foot", "contact_c_primary": "table",
       "contact_c_friction": MU, "contact_c_method": "gpts", "contact_c_enforce": "penalty", "contact_c_penalty": 2e4,
       "bcs": "hold,push", "bc_hold_on": "floor", "bc_hold_type": "fix", "bc_push_on": "head", "bc_push_type": "traction",
       "bc_push_uy": f"-{PRESS}*ramp(t,0,0.02)", "bc_push_ux": f"{SHEAR}*ramp(t,0.03,0.04)", "measures": "a", "measure_a_on": "foot",
       "measure_a_fields": "u", "ts_max_time": 0.1, "checkpoint_every": 20,
       **{f"material_{name}_{key}": value for name in ("base", "pad", "strip")
          for key, value in {"E": 1000, "nu": 0.3, "rho": 1e-3, "b_d": 0.03}.items()}}
# Cells of the strip, which closes up by itself, leave from the time on at which the pad begins to stick.
FLIES = {"ics": "f", "ic_f_on": "strip", "ic_f_vx": "(0-20-8*(x-4.5))*(x-4.5)", "material_strip_b_d": 0, "material_strip_E": 1e-3,
         "material_strip_erosion": "on", "material_strip_erosion_J": 0.4}
SCHEMES = {"explicit": {"ts_type": "central_difference", "ts_dt": 3.5e-5}, "implicit": {"ts_type": "newmark", "ts_dt": 1e-3}}
for scheme, steps in SCHEMES.items():
    stuck = run(f"stuck_{scheme}", {**PAD, **steps})
    before, after = (numpy.searchsorted(stuck["time"], t) for t in (0.03, 0.1))
    moved = stuck["measure_a_ux"][-1] - stuck["measure_a_ux"][before]
    check(f"{scheme}: shear force", stuck["contact_c_force_x"][-1], -SHEAR, 0.05)
    check_between(f"{scheme}: the pad gives way by what is elastic in it and below", moved, 1e-4, 5e-3)
    for name, more in (("none leaves", {"material_pad_erosion": "on", "material_pad_erosion_J": 0.01}),
                       ("cells leave", FLIES)):
        r = run(f"{name[:4]}_{scheme}", {**PAD, **steps, **more})
        for column in ("measure_a_ux", "contact_c_force_x", "contact_c_force_y"):
            check(f"{scheme}, {name}: {column}", abs(r[column] - stuck[column]).max() / abs(stuck[column]).max(), 0, 1e-3 if "force" in column else 1e-4,
                  relative=False)
        check(f"{scheme}, {name}: heat of friction", (r["dissipated_friction"] - stuck["dissipated_friction"])[-1] / (SHEAR * moved), 0,
              1e-6, relative=False)
    last = r["eroded_cells"]
    require(f"{scheme}: cells left as it stuck", last[before] < last[-1] and last[-1] > 2)
    if not long():  # verify_erosion goes on with such a run
        continue
    rubs = ("dissipated_friction", "contact_c_dissipated")
    two = check_goes_on(f"{scheme}: ", {**PAD, **steps, **more}, r, int(r["step"][(before + after) // 2]), 1e-8, rounding=rubs)
    for column in rubs:  # what rubs nowhere is rounding
        for one in (r, two):
            check(f"{scheme}: {column}", abs(one[column]).max() / (SHEAR * moved), 0, 1e-9, relative=False)
finish()
