# labels: run
# timeout: 120
"""Fatigue under cyclic loads. One cell at constant amplitude against a recurrence written here; lives fall with the
amplitude; energy, heat and entropy; where nothing moves nothing tires; runs that stop by themselves; rows of the
history at the turning points of chosen cycles."""
import math

import numpy

import _fatigue as fatigue
import _runs as runs
from _fatigue import GC, REST, WIDTH, stretched, wave

RATE = 0.5
SOLID, CELL = ({**options, "material_solid_fatigue_a": RATE} for options in (fatigue.SOLID, fatigue.CELL))


def recurrence(strain, times, rate=math.inf):
    """phi and Fat at these times: backward Euler of the damage equation with Fat of the step before, bounded below by
    the last phi and by 1 above, then the growth of Fat."""
    phi, fat = [0.0], [0.0]
    for before, now in zip(times, times[1:]):
        (_, S_n), (energy, S) = stretched(1 + strain(before)), stretched(1 + strain(now))
        drive, inertia = 2 * (1 - REST) * energy, (1 - phi[-1]) / rate / (now - before)
        root = (drive + fat[-1] / WIDTH + inertia * phi[-1]) / (drive + GC / WIDTH + inertia)
        phi.append(min(1, max(phi[-1], root)))
        work = (S + S_n) / 4 * ((1 + strain(now)) ** 2 - (1 + strain(before)) ** 2)
        fat.append(fat[-1] + RATE / WIDTH * (1 - phi[-1]) * phi[-1] * abs(work))
    return numpy.array(phi), numpy.array(fat)


# Constant amplitude, rate-independent and with a rate.
for name, steps, more in (("four", 4, {}), ("rate", 1 / 0.3, {"material_solid_c": 3.0})):
    run = runs.run(f"cell_{name}", {**CELL, **more, "bc_hold_ux": "0.02*cycle(t,1)*x", "ts_dt": 1 / steps,
                                    "ts_max_time": 40})
    phi, fat = recurrence(lambda t: 0.02 * wave(t), run["time"], more.get("material_solid_c", math.inf))
    runs.require(f"{name}: the middles and ends of cycles are hit", set(numpy.arange(0, 40.5, 0.5)) <= set(run["time"]))
    runs.check(f"{name}: largest error of phi over {len(phi) - 1} steps", abs(run["phi_max"] - phi).max(), 0, 1e-8,
               relative=False)
    runs.check(f"{name}: largest error of Fat", abs(run["fatigue_max"] - fat).max(), 0, 1e-8, relative=False)
    runs.check_between(f"{name}: phi at the end", run["phi_max"][-1], 0.9, 1)
    runs.require(f"{name}: Fat never shrinks", (numpy.diff(run["fatigue_max"]) >= 0).all())
    runs.check(f"{name}: energy of fatigue is -Fat phi/gamma", run["energy_fatigue"][-1], -fat[-1] * phi[-1] / WIDTH, 1e-8)
    runs.check(f"{name}: dissipated is the sum of phi dFat/gamma", run["dissipated_fatigue"][-1],
               (phi[1:] * numpy.diff(fat)).sum() / WIDTH, 1e-8)
    runs.check(f"{name}: smallest dissipation at a point", float(run.log.split("smallest dissipation at a point")[1].split()[0]),
               0, 0, relative=False)

# Without a: the same text as without the option.
plain = {key: value for key, value in CELL.items() if key != "material_solid_fatigue_a"}
cyclic = {"bc_hold_ux": "0.02*cycle(t,1)*x", "ts_dt": 0.25, "ts_max_time": 3}
texts = [open(runs.run(name, {**plain, **cyclic, **more}).dir + "/history.csv").read()
         for name, more in (("without", {}), ("zero", {"material_solid_fatigue_a": 0}))]
runs.require("a = 0: the history without the option, bit for bit", texts[0] == texts[1] and "fatigue" not in texts[0])

# Lives: until phi passes 0.95, with the stop that says so.
lives, amplitudes = [], (0.012, 0.018, 0.026)
for strain in amplitudes:
    run = runs.run(f"life_{strain}", {**CELL, "bc_hold_ux": f"{strain}*cycle(t,1)*x", "ts_dt": 0.5, "ts_max_time": 2000,
                                      "stops": "broken", "stop_broken_when": "phi_max > 0.95",
                                      "outputs": "hist", "output_hist_type": "csv", "output_hist_cycles": 5})
    life = float(run.log.split("stopped at t = ")[1].split()[0])
    times = numpy.arange(0, 2001, 0.5)
    phi, _ = recurrence(lambda t: strain * wave(t), times)
    runs.check(f"life at {strain}", life, times[(phi > 0.95).argmax()], 0, relative=False)
    marks = {t for k in range(1, int(life) + 1) if k % 5 == 0 for t in (k - 0.5, k) if t <= life} | {0, life}
    runs.require(f"rows at {strain}: the start, the middles and ends of every fifth cycle, and the end", list(run["time"]) == sorted(marks))
    lives.append(life)
slopes = numpy.diff(numpy.log(lives)) / numpy.diff(numpy.log(amplitudes))
print("     lives:", lives, "slopes of log N over log strain:", slopes)
runs.check_between("lives fall with the amplitude: largest slope", slopes.max(), -3, -1.5)

# A bar whose left part rests and whose right part is pulled, then held: Fat grows where the body is damaged and works.
run = runs.run("parts", {**SOLID, "mesh_set_n": 4, "mesh_set_ny": 1, "bcs": "hold", "bc_hold_on": "solid", "bc_hold_uy": 0,
                         "bc_hold_ux": "0.04*(t<2 ? cycle(t,1) : ramp(t,2,2.5))*max(x-0.5,0)", "ts_dt": 0.125,
                         "ts_max_time": 4, "probes": "rest,work", "probe_rest_at": "0.3,0.5",
                         "probe_rest_fields": "phi,fatigue", "probe_work_at": "0.9,0.5", "probe_work_fields": "fatigue"})
runs.check_between("at rest: phi grows by its gradient", run["probe_rest_phi"][-1], 0.05, 1)
runs.check("at rest: no fatigue", abs(run["probe_rest_fatigue"]).max(), 0, 1e-20, relative=False)
runs.check_between("at work: fatigue", run["probe_work_fatigue"][-1], 0.01, 1)
held = run["time"] > 2.5
runs.require("held: no fatigue", numpy.ptp(run["probe_work_fatigue"][held]) == 0)

# A clamped plastic block under a cyclic pull, with heat: first law of both forms, entropy, ranks.
BLOCK = {**SOLID, "mesh_set_n": 4, "material_solid_model": "j2", "material_solid_sigma_y": 4,
         "material_solid_gp": "one",
         "material_solid_linear_h": 100, "material_solid_c_v": 0.05, "material_solid_alpha_t": 1e-5,
         "material_solid_conductivity": 1, "bcs": "clamp,pull", "bc_clamp_on": "left", "bc_clamp_type": "fix",
         "bc_pull_on": "right", "bc_pull_ux": "0.03*cycle(t,1)", "ts_max_time": 3, "ts_dt": 0.1,
         "coupling_snes_atol": 1e-6, "history_materials": 1}
energy = runs.run("block_energy", {**BLOCK, "heat_form": "energy"})
for column in ("dissipated_fatigue", "dissipated_plastic", "alpha_max", "fatigue_max"):
    runs.require(f"block: {column} grows", energy[column][-1] > 0 and (numpy.diff(energy[column]) >= 0).all())
runs.check("block, energy form: first law", abs(energy["balance_first_law"]).max(), 0, 1e-8, relative=False)
for kind in ("energy_fatigue", "energy_fracture", "dissipated_fatigue", "dissipated_plastic"):
    runs.check(f"block: {kind} of the only material is the total", energy[kind + "_solid"][-1], energy[kind][-1], 1e-13)
# Flow leaves a residual of its own in the entropy form: without.
coarse, fine = (runs.run(f"block_entropy_{n}", {**BLOCK, "material_solid_model": "elastic", "ts_dt": 0.1 / n,
                                                "history_materials": 0}) for n in (1, 2))
lost = [abs(run["balance_first_law"][run["time"] > 0.95]).max() for run in (coarse, fine)]
print("     entropy form, largest first-law residual after the first cycle:", lost)
runs.check("block, entropy form: first law with twenty steps to a cycle", lost[1], 0, 5e-3, relative=False)
runs.check_between("block, entropy form: with ten", lost[0], 1.5 * lost[1], 0.05)
runs.require("block, entropy form: entropy grows", (numpy.diff(fine["entropy_produced"]) > -1e-15).all())
two = runs.run("block_two", {**BLOCK, "heat_form": "energy"}, ranks=2)
for column in ("fatigue_max", "phi_max", "energy_fatigue", "reaction_pull_x"):
    runs.check(f"block on 2 ranks: {column}", abs(two[column] - energy[column]).max() / abs(energy[column]).max(), 0, 1e-8,
               relative=False)

# The run of the gallery, coarse and short: rows at both turning points of each cycle, the load of its resultant.
run = runs.run("compact", {"mesh_set_h": 1, "ts_max_time": 3}, files=[runs.option_file("fatigue_ct.opts")])
runs.require("compact specimen: rows at the turning points", list(run["time"]) == [0, 0.5, 1, 1.5, 2, 2.5, 3])
runs.require("compact specimen: the ligament holds the load and a tenth of it",
             numpy.allclose(run["reaction_symmetry_y"][1:], [-160, -16] * 3, rtol=2e-3))
runs.require("compact specimen: it tires", (numpy.diff(run["fatigue_max"]) > 0).all())
runs.finish()
