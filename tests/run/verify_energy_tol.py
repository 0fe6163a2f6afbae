# labels: run
# timeout: 120
# long: 200
"""What -energy_tol, -energy_action and -energy_stop do, given and by default, on a bar that is pulled until its strength
falls: with one pass of motion and damage in a step the damage lags behind, so that steps this long miss the first law on
purpose; and on two bars whose impact without an update of contact makes energy."""
import glob
import re

import numpy

import _runs as runs

TOL = 0.02
BAR = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_n": 1,
       "materials": "solid", "material_solid_E": 210e3, "material_solid_nu": 0.3, "material_solid_damage": "at2", "material_solid_split": "volumetric",
       "material_solid_Gc": 2.7, "material_solid_gamma": 0.015, "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0,
       "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right", "bc_pull_ux": "0.04*t", "ts_dt": 0.1,
       "ts_max_time": 1, "coupling_snes_max_it": 1}


def told(run):
    """Residuals that the messages name."""
    return [float(x) for x in re.findall(r"first-law residual (\S+) exceeds -energy_tol", run.log)]


off = runs.run("off", {**BAR, "energy_tol": 0})
residual = abs(off["balance_first_law"])
print("     first-law residual of each step:", " ".join(f"{x:.3g}" for x in residual))
runs.check_between("without the option: the residual passes the bound that is set below", residual.max(), 2 * TOL, 10)
runs.require("with 0: no message", not told(off))

warned = runs.run("warn", BAR)
first = residual[residual > TOL][4]  # the fifth in a row
runs.require("by default: the same history as without", all(
    numpy.array_equal(off[c], warned[c], equal_nan=True) for c in off.history))
runs.require("by default: one message, and again among the closing lines", len(told(warned)) == 2
             and "WARNING" in warned.log and "WARNING" in warned.log.split("smallest dissipation")[1])
for x in told(warned):
    runs.check("by default: the fifth residual beyond 0.02 in the message and in the history", x, first, 1e-2)
runs.require("by default: cause and remedy of a loss without inertia",
             re.search(r"energy lost since.*a crack ran within a step.*more coupling passes", warned.log))
ductile = runs.run("ductile", {**BAR, "material_solid_damage": "at1", "material_solid_model": "j2", "material_solid_sigma_y": 250, "material_solid_hardening": "linear",
                               "material_solid_linear_h": 500, "material_solid_ge": "ductile", "material_solid_alpha_c": 0.1, "material_solid_gp": "ge", "ts_dt": 0.02,
                               "material_solid_gamma": 0.6, "material_solid_Gc": 20, "bc_pull_ux": "0.2*t", "coupling_snes_max_it": 100}, takes_back=True)
runs.require("by default: cause and remedy of ductile damage that lags by a step", re.search(r"energy lost since.*_ge ductile.*-ts_adapt_dalpha", ductile.log))
far = runs.run("far", {**BAR, "ts_dt": 0.25, "ts_max_time": 4})
runs.check_between("what a static run loses ends none: largest residual", abs(far["balance_first_law"]).max(), 0.201, 10)

stopped = runs.run("stop", {**BAR, "energy_tol": TOL, "energy_action": "stop"}, code=5)
runs.require("stop: exit 5 with one message and the remedy", len(told(stopped)) == 1
             and "stopped by -energy_action stop; take smaller steps or more coupling passes" in stopped.log)
runs.require("stop: the history ends before the step beyond the bound", numpy.array_equal(
    stopped["time"], off["time"][:len(stopped["time"])]) and residual[len(stopped["time"])] > TOL
    and residual[:len(stopped["time"])].max() <= TOL)

cut = runs.run("cut", {**BAR, "energy_tol": TOL, "energy_action": "cut"}, refused=17)
runs.require("cut: the refused steps are cut", "time step cut" in cut.log and len(told(cut)) > 0)
runs.check("cut: the run reaches its end", cut["time"][-1], 1, 1e-12)
runs.check_between("cut: tries of a step at most", cut["tries"].max(), 2, 10)
runs.check_between("cut: residual at the end", abs(cut["balance_first_law"][-1]), 0, TOL)
beyond = [x for before, x in zip(abs(cut["balance_first_law"]), abs(cut["balance_first_law"][1:]))
          if x > TOL and x > before]
runs.require("cut: no accepted step passed the bound with a growing residual", not beyond)

# The remedy: passes until motion and damage agree.
agreed = runs.run("agreed", {**BAR, "ts_dt": 0.005, "coupling_snes_max_it": 100, "coupling_snes_atol": 1e-8,
                             "energy_tol": TOL, "energy_action": "stop"})
runs.check("with passes and short steps nothing stops", agreed["time"][-1], 1, 1e-12)

# Energy out of nothing: the trapezoidal forces of contact without any update.
END = 4e-5 if runs.long() else 1.2e-5
BARS = {"ts_newmark_rho": 1, "contact_face_impact": "none", "coupling_snes_max_it": 1}
bars = [runs.option_file("bars_impact.opts")]
on = runs.run("on", {**BARS, "energy_stop": 0, **({} if runs.long() else {"ts_max_time": END})}, files=bars)
gain = on["balance_first_law"]
runs.check_between("bars without an update: largest first-law residual", gain.max(), 0.201, 100)
runs.require("-energy_stop 0 goes on, with one message and again at the end", len(told(on)) == 2
             and on["time"][-1] > 0.99 * END)
ended = runs.run("ended", BARS, files=bars, code=5)
runs.require("by default a run ends beyond 0.2 and says why and what to do", re.search(
    r"exceeds -energy_stop 0.2 .*energy gained", ended.log) and "a shorter -ts_dt" in ended.log
    and "-energy_stop 0 goes on" in ended.log)
last = len(ended["time"])  # rows begin with t = 0: the step that would be the next one
runs.require("the history ends before the fifth step in a row beyond the bound", numpy.array_equal(
    ended["time"], on["time"][:last]) and (gain[last - 4:last + 1] > 0.2).all() and not (gain[last - 5:last] > 0.2).all())
runs.require("and its state is in a checkpoint", glob.glob("ended/checkpoints/*.h5") and "the state at t" in ended.log)

# Steps of a seventh of the contact time: no impact gains energy, whatever the steps damp.
LONG = {"ts_dt": 8e-6, "ts_max_time": 1.5e-4, "outputs": "none", "probes": "none", "measures": "none"}
sphere = [runs.option_file("sphere_impact.opts")]
plain = runs.run("sphere", LONG, files=sphere)
energy = plain["energy_kinetic"] + plain["energy_elastic"]
runs.check_between("a sphere in long steps, by default: largest energy over that of the start", energy.max() / energy[0], 0, 1 + 1e-12)
runs.check_between("a sphere in long steps, by default: what is gained", plain["gain"].max() / energy[0], 0, 1e-12)
runs.check_between("a sphere in long steps, by default: what its impact takes", plain["dissipated_contact"][-1] / energy[0], 0.021, 1)
runs.require("of which the log tells", re.search(r"impacts took 0.* \(dissipated_contact\).* -contact_<id>_impact conserving", plain.log))
damped = runs.run("sphere_damped", {**LONG, "ts_newmark_rho": 0.9}, files=sphere)
energy = damped["energy_kinetic"] + damped["energy_elastic"]
runs.check_between("with -ts_newmark_rho 0.9, which takes no update: largest energy over that of the start", energy.max() / energy[0], 1, 1.02)
traded = runs.run("sphere_traded", {**LONG, "ts_newmark_rho": 0.9, "contact_foot_impact": "stabilised"}, files=sphere)
energy = traded["energy_kinetic"] + traded["energy_elastic"]
runs.check_between("with the update beside it: largest energy over that of the start", energy.max() / energy[0], 0, 1 + 1e-12)
runs.check_between("with the update beside it: what is gained", traded["gain"].max() / energy[0], 0, 1e-12)
runs.require("with the update beside it: no word of energy that is gained", "gained" not in traded.log)

# Pressed slowly by a plane askew in damped steps of 2e5 h/c_p: nothing strikes, and the default is no update.
SLOW = {"units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_n": 8, "materials": "solid", "material_solid_E": 1000,
        "material_solid_nu": 0.3, "material_solid_rho": "1000 kg/m^3", "bcs": "hold", "bc_hold_on": "bottom", "bc_hold_type": "fix",
        "contacts": "plate", "contact_plate_secondary": "top", "contact_plate_primary": "plane", "contact_plate_plane_point": "0,1.001",
        "contact_plate_plane_normal": "0.05,-1", "contact_plate_rigid_uy": "(-0.2*t)", "ts_dt": 0.02, "ts_max_time": 1}
damped = runs.run("slow_damped", {**SLOW, "ts_newmark_rho": 0.8})
static = runs.run("slow_static", {**SLOW, "ts_type": "static"})
runs.require("damped steps that resolve no impact: no update", "impact update: none: damped steps" in damped.log)
runs.check("a block pressed slowly: the force of a static run", damped["contact_plate_force_y"][-1], static["contact_plate_force_y"][-1], 1e-6)
# The force of the update is one within the step.
for rho in (0, 0.5, 0.8, 0.99, 1) if runs.long() else (0, 0.8, 1):
    asked = runs.run(f"slow_asked_{rho}", {**SLOW, "ts_newmark_rho": rho, "contact_plate_impact": "stabilised"})
    runs.check_between(f"the update in such steps, rho {rho}: force", asked["contact_plate_force_y"][-1],
                       static["contact_plate_force_y"][-1] * (1 + 1e-9), static["contact_plate_force_y"][-2])
    runs.check(f"the update in such steps, rho {rho}: energy", asked["energy_elastic"][-1], static["energy_elastic"][-1], 1e-6)
    runs.check_between(f"the update in such steps, rho {rho}: kinetic energy, over what the plane's speed makes of the block's mass",
                       asked["energy_kinetic"][-1] / (1e-9 * 0.2**2 / 2), 0, 1)

# A block whose side jumps by 100 K: the form of the entropy loses energy, which the warning tells the remedy for.
WARM = {"mesh": runs.mesh("block.geo"), "mesh_set_n": 8, "materials": "solid", "material_solid_E": 1e9, "material_solid_nu": 0.3,
        "material_solid_c_v": 1e6, "material_solid_conductivity": 1e4, "material_solid_theta0": 300, "bcs": "hold,hot", "bc_hold_on": "bottom",
        "bc_hold_type": "fix", "bc_hot_on": "top", "bc_hot_type": "temperature", "bc_hot_value": "t > 0 ? 400 : 300", "ts_type": "static",
        "ts_dt": 1, "ts_max_time": 20}
lossy = runs.run("warm", WARM)
runs.require("heat that jumps: the warning names the form that misses nothing", re.search(r"WARNING: .*energy lost.* -heat_form energy", lossy.log))
runs.check("with that form: what the first law misses", abs(runs.run("warm_energy", {**WARM, "heat_form": "energy"})["balance_first_law"]).max(), 0, 1e-8,
           relative=False)

# What is right ends at no bound. A block that flows as soon as it is pressed: half of the work of the first step is missed, a part
# 1/(2 sqrt n - 1) of the work booked in n steps that go with the root of time. Two blocks that overlap at the start, a shrink fit: each
# is pressed by half of the overlap d, with E d^2/8.
DIE = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_n": 8, "materials": "solid",
       "material_solid_E": "70 GPa", "material_solid_nu": 0.33, "material_solid_model": "j2", "material_solid_sigma_y": "5 MPa",
       "bcs": "below,side,die", "bc_below_on": "bottom", "bc_below_uy": 0, "bc_side_on": "left", "bc_side_ux": 0,
       "bc_die_on": "top", "bc_die_uy": "(-0.05*sqrt(t))", "ts_dt": 0.02, "ts_max_time": 1}
pressed = runs.run("die", DIE)
error = pressed["balance_first_law"][1:]
for n in (5, 50):
    runs.check(f"a block that flows at once: what {n} steps miss", error[n - 1], 1 / (2 * n**0.5 - 1), 0.05)
FIT = {"ts_type": "static", "mesh": runs.mesh("two_blocks.geo"), "mesh_set_gap": -1e-5, "materials": "lower,upper", "material_lower_E": 1e9,
       "material_lower_nu": 0, "material_upper_like": "lower", "bcs": "below,above", "bc_below_on": "lower_bottom", "bc_below_type": "fix",
       "bc_above_on": "upper_top", "bc_above_type": "fix", "contacts": "fit", "contact_fit_secondary": "upper_bottom",
       "contact_fit_primary": "lower_top", "contact_fit_initial": "allow", "ts_dt": 0.1, "ts_max_time": 1}
fit = runs.run("fit", FIT)
runs.check("an overlap at the start: its energy", fit["energy_elastic"][-1], 1e9 * 1e-10 / 4, 1e-3)
runs.check("an overlap at the start: the first law", abs(fit["balance_first_law"]).max(), 0, 1e-4, relative=False)

# A rigid ball that goes in by 0.02 of its radius in two steps, from beside a block or 1e-4 in it, by whose energy a tenth less is missed:
# the pressure of the nodes that it comes to counts from the start of the step on, and that is no energy of the start.
BALL = {"ts_type": "static", "mesh": runs.mesh("block.geo"), "mesh_set_n": 40, "materials": "solid", "material_solid_E": 1e9,
        "material_solid_nu": 0.3, "bcs": "below", "bc_below_on": "bottom", "bc_below_type": "fix", "contacts": "ball", "contact_ball_secondary": "top",
        "contact_ball_primary": "rigid_sphere", "contact_ball_radius": 1, "contact_ball_initial": "allow", "contact_ball_rigid_uy": "(-0.02*t)",
        "ts_dt": 0.5, "ts_max_time": 1}
apart, into = (runs.run(f"ball_{name}", {**BALL, "contact_ball_centre": f"0.5,{place}"}) for name, place in (("apart", 2.000001), ("into", 1.9999)))
runs.check_between("a ball that goes in by long steps: the first law", apart["balance_first_law"][-1], -0.3, -0.02)
runs.check("the same from an overlap", into["balance_first_law"][-1], apart["balance_first_law"][-1], 0.15)
for name, run in (("a gap", apart), ("an overlap", into)):
    runs.require(f"from {name}: cause and remedy", re.search(r"WARNING: .*energy lost.*gaps of contacts closed within steps.*shorter -ts_dt", run.log))

# One that opens within a step: the trapezoidal rule misses what the force did until then, once, and the states after it are right.
lift = runs.run("lift", {**FIT, "mesh_set_gap": 0, "bc_above_type": "displacement", "bc_above_ux": 0, "ts_dt": 0.25, "ts_max_time": 4.5,
                         "bc_above_uy": "(-1e-3)*ramp(t,0,1) + 0.011*ramp(t,1,1.5) - 0.011*ramp(t,3.5,4.5)"}, refused=2)
pressing = lift["contact_fit_force_y"]
runs.check("pressed, lifted, pressed again: the second force", pressing[-1], pressing[lift["time"].searchsorted(1)], 1e-6)
runs.check("lifted: no force, no energy", max(abs(pressing[6:14]).max(), lift["energy_elastic"][6:14].max()), 0, 1e-6, relative=False)
runs.require("lifted: a warning at the end alone", len(told(lift)) == 1 and "WARNING" in lift.log and "-energy_action cut" in lift.log and lift["balance_first_law"][8] > 0.5)

# A run that ends before the fifth step beyond the bound says so at its end.
short = runs.run("short", {**BAR, "ts_max_time": float(off["time"][residual > TOL][0])})
runs.require("beyond the bound at the end of a run, once: one warning", len(told(short)) == 1 and "WARNING" in short.log)

runs.finish()
