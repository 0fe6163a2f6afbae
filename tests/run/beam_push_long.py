# labels: run long
# timeout: 300
# processors: 1
"""The short notched beam pushed at one node until it is cut through, with two time steps, against the table of an
independent small-strain program; see beam_push.py. The force at t = 0.15 lies on the steep fall, where one step is worth 10 %: there the time
of that force is compared."""
import numpy

from _runs import check, finish, option_file, run


def first(history, column, level):
    return history["time"][numpy.argmax(history[column] > level)]


def falling(history, level):
    """The time at which the force passes the level after its peak."""
    force, time = history["reaction_push_y"], history["time"]
    after = force.argmax() + numpy.argmax(force[force.argmax():] < level)
    return numpy.interp(-level, -force[after - 1:after + 1], time[after - 1:after + 1])


for dt, peak, peak_time, times, forces in (
        (1e-3, 61.4, 0.115, (0.060, 0.127, 0.143), (59.5, 26.7, 11.4, 6.0, 4.5)),
        (5e-4, 61.0, 0.114, (0.060, 0.1255, 0.1375), (58.3, 17.6, 10.6, 5.7, 4.3))):
    r = run(f"push_{dt:g}", {"ts_dt": dt, "output_vis_dt": 1}, [option_file("beam_push.opts")])
    name = f"dt {dt:g}: "
    force = r["reaction_push_y"]
    check(name + "largest force, N/mm", force.max(), peak, 0.05)
    check(name + "its time", r["time"][force.argmax()], peak_time, 0.05)
    for level, time in zip((0.1, 0.5, 0.95), times):
        check(name + f"phi > {level:g}", first(r.history, "phi_max", level), time, 0.05)
    for time, value in zip((0.13, 0.15, 0.18, 0.22, 0.24), forces):
        if time == 0.15:
            check(name + f"time at which {value:g} N/mm are left", falling(r.history, value), time, 0.05)
        else:
            check(name + f"force at t = {time:g}, N/mm", numpy.interp(time, r["time"], force), value, 0.05)
finish()
