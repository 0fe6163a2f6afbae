# labels: run
# timeout: 60
# long: 120
"""Messages and reductions of an explicit step on two ranks, as PETSc counts them (-log_view): the displacement to the ghosts, one
message of forces back, one reduction for the cells and one for the ledger, beside what is asked for now and then; how often
contact with friction finds forces."""
import collections
import csv

from _runs import check_between, finish, long, mesh, run

E = {"material_solid_E": 1e6, "material_solid_nu": 0.3, "material_solid_rho": 1000}
BODY = {"ts_type": "central_difference", "mesh": mesh("block.geo"), "mesh_set_n": 20, "materials": "solid", **E,
        "ics": "s", "ic_s_on": "solid", "ic_s_vx": "sin(3*x)", "ts_max_time": 1e6, "outputs": "hist", "output_hist_type": "csv",
        "output_hist_every": 10**6}
J2 = {"material_solid_model": "j2", "material_solid_sigma_y": 1e4, "material_solid_hardening": "linear", "material_solid_linear_h": 1e5}
HELD = {"bcs": "hold", "bc_hold_on": "left", "bc_hold_type": "fix"}
SLIDES = {"contacts": "floor", "contact_floor_secondary": "bottom", "contact_floor_primary": "plane",
          "contact_floor_plane_point": "0,0,0", "contact_floor_plane_normal": "0,1,0", "contact_floor_friction": 0.3}
WEIGHT = {"bcs": "g", "bc_g_on": "solid", "bc_g_type": "body_force", "bc_g_uy": -9.81}


def counted(name, options, steps):
    """Messages that the busiest rank sends, reductions and evaluations of contact forces, of all steps."""
    run(name, {**options, "ts_max_steps": steps, "log_view": f":{name}.csv:ascii_csv"}, ranks=2)
    sums = collections.defaultdict(lambda: [0.0, 0.0, 0.0])
    with open(f"{name}.csv") as file:
        for row in csv.DictReader(file):
            if row["Stage Name"] == "Set-up":
                continue
            if row["Event Name"] == "ContactForces":
                sums[row["Rank"]][2] += float(row["Count"])
            if row["Event Name"] != "summary":
                continue
            # PETSc counts a message where it leaves and where it comes in.
            sums[row["Rank"]][0] += float(row["Num Messages"] or 0) / 2
            sums[row["Rank"]][1] += float(row["Num Reductions"] or 0)
    return [max(of_rank[i] for of_rank in sums.values()) for i in (0, 1, 2)]


# Signals are asked for in each sixteenth step, and cells for their stable step after 1 to 64: 0.06 and 0.02 of a step.
# Friction: forces, energies, and what the next step starts from.
for name, more, *counts in (("elastic", {}, 2, 2, 0), ("j2", {**J2, **HELD}, 2, 2, 0), ("weight", {**J2, **WEIGHT}, 3, 2, 0),
                            ("slides", {**J2, **WEIGHT, **SLIDES}, 6.5, 2, 1))[:: 1 if long() else 3]:
    few, many = counted(name, {**BODY, **more}, 100), counted(name, {**BODY, **more}, 420)
    for what, before, after, most in zip(("messages to the neighbour", "reductions", "contact forces"), few, many, counts):
        check_between(f"{name}: {what} of a step", (after - before) / 320, most, most + 0.1)
finish()
