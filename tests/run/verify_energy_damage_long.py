# labels: run long
# timeout: 7200
"""Fracture by a blow keeps the first law to the end whatever the step, with all choices of the scheme left to the program: the
upper half of a Kalthoff-Winkler plate of triangles with the spectral split, and a steel ball at 100 m/s on a brittle plate of
tetrahedra whose broken cells are crushed, without viscosity. Passes until motion and damage agree."""
import _runs as runs

PASSES = {"units": "SI", "mesh_scale": 1e-3, "coupling_snes_max_it": 50, "coupling_snes_atol": 1e-3, "energy_stop": 0}
KALTHOFF = {
    **PASSES, "mesh": runs.mesh("kalthoff.geo"), "materials": "plate", "material_plate_E": "190 GPa",
    "material_plate_nu": 0.3, "material_plate_rho": "8000 kg/m^3", "material_plate_damage": "at2",
    "material_plate_Gc": "22.13 kN/m", "material_plate_gamma": "2 mm", "material_plate_split": "spectral",
    "bcs": "symmetry,hit", "bc_symmetry_on": "symmetry", "bc_symmetry_type": "symmetry", "bc_hit_on": "hit",
    "bc_hit_type": "velocity", "bc_hit_ux": "16.5*ramp(t,0,1e-6)", "ts_max_time": "90 us",
}
BALL = {
    **PASSES, "mesh": runs.mesh("ball_tets.geo"), "materials": "ball,plate", "material_ball_E": "210 GPa",
    "material_ball_nu": 0.3, "material_ball_rho": "7850 kg/m^3", "material_plate_E": "70 GPa", "material_plate_nu": 0.22,
    "material_plate_rho": "2500 kg/m^3", "material_plate_damage": "at2", "material_plate_Gc": "20 kN/m",
    "material_plate_gamma": "1.5 mm", "material_plate_split": "volumetric", "bcs": "rim", "bc_rim_on": "plate_edges",
    "bc_rim_type": "fix", "ics": "throw", "ic_throw_on": "ball", "ic_throw_vz": -100, "contacts": "hit",
    "contact_hit_secondary": "ball_side", "contact_hit_primary": "plate_top", "contact_hit_search_radius": "1.5 mm",
    "ts_max_time": "60 us",
}


def blow(name, options, dt, least_crack):
    # The semismooth method creeps in a step of the ball, and augmentations take its place.
    r = runs.run(f"{name}_{dt}".replace(" ", "_"), {**options, "ts_dt": dt}, refused=1 if name == "ball" else 0)
    runs.check_between(f"{name}, {dt}: largest residual of the first law", abs(r["balance_first_law"]).max(), 0, 0.02)
    runs.check_between(f"{name}, {dt}: balance", abs(r["balance"]).max(), 0, 1e-10)
    runs.check_between(f"{name}, {dt}: loss by closing cracks is none that gains", r["dissipated_closing"].min() / r["energy_kinetic"].max(), -1e-9, 1)
    runs.check_between(f"{name}, {dt}: energy of cracks (J)", r["energy_fracture"][-1], least_crack, 1e9)
    runs.check(f"{name}, {dt}: the end is reached", r["time"][-1], 9e-5 if name == "kalthoff" else 6e-5, 1e-9)


for dt in ("0.4 us", "0.2 us", "0.13 us"):
    blow("kalthoff", KALTHOFF, dt, 3000)
for dt in ("0.5 us", "0.25 us", "0.125 us"):
    blow("ball", BALL, dt, 1)
runs.finish()
