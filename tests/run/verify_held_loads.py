# labels: run
# timeout: 60
"""A step that is much longer than the one before it, as loads that ramped are held: an arch below its limit stays where it is, a
tube that was pressed or warmed and blocks that were pressed on each other find their state at once. They snapped through with exit
status 0, or ended with status 5: the first guess went on as far as the step was longer."""
from _runs import check, finish, mesh, require, run

with open("arch.geo", "w") as file:
    file.write("""half = 50; rise = 4; t = 1; n = 24; R = (half * half + rise * rise) / 2 / rise; c = rise - R; s = (R + t / 2) / R; q = (R - t / 2) / R;
Point(9) = {0, c, 0}; Point(1) = {-half * q, c - c * q, 0}; Point(2) = {0, c + (R - t / 2), 0}; Point(3) = {0, c + (R + t / 2), 0};
Point(4) = {-half * s, c - c * s, 0}; Circle(1) = {1, 9, 2}; Line(2) = {2, 3}; Circle(3) = {3, 9, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = n + 1; Transfinite Curve {2, 4} = 3; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("arch") = {1}; Physical Curve("middle") = {2}; Physical Curve("end") = {4}; Physical Curve("top") = {3};
""")
ARCH = {"units": "mm_t_s_MPa", "mesh": "arch.geo", "order": 2, "materials": "arch", "material_arch_E": 70e3, "material_arch_nu": 0.3, "material_arch_rho": 2.7e-9,
        "bcs": "middle,end,load", "bc_middle_on": "middle", "bc_middle_ux": 0, "bc_end_on": "end", "bc_end_type": "fix", "bc_load_on": "top",
        "bc_load_type": "traction", "measures": "top", "measure_top_on": "middle", "measure_top_fields": "u"}
# Its limit is 0.16 MPa.
for name, load, longer, more in (("63 % of the limit", 0.1, 30, {"ts_type": "static"}), ("87 % of the limit", 0.14, 1000, {"ts_type": "static"}),
                                 ("63 %, with inertia", 0.1, 30, {"ts_type": "newmark"})):
    r = run("arch", {**ARCH, **more, "bc_load_uy": f"(-{load})*min(t,1)", "ts_times": f"0,1,{1 + longer}", "ts_dts": f"0.25,{longer}"}, refused=None)
    u = r["measure_top_uy"]
    check(f"arch, {name}: displacement after a step of {longer} s, over that when the load ends to grow", u[-1] / u[4], 1, 1e-5)
    require(f"arch, {name}: one try, {r['newton'][-1]:.0f} iterations", r["tries"].max() == 1 and len(u) == 6)

# Ramps of a millisecond, then a step of hours.
TUBE = {"mesh": mesh("block.geo"), "mesh_set_n": 6, "mesh_set_lx": 0.01, "mesh_set_ly": 0.01, "plane": "axisymmetric", "materials": "solid",
        "material_solid_E": 210e9, "material_solid_nu": 0.3, "material_solid_alpha_t": 1.2e-5, "material_solid_c_v": 3.5e6, "material_solid_conductivity": 50,
        "bcs": "axis,foot,rim,hot", "bc_axis_on": "left", "bc_axis_ux": 0, "bc_foot_on": "bottom", "bc_foot_uy": 0, "bc_rim_on": "right",
        "ts_type": "static", "ts_times": "0,1e-3,1e4", "ts_dts": "1e-3,1e4"}
RISE = "min(t/1e-3,1)"
pressed = run("pressed", {**TUBE, "physics": "motion", "bcs": "axis,foot,rim", "bc_rim_type": "pressure", "bc_rim_value": f"1e7*{RISE}"}, refused=None)
require(f"pressed and held: {len(pressed['time']) - 1} steps, one try each", len(pressed["time"]) == 3 and pressed["tries"].max() == 1)
check("its energy stays", pressed["energy_elastic"][-1], pressed["energy_elastic"][1], 1e-8)
warm = run("warm", {**TUBE, "bc_rim_type": "temperature", "bc_rim_value": f"293.15+50*{RISE}", "bc_hot_on": "top", "bc_hot_type": "temperature",
                    "bc_hot_value": f"293.15+50*{RISE}", "material_solid_theta0": 293.15, "measures": "rim", "measure_rim_on": "right",
                    "measure_rim_fields": "u"}, refused=None)
require(f"warmed and held: {len(warm['time']) - 1} steps, one try each", len(warm["time"]) == 3 and warm["tries"].max() == 1)
check("free of stress in the end: alpha dtheta R", warm["measure_rim_ux"][-1], 1.2e-5 * 50 * 0.01, 2e-3)

BLOCKS = {"units": "mm_t_s_MPa", "mesh": mesh("two_blocks.geo"), "mesh_set_inset": 0.1, "materials": "lower,upper", "material_lower_E": 100,
          "material_lower_nu": 0.3, "material_upper_like": "lower", "bcs": "ground,top,guide", "bc_ground_on": "lower_bottom", "bc_ground_type": "fix",
          "bc_top_on": "upper_top", "bc_top_type": "traction", "bc_top_uy": "(-10)*min(t,1)", "bc_guide_on": "upper_top", "bc_guide_ux": 0, "contacts": "c",
          "contact_c_secondary": "upper_bottom", "contact_c_primary": "lower_top", "ts_type": "static", "ts_times": "0,1,10001", "ts_dts": "0.25,10000"}
for method in "mortar", "gpts":
    r = run("blocks", {**BLOCKS, "contact_c_method": method}, refused=None)
    require(f"blocks pressed and held, {method}: {len(r['time']) - 1} steps, one try each", len(r["time"]) == 6 and r["tries"].max() == 1)
    check(f"blocks, {method}: energy", r["energy_elastic"][-1], r["energy_elastic"][4], 1e-6)
finish()
