# labels: run
# timeout: 120
"""Strip rolling in the plane, static, with friction and the default contact: roll force and torque are those of von Karman's slab
theory, each step goes as far as it may, the strip that the roll has let go keeps its forces at nought and stays where it is."""
import numpy
from _runs import check, check_between, finish, require, run

with open("roll.geo", "w") as out:
    out.write("""DefineConstant[L = 20, m = 80, back = 0.3];
Point(1) = {-L*back, 0, 0}; Point(2) = {L*(1 - back), 0, 0}; Point(3) = {L*(1 - back), 1, 0}; Point(4) = {-L*back, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = m + 1; Transfinite Curve {2, 4} = 6; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("strip") = {1}; Physical Curve("top") = {3}; Physical Curve("middle") = {1};
""")
R, THICK, THIN, MU, YIELD = 50, 2, 1.6, 0.1, 200
ROLL = {"units": "mm_t_s_MPa", "mesh": "roll.geo", "materials": "strip", "material_strip_model": "j2", "material_strip_E": 70000,
        "material_strip_nu": 0.33, "material_strip_sigma_y": YIELD, "material_strip_hardening": "linear", "material_strip_linear_h": 1,
        "bcs": "middle", "bc_middle_on": "middle", "bc_middle_uy": 0, "contacts": "roll", "contact_roll_secondary": "top",
        "contact_roll_primary": "rigid_cylinder", "contact_roll_centre": f"0,{R + 1}", "contact_roll_radius": R,
        "contact_roll_rigid_mass": 1e-3, "contact_roll_rigid_ux": 0, "contact_roll_rigid_uy": "(-0.2*min(t,1))",
        "contact_roll_rigid_rz": "0.3*max(0,t-1)", "contact_roll_friction": MU, "ts_type": "static", "ts_dts": "0.05,0.01"}


def slab():
    """Force and torque of a roll: d(h (p - k))/dphi = 2 R p (sin phi -+ mu cos phi) from both ends, k = 2 Y/sqrt 3."""
    k, phi = 2 * YIELD / 3**0.5, numpy.linspace(0, numpy.arccos(1 - (THICK - THIN) / (2 * R)), 4001)
    h, step = THIN + 2 * R * (1 - numpy.cos(phi)), phi[1]
    def pressures(places, sign):
        p, q = numpy.empty_like(phi), 0.0
        for last, i in zip([None, *places], places):
            if last is not None:
                q += (phi[i] - phi[last]) * 2 * R * p[last] * (numpy.sin(phi[last]) + sign * MU * numpy.cos(phi[last]))
            p[i] = q / h[i] + k
        return p
    out, into = pressures(range(4001), 1), pressures(range(4000, -1, -1), -1)
    p, side = numpy.minimum(out, into), numpy.where(out < into, -1, 1)
    return (p * R * (numpy.cos(phi) + side * MU * numpy.sin(phi))).sum() * step, (side * MU * p * R * R).sum() * step


force, torque = slab()
print(f"slab theory: force {force:.1f} N/mm, torque {torque:.1f} N")
r = run("strip", {**ROLL, "ts_times": "0,1,1.16", "ts_max_time": 1.16}, refused=None)
steady = r["time"] > 1.12
check("roll force, the mean over a cell and more", -r["contact_roll_force_y"][steady].mean(), force, 0.08)
check("torque", abs(r["moment_obstacle_roll_z"][steady].mean()), torque, 0.03)
check_between("steps, 36 without a cut", len(r["time"]) - 1, 36, 48)

r = run("let_go", {**ROLL, "mesh_set_L": 12, "mesh_set_m": 48, "mesh_set_back": 0.1, "ts_times": "0,1,1.6", "ts_max_time": 1.6}, refused=None)
free = r["contact_roll_active"] == 0
free[r["time"] < 1] = False
check("let go: largest force", abs(r["contact_roll_force_y"][free]).max(), 0, 1e-6, relative=False)
check("way from there on", r["mean_middle_ux"][-1] - r["mean_middle_ux"][free][0], 0, 1e-9, relative=False)
require("and that is said", "nothing holds the bodies that contact alone holds" in r.log)
check_between("steps, 80 without a cut", len(r["time"]) - 1, 80, 100)
finish()
