# labels: run
"""Measures of fields of cells over a region: a column under its weight, of cells that grow upwards, on any number of ranks."""
from _runs import check, finish, run

RHO, G, HEIGHT, AREA, THICK, CELLS, RATIO = 1e-9, 9810, 10, 2, 0.5, 8, 1.3
with open("column.geo", "w") as file:
    file.write(f"""Point(1) = {{0, 0, 0}}; Point(2) = {{{AREA}, 0, 0}}; Point(3) = {{{AREA}, {HEIGHT}, 0}}; Point(4) = {{0, {HEIGHT}, 0}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{3, 4}}; Line(4) = {{4, 1}}; Curve Loop(1) = {{1 : 4}}; Plane Surface(1) = {{1}};
Transfinite Curve {{1, 3}} = 3; Transfinite Curve {{2, -4}} = {CELLS + 1} Using Progression {RATIO};
Transfinite Surface {{1}}; Recombine Surface {{1}};
Physical Surface("column") = {{1}}; Physical Curve("foot") = {{1}}; Physical Curve("sides") = {{2, 4}};
""")
lowest = HEIGHT * (RATIO - 1) / (RATIO**CELLS - 1)
weight = RHO * G
exact = {"mean": -weight * HEIGHT / 2, "sum": -weight * HEIGHT / 2 * HEIGHT * AREA * THICK, "min": -weight * (HEIGHT - lowest / 2),
         "max": -weight * lowest * RATIO ** (CELLS - 1) / 2}
for ranks in (1, 2):
    r = run(f"ranks_{ranks}", {
        "mesh": "column.geo", "units": "mm_t_s_MPa", "thickness": THICK, "materials": "column", "material_column_E": 100, "material_column_nu": 0,
        "material_column_rho": RHO, "bcs": "foot,weight", "bc_foot_on": "foot", "bc_foot_uy": 0, "bc_foot_ux": 0,
        "bc_weight_on": "column", "bc_weight_type": "body_force", "bc_weight_uy": -G, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1,
        "measures": ",".join(exact), **{f"measure_{of}_{key}": value for of in exact
                                       for key, value in (("on", "column"), ("of", of), ("fields", "stress"))}}, ranks=ranks)
    for of, value in exact.items():
        check(f"{ranks} ranks, {of} of stress_yy", r[f"measure_{of}_stress_yy"][-1], value, 1e-5)
run("refused", {"mesh": "column.geo", "units": "mm_t_s_MPa", "materials": "column", "material_column_E": 100, "material_column_nu": 0,
                "bcs": "foot", "bc_foot_on": "foot", "bc_foot_type": "fix", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1,
                "measures": "side", "measure_side_on": "sides", "measure_side_fields": "von_mises"}, code=2)
finish()
