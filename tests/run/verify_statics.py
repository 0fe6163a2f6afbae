# Elastic statics: Cook's membrane, compressible and nearly incompressible (A4, A5).
# labels: run
# timeout: 120
import _runs as runs

STATIC = {"ts_type": "static", "units": "mm_t_s_MPa"}


def cook(name, n, E, nu, force, locking, steps, at):
    return runs.run(name, {
        **STATIC, "mesh": runs.mesh("cook.geo"), "mesh_set_n": n, "materials": "solid", "material_solid_E": repr(E),
        "material_solid_nu": nu, "material_solid_locking": locking, "bcs": "clamp,shear", "bc_clamp_on": "left",
        "bc_clamp_type": "fix", "bc_shear_on": "right", "bc_shear_type": "force", "bc_shear_uy": f"{force}*t",
        "ts_dt": 1 / steps, "ts_max_time": 1, "probes": "p", "probe_p_at": at, "probe_p_fields": "u"},
                    refused=6 if nu > 0.49 else 0)["probe_p_uy"][-1]  # a force on what is nearly incompressible


# A4: an independent program with this law and element; deal.II's code gallery (quasi-static finite-strain compressible
# elasticity, Q1) gives 12.07, 13.86, 14.49, 14.67.
G = 0.4225
for n, reference in ((4, 12.0712), (8, 13.8632), (16, 14.4853), (32, 14.6673)):
    u = cook(f"a4_{n}", n, 2 * G * 1.3, 0.3, 1, "none", 2, "48,52")
    runs.check(f"A4 Cook compressible, middle of the loaded edge, n = {n}", u, reference, 1e-4, relative=False)

# A5: the same law and element by an independent program.
for locking, n, reference in (("fbar", 8, 6.631), ("fbar", 16, 6.818), ("mean", 8, 6.619), ("mean", 16, 6.815)):
    u = cook(f"a5_{locking}_{n}", n, 240.565, 0.4999, 100, locking, 5, "48,60")
    runs.check(f"A5 Cook nearly incompressible, {locking}, corner, n = {n}", u, reference, 1e-3, relative=False)
u = cook("a5_none", 16, 240.565, 0.4999, 100, "none", 5, "48,60")
runs.check_between("A5 plain quadrilaterals lock, n = 16", u, 0.5, 4)

# Left to itself the program takes the cure from nu = 0.45 on, and says so; below it does not.
u = cook("auto_0.4999", 16, 240.565, 0.4999, 100, "auto", 5, "48,60")
runs.check("A5 with -material_<id>_locking auto, corner, n = 16", u, 6.815, 1e-3, relative=False)
for nu, cure in ((0.45, "mean"), (0.449, "none")):
    u, same = (cook(f"auto_{nu}_{locking}", 4, 240.565, nu, 10, locking, 1, "48,60") for locking in ("auto", cure))
    runs.require(f"auto at nu = {nu} is {cure}", u == same)

# What locks without a cure is named, once: flow or nu on simplices, and under a split that has none.
J2 = {"material_solid_model": "j2", "material_solid_sigma_y": 10}
SQUARE = {**STATIC, "mesh": runs.mesh("block.geo"), "mesh_set_n": 2, "materials": "solid", "material_solid_E": 1000,
          "material_solid_nu": 0.3, "bcs": "hold", "bc_hold_on": "left", "bc_hold_type": "fix", "ts_dt": 1, "ts_max_time": 1,
          "dry_run": 1}
SOFT, PLAIN = {"material_solid_nu": 0.49}, {"material_solid_locking": "none"}
SPECTRAL = {"material_solid_damage": "at2", "material_solid_Gc": 1, "material_solid_gamma": 1, "material_solid_split": "spectral"}
for name, more, shape, cause in (
        ("triangles", {**J2, **PLAIN, "mesh_set_simplex": 1}, "linear triangles", "j2"),
        ("tetrahedra", {**J2, **PLAIN, "mesh_set_simplex": 1, "mesh_set_dim": 3}, "linear tetrahedra", "j2"),
        ("soft_triangles", {**SOFT, **PLAIN, "mesh_set_simplex": 1}, "linear triangles", "nu from 0.45"),
        ("fbar_triangles", {**J2, "material_solid_locking": "fbar", "mesh_set_simplex": 1}, "linear triangles", "j2"),
        ("patched_triangles", {**J2, "mesh_set_simplex": 1}, "", ""),
        ("patched_tetrahedra", {**J2, "mesh_set_simplex": 1, "mesh_set_dim": 3}, "", ""),
        ("patched_soft", {**SOFT, "mesh_set_simplex": 1}, "", ""),
        ("split_triangles", {**SOFT, **SPECTRAL, "mesh_set_simplex": 1}, "linear triangles", "nu from 0.45"),
        ("soft_split", {**SOFT, **SPECTRAL}, "", ""),
        ("quads", J2, "", ""), ("soft_quads", SOFT, "", ""), ("stiff_triangles", {"mesh_set_simplex": 1}, "", ""),
        ("sheet", {**J2, "mesh_set_simplex": 1, "plane": "stress"}, "", "")):
    log = runs.run(name, {**SQUARE, **more}).log
    words = [line for line in log.splitlines() if " lock, " in line]
    if shape:
        runs.require(f"{name}: one warning with material, cells, cause and remedy: {words}", len(words) == 1 and all(
            part in words[0] for part in ("material solid", shape, cause, "remedy")))
    else:
        runs.require(f"{name}: no warning", not words)
    runs.require(f"{name}: the cure is named where there is one",
                 ("material solid: locking cure of its " in log) == (name in ("quads", "soft_quads", "soft_split") or "patched" in name))
runs.finish()
