# labels: run long
# timeout: 7200
"""R2, R3, R4: all runs of all test scripts in the modes recover, repartition and restep (see _modes.py)."""
from _modes import conclude, exercise, scripts

conclude(exercise(scripts(), ("recover", "restep", "repartition")))
