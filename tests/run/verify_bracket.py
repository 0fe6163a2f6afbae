# labels: run
# long: 120
# processors: 1
"""The bracket of the gallery on coarse tetrahedra of second order: it flows on the ground that its heel presses, by the forces of
finer cells. Under friction the whole foot touches at once, from a gap of zero everywhere: nothing flows by pressures on the way."""
import numpy
from _runs import check, check_between, finish, long, option_file, require, run

COARSE = {"mesh_set_h": 2.5, "mesh_set_coarse": 5, "ts_dt": 0.07, "ts_max_time": 0.28, "outputs": "hist"}
r = run("coarse", COARSE, files=[option_file("bracket.opts")])
pull = -r["reaction_pin_x"]
check("force at 0.28 mm, that of the gallery's cells", pull[-1], 7046, 0.05)
check_between("no more than the plastic hinge bears", pull[-1], 5000, 7500)
check_between("it flows", r["alpha_max"][-1], 1e-3, 2e-2)
check_between("the heel presses on the ground", r["contact_ground_force_z"][-1] / pull[-1], 1, 1.4)
up = (r["reaction_bolts_z"] + r["reaction_pin_z"] + r["contact_ground_force_z"])[-1]
check("forces on bolts, pin and ground are in balance, upwards", up, 0, 1e-6 * pull[-1], relative=False)
check("and along the pull", (r["reaction_bolts_x"] - pull)[-1], 0, 1e-6 * pull[-1], relative=False)
check("balance", abs(r["balance"]).max(), 0, 1e-12, relative=False)
require("no step is cut", r["tries"].max() == 1)

if long():
    r = run("touch", {"mesh_set_h": 2.2, "mesh_set_coarse": 3, "contact_ground_friction": 0.3, "ts_max_time": 0.05, "outputs": "hist"},
            files=[option_file("bracket.opts")])
    require("22,878 unknowns touch under friction in one try", r["tries"].max() == 1)
    check_between("iterations of Newton's method", r["newton"].max(), 10, 30)
    require("conjugate gradients' preconditioner serves GMRES", "motion solver: gmres + two_level" in r.log)
    check_between("linear iterations in each", r["linear"].max() / r["newton"].max(), 40, 120)
    check("nothing flows", r["alpha_max"][-1], 0, 1e-12, relative=False)
    slide = numpy.hypot(r["contact_ground_force_x"], r["contact_ground_force_y"])[-1]
    check_between("friction over normal force", slide / r["contact_ground_force_z"][-1], 0.03, 0.3)
finish()
