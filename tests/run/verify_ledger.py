# labels: run
# timeout: 120
"""The energy sheet at the end of shortened runs of the gallery: no dissipation at any point in any step is negative, and
what the sheet and the columns of materials say adds up to the totals."""
import re

import numpy

import _runs as runs

# Flow with heat; contact, flow, damage and viscosity; contact that is stabilised; the paper's choices.
GALLERY = {"necking": {"ts_max_steps": 25}, "beam_wedge": {"ts_max_steps": 12, "ts_dt": 0.01},
           "bars_impact": {"ts_max_steps": 60}, "beam_wedge_paper": {"ts_max_steps": 3}}
for name, more in GALLERY.items():
    run = runs.run(name, {**more, "history_materials": 1}, files=[runs.option_file(name + ".opts")])
    sheet = run.log[run.log.index("energy since t = 0"):]
    rows = {re.split(r"  +", line.strip())[0]: [float(x) for x in line[33:].split()] for line in sheet.splitlines()[1:]
            if re.match(r"  \w", line)}
    runs.check(f"{name}: smallest dissipation at a point", rows["smallest dissipation at a point"][0], 0, 0, relative=False)
    materials = [c[len("energy_kinetic_"):] for c in run.history if c.startswith("energy_kinetic_")]
    kinds = [c for c in run.history if re.fullmatch(r"(energy_(elastic|plastic|fracture|thermal)|"
                                                    r"dissipated_(viscous|damage|plastic))", c)]
    runs.require(f"{name}: {len(kinds)} kinds in {len(materials)} materials", len(kinds) > 0 and len(materials) > 0)
    scale = max(abs(run[c]).max() for c in kinds)
    for kind in kinds:
        parts = sum(run[f"{kind}_{m}"] for m in materials)
        runs.check(f"{name}: {kind} of the materials", abs(parts - run[kind]).max() / scale, 0, 1e-12, relative=False)
        row = kind.replace("energy_", "stored: ").replace("dissipated_", "dissipated: ")
        row = next(r for r in rows if r == row or r == row + " (heat)")
        runs.check(f"{name}: {kind} of the sheet", abs(rows[row][0] - run[kind][-1]) / scale, 0, 1e-4, relative=False)
        if kind.startswith("dissipated"):
            runs.require(f"{name}: {kind} never shrinks", (numpy.diff(run[kind]) >= 0).all())
    supplied = rows["work of loads and supports"][0] + sum(rows.get("heat supplied", [0])) + rows["at the start"][0]
    inside = sum(v[0] for r, v in rows.items() if r.startswith(("stored", "dissipated")) and "(heat)" not in r)
    runs.check(f"{name}: the sheet adds up to its residual", inside - supplied, rows["first-law residual"][0], 2e-4 * scale,
               relative=False)
# What stands at t = 0 and is not in balance there, without inertia: a load grows in the first step, and so does a prescribed crack.
BAR = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_n": 40, "mesh_set_ny": 4,
       "mesh_set_ly": 0.1, "materials": "solid", "material_solid_E": 210e3, "material_solid_nu": 0.3, "bcs": "hold,load",
       "bc_hold_on": "left", "bc_hold_type": "fix", "bc_load_on": "right", "ts_dt": 0.25, "ts_max_time": 1}
run = runs.run("load", {**BAR, "bc_load_type": "traction", "bc_load_ux": 100})
runs.check("a load from the start on: its work is what the body stores", run["work_external"][-1] / run["energy_elastic"][-1], 1, 1e-3)
runs.check("a load from the start on: first law", abs(run["balance_first_law"]).max(), 0, 1e-3, relative=False)
CRACK = {**BAR, "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": 2.7, "material_solid_gamma": 0.1, "bc_load_type": "damage"}
for name, more, work in (("seeded", {"bc_load_value": 1}, None), ("driven", {"bc_load_value": "t"}, 1),
                         ("driven with a rate", {"bc_load_value": "t", "material_solid_c": 1, "ts_dt": 0.01}, 1)):
    run = runs.run(name.replace(" ", "_"), {**CRACK, **more})
    # The stress of the spike's gradient moves the bar: what staggering leaves of that.
    runs.check(f"{name} crack: first law", run["balance_first_law"][-1], 0, 1e-2 if name == "seeded" else 2e-3, relative=False)
    change = run["energy_fracture"][-1] - run["energy_fracture"][0] + run["dissipated_damage"][-1]
    runs.check(f"{name} crack: work of the prescribed phi over energy and dissipation", run.history.get("work_damage", [0])[-1] / change, 1, 1e-2)
# What Newton's method leaves is told apart: by a hundredth of the force, the balance holds as it does by 1e-10 of it.
LOOSE = {**BAR, "bc_load_type": "traction", "bc_load_ux": "20e3*t", "motion_snes_rtol": 1e-4, "motion_snes_atol": 0, "motion_reuse_tangent": 0.9}
run = runs.run("loose", LOOSE)
left = float(re.search(r"work of unbalanced forces +(\S+)", run.log).group(1)) / run["work_external"].max()
runs.check_between("a loose tolerance: work of unbalanced forces over the work", abs(left), 1e-9, 1e-5)
runs.finish()
