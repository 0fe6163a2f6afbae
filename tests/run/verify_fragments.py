# An expanding ring of the gallery with a quarter of its cells: as many pieces as cohesive cracks make in published runs of a
# bar, Zhou, Molinari and Ramesh (2006), more with the rate as Grady's energy says; none before the strength is reached.
# labels: run
# timeout: 120
# long: 200
import math

import _runs as runs
from fields import Fields
from fragments import parts

E, RHO, STRENGTH, GC, RADIUS = 275e3, 2.75e-9, 300.0, 0.1, 2.01  # MPa, t/mm^3, N/mm, mm
LENGTH, C = E * GC / STRENGTH**2, math.sqrt(E / RHO)
RATE = C * STRENGTH**3 / (E**2 * GC)
pieces = {}
for rate, end in ((2e4, 0.25e-6), (8e4, 0.12e-6)):
    counts = []
    for seed in (1, 2, 3) if runs.long() else (1,):
        run = runs.run(f"ring_{rate:g}_{seed}", {
            "mesh_set_n_around": 1200, "mesh_set_n_through": 4, "mesh_set_seed": seed, "material_ring_gamma": 0.025,
            "param_rate": rate, "ts_max_time": end, "output_vis_dt": end}, files=[runs.option_file("expanding_ring.opts")])
        # The hoop strain is rate R/c sin(c t/R), that of a ring that breathes.
        reached = math.asin(STRENGTH / E * C / RADIUS / rate) * RADIUS / C
        first = run["time"][run["phi_max"] > 0][0]
        runs.check(f"rate {rate:g}, seed {seed}: time of the first damage", first, reached, 0.08)
        fields = Fields(f"ring_{rate:g}_{seed}/vis.xdmf")
        found = parts(fields, fields.grids[-1])
        runs.check_between(f"rate {rate:g}, seed {seed}: what the pieces are of the ring", sum(found), 0.9, 1)
        counts.append(len(found))
        cracks = run["energy_fracture"][-1] / (GC * 0.08)
        runs.require(f"rate {rate:g}, seed {seed}: {len(found)} pieces have cost {cracks:.4g} cracks", cracks > 0.98 * len(found))
    pieces[rate] = sum(counts) / len(counts)
    published = 2 * math.pi * RADIUS / (LENGTH * 4.5 / (1 + 4.5 * (rate / RATE)**(2 / 3)))
    runs.check(f"rate {rate:g}: number of pieces", pieces[rate], published, 0.2)
runs.check("growth of the number with the rate: exponent", math.log(pieces[8e4] / pieces[2e4]) / math.log(4), 2 / 3, 0.08, relative=False)
runs.finish()
