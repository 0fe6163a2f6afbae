"""On 4 and 8 ranks the fullest rank has at most 1.15 times the mean of the cells and 1.15 times the mean of the secondary facets of
contacts, whose ranks do its work (of whole ones: of 12 facets one of 8 ranks has 2), and linear solvers take at most 1.2 times the
iterations of one rank: the beam on the wedge, once refined, and the sphere on a plane in space. Balanced in the facets of both sides,
one of 2 ranks had all secondary ones. In the long form both on 4, 8 and 16 ranks, and on four and eight times the cells."""
# labels: run
# timeout: 240
# long: 900
import math
import re

from _runs import check_between, finish, long, option_file, run

# One step, by the iterative solver whose iterations could grow with the ranks.
STEP = {"ts_max_steps": 1, "outputs": "hist", "checkpoint_wall": 0}
BEAM = ("beam_wedge.opts", {**STEP, "motion_ksp_type": "gmres", "motion_pc_type": "gamg"})
SPHERE = ("hertz_sphere.opts", {**STEP, "motion_ksp_type": "cg", "motion_pc_type": "two_level"})
MOST_SHARE, MOST_GROWTH = 1.15, 1.2


def shares(log):
    """Cells and secondary facets of contacts, of the fullest rank over what whole ones let it have at least."""
    line = re.search(r"^ranks: the fullest has (\S+) times the mean of (\S+) cells, (\S+) times the mean of (\S+) secondary facets", log, re.M)
    numbers = [float(number) for number in line.groups()]
    return [share * mean / math.ceil(mean) for share, mean in zip(numbers[::2], numbers[1::2])]


def check_case(name, options, settings, refine, ranks_of_all):
    linear = {}
    for ranks in ranks_of_all:
        r = run(f"{name}_{ranks}", {**settings, "dm_refine": refine}, files=[option_file(options)], ranks=ranks)
        linear[ranks] = r["linear"].sum()
        if ranks == 1:
            continue
        for what, share in zip(("cells", "secondary facets"), shares(r.log)):
            check_between(f"{name}, {ranks} ranks: {what} of the fullest over an even share", share, 0.99, MOST_SHARE)
        # GAMG's aggregates differ with the numbers of the unknowns: the count of two ranks is a draw as much as any other.
        check_between(f"{name}, {ranks} ranks: {linear[ranks]:.0f} linear iterations, over the {linear[1]:.0f} of one rank",
                      linear[ranks] / linear[1], 0.5, MOST_GROWTH)


check_case("beam", *BEAM, refine=2 if long() else 1, ranks_of_all=(1, 4, 8, 16) if long() else (1, 4))
check_case("sphere", *SPHERE, refine=1 if long() else 0, ranks_of_all=(1, 4, 8, 16) if long() else (1, 8))
finish()
