# labels: run long
# timeout: 900
"""Griffith's strip as options/griffith_strip.opts has it (D4), on two ranks; on the coarse mesh of verify_crack_runs.py one and two
ranks agree."""
import re

import _griffith as griffith
import _runs as runs

u_c, r = griffith.strip("strip", 0.06, 0.015, ranks=2)
griffith.check_strip("strip", 0.06, 0.015, 3.5, 1.2, u_c, r)
minutes = re.search(r"steps in (\d+):(\d+);", r.log)
runs.check_between("seconds on two ranks", 60 * int(minutes.group(1)) + int(minutes.group(2)), 1, 180)
one, two = (griffith.strip(f"coarse_{ranks}", 0.08, 0.02, {"mesh_set_length": 3.0, "mesh_set_slot": 1.2}, ranks=ranks)[1] for ranks in (1, 2))
runs.check("two ranks: time of the jump", two["time"][-1], one["time"][-1], 1e-12)
for column in ("energy_fracture", "work_external"):
    runs.check(f"two ranks: {column} after it", two[column][-1], one[column][-1], 1e-3)
runs.finish()
