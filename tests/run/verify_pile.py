# labels: run
# timeout: 300
# long: 300
"""Three blocks fall on each other and on the floor in space (options/pile.opts): contacts close, open and close again, no
step is refused, nothing passes through anything, the energy never rises, and 1 and 2 ranks (long: 1 to 4) give one history."""
import numpy
from _histories import difference
from _runs import check, check_between, finish, long, option_file, run

PAIRS = ("floor", "first", "second")
RANKS = (2, 3, 4) if long() else (2,)
runs = {ranks: run(f"ranks_{ranks}", {"ts_max_time": 0.3 if ranks == 1 or long() else 0.15, "output_vis_dt": 1, "motion_snes_rtol": 1e-11},
                   files=[option_file("pile.opts")], ranks=ranks) for ranks in (1, *RANKS)}
r = runs[1]
for pair in PAIRS:
    pressed = (r[f"contact_{pair}_active"] > 0).astype(int)
    closings = numpy.count_nonzero(numpy.diff(pressed) == 1)
    print(f"     {pair}: pressed in {pressed.sum()} of {len(pressed) - 1} steps, closed {closings} times")
    check_between(f"{pair}: closings", closings, 1, 10)
    check_between(f"{pair}: smallest mean gap about a node", numpy.nanmin(r[f"contact_{pair}_gap_min"]), -1e-9, 1)
check_between("closings of the floor, which the lowest block leaves again",
              numpy.count_nonzero(numpy.diff((r["contact_floor_active"] > 0).astype(int)) == 1), 2, 10)
energy = r["energy_kinetic"] + r["energy_elastic"] - r["work_external"]
check_between("largest rise of the energy in a step over the work of the weight",
              numpy.diff(energy).max() / r["work_external"].max(), -1, 1e-3)
check_between("tries of a step", r["tries"].max(), 1, 1)
check_between("most Newton iterations", r["newton"].max(), 3, 25)
for ranks in RANKS:
    other = runs[ranks].history
    worst, where = difference({c: values[:len(other["time"])] for c, values in r.history.items()}, other)
    check(f"{ranks} ranks against 1, worst column {where}", worst, 0, 1e-8, relative=False)
finish()
