# labels: run
# timeout: 180
# long: 200
"""A run without inertia refuses, before its first step, a body that could move rigidly, and says how; a body that
contact touches from the start is warned of; held bodies run."""
from _runs import finish, long, mesh, require, run

STATIC = {"units": "mm_t_s_MPa", "materials": "solid", "material_solid_E": 1000, "material_solid_nu": 0.3,
          "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
SQUARE = {**STATIC, "mesh": mesh("block.geo"), "mesh_set_n": 6}
CUBE = {**SQUARE, "mesh_set_dim": 3, "mesh_set_n": 3}
PULL = {"bc_pull_on": "top", "bc_pull_type": "traction", "bc_pull_uy": 1}


def refused(claim, name, options, motions, region="solid", ranks=(1,)):
    for n in ranks:
        r = run(f"{name}_{n}", options, ranks=n, code=3)
        lines = [line for line in r.log.splitlines() if line.startswith("impact: -ts_type static: ")]
        good = len(lines) == 1 and f"the body of region {region} around" in lines[0]
        good = good and f"is not held against {motions};" in lines[0] and "-ts_type newmark" in lines[0]
        require(f"{claim}, {n} ranks: exit 3, '{motions}' and the remedy named in one line", good)
        if not good:
            print(r.log[-2000:])
        require(f"{claim}, {n} ranks: no step was taken", not r.history)


def runs(claim, name, options, warned=None, ranks=(1,), cut=0):
    for n in ranks:
        r = run(f"{name}_{n}", options, ranks=n, refused=cut)
        require(f"{claim}, {n} ranks: runs to the end", r["time"][-1] == 1)
        words = "is held by contact alone against"
        require(f"{claim}, {n} ranks: {'a' if warned else 'no'} warning",
                f"{words} {warned};" in r.log if warned else words not in r.log)


refused("free square under traction", "free", {**SQUARE, **PULL, "bcs": "pull"},
        "translation in x, translation in y, rotation", ranks=(1, 2) if long() else (2,))
refused("square held in y", "y_only", {**SQUARE, **PULL, "bcs": "pull,low", "bc_low_on": "bottom", "bc_low_uy": 0},
        "translation in x", ranks=(1, 2) if long() else (1,))
refused("square held at a corner", "corner",
        {**SQUARE, **PULL, "bcs": "pull,low", "bc_low_on": "origin", "bc_low_type": "fix"}, "rotation about (0, 0)")
runs("square held in y and at a corner in x", "held",
     {**SQUARE, **PULL, "bcs": "pull,low,corner", "bc_low_on": "bottom", "bc_low_uy": 0, "bc_corner_on": "origin",
      "bc_corner_ux": 0}, ranks=(1, 2) if long() else (1,))
refused("ring held in R", "ring", {**SQUARE, "plane": "axisymmetric", "bcs": "side", "bc_side_on": "left",
                                   "bc_side_ux": 0}, "translation in y, along the axis")
refused("cube on a plane", "cube", {**CUBE, **PULL, "bcs": "pull,low", "bc_low_on": "bottom", "bc_low_type": "symmetry"},
        "translation in x, translation in z, rotation about y")
runs("cube on three planes of symmetry", "planes",
     {**CUBE, **PULL, "bcs": "pull,low", "bc_low_on": "bottom,left,back", "bc_low_type": "symmetry"})

# Two blocks, the upper one guided in x above the lower one. A contact that is open but near holds it, one that sees nothing
# does not.
BLOCKS = {**STATIC, "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 4, "mesh_set_n_upper": 3,
          "materials": "solid", "material_solid_region": "lower,upper", "bcs": "plate,guide,load",
          "bc_plate_on": "lower_bottom", "bc_plate_type": "fix", "bc_guide_on": "upper", "bc_guide_ux": 0,
          "bc_load_on": "upper_top", "bc_load_type": "pressure", "bc_load_value": "10*t",
          "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top"}
refused("block far above", "far", {**BLOCKS, "mesh_set_gap": 2}, "translation in y", region="upper", ranks=(2 if long() else 1,))
runs("block above an open contact", "open", {**BLOCKS, "mesh_set_gap": 0.02}, warned="translation in y", ranks=(2,))
runs("block on a closed contact", "closed", {**BLOCKS, "mesh_set_gap": -1e-3, "contact_face_initial": "allow"},
     warned="translation in y")
runs("with inertia nothing is refused", "inertia",
     {**SQUARE, **PULL, "bcs": "pull", "ts_type": "newmark", "material_solid_rho": 1e-9}, cut=3)
finish()
