"""Flow, heat, damage and inertia together, in the plane and in space: from a checkpoint to the bit, on other numbers of ranks to
rounding."""
import filecmp

import numpy
from _histories import difference, fields_difference
from _runs import check, check_between, mesh, require, run

WHOLE = {"mesh": mesh("block.geo"), "mesh_set_simplex": 1, "materials": "solid", "units": "mm_t_s_MPa",
         "material_solid_model": "j2", "material_solid_E": "70 GPa", "material_solid_nu": 0.3,
         "material_solid_rho": "2700 kg/m^3", "material_solid_sigma_y": "300 MPa", "material_solid_damage": "at2",
         "material_solid_Gc": "20 N/mm", "material_solid_gamma": 0.3, "material_solid_c_v": 2.4, "material_solid_conductivity": 200,
         "material_solid_alpha_t": 2e-5, "bcs": "hold,pull", "bc_hold_on": "left", "bc_hold_type": "fix", "bc_pull_on": "right",
         "bc_pull_ux": "2e4*t", "ts_dt": 2e-7, "ts_max_time": 4e-6, "motion_snes_rtol": 1e-12, "damage_snes_rtol": 1e-12,
         "checkpoint_every": 10, "outputs": "vis", "output_vis_every": 5}


def compare(claim, one, other, tolerance=1e-8):
    worst, where = difference(one.history, other.history)
    check(f"{claim}, largest difference, in {where}", worst, 0, tolerance, relative=False)


def check_goes_on(claim, options, whole, cut, tolerance, rounding=()):
    """A run from its step `cut` on, with every step refused once and repeated, and on two ranks is `whole`, which has the options.
    Returns that on two ranks, of which the columns `rounding` are not compared."""
    halves = f"{whole.dir}_halves"
    run(halves, {**options, "ts_max_steps": cut})
    run(halves, {**options, "restart": "auto"})
    require(f"{claim}restart in the middle is bitwise",
            filecmp.cmp(f"{whole.dir}/history.csv", f"{halves}/history.csv", shallow=False))
    restep = run(f"{whole.dir}_restep", {**options, "test_restep": 1}, refused=None)
    worst, where = max((abs(restep[c] - whole[c]).max(), c) for c in whole.history if c != "tries" and numpy.isfinite(whole[c]).all())
    check(f"{claim}every step refused once and repeated, in {where}", worst, 0, 0, relative=False)
    two = run(f"{whole.dir}_ranks", options, ranks=2)
    histories = ({c: values for c, values in r.history.items() if c not in rounding} for r in (whole, two))
    worst, where = difference(*histories)
    check(f"{claim}two ranks, in {where}", worst, 0, tolerance, relative=False)
    return two


def check_whole(cells, numbers_of_ranks, kind="", **options):
    """`cells`: [dim -> cells along an edge]."""
    for dim, n in cells.items():
        more, dim = {**WHOLE, "mesh_set_dim": dim, "mesh_set_n": n, **options}, f"{kind}{dim}"
        one = run(f"whole_{dim}", more)
        check_between(f"{dim}D: it flows and is damaged", min(one["alpha_max"][-1], one["phi_max"][-1]), 1e-3, 1)
        run(f"cut_{dim}", {**more, "ts_max_steps": 10})
        again = run(f"cut_{dim}", {**more, "restart": "auto"})
        worst, where = difference(one.history, again.history, exact=True)
        check(f"{dim}D: from a checkpoint, largest difference, in {where}", worst, 0, 1e-300, relative=False)
        for ranks in numbers_of_ranks:
            many = run(f"ranks_{ranks}_{dim}", more, ranks=ranks)
            compare(f"{dim}D: on {ranks} ranks", one, many)
            worst, where = fields_difference(many.dir, one.dir, by_place=True)
            check(f"{dim}D: on {ranks} ranks, largest difference of a field, {where}", worst, 0, 1e-7, relative=False)
        run(f"moved_on_{dim}", {**more, "ts_max_steps": 10})
        compare(f"{dim}D: from one rank to two", one, run(f"moved_on_{dim}", {**more, "restart": "auto"}, ranks=2))
