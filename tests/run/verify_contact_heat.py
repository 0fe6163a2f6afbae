# labels: run
# timeout: 300
# long: 200
# processors: 1
"""Heat across contacts. Two pressed blocks of non-matching meshes conduct the flux of three resistances in a row and
jump by flux over conductance, uniformly with mortar; well joined they heat up as one body; a rigid wall takes and gives;
what touches without pressure conducts too, whatever presses, and where no motion is solved; a sliding block turns its work into heat, in the parts of the split, and the first law closes to rounding."""
import numpy
from _press import press
from _runs import check, check_between, finish, long, mesh, require, run

E, NU, PRESS, K, H = 1e6, 0.3, 0.02, 3.0, 7.0
HOT, COLD = 400.0, 300.0


def bars(dim, lower, upper, turned=False):
    """Both unit blocks pressed together uniformly; the plates keep their temperatures. Steady: hardly any capacity."""
    a, force = press(E, NU, 1 - PRESS, dim=dim)
    side = {"ux": f"{a - 1!r}*x*t"}
    if dim == 3:
        side["uz"] = f"{a - 1!r}*z*t"
    surfaces = ("upper_bottom", "lower_top") if turned else ("lower_top", "upper_bottom")
    return a, force / a ** (dim - 1), {
        "mesh": mesh("two_blocks.geo"), "mesh_set_dim": dim, "mesh_set_n_lower": lower, "mesh_set_n_upper": upper,
        "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": NU, "material_lower_conductivity": K,
        "material_lower_c_v": 1e-9, "material_lower_theta0": COLD, "material_upper_like": "lower",
        "bcs": "plate,press,cold,hot", "bc_plate_on": "lower_bottom", "bc_plate_uy": 0,
        "bc_press_on": "upper_top", "bc_press_uy": f"-{2 * PRESS!r}*t",
        **{f"bc_{bc}_{k}": v for bc in ("plate", "press") for k, v in side.items()},
        "bc_cold_on": "lower_bottom", "bc_cold_type": "temperature", "bc_cold_value": COLD,
        "bc_hot_on": "upper_top", "bc_hot_type": "temperature", "bc_hot_value": HOT,
        "contacts": "face", "contact_face_secondary": surfaces[0], "contact_face_primary": surfaces[1],
        "contact_face_method": "mortar", "contact_face_conductance": H,
        "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "heat_snes_rtol": 1e-13, "heat_ksp_rtol": 1e-12,
        "measures": ",".join(f"{s}{of}" for s in ("lower", "upper") for of in ("min", "max")),
        **{f"measure_{s}{of}_{k}": v for s, g in (("lower", "lower_top"), ("upper", "upper_bottom"))
           for of in ("min", "max") for k, v in (("on", g), ("fields", "theta"), ("of", of))}}


def steady(name, r, a, dim, h, tolerance, sign=1):
    """Against L/k + 1/h + L/k, all per reference area: J C^-1 = a^(dim-1)/b, contact a^(dim-1)."""
    area = a ** (dim - 1)
    flux = (HOT - COLD) / (2 * (1 - PRESS) / (K * area) + 1 / (h * area))
    faces = {s: [r[f"measure_{s}{of}_theta"][-1] for of in ("min", "max")] for s in ("lower", "upper")}
    check(f"{name}: flux", r["heat_hot"][-1], flux, tolerance)
    check(f"{name}: what flows in at the top flows out below", r["heat_cold"][-1] / r["heat_hot"][-1], -1, 1e-8)
    check(f"{name}: and through the contact", sign * r["heat_contact_face"][-1] / r["heat_hot"][-1], 1, 1e-8)
    check(f"{name}: jump is flux over conductance", faces["upper"][0] - faces["lower"][1], flux / (h * area), tolerance)
    check(f"{name}: scatter of the temperatures of a face", max(numpy.ptp(f) for f in faces.values()) / (HOT - COLD), 0,
          tolerance, relative=False)


for dim, lower, upper, turned, more in (
        (2, 5, 4, False, {}), (2, 3, 7, True, {"contact_face_multipliers": "dual"}), (3, 3, 2, False, {}),
        (2, 4, 3, False, {"order": 2}), (3, 2, 1, False, {"order": 2}),
        (3, 2, 3, False, {"mesh_set_simplices_upper": 1, "contact_face_multipliers": "standard"}))[slice(None) if long() else slice(1, 6, 2)]:
    a, pressure, base = bars(dim, lower, upper, turned)
    r = run(f"steady_{dim}_{lower}_{upper}", {**base, **more})
    steady(f"steady, {dim}D, {lower} on {upper} facets{', sides swapped' if turned else ''}", r, a, dim, H, 1e-8,
           -1 if turned else 1)

a, pressure, base = bars(2, 5, 4)
LAW = {"contact_face_conductance_exponent": 0.95, "contact_face_conductance_pressure": E}
for enforce in ("semismooth", "auglag", "penalty") if long() else ("semismooth",):
    r = run(f"law_{enforce}", {**base, **LAW, "contact_face_enforce": enforce})
    p = r["contact_face_pressure_max"][-1]
    steady(f"h (p/p_0)^m, {enforce}", r, a, 2, H * (p / E) ** 0.95, 1e-8 if enforce == "semismooth" else 2e-2)
    if enforce == "semismooth":
        check("its pressure is that of the closed form", p, pressure, 1e-8)
r = run("gpts", {**base, "contact_face_method": "gpts"})
steady("Gauss points, which do not pass the patch test", r, a, 2, H, 2e-2)
check_between("scatter is not rounding there, so that the test above can fail",
              r["measure_lowermax_theta"][-1] - r["measure_lowermin_theta"][-1], 1e-6, 1)
one = run("ranks_1", base)
for ranks in (2, 3) if long() else (2,):
    more = run(f"ranks_{ranks}", base, ranks=ranks)
    for column in ("heat_hot", "heat_contact_face", "measure_lowermin_theta"):
        check(f"{ranks} ranks: {column}", more[column][-1], one[column][-1], 1e-9)

# Places that touch and do not press: a pressure of rounding closed some of them, or none.
TOUCH = {**{k: v for k, v in bars(2, 5, 4)[2].items() if k != "contact_face_method"}, "bc_press_uy": 0, "bc_press_ux": 0, "bc_plate_ux": 0,
         "mesh_set_angle": 17, "ts_dt": 0.1}
FLUX = (HOT - COLD) / (2 / K + 1 / H)
for name, ranks, more in (("mortar", 1, {}), ("gpts", 1, {"contact_face_method": "gpts"}), ("auglag", 1, {"contact_face_enforce": "auglag"}),
                          ("penalty", 1, {"contact_face_enforce": "penalty"}), ("still", 1, {"physics": "heat"}),
                          ("still_unloaded", 1, {"physics": "heat", "bcs": "cold,hot", "material_lower_E": None, "material_lower_nu": None,
                                                 **{key: None for key in TOUCH if key.startswith(("bc_plate", "bc_press"))}}),
                          ("still_2", 2, {"physics": "heat", "contact_face_method": "gpts"}),
                          ("still_quadratic", 1, {"physics": "heat", "order": 2}),
                          ("still_space", 1, {"physics": "heat", "mesh_set_dim": 3, "mesh_set_angle": 0, "mesh_set_n_lower": 3}),
                          ("still_apart", 1, {"physics": "heat", "mesh_set_gap": 0.01, "contact_face_conductance_gap": 0.02})):
    r = run(f"touch_{name}", {key: value for key, value in {**TOUCH, **more}.items() if value is not None}, ranks=ranks)
    near = 1e-4 if "contact_face_method" in more else 1e-8  # Gauss points do not pass the patch test
    check(f"touching, {name}: heat of ten steps", r["heat_contact_face"][-1], FLUX, near)
    if "physics" in more:
        check(f"touching, {name}: first law over what flows through", abs(r["balance_first_law"]).max(), 0, 1e-9, relative=False)
    check(f"touching, {name}: of each step", numpy.diff(r["heat_contact_face"]).min(), FLUX / 10, near)
# From one rigid wall to another one, without a condition.
walls = run("touch_walls", {
    "physics": "heat", "mesh": mesh("block.geo"), "mesh_set_n": 3, "materials": "solid", "material_solid_c_v": 1e-9, "material_solid_theta0": COLD,
    "material_solid_conductivity": K, "contacts": "cold,hot", "contact_cold_secondary": "bottom", "contact_hot_secondary": "top",
    **{f"contact_{c}_{k}": v for c, point, theta in (("cold", "0,0", COLD), ("hot", "0,1", HOT)) for k, v in {
        "primary": "plane", "plane_point": point, "plane_normal": "0,1" if c == "cold" else "0,-1", "conductance": H, "temperature": theta}.items()},
    "ts_type": "static", "ts_dt": 1, "ts_max_time": 3, "heat_snes_rtol": 1e-13, "heat_ksp_rtol": 1e-12})
check("between two walls: heat of three steps", walls["heat_contact_hot"][-1], 3 * (HOT - COLD) / (1 / K + 2 / H), 1e-8)
check("between two walls: first law over what flows through", abs(walls["balance_first_law"]).max(), 0, 1e-9, relative=False)
apart = run("touch_not", {**TOUCH, "physics": "heat", "mesh_set_gap": 0.01})
check("apart: heat", apart["heat_contact_face"][-1], 0, 0, relative=False)
require("apart: told", "no heat passes" in apart.log and "the smallest gap is 0.01" in apart.log)
half = run("touch_restart", {**TOUCH, "physics": "heat", "material_lower_c_v": 1, "ts_max_time": 0.5})
half = run("touch_restart", {**TOUCH, "physics": "heat", "material_lower_c_v": 1, "restart": "auto"}, ranks=2)
whole = run("touch_whole", {**TOUCH, "physics": "heat", "material_lower_c_v": 1})
check("still, restarted on two ranks: heat", half["heat_contact_face"][-1], whole["heat_contact_face"][-1], 1e-9)

# Two blocks, well joined and heated from above, against the same heat in one bar of their length (matching meshes).
_, _, base = bars(2, 8, 8)
TIME = {"ts_dt": 0.01, "ts_max_time": 0.1, "ts_type": "static", "heat_form": "energy", "heat_snes_rtol": 1e-13}
still = {**{k: v for k, v in base.items() if not k.startswith(("measure", "bc_cold"))}, "bcs": "plate,press,hot",
         "bc_press_uy": "-1e-9", "bc_press_ux": 0, "bc_plate_ux": 0, "material_lower_c_v": 1,
         "bc_hot_value": f"{COLD}+4000*t", "contact_face_conductance": 1e4, **TIME,
         "probes": "p", "probe_p_at": "0.5,0.75", "probe_p_on": "lower", "probe_p_fields": "theta"}
joined = run("joined", still)
bar = run("bar", {
    "physics": "heat", "mesh": mesh("block.geo"), "mesh_set_n": 16, "mesh_set_ny": 1, "mesh_set_lx": 2,
    "materials": "solid", "material_solid_conductivity": K, "material_solid_c_v": 1, "material_solid_theta0": COLD,
    "bcs": "hot", "bc_hot_on": "right", "bc_hot_type": "temperature", "bc_hot_value": f"{COLD}+4000*t", **TIME,
    "probes": "p", "probe_p_at": "0.75,0.5", "probe_p_fields": "theta"})
check("perfect joint: warming of the cold block against one bar", abs(joined["probe_p_theta"] - bar["probe_p_theta"]).max(), 0,
      2e-2, relative=False)
check_between("which warmed", bar["probe_p_theta"][-1] - COLD, 10, 200)
check("perfect joint: first law", abs(joined["balance_first_law"]).max(), 0, 1e-10, relative=False)
produced = joined["entropy_produced"]
check_between("entropy produced in a step", numpy.diff(produced)[1:].min(), 1e-6, 1)
# What passes a resistance produces q^2/(h theta theta) there: more than without it in the same blocks.
loose = run("loose", {**still, "contact_face_conductance": 10})
check("loose joint: first law", abs(loose["balance_first_law"]).max(), 0, 1e-10, relative=False)
check_between("loose joint: heat that came through, over that of the perfect one",
              loose["heat_contact_face"][-1] / joined["heat_contact_face"][-1], 0.2, 0.8)
tight = run("insulated", {**still, "contact_face_conductance": 0})
check("insulated: the lower block stays as it is", tight["energy_thermal_lower"][-1], 0, 1e-8, relative=False)

# A block on a rigid wall of a temperature that changes: lumped by its conductivity, theta' = -h/(c L) (theta - T).
WALL = {
    "mesh": mesh("block.geo"), "mesh_set_n": 2, "materials": "block", "material_block_region": "solid",
    "material_block_E": E, "material_block_nu": 0, "material_block_c_v": 2, "material_block_conductivity": 1e6,
    "material_block_theta0": COLD, "bcs": "press", "bc_press_on": "top", "bc_press_uy": "-1e-4*t", "bc_press_ux": 0,
    "contacts": "wall", "contact_wall_secondary": "bottom", "contact_wall_primary": "plane", "contact_wall_conductance": H,
    "contact_wall_temperature": "350+10*t", "heat_theta": 0.5, "heat_form": "energy", "ts_type": "static", "ts_dt": 0.01,
    "ts_max_time": 0.2, "heat_snes_rtol": 1e-13}
theta, wall = COLD, lambda t: 350 + 10 * t
for n in range(20):  # 2 (theta_1 - theta_0)/dt = h ((T_0 + T_1)/2 - (theta_0 + theta_1)/2)
    mean = (wall(n * 0.01) + wall(n * 0.01 + 0.01)) / 2
    theta = (theta * (2 / 0.01 - H / 2) + H * mean) / (2 / 0.01 + H / 2)
for method in ("gpts", "mortar"):
    r = run(f"wall_{method}", {**WALL, "contact_wall_method": method})
    check(f"wall, {method}: temperature by the trapezoidal rule", r["theta_max"][-1], theta, 1e-6)
    check(f"wall, {method}: heat of the contact is that of the block", r["heat_contact_wall"][-1], r["energy_thermal"][-1], 1e-10)
    check(f"wall, {method}: which is supplied from outside", r["heat_supplied"][-1], r["heat_contact_wall"][-1], 1e-12)
    check(f"wall, {method}: first law", abs(r["balance_first_law"]).max(), 0, 1e-8, relative=False)

# A block slides on another one under a weight: what friction takes warms both, half and half, or as it is told.
MU, G, V, RHO = 0.3, 10.0, 0.5, 1000.0
SLIDE = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 4, "mesh_set_n_upper": 3, "mesh_set_inset": 0.1,
    "materials": "lower,upper", "material_lower_E": 1e8, "material_lower_nu": 0.3, "material_lower_rho": RHO,
    "material_lower_c_v": 5e3, "material_lower_conductivity": 1, "material_upper_like": "lower",
    "bcs": "hold,weight", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_weight_on": "upper",
    "bc_weight_type": "body_force", "bc_weight_uy": -G, "ics": "flight", "ic_flight_on": "upper", "ic_flight_vx": V,
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "contact_face_friction": MU, "ts_dt": 5e-3, "ts_max_time": 0.15, "heat_form": "energy", "heat_snes_rtol": 1e-13,
    "motion_snes_rtol": 1e-12,
    "measures": "place", "measure_place_on": "upper", "measure_place_fields": "u"}
for name, part, more in (("gpts", 0.5, {"contact_face_method": "gpts", "ts_newmark_rho": 0.9}),
                         ("mortar", 0.8, {"contact_face_method": "mortar", "contact_face_friction_heat_split": 0.8}),
                         ("penalty", 0.0, {"contact_face_enforce": "penalty", "contact_face_friction_heat_split": 0}),
                         ("conserving", 0.5, {"contact_face_impact": "conserving"}),
                         ("conducting", None, {"contact_face_method": "mortar", "contact_face_conductance": 1e3})):
    r = run(f"slide_{name}", {**SLIDE, **more}, ranks=2 if name == "mortar" else 1)
    warmed = {body: r[f"energy_thermal_{body}"] for body in ("lower", "upper")}
    lost = r["dissipated_friction"][-1]
    check_between(f"{name}: friction over mu g m v^2/(2 mu g)", lost / (RHO * 0.8 * V * V / 2), 0.8, 1.02)
    # What the stabilised forces take beyond friction and their own energy, 2 % of friction, counts as lost.
    stored = sum(r[c] for c in ("energy_kinetic", "energy_elastic", "energy_thermal", "energy_contact", "energy_numerical",
                                "dissipated_numerical", "dissipated_contact"))
    left = stored - r["work_external"] - r["heat_supplied"]
    check(f"{name}: first law over friction", abs(left - left[0]).max() / lost, 0, 1e-9, relative=False)
    if name != "conserving":
        check_between(f"{name}: what contact takes beyond friction, over friction", r["dissipated_contact"][-1] / lost, 0.01, 0.03)
    if part is not None:
        # The energy form takes what the waves of the weight's onset leave for heat too.
        check(f"{name}: part of the upper block", (warmed["upper"][-1] - warmed["upper"][0]) / lost, part, 2e-5, relative=False)
    check(f"{name}: heat of both is what friction took", (warmed["upper"] + warmed["lower"])[-1], lost, 2e-5)
    if part is None:
        require(f"{name}: heat goes to the colder side", abs(r["heat_contact_face"][-1]) > 1e-3 * lost)
    # But for what the steps of the waves take, whose losses change their sign at points (the energy form).
    check(f"{name}: no node is colder than the start", min(0, r["theta_min"].min() - 298.15), 0, 2e-6, relative=False)
    check(f"{name}: entropy is produced", min(0, numpy.diff(r["entropy_produced"]).min()), 0, 1e-12, relative=False)
require("hottest at the surface that slides", r["theta_max"][-1] > 298.15 + lost / 5e3)

# Messages.
for name, change, text in (
        ("no_capacity", {"material_lower_c_v": None}, "-contact_face_conductance"),
        ("still_pressure", {"contact_face_conductance_exponent": 1, "contact_face_conductance_pressure": 1, "physics": "heat"},
         "-contact_face_conductance_exponent: bodies that stay where they are do not press"),
        ("no_pressure", {"contact_face_conductance_exponent": 1}, "-contact_face_conductance_pressure: missing"),
        ("own_temperature", {"contact_face_temperature": 300}, "-contact_face_temperature"),
        ("no_temperature", {"contact_face_primary": "plane"}, "-contact_face_temperature: missing")):
    _, _, base = bars(2, 2, 2)
    words = {**base, **change}
    if change.get("material_lower_c_v", 0) is None:
        words = {k: v for k, v in words.items() if v is not None and "cold" not in k and "hot" not in k and "measure" not in k}
        words["bcs"] = "plate,press"
    r = run(name, words, code=2)
    require(f"refused, {name}: one line that names the option", sum(text in line for line in r.log.splitlines()) == 1)
finish()
