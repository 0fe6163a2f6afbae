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
runs.finish()
