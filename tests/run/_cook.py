"""Cook's membrane, in the plane or as a slab between smooth walls. Nearly incompressible, 6.93 is the limit of quadrilaterals with
mean dilatation (6.815, 6.884, 6.911 with 16, 32, 64 cells along a side)."""
from _runs import mesh, run

SOFT = {"material_solid_E": 240.565, "material_solid_nu": 0.4999}


def cook(name, n, force=100, law=SOFT, simplices=1, depth=0, refused=None, **more):
    space = {"mesh_set_depth": depth, "bcs": "clamp,shear,faces", "bc_faces_on": "faces", "bc_faces_uz": 0} if depth else {}
    return run(name, {
        "ts_type": "static", "units": "mm_t_s_MPa", "mesh": mesh("cook.geo"), "mesh_set_n": n, "mesh_set_simplices": simplices,
        "materials": "solid", **law, "bcs": "clamp,shear", "bc_clamp_on": "left", "bc_clamp_type": "fix", "bc_shear_on": "right",
        "bc_shear_type": "force", "bc_shear_uy": f"{force * (depth or 1)}*t", "ts_dt": 0.1, "ts_max_time": 1, "probes": "p",
        "probe_p_at": f"48,60,{depth / 2}" if depth else "48,60", "probe_p_fields": "u", "outputs": "vis",
        "output_vis_fields": "pressure", **space, **more}, refused=refused)
