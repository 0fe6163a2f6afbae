# labels: run
# timeout: 120
"""Step load on a bar (nu = 0, one-dimensional wave theory): behind the front the velocity is p / (rho c) and the stress
-p, the front arrives at x / c, and at a fixed end the stress doubles."""
import numpy
from _runs import check, finish, option_file, run

L, WIDTH, E, RHO, P = 0.1, 2e-3, 70e9, 2800.0, 70e6
C = (E / RHO) ** 0.5
V = P / (RHO * C)

r = run("wave", {"output_vis_every": 100000}, files=[option_file("bar_wave.opts")])
time = r["time"]


def window(start, end):
    """The middle half of an interval of time."""
    quarter = (end - start) / 4
    return (time > start + quarter) & (time < end - quarter)


def arrival(values, level):
    """First time at which the level is passed, by linear interpolation."""
    i = numpy.nonzero(values >= level)[0][0]
    return time[i - 1] + (level - values[i - 1]) / (values[i] - values[i - 1]) * (time[i] - time[i - 1])


velocity, stress, wall = r["probe_middle_vx"], r["probe_middle_stress_xx"], r["reaction_wall_x"]
behind = window(L / 2 / C, 1.5 * L / C)
check("mean velocity behind the front p / (rho c)", velocity[behind].mean(), V, 0.02)
check("mean stress behind the front", stress[behind].mean(), -P, 0.02)
# The consistent mass makes short waves a little too fast; at the exact place of such a dispersed step (the integral of
# the Airy function) two thirds of it have arrived.
check("arrival at L/2, within h/c", arrival(velocity, 2 * V / 3), L / 2 / C, L / 200 / C, relative=False)
end = window(L / C, 35e-6)
check("mean reaction of the fixed end, twice the load", -wall[end].mean(), 2 * P * WIDTH, 0.02)
check("arrival at the fixed end, within h/c", arrival(-wall, 4 * P * WIDTH / 3), L / C, L / 200 / C, relative=False)
back = window(1.5 * L / C, 35e-6)
check("mean stress at L/2 behind the reflected front", stress[back].mean(), -2 * P, 0.02)
check("mean velocity there, relative to p / (rho c)", velocity[back].mean() / V, 0, 0.02, relative=False)
check("impulse of the load is the momentum before the reflection",
      numpy.interp(15e-6, time, r["momentum_bar_x"]), P * WIDTH * 15e-6, 2e-3)
check("first law", abs(r["balance_first_law"]).max(), 0, 5e-3, relative=False)
finish()
