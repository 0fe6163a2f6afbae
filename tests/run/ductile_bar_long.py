# The notched bar of the gallery: with the ductile degradation the crack starts on the axis, with the quadratic one at the notch.
# labels: run long
# timeout: 600
import _runs as runs


def first(run, name):
    """The time at which phi passes 0.9 there."""
    return next(t for t, phi in zip(run["time"], run[f"probe_{name}_phi"]) if phi > 0.9)


for law, early, late in (("ductile", "centre", "root"), ("quadratic", "root", "centre")):
    run = runs.run(law, {"material_bar_ge": law}, files=[runs.option_file("ductile_bar.opts")])
    start = next(i for i, phi in enumerate(run["phi_max"]) if phi > 0.9)
    runs.check(f"{law}: the first phi above 0.9 is that of the {early}", run[f"probe_{early}_phi"][start],
               run["phi_max"][start], 1e-3)
    runs.check_between(f"{law}: phi at the {late} then", run[f"probe_{late}_phi"][start], 0, 0.3)
    runs.require(f"{law}: the crack is at the {late} later", first(run, late) > first(run, early))
    runs.check(f"{law}: first law", run["balance_first_law"][-1], 0, 0.02, relative=False)
    if law == "ductile":
        runs.check("largest force (N)", run["reaction_grip_y"].max(), 5784.5, 1e-3)
        runs.check("start of the crack (mm)", run["time"][start], 0.0867, 0.01)
    else:
        runs.check("largest force (N)", run["reaction_grip_y"].max(), 2660.4, 0.01)
        runs.require("nothing has flowed when it starts", run["alpha_max"][start] == 0)
runs.finish()
