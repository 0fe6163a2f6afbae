# C10: the necking bar of Simo and Miehe (1992) with their thermal softening, w = 0.002/K, insulated and without expansion: what
# is stored as heat is what flow dissipated, and this nine tenths of the plastic work.
# labels: run long
# timeout: 1200
import _runs as runs

run = runs.run("necking", {
    "material_bar_softening": "linear", "material_bar_softening_w": 2e-3, "material_bar_alpha_t": 0,
    "material_bar_conductivity": 0, "bc_cold_type": "heat_flux", "bc_cold_value": 0, "bc_air_h": 0,
    "heat_form": "entropy", "heat_theta": 0.5, "ts_dt": 0.01,
    "ts_max_time": 6.5, "coupling_snes_max_it": 1, "output_vis_times": 6.5}, files=[runs.option_file("necking.opts")])
runs.require(f"C10: {len(run['step']) - 1} steps, none cut", len(run["step"]) == 651)
lost, kept = run["dissipated_plastic"], run["energy_plastic"]
# The trapezoidal entropy form: theta d eta = c_V d theta up to the square of a step's relative rise, below 1e-7 of it.
gain = run["energy_thermal"] - run["energy_thermal"][0]
runs.check("C10 heat stored - plastic dissipation / plastic dissipation, largest", abs(gain[1:] - lost[1:]).max() / lost[-1], 0, 1e-6,
           relative=False)
runs.check("C10 part of the plastic work that became heat", lost[-1] / (lost[-1] + kept[-1]), 0.9, 2e-4)
peak = run["reaction_grip_y"].argmax()
print(f"largest force {run['reaction_grip_y'][peak] / 1e3:.4f} kN at {run['mean_grip_uy'][peak]:.3f} mm; at {run['mean_grip_uy'][-1]} mm "
      f"{run['reaction_grip_y'][-1] / 1e3:.3f} kN, {run['theta_max'][-1]:.1f} K, plastic strain {run['alpha_max'][-1]:.3f}")
runs.finish()
