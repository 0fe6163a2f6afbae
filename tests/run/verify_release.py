# labels: run
# timeout: 120
# long: 200
"""Energy release rates of cracks at rest, in rings of two sizes: a slit in a long strip between grips against the energy that the strip
has by length (Rice, J. Appl. Mech. 35, 1968), and a crack that a wave of tension meets against Freund's
K = 2 s/(1 - nu) sqrt((1 - 2 nu) c_d t/pi) (Dynamic Fracture Mechanics, 1990), in explicit and in Newmark's steps. A penny-shaped crack in
the section of a cylinder and in space, its front met by a ball within the body and by half of one, against K = 2 s sqrt(a/pi) (Sneddon, Proc.
R. Soc. A 187, 1946)."""
import math

import numpy
from _runs import check, finish, long, mesh, run

E, NU, RHO = 210e9, 0.3, 8000
PLATE = {"mesh": mesh("edge_crack.geo"), "materials": "plate", "material_plate_E": E, "material_plate_nu": NU, "bcs": "up,down",
         "bc_up_on": "top", "bc_down_on": "bottom", "bc_down_uy": 0, "releases": "near,wide", "release_near_inner": 0.05, "release_near_outer": 0.2,
         "release_wide_inner": 0.2, "release_wide_outer": 0.6}


def intensity(r, ring):
    """sqrt(G E/(1 - nu^2)) of each row."""
    return numpy.sqrt(numpy.abs(r["release_" + ring]) * E / (1 - NU**2))


modulus = E * (1 - NU) / ((1 + NU) * (1 - 2 * NU))
GRIPS = {**PLATE, "mesh_set_width": 10, "mesh_set_height": 2, "mesh_set_n": 200, "bc_up_ux": 0, "bc_up_uy": 1e-5, "bc_down_ux": 0,
         "release_near_at": "5,1", "release_wide_at": "5,1", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
# The cells at the tip miss a part of it that goes with their size.
for n, order, part in ((100, 1, 8e-3), (200, 1, 4e-3), (200, 2, 4e-3))[: 3 if long() else 1]:
    r = run("grips", {**GRIPS, "mesh_set_n": n, "order": order})
    for ring in ("near", "wide") if n > 100 else ("wide",):
        check(f"a strip between grips, {n} cells of order {order}, {ring} ring: G over the energy by length",
              r["release_" + ring][-1] / (modulus * 1e-5**2 / (2 * 2)), 1, part)

# A long slit in a strip whose upper side is pulled at once: until the wave has come back to the tip the plane is without an end.
S = 50e6
speed = math.sqrt(modulus / RHO)
arrival = 2 / speed
WAVE = {**PLATE, "mesh_set_width": 10, "mesh_set_height": 4, "mesh_set_n": 200, "material_plate_rho": RHO, "bc_up_type": "traction", "bc_up_uy": S,
        "release_near_at": "5,2", "release_wide_at": "5,2", "ts_max_time": 2.6 * arrival}
STEPS = {"explicit": {"ts_type": "central_difference", "ts_dt": "auto"}, "implicit": {"ts_dt": 4e-6, "ts_newmark_rho": 0.8}}
for name, more in list(STEPS.items())[: 2 if long() else 1]:
    r = run(name, {**WAVE, **more})
    for since in (1.5, 2, 2.5):
        row = abs(r["time"] - since * arrival).argmin()
        after = r["time"][row] - arrival
        exact = 2 * S / (1 - NU) * math.sqrt((1 - 2 * NU) * speed * after / math.pi)
        for ring in ("near", "wide"):
            check(f"{name}, {since} times the arrival, {ring} ring: K over Freund's", intensity(r, ring)[max(row - 4, 0):row + 5].mean() / exact, 1, 0.01)

# What the advance leaves in its place: a temperature in a strip four times as long as wide, whose ends stay level (Wilson and Yu, Int. J.
# Fracture 15, 1979: K = 0.5 E alpha T sqrt(pi a)/(1 - nu)), a graded stiffness,
# a weight.
ALONG = {**PLATE, "mesh_set_width": 1, "mesh_set_height": 4, "mesh_set_n": 40, "bc_up_uy": 0, "bc_down_ux": 0, "release_near_at": "0.5,2", "release_wide_at": "0.5,2",
         "release_near_outer": 0.15, "release_wide_outer": 0.45, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
warm = run("warm", {**ALONG, "order": 2, "material_plate_alpha_t": 1e-5, "material_plate_c_v": 3.6e6, "heat_form": "energy", "physics": "motion,heat", "bcs": "up,down,heat",
                    "bc_heat_on": "plate", "bc_heat_type": "temperature", "bc_heat_value": "298.15+20*(x-0.5)"})
for ring in ("near", "wide"):
    check(f"a crack under a gradient of temperature, {ring} ring: K over that of Wilson and Yu", intensity(warm, ring)[-1] / (0.5 * E * 1e-5 * 10 / (1 - NU) * math.sqrt(math.pi / 2)), 1, 6e-3)
for name, more in (("graded", {"bc_up_uy": 1e-3, "material_plate_E_factor": "exp(2*x-1)"}),
                   ("weight", {"material_plate_rho": RHO, "bcs": "up,down,weight", "bc_up_uy": 1e-6, "bc_weight_on": "plate", "bc_weight_type": "body_force", "bc_weight_ux": 100})):
    r = run(name, {**ALONG, **more})
    check(f"{name}: wide over near ring", r["release_wide"][-1] / r["release_near"][-1], 1, 2e-3)

# A ring that meets the sides of the strip, which stay where they are.
r = run("beyond", {**ALONG, "bc_up_uy": 1e-3, "release_wide_inner": 0.3, "release_wide_outer": 0.8}, ranks=2)
check("a ring across the sides: over one within", r["release_wide"][-1] / r["release_near"][-1], 1, 2e-3)

# Half of the body, so half of G. The cells at the front miss a part of it that goes with their size.
PENNY = {"mesh": mesh("penny_crack.geo"), "order": 2, "materials": "body", "material_body_E": E, "material_body_nu": NU, "bc_ahead_on": "ahead", "bc_top_on": "top",
         "bc_top_type": "traction", "release_near_inner": 0.1, "release_near_outer": 0.3, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
exact = 4 * 1e6**2 * (1 - NU**2) / (math.pi * E) / 2
r = run("penny_section", {**PENNY, "plane": "axisymmetric", "bcs": "ahead,top,axis", "bc_ahead_uy": 0, "bc_top_uy": 1e6, "bc_axis_on": "axis", "bc_axis_ux": 0,
                          "releases": "near,wide", "release_near_at": "1,0", "release_wide_at": "1,0", "release_wide_inner": 0.3, "release_wide_outer": 0.8})
for ring in ("near", "wide"):
    check(f"penny-shaped crack, its section, {ring} ring: G over Sneddon's", r["release_" + ring][-1] / exact, 1, 4e-3)
r = run("penny_space", {**PENNY, "mesh_set_dim": 3, "mesh_set_h": 0.03, "bcs": "ahead,top,x,y", "bc_ahead_uz": 0, "bc_top_uz": 1e6, "bc_x_on": "x0", "bc_x_ux": 0, "bc_y_on": "y0",
                        "bc_y_uy": 0, "releases": "near,half", "release_near_at": "0.70710678,0.70710678,0", "release_near_along": "1,1,0", "release_half_at": "1,0,0",
                        "release_half_inner": 0.1, "release_half_outer": 0.3, "release_half_length": 0.2}, ranks=2)
for ring in ("near", "half"):
    check(f"penny-shaped crack in space, {ring} ball: G over Sneddon's", r["release_" + ring][-1] / exact, 1, 0.012)

# What presses the faces of a crack apart sets free what the same pull from afar does.
for load, more in (("pressure", {"bc_top_value": 1e6}), ("traction", {"bc_top_uy": 1e6})):
    r = run(f"penny_{load}", {**PENNY, "plane": "axisymmetric", "bcs": "ahead,top,axis", "bc_ahead_uy": 0, "bc_top_on": "face", "bc_top_type": load, **more, "bc_axis_on": "axis",
                              "bc_axis_ux": 0, "releases": "near,wide", "release_near_at": "1,0", "release_wide_at": "1,0", "release_wide_inner": 0.3, "release_wide_outer": 0.8})
    for ring in ("near", "wide"):
        check(f"penny-shaped crack under {load} on its faces, {ring} ring: G over Sneddon's", r["release_" + ring][-1] / exact, 1, 4e-3)
pressed = run("penny_space_pressure", {**PENNY, "mesh_set_dim": 3, "mesh_set_h": 0.03, "bcs": "ahead,top,x,y", "bc_ahead_uz": 0, "bc_top_on": "face", "bc_top_type": "pressure",
                                       "bc_top_value": 1e6, "bc_x_on": "x0", "bc_x_ux": 0, "bc_y_on": "y0", "bc_y_uy": 0, "releases": "near", "release_near_along": "1,1,0",
                                       "release_near_at": "0.70710678,0.70710678,0"}, ranks=2)
check("penny-shaped crack in space under pressure on its faces: G over Sneddon's", pressed["release_near"][-1] / exact, 1, 0.012)
finish()
