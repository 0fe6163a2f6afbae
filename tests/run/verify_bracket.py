# labels: run
# processors: 1
"""The bracket of the gallery on coarse tetrahedra of second order: it flows on the ground that its heel presses, by the forces of
finer cells."""
from _runs import check, check_between, finish, option_file, require, run

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
finish()
