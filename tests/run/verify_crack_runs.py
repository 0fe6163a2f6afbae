# labels: run
# timeout: 120
"""A crack that runs at a fixed load in statics, with the default number of passes: Griffith's strip (D4) on a coarse mesh starts
at its load, runs through in one step and costs what it must. A limit of passes that is given is kept, and named where it ends a run."""
import re

import _griffith as griffith
import _runs as runs

GAMMA, H, LENGTH, SLOT = 0.08, 0.02, 3.0, 1.2
COARSE = {"mesh_set_length": LENGTH, "mesh_set_slot": SLOT}
u_c, one = griffith.strip("one", GAMMA, H, COARSE)
griffith.check_strip("one rank", GAMMA, H, LENGTH, SLOT, u_c, one)
passes = int(re.search(r"crack ran: .* (\d+) passes", one.log).group(1))
runs.check_between("passes of the jump, of 90 cells", passes, 20, 180)

_, few = griffith.strip("few", GAMMA, H, {**COARSE, "coupling_snes_max_it": 30, "ts_max_reject": 0}, code=5)
runs.require("a given limit is kept and named: " + (re.search(r"impact: (.*passes.*)", few.log) or ["nothing"])[0],
             re.search(r"impact: 30 passes, phi still changes by [0-9.e-]+ \(-coupling_snes_max_it\), step \d+ try 1", few.log))
runs.finish()
