# labels: run
# long: 300
# timeout: 240
"""Springs and dashpots under surfaces, theory.md (3'): a block on springs (every frame and order, to rounding), a beam on an
elastic foundation (Hetenyi), inclined planes of symmetry (Lame), a damped oscillator, waves that leave a bar to rounding and a
plate at all angles, explicit beside implicit steps, energies, ranks, restart, and what cannot be."""
import math

import numpy

from _runs import check, check_between, finish, long, mesh, option_file, require, run, some

BODY = {"mesh": mesh("block.geo"), "mesh_set_n": 4, "materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3,
        "material_solid_rho": 1000}
STATIC = {"ts_type": "static", "ts_dt": 1, "ts_max_time": 1}

# A block under tension on springs.
PULLED = {**BODY, **STATIC, "bcs": "load,base,side", "bc_load_on": "top", "bc_load_type": "traction", "bc_load_uy": "10*t",
          "bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_stiffness": 1e5, "bc_side_on": "left", "bc_side_type": "symmetry"}
IN_SPACE = {"mesh_set_dim": 3, "bcs": "load,base,side,back", "bc_back_on": "back", "bc_back_type": "symmetry"}
FRAMES = [("plane strain", 1, {}), ("plane stress", 0.5, {"plane": "stress", "thickness": 0.5}), ("triangles of second order", 1, {"order": 2, "mesh_set_simplex": 1}),
          ("serendipity", 1, {"order": 2, "mesh_serendipity": 1}), ("axisymmetric", math.pi, {"plane": "axisymmetric"}),
          ("hexahedra", 1, IN_SPACE), ("hexahedra of second order", 1, {**IN_SPACE, "order": 2, "mesh_set_n": 2}),
          ("tetrahedra of second order", 1, {**IN_SPACE, "order": 2, "mesh_set_simplex": 1, "mesh_set_n": 2})]
for name, area, more in some(FRAMES, 2):
    block = run("pulled", {**PULLED, **more})
    check(f"pulled, {name}: displacement on the springs", block["mean_base_uy"][-1], 1e-4, 1e-9)
    check(f"pulled, {name}: force of the springs", block["reaction_base_y"][-1], -10 * area, 1e-9)
    check(f"pulled, {name}: energy of the springs", block["energy_foundation"][-1], 0.5e-3 * area, 1e-9)
    check(f"pulled, {name}: first law", block["balance_first_law"][-1], 0, 1e-6, relative=False)
    check_between(f"pulled, {name}: Newton iterations", block["newton"][-1], 1, 3)
# Pushed aside: springs across the normal, at a stiffness that grows along the surface, hold a block that nothing else does.
aside = run("aside", {**BODY, **STATIC, "bcs": "load,base", "bc_load_on": "solid", "bc_load_type": "body_force", "bc_load_ux": 1e-4,
                      "bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_stiffness": 1e6, "bc_base_stiffness_tangential": "1e5*(1+x)"})
check("aside: force of the springs", aside["reaction_base_x"][-1], -0.1, 1e-9)
check("aside: no force across", aside["reaction_base_y"][-1], 0, 1e-9, relative=False)

# Half of a long beam (plane stress) under a force in its middle: w = P lambda / 2k, with lambda h = 0.05.
H, LAMBDA = 0.1, 0.5
K = 4 * LAMBDA**4 * 1e6 * H**3 / 12
beam = run("beam", {**BODY, **STATIC, "plane": "stress", "order": 2, "mesh_set_lx": 14, "mesh_set_ly": H, "mesh_set_n": 140, "mesh_set_ny": 1,
                    "bcs": "middle,load,base", "bc_middle_on": "left", "bc_middle_type": "symmetry", "bc_load_on": "left",
                    "bc_load_type": "force", "bc_load_uy": -1e-5, "bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_stiffness": K})
check("beam on an elastic foundation: displacement under the force (Hetenyi)", beam["mean_load_uy"][-1], -2e-5 * LAMBDA / (2 * K), 5e-3)

# A sector of 30 degrees of a thick tube, 1 to 2 m, whose planes of symmetry stiff springs hold: Lame's displacements.
with open("sector.geo", "w", encoding="ascii") as file:
    file.write("""c = Cos(Pi/12); s = Sin(Pi/12);
Point(1) = {0, 0, 0};
Point(2) = {Cos(Pi/18), Sin(Pi/18), 0};
Point(3) = {2*Cos(Pi/18), 2*Sin(Pi/18), 0};
Point(4) = {2*Cos(2*Pi/9), 2*Sin(2*Pi/9), 0};
Point(5) = {Cos(2*Pi/9), Sin(2*Pi/9), 0};
Line(1) = {2, 3}; Circle(2) = {3, 1, 4}; Line(3) = {4, 5}; Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 9; Transfinite Curve {2, 4} = 7; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("solid") = {1}; Physical Curve("sides") = {1, 3}; Physical Curve("inside") = {4};
""")
SECTOR = {**BODY, **STATIC, "mesh": "sector.geo", "order": 2, "bcs": "sides,inside", "bc_sides_on": "sides", "bc_sides_type": "foundation",
          "bc_sides_stiffness": 1e12, "bc_inside_on": "inside", "bc_inside_type": "pressure", "bc_inside_value": 1,
          "probes": "in", "probe_in_at": f"{math.cos(math.pi / 18)},{math.sin(math.pi / 18)}", "probe_in_fields": "u"}
del SECTOR["mesh_set_n"]
sector = run("sector", SECTOR)
radial = sector["probe_in_ux"][-1] * math.cos(math.pi / 18) + sector["probe_in_uy"][-1] * math.sin(math.pi / 18)
check("sector of a tube: displacement inside (Lame)", radial, 1.3 / 1e6 / 3 * (0.4 + 4), 1e-4)

# A stiff block on springs and dashpots: u = v_0/w_d exp(-z w t) sin(w_d t), and half of k u^2.
OSCILLATOR = {**BODY, "material_solid_nu": 0, "material_solid_E": 1e7, "mesh_set_n": 1, "bcs": "base", "bc_base_on": "bottom",
              "bc_base_type": "foundation", "bc_base_stiffness": 1000, "bc_base_stiffness_tangential": 1000, "bc_base_damping": 400, "bc_base_damping_tangential": 0,
              "ics": "start", "ic_start_on": "solid", "ic_start_vy": 1e-3, "ts_max_time": 8}
for kind, more in (("newmark", {"ts_dt": 0.02}), ("newmark", {"ts_dt": 0.02, "ts_newmark_rho": 0.8}), ("central_difference", {"ts_dt": "auto"})):
    block = run("block", {**OSCILLATOR, "ts_type": kind, **more})
    t, damped = block["time"], math.sqrt(1 - 0.2**2)
    exact = 1e-3 / damped * numpy.exp(-0.2 * t) * numpy.sin(damped * t)
    check(f"oscillator, {kind}: displacement", abs(block["mean_base_uy"] - exact).max() / exact.max(), 0, 2e-3, relative=False)
    check(f"oscillator, {kind}: energy of the springs", abs(block["energy_foundation"] - 500 * exact**2).max() / 5e-4, 0, 3e-3, relative=False)
    check(f"oscillator, {kind}: what dashpots took is what the block lost",
          block["dissipated_foundation"][-1] + block["energy_kinetic"][-1] + block["energy_elastic"][-1] + block["energy_foundation"][-1], 5e-4, 2e-3)
    check(f"oscillator, {kind}: first law", abs(block["balance_first_law"]).max(), 0, 1e-6, relative=False)

# Waves that run to both ends of a bar leave it: to rounding by steps of h/c, in which they move by a cell.
BAR = {**BODY, "material_solid_nu": 0, "mesh_set_lx": 1, "mesh_set_ly": 0.1, "mesh_set_n": 50, "mesh_set_ny": 1, "bcs": "flat,ends",
       "bc_flat_on": "top,bottom", "bc_flat_type": "displacement", "bc_flat_uy": 0, "bc_ends_on": "left,right", "bc_ends_type": "absorbing",
       "ics": "pulse", "ic_pulse_on": "solid", "ic_pulse_vx": "abs(x-0.4)<0.2 ? 1e-6*cos(pi*(x-0.4)/0.4)^2 : 0", "ts_max_time": 0.04}
EXPLICIT = {"ts_type": "central_difference", "ts_dt": "auto"}


def echo(wave):
    """Energy at the end over that of the start."""
    return (wave["energy_kinetic"][-1] + wave["energy_elastic"][-1]) / wave["energy_kinetic"][0]


bar = run("bar", {**BAR, **EXPLICIT, "ts_dt": 0.02 / math.sqrt(1000), "ts_dt_cfl": 1})
check("bar, steps of h/c: energy of the echo", echo(bar), 0, 1e-12, relative=False)
check("bar: energy that left", bar["dissipated_foundation"][-1], bar["energy_kinetic"][0], 1e-6)
check("bar, half of these steps: energy of the echo", echo(run("bar_half", {**BAR, **EXPLICIT, "ts_dt_cfl": 0.5})), 0, 1e-4, relative=False)
check("bar, implicit: energy of the echo", echo(run("bar_implicit", {**BAR, "ts_dt": 5e-4})), 0, 1e-3, relative=False)
sheet = run("sheet", {**BAR, **EXPLICIT, "material_solid_nu": 0.3, "plane": "stress"})
check("bar, a sheet with nu 0.3 held across: energy of the echo", echo(sheet), 0, 1e-4, relative=False)

# A disc that bursts in a plate: waves of both kinds at all angles.
PLATE = {**BODY, "mesh_set_n": 40, "bcs": "ends", "bc_ends_on": "left,right,top,bottom", "bc_ends_type": "absorbing", "ics": "burst",
         "ic_burst_on": "solid", "ic_burst_vx": "1e-3*(x-0.4)*exp(-100*((x-0.4)^2+(y-0.5)^2))",
         "ic_burst_vy": "1e-3*(y-x)*exp(-100*((x-0.4)^2+(y-0.5)^2))", "ts_max_time": 0.08}
plate = run("plate", {**PLATE, **EXPLICIT})
slow = run("plate_implicit", {**PLATE, "ts_dt": 4e-4})
for name, wave in (("explicit", plate), ("implicit", slow)):
    check_between(f"plate, {name}: energy of the echo", echo(wave), 0, 0.02)
    check(f"plate, {name}: first law", abs(wave["balance_first_law"]).max(), 0, 1e-6, relative=False)
check("plate: what left by both schemes", slow["dissipated_foundation"][-1] / slow["energy_kinetic"][0],
      plate["dissipated_foundation"][-1] / plate["energy_kinetic"][0], 1e-3)

# Lamb's problem: the speed of the wave on the surface, and what is left.
if long():
    lamb = run("lamb", {}, files=[option_file("lamb.opts")], ranks=2)
    grid = numpy.arange(0, 0.06, 2e-6)
    near, far = (numpy.interp(grid, lamb["time"], lamb[f"probe_{name}_uy"]) for name in ("near", "far"))
    alone = grid < 0.036  # the first one passes
    late = max(range(10000, 15000, 5), key=lambda steps: near[alone] @ numpy.roll(far, -steps)[alone])
    check("Lamb: speed of Rayleigh's wave", 40 / (2e-6 * late), 0.91940 * math.sqrt(7.5e9 / 2500), 0.003)
    check_between("Lamb: energy of the echo", (lamb["energy_kinetic"] + lamb["energy_elastic"])[-1] / lamb["work_external"][-1], 0, 0.01)

# Cells of second order in space, where corners of facets have no area of their own: explicit beside implicit steps, two
# ranks beside one, restart.
CUBE = {**BODY, "mesh_set_dim": 3, "mesh_set_simplex": 1, "mesh_set_n": 2, "order": 2, "bcs": "base,ends", "bc_base_on": "bottom",
        "bc_base_type": "foundation", "bc_base_stiffness": 1e4, "bc_base_stiffness_tangential": 1e4, "bc_base_damping": 400,
        "bc_base_damping_tangential": "100*(1+x)", "bc_ends_on": "right", "bc_ends_type": "absorbing", "ics": "start", "ic_start_on": "solid",
        "ic_start_vy": 1e-3, "ic_start_vz": 2e-3, "ts_max_time": 1}
STRAIGHT = {**CUBE, "ic_start_vz": 0, "bc_ends_type": "foundation", "bc_ends_damping": 200}  # does not rock
cube = run("cube", {**STRAIGHT, **EXPLICIT})
slow = run("cube_implicit", {**STRAIGHT, "ts_dt": 2e-3})
for column in ("dissipated_foundation", "energy_foundation"):
    check(f"cube: {column} by both schemes", abs(numpy.interp(slow["time"], cube["time"], cube[column]) - slow[column]).max() / cube[column].max(),
          0, 5e-3, relative=False)
for name, options in (("explicit", {**CUBE, **EXPLICIT}), ("implicit", {**CUBE, "ts_dt": 2e-3})):
    one = run("one", {**options, "checkpoint_every": 60, "checkpoint_keep": 99})
    two = run("two", options, ranks=2)
    again = run("again", {**options, "restart": "one/checkpoints/checkpoint_000001.h5"})
    for column in ("dissipated_foundation", "energy_foundation", "reaction_base_y", "reaction_ends_x"):
        check(f"cube, {name}, 2 ranks: {column}", abs(two[column] - one[column]).max() / abs(one[column]).max(), 0, 1e-9, relative=False)
        require(f"cube, {name}, restart: {column} bit for bit", (again[column][-20:] == one[column][-20:]).all())
# Dashpots far stronger than rho c under a body that is in motion at the start, and where explicit steps begin at a restart.
STRONG = {**BODY, "material_solid_E": 1e9, "material_solid_nu": 0, "mesh_set_n": 8, "bcs": "base", "bc_base_on": "bottom", "bc_base_type": "foundation",
          "ics": "start", "ic_start_on": "solid", "ic_start_vy": -1, "ts_max_time": 0.02}
for damping in some((1e8, 1e7, 1e9), 2):
    strong = run("strong", {**STRONG, **EXPLICIT, "bc_base_damping": damping})
    check_between(f"dashpots of {damping:.0e}: kinetic energy over that of the start", strong["energy_kinetic"].max() / 500, 0, 1.0001)
    check_between(f"dashpots of {damping:.0e}: least of what they took", strong["dissipated_foundation"].min(), 0, 500)
    check(f"dashpots of {damping:.0e}: first law", abs(strong["balance_first_law"]).max(), 0, 1e-4, relative=False)
run("slow", {**STRONG, "bc_base_damping": 1e8, "ts_dt": 1e-4, "ts_max_time": 2e-3})
strong = run("strong", {**STRONG, **EXPLICIT, "bc_base_damping": 1e8, "restart": "slow/checkpoints/checkpoint_000001.h5", "restart_allow": "ts_type,ts_dt"})
check_between("begun by implicit steps: kinetic energy over that of the start", strong["energy_kinetic"].max() / 500, 0, 1.0001)
check("begun by implicit steps: first law", abs(strong["balance_first_law"]).max(), 0, 3e-4, relative=False)

# A foundation that a run leaves out at a restart takes along what its springs stored; what dashpots took stays in the books.
let_go = {**OSCILLATOR, "ts_dt": 0.02, "ts_max_time": 2, "checkpoint_every": 50, "checkpoint_keep": 9}
before = run("before", let_go)
after = run("after", {**{key: value for key, value in let_go.items() if not key.startswith("bc")}, "restart": "before/checkpoints/checkpoint_000001.h5",
                      "restart_allow": "bcs,bc_base"})
check("left out at a restart: work of the letting go, and half of the first step's", after["work_external"][-1], -before["energy_foundation"][50], 0.02)
check("left out at a restart: what dashpots took", after["dissipated_foundation"][-1], before["dissipated_foundation"][50], 1e-12)
check("left out at a restart: first law", abs(after["balance_first_law"]).max(), 0, 1e-6, relative=False)

# A steel cube on soft springs and dashpots (0.5 Hz) under a force of a tenth of a millinewton: by Runge and Kutta, 4.0044e-7 m.
ISOLATED = {**BODY, "mesh_set_dim": 3, "mesh_set_n": 2, "mesh_set_lx": 0.1, "mesh_set_ly": 0.1, "mesh_set_lz": 0.1, "material_solid_E": 210e9,
            "material_solid_rho": 7850, "bcs": "base,load", "bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_stiffness": 8e3,
            "bc_base_stiffness_tangential": 8e3, "bc_base_damping": 80, "bc_load_on": "top", "bc_load_type": "force",
            "bc_load_uy": "1e-4*sin(2*pi*2*t)", "ts_dt": 0.005, "ts_max_time": 2}
isolated = run("isolated", ISOLATED)
check("isolated cube, a small force: largest displacement", abs(isolated["mean_load_uy"]).max(), 4.00442e-7, 1e-3)
# Without springs such a force is below what counts: that is told.
free = run("free", {**{key: value for key, value in ISOLATED.items() if not key.startswith("bc_base")}, "bcs": "load"})
require("a free cube under a force below the absolute tolerance: told", "loads moved nothing" in free.log and "-motion_snes_atol" in free.log)
require("on springs: not told", "loads moved nothing" not in isolated.log)
# Springs alone bound the step: without them the cells allow longer ones, which would be unstable.
held = run("held", {**OSCILLATOR, **EXPLICIT, "bc_base_stiffness": 1e9, "bc_base_damping": 0, "ts_max_time": 0.5})
check("stiff springs, explicit: first law", abs(held["balance_first_law"]).max(), 0, 1e-4, relative=False)
check_between("stiff springs, explicit: steps are shorter", held["dt"][-1], 0, 1e-3)

REFUSED = [("no value", {"bc_base_on": "bottom", "bc_base_type": "foundation"}, 2, "-bc_base_stiffness: missing; allowed: at least one of"),
           ("a value that changes", {"bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_stiffness": "1+t"}, 2, "does not change with t"),
           ("a negative one", {"bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_damping": "x-0.5"}, 3, "-bc_base_damping"),
           ("springs of another type", {"bc_base_on": "bottom", "bc_base_type": "fix", "bc_base_stiffness": 1}, 2, "allowed with type foundation"),
           ("points", {"bc_base_on": "origin", "bc_base_type": "foundation", "bc_base_stiffness": 1}, 3, "-bc_base_on"),
           ("waves without inertia", {"bc_base_on": "bottom", "bc_base_type": "absorbing"}, 2, "waves need inertia"),
           ("dashpots along a path", {"bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_damping": 1, "ts_path_length": 1e-3}, 2, "steps along a path"),
           ("a rigid body", {"bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_stiffness": 1, "ts_type": "newmark", "ts_dt": 1e-3,
                             "material_solid_model": "rigid", "material_solid_E": None, "material_solid_nu": None}, 3, "is rigid"),
           ("a block that slips", {"bc_base_on": "bottom", "bc_base_type": "foundation", "bc_base_stiffness": 1}, 3, "is not held against")]
for name, more, code, words in some(REFUSED, 2):
    options = {key: value for key, value in {**BODY, **STATIC, "bcs": "base", **more}.items() if value is not None}
    require(f"{name}: told", words in run("refused", options, code=code).log)
finish()
