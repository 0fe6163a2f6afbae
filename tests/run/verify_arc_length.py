# labels: run
# timeout: 240
# long: 300
"""Static steps that follow bodies past limits of their load (theory.md, 10, (P4), (P5)): a deep arch through limit and snap-back
against the elastica, its load against the published one; a rubber sphere under follower pressure and a bar that flows against closed
forms; the same path by a prescribed displacement; restarts, refused tries, two ranks; refusals."""
import os

import numpy

import _runs as runs

R, HALF, EI = 100.0, numpy.radians(107.5), 1e6


def arch(name, ranks=1, **more):
    run = runs.run(name, {"output_overwrite": "on", **more}, [runs.option_file("arch.opts")], ranks=ranks, refused=1)
    return run, 100 * run["load_parameter"], numpy.c_[run["mean_load_ux"], run["mean_load_uy"]]


def elastica(force_x, force_y, turned, load, points=80):
    """An inextensible arch of those dimensions from its hinge, which holds it by a force and has turned: position and angle of the
    tangent at the crown, where the load is, and at the clamp."""
    y = numpy.array([-R * numpy.sin(HALF), R * numpy.cos(HALF), HALF + turned, 0.0])  # x, y, angle, moment
    h, found = R * HALF / points, []
    for downwards in (0, load):
        nx, ny = -force_x, downwards - force_y

        def rate(y):
            c, s = numpy.cos(y[2]), numpy.sin(y[2])
            return numpy.array([c, s, y[3] / EI - 1 / R, s * nx - c * ny])

        for _ in range(points):
            a = rate(y)
            b = rate(y + h / 2 * a)
            c = rate(y + h / 2 * b)
            y = y + h / 6 * (a + 2 * b + 2 * c + rate(y + h * c))
        found.append(y[:3])
    return found


def nearest(unknowns, u, load, way):
    """The state of the elastica on the plane across the path at a displacement u of the crown and a load."""
    scale = numpy.array([100, 100, 1, 100])

    def residual(q):
        crown, clamp = elastica(*q)
        return numpy.array([clamp[0] - R * numpy.sin(HALF), clamp[1] - R * numpy.cos(HALF), R * (clamp[2] + HALF),
                            way @ numpy.append(crown[:2] - [0, R] - u, (q[3] - load) / 10)])

    for _ in range(40):
        r = residual(unknowns)
        slope = numpy.array([(residual(unknowns + 1e-6 * scale * e) - r) / 1e-6 for e in numpy.eye(4)]).T
        step = -numpy.linalg.solve(slope, r)
        unknowns = unknowns + scale * step * min(1, 0.3 / abs(step).max())
        if abs(step).max() < 1e-8:
            break
    return unknowns


run, load, u = arch("arch")
peak = load.argmax()
runs.check("arch: the load that it bears, 897 by D. DaDeppo and R. Schmidt (1975)", load[peak], 897, 3e-3)
runs.require(f"arch: {len(load) - 1} steps from nothing through the limit and back up to {load[-1]:.0f} N", load[-1] < 0.1 * load[peak])
runs.require("arch: the crown comes back up", u[-1, 1] > u[:, 1].min() + 1)
exact, loads, places = numpy.zeros(4), [], []
states = [1, 2, *range(4, len(load) - 1, 4)]
for i in states:
    way = numpy.append(u[i + 1] - u[i - 1], (load[i + 1] - load[i - 1]) / 10)
    exact = nearest(exact if i > 1 else numpy.array([0, 0, 0, load[1]]), u[i], load[i], way / numpy.linalg.norm(way))
    loads.append(exact[3])
    places.append(elastica(*exact)[0][:2] - [0, R])
runs.check("arch: load against the elastica, over its largest", abs(numpy.array(loads) - load[states]).max() / load[peak], 0, 2e-3, relative=False)
runs.check("arch: place of the crown against the elastica, over R", abs(numpy.array(places) - u[states]).max() / R, 0, 1e-3, relative=False)

# The way back of a coarser one: a restart, tries that are refused, two ranks; the same states where the crown's place is given.
COARSE = {"mesh_set_n": 120 if runs.long() else 80, "ts_max_time": 50}
whole, force, way = arch("whole", checkpoint_every=44, **COARSE)
for steps, restart in ((44, "none"), (400, "auto")):
    again = arch("again", ts_max_steps=steps, restart=restart, output_overwrite="off", **COARSE)[0]
runs.require("arch: a restart on the way back changes no bit", all(numpy.array_equal(whole[c], again[c], equal_nan=True) for c in whole.history))
for name, ranks, more in (("two", 2, {}), ("tried", 1, {"test_restep": 1})):
    other = arch(name, ranks=ranks, **more, **COARSE, **({} if runs.long() else {"ts_max_steps": 6}))[0]
    for column in ("load_parameter", "mean_load_uy", "energy_elastic"):
        apart = abs(other[column] - whole[column][:len(other["time"])]).max()
        runs.check(f"arch, {name}: {column} over its largest", apart / abs(whole[column]).max(), 0, 1e-6, relative=False)
if runs.long():
    given, crown, _ = arch("given", bc_load_type="displacement", bc_load_uy="0 - 100*t", **COARSE)
    runs.check("arch, crown moved downwards: it comes back by", crown[-1] - crown.max(), way[:, 1].min() - way[-1, 1], 0.01)
    runs.check("arch, crown moved downwards: largest reaction", -given["reaction_load_y"].min(), force.max(), 1e-3)

# A path that begins where loads were given, and one that is left.
ramp = {key: value for key, value in COARSE.items() if key != "ts_max_time"}
text = open(runs.option_file("arch.opts")).read()
with open("given.opts", "w") as file: # without the path
    file.write("\n".join(line for line in text.splitlines() if not line.startswith("-ts_path")).replace("../meshes", os.path.dirname(runs.mesh("arch.geo"))))
if runs.long():
    loaded = runs.run("loaded", {"output_dir": "loaded", **ramp, "ts_dt": 1, "ts_max_time": 3}, ["given.opts"])
    on = runs.run("on", {"output_dir": "on", **ramp, "ts_max_time": 45, "restart": "loaded/checkpoints/checkpoint_000001.h5", "restart_allow": "ts_path_length"},
                  [runs.option_file("arch.opts")], refused=1)
    runs.check("arch, loads given to 300 N, then followed: its limit", 100 * on["load_parameter"].max(), force.max(), 1e-3)
    on = runs.run("rises", {"output_dir": "rises", **ramp, "ts_max_time": 15}, [runs.option_file("arch.opts")])
    left = runs.run("left", {"output_dir": "left", **ramp, "bc_load_uy": f"0 - {100 * on['load_parameter'][-1]}", "ts_dt": 1, "ts_max_time": 16,
                             "restart": "rises/checkpoints/checkpoint_000001.h5", "restart_allow": "ts_path_length,bc_load_uy"}, ["given.opts"])
    runs.check("arch, followed and then held at its load: it stays", left["mean_load_uy"][-1], on["mean_load_uy"][-1], 1e-6)
    runs.require("arch, held: the run says that its conditions are at t now", "followed a path" in left.log)

# Loads that end: there the path does, too.
for name, ends, at in (("ramp", "ramp(t,0,4)", "load_parameter 4"), ("below", "t<0 ? 0 : t", "load_parameter -"))[: 2 if runs.long() else 0]:
    done = runs.run(f"ends_{name}", {"output_dir": f"ends_{name}", "mesh_set_n": 120, "bc_load_uy": f"0 - 100*({ends})", "ts_max_time": 90},
                    [runs.option_file("arch.opts")], code=5, refused=None)
    said = [line for line in done.log.splitlines() if "no condition changes with t" in line]
    runs.require(f"loads that end ({ends}): {said[-1][-60:] if said else 'no word'}", bool(said) and at in said[-1])
    runs.require(f"loads that end ({ends}): no step beyond", done["load_parameter"].max() < 9.3 and done["load_parameter"].min() > -1e-3)

# An incompressible shell of radii 1 and 2 under inner pressure (A. Green, W. Zerna): the pressure has a limit.
sphere = runs.run("sphere", {
    "mesh": runs.mesh("ring.geo"), "mesh_set_radius": 1.5, "mesh_set_thickness": 1, "mesh_set_oval": 0, "mesh_set_n_around": 80 if runs.long() else 40,
    "mesh_set_n_through": 16 if runs.long() else 8, "order": 2, "plane": "axisymmetric", "units": "mm_t_s_MPa", "materials": "ring", "material_ring_K": 1e4,
    "material_ring_G": 1, "bcs": "axis,equator,push", "bc_axis_on": "cut", "bc_axis_ux": 0, "bc_equator_on": "right", "bc_equator_uy": 0,
    "bc_push_on": "inside", "bc_push_type": "pressure", "bc_push_value": "t", "probes": "in", "probe_in_at": "1,0", "ts_type": "static",
    "ts_dt": 1, "ts_max_time": 30, "ts_path_length": 0.1})
inner = 1 + sphere["probe_in_ux"]
outer = (1 + (inner**3 - 1) / 8)**(1 / 3)
pressure = 2 / outer + 0.5 / outer**4 - 2 / inner - 0.5 / inner**4
runs.check("sphere: pressure over its limit, against the closed form", abs(sphere["load_parameter"] - pressure).max() / pressure.max(), 0, 1e-3, relative=False)
runs.require("sphere: far beyond its limit", sphere["load_parameter"][-1] < 0.7 * pressure.max())

# A cube under a dead traction flows with the stress 200 + 500 alpha^0.3 MPa: the traction has a limit (A. Considere).
BAR = {"mesh": runs.mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 1, "units": "mm_t_s_MPa", "materials": "solid",
       "material_solid_E": 200e3, "material_solid_nu": 0.3, "material_solid_model": "j2", "material_solid_hardening": "johnson_cook",
       "material_solid_jc_a": 200, "material_solid_jc_b": 500, "material_solid_jc_n": 0.3, "bcs": "x,y,z,pull", "bc_x_on": "left",
       "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_z_on": "back", "bc_z_uz": 0, "bc_pull_on": "right", "ts_type": "static"}
bar = runs.run("bar", {**BAR, "bc_pull_type": "traction", "bc_pull_ux": "t", "ts_path_length": 0.01, "ts_dt": 1, "ts_max_time": 60})
stretched = runs.run("stretched", {**BAR, "bc_pull_ux": "t", "ts_dt": 0.0025, "ts_max_time": 0.61})
traction = numpy.interp(bar["mean_pull_ux"], stretched["time"], stretched["reaction_pull_x"])
runs.check("bar: traction against the reaction where it is stretched", abs(bar["load_parameter"] - traction)[2:].max() / traction.max(), 0, 1e-3, relative=False)
runs.check("bar: each step moves its end by the length asked", abs(numpy.diff(bar["mean_pull_ux"])[1:] / 0.01 - 1).max(), 0, 0.02, relative=False)
alpha = numpy.linspace(1e-6, 1, 100001)
runs.check("bar: limit of a rigid-plastic one", bar["load_parameter"].max(), ((200 + 500 * alpha**0.3) * numpy.exp(-alpha)).max(), 3e-3)

BOX = {"mesh": runs.mesh("block.geo"), "materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3, "bcs": "hold,pull",
       "bc_hold_on": "left", "bc_hold_type": "fix", "bc_pull_on": "right", "bc_pull_ux": "t", "ts_type": "static", "ts_path_length": 1, "ts_dt": 0.1,
       "ts_max_time": 1}
for name, more, word in runs.some((("inertia", {"ts_type": "newmark", "material_solid_rho": 1}, "is for motion with -ts_type static"),
                         ("crack", {"material_solid_damage": "at2", "material_solid_Gc": 1, "material_solid_gamma": 0.5}, "follow cracks by -ts_path_dissipation"),
                         ("heat", {"material_solid_c_v": 1}, "knows no heat"),
                         ("rate", {"material_solid_b_d": 1}, "has no time for rates to be of (-material_solid_b_d)"),
                         ("touch", {"contacts": "a", "contact_a_secondary": "left", "contact_a_primary": "rigid_plane",
                                    "contact_a_plane_point": "0,0", "contact_a_plane_normal": "1,0"}, "knows no contact"),
                         ("search", {"motion_snes_linesearch_type": "bt"}, "whose steps are full ones"),
                         ("nothing", {"bc_pull_ux": 0}, "no condition moves or loads a body")), 3):
    refused = runs.run(f"refused_{name}", {**BOX, **more}, code=2)
    said = next((line for line in refused.log.splitlines() if "ts_path_length" in line), "nothing")
    runs.require(f"refused: {name}: {said[:110]}", word in said)
runs.finish()
