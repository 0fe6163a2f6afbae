# Cracks with a strength of their own: bars bear the strength asked for, whatever the length; the stress falls with the
# opening of the crack by the law that the degradation stands for, and the crack has cost G_c; in explicit steps too.
# labels: run
# timeout: 240
# long: 240
import math

import numpy

import _runs as runs

E, STRENGTH, GC, WIDTH = 30e3, 3.0, 0.1, 1.0  # MPa, N/mm, mm: E G_c/f_t^2 = 333 mm
BAR = {"units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_ly": WIDTH, "materials": "solid", "material_solid_E": E,
       "material_solid_strength": STRENGTH, "material_solid_Gc": GC, "material_solid_residual_stiffness": 0}
LAWS = {"linear": "wu", "exponential": "wu", "cornelissen": "wu", "lorentz": "at1"}


def law(ge, gamma):
    return {"material_solid_damage": LAWS[ge], "material_solid_ge": ge, "material_solid_gamma": gamma}


# A cell under uniaxial stress, by steps of 5e-4 of the strength around it; in space with the split that leaves the lateral
# contraction out of what drives damage.
CELL = {**BAR, "ts_type": "static", "mesh_set_n": 1, "material_solid_nu": 0.2, "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0,
        "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right", "bc_pull_ux": f"{STRENGTH / E}*(0.99 + 0.04*t)",
        "ts_dt": 0.0125, "ts_max_time": 1}
SHEET = {"plane": "stress"}
SPACE = {"mesh_set_dim": 3, "bcs": "x,y,z,pull", "bc_z_on": "back", "bc_z_uz": 0, "material_solid_split": "spectral"}
for ge in LAWS:
    for gamma in (10, 40) if runs.long() else (10,):
        for name, frame in (("sheet", SHEET), ("space", SPACE)) if ge == "linear" else (("sheet", SHEET),):
            force = runs.run(f"strength_{ge}_{gamma}_{name}", {**CELL, **law(ge, gamma), **frame})["reaction_pull_x"][1:]
            runs.check(f"{ge}, gamma {gamma}, {name}: strength of a bar", force.max(), STRENGTH, 1e-3)
            runs.require(f"{ge}, gamma {gamma}, {name}: softens behind it", force[-1] < 0.9995 * force.max())

# Drucker and Prager's split: the strengths in tension and in compression, under pressure that of the cone, and none of what is
# broken.
RATIO, SMALL = 2.5, 0.3
CONE = {**SPACE, "material_solid_split": "drucker_prager", "material_solid_strength_ratio": RATIO, "material_solid_strength": SMALL}
B = (RATIO - 1) / (RATIO + 1) / math.sqrt(3)
PRESS = {"bcs": "x,y,z,pull,side,face", "bc_side_on": "top", "bc_side_type": "pressure", "bc_side_value": 2 * SMALL, "bc_face_on": "front",
         "bc_face_type": "pressure", "bc_face_value": 2 * SMALL}
# Pressed from the side with p the axial strength is that of sqrt(J_2) + B I_1 = its value in tension.
pressed = -(SMALL * (1 / math.sqrt(3) + B) + 2 * SMALL * (2 * B + 1 / math.sqrt(3))) / (1 / math.sqrt(3) - B)
for name, strength, more in (("tension", SMALL, {}), ("compression", -RATIO * SMALL, {}), ("compression and pressure from the sides", pressed, PRESS)):
    # The sides' pressure shortens or lengthens the bar by nu; 4 % around the strength.
    lateral = 2 * 0.2 * 2 * SMALL / E if more else 0
    run = runs.run(f"cone_{name.replace(' ', '_')}", {**CELL, **law("linear", 1000), **CONE, **more, "coupling_snes_atol": 1e-9,
                                                      "bc_pull_ux": f"{strength / E}*(0.98 + 0.04*t) + {lateral}"})
    force, sound = run["reaction_pull_x"][1:] / strength, run["phi_max"][1:] < 1e-9
    runs.require(f"drucker_prager, {name}: sound at first, damaged at last", sound[0] and not sound[-1])
    runs.check(f"drucker_prager: strength in {name}", force[sound].max(), 1, 1e-3)

# The spectral split leaves the lateral contraction whole: with a large nu and a small gamma a bar hardens before it softens.
NU, SHORT = 0.3, 2.5
lame, shear = E * NU / ((1 + NU) * (1 - 2 * NU)), E / 2 / (1 + NU)
limit = STRENGTH**2 / (2 * E) * (1 + NU * (1 - 2 * NU)) / (1 + NU)
a1 = 2 / math.pi * GC / SHORT / limit
phi = numpy.linspace(0, 0.2, 20001)
free, soft = (1 - phi)**2, a1 * phi * (1 - phi / 2)
g, fall = free / (free + soft), a1 * (1 - phi) / (free + soft)**2
strain = numpy.sqrt(limit * a1 * (1 - phi) / fall / (lame / 2 / (1 + lame / shear * g)**2 + shear))
stress = g * strain * (lame / (1 + lame / shear * g) + 2 * shear)
far = 1.5 * strain[stress.argmax()]
run = runs.run("hardens", {**CELL, **law("linear", SHORT), **SPACE, "material_solid_nu": NU, "coupling_snes_atol": 1e-7,
                           "bc_pull_ux": f"{0.99 * STRENGTH / E}+{far - 0.99 * STRENGTH / E}*t"})
runs.check(f"spectral split, nu {NU}, gamma {SHORT}: what a bar bears, over the strength", run["reaction_pull_x"][1:].max() / STRENGTH,
           stress.max() / STRENGTH, 1e-3)


def softening(ge):
    """Openings over G_c/f_t and stresses over f_t: the localised solution of a bar by quadrature (theory.md, (56'''))."""
    p, a2, a3 = {"linear": (2, -0.5, 0), "exponential": (2.5, 2**(5 / 3) - 3, 0), "cornelissen": (2, 1.3868, 0.6567),
                 "lorentz": (2, 1, 0)}[ge]
    start, c0 = (2, math.pi) if LAWS[ge] == "wu" else (1, 8 / 3)
    x, weight = numpy.polynomial.legendre.leggauss(400)
    t, top = (x + 1) / 2, numpy.linspace(1e-4, 0.9999, 2000)[:, None]
    local = lambda f: start * f + (1 - start) * f * f
    soft = lambda f: f * (1 + a2 * f + a2 * a3 * f * f) / (1 - f)**p
    stress = numpy.sqrt(local(top) / (start * soft(top)))
    phi = top * (1 - t * t)  # takes the square root at the top away
    flux = numpy.sqrt(local(phi) - start * stress**2 * soft(phi))
    return (4 * start * stress / c0 * (weight / 2 * soft(phi) / flux * 2 * t * top)).sum(axis=1), stress[:, 0]


# The curves against the formulas whose names they bear.
NAMED = {"linear": (lambda d: 1 - d / 2, 1e-4), "exponential": (lambda d: numpy.exp(-d), 3e-3),
         "cornelissen": (lambda d: (1 + 27 * (d / 5.1361)**3) * numpy.exp(-6.93 * d / 5.1361) - d / 5.1361 * 28 * math.exp(-6.93), 0.05)}
for ge, (formula, most) in NAMED.items():
    opening, stress = softening(ge)
    runs.check(f"{ge}: the curve against the formula of that name", abs(stress - formula(opening)).max(), 0, most, relative=False)

# Half a bar that breaks at its held end: behind the widest layer a body force takes a tenth of the strength off.
PER_GAMMA = 40


def pulled(name, ge, gamma, last, **more):
    """Pulled to an opening of `last` G_c/f_t: the run, openings and stresses in the broken part over G_c/f_t and f_t."""
    length, broad = 3 * gamma, {"wu": math.pi / 2, "at1": 2}[LAWS[ge]] * gamma
    relief, band = 0.1 * STRENGTH, 0.1 * gamma
    elastic = lambda stress: (stress * length - relief * (length - broad - band / 2)) / E
    start, end = elastic(STRENGTH), 0.5 * last * GC / STRENGTH + elastic(0)
    run = runs.run(name, {
        **BAR, **law(ge, gamma), "ts_type": "static", "plane": "stress", "mesh_set_n": 3 * PER_GAMMA, "mesh_set_ny": 1,
        "mesh_set_lx": length, "material_solid_nu": 0, "material_solid_rho": 1e-9, "bcs": "x,y,pull,relief", "bc_x_on": "left",
        "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right", "bc_pull_ux": f"{start}+{end - start}*t",
        "bc_relief_on": "solid", "bc_relief_type": "body_force",
        "bc_relief_ux": f"x>{broad} && x<{broad + band} ? {1e9 * relief / band} : 0", "coupling_snes_atol": 1e-6,
        "ts_dt": 0.05, "ts_max_time": 1, **more})
    stress = -run["reaction_x_x"][1:] / WIDTH
    opening = 2 * (start + (end - start) * run["time"][1:] - elastic(stress))
    return run, opening * STRENGTH / GC, stress / STRENGTH


for ge, gamma in runs.some((("linear", 10), ("linear", 2.5), ("exponential", 10), ("cornelissen", 10), ("lorentz", 10)), 2):
    curve = softening(ge)
    run, opening, stress = pulled(f"opening_{ge}_{gamma}", ge, gamma, numpy.interp(-0.1, -curve[1], curve[0]))
    worst = abs(stress - numpy.interp(opening, *curve)).max()
    runs.check(f"{ge}, gamma {gamma}: stress over opening against its law, over the strength", worst, 0, 0.01, relative=False)
# Broken for good: between G_c and that with the row of cells at the end, which would store w(1) G_c h/gamma.
for ge, w in runs.some((("linear", 1 / math.pi), ("lorentz", 3 / 8)), 2):
    run, opening, stress = pulled(f"broken_{ge}", ge, 10, 6)
    runs.check_between(f"{ge}: energy of a crack over G_c", run["energy_fracture"][-1] / (GC * WIDTH / 2), 1, 1 + 2 * w / PER_GAMMA)
    runs.check(f"{ge}: what a broken bar bears, over its strength", stress[-1], 0, 2e-3, relative=False)

# Explicit steps: a wave of 0.6 f_t doubles at the wall, where the bar breaks: with the opening 2 d, (1 - d f_t/G_c) f_t =
# 1.2 f_t - rho c d', so that it is open at tau ln 6 after the front has come, tau = rho c G_c/f_t^2.
RHO, FRACTURE, LENGTH = 2.4e-9, 0.02, 200.0
SPEED = math.sqrt(E / RHO)
front, tau = LENGTH / SPEED, RHO * SPEED * FRACTURE / STRENGTH**2
if runs.long():
    wave = runs.run("explicit", {
        **BAR, **law("linear", 2.5), "material_solid_Gc": FRACTURE, "ts_type": "central_difference", "plane": "stress", "mesh_set_n": 800,
        "mesh_set_ny": 1, "mesh_set_lx": LENGTH, "material_solid_nu": 0, "material_solid_rho": RHO, "bcs": "x,y,pull", "bc_x_on": "left",
        "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right", "bc_pull_type": "velocity",
        "bc_pull_ux": f"{0.6 * STRENGTH / (RHO * SPEED)}*min(1,t/{0.1 * tau})", "ts_max_time": front + 2.5 * tau, "outputs": "hist", "output_hist_type": "csv",
        "output_hist_every": 1})
    stress, time = -wave["reaction_x_x"] / WIDTH, wave["time"]
    runs.check("explicit: largest stress at the wall, over the strength", stress.max() / STRENGTH, 1, 0.02)
    for part in (0.75, 0.5, 0.25):
        when = time[numpy.nonzero(stress > part * STRENGTH)[0][-1]]
        runs.check(f"explicit: when it has fallen to {part} of the strength, over tau", (when - front) / tau,
                   math.log((1 - part) / 0.2 + 1), 0.09, relative=False)  # the row of cells at the wall adds 0.06 G_c
    runs.check_between("explicit: energy of the crack over G_c", wave["energy_fracture"][-1] / (FRACTURE * WIDTH / 2), 0.99, 1 + 2 / math.pi * 0.1)
    runs.check("explicit: balance", abs(wave["balance"]).max(), 0, 1e-12, relative=False)

# A length near the longest one, where iterates come closer by 0.92 each: steps were cut without end, none reached a third of the time.
struck = runs.run("struck", {
    "units": "mm_t_s_MPa", "mesh": runs.mesh("two_blocks.geo"), "mesh_set_n_lower": 6, "mesh_set_n_upper": 5, "mesh_set_gap": 0.01,
    "mesh_set_inset": 0.2, "mesh_set_simplices_lower": 1, "materials": "lower,upper", "material_lower_E": 1000, "material_lower_nu": 0.35,
    "material_lower_rho": 1.2e-9, "material_lower_Gc": 0.1, "material_lower_gamma": 0.2, "material_lower_damage": "wu",
    "material_lower_ge": "linear", "material_lower_strength": 8, "material_lower_split": "volumetric", "material_upper_E": 30000,
    "material_upper_nu": 0.35, "material_upper_rho": 7.8e-9, "contacts": "c", "contact_c_secondary": "upper_bottom",
    "contact_c_primary": "lower_top", "bcs": "b", "bc_b_on": "lower_bottom", "bc_b_type": "fix", "ics": "f", "ic_f_on": "upper",
    "ic_f_vx": "9 m/s", "ic_f_vy": "-30 m/s", "ts_type": "central_difference", "ts_max_time": 4e-6, "ts_max_steps": 400})
runs.check("struck by a block, gamma near its longest: time reached in 400 steps", struck["time"][-1], 4e-6, 1e-9)
runs.require("struck: it broke", struck["phi_max"][-1] > 0.9)
runs.finish()
