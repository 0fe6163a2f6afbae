# labels: run
# timeout: 240
"""Hertz's line contact, a cylinder pressed into a block (NAFEMS CGS-1): largest pressure, half width and profile of the
closed form; the error falls with the cells; augmented Lagrangian finds the state of the semismooth method from a hundredth
to a hundred times its penalty; half the facets do with cells of second order, by Gauss points and by mortar. Strains at the full load are up to a
twentieth: it misses the closed form by 1.5 %, a hundredth of it by 0.1 %."""
import re

import numpy
from _hertz import LIGHT, Indentation, full_load, light_load
from _runs import check, check_between, finish, long

print("35 kN per mm; p0 = 3585 MPa, a = 6.21 mm")
semismooth = Indentation("mortar", {})
full_load("mortar", semismooth)
check("mortar: largest nodal pressure over p0", semismooth.p.max() / semismooth.peak, 1, 0.04)
check_between("mortar: length of the active constraints over a, one facet less at most",
              semismooth.run["contact_face_length"][-1] / semismooth.width, 1 - 9 / 20 / semismooth.width, 1)
gpts = Indentation("gpts", {"contact_face_method": "gpts"})
# Two points on each facet are more constraints than the surface can meet: every other one lets go, and the pressure of a
# node, the mean over its points, scatters by some per cent at any size of the cells.
full_load("Gauss points", gpts)
check("load, Gauss points against mortar", gpts.load, semismooth.load, 1e-3)

print("a hundredth of the load")
light = [Indentation(f"light_{n}", {**LIGHT, "mesh_set_n": n}) for n in (10, 20)]
light_load("mortar", light, 0.65)

print("triangles of second order, half as many facets, then a quarter, beside squares")
CURVED = {**LIGHT, "order": 2, "mesh_set_simplices": 1, "contact_face_method": "gpts"}
half, quarter = (Indentation(f"curved_{n}", {**CURVED, "mesh_set_n": n}) for n in (10, 5))
straight = Indentation("straight", {**LIGHT, "mesh_set_n": 20, "contact_face_method": "gpts"})
for name, i in (("half", half), ("a quarter", quarter), ("squares", straight)):
    print(f"     {name}: load {i.load:.2f}, rms distance from the closed form {i.scatter():.5f} p0, fitted p0 and a "
          f"{i.fitted()[0]:.4f}, {i.fitted()[1]:.4f}, Newton iterations of a step {i.run['newton'].max():.0f}")
check_between("half: error of the profile over that of straight facets", half.scatter() / straight.scatter(), 0.1, 0.8)
check_between("a quarter: the same", quarter.scatter() / straight.scatter(), 0.1, 1)
check("half: fitted largest pressure over p0", half.fitted()[0], 1, 2e-3)
check("half: fitted half width over a", half.fitted()[1], 1, 1e-2)

print("mortar, half as many facets of second order")
for kind, simplices, functions, most in (("triangles", 1, "dual", 1.5), ("squares", 0, "standard", 0.8))[: 2 if long() else 1]:
    i = Indentation(f"mortar_{kind}", {**CURVED, "mesh_set_simplices": simplices, "mesh_set_n": 10,
                                       "contact_face_method": "mortar", "contact_face_multipliers": functions})
    print(f"     {kind}: load {i.load:.2f}, rms distance from the closed form {i.scatter():.5f} p0, straight ones {light[1].scatter():.5f}, "
          f"fitted p0 and a {i.fitted()[0]:.4f}, {i.fitted()[1]:.4f}")
    check_between(f"{kind}: error of the profile over that of twice as many straight facets", i.scatter() / light[1].scatter(),
                  0.1, most)
    check(f"{kind}: load against that of Gauss points", i.load, half.load, 1e-3)
    check(f"{kind}: fitted largest pressure over p0", i.fitted()[0], 1, 2e-3)
    check(f"{kind}: fitted half width over a", i.fitted()[1], 1, 5e-3)

print("augmented Lagrangian, the starting penalty over three decades, multipliers to 1e-5")
AUTO = 10 * 70e3 / (9 / 20)
for factor in (0.1, 1, 10, 100)[:: 1 if long() else 2]:
    i = Indentation(f"penalty_{factor}", {
        "contact_face_enforce": "auglag", "contact_face_penalty": factor * AUTO, "contact_face_penalty_max": 1e15,
        "contact_face_penalty_increment": max(factor, 1) * AUTO, "contact_face_gap_tol": 2e-6,
        "contact_face_pressure_tol": 1e-5, "uzawa_snes_max_it": 50, "motion_snes_converged_reason": "",
    }, refused=3 if factor == 100 else 0)
    solves = [int(n) for n in re.findall(r"motion_ solve converged .*iterations (\d+)", i.run.log)]
    refused = i.run.log.count("motion_ solve did not converge")
    print(f"     {factor} times: steps {len(i.run['time']) - 1}, refused solves {refused}, iterations of a solve {max(solves)}")
    check(f"{factor} times the automatic penalty: force", i.load, semismooth.load, 1e-6)
    check(f"{factor} times: nodal pressures, largest difference over p0", abs(i.p - semismooth.p).max() / i.peak, 0, 1e-6,
          relative=False)
    check_between(f"{factor} times: augmentations of a step", i.run["uzawa"].max() - 1, 2, 10)
    check_between(f"{factor} times: Newton iterations of a solve", max(solves), 3, 25)
finish()
