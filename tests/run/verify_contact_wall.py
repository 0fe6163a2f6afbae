# labels: run
# timeout: 120
# long: 200
"""An elastic bar rebounds from a rigid plane and from a held block (one-dimensional wave theory, nu = 0): touch at
gap / v, contact for 2 L/c, force rho c v A, rebound with -v."""
import numpy
from _runs import check, check_between, finish, long, mesh, run

L, E, RHO, V, WIDTH, GAP = 0.1, 70e9, 2800.0, 2.0, 1e-3, 1e-5
C = (E / RHO) ** 0.5
FORCE = RHO * C * V * WIDTH
DT = 0.5 * L / 200 / C
MOMENTUM = RHO * L * WIDTH * V
BASE = {
    "mesh": mesh("bar.geo"), "mesh_set_length": 100, "mesh_set_width": 1, "mesh_set_n": 200, "mesh_scale": 1e-3,
    "mesh_set_gap": GAP * 1e3,
    "materials": "bar", "material_bar_E": E, "material_bar_nu": 0, "material_bar_rho": RHO,
    "ics": "flight", "ic_flight_on": "bar", "ic_flight_vx": V,
    "contacts": "face", "contact_face_secondary": "bar_right",
    "ts_dt": DT, "ts_max_time": 60e-6, "ts_newmark_rho": 0.9,
}
PLANE = {"mesh_set_second": 0, "contact_face_primary": "plane", "contact_face_plane_normal": "-1,0",
         "contact_face_plane_point": f"{L + GAP},0"}
BLOCK = {"mesh_set_second": 2, "mesh_set_n_second": 2, "mesh_set_wall_length": 1, "mesh_set_wall_width": 3,
         "contact_face_primary": "second_left",
         "materials": "bar,wall", "material_wall_like": "bar", "bcs": "hold", "bc_hold_on": "wall",
         "bc_hold_type": "fix"}


def rebound(name, options):
    print(name)
    r = run(name.replace(" ", "_"), {**BASE, **options})
    force = r["contact_face_force_x"]
    on = numpy.nonzero(force)[0]
    start, end = r["time"][on[0]], r["time"][on[-1]]
    middle = (r["time"] > GAP / V + L / (2 * C)) & (r["time"] < GAP / V + 3 * L / (2 * C))
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check("first touch at gap / v, within a step", start, GAP / V, 1.001 * DT, relative=False)
    check("contact time 2 L/c", end - start, 2 * L / C, 0.02)
    check("mean plateau force rho c v A", -force[middle].mean(), FORCE, 0.02)
    check("largest excursion from the plateau", abs(force[middle] + FORCE).max() / FORCE, 0, 0.02, relative=False)
    check("rebound velocity", r["momentum_bar_x"][-1] / MOMENTUM * V, -V, 0.01)
    check("impulse is the change of momentum, relative",
          (r["impulse_face_x"][-1] - (r["momentum_bar_x"][-1] - r["momentum_bar_x"][0])) / (2 * MOMENTUM), 0, 1e-6,
          relative=False)
    check_between("largest energy / energy at the start", energy.max() / energy[0], 0.97, 1 + 1e-9)
    check_between("energy at the end / energy at the start", energy[-1] / energy[0], 0.97, 1)
    check_between("most Uzawa passes in a step", r["uzawa"].max(), 1, 6)
    check_between("most Newton iterations in a step", r["newton"].max(), 1, 14)
    check_between("tries of a step", r["tries"].max(), 1, 1)
    return r


rebound("rigid plane", PLANE)
if not long():
    finish()
block = rebound("held block", BLOCK)
check("the block's reaction carries the contact force: largest difference, relative",
      abs(block["reaction_hold_x"] - block["contact_face_force_x"]).max() / FORCE, 0, 1e-8, relative=False)
finish()
