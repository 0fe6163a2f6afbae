# labels: run
# timeout: 120
# processors: 1
"""The runs of the gallery with heat across contacts, coarser and shorter: brake.opts against Jaeger's flash temperature, and
the first steps of beam_wedge_heat.opts."""
import math

from _runs import check, check_between, finish, option_file, require, run

MU, SPEED, WIDTH, K, C, PART = 0.4, 1000.0, 10.0, 45.0, 3.588, 0.073
r = run("brake", {"mesh_set_h": 1, "mesh_set_layers": 10, "mesh_set_grading": 1.4, "mesh_set_length": 40, "ts_dt": 5e-4,
                  "ts_max_time": 0.016, "output_vis_dt": 1, "heat_snes_rtol": 1e-13}, files=[option_file("brake.opts")])
flux = MU * abs(r["contact_face_force_y"][-1]) / WIDTH * SPEED
flash = 2 * (1 - PART) * flux * math.sqrt(WIDTH / (math.pi * K * C * SPEED))
check("flash temperature of the plate, 2 q sqrt(w/(pi k c v))", r["measure_plate_theta"][-1] - 300, flash, 0.06)
lost = r["dissipated_friction"][-1]
check("friction takes mu F v", r["dissipated_friction"][-1] - r["dissipated_friction"][-2],
      MU * abs(r["contact_face_force_y"][-1]) * SPEED * 5e-4, 1e-2)
for body, part in (("pad", PART), ("plate", 1 - PART)):
    check(f"part of the {body}", r[f"energy_thermal_{body}"][-1] / lost, part, 1e-4)

# What the first law misses is what the contact did by the trapezoidal rule of the motion and by its own law at the end of the step, and goes
# with the step.
misses = []
for steps in (4, 8, 16):
    r = run(f"brake_{steps}", {"mesh_set_h": 1, "mesh_set_layers": 10, "mesh_set_grading": 1.4, "mesh_set_length": 40, "ts_dt": 2e-3 / steps,
                               "ts_max_time": 2e-3, "output_vis_dt": 1, "heat_snes_rtol": 1e-13}, files=[option_file("brake.opts")])
    stored = sum(r["energy_" + kind] for kind in ("elastic", "thermal", "contact"))
    missing = stored - stored[0] - r["work_external"] - r["heat_supplied"]
    own = r["work_contact"] + r["dissipated_friction"] + r["energy_contact"]
    check(f"brake, {steps} steps: what the first law misses but for the contact's own work / heat", abs(missing - own).max() /
          r["dissipated_friction"][-1], 0, 1e-9, relative=False)
    misses.append(missing[-1])
for before, after in zip(misses, misses[1:]):
    check("brake: order of what the first law misses", math.log2(before / after), 1, 0.05)

r = run("beam", {"ts_max_steps": 3, "output_vis_dt": 1, "output_vis_times": 1}, files=[option_file("beam_wedge_heat.opts")])
require("three steps without a cut", len(r["step"]) == 4 and r["tries"].max() == 1)
check_between("heat goes through the contact", abs(r["heat_contact_tip"][-1]), 1e-9, 1)
check("first law", abs(r["balance_first_law"]).max(), 0, 1e-3, relative=False)
finish()
