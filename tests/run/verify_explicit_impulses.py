# labels: run
# timeout: 120
"""Impulses of explicit steps where a surface meets itself: two bodies under one name, and a fork whose prongs close. Both momenta
stay to rounding, contact never gives energy, ranks agree, and what happens is what happens under two names. Likewise on cells of
second order, in the plane and in space."""
import numpy
from _histories import difference
from _runs import check, check_between, finish, mesh, require, run

BLOCKS = """// Two blocks of different cells, one above the other and `off` to the side.
DefineConstant[gap = 0.05, off = 0.3];
For k In {0 : 1}
  a = newp; x = k * off; y = k * (1 + gap);
  Point(a) = {x, y, 0}; Point(a + 1) = {x + 1, y, 0}; Point(a + 2) = {x + 1, y + 1, 0}; Point(a + 3) = {x, y + 1, 0};
  l = newl; Line(l) = {a, a + 1}; Line(l + 1) = {a + 1, a + 2}; Line(l + 2) = {a + 2, a + 3}; Line(l + 3) = {a + 3, a};
  Transfinite Curve {l : l + 3} = 5 + k;
  Curve Loop(k + 1) = {l : l + 3}; Plane Surface(k + 1) = {k + 1}; Transfinite Surface {k + 1}; Recombine Surface {k + 1};
EndFor
Physical Surface("low") = {1}; Physical Surface("high") = {2}; Physical Curve("skin") = {1 : 8};
Physical Curve("top") = {3}; Physical Curve("foot") = {5};
"""
FORK = """// Two prongs on a shaft.
Point(1) = {0, 0, 0}; Point(2) = {2, 0, 0}; Point(3) = {2, 0.3, 0}; Point(4) = {0.4, 0.3, 0};
Point(5) = {0.4, 0.4, 0}; Point(6) = {2, 0.4, 0}; Point(7) = {2, 0.7, 0}; Point(8) = {0, 0.7, 0};
For k In {1 : 8}
  Line(k) = {k, k % 8 + 1};
EndFor
Curve Loop(1) = {1 : 8}; Plane Surface(1) = {1}; Physical Surface("solid") = {1}; Physical Curve("skin") = {1 : 8};
Mesh.MeshSizeMax = 0.1;
"""
EXPLICIT = {"ts_type": "central_difference", "outputs": "hist", "output_hist_type": "csv", "output_hist_every": 1}
SKIN = {"contacts": "skin", "contact_skin_secondary": "skin", "contact_skin_primary": "skin", "contact_skin_enforce": "impulse"}


def body(*names):
    return {"materials": ",".join(names), **{f"material_{name}_{key}": value for name in names
                                             for key, value in {"E": 1e6, "nu": 0.3, "rho": 1000}.items()}}


def keeps(name, r):
    """What holds whatever happens."""
    size = max(sum(abs(r[c][0]) for c in r.history if c.startswith("momentum_")), 1e-300)
    for k in sorted({c[-1] for c in r.history if c.startswith("momentum_")}):
        total = sum(r[c] for c in r.history if c.startswith("momentum_") and c.endswith(f"_{k}"))
        check(f"{name}: momentum {k}", abs(total - total[0]).max() / size, 0, 1e-13, relative=False)
    lost = r["dissipated_contact"]
    require(f"{name}: bodies meet, and contact has given no energy up to any time",
            lost[-1] > 0 and lost.min() >= -1e-14 * r["energy_kinetic"][0])
    check(f"{name}: balance", abs(r["balance"]).max(), 0, 1e-13, relative=False)
    check(f"{name}: first law", abs(r["balance_first_law"]).max(), 0, 0.01, relative=False)


with open("blocks.geo", "w", encoding="ascii") as file:
    file.write(BLOCKS)
with open("fork.geo", "w", encoding="ascii") as file:
    file.write(FORK)
FLIGHT = {"mesh": "blocks.geo", **body("low", "high"), **EXPLICIT, "ics": "a,b", "ic_a_on": "low", "ic_a_vy": 1, "ic_b_on": "high",
          "ic_b_vy": -2, "ic_b_vx": 0.5, "ts_max_time": 0.1}
one = run("one_name", {**FLIGHT, **SKIN})
keeps("two bodies under one name", one)
apart = run("two_names", {**FLIGHT, "contacts": "skin", "contact_skin_secondary": "foot", "contact_skin_primary": "top",
                          "contact_skin_enforce": "impulse"})
check("the upper block after the impact, under one name and under two", one["momentum_high_y"][-1], apart["momentum_high_y"][-1], 0.02)
two = run("one_name_ranks", {**FLIGHT, **SKIN}, ranks=2)
worst, where = difference(one.history, two.history)
check(f"two ranks, in {where}", worst, 0, 1e-8, relative=False)

# What slides rubs by mu times the pressure: the change of momentum along the surface over that across it in the step in which the
# blocks meet, whose sides are straight as yet.
MU = 0.1
rub = run("rub", {**FLIGHT, **SKIN, "contact_skin_friction": MU, "ic_b_vx": 3})
keeps("with friction", rub)
change = {k: rub[f"momentum_high_{k}"] - rub[f"momentum_high_{k}"][0] for k in "xy"}
first = numpy.argmax(change["y"] > 1e-6 * change["y"].max())
check("with friction: along the surface over across it", -change["x"][first] / change["y"][first], MU, 1e-9)
require("with friction: it heats", rub["dissipated_friction"][-1] > 0)

print("cells of second order: pressures are linear on their facets")
fine = run("fine", {**FLIGHT, **SKIN, "dm_refine": 2})
# An impact takes the energy of a layer of nodes: of one of second order less.
for name, options, least in (("quadrilaterals of 9", {}, 0.97), ("of 8", {"mesh_serendipity": True}, 0.87)):
    r = run("curved", {**FLIGHT, **SKIN, "order": 2, **options})
    keeps(f"{name} nodes", r)
    check_between(f"{name} nodes: the upper block after the impact, over that of linear cells a fourth as wide",
                  r["momentum_high_y"][-1] / fine["momentum_high_y"][-1], least, 1.03)
    rub = run("curved_rub", {**FLIGHT, **SKIN, "order": 2, **options, "contact_skin_friction": MU, "ic_b_vx": 3})
    change = {k: rub[f"momentum_high_{k}"] - rub[f"momentum_high_{k}"][0] for k in "xy"}
    first = numpy.argmax(change["y"] > 1e-6 * change["y"].max())
    check(f"{name} nodes, with friction: along the surface over across it", -change["x"][first] / change["y"][first], MU, 1e-9)
SPACE = {"mesh": mesh("two_blocks.geo"), "mesh_set_dim": 3, "mesh_set_n_lower": 2, "mesh_set_n_upper": 3, "mesh_set_gap": 0.05,
         "mesh_set_inset": 0.1, **body("lower", "upper"), **EXPLICIT, "contacts": "skin", "contact_skin_secondary": "upper_bottom",
         "contact_skin_primary": "lower_top", "contact_skin_enforce": "impulse", "ics": "a", "ic_a_on": "upper", "ic_a_vy": -2,
         "ic_a_vx": 0.3, "ts_max_time": 0.07}
flat = run("space", {**SPACE, "mesh_set_n_lower": 4, "mesh_set_n_upper": 6})
for name, options in (("hexahedra of 27", {}), ("hexahedra of 20", {"mesh_serendipity": True}),
                      ("tetrahedra of 10", {"mesh_set_simplices_lower": 1, "mesh_set_simplices_upper": 1})):
    r = run("curved_space", {**SPACE, "order": 2, **options})
    keeps(f"{name} nodes", r)
    other = (r["momentum_upper_y"] - flat["momentum_upper_y"][-1])[-1] / flat["momentum_upper_y"][0]
    check(f"{name} nodes: the upper block after the impact, against linear cells half as wide, over before", other, 0, 0.04, relative=False)
two = run("curved_space_ranks", {**SPACE, "order": 2, "mesh_set_simplices_lower": 1, "mesh_set_simplices_upper": 1}, ranks=2)
worst, where = difference(r.history, two.history)
check(f"tetrahedra, two ranks, in {where}", worst, 0, 1e-8, relative=False)

close = "-4*x^2*(y-0.35)/0.35+0.5"
fork = run("fork", {"mesh": "fork.geo", **body("solid"), **EXPLICIT, **SKIN, "ics": "a", "ic_a_on": "solid", "ic_a_vy": close,
                    "ts_dt_cfl": 0.7, "ts_max_time": 0.3})  # steps in which the tips close by less than a quarter of a cell
keeps("fork", fork)
check_between("fork: what the meeting of its prongs takes, over its energy", fork["dissipated_contact"][-1] / fork["energy_kinetic"][0],
              0.1, 0.4)
require("fork: no prong goes through the other one", numpy.nanmin(fork["contact_skin_gap_min"]) > -0.1 / 4)  # of a cell
finish()
