"""Griffith's strip (meshes/griffith_strip.geo, options/griffith_strip.opts): the load at which its crack starts, by energies."""
import math

import numpy
from _runs import check_between, option_file, require, run

E, GC, HALF = 70e3, 0.01, 1.0  # MPa, N/mm, mm
RAISED = 0.005  # steps of the load about the start, as a part of it


def damage_ahead(u, gamma):
    """Energy density of the undamaged strip whose edges move by u each, and its homogeneous phi (AT2)."""
    psi = E * (u / HALF) ** 2 / 2
    return psi, 2 * psi / (2 * psi + GC / gamma)


def released(u, gamma):
    """Elastic energy that the strip ahead of the crack holds, by length: it is gone behind it."""
    psi, phi = damage_ahead(u, gamma)
    return 2 * HALF * (1 - phi) ** 2 * psi


def cost(u, gamma, h):
    """Energy of the crack by length beyond what the strip ahead is damaged by already: Gc for the two flanks, cut off where
    they meet the phi ahead, and h/(2 gamma) of it for the row of cells between them with phi = 1."""
    phi = damage_ahead(u, gamma)[1]
    return GC * (1 + h / (2 * gamma)) - GC * phi * phi * (1 + math.log(1 / phi))


def start_of_crack(gamma, h):
    low, high = 1e-6, 1e-2
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if released(middle, gamma) < cost(middle, gamma, h) else (low, middle)
    return low


def strip(name, gamma, h, options=(), **more):
    """Runs the option file up to 1.1 times the load of the start in steps of a two-hundredth."""
    u_c = start_of_crack(gamma, h)
    return u_c, run(name, {"material_strip_gamma": gamma, "mesh_set_h": h, "param_uc": u_c, "ts_times": "0,0.97,1.1",
                           "ts_dts": f"0.485,{RAISED}", "output_vis_dt": 10, **dict(options)},
                    [option_file("griffith_strip.opts")], **more)


def check_strip(name, gamma, h, length, slot, u_c, r):
    """Start, passage and energies of such a run."""
    jump = len(r["time"]) - 1
    before, after = jump - 1, jump
    check_between(f"{name}: load at which the crack starts over that by energies", r["time"][jump] - RAISED / 2, 0.97, 1.03)
    require(f"{name}: it has not moved a step before and has run through after", numpy.isnan(r["crack_strip_tip_x"][before])
            and r["crack_strip_tip_x"][after] == length)
    require(f"{name}: no try was refused", r["tries"].max() == 1 if "tries" in r.history else "time step cut" not in r.log)
    require(f"{name}: the log says how far it ran", f"crack ran: phi > 0.9 on {length - slot:.4g} mm, 0 before" in r.log)
    run_length, u = length - slot, u_c * r["time"][before]
    own = run_length * 2 * HALF * GC / (2 * gamma) * damage_ahead(u, gamma)[1] ** 2
    crack = (r["energy_fracture"][after] - own) / run_length
    check_between(f"{name}: energy of the crack by length, less the strip's own damage, over Gc (1 + h/(2 gamma))",
                  crack / (GC * (1 + h / (2 * gamma))), 0.95, 1.05)
    # What the jump must release: the energy that the strip held, at the load of the jump, less what is left and what the crack
    # costs. Nothing else may be missing.
    held = r["energy_elastic"][before] * (r["time"][jump] / r["time"][before]) ** 2 + r["energy_fracture"][before]
    left = r["energy_elastic"][after] + own + run_length * cost(u, gamma, h)
    lost = r["balance_first_law"][before] - r["balance_first_law"][after]
    check_between(f"{name}: what the first law lacks after the jump, {lost:.4f} of the work, over what this must release", lost
                  * r["work_external"].max() / (held - left), 0.8, 1.2)
    check_between(f"{name}: the first law before", abs(r["balance_first_law"][:jump]).max(), 0, 0.04)
