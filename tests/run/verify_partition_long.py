"""The claims of verify_partition.py on four and eight times the cells."""
# labels: long
# processors: 2
# timeout: 900
from _partition import BEAM, SPHERE, check_case
from _runs import finish

check_case("beam", *BEAM, refine=2)
check_case("sphere", *SPHERE, refine=1)
finish()
