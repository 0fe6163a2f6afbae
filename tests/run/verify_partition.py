"""On 4, 8 and 16 ranks the fullest rank has at most 1.15 times the mean of the cells and 1.15 times the mean of the secondary facets of
contacts, whose ranks do its work (of whole ones: of 12 facets one of 8 ranks has 2), and linear solvers take at most 1.2 times the
iterations of one rank: the beam on the wedge, once refined, and the sphere on a plane in space. Balanced in the facets of both sides, one of 2 ranks had all
secondary ones."""
# labels: run
# processors: 2
# timeout: 240
from _partition import BEAM, SPHERE, check_case
from _runs import finish

check_case("beam", *BEAM, refine=1)
check_case("sphere", *SPHERE, refine=0)
finish()
