# labels: run
# timeout: 60
# long: 200
"""A static run that ends on a branch which a real body leaves says so, with the number of modes in which it buckles: a clamped
strut pressed straight past none to three of Euler's loads. One with an imperfection bears the first of them, however small
that is and however long the steps; a perfect one does where it is asked to."""
import math

import numpy

from _runs import check, finish, long, mesh, require, run

LENGTH, E = 40, 1000
EULER = 4 * math.pi**2 * E / 12 / LENGTH**2  # the lowest; the next are 2.0457, 4 and 6.05 times that
ASIDE = 5e-4
STRUT = {"mesh": mesh("block.geo"), "mesh_set_lx": LENGTH, "mesh_set_n": 40, "mesh_set_ny": 2, "order": 2, "units": "mm_t_s_MPa",
         "materials": "strut", "material_strut_region": "solid", "material_strut_E": E, "material_strut_nu": 0, "bcs": "hold,press",
         "bc_hold_on": "left", "bc_hold_type": "fix", "bc_press_on": "right", "ts_type": "static", "ts_dt": 0.1,
         "ts_max_time": 1, "probes": "middle", "probe_middle_at": f"{LENGTH / 2},0.5"}


def press(name, load, **more):
    return run(name, {**STRUT, "bc_press_uy": 0, "bc_press_ux": f"-{load * EULER / E * LENGTH}*t", **more.pop("options", {})}, **more)


def modes_told(r):
    said = [line for line in r.log.splitlines() if "the equilibrium at the end is unstable" in line]
    return int(said[0].split("has ")[1].split()[0]) if said else 0


for name, load, modes, more in (("none", 0.7, 0, {}), ("one", 1.5, 1, {}), ("two", 3, 2, {}), ("three", 5, 3, {}),
                                ("sbaij", 3, 2, {"options": {"motion_mat_type": "sbaij", "motion_pc_type": "cholesky"}}),
                                ("ranks", 5, 3, {"ranks": 2}))[: 6 if long() else 5]:
    told = modes_told(press(name, load, **more))
    require(f"{load} times Euler's load ({name}): {told} modes told, {modes} loads passed", told == modes)

# A path goes straight on past these loads, and says so, too.
for load, modes in ((0.7, 0), (1.5, 1), (3, 2)):
    told = modes_told(press("path", 1, options={"ts_path_length": load * EULER / E * LENGTH / 10, "ts_dt": 1, "ts_max_time": 10}))
    require(f"a path to {load} times Euler's load: {told} modes told, {modes} loads passed", told == modes)

# The elastica bears 1 + s/2 of Euler's load as its ends come closer by the part s of its length.
for name, more in (("leant", {"bcs": "hold,press,aside", "bc_aside_on": "bottom", "bc_aside_type": "traction", "bc_aside_uy": "1e-9 MPa"}),
                   ("on", {"motion_leave_unstable": "on"}), ("fine", {"mesh_set_n": 160, "mesh_set_ny": 20, "bcs": "hold,press,aside",
                    "bc_aside_on": "bottom", "bc_aside_type": "traction", "bc_aside_uy": "1e-9 MPa", "ts_dt": 0.25}))[: 3 if long() else 2]:
    r = press(name, 3, options=more, ranks=2 if name == "on" else 1)
    require(f"{name}: buckles, and says so", modes_told(r) == 0 and "left an equilibrium that is unstable" in r.log)
    force = -r["reaction_press_x"] / EULER
    short = (3 * r["time"] - force) * EULER / E
    check(f"{name}: force at the end in Euler's loads", force[-1], 1 + short[-1] / 2, 5e-3)
    check(f"{name}: force of the step in which it buckles", force[numpy.argmax(short > 1e-3)], 1, 5e-3)
    if name == "leant":
        require("it bends to the side to which it leant", r["probe_middle_uy"][-1] * r["probe_middle_uy"][2] > 0)

bent = press("bent", 3, options={"bcs": "hold,press,aside", "bc_aside_on": "bottom", "bc_aside_type": "traction", "bc_aside_uy": f"{ASIDE} MPa", "ts_dt": 0.02})
require("bent aside: no word", modes_told(bent) == 0)
# A cosine of amplitude A takes pi^2 A^2 / 4L of the length, and P = (1 - A0 / A) Euler with the deflection A0 without P.
A = math.sqrt(4 * LENGTH / math.pi**2 * 2 * EULER / E * LENGTH)
check("bent aside: force in Euler's loads", -bent["reaction_press_x"][-1] / EULER, 1 - ASIDE * LENGTH**4 / (32 * E) / A, 0.01)

# A cantilever under dead loads above that of Euler, in four steps: where its end goes (S. Timoshenko, J. Gere, Theory of elastic
# stability, table 2-4). The second step of the last one passes the load.
ENDS = (1.063, 0.881, 0.422), (1.152, 0.741, 0.593), (1.518, 0.349, 0.792), (2.541, -0.107, 0.750)
for load, x, y in ENDS[:: 1 if long() else 3]:
    r = run(f"elastica_{load}", {**STRUT, "bcs": "hold,press,aside", "bc_press_type": "traction", "bc_press_ux": f"-{load * EULER / 16}*t",
                                 "bc_aside_on": "bottom", "bc_aside_type": "traction", "bc_aside_uy": "1e-9 MPa", "ts_dt": 0.25,
                                 "probe_middle_at": f"{LENGTH},0.5"})
    check(f"cantilever at {load} times Euler's load, its end along the axis", 1 + r["probe_middle_ux"][-1] / LENGTH, x, 3e-3, relative=False)
    check(f"cantilever at {load} times Euler's load, its end across", r["probe_middle_uy"][-1] / LENGTH, y, 3e-3, relative=False)

finish()
