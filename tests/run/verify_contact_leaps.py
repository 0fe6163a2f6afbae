# labels: run
# timeout: 120
"""Blows that a step does not resolve: with whatever leaves the program's choices to it, no body gains energy, steps are cut
where they would leap more than a facet into the other body, and the first law closes, the loss of closing gaps included."""
import numpy
from _gates import E, GAP, SPEED, SWAPPED, flight
from _runs import check, check_between, finish, mesh, run

FACET = 0.25
GROUND = {"mesh_set_n_lower": 4, "mesh_set_inset": 0.1, "bcs": "ground", "bc_ground_on": "lower_bottom",
          "bc_ground_type": "fix"}
FREE = {"ts_newmark_rho": None, "motion_snes_rtol": None, "motion_snes_atol": None}
CASES = [(2, "gpts", "auglag"), (2, "mortar", "penalty"), (2, "mortar", "semismooth"), (3, "mortar", "semismooth")]


def largest_energy(r):
    stored = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
    return stored.max() / stored[0]


for case in CASES:
    name = "{}D, {}, {}".format(*case)
    # 31 and 970 times h/c_p.
    for stiffness in (E, 1e3 * E):
        r = flight(case, f"unresolved_{stiffness:g}",
                   extra={**FREE, "material_lower_E": stiffness, "ts_dt": 0.24, "ts_max_time": 2.4})
        check_between(f"{name}, E = {stiffness:g}, unresolved: largest energy over that of the start", largest_energy(r), 1,
                      1 + 1e-9)
        check_between(f"{name}, E = {stiffness:g}, unresolved: impulse over momentum",
                      r["impulse_face_y"][-1] / -r["momentum_upper_y"][0], 0.85, 1.1)

# The case in which cells tangled: 330 times the energy. The first step is halved until it goes less than a facet deep.
leap = {**GROUND, **SWAPPED, "contact_face_impact": "stabilised", "ts_dt": 5 * FACET, "ts_max_time": 5 * FACET}
for case in CASES[:3]:
    name = "{}D, {}, {}".format(*case)
    r = flight(case, "leap", extra=leap, refused=3)
    depth = SPEED * r["time"][1] - GAP
    check_between(f"{name}: depth of the first step that is taken, in facets", depth / FACET, 0.45, 1)
    check_between(f"{name}: largest number of tries", r["tries"].max(), 4, 4)
    check_between(f"{name}, five facets deep: largest energy over that of the start", largest_energy(r), 1, 1 + 1e-9)
r = flight(CASES[2], "no_limit", extra={**leap, "ts_adapt_closing": 0, "energy_stop": 0})
check("without a limit: length of the first step", r["time"][1], leap["ts_dt"], 1e-12)

# With strains v/c the bodies' own part of the first law falls; what gaps lose as they close is no part of it.
lacks = []
for speed in (1, 0.1):
    r = flight(CASES[2], f"speed_{speed}", speed=speed, extra={
        **GROUND, "contact_face_impact": "stabilised", "ts_dt": 0.02,
        "mesh_set_gap": 0.01 * speed, "ts_max_time": 0.3, "motion_snes_atol": 1e-12})
    check_between(f"v = {speed}: what contact takes, over the energy of the start",
                  -r["work_contact"][-1] / r["energy_kinetic"][0], 0.1, 0.2)
    lacks.append(numpy.abs(r["balance_first_law"]).max())
check_between("first law in a blow of small strains", lacks[1], 0, 2e-4)
check("its fall with the strains", lacks[0] / lacks[1], 10, 0.1)

# A plane that rises into a resting block, and the same block falling on a resting plane: seen from a frame that moves, so
# that losses and impulse agree, and the plane's work is its speed times the impulse, the shock included.
PLANE = {"mesh": mesh("block.geo"), "mesh_set_n": 4, "materials": "block", "material_block_region": "solid",
         "material_block_E": E, "material_block_nu": 0.3, "material_block_rho": 1000, "contacts": "foot",
         "contact_foot_secondary": "bottom", "contact_foot_primary": "plane", "contact_foot_plane_point": "0,-0.0213",
         "ts_dt": 0.01, "ts_max_time": 0.2, "motion_snes_rtol": 1e-12, "motion_snes_atol": 1e-9}


def lacking(r):
    kept = sum(r[c] for c in ("energy_kinetic", "energy_elastic", "energy_contact", "energy_numerical", "dissipated_numerical",
                                "dissipated_contact"))
    return kept - kept[0] - r["work_external"]


for method in ("gpts", "mortar"):
    falls = run(f"falls_{method}", {**PLANE, "contact_foot_method": method, "ics": "flight", "ic_flight_on": "solid",
                                    "ic_flight_vy": -SPEED})
    rises = run(f"rises_{method}", {**PLANE, "contact_foot_method": method, "contact_foot_rigid_uy": f"{SPEED}*t"})
    name = f"a plane rises, {method}"
    check(f"{name}: impulse of the block that falls", abs(rises["impulse_foot_y"] - falls["impulse_foot_y"]).max()
          / (1000 * SPEED), 0, 1e-10, relative=False)
    for what, of in (("loss of contact", lambda r: r["dissipated_contact"]), ("loss", lambda r: r["dissipated_numerical"]), ("what the first law lacks", lacking)):
        check(f"{name}: {what} of the block that falls", abs(of(rises) - of(falls)).max() / falls["energy_kinetic"][0], 0,
              1e-10, relative=False)
    check(f"{name}: its work over speed times impulse", rises["work_external"][-1] / (SPEED * rises["impulse_foot_y"][-1]), 1,
          1e-9)
finish()
