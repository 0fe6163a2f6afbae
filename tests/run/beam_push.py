# labels: run
# timeout: 120
# processors: 1
"""The short notched beam pushed at one node, until the force has passed its peak, against the table of an
independent small-strain program (Q1 with B-bar, damage in the same form, no split, cells of 0.125 mm). Its mesh is not kept;
the slit of 0.375 mm, three such cells, is inferred, since 0.4 mm shifts every time by 2 to 4 %. The table: a peak of 61.4 N/mm at t = 0.115,
phi > 0.1 at 0.060 and > 0.5 at 0.127, 59.5 N/mm at t = 0.13. The first yield and the stiffness come before any damage.
The whole run is beam_push_long.py."""
import numpy

from _runs import check, check_between, finish, option_file, run


def first(history, column, level):
    return history["time"][numpy.argmax(history[column] > level)]


r = run("push", {"ts_max_time": 0.131, "output_vis_dt": 1}, [option_file("beam_push.opts")])
force = r["reaction_push_y"]
check("largest force, N/mm", force.max(), 61.4, 0.05)
check("its time", r["time"][force.argmax()], 0.115, 0.05)
check("first yield", first(r.history, "alpha_max", 1e-9), 0.036, 0.05)
check("phi > 0.1", first(r.history, "phi_max", 0.1), 0.060, 0.05)
check("phi > 0.5", first(r.history, "phi_max", 0.5), 0.127, 0.05)
check("force at t = 0.13, N/mm", numpy.interp(0.13, r["time"], force), 59.5, 0.05)
# Newton ends at 1e-8 of the first residual.
check_between("clamp and push add up to", numpy.abs(force + r["reaction_clamp_y"]).max() / force.max(), 0, 1e-8)
finish()
