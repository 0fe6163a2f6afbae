# labels: run
# timeout: 120
"""The comparison of runs sees what it is for: a history or a field that is changed in one place, beyond the tolerance or in a
count; and the modes fail where nothing was compared, and do not take for noise what they leave out of a comparison."""
import contextlib
import io
import os
import shutil

import _modes
import h5py
import numpy
from _histories import Fields, difference, fields_difference, history
from _runs import BREAKING_BLOCKS, check, check_between, finish, require, run

whole = run("whole", {**BREAKING_BLOCKS, "ts_max_time": 0.03, "output_vis_every": 5})
plain = history("whole")
check("a run against itself", difference(plain, history("whole"), exact=True)[0], 0, 0, relative=False)


def spoilt(column, row, change):
    other = {name: values.copy() for name, values in plain.items()}
    other[column][row] += change
    return other


scale = {c: abs(plain[c][numpy.isfinite(plain[c])]).max(initial=0) for c in plain}
for column in ("energy_elastic", "momentum_upper_x", "contact_face_pressure_max", "phi_max"):
    found, where = difference(plain, spoilt(column, 7, 1e-7 * scale[column]))
    require(f"{column} changed by 1e-7 in a row: {found:.2e} in {where}", 1e-9 < found <= 1.01e-7 and where == column)
for column in ("balance", "balance_first_law"):
    check(f"{column} changed by 1e-7", difference(plain, spoilt(column, 7, 1e-7))[0], 1e-7, 1e-3)
check_between("a count that differs, on one rank", difference(plain, spoilt("newton", 7, 1), exact=True)[0], 0.01, 1)
check("the same on several", difference(plain, spoilt("newton", 7, 1))[0], 0, 0, relative=False)
require("a number that is none", difference(plain, spoilt("energy_elastic", 7, numpy.nan))[0] == numpy.inf)
require("a row that lacks", difference(plain, {c: v[:-1] for c, v in plain.items()})[0] == numpy.inf)
require("a column that lacks", difference(plain, {c: v for c, v in plain.items() if c != "phi_max"})[0] == numpy.inf)

# Fields: the numbers of nodes and cells hang on the ranks, their places do not.
other = run("ranks", {**BREAKING_BLOCKS, "ts_max_time": 0.03, "output_vis_every": 5, "motion_snes_rtol": 1e-12}, ranks=3)
check("fields on three ranks, by place", fields_difference("ranks", "whole", by_place=True, exact=False)[0], 0, 1e-8,
      relative=False)
check_between("the same by number", fields_difference("ranks", "whole")[0], 1e-3, numpy.inf)
shutil.copytree("whole", "field")
fields = Fields("field/vis.xdmf")
stress = next(a for a in fields.grids[-1].iter("Attribute") if a.get("Name") == "von_mises").find("DataItem")
path, data = stress.text.strip().split(":", 1)
with h5py.File(os.path.join("field", path), "r+") as file:
    values = file[data][()]
    values[abs(values).argmax()] *= 1 + 1e-3
    file[data][...] = values
for by_place in (False, True):
    found, where = fields_difference("field", "whole", by_place=by_place)
    require(f"a stress changed by 1e-3 of itself: {found:.2e} in {where}", 1e-9 < found <= 1e-3 and where.startswith("von_mises"))

# The modes themselves.
quiet = contextlib.redirect_stdout(io.StringIO())


def status(report):
    try:
        with quiet:
            _modes.conclude(report)
    except SystemExit as end:
        return end.code


nothing, skipped, one = _modes.Report(), _modes.Report(), _modes.Report()
skipped.skipped.append("x: y (a single step)")
check("nothing compared", status(nothing), 1, 0)
check("all skipped", status(skipped), 1, 0)
one.compared["x"] = 1
one.rows.append(("recover", 0.0, True))
check("one comparison that agrees", status(one), 0, 0, relative=False)
os.makedirs("scripts")
with open("scripts/verify_single.py", "w") as file:
    file.write("from _runs import *\nrun('one', {**TWO_BLOCKS, 'ts_max_time': 2e-3})\nfinish()\n")
with quiet:
    report = _modes.exercise([os.path.abspath("scripts/verify_single.py")], ("recover",))
require(f"a script in which every run is skipped fails: {report.failed}", status(report) == 1)
finish()
