"""What a run says of itself, and lists that can be shortened: each row is a command, its exit status and words that are in
what it prints or are not. An option of ours that a file gives was an error when the command line left its id out; the
head of the log had no groups, masses, gaps, and "as the options say" for the solver."""
# labels: run
# timeout: 120
# long: 200
import subprocess

from _runs import ENVIRONMENT, PROGRAM, check, finish, long, mesh, require, run

BLOCKS = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 2, "mesh_set_n_upper": 2, "mesh_set_gap": 0.01, "materials": "lower,upper",
    "material_lower_E": '"2 MPa"', "material_lower_nu": 0.3, "material_lower_rho": 1000, "material_lower_damage": "at2",
    "material_lower_Gc": 50, "material_lower_gamma": 1, "material_upper_like": "lower", "material_upper_K": 1e6, "material_upper_G": 1e5,
    "bcs": "hold,push", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_push_on": "upper_top", "bc_push_ux": 0,
    "bc_push_uy": '" -0.1*t"', "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "outputs": "vis,more", "output_vis_every": 2, "output_more_times": "0.1,0.2", "probes": "a", "probe_a_at": "0.5,0.5",
    "ts_dt": 0.01, "ts_max_time": 0.02,
}
with open("blocks.opts", "w") as file:
    file.writelines(f"-{key} {value}\n" for key, value in BLOCKS.items())
FILE, DRY = ["-options_file", "blocks.opts"], ["-dry_run"]

RUBBER = ["-mesh", mesh("block.geo"), "-mesh_set_dim", "3", "-mesh_set_n", "10", "-mesh_set_ny", "18", "-order", "2", "-materials", "solid", "-material_solid_K", "2000",
          "-material_solid_G", "1", "-bcs", "hold,press", "-bc_hold_on", "bottom", "-bc_hold_type", "fix", "-bc_press_on", "top",
          "-bc_press_type", "pressure", "-bc_press_value", "t", "-ts_type", "static", "-ts_dt", "1", "-ts_max_time", "1", "-dry_run"]

# claim, words of the command, exit status, what is printed, what is not
ROWS = [
    ("groups", FILE + DRY, 0, ["lower 4 (", "upper_bottom 2 ("], []),
    ("materials as typed", FILE + DRY, 0, ["material lower: elastic with at2 damage, spectral split, E 2 MPa (2e+06), nu 0.3, rho 1000, Gc 50, gamma 1, mass 1000; cells 0.5 to 0.5",
     "material upper: elastic with at2 damage, volumetric split, K 1000000.0, G 100000.0, rho 1000, Gc 50", "-material_lower_E \"2 MPa\"\n-material_lower_nu 0.3\n", "-material_upper_K 1000000.0\n"],
     ["-material_lower_K"]),
    ("gamma over the cells", FILE + DRY, 0, ["material lower: gamma is 2 to 2 cells wide"], []),
    ("waves", FILE + DRY, 0, ["material lower: h/c_p from 0.00964", "c_p 51.88"], []),
    ("the gap of a contact", FILE + DRY, 0, ["contact face: smallest gap at the start 0.01, 0 points press", "candidate pairs"], []),
    ("the solvers", FILE + DRY, 0, ["motion solver: preonly + lu by ", "damage solver: cg + icc", "memory: ", "the factors of the motion take about"], []),
    ("the solvers that options chose", FILE + DRY + ["-motion_ksp_type", "gmres", "-motion_pc_type", "jacobi", "-damage_pc_type", "jacobi"], 0,
     ["motion solver: gmres + jacobi (chosen by options)", "damage solver: cg + jacobi"], ["as the options say", "factors"]),
    ("rubber under pressure in space: factors", RUBBER, 0, ["motion solver: fgmres + lu by mumps (48951 dofs)"], []),
    ("no factors in explicit steps", FILE + DRY + ["-ts_type", "central_difference", "-contact_face_enforce", "penalty", "-ts_dt", "auto"], 0,
     ["central differences: ", "memory: "], ["factors"]),
    ("a dry run looks at probes too", FILE + DRY + ["-probe_a_at", "9,9"], 3, ["-probe_a_at: the point is in no cell of the mesh; give reference "
     "coordinates inside a body, the nearest node is at 1,2.01, 10.6 away"], []),
    ("and at criteria", FILE + DRY + ["-stops", "s", "-stop_s_when", "contact_face_forc_y > 3"], 2, ["has no column 'contact_face_forc_y'; did you mean contact_face_force_y?"], []),
    ("the same words before a run", FILE + ["-ts_max_steps", "1"], 0, ["motion solver: preonly + lu by ", "material lower: gamma is 2"], []),
    ("a contact in which nothing pressed", FILE + ["-ts_max_steps", "1"], 0, ["impact: contact face: nothing pressed in this run", "where something should have"], []),
    ("no outputs", FILE + DRY + ["-outputs", "none"], 0,
     ["without effect, because -outputs leaves their id out: -output_more_times -output_vis_every"], ["\n-outputs"]),
    ("one output less", FILE + DRY + ["-outputs", "vis"], 0, ["without effect", "-output_more_times", "\n-outputs vis\n"], ["-output_more_"[1:] + "every"]),
    ("no times", FILE + DRY + ["-output_more_times", "none"], 0, ["\n-output_more_every 1\n"], ["\n-output_more_times"]),
    ("a typing error beside a list that is shorter", FILE + DRY + ["-outputs", "vis", "-output_more_every", "3"], 2,
     ["unknown option -output_more_every   ('more' is not declared; outputs: vis)"], []),
    ("velocities of a static run", FILE + DRY + ["-ts_type", "static", "-ics", "fall", "-ic_fall_on", "upper", "-ic_fall_vy", "(-1)"], 0,
     ["impact: without effect, because this run has no inertia: velocities of -ic_fall\n"], []),
    ("data of obstacles beside a contact between meshes", FILE + DRY + ["-contact_face_plane_point", "0,1", "-contact_face_radius", "1"], 0,
     ["without effect, because -contact_face_primary is no rigid plane: -contact_face_plane_point",
      "without effect, because -contact_face_primary is no rigid sphere or cylinder: -contact_face_radius"], []),
    ("erosion switched off, and data of laws that nobody chose", FILE + DRY + ["-material_lower_erosion", "off", "-material_lower_erosion_stretch", "2",
      "-material_lower_erosion_mass", "remove", "-material_lower_star_gamma", "2", "-material_lower_jc_d1", "0.1"], 0,
     ["because -material_lower_erosion is off: -material_lower_erosion_mass -material_lower_erosion_stretch",
      "because -material_lower_split is not star_convex: -material_lower_star_gamma", "because -material_lower_jc_failure is off: -material_lower_jc_d1"], []),
    ("data of Newmark's method in statics", FILE + DRY + ["-ts_type", "static", "-ts_newmark_rho", "0.5"], 0,
     ["without effect, because the steps of this -ts_type are not Newmark's: -ts_newmark_rho"], []),
    ("data of heat and of a break where there is none", FILE + DRY + ["-heat_theta", "0.5", "-contact_face_friction_heat_split", "0.3",
      "-material_lower_damage", "none", "-material_upper_damage", "none", "-damage_bounds", "history",
      "-coupling_snes_max_it", "3", "-coupling_error", "-material_lower_conduction", "material"], 0,
     ["without effect, because no temperature is solved for: -heat_theta", "because -contact_face_friction is 0, or no temperature is solved for: -contact_face_friction_heat_split",
      "because no damage is solved for: -damage_bounds", "because neither damage nor a temperature is solved for: -coupling_snes_max_it -coupling_error",
      "because -material_lower_c_v is not given, and no temperature is solved for: -material_lower_conduction"], []),
    ("data of laws that a material does not have", FILE + DRY + ["-material_lower_damage", "none", "-material_upper_sigma_y", "1", "-material_upper_hardening", "linear",
      "-material_upper_linear_h", "1", "-material_lower_alpha_t", "1e-5"], 0,
     ["impact: without effect, because -material_upper_model is elastic: -material_upper_sigma_y -material_upper_hardening -material_upper_linear_h\n",
      "impact: without effect, because -material_lower_c_v is not given, and no temperature is solved for: -material_lower_alpha_t\n",
      "impact: without effect, because -material_lower_damage is none: -material_lower_Gc -material_lower_gamma\n"], []),
    ("data of damage without a rate, fatigue, flow and heat", FILE + DRY + ["-material_lower_zeta", "2", "-material_lower_delta", "0.1", "-material_lower_cubic_s", "0.1",
      "-material_lower_alpha_c", "1", "-material_lower_visc_degrade", "on", "-material_lower_gp", "ge", "-material_lower_fatigue_kappa", "1",
      "-material_lower_fatigue_threshold", "1", "-material_lower_gtheta", "one", "-coupling_theta_tol", "0.1"], 0,
     [f"without effect, because {why}: -material_lower_{what}" for why, what in (
         ("-material_lower_c is inf, damage without a rate", "zeta -material_lower_delta"), ("-material_lower_ge is not cubic", "cubic_s"),
         ("-material_lower_ge is not ductile", "alpha_c"), ("-material_lower_b_d is 0", "visc_degrade"), ("-material_lower_model is not j2", "gp"),
         ("-material_lower_fatigue is not logarithmic", "fatigue_kappa"), ("-material_lower_fatigue is not asymptotic or logarithmic", "fatigue_threshold"),
         ("-material_lower_c_v is not given, and no temperature is solved for", "gtheta"))]
     + ["because no temperature is solved for: -coupling_theta_tol"], []),
    ("what only goes with another option", FILE + DRY + ["-walltime_margin", "5", "-mesh_cells", "10", "-ts_substeps", "10", "-ts_times", "0,1", "-ts_dts", "0.5"], 0,
     ["because -walltime is not given: -walltime_margin", "because -dm_refine is not given: -mesh_cells", "because -ts_dts has the steps: -ts_dt",
      "because neither -damage_ts_dt nor -heat_ts_dt is given: -ts_substeps"], []),
    ("data of augmentations and impacts", FILE + DRY + ["-contact_face_enforce", "semismooth", "-contact_face_gap_tol", "1e-5", "-contact_face_penalty_growth", "always",
      "-contact_face_impact", "stabilised", "-ts_type", "static"], 0,
     ["because nothing is augmented: -contact_face_penalty_growth -contact_face_gap_tol", "because nothing has inertia: -contact_face_impact"], []),
    ("what a file asks for, taken back", FILE + DRY + ["-ts_path_length", "none", "-ts_period", "none", "-walltime", "none", "-damage_ts_dt", "none",
      "-heat_ts_dt", "none", "-ts_mass_scaling_dt", "none", "-material_lower_Gc_rate", "none"], 0, ["the input is complete"], ["\n-walltime ", "none\n-ts_path", "-ts_period"]),
    ("damage without a rate, divided by it", FILE + DRY + ["-damage_form", "divided"], 2,
     ["divides by a rate", "give each material that damages a finite -material_<id>_c"], []),
    ("a shortest step above the steps", FILE + DRY + ["-ts_adapt_dt_min", "1e9"], 2, ['-ts_adapt_dt_min "1e+09": is longer than the longest step, 0.01, '], []),
    ("the same, asked to be strict", FILE + DRY + ["-material_upper_sigma_y", "1", "-options_strict"], 2,
     ["without effect, because -material_upper_model is elastic: -material_upper_sigma_y (-options_strict)"], []),
    ("damage where no material has any", FILE + DRY + ["-material_lower_damage", "none", "-ics", "a", "-ic_a_on", "upper", "-ic_a_phi", "1"], 2,
     ["-ic_a_phi: damages nothing, for no material has damage; give -material_lower_damage, or remove it"], []),
    ("a value that begins with a minus", FILE + DRY + ["-bc_push_ux", "-t*2"], 2, ["unknown option -t*2; a value that begins with a minus needs brackets: (-t*2)"], []),
    ("an id that no list ever had", FILE + DRY + ["-probe_b_at", "0,0"], 2, ["unknown option -probe_b_at; did you mean -probe_a_at?"], []),
]
# Contact in static pressure of 1000 per length: what probes and measures say on its surface.
PRESS = {**{key: value for key, value in BLOCKS.items() if not key.startswith(("output", "probe", "ts_", "bc_push", "material_lower_d",
         "material_lower_G", "material_lower_ga", "material_upper_"))}, "mesh_set_gap": 0, "material_lower_E": "2 MPa", "material_upper_like": "lower",
         "material_lower_nu": 0, "bcs": "hold,push", "bc_push_on": "upper_top", "bc_push_type": "pressure", "bc_push_value": "1000*t",
         "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "probes": "a", "probe_a_at": "0.4,1", "probe_a_on": "upper",
         "probe_a_fields": "contact_pressure,contact_gap,contact_traction,contact_slip", "measures": "m,g", "measure_m_on": "upper_bottom",
         "measure_m_fields": "contact_pressure,contact_slip", "measure_m_of": "max", "measure_g_on": "upper", "measure_g_fields": "contact_gap"}
r = run("press", PRESS)
for column in ("probe_a_contact_pressure", "measure_m_contact_pressure"):
    check(column, r[column][-1], 1000, 2e-3)
check("the gap, by the height of the blocks", max(abs(r["probe_a_contact_gap"][-1]), abs(r["measure_g_contact_gap"][-1])), 0, 1e-6, relative=False)
require("traction and slip have components", "probe_a_contact_tractionx" in r.history and "measure_m_contact_slipy" in r.history)

# A force on points, and on an edge in space: the reaction is its opposite, on one rank and two.
SQUARE = "Point(1) = {0, 0, 0}; Extrude{1, 0, 0}{ Point{1}; Layers{3}; } Extrude{0, 1, 0}{ Line{1}; Layers{3}; Recombine; }\n"
with open("points.geo", "w") as file:
    file.write(SQUARE + 'Physical Surface("solid") = {5}; Physical Curve("bottom") = {1}; Physical Point("on") = {3, 4};\n')
with open("edge.geo", "w") as file:
    file.write(SQUARE + "o[] = Extrude{0, 0, 1}{ Surface{5}; Layers{3}; Recombine; };\n"
               'Physical Volume("solid") = {1}; Physical Surface("bottom") = {5}; Physical Curve("on") = {7};\n')
FORCE = {"materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3, "bcs": "hold,load", "bc_hold_on": "bottom", "bc_hold_type": "fix",
         "bc_load_on": "on", "bc_load_type": "force", "bc_load_uy": "-1000*t", "bc_load_ux": "300*t", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
# A point between cells: the value of a cell is that of the same one on any number of ranks.
BETWEEN = {"mesh": mesh("block.geo"), "mesh_set_n": 4, "materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3, "bcs": "hold,push",
           "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_push_on": "top", "bc_push_ux": 0, "bc_push_uy": "(-0.1*t)", "ts_type": "static", "ts_dt": 1,
           "ts_max_time": 1, "probes": "a,b,c", **{f"probe_{name}_{key}": value for name, place in (("a", "0.5,0.9"), ("b", "0.5,0.5"), ("c", "0.6,0.75"))
                                                   for key, value in (("at", place), ("fields", "stress"))}}
one, two = (run(f"between_{ranks}", BETWEEN, ranks=ranks) for ranks in (1, 2))
for name in "abc":
    check(f"stress at a point between cells, {name}: on two ranks", two[f"probe_{name}_stress_yy"][-1], one[f"probe_{name}_stress_yy"][-1], 1e-9)

for name, ranks, more in (("points", 1, {"thickness": 50}), ("edge", 2, {}), ("points", 1, {}), ("points", 2, {}), ("edge", 1, {}))[: 5 if long() else 2]:
    r = run(f"{name}_{ranks}", {**FORCE, "mesh": f"{name}.geo", **more}, ranks=ranks)
    check(f"force on {name} {more}, {ranks} ranks: reaction along y", r["reaction_hold_y"][-1], 1000, 1e-8)
    check(f"force on {name} {more}, {ranks} ranks: reaction along x", r["reaction_hold_x"][-1], -300, 1e-8)
# On a boundary it is the total too, of all of the thickness and of the whole ring.
for name, more in (("a sheet", {"plane": "stress", "thickness": 0.1}), ("a thick plate", {"thickness": 50}), ("a ring", {"plane": "axisymmetric"}),
                   ("a ring of second order", {"plane": "axisymmetric", "order": 2})):
    r = run("total", {**FORCE, "mesh": mesh("block.geo"), "bc_load_on": "top", "bc_load_ux": 0, **more})
    check(f"force on {name}: reaction", r["reaction_hold_y"][-1], 1000, 1e-8)
    require(f"force on {name}: nodes that nothing holds on an axis are told", ("nodes on the axis of symmetry may leave it" in r.log) == ("ring" in name))

# A hardening modulus of 0 that is given is perfect plasticity.
PERFECT = {**{key: value for key, value in FORCE.items() if not key.startswith(("bc_load", "bcs"))}, "mesh": "points.geo", "bcs": "hold",
           "material_solid_model": "j2", "material_solid_sigma_y": 1e3, "material_solid_hardening": "linear", "material_solid_linear_h": 0}
require("hardening linear with 0 given", run("perfect", {**PERFECT, "dry_run": "on"}).code == 0)
del PERFECT["material_solid_linear_h"]
require("and without it is refused", "-material_solid_linear_h: missing" in run("missing", {**PERFECT, "dry_run": "on"}, code=2).log)

# The one step of a run whose -ts_dt lies far behind its end ends there; a place in the plane has no z.
LAST = {**{key: value for key, value in PERFECT.items() if not key.startswith("material_solid")}, "mesh": mesh("block.geo"), "material_solid_E": 1e6,
        "material_solid_nu": 0.3, "bcs": "hold,pull", "bc_hold_on": "left", "bc_pull_on": "right", "bc_pull_ux": "0.01*t", "ts_type": "static", "ts_max_time": 1}
check("a step of 1e19 of a run of 1", run("far", {**LAST, "ts_dt": 1e19})["time"][-1], 1, 1e-12)
require("a probe in the plane with a z", "the mesh is in the plane and has no z; allowed: x,y" in run(
    "z", {**LAST, "ts_dt": 1, "probes": "p", "probe_p_at": "0.5,0.5,0.3"}, code=3).log)
# What F-bar's balance misses is said to be its own.
PRESSED = {**LAST, "units": "mm_t_s_MPa", "material_solid_E": None, "material_solid_nu": None, "material_solid_K": 1000, "material_solid_G": 1, "material_solid_locking": "fbar",
           "mesh_set_n": 8, "bcs": "left,bottom,pull", "bc_left_on": "left", "bc_left_ux": 0, "bc_bottom_on": "bottom", "bc_bottom_uy": 0,
           "bc_pull_on": "top", "bc_pull_ux": 0, "bc_pull_uy": "(-0.4*t)", "ts_dt": 0.05}
PRESSED = {key: value for key, value in PRESSED.items() if value is not None and not key.startswith("bc_hold")}
said = run("fbar", PRESSED, refused=None)
require(f"F-bar under large strains, first law {said['balance_first_law'][-1]:.2f}", "_locking fbar have no energy" in said.log)

for claim, words, status, there, absent in ROWS:
    done = subprocess.run([PROGRAM] + words + ["-output_dir", "said"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env=ENVIRONMENT)
    missing = [word for word in there if word not in done.stdout] + [word for word in absent if word in done.stdout]
    require(f"{claim}: status {done.returncode}, {missing or 'all words'}", done.returncode == status and not missing)

# Dual functions press what a ball has not reached; a static run that begins with moved nodes snaps nowhere.
r = run("dual_ball", {"mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 4, "mesh_set_nz": 2, "materials": "solid", "material_solid_E": 1e6,
                      "material_solid_nu": 0.3, "bcs": "hold", "bc_hold_on": "back", "bc_hold_type": "fix", "contacts": "ball",
                      "contact_ball_secondary": "front", "contact_ball_primary": "rigid_sphere", "contact_ball_centre": "0.5,0.5,2",
                      "contact_ball_radius": 1, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1})
require("dual multipliers beside a ball that only touches", "by 0.0102 at the start" in r.log and "-contact_ball_multipliers standard" in r.log)
r = run("jump", {"mesh": mesh("block.geo"), "mesh_set_n": 50, "mesh_set_ny": 1, "mesh_set_ly": 0.002, "order": 2, "plane": "stress", "materials": "solid", "material_solid_E": 2e11,
                 "material_solid_nu": 0.3, "bcs": "left,right", "bc_left_on": "left", "bc_left_type": "fix", "bc_right_on": "right", "bc_right_ux": 0.001,
                 "bc_right_uy": 0, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1})
require("a displacement that is there at once", "-bc_right_ux, which is not 0 at the start" in r.log and "snapped" not in r.log)
finish()
