# Energy audit of a fracture run (D15): a notched plate is torn by a moving side, with inertia, rate-dependent damage
# and iterated coupling. External work must go into kinetic, elastic and crack energy and dissipation. After the break
# the crack closes and is stiff at once, like contact: what that takes is part of the audit.
# labels: run
# timeout: 120
import numpy

import _runs as runs

with open("notched.geo", "w") as file:
    file.write("""// Upper half of a plate with an edge notch on its symmetry plane y = 0; the ligament is x > 0.3.
h = 1 / 24;
Point(1) = {0, 0, 0}; Point(2) = {0.3, 0, 0}; Point(3) = {1, 0, 0};
Point(4) = {1, 0.5, 0}; Point(5) = {0.3, 0.5, 0}; Point(6) = {0, 0.5, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1};
Line(7) = {2, 5};
Curve Loop(1) = {1, 7, 5, 6}; Plane Surface(1) = {1};
Curve Loop(2) = {2, 3, 4, -7}; Plane Surface(2) = {2};
Transfinite Curve {1, 5} = Round(0.3 / h) + 1; Transfinite Curve {2, 4} = Round(0.7 / h) + 1;
Transfinite Curve {3, 6, 7} = Round(0.5 / h) + 1;
Transfinite Surface "*"; Recombine Surface "*";
Physical Surface("plate") = {1, 2};
Physical Curve("ligament") = {2}; Physical Curve("top") = {4, 5};
""")


def tear(name, dt):
    run = runs.run(name, {
        "units": "mm_t_s_MPa", "mesh": "notched.geo", "materials": "plate", "material_plate_E": 210e3,
        "material_plate_nu": 0.3, "material_plate_rho": 7.8e-9, "material_plate_damage": "at2", "material_plate_split": "volumetric",
        "material_plate_Gc": 2.7, "material_plate_gamma": 0.1, "material_plate_c": 1e6, "bcs": "symmetry,pull",
        "bc_symmetry_on": "ligament", "bc_symmetry_uy": 0, "bc_pull_on": "top", "bc_pull_uy": "400*(t-4e-6*(1-exp(-t/4e-6)))",
        "bc_pull_ux": 0, "ts_dt": dt, "ts_max_time": 2e-5, "coupling_snes_max_it": 50, "coupling_snes_atol": 1e-4,
        "motion_snes_rtol": 1e-12, "motion_snes_atol": 1e-10, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
        "ts_newmark_rho": 0.8})
    spent = sum(column for key, column in run.history.items() if key in (
        "energy_kinetic", "energy_elastic", "energy_plastic", "energy_fracture", "dissipated_viscous",
        "dissipated_damage", "dissipated_plastic", "dissipated_numerical", "dissipated_closing", "energy_numerical",
        "energy_contact"))
    missing = spent - spent[0] - run["work_external"]
    audit = abs(missing).max() / run["work_external"].max()
    print(f"     {name}: {len(run['step']) - 1} steps, work {run['work_external'].max():.4g}, at the end kinetic "
          f"{run['energy_kinetic'][-1]:.3g}, elastic {run['energy_elastic'][-1]:.3g}, crack "
          f"{run['energy_fracture'][-1]:.3g}, dissipated by damage {run['dissipated_damage'][-1]:.3g}, largest force "
          f"{run['reaction_pull_y'].max():.4g}, last {run['reaction_pull_y'][-1]:.3g}")
    return run, audit


coarse, coarse_audit = tear("coarse", 1e-7)
fine, fine_audit = tear("fine", 5e-8)
for run, audit, dt in ((coarse, coarse_audit, 1e-7), (fine, fine_audit, 5e-8)):
    runs.check(f"D15 dt = {dt}: energy that the audit misses / external work", audit, 0, 5e-3, relative=False)
    # Relative to the work so far, which is nothing in the first steps.
    loaded = run["work_external"] > 0.01 * run["work_external"].max()
    runs.check(f"D15 dt = {dt}: balance of the integrator", abs(run["balance"][loaded]).max(), 0, 1e-10,
               relative=False)
runs.check_between("D15 the missing energy falls with dt, ratio", coarse_audit / fine_audit, 1.5, 5)
runs.require("D15 the plate broke", fine["phi_max"][-1] > 0.95 and
             fine["reaction_pull_y"][-1] < 0.3 * fine["reaction_pull_y"].max())
drop = numpy.diff(fine["energy_fracture"]).min() / fine["energy_fracture"].max()
runs.check_between("D15 the crack energy never falls: smallest increment / largest energy", drop, -1e-4, 1)

# The integrator's identity from the first step on, where the load is there at once and a_0 is not zero.
for rho in (1, 0.8):
    run = runs.run(f"front_{rho}", {"ts_newmark_rho": rho, "ts_max_time": 2e-6, "motion_snes_rtol": 1e-12,
                                    "motion_ksp_rtol": 1e-12}, files=[runs.option_file("bar_wave.opts")])
    runs.check(f"D15 pressure on a bar at once, rho = {rho}: balance of the integrator", abs(run["balance"]).max(), 0,
               1e-10, relative=False)
runs.finish()
