# labels: run
# timeout: 120
# processors: 1
"""Patch test on bent interfaces: two blocks that share a roof of inclined planes, with meshes that do not match on them nor
along their ridges, are squeezed alike in all directions. The pressure is that of the closed form at every node, in the plane
and in space, hexahedra against tetrahedra, standard and dual multipliers. Two different polygons through the same curve
leave gaps of the square of the facets at the start: the error of the mean pressure falls with that square."""
import math

from _runs import check, check_between, finish, mesh, run

E, NU, SQUEEZE = 1e6, 0.3, 0.99
K, G = E / (3 * (1 - 2 * NU)), E / (2 * (1 + NU))


def pressure(dim):
    """Cauchy pressure in the planes of the squeeze: K/2 (1/J - J), and in plane strain the deviator's share."""
    J, a = SQUEEZE**dim, SQUEEZE
    return K / 2 * (1 / J - J) + (0 if dim == 3 else G * J**(-5 / 3) * ((2 * a * a + 1) / 3 - a * a))


def blocks(dim, **geometry):
    options = {
        "mesh": mesh("bent_interface.geo"), "mesh_set_dim": dim, **{f"mesh_set_{k}": v for k, v in geometry.items()},
        "materials": "lower,upper", "material_lower_region": "body_0", "material_upper_region": "body_1",
        "material_lower_E": E, "material_lower_nu": NU, "material_upper_E": E, "material_upper_nu": NU,
        "contacts": "face", "contact_face_secondary": "face_0", "contact_face_primary": "face_1",
        "contact_face_method": "mortar", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1,
        # The defaults leave 1e-8 of the pressure of a single node in space.
        "motion_snes_atol": 3e-9, "motion_snes_rtol": 1e-14,
    }
    sides = [f"{side}_{b}" for b in (0, 1) for side in ("x0", "x1", "outside") + (("z0", "z1") if dim == 3 else ())]
    options["bcs"] = ",".join(side.replace("_", "") for side in sides)
    for side in sides:
        axis = "y" if side[0] == "o" else side[0]
        name = side.replace("_", "")
        options |= {f"bc_{name}_on": side, f"bc_{name}_u{axis}": f"{SQUEEZE - 1!r}*{axis}*t"}
    return options


def extremes(r, dim):
    return (r[f"contact_face_pressure_{end}"][-1] / pressure(dim) - 1 for end in ("min", "max"))


ROOF = {"radius": 0.8}
CASES = [(2, {"n_upper": 3, "m_upper": 4}, "standard"), (2, {"n_lower": 3, "simplices_upper": 1}, "dual"),
         (3, {}, "dual"), (3, {"simplices_upper": 1}, "dual"), (3, {"simplices_lower": 1}, "standard"),
         (3, {"radius": 0, "strips_lower": 1, "strips_upper": 1, "n_lower": 3, "n_upper": 4}, "standard")]
for dim, geometry, space in CASES:
    r = run(f"case_{CASES.index((dim, geometry, space))}",
            {**blocks(dim, **{**ROOF, **geometry}), "contact_face_multipliers": space})
    low, high = extremes(r, dim)
    name = f"{dim} dimensions, {space}, " + ", ".join(f"{k} {v}" for k, v in geometry.items())
    check(f"pressure of the closed form at every node, {name}", max(-low, high), 0, 1e-8, relative=False)
    nodes = 1 + geometry.get("strips_lower", 3) * geometry.get("n_lower", 1)
    check("nodes that press", r["contact_face_active"][-1], nodes if dim == 2 else 4 * nodes, 0)
    check_between("Newton iterations", r["newton"][-1], 3, 8)

print("Gauss points, by their number on a facet: the force of the closed form")
off = {}
for points in (2, 4):
    r = run(f"points_{points}", {**blocks(2, **ROOF, n_upper=3, m_upper=4), "contact_face_method": "gpts",
                                 "contact_face_points": points})
    low, high = extremes(r, 2)
    mean = abs(r["contact_face_force_y"][-1]) / (pressure(2) * SQUEEZE) - 1
    print(f"     {points}: single points {low:.3g} to {high:.3g} of the pressure")
    check(f"{points} points: force over that of the closed form", mean + 1, 1, 2e-3)
    off[points] = abs(mean)
check_between("the difference with 4 points over that with 2", off[4] / off[2], 0, 0.2)

print("two polygons of 3 k and 4 k sides through one curve")
last = None
for k in (1, 2, 4):
    r = run(f"curve_{k}", {**blocks(2, radius=0.8, strips_lower=3 * k, strips_upper=4 * k, n_lower=1, n_upper=1, m_lower=3 * k,
                                    m_upper=4 * k), "contact_face_initial": "allow"})
    low, high = extremes(r, 2)
    # The projection of the interface on y = 0 carries the nominal pressure.
    mean = abs(r["contact_face_force_y"][-1]) / (pressure(2) * SQUEEZE) - 1
    print(f"     k = {k}: {low:.3g} to {high:.3g} of the pressure, mean {mean:.3g}")
    if last:
        check_between("order of the error of the mean pressure", math.log2(last / mean), 1.8, 2.2)
    last = mean
finish()
