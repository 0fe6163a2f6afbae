# labels: run
"""A cylinder bends a cantilever that flows. Whether it is drawn back or taken away at a restart (-restart_allow contacts), the bar springs
back to the same place, and what the release of its elastic energy did is the first law's only error. A tool that comes at a restart
goes on with what another condition did."""
import numpy
from _runs import check, finish, mesh, read_history, require, run

with open("bar.geo", "w") as file:
    file.write("""Point(1) = {0, 0, 0}; Point(2) = {100, 0, 0}; Point(3) = {100, 5, 0}; Point(4) = {0, 5, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1 : 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 61; Transfinite Curve {2, 4} = 5; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("bar") = {1}; Physical Curve("left") = {4}; Physical Curve("right") = {2}; Physical Curve("up") = {3};
""")
BAR = {
    "mesh": "bar.geo", "units": "mm_t_s_MPa", "materials": "bar", "material_bar_model": "j2", "material_bar_sigma_y": 300,
    "material_bar_hardening": "linear", "material_bar_linear_h": 2000, "material_bar_E": 200e3, "material_bar_nu": 0.3,
    "bcs": "left", "bc_left_on": "left", "bc_left_type": "fix", "contacts": "tool", "contact_tool_secondary": "up",
    "contact_tool_primary": "rigid_cylinder", "contact_tool_centre": "90,15", "contact_tool_radius": 10, "contact_tool_friction": 0.1,
    "ts_type": "static", "ts_dt": 0.1, "ts_max_time": 1, "measures": "tip", "measure_tip_on": "right", "energy_tol": 0}
back = run("back", {**BAR, "contact_tool_rigid_uy": "-8*min(t, 2 - t)", "ts_max_time": 2, "ts_times": "0,1,2", "ts_dts": "0.1,0.1"}, refused=None)
run("taken", {**BAR, "contact_tool_rigid_uy": "-8*t"}, refused=None)
alone = {key: value for key, value in BAR.items() if not key.startswith("contact_")}
refused = run("taken", {**alone, "restart": "auto", "contacts": "none", "ts_max_time": 1.1}, code=2)
require("a contact that is gone is allowed by its name", refused.log.rstrip().endswith("-restart_allow contact_tool,contacts"))
taken = run("taken", {**alone, "restart": "auto", "restart_allow": "contacts,contact_tool", "contacts": "none", "ts_max_time": 1.1})
last, loaded = len(taken["time"]) - 1, int(numpy.argmin(abs(taken["time"] - 1)))
check("place after springback, taken away over drawn back", taken["measure_tip_uy"][-1], back["measure_tip_uy"][-1], 1e-6)
require("it springs back", taken["measure_tip_uy"][loaded] < 1.1 * taken["measure_tip_uy"][-1] < 0)
before, after = ({k: taken[k][n] for k in ("energy_elastic", "energy_plastic", "dissipated_plastic", "work_external", "balance_first_law")}
                 for n in (loaded, last))
let_go = before["energy_elastic"] - after["energy_elastic"]
lost = before["balance_first_law"] - after["balance_first_law"]
check("what the first law misses over what the bar let go", lost * before["work_external"] / let_go, 1, 1e-3)

# With inertia: a block is pressed and let go in a step of six times what a wave needs through a cell. Accelerations jump there, and the
# energy goes on; with that of the pressed block half a step of its force was lost, 38 % of the energy.
PRESSED = {
    "mesh": mesh("block.geo"), "mesh_set_n": 8, "materials": "solid", "material_solid_E": 1e9, "material_solid_nu": 0.3, "material_solid_rho": 2000,
    "bcs": "floor", "bc_floor_on": "bottom", "bc_floor_type": "fix", "ts_type": "newmark", "ts_newmark_rho": 1, "ts_dt": 1e-3}
PRESS = {"contacts": "tool", "contact_tool_secondary": "top", "contact_tool_primary": "plane", "contact_tool_plane_point": "0,1",
         "contact_tool_plane_normal": "0,-1", "contact_tool_rigid_uy": "(-0.004*ramp(t,0,0.01))"}
run("pressed", {**PRESSED, **PRESS, "ts_max_time": 0.02}, refused=None)
r = run("pressed", {**PRESSED, "contacts": "none", "restart": "auto", "restart_allow": "contacts,contact_tool", "ts_max_time": 0.03})
energy, pressed = r["energy_kinetic"] + r["energy_elastic"], int(numpy.argmin(abs(r["time"] - 0.02)))
for name, row in ("first step", pressed + 1), ("end", -1):
    check(f"pressed and let go: energy after the {name} over that before", energy[row] / energy[pressed], 1, 0.01)

# With heat: what passed a support is kept, while another one goes and a heated side comes.
WARM = {"contacts": "none", "physics": "motion,heat", "material_bar_rho": 7.8e-9, "material_bar_c_v": 3.6, "material_bar_conductivity": 50, "material_bar_theta0": 300,
        "bcs": "left,right,cold", "bc_right_on": "right", "bc_right_ux": 0, "bc_cold_on": "left", "bc_cold_type": "temperature", "bc_cold_value": 280}
warm = run("warm", {**alone, **WARM})
free = {key: value for key, value in WARM.items() if not key.startswith("bc_right")}
let_go = run("let_go", {**alone, **free, "bcs": "left,cold,hot", "bc_hot_on": "up", "bc_hot_type": "heat_flux", "bc_hot_value": 10,
                        "restart": "warm/checkpoints/checkpoint_000001.h5", "restart_allow": "bcs,bc_right,bc_hot", "ts_max_time": 1.1})
check("a support let go, a flux added: heat of the cold end", let_go["heat_cold"][0], warm["heat_cold"][-1], 0.1)
check("heat supplied, ends and flux", let_go["heat_supplied"][-1], let_go["heat_cold"][-1] + let_go["heat_hot"][-1], 1e-12)
check("heat of the flux in its step", let_go["heat_hot"][-1], 10 * 100 * 0.1, 1e-2)

# A block that flows, pressed by a condition to the middle, and from there on by a plane in its place.
FLOWS = {
    "mesh": mesh("block.geo"), "mesh_set_n": 4, "units": "mm_t_s_MPa", "materials": "solid", "material_solid_model": "j2",
    "material_solid_E": 1000, "material_solid_nu": 0.3, "material_solid_sigma_y": 10, "material_solid_hardening": "linear",
    "material_solid_linear_h": 50, "bcs": "floor,side", "bc_floor_on": "bottom", "bc_floor_uy": 0, "bc_side_on": "left", "bc_side_ux": 0,
    "ts_type": "static", "ts_dt": 0.05, "ts_max_time": 1}
PLANE = {**PRESS, "contact_tool_rigid_uy": "(-0.05*t)"}
whole = run("plane", {**FLOWS, **PLANE})
MORE = {"restart": "auto", "outputs": "hist", "restart_allow": "contacts,contact_tool,bcs,bc_push", "output_hist_type": "csv",
        "output_hist_file": "on.csv"}
for method in ("mortar", "gpts"):
    run(f"comes_{method}", {**FLOWS, "bcs": "floor,side,push", "bc_push_on": "top", "bc_push_uy": "-0.05*t", "ts_max_time": 0.5})
    refused = run(f"comes_{method}", {**FLOWS, **PLANE, "contact_tool_rigid_uy": "(-0.06*t)", "contact_tool_method": method, **MORE}, code=3)
    require(f"{method}: a plane that would begin in the block is refused: {refused.log.splitlines()[-1]}",
            "overlaps `plane` by 0.005 where it begins" in refused.log)
    run(f"comes_{method}", {**FLOWS, **PLANE, "contact_tool_method": method, **MORE})
    comes = read_history(f"comes_{method}/on.csv")
    for column in ("energy_elastic", "energy_plastic", "dissipated_plastic", "contact_tool_force_y"):
        check(f"{method}: {column} at the end, of a plane that comes in the middle", comes[column][-1], whole[column][-1], 1e-6)
    check(f"{method}: work from there on", comes["work_external"][-1] - comes["work_external"][-6],
          whole["work_external"][-1] - whole["work_external"][-6], 1e-6)
    check(f"{method}: first law", abs(comes["balance_first_law"]).max(), 0, 0.02, relative=False)
finish()
