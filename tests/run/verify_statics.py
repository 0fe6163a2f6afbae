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
runs.finish()
