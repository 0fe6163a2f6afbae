"""The one comparison of two histories, column by column, of the tools and of the tests.

    from comparison import difference, differences

A difference counts relative to the scale of its column: columns of one kind share theirs. What is exempt, and when, is said
here and nowhere else: counts of the solvers' work and places that jump from node to node are the same only where sums are
formed in the same order (`exact`); numbers below the rounding of what they are made of say nothing."""
import math
import re

import numpy

COUNTS = ("newton", "newton_most", "linear", "uzawa", "damage_its", "heat_its")
# Parts of a whole already: an energy of the largest one, a change of the forces of the forces.
OF_ONE = ("balance", "balance_first_law", "coupling_error")


def family(column):
    """Columns of one kind share a scale: a component that is zero but for the solver's tolerance is measured by its
    vector, and by what else is of its kind: energies, forces, impulses, displacements."""
    if column in OF_ONE:
        return "one"
    if column.startswith(("energy", "work", "dissipated", "exchange", "gain", "heat_")) or re.match(r"contact_\w+_work$", column):
        return "energy"
    if column.startswith("moment_"):
        return "moment"
    if re.match(r"rigid_\w+_[lruvw][xyz]$", column):
        return {"l": "spin", "r": "rotation", "u": "displacement", "v": "velocity", "w": "turning"}[column[-2]]
    if column.startswith("reaction") or re.match(r"contact_\w+_force", column):
        return "force"
    if column.startswith(("momentum", "impulse")):
        return "momentum"
    if re.match(r"contact_\w+_pressure", column):
        return column.rsplit("_", 1)[0]
    # Gaps that are held closed are rounding of displacements.
    if re.match(r"(mean|probe|measure)_\w+_u[xyz]$|contact_\w+_gap_min$", column):
        return "displacement"
    return re.sub(r"_?[va]?(xx|yy|zz|xy|yz|xz|x|y|z)$", "", column)


def rounding(scales, modulus):
    """Below these scales a column is rounding: stresses of strains under 1e-10, and what belongs to them. A body is at
    least as large as it moves while it deforms. An iterative solver leaves 1e-16 of prescribed displacements of zero."""
    moved = scales.get("displacement", 0)
    return {"energy": 1e-10 * modulus * min(moved ** 2, moved ** 3), "force": 1e-10 * modulus * min(moved, moved ** 2),
            "stress": 1e-10 * modulus, "displacement": 1e-15}


def scales_of(*histories):
    """The largest magnitude in each family of columns. Entropy is energy over temperature."""
    scales = {}
    for history in histories:
        for column, values in history.items():
            scales[family(column)] = max(scales.get(family(column), 0), abs(values[numpy.isfinite(values)]).max(initial=0))
    scales["one"] = 1.0
    if scales.get("theta_max", 0) > 0:
        scales["entropy_produced"] = max(scales.get("entropy_produced", 0), scales.get("energy", 0) / scales["theta_max"])
    return scales


def differences(a, b, modulus=0, exact=True):
    """(column, largest difference relative to its scale, row) of each column of two histories with the same columns and rows;
    infinite where only one of them has a number, None where a column is exempt or rounding."""
    scales = scales_of(a, b)
    none = rounding(scales, modulus)
    # Forces that balance to rounding say nothing: no body is 1e10 lengths long. Nor do moments beside forces or work, angular
    # momenta beside momenta or energies, rotations beside ways, their rates beside speeds.
    beside = {"force": ("energy",), "moment": ("force", "energy"), "spin": ("momentum", "energy"),
              "rotation": ("displacement",), "turning": ("velocity",)}
    for column, values in a.items():
        kind, other = family(column), b[column]
        scale, good = scales[kind], numpy.isfinite(values)
        small = max(1e-10 * max((scales.get(k, 0) for k in beside.get(kind, ())), default=0),
                    none.get("stress" if re.search("_(stress|von_mises|pressure)$", kind) else kind, 0))
        if not exact and (column in COUNTS or column == "tries" or column.startswith("crack")):
            yield column, None, 0
        elif (strange := good != numpy.isfinite(other)).any():
            yield column, math.inf, int(strange.argmax())
        elif scale < small:
            yield column, None, 0
        else:
            gap = abs(numpy.subtract(values, other, out=numpy.zeros(len(values)), where=good))
            row = int(gap.argmax()) if len(gap) else 0
            yield column, float(gap[row] / scale) if scale > 0 else 0.0, row


def difference(a, b, modulus=0, exact=False, skip=()):
    """Largest difference of two histories and its column; infinite where columns, rows or gaps differ. `modulus`: of the
    stiffest material; what is rounding beside it does not count. `exact`: counts and the places of cracks count too, as in
    two runs that form all sums in the same order. `skip`: what the caller itself made different."""
    if list(a) != list(b):
        return math.inf, "columns"
    if len(a["time"]) != len(b["time"]):
        return math.inf, f"{len(a['time'])} and {len(b['time'])} rows"
    worst, where = 0.0, "time"
    for column, gap, _ in differences(a, b, modulus, exact):
        if column not in skip and gap is not None and gap > worst:
            worst, where = gap, column
    return worst, where
