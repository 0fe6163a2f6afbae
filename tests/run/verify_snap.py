# labels: run
# timeout: 120
"""A rigid cylinder goes under the free end of a leaf and back (static): the leaf springs up beyond it and bears nothing at the end,
without friction no work is left, with friction it is heat. Newton's method finds a state of 2700 times the energy on the way, which
no work gave: such a step is tried again with half its length (src/theory.md, Watch)."""
from _runs import check, check_between, finish, require, run

with open("leaf.geo", "w") as out:
    out.write("""Point(1) = {0, 0, 0}; Point(2) = {20, 0, 0}; Point(3) = {20, 1, 0}; Point(4) = {0, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 41; Transfinite Curve {2, 4} = 5; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("leaf") = {1}; Physical Curve("root") = {4}; Physical Curve("skin") = {1, 2, 3};
""")
LEAF = {"units": "mm_t_s_MPa", "mesh": "leaf.geo", "materials": "leaf", "material_leaf_E": 2000, "material_leaf_nu": 0.3, "bcs": "root",
        "bc_root_on": "root", "bc_root_type": "fix", "contacts": "snap", "contact_snap_secondary": "skin",
        "contact_snap_primary": "rigid_cylinder", "contact_snap_centre": "24,-1.5", "contact_snap_radius": 2, "contact_snap_friction": 0,
        "contact_snap_rigid_ux": "-12*cycle(t,2)", "ts_type": "static", "ts_dt": 0.005, "ts_max_time": 2}
# Energy of the fifteen other methods, cells and steps that keep to the branch: 0.039 to 0.042.
for friction in (0, 0.2):
    r = run(f"leaf_{friction}", {**LEAF, "contact_snap_friction": friction}, refused=None)
    name = f"friction {friction}"
    most = r["energy_elastic"].max()
    check_between(f"{name}: largest elastic energy", most, 0.038, 0.047)
    check(f"{name}: what is left of it", r["energy_elastic"][-1] / most, 0, 1e-6, relative=False)
    if friction == 0:
        require(f"{name}: a leap is told", "in one step: another state than the one next to the last" in r.log)
        check(f"{name}: work that is left", r["work_external"][-1] / most, 0, 1e-3, relative=False)
    else:
        check(f"{name}: work over the heat of friction", r["work_external"][-1], r["dissipated_friction"][-1], 1e-3)
finish()
