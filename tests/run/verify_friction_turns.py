"""Slip that turns round (a static run): a belt around half a drum is drawn tight by a force at one end, so that it slips one way,
and then pulled at the other end, so that slip turns facet by facet. Both times the greater force is exp(pi mu) times the smaller
one (Euler and Eytelwein). With shape functions as multipliers and 25 iterations the runs gave up at the turn after hundreds of cut steps."""
# labels: run
# timeout: 180
# long: 240
import math

from _runs import check, check_between, finish, long, mesh, require, run

BELT = {
    "mesh": mesh("belt.geo"), "units": "mm_t_s_MPa", "materials": "belt", "material_belt_E": 2000, "material_belt_nu": 0.3,
    "bcs": "slack,slackx,tight,tightx", "bc_slack_on": "slack", "bc_slack_type": "force", "bc_slack_uy": "(-5*ramp(t,0,1))",
    "bc_slackx_on": "slack", "bc_slackx_ux": 0, "bc_tight_on": "tight", "bc_tight_type": "displacement",
    "bc_tight_uy": "(-3*ramp(t,1,2))", "bc_tightx_on": "tight", "bc_tightx_ux": 0,
    "contacts": "drum", "contact_drum_secondary": "inside", "contact_drum_primary": "rigid_cylinder", "contact_drum_radius": 50,
    "ts_type": "static", "ts_dt": 0.1, "ts_max_time": 2, "energy_tol": 0.1,
}
CASES = {
    "linear, mu 0.3": ({"contact_drum_friction": 0.3}, 60),
    "second order, mu 0.3": ({"contact_drum_friction": 0.3, "order": 2, "mesh_set_n": 45, "mesh_set_n_across": 1, "mesh_set_n_tail": 10}, 30),
    **({"linear, mu 0.1": ({"contact_drum_friction": 0.1}, 60)} if long() else {}),
}

for name, (settings, most_steps) in CASES.items():
    r = run(name.replace(" ", "_").replace(",", ""), {**BELT, **settings}, refused=30)
    times = math.exp(math.pi * settings["contact_drum_friction"])
    last = (r["time"] <= 1).nonzero()[0][-1]
    check(f"{name}: held force before the turn, that of the load over exp(pi mu)", -r["reaction_tight_y"][last],
          5 * r["time"][last] / times, 1e-2)
    check(f"{name}: pulling force in the end, 5 N times exp(pi mu)", -r["reaction_tight_y"][-1], 5 * times, 1e-2)
    check_between(f"{name}: steps", len(r["time"]) - 1, 20, most_steps)
finish()
