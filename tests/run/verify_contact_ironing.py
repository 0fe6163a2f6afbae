# labels: run
# timeout: 240
"""Shallow ironing with friction (options/ironing.opts): forces between those of Code_Aster, of Poulios and Renard and of a
finite-volume program; smooth on two meshes; the Gauss points, which lose their way as soon as the block slides over the
hollow that it has made, agree with mortar until then."""
import numpy
from _runs import check, check_between, finish, long, option_file, run

# Of the digitised curves and the table of the same benchmark in solids4foam (tutorials/solids/hyperelasticity/shallowIroning),
# N per mm: vertical and horizontal force at the end of the indentation and half way.
ASTER = {1: (332.0, 71.0), 1.5: (421.0, 143.3)}
VOLUMES = {1: (316.4, 55.0), 1.5: (395.1, 122.7)}  # solids4foam
RENARD = {1: (267.9, 55.3), 1.5: (337.4, 102.1)}  # Poulios and Renard, Computers & Structures 153 (2015)
HALF = {"mesh_set_n": 6, "mesh_set_n_height": 12, "mesh_set_grow": 1.1}
TWO_THIRDS = {"mesh_set_n": 8, "mesh_set_n_height": 16, "mesh_set_grow": 1.08}


def forces(r, time):
    """Vertical and horizontal force on the block."""
    return [numpy.interp(time, r["time"], abs(r[f"reaction_press_{k}"])) for k in "yx"]


def unsmooth(r, column):
    """Largest distance of the force from a parabola of fourth degree while the block slides from 2 to 8 mm, over its mean."""
    sliding = (r["time"] > 1.2) & (r["time"] < 1.8)
    t, f = r["time"][sliding], abs(r[column][sliding])
    return abs(f - numpy.polyval(numpy.polyfit(t - 1.5, f, 4), t - 1.5)).max() / f.mean()


def ironed(name, options):
    """Of 125 steps one or two are cut, on one mesh or another, where a node that slides passes a corner of the foundation."""
    r = run(name, {"output_vis_dt": 10, **options}, files=[option_file("ironing.opts")], refused=3)
    down, along = forces(r, 1), forces(r, 1.5)
    print(f"     {name}: {len(r['time']) - 1} steps, Newton iterations per step {r['newton'][1:].mean():.1f}, most "
          f"{r['newton'].max():.0f}, Uzawa passes {r['uzawa'].max():.0f}\n"
          f"     V and H at t = 1: {down[0]:.1f}, {down[1]:.1f} (Code_Aster {ASTER[1]}, solids4foam {VOLUMES[1]}, Poulios and "
          f"Renard {RENARD[1]})\n"
          f"     V and H at t = 1.5: {along[0]:.1f}, {along[1]:.1f} ({ASTER[1.5]}, {VOLUMES[1.5]}, {RENARD[1.5]})")
    check_between(f"{name}: tries of a step", r["tries"].max(), 1, 2)
    check_between(f"{name}: steps, of 125 without a cut", len(r["time"]) - 1, 125, 132)
    for time, (vertical, horizontal) in {1: down, 1.5: along}.items():
        check(f"{name}: vertical force at t = {time} against Code_Aster", vertical, ASTER[time][0], 0.03)
        check_between(f"{name}: horizontal force at t = {time} between those of the three programs", horizontal,
                      RENARD[time][1], ASTER[time][1])
    check_between(f"{name}: horizontal over vertical force at t = 1.5 (published: 0.30 to 0.34)", along[1] / along[0], 0.30, 0.34)
    for column, what in (("reaction_press_y", "vertical"), ("reaction_press_x", "horizontal")):
        check(f"{name}: largest distance of the {what} force from a smooth curve over its mean", unsmooth(r, column), 0, 0.05,
              relative=False)
    worked = r["time"] > 0.5  # the balance is over the work so far
    check(f"{name}: work balance of the steps", abs(r["balance"][worked]).max(), 0, 1e-9, relative=False)
    return r


def indented(name, mortar, options):
    """Gauss points against mortar up to the end of the indentation: the larger relative difference of the two forces. One
    step of the Gauss points is cut, as ever, and up to four solves are repeated, one of them in the place of another cut."""
    r = run(name, {"output_vis_dt": 10, "contact_face_method": "gpts", "ts_max_time": 1, "ts_times": "0,1", "ts_dts": "0.04",
                   **options}, files=[option_file("ironing.opts")], refused=5)
    differences = [abs(a / b - 1) for a, b in zip(forces(r, 1), forces(mortar, 1))]
    print(f"     {name}: forces differ from those of mortar by {differences[0]:.2e} and {differences[1]:.2e}")
    return max(differences)


if __name__ == "__main__":
    coarse = ironed("half", HALF)
    if long():
        fine = ironed("two_thirds", TWO_THIRDS)
        check("vertical force at t = 1.5, the two meshes", forces(fine, 1.5)[0], forces(coarse, 1.5)[0], 0.01)
        check("Gauss points against mortar, indentation", indented("gpts_two_thirds", fine, TWO_THIRDS), 0, 0.01, relative=False)
    finish()
