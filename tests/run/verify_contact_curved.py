# labels: run
# timeout: 400
# long: 900
"""Contact on facets of second order: by Gauss points blocks whose facets lie within each other's carry the uniform pressure
of the closed form by every enforcement, at any angle, in the plane and in space, others nearly; by mortar all do; a block
that flies into another one keeps momentum and energy at any angle, with each body on a rank of its own, implicit and
explicit; the same from a checkpoint to the bit; what is refused. The long form takes all cells, angles and enforcements."""
import math
import os
import subprocess

from _gates import flight, same, touches_and_keeps_momentum, turned_mesh
from _histories import difference
from _press import press
from _runs import check, check_between, finish, long, mesh, require, run

E, NU, PRESS = 1e6, 0.3, 0.02
CURVED = {"order": 2, "mesh_set_simplices_lower": 1, "mesh_set_simplices_upper": 2}
BOXES = {"mesh_set_simplices_lower": 0, "mesh_set_simplices_upper": 0}
TIGHT = {"contact_face_gap_tol": 1e-11, "contact_face_pressure_tol": 1e-10, "uzawa_snes_max_it": 200}
STIFF = {"contact_face_penalty": 1e11}
ENFORCEMENTS = {"penalty": STIFF, "auglag": TIGHT, "semismooth": {}}


def patch(name, dim, cells, angle=0, extra=None):
    """Two blocks of the given cells along a side, compressed along the press and stretched across it. Over the pressure of the
    closed form: those of the points, smallest and largest, and the stress across in cells beside the interface."""
    stretch, force = press(E, NU, 1 - PRESS, dim=dim)
    pressure = force / stretch ** (dim - 1)
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    along = f"({c!r}*x+{s!r}*y)*{stretch - 1!r}"

    def end(side, down):
        across = {f"bc_{side}_uz": f"{stretch - 1!r}*z*t"} if dim == 3 else {}
        return {f"bc_{side}_ux": f"({c!r}*({along})-{s!r}*({-down!r}))*t",
                f"bc_{side}_uy": f"({s!r}*({along})+{c!r}*({-down!r}))*t", **across}

    places = [(x, y) for x in (0.1, 0.3, 0.52) for y in (0.95, 1.05)]
    probes = {f"probe_p{i}_at": f"{c * x - s * y!r},{s * x + c * y!r}" + (",0.47" if dim == 3 else "")
              for i, (x, y) in enumerate(places)}
    r = run(f"patch_{name}", {
        **CURVED, "probes": ",".join(f"p{i}" for i in range(len(places))), **probes,
        **{f"probe_p{i}_fields": "stress" for i in range(len(places))}, "mesh": mesh("two_blocks.geo"), "mesh_set_dim": dim, "mesh_set_n_lower": cells[0],
        "mesh_set_n_upper": cells[1], "mesh_set_angle": angle, "materials": "lower,upper", "material_lower_E": E,
        "material_lower_nu": NU, "material_upper_like": "lower", "contacts": "face",
        "contact_face_secondary": "lower_top", "contact_face_primary": "upper_bottom", "bcs": "plate,press",
        "bc_plate_on": "lower_bottom", "bc_press_on": "upper_top", **end("plate", 0.0), **end("press", 2 * PRESS),
        "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "motion_snes_rtol": 1e-12, "contact_face_method": "gpts",
        **(extra or {})})
    check_between("tries of the step", r["tries"].max(), 1, 1)
    stress = [-(s * s * r[f"probe_p{i}_stress_xx"][-1] + c * c * r[f"probe_p{i}_stress_yy"][-1]
                - 2 * s * c * r[f"probe_p{i}_stress_xy"][-1]) / pressure for i in range(len(places))]
    return [r[f"contact_face_pressure_{end}"][-1] / pressure for end in ("min", "max")], stress


print("facets within each other's")
for kind, dim, cells, shape in (("simplices", 2, (6, 3), {}), ("simplices", 3, (4, 2), {}), ("boxes", 2, (6, 3), BOXES),
                                ("boxes", 3, (4, 2), BOXES), ("serendipity", 3, (2, 1), {**BOXES, "mesh_serendipity": 1})):
    for angle, (enforce, extra) in list(zip((0, 33, 33), ENFORCEMENTS.items()))[0 if long() or (kind, dim) == ("simplices", 2) else 2:]:
        (low, high), stress = patch(f"{kind}_{dim}_{enforce}", dim, cells, angle,
                                    {"contact_face_enforce": enforce, **extra, **shape})
        name, soft = f"{dim}D, {kind}, {enforce}, angle {angle}", extra == STIFF
        if soft:  # the overlap that a penalty needs has a moment
            check(f"{name}: largest over smallest pressure", high / low, 1, 1e-6)
        check(f"{name}: stress on both sides of the interface", max(abs(p - 1) for p in stress), 0, 1e-5 if soft else 1e-8,
              relative=False)
        # In space there are three points for two nodes, which share a force in many ways.
        check(f"{name}: pressures of the points", max(high - 1, 1 - low), 0, 1e-5 if soft else 1e-8 if dim == 2 else 1e-4,
              relative=False)
print("others, by the automatic penalty")
for kind, dim, cells, most, shape in (("simplices", 2, (5, 4), 0.05, {}), ("simplices", 3, (3, 2), 0.05, {}),
                                      ("boxes", 2, (5, 4), 0.05, BOXES), ("boxes", 3, (3, 2), 0.05, BOXES))[:: 1 if long() else 3]:
    (low, high), stress = patch(f"{kind}_{dim}_others", dim, cells, 0, {"contact_face_enforce": "penalty", **shape})
    print(f"     {dim}D: pressures {low:.4f} to {high:.4f}, stress {min(stress):.4f} to {max(stress):.4f}")
    check(f"{dim}D, {kind}: largest deviation of the stress", max(abs(p - 1) for p in stress), 0, most, relative=False)

print("others, by mortar")
SERENDIPITY = {**BOXES, "mesh_serendipity": 1}
for kind, dim, cells, shape in (("simplices", 2, (5, 4), {}), ("boxes", 2, (5, 4), BOXES), ("simplices", 3, (3, 2), {}),
                                ("boxes", 3, (3, 2), BOXES), ("serendipity", 3, (3, 2), SERENDIPITY),
                                ("tetrahedra on boxes", 3, (3, 2), {"mesh_set_simplices_lower": 0}),
                                ("boxes on tetrahedra, serendipity", 3, (3, 2), {"mesh_set_simplices_upper": 0, "mesh_serendipity": 1}))[:: 1 if long() else 3]:
    for angle, functions, enforce in ((0, "standard", "semismooth"),
                                      (33, "dual", "auglag" if kind == "simplices" else "semismooth"))[0 if long() else 1:]:
        (low, high), stress = patch(f"mortar_{kind}_{dim}_{functions}_{enforce}".replace(", ", "_").replace(" ", "_"), dim, cells, angle, {
            "contact_face_method": "mortar", "contact_face_multipliers": functions, "contact_face_enforce": enforce,
            "contact_face_gap_tol": 1e-9, "contact_face_pressure_tol": 1e-9, **shape})
        name = f"{dim}D, {kind}, mortar, {functions}, {enforce}"
        check(f"{name}: pressures of the nodes", max(high - 1, 1 - low), 0, 1e-8, relative=False)
        check(f"{name}: stress on both sides of the interface", max(abs(p - 1) for p in stress), 0, 1e-9, relative=False)

print("a block flies into another one")
FLIGHTS = {2: CURVED}
spread = os.path.abspath("blocks.msh")
subprocess.run(["gmsh", "-v", "1", "-3", "-order", "2", "-format", "msh22", mesh("two_blocks.geo"), "-o", spread,
                *[word for key, value in {"dim": 3, "n_lower": 2, "n_upper": 2, "gap": 0.0213, "inset": 0.07,
                                          "simplices_lower": 1, "simplices_upper": 1}.items()
                  for word in ("-setnumber", key, str(value))]], check=True)
FLIGHTS[3] = {"mesh": spread, "ts_max_time": 0.1}
for dim, flown in FLIGHTS.items():
    turned_by = {"angle": 37, "tilt": -24 if dim == 3 else 0}
    turned_on = {"mesh": turned_mesh(spread, **turned_by)} if dim == 3 else {}
    for method, enforce in [("gpts", e) for e in (ENFORCEMENTS if long() else ("semismooth",)[dim - 2:])] + [
            ("mortar", e) for e in (("auglag", "semismooth") if long() else ("auglag",)[: dim - 2])]:
        case, name = (dim, method, enforce), f"{dim}D, {method}, {enforce}"
        straight = flight(case, "straight", extra=flown)
        touches_and_keeps_momentum(name, straight)
        if dim == 3 and not long():
            continue
        turned = flight(case, "turned", **turned_by, ranks=2,
                        extra={**flown, **turned_on, "petscpartitioner_type": "simple"})
        same(f"{name}, turned, each body on its own rank", straight, turned, 1e-10)
    parts = {**flown, "checkpoint_every": 10, "ts_max_time": 0.06 if dim == 2 or long() else 0.04}
    case = (dim, "gpts" if dim == 2 else "mortar", "auglag")
    whole = flight(case, "whole", extra=parts)
    for ranks in (1, 2) if dim == 2 or long() else (1,):
        flight(case, f"cut_{ranks}", extra={**parts, "ts_max_steps": 10})
        again = flight(case, f"cut_{ranks}", extra={**parts, "restart": "auto"}, ranks=ranks)
        worst, where = difference(whole.history, again.history, exact=ranks == 1)
        check(f"{dim}D: from a checkpoint on {ranks} ranks, largest difference, in {where}", worst, 0,
              1e-300 if ranks == 1 else 1e-8, relative=False)
    hit = flight((dim, "gpts", "penalty"), "explicit", extra={
        **flown, "ts_type": "central_difference", "ts_max_time": 0.1, "ts_dt": 1e-3, "ts_newmark_rho": None,
        "motion_snes_rtol": None, "motion_snes_atol": None, "motion_ksp_type": None, "motion_pc_type": None})
    total = [hit[f"momentum_lower_{k}"] + hit[f"momentum_upper_{k}"] for k in "xyz"[:dim]]
    start = abs(total[1][0])
    check(f"{dim}D, explicit: sum of the momenta", max(abs(p - p[0]).max() for p in total) / start, 0, 1e-12,
          relative=False)
    check_between(f"{dim}D, explicit: impulse over the momentum", abs(hit["impulse_face_y"][-1]) / start, 0.5, 1.2)
    energy = hit["energy_kinetic"] + hit["energy_elastic"] + hit["energy_contact"]
    check_between(f"{dim}D, explicit: largest energy over that of the start", energy.max() / energy[0], 1, 1 + 5e-3)

# Tetrahedra fly into hexahedra.
mixed = {**FLIGHTS[3], "mesh": os.path.abspath("mixed.msh")}
subprocess.run(["gmsh", "-v", "1", "-3", "-order", "2", "-format", "msh22", mesh("two_blocks.geo"), "-o", mixed["mesh"],
                *[word for key, value in {"dim": 3, "n_lower": 2, "n_upper": 2, "gap": 0.0213, "inset": 0.07,
                                          "simplices_lower": 0, "simplices_upper": 1}.items()
                  for word in ("-setnumber", key, str(value))]], check=True)
for enforce in ("auglag", "semismooth") if long() else ():
    name = f"3D, tetrahedra on hexahedra, mortar, {enforce}"
    straight = flight((3, "mortar", enforce), "mixed", extra=mixed)
    touches_and_keeps_momentum(name, straight)
    turned = flight((3, "mortar", enforce), "mixed_turned", angle=37, tilt=-24, ranks=2,
                    extra={**mixed, "mesh": turned_mesh(mixed["mesh"], angle=37, tilt=-24), "petscpartitioner_type": "simple"})
    same(f"{name}, turned, each body on its own rank", straight, turned, 1e-10)

print("what is not there says so")
r = run("refused_mixed", {"mesh": mixed["mesh"], "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": NU,
                          "material_upper_like": "lower", "contacts": "face", "contact_face_secondary": "lower_top",
                          "contact_face_primary": "upper_bottom", "contact_face_method": "gpts", "ts_type": "static", "ts_dt": 1,
                          "ts_max_time": 1, "bcs": "plate", "bc_plate_on": "lower_bottom", "bc_plate_type": "fix"}, code=3)
require("Gauss points on triangles beside hexahedra: the message names mortar", "_method mortar" in r.log)
finish()
