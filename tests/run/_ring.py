"""The folding ring of options/ring.opts, coarser and faster."""
from _runs import option_file, run

COARSE = {"mesh_set_thickness": 1, "mesh_set_n_around": 64, "mesh_set_n_through": 1, "material_ring_nu": 0,
          "motion_snes_rtol": 1e-12, "motion_snes_atol": 1e-12, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
          "motion_pc_factor_mat_solver_type": "mumps", "output_vis_every": 100000, "ts_dt": 0.04}
E, RADIUS = 1000, 10


def stiffness(thickness):
    """EI/R^3 without lateral contraction."""
    return E * thickness**3 / 12 / RADIUS**3


def ring(name, options=None, **kwargs):
    given = {**COARSE, **(options or {})}
    given["param_stiffness"] = repr(stiffness(given["mesh_set_thickness"]))
    return run(name, given, files=[option_file("ring.opts")], **kwargs)
