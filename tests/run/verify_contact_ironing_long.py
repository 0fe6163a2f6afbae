# labels: run long
# timeout: 600
"""Shallow ironing on the mesh of the published runs and a finer one (see verify_contact_ironing.py)."""
from _runs import check, check_between, finish
from verify_contact_ironing import HALF, forces, indented, ironed

whole = ironed("whole", {})
finer = ironed("finer", {"mesh_set_n": 18, "mesh_set_grow": 1.04, "mesh_set_n_height": 30})
for k, force in enumerate(("vertical", "horizontal")):
    check(f"{force} force at t = 1.5, the two meshes", forces(finer, 1.5)[k], forces(whole, 1.5)[k], 0.02)
coarse = indented("gpts_half", ironed("half", HALF), HALF)
check_between("Gauss points against mortar, cells of half the size over those before", indented("gpts_whole", whole, {}) / coarse,
              0, 0.7)
finish()
