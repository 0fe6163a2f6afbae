"""A body that tires under cyclic strains: its options, the energy and stress of a cell, the wave of a cycle."""
import math

import _runs as runs

E, NU, GC, WIDTH, REST = 1000.0, 0.3, 1.0, 1.0, 1e-6
K, G = E / 3 / (1 - 2 * NU), E / 2 / (1 + NU)
SOLID = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "materials": "solid",
         "material_solid_E": E, "material_solid_nu": NU, "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": GC,
         "material_solid_gamma": WIDTH, "material_solid_residual_stiffness": REST,
         "ts_period": 1, "damage_snes_rtol": 1e-13, "damage_ksp_rtol": 1e-13}
# A few steps for each cycle: a recurrence is that of the steps, the first law is not.
CELL = {**SOLID, "energy_stop": 0, "mesh_set_n": 1, "bcs": "hold", "bc_hold_on": "solid", "bc_hold_uy": 0}


def stretched(l):
    """Energy and S_11 of the undamaged body at diag(l, 1, 1), l >= 1."""
    shape, trace = l ** (-2 / 3), l * l + 2
    return (K / 2 * ((l * l - 1) / 2 - math.log(l)) + G / 2 * (shape * trace - 3),
            K / 2 * (l * l - 1) / l ** 2 + G * shape * (1 - trace / (3 * l * l)))


def wave(t):
    return 1 - abs(2 * (t - math.floor(t)) - 1)
