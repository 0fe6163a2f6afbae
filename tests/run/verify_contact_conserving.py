# labels: run
# timeout: 120
# long: 200
"""The energy-conserving contact update: equal bars, oblique discs (Gauss points and mortar) and a block of tetrahedra on one
of hexahedra in space keep momentum to rounding and energy to 1e-6; contact gives back what it stored to 1e-9, what is left
is the trapezoidal rule's error in the bodies. A plane that moves into a bar does exactly the work that the bar gains. The
same penalty without the update gains energy without bound. Restarts and ranks do not matter."""
import os
import shutil

import numpy
from _fields import Bodies
from _runs import check, check_between, finish, long, mesh, option_file, run

CONSERVING = {"contact_face_impact": "conserving", "ts_newmark_rho": 1, "motion_snes_rtol": 1e-11}
RHO, V, RADIUS, DT = 2700.0, 10.0, 10e-3, 2e-7


def books(name, r, energy_bar):
    """Largest change of the energy over that of the start."""
    energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
    change = abs(energy / energy[0] - 1).max()
    print(f"     {name}: {len(r['time']) - 1} steps, contact in {numpy.count_nonzero(r['contact_face_active'])}, "
          f"Newton iterations per step {r['newton'][1:].mean():.2f}, most {r['newton'].max():.0f}")
    check(f"{name}: largest change of the energy, relative", change, 0, energy_bar, relative=False)
    check_between(f"{name}: energy that contact stores at most", r["energy_contact"].max() / energy[0], 1e-5, 0.5)
    # What contact does to the bodies is what it stored, whatever the step.
    check(f"{name}: work of contact and energy in contact, sum relative to the largest energy in contact",
          abs(r["work_contact"] + r["energy_contact"]).max() / r["energy_contact"].max(), 0, 1e-9, relative=False)
    for k in "xyz":
        parts = [r[c] for c in r.history if c.startswith("momentum_") and c.endswith("_" + k)]
        if parts:
            total = sum(parts)
            check(f"{name}: change of the total momentum in {k}, relative", abs(total - total[0]).max() / START[name], 0, 1e-10,
                  relative=False)
    check_between(f"{name}: tries of a step", r["tries"].max(), 1, 1)
    return change


START = {}
L, E, BAR_RHO, SPEED, WIDTH, GAP = 0.1, 70e9, 2800.0, 2.0, 1e-3, 1e-5
C = (E / BAR_RHO) ** 0.5
BARS = {**CONSERVING, "output_vis_every": 100000, "motion_ksp_type": "preonly", "motion_pc_type": "lu"}
change = {}
for name, dt in (("bars", 1e-7), ("bars_third", 1e-7 / 3))[: 2 if long() else 1]:
    START[name] = BAR_RHO * L * WIDTH * SPEED
    r = run(name, {**BARS, "ts_dt": dt, "ts_max_time": 5.4e-5}, files=[option_file("bars_impact.opts")])
    change[dt] = books(name, r, 4e-6 if name == "bars" else 1e-6)
    on = numpy.flatnonzero(r["contact_face_active"])
    check(f"{name}: contact time 2 L/c", r["time"][on[-1]] - r["time"][on[0]], 2 * L / C, 0.02)
    check(f"{name}: momentum of the target at the end", r["momentum_target_x"][-1] / START[name], 1, 0.01)
    check(f"{name}: its impulse against its change of momentum",
          (abs(r["impulse_face_x"][-1]) - r["momentum_target_x"][-1]) / START[name], 0, 1e-9, relative=False)
if long():
    check_between("bars: energy's change with a third of the step over that with the whole one", change[1e-7 / 3] / change[1e-7],
                  0, 0.5)
r = run("bars_without", {**BARS, "contact_face_impact": "none", "contact_face_enforce": "penalty", "ts_dt": 1e-7,
                         "ts_max_time": 5.4e-5, "energy_stop": 0}, files=[option_file("bars_impact.opts")])
energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
check_between("without the update: largest change of the energy, relative", abs(energy / energy[0] - 1).max(), 1e-2, 1e3)

for method in ("gpts", "mortar"):
    name = "discs_" + method
    r = run(name, {**CONSERVING, "contact_face_method": method, "ts_dt": DT / 2}, files=[option_file("discs.opts")])
    START[name] = r["momentum_disc_x"][0]
    books(name, r, 1e-6)
    bodies = Bodies(r, RHO)
    moments = numpy.array([bodies.moments(k) for k in range(len(bodies.fields.times))])
    check(f"{name}: change of the moment of momentum over momentum times radius",
          abs(moments[:, 2] - moments[0, 2]).max() / (START[name] * RADIUS), 0, 1e-6, relative=False)

print("a block of tetrahedra flies into one of hexahedra, both free, along a direction of no edge")
FLIGHT = {
    **CONSERVING, "mesh": mesh("two_blocks.geo"), "mesh_set_dim": 3, "mesh_set_angle": 20, "mesh_set_gap": 4e-4,
    "mesh_set_inset": 0.1, "mesh_set_n_lower": 3, "mesh_set_simplices_lower": 0, "mesh_set_n_upper": 2,
    "mesh_set_simplices_upper": 1, "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3,
    "material_lower_rho": 1000, "material_upper_like": "lower", "contacts": "face", "contact_face_secondary": "lower_top",
    "contact_face_primary": "upper_bottom", "ics": "flight", "ic_flight_on": "upper", "ic_flight_vx": 0.006,
    "ic_flight_vy": -0.018, "ic_flight_vz": 0.002, "ts_dt": 1e-3, "ts_max_time": 0.13,
}
r = run("flight", {**FLIGHT, "checkpoint_every": 60, "checkpoint_keep": 9})
START["flight"] = numpy.hypot(r["momentum_upper_x"][0], r["momentum_upper_y"][0])
books("flight", r, 1e-6)
check("flight: impulse on the secondary side against its change of momentum",
      max(abs(r[f"impulse_face_{k}"][-1] - r[f"momentum_lower_{k}"][-1]) for k in "xyz") / START["flight"], 0, 1e-9,
      relative=False)


def compare(name, other, tolerance):
    for column in ("contact_face_gap_min", "contact_face_pressure_max", "energy_elastic", "momentum_lower_y"):
        first = r[column][:len(other["time"])]
        check(f"{name}: {column}", numpy.nanmax(abs(other[column] - first)) / numpy.nanmax(abs(first)), 0, tolerance,
              relative=False)


shutil.copytree("flight", "flight_again")
compare("resumed in contact", run("flight_again", {**FLIGHT, "checkpoint_every": 60, "checkpoint_keep": 9, "restart":
                                                   os.path.abspath("flight_again/checkpoints/checkpoint_000001.h5")}), 1e-12)
compare("other ranks", run("flight_ranks", {**FLIGHT, "ts_max_time": 0.05}, ranks=3 if long() else 2), 1e-8) # touches after 0.022

print("a plane moves into a bar at rest")
r = run("hammer", {
    **CONSERVING, "mesh": mesh("bar.geo"), "mesh_set_length": 100, "mesh_set_width": 1, "mesh_set_n": 200, "mesh_scale": 1e-3,
    "mesh_set_gap": GAP * 1e3, "mesh_set_second": 0, "materials": "bar", "material_bar_E": E, "material_bar_nu": 0,
    "material_bar_rho": BAR_RHO, "contacts": "face", "contact_face_secondary": "bar_right", "contact_face_primary": "plane",
    "contact_face_plane_normal": "-1,0", "contact_face_plane_point": f"{L + GAP},0", "contact_face_rigid_ux": f"-{SPEED}*t",
    "ts_dt": 2.5e-8, "ts_max_time": 5e-5,
})
stored = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
# Leaves with twice the plane's velocity.
check("kinetic energy of the bar at the end", r["energy_kinetic"][-1] / (2 * BAR_RHO * L * WIDTH * SPEED**2), 1, 0.01)
check("work of the plane against what the bar and the contact hold, relative",
      abs(r["work_external"] - stored).max() / stored.max(), 0, 1e-6, relative=False)
finish()
