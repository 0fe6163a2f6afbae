"""Bodies that contact alone holds: a quarter of a disc on a block with a plane of symmetry, and three blocks."""
import math
import os
import sys

import numpy
from _runs import mesh, run

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools"))
from fields import Fields  # noqa: E402

METHODS = [(method, enforce) for method in ("mortar", "gpts") for enforce in ("semismooth", "auglag", "penalty")]
R, E, NU, LOAD = 10.0, 200e3, 0.3, 1000.0
STAR = E / (2 * (1 - NU**2))
WIDTH = math.sqrt(4 * LOAD * R / (math.pi * STAR))
PEAK = 2 * LOAD / (math.pi * WIDTH)
CYLINDER = {
    "units": "mm_t_s_MPa", "mesh": mesh("disc_on_block.geo"), "materials": "disc,block", "material_disc_E": E,
    "material_disc_nu": NU, "material_block_like": "disc", "bcs": "ground,load,middle", "bc_ground_on": "ground",
    "bc_ground_type": "fix", "bc_load_on": "top", "bc_load_type": "traction", "bc_load_uy": "(-50*t)",
    "bc_middle_on": "middle", "bc_middle_type": "displacement", "bc_middle_ux": 0, "contacts": "touch",
    "contact_touch_secondary": "rim", "contact_touch_primary": "block_top", "ts_type": "static", "ts_dt": 1,
    "ts_max_time": 1, "outputs": "vis,hist", "output_hist_type": "csv", "output_vis_times": 1,
}
STACK = {
    "units": "mm_t_s_MPa", "mesh": mesh("three_blocks.geo"), "materials": "b0,b1,b2", "material_b0_E": 1000,
    "material_b0_nu": 0.3, "material_b0_rho": "1000 kg/m^3", "material_b1_like": "b0", "material_b2_like": "b0",
    "bcs": "ground,weight", "bc_ground_on": "bottom0", "bc_ground_type": "fix", "bc_weight_on": "b0,b1,b2",
    "bc_weight_type": "body_force", "bc_weight_uy": "(-9.81e3*t)", "contacts": "lower,upper",
    "contact_lower_secondary": "bottom1", "contact_lower_primary": "top0", "contact_upper_secondary": "bottom2",
    "contact_upper_primary": "top1", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "outputs": "hist",
    "output_hist_type": "csv",
}
SPHERE = {
    "units": "mm_t_s_MPa", "mesh": mesh("ball_on_block.geo"), "materials": "ball,block", "material_ball_E": 200e3,
    "material_ball_nu": 0.3, "material_block_like": "ball", "bcs": "ground,load,left,back", "bc_ground_on": "ground",
    "bc_ground_type": "fix", "bc_load_on": "top", "bc_load_type": "traction", "bc_load_uy": "(-5*t)",
    "bc_left_on": "left", "bc_left_type": "displacement", "bc_left_ux": 0, "bc_back_on": "back",
    "bc_back_type": "displacement", "bc_back_uz": 0, "contacts": "touch", "contact_touch_secondary": "skin",
    "contact_touch_primary": "block_top", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "outputs": "vis,hist",
    "output_hist_type": "csv", "output_vis_times": 1, "mesh_set_near": 0.08,
}


def cylinder(name, method, enforce, friction=0, extra=None, ranks=1, code=0):
    return run(name, {**CYLINDER, "contact_touch_method": method, "contact_touch_enforce": enforce,
                      "contact_touch_friction": friction, **(extra or {})}, ranks=ranks, code=code)


def stack(name, method, enforce, friction, extra=None, ranks=1):
    own = {}
    for contact in ("lower", "upper"):
        own.update({f"contact_{contact}_method": method, f"contact_{contact}_enforce": enforce,
                    f"contact_{contact}_friction": friction})
    return run(name, {**STACK, **own, **(extra or {})}, ranks=ranks)


def hertz_error(name, peak=PEAK, width=WIDTH):
    """Factor of Hertz's profile that fits the nodal pressures on the round side best."""
    fields = Fields(os.path.join(name, "vis.xdmf"))
    x = fields.places(fields.grids[0])
    p = fields.field(fields.grids[-1], "contact_pressure")[0][:, 0]
    at = numpy.hypot(x[:, 0], x[:, 2]) if x.shape[1] > 2 else x[:, 0]
    on_rim = (abs(numpy.hypot(at, x[:, 1] - R) - R) < 1e-6 * R) & (at < 1.5 * width) & (x[:, 1] < R)
    on_rim &= at > 1e-9  # where the corner of the block lies too
    at, p = at[on_rim], p[on_rim]
    hertz = peak * numpy.sqrt(numpy.maximum(0, 1 - (at / width) ** 2))
    return (p * hertz).sum() / (hertz**2).sum()
