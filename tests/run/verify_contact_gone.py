# labels: run
# timeout: 120
"""A contact that a restart leaves out keeps what it took and lost in the books, columns and sheet; the script that left it out may run
again as it is. Surfaces that touch to rounding at the start hold no energy there. `none` takes back what a file gives."""
import re
import numpy
from _runs import check, finish, mesh, require, run

PRESSED = {"units": "mm_t_s_MPa", "plane": "strain", "mesh": mesh("block.geo"), "mesh_set_n": 8, "mesh_set_ny": 4, "mesh_set_lx": 2,
           "mesh_set_ly": 1, "materials": "solid", "material_solid_E": 100, "material_solid_nu": 0.45, "bcs": "base,left",
           "bc_base_on": "bottom", "bc_base_uy": 0, "bc_left_on": "left", "bc_left_ux": 0, "contacts": "tool",
           "contact_tool_secondary": "top", "contact_tool_primary": "plane", "contact_tool_plane_point": "0,1",
           "contact_tool_plane_normal": "0,-1", "contact_tool_rigid_uy": "(-0.1*t)", "contact_tool_friction": 0.1,
           "ts_type": "static", "ts_dt": 0.1, "outputs": "hist", "output_hist_type": "csv"}
with open("pressed.opts", "w") as out:
    out.write("".join(f"-{key} {value}\n" for key, value in {**PRESSED, "output_hist_every": 3}.items()))


def of_sheet(log, line):
    found = re.search(rf"^ *{line} +(\S+)", log, re.M)
    return float(found.group(1)) if found else numpy.nan


r = run("pressed", {"ts_max_time": 1, "output_hist_every": "none"}, files=["pressed.opts"])
check("every step has a row, as without -output_hist_every: rows", len(r["time"]), 11, 0)
lost = r["dissipated_friction"][-1]
require("friction has a part of the work", lost > 0.005 * r["work_external"][-1])
check("energy at the start, of surfaces that touch to rounding", of_sheet(r.log, "at the start"), 0, 0, relative=False)

GONE = {"contacts": "none", "restart": "auto", "restart_allow": "contacts,contact_tool", "output_hist_every": "none"}
for until in (1.2, 1.4):
    r = run("pressed", {**GONE, "ts_max_time": until}, files=["pressed.opts"])
    check(f"gone, to t = {until}: friction of before", r["dissipated_friction"][-1], lost, 1e-14)
    require("its column of work goes on", numpy.isfinite(r["work_contact"]).all())
    check("friction in the sheet", of_sheet(r.log, "dissipated: friction"), lost, 1e-4)
    there = sum(of_sheet(r.log, line) for line in ("stored: elastic", "stored: contact", "dissipated: friction", "dissipated: integrator"))
    came = of_sheet(r.log, "work of loads and supports") + of_sheet(r.log, "at the start") + of_sheet(r.log, "first-law residual")
    check("the lines of the sheet add up, over the work", (there - came) / of_sheet(r.log, "work of loads and supports"), 0, 1e-4, relative=False)
finish()
