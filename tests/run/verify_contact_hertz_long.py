# labels: run long
# timeout: 300
"""Hertz's line contact on finer meshes: halvings of the cells, standard and dual multipliers; the distance from the
closed form at the full load is that of finite strain, for it falls with the load; Gauss points with their default."""
from _hertz import LIGHT, Indentation, full_load, light_load
from _runs import check, check_between, finish

for space in ("standard", "dual"):
    light_load(space, [Indentation(f"light_{space}_{n}", {**LIGHT, "mesh_set_n": n, "contact_face_multipliers": space})
                       for n in (10, 20, 40)], 0.75)
full_load("mortar", Indentation("mortar_40", {"mesh_set_n": 40}))
full_load("Gauss points", Indentation("gpts_40", {"mesh_set_n": 40, "contact_face_method": "gpts"}))
excess = []
for factor in (1, 0.1, 0.01):
    i = Indentation(f"load_{factor}", {"mesh_set_n": 40, "param_way": 1.5762 * factor**0.95,
                                       "mesh_set_patch": 9 * factor**0.5})
    excess.append(i.fitted()[0] - 1)
    print(f"     load {i.load:.1f}: fitted largest pressure over p0 - 1: {excess[-1]:.5f}")
check_between("excess of the largest pressure at a tenth of the load over that at the full one", excess[1] / excess[0],
              0.05, 0.6)
check("largest pressure at a hundredth of the load over p0", 1 + excess[2], 1, 2e-3)
finish()
