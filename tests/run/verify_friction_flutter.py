# labels: run
# timeout: 240
# long: 240
# processors: 1
"""An elastic layer that slides on a rough rigid plane takes up vibrations by Coulomb's law at any speed: explicit steps show the
growth that the eigenvalues of the semi-discrete layer have, which are found here without the program. A strip that is drawn over
such a plane slips by the shear lag of statics once it has the viscosity that a run without asks for at its end."""
import numpy
from _runs import check, check_between, finish, long, mesh, require, run

E, RHO, MU = 1e4, 1e-9, 0.3  # MPa, t/mm^3; Poisson's ratio 0, plane stress, height 1 mm
LAYER = {"units": "mm_t_s_MPa", "plane": "stress", "mesh": mesh("block.geo"), "mesh_set_ny": 1, "mesh_set_ly": 1,
         "materials": "solid", "material_solid_E": E, "material_solid_nu": 0, "material_solid_rho": RHO,
         "contacts": "base", "contact_base_secondary": "bottom", "contact_base_primary": "plane"}


def ramp(since, until):
    """From 0 to 1, smoothly."""
    return f"ramp(t,{since},{until})^2*(3-2*ramp(t,{since},{until}))"


def growth(n, length, penalty, friction):
    """Largest real part of the eigenvalues of n square cells with lumped mass that slide on springs along their lower side,
    at two Gauss points a facet: M u'' + (K + K_c) u = 0, K_c of the gaps and, in their proportion, of the friction."""
    h, g = length / n, 1 / numpy.sqrt(3)
    x, y = numpy.array([-1, 1, 1, -1]), numpy.array([-1, -1, 1, 1])
    cell = numpy.zeros((8, 8))
    for r in (-g, g):
        for s in (-g, g):
            B = numpy.zeros((3, 8))
            B[0, 0::2] = B[2, 1::2] = x * (1 + y * s) / (2 * h)
            B[1, 1::2] = B[2, 0::2] = y * (1 + x * r) / (2 * h)
            cell += B.T @ numpy.diag([E, E, E / 2]) @ B * h * h / 4
    K, M = numpy.zeros((4 * (n + 1), 4 * (n + 1))), numpy.zeros(4 * (n + 1))
    for i in range(n):
        nodes = [i, i + 1, n + 2 + i, n + 1 + i]
        dofs = numpy.array([[2 * a, 2 * a + 1] for a in nodes]).ravel()
        K[numpy.ix_(dofs, dofs)] += cell
        M[dofs] += RHO * h * h / 4
        along, across = [2 * i, 2 * i + 2], [2 * i + 1, 2 * i + 3]
        for r in (-g, g):
            N = numpy.array([(1 - r) / 2, (1 + r) / 2])
            spring = penalty * h / 2 * numpy.outer(N, N)
            K[numpy.ix_(across, across)] += spring
            K[numpy.ix_(along, across)] -= friction * spring
    # Roots come in pairs of either sign: numpy's have a real part that is not negative.
    return numpy.sqrt(-numpy.linalg.eigvals(K / M[:, None]).astype(complex)).real.max()


print("flutter of a layer that slides at 20 m/s under a traction in balance with its friction")
SLIDING = {**LAYER, "mesh_set_n": 20, "mesh_set_lx": 20, "contact_base_friction": MU, "bcs": "press", "bc_press_on": "top",
           "bc_press_type": "traction", "bc_press_uy": f"(-{ramp(0, 1e-4)})", "bc_press_ux": f"{MU}*{ramp(0, 1e-4)}", "ics": "go",
           "ic_go_on": "solid", "ic_go_vx": 20000, "ts_type": "central_difference", "ts_dt": "auto", "ts_max_time": 1.1e-4,
           "probes": "middle", "probe_middle_at": "10,0", "probe_middle_fields": "v"}
for penalty, first, last in ((5e3, 0.7e-4, 0.9e-4), (1e4, 0.45e-4, 0.6e-4)):
    r = run(f"layer_{penalty:g}", {**SLIDING, "contact_base_penalty": penalty, "ts_dt_cfl": 0.4})
    t, v = r["time"], numpy.abs(r["probe_middle_vy"])
    require("everything slides", r["contact_base_sliding"][t < last][-1] == 40)
    # Tops of the vibration, which is well above what the load brings then and opens nothing.
    early, late = (v[(t > since) & (t < since + 4e-6)].max() for since in (first, last))
    check(f"penalty {penalty:g}: growth of the vibration, 1/s", numpy.log(late / early) / (last - first),
          growth(20, 20, penalty, MU), 0.1)

print("a strip pressed by 1 MPa and drawn at its end by 15 N: shear lag F^2/(2 E A mu p), of which F^3/(6 E A mu p) is heat")
STRIP = {**LAYER, "mesh_set_n": 50, "mesh_set_lx": 100, "contact_base_friction": MU, "bcs": "press,pull", "bc_press_on": "top",
         "bc_press_type": "traction", "bc_press_uy": f"(-{ramp(0, 1e-3)})", "bc_pull_on": "right", "bc_pull_type": "traction",
         "bc_pull_ux": f"15*{ramp(1e-3, 2e-3)}", "ts_type": "central_difference", "ts_dt": "auto", "ts_max_time": 2e-3,
         "outputs": "hist", "output_hist_type": "csv", "output_hist_every": 100}
SLIP, HEAT = 15**2 / (2 * E * MU), 15**3 / (6 * E * MU)
TOLD = "contact base: what pressed opened and closed again"
VISCOUS = {"material_solid_b_d": MU / 5 * numpy.sqrt(E * RHO)}
for what, more in (("penalty", {}), ("impulses", {"contact_base_enforce": "impulse"})):
    r = run(f"strip_{what}", {**STRIP, **VISCOUS, **more})
    check(f"{what}, with the viscosity that is told: slip of the end, mm", r["mean_pull_ux"][-1], SLIP, 0.01)
    check("heat of friction and loss of viscosity, mJ", r["dissipated_friction"][-1] + r["dissipated_viscous"][-1], HEAT, 0.015)
    require("nothing is said of flutter", TOLD not in r.log)
r = run("strip_alone", {**STRIP, "output_hist_every": 1})  # what the integrator may give is told by the lengths of all steps
check_between("without: it slips farther", r["mean_pull_ux"][-1] / SLIP, 1.5, 4)
require("and that is said", TOLD in r.log and "-material_<id>_b_d" in r.log)
r = run("strip_static", {**STRIP, "ts_type": "static", "ts_dt": 1e-4, "output_hist_every": 1})
check("static steps: slip of the end, mm", r["mean_pull_ux"][-1], SLIP, 0.01)
check("heat of friction, mJ", r["dissipated_friction"][-1], HEAT, 0.01)

if not long():
    finish()
print("the same by implicit steps that resolve its height, twice the friction and the force: twice the slip, four times the heat")
IMPLICIT = {**STRIP, "ts_type": "newmark", "ts_dt": 2e-6, "contact_base_friction": 2 * MU, "bc_pull_ux": f"30*{ramp(1e-3, 2e-3)}"}
r = run("implicit", IMPLICIT, refused=None)
require("undamped steps say what they have", TOLD in r.log and "-ts_newmark_rho 0.5" in r.log)
r = run("implicit_damped", {**IMPLICIT, "ts_newmark_rho": 0.5})
check("damped ones: slip of the end, mm", r["mean_pull_ux"][-1], 2 * SLIP, 0.015)
check("heat of friction, mJ", r["dissipated_friction"][-1], 4 * HEAT, 0.01)
require("nothing is said of flutter", TOLD not in r.log)
finish()
