# labels: run
# timeout: 240
"""R2, R3, R4: the first runs of a few quick scripts in the modes recover, restep and repartition (see _modes.py): damage with
sub-steps, two blocks that meet. `reliability_modes_long` takes all runs of all scripts."""
import os

from _modes import conclude, exercise, scripts

QUICK = ("verify_contact_gates", "verify_substeps")
paths = [path for path in scripts() if os.path.basename(path)[:-3] in QUICK]
assert len(paths) == len(QUICK), paths
conclude(exercise(paths, ("recover", "restep", "repartition"), most=1, in_turn=True))
