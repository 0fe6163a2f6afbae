# labels: run long
# timeout: 240
"""A strip of PMMA, stretched statically and let go (options/pmma_strip*.opts), smaller than there: the crack waits for nothing, is
slower than Rayleigh's waves, takes no less than Gc per length, and energy is kept from the static state on."""
import numpy

from _runs import check, check_between, finish, option_file, require, run

STRETCH = 0.024
SMALL = {"mesh_set_width": 8, "mesh_set_height": 4, "mesh_set_slit": 1, "mesh_set_n": 160, "param_stretch": STRETCH}
loaded = run("pmma_strip_load", SMALL, files=[option_file("pmma_strip_load.opts")])
stored = loaded["energy_elastic"][-1]
check("work of the load is what is stored", loaded["work_external"][-1], stored, 1e-3)
E, NU, GC, RHO = 3090.0, 0.35, 0.3, 1180e-12
strain = STRETCH / 2
check_between("stored, over that of a strip that does not contract nor has a slit", stored / (0.5 * E / (1 - NU ** 2) * strain ** 2 * 8 * 4), 0.75, 1.0)

r = run("pmma_strip", {**SMALL, "ts_max_time": 1.00001, "restart": "pmma_strip_load/checkpoints/checkpoint_000001.h5", "outputs": "hist",
                       "output_hist_dt": 1e-7}, files=[option_file("pmma_strip.opts")])
t, tip, energy = (r["time"] - 1) * 1e6, r["crack_pmma_tip_x"], r["energy_fracture"]
kept = r["energy_elastic"] + r["energy_kinetic"] + energy
check("energy in the first row", kept[0], stored, 2e-3)
began = int(numpy.argmax(numpy.nan_to_num(tip) > 1.2))
check_between("it has run 0.2 mm after, us", t[began], 0.5, 3)
there = (tip > 2) & (tip < 7)
require("it runs through", numpy.nanmax(tip) == 8 and there.sum() > 5)
speed = numpy.polyfit(t[there], tip[there], 1)[0] * 1e3
shear = (E / 2 / (1 + NU) / RHO) ** 0.5 * 1e-3
rayleigh = shear * (0.862 + 1.14 * NU / (1 + NU)) / (1 + NU / (1 + NU))  # Viktorov, with nu/(1 + nu) for plane stress
check_between(f"speed of the tip, over Rayleigh's {rayleigh:.0f} m/s", speed / rayleigh, 0.4, 0.95)
check_between("the column of the speed, its mean over that", numpy.median(r["crack_pmma_speed"][there]) * 1e-3 / speed, 0.8, 1.25)
check_between("energy per length, over Gc", (energy[there][-1] - energy[there][0]) / (tip[there][-1] - tip[there][0]) / GC, 1.0, 2.5)
# Of first order in the step: 1.4e-2, and 7e-3 with -ts_dt_cfl 0.4.
check("first law", r["balance_first_law"][-1], 0, 2e-2, relative=False)
finish()
