"""On 4, 8 and 16 ranks the fullest rank has at most 1.15 times the mean of the cells and 1.15 times the mean of the facets of
secondary surfaces, or one facet more than that has, and linear solvers take at most 1.2 times the iterations of one rank: the beam on the wedge, once refined, and the
sphere on a plane in space. Balanced in the sum of both, one of 16 ranks had 6.7 times the mean of the facets."""
# labels: run
# processors: 2
# timeout: 240
from _partition import BEAM, SPHERE, check_case, shares
from _runs import check_between, finish, mesh, run

check_case("beam", *BEAM, refine=1)
check_case("sphere", *SPHERE, refine=0)

# With the facets of both sides for work each rank had one block, and one of them all the pairs.
blocks = run("blocks", {
    "mesh": mesh("two_blocks.geo"), "mesh_set_dim": 3, "mesh_set_n_lower": 8, "mesh_set_n_upper": 7, "materials": "lower,upper",
    "material_lower_E": 1e6, "material_lower_nu": 0.3, "material_upper_like": "lower", "contacts": "face",
    "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top", "bcs": "hold,press",
    "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_press_on": "upper_top", "bc_press_uy": "-0.01*t", "bc_press_ux": 0,
    "bc_press_uz": 0, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}, ranks=2)
check_between("two blocks on two ranks: secondary facets of the fullest over the mean", shares(blocks.log)[1][0], 1, 1.15)
finish()
