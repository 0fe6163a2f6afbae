# labels: run long
# timeout: 600
"""Every method and enforcement of contact, in the plane and in space: free flight first, equal and opposite impulses,
the same history turned about an axis of no edge with each body on a rank of its own, by whatever criterion Newton's
method ends, the sides swapped, and a body that is facets deep within a step."""
from _gates import ALL, SWAPPED, began_as, flight, held, opposite, same, sides_swapped, touches_and_keeps_momentum
from _runs import finish

# Each alone, the others switched off; the last one leaves all of them to the program.
CRITERIA = {
    "rtol": {"motion_snes_rtol": 1e-9, "motion_snes_atol": 0},
    "atol": {"motion_snes_rtol": 0, "motion_snes_atol": 1e-5},
    "rounding": {"motion_snes_rtol": 0, "motion_snes_atol": 0},
    "default": {"motion_snes_rtol": None, "motion_snes_atol": None},
}
# Two different materials whose sides run on rails: one-dimensional, so that the choice of sides changes nothing but what
# is numerical, if the facets match. Mortar integrates exactly over facets that do not, where the numbers that go with the
# secondary facet are given.
RAILS = {"mesh_set_inset": 0, "material_upper_E": 3e6, "bcs": "rails", "bc_rails_on": "lower_sides,upper_sides",
         "bc_rails_ux": 0}
COARSER = {"mesh_set_n_upper": 2, "contact_face_penalty": 3e7, "contact_face_gap_tol": 1e-5}
# The lower block stands on the ground, its facets are 0.25 wide.
GROUND = {"mesh_set_n_lower": 4, "mesh_set_inset": 0.1, "bcs": "ground", "bc_ground_on": "lower_bottom",
          "bc_ground_type": "fix", "contact_face_impact": "stabilised"}

for case in ALL:
    dim, method, enforce = case
    name = f"{dim}D, {method}, {enforce}"
    reference = flight(case, "straight")
    touches_and_keeps_momentum(name, reference)
    turned = flight(case, "turned", angle=37, tilt=-24 if dim == 3 else 0, ranks=2,
                    extra={"petscpartitioner_type": "simple"})
    same(f"{name}, turned, each body on its own rank", reference, turned, 1e-8)

    for criterion, options in CRITERIA.items():
        began_as(f"{name}, {criterion} decides", reference,
                 flight(case, criterion, extra={**options, "ts_max_time": 0.06}), 1e-8)

    # An automatic penalty, and with it the depth, goes with the secondary facet.
    sides_swapped(name, reference, flight(case, "swapped", extra=SWAPPED), 2e-2 if enforce == "penalty" else 3e-3)
    rails = {**RAILS, **({"bc_rails_uz": 0} if dim == 3 else {}),
             **({"contact_face_pressure_tol": 1e-9} if enforce == "auglag" else {})}
    for facets, extra in {"that match": {}, **({"that do not": COARSER} if method == "mortar" else {})}.items():
        one = flight(case, f"rails_{facets[-3:]}", extra={**rails, **extra})
        other = flight(case, f"rails_{facets[-3:]}_swapped", extra={**rails, **extra, **SWAPPED})
        opposite(f"{name}, sides swapped, facets {facets}", one, other, 1e-9)

    for facets, sides in ((3.2, {}), (3.2, SWAPPED), (5, {}), (5, SWAPPED)):
        step = facets * 0.25
        fast = flight(case, f"fast_{facets}_{'swapped' if sides else 'straight'}",
                      extra={**GROUND, **sides, "ts_dt": step, "ts_max_time": 4 * step})
        held(f"{name}, v dt = {facets} facets{', sides swapped' if sides else ''}", fast, upper_is_secondary=not sides)
finish()
