"""What a contact must not depend on, for every method and enforcement in the plane and in space: two free blocks, of
which the upper one flies into the lower one."""
from math import cos, pi, sin

import numpy
from _runs import Run, check, check_between, mesh, require, run

E, RHO, GAP, SPEED = 1e6, 1000.0, 0.0213, 1.0
DT, END = 4e-3, 0.12
INSET = 0.07
ALL = [(dim, method, enforce) for dim in (2, 3) for method in ("gpts", "mortar")
       for enforce in ("penalty", "auglag", "semismooth")]
# The sides do not match, though their diagonals lie on each other in space, and both have as many cells: the simple partitioner gives
# each of two ranks one of them.
BASE = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 3, "mesh_set_n_upper": 3, "mesh_set_gap": GAP,
    "mesh_set_inset": INSET,
    "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": 0.3, "material_lower_rho": RHO,
    "material_upper_like": "lower", "ics": "flight", "ic_flight_on": "upper",
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "ts_dt": DT, "ts_max_time": END, "ts_newmark_rho": 0.9,
    "motion_snes_rtol": 1e-12, "motion_snes_atol": 1e-9, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
}
SWAPPED = {"contact_face_secondary": "lower_top", "contact_face_primary": "upper_bottom"}


def flight(case, name, angle=0, tilt=0, extra=None, ranks=1, speed=SPEED, refused=0):
    """Two blocks turned by the angle in the plane of x and y, then by the tilt in that of y and z. None among the extra
    options leaves one of BASE to the program's default."""
    dim, method, enforce = case
    turn, lean = angle * pi / 180, tilt * pi / 180
    options = {**BASE, "mesh_set_dim": dim, "mesh_set_angle": angle, "contact_face_method": method,
               "contact_face_enforce": enforce, **(extra or {})}
    if options["mesh"].endswith(".msh"):  # which has no parameters, and is as it is
        options.update({key: None for key in options if key.startswith("mesh_set_")})
    options = {key: value for key, value in options.items() if value is not None}
    velocity = (speed * sin(turn), -speed * cos(turn) * cos(lean), -speed * cos(turn) * sin(lean))
    for axis, value in zip("xyz"[:dim], velocity):
        options[f"ic_flight_v{axis}"] = repr(value)
    if dim == 3 and "mesh_set_dim" in options:
        options["mesh_set_tilt"] = tilt
    return run(f"{dim}_{method}_{enforce}_{name}", options, ranks=ranks, refused=refused)


def turned_mesh(path, angle, tilt):
    """A copy of a .msh file of version 2.2, turned as a flight is: the same mesh, which gmsh would not make of turned blocks
    where its tetrahedra follow no pattern."""
    lines = open(path).read().split("\n")
    first = lines.index("$Nodes") + 2
    turn, lean = angle * pi / 180, tilt * pi / 180
    for i in range(first, first + int(lines[first - 1])):
        number, x, y, z = lines[i].split()
        x, y, z = float(x), float(y), float(z)
        x, y = cos(turn) * x - sin(turn) * y, sin(turn) * x + cos(turn) * y
        y, z = cos(lean) * y - sin(lean) * z, sin(lean) * y + cos(lean) * z
        lines[i] = f"{number} {x!r} {y!r} {z!r}"
    copy = path.replace(".msh", f"_{angle}_{tilt}.msh")
    with open(copy, "w") as file:
        file.write("\n".join(lines))
    return copy


def vector(r, column):
    """[step][component] of a vector among the columns."""
    return numpy.array([r[f"{column}_{axis}"] for axis in "xyz" if f"{column}_{axis}" in r.history]).T


def size(r, column):
    return numpy.linalg.norm(vector(r, column), axis=1)


def same(claim, a, b, tolerance):
    """Energies, gap, force and momenta of two runs, relative to each column's largest value."""
    if not require(f"{claim}: as many steps", len(a["time"]) == len(b["time"])):
        return
    worst = {}
    for column in ("energy_kinetic", "energy_elastic", "contact_face_gap_min", "contact_face_length"):
        difference = abs(a[column] - b[column])
        worst[column] = numpy.nanmax(difference) / numpy.nanmax(abs(a[column]))
        if (numpy.isnan(a[column]) != numpy.isnan(b[column])).any():
            worst[column] = numpy.inf
    for column in ("contact_face_force", "impulse_face", "momentum_lower", "momentum_upper"):
        worst[column] = abs(size(a, column) - size(b, column)).max() / size(a, column).max()
    name = max(worst, key=worst.get)
    check(f"{claim}: largest difference, in {name}", worst[name], 0, tolerance, relative=False)


def touches_and_keeps_momentum(claim, r, upper_is_secondary=True):
    active = r["contact_face_active"] > 0
    require(f"{claim}: nothing presses before the gap is closed", not active[r["time"] < GAP / SPEED - DT].any())
    check_between(f"{claim}: steps with contact", numpy.count_nonzero(active), 5, 25)
    lower, upper = vector(r, "momentum_lower"), vector(r, "momentum_upper")
    impulse = vector(r, "impulse_face") * (1 if upper_is_secondary else -1)
    whole = numpy.linalg.norm(upper[0])
    check(f"{claim}: sum of the momenta", abs(lower + upper - upper[0]).max() / whole, 0, 1e-12, relative=False)
    check(f"{claim}: impulse on the upper block is its change of momentum",
          abs(upper - upper[0] - impulse).max() / whole, 0, 1e-9, relative=False)
    # Of an elastic stroke that leaves no waves: 2 M / (M + m), M the lower block's mass.
    part = (1 - 2 * INSET) ** (2 if upper.shape[1] == 3 else 1)
    check_between(f"{claim}: what it gives away, over its momentum", numpy.linalg.norm(impulse[-1]) / whole, 0.8,
                  2 / (1 + part))
    check_between(f"{claim}: largest energy over that of the start",
                  (r["energy_kinetic"] + r["energy_elastic"]).max() / r["energy_kinetic"][0], 1, 1 + 1e-9)


def sides_swapped(claim, reference, swapped, tolerance):
    """The meshes do not match, so each choice of sides has constraints of its own: what they exchange agrees as the two
    discretisations do."""
    touches_and_keeps_momentum(f"{claim}, sides swapped", swapped, upper_is_secondary=False)
    one, other = vector(reference, "impulse_face"), vector(swapped, "impulse_face")
    check(f"{claim}, sides swapped: largest difference of what the blocks have exchanged, over what they exchange",
          numpy.linalg.norm(one + other, axis=1).max() / size(reference, "impulse_face").max(), 0, tolerance,
          relative=False)


def opposite(claim, one, other, tolerance):
    """Two choices of sides with one solution: opposite forces and impulses, the same momenta and energies, in each step."""
    if not require(f"{claim}: as many steps", len(one["time"]) == len(other["time"])):
        return
    check_between(f"{claim}: steps with contact", numpy.count_nonzero(one["contact_face_active"]), 5, 25)
    worst = {column: abs(one[column] - other[column]).max() / abs(one[column]).max()
             for column in ("energy_kinetic", "energy_elastic")}
    for column, sign in (("contact_face_force", -1), ("impulse_face", -1), ("momentum_lower", 1), ("momentum_upper", 1)):
        difference = numpy.linalg.norm(vector(one, column) - sign * vector(other, column), axis=1)
        worst[column] = difference.max() / size(one, column).max()
    name = max(worst, key=worst.get)
    check(f"{claim}: largest difference, in {name}", worst[name], 0, tolerance, relative=False)


def began_as(claim, reference, r, tolerance):
    """The steps of a shorter run are those of the reference."""
    steps = len(r["time"])
    start = Run(reference.code, "", reference.dir)
    start.history = {column: values[:steps] for column, values in reference.history.items()}
    require(f"{claim}: the blocks have touched", numpy.count_nonzero(r["contact_face_active"]) > 5)
    same(claim, start, r, tolerance)
    check_between(f"{claim}: largest number of tries", r["tries"].max(), 1, 1)


def held(claim, r, upper_is_secondary):
    """A body that would have passed through the other one, which stands on the ground, within a step flies back."""
    upper = vector(r, "momentum_upper")
    impulse = vector(r, "impulse_face") * (1 if upper_is_secondary else -1)
    before = numpy.linalg.norm(upper[0])
    check_between(f"{claim}: impulse over momentum", impulse[-1][1] / before, 1.2, 2)
    # The residual falls by 1e-12 of what it is at the depth of facets.
    check(f"{claim}: impulse is the change of momentum", abs(upper - upper[0] - impulse).max() / before, 0, 1e-7,
          relative=False)
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check_between(f"{claim}: largest energy over that of the start", energy.max() / energy[0], 1, 1 + 1e-9)
    check_between(f"{claim}: smallest gap over a facet", numpy.nanmin(r["contact_face_gap_min"]) * 4, -5e-3, 1)
