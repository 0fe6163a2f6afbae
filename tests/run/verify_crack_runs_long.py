# labels: run long
# timeout: 900
"""Griffith's strip as options/griffith_strip.opts has it (D4), on two ranks."""
import re

import _griffith as griffith
import _runs as runs

u_c, r = griffith.strip("strip", 0.06, 0.015, ranks=2)
griffith.check_strip("strip", 0.06, 0.015, 3.5, 1.2, u_c, r)
minutes = re.search(r"steps in (\d+):(\d+);", r.log)
runs.check_between("seconds on two ranks", 60 * int(minutes.group(1)) + int(minutes.group(2)), 1, 180)
runs.finish()
