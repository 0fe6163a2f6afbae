# labels: run long
# timeout: 7200
"""The beam and the wedge of beam_wedge.opts to the end: every observable of tools/beam_wedge_observables.py. Then until the
force has fallen, with ten times the density (the problem is quasi-static: the force may not notice), half the time step and
half the cell size (the crack's start moves by a few per cent)."""
import os
import subprocess
import sys

import numpy

from _runs import SOURCE, check, check_between, finish, option_file, require, run

END = 0.14


def crack_start(history, level=0.5):
    return history["time"][numpy.argmax(history["phi_max"] > level)]


base = run("base", {}, [option_file("beam_wedge.opts")], ranks=2)
tool = os.path.join(SOURCE, "tools", "beam_wedge_observables.py")
done = subprocess.run([sys.executable, tool, "base"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
print(done.stdout)
require("every observable is within its limits", done.returncode == 0)

peak = base["reaction_push_y"].max()


def variant(name, options):
    r = run(name, {"ts_max_time": END, "output_vis_dt": 1, **options}, [option_file("beam_wedge.opts")], ranks=2)
    print(f"{name}: largest force {r['reaction_push_y'].max():.6g}, phi > 0.5 at {crack_start(r.history):.6g}, > 0.95 at "
          f"{crack_start(r.history, 0.95):.6g}, first law {r['balance_first_law'][-1]:.3g}")
    return r


print(f"base: largest force {peak:.6g}, phi > 0.5 at {crack_start(base.history):.6g}, > 0.95 at "
      f"{crack_start(base.history, 0.95):.6g}")
heavy = variant("density", {"material_beam_rho": "28100 kg/m^3"})
before = base["time"] <= END + 1e-9
difference = numpy.interp(base["time"][before], heavy["time"], heavy["reaction_push_y"]) - base["reaction_push_y"][before]
check_between("density: largest difference of the force over its peak", numpy.abs(difference).max() / peak, 0, 0.02)

fine = variant("step", {"ts_dt": 5e-4})
check("half the step: largest force", fine["reaction_push_y"].max(), peak, 0.05)
check("half the step: phi > 0.5", crack_start(fine.history), crack_start(base.history), 0.05)

small = variant("size", {"mesh_set_h_factor": 0.5})
check("half the size: largest force", small["reaction_push_y"].max(), peak, 0.05)
check("half the size: phi > 0.5", crack_start(small.history), crack_start(base.history), 0.05)
finish()
