"""The one comparison of two runs: their histories, column by column, and their fields, value by value.

A difference counts relative to the scale of its column or field. What is exempt, and when, is said here and nowhere else:
counts of the solvers' work and places that jump from node to node are the same only where sums are formed in the same order
(`exact`); numbers below the rounding of what they are made of say nothing."""
import math
import os
import re
import sys
import xml.etree.ElementTree

import numpy
from _runs import SOURCE, read_history

sys.path.insert(0, os.path.join(SOURCE, "tools"))
from render import Fields  # noqa: E402

COUNTS = ("newton", "newton_most", "linear", "uzawa", "damage_its", "heat_its")
# Parts of a whole already: an energy of the largest one, a change of the forces of the forces.
OF_ONE = ("balance", "balance_first_law", "coupling_error")


def history(folder):
    return read_history(os.path.join(folder, "history.csv"))


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


def largest_modulus(said):
    """Largest of the moduli that the options give as plain numbers, 0 without any."""
    return max((float(n) for n in re.findall(r"-material_\w+_[EK][ \n]+([0-9.]+(?:e[+-]?\d+)?)(?=\s|$)", said)), default=0)


def rounding(scales, modulus):
    """Below these scales a column is rounding: stresses of strains under 1e-10, and what belongs to them. A body is at
    least as large as it moves while it deforms. An iterative solver leaves 1e-16 of prescribed displacements of zero."""
    moved = scales.get("displacement", 0)
    return {"energy": 1e-10 * modulus * min(moved ** 2, moved ** 3), "force": 1e-10 * modulus * min(moved, moved ** 2),
            "stress": 1e-10 * modulus, "displacement": 1e-15}


def scales_of(a):
    """The largest magnitude in each family of columns. Entropy is energy over temperature."""
    scales = {}
    for column, values in a.items():
        scales[family(column)] = max(scales.get(family(column), 0), abs(values[numpy.isfinite(values)]).max(initial=0))
    scales["one"] = 1.0
    if scales.get("theta_max", 0) > 0:
        scales["entropy_produced"] = max(scales.get("entropy_produced", 0), scales.get("energy", 0) / scales["theta_max"])
    return scales


def difference(a, b, modulus=0, exact=False, skip=()):
    """Largest difference of two histories and its column; infinite where columns, rows or gaps differ. `modulus`: of the
    stiffest material; what is rounding beside it does not count. `exact`: counts and the places of cracks count too, as in
    two runs that form all sums in the same order. `skip`: what the caller itself made different."""
    if list(a) != list(b):
        return math.inf, "columns"
    if len(a["time"]) != len(b["time"]):
        return math.inf, f"{len(a['time'])} and {len(b['time'])} rows"
    scales = scales_of(a)
    none = rounding(scales, modulus)
    worst, where = 0.0, "time"
    for column, values in a.items():
        if column in skip or not exact and (column in COUNTS or column == "tries" or column.startswith("crack")):
            continue
        kind = family(column)
        other, scale = b[column], scales[kind]
        if (numpy.isfinite(values) != numpy.isfinite(other)).any():
            return math.inf, column
        good = numpy.isfinite(values)
        gap = abs(values[good] - other[good]).max(initial=0)
        # Forces that balance to rounding say nothing: no body is 1e10 lengths long.
        if kind == "force" and scale < 1e-10 * scales.get("energy", 0):
            continue
        # Nor do moments beside forces or work, angular momenta beside momenta or energies, rotations beside ways, their
        # rates beside speeds.
        beside = {"moment": ("force", "energy"), "spin": ("momentum", "energy"), "rotation": ("displacement",),
                  "turning": ("velocity",)}
        if scale < 1e-10 * max((scales.get(other_kind, 0) for other_kind in beside.get(kind, ())), default=0):
            continue
        if scale < none.get("stress" if re.search("_(stress|von_mises|pressure)$", kind) else kind, 0):
            continue
        if scale > 0 and gap / scale > worst:
            worst, where = gap / scale, column
    return worst, where


def field_values(folder, name, by_place):
    """Arrays of the field output by (time, field). `by_place`: in an order of places instead of the file's, which hangs on
    the ranks: cells by their middles, and what belongs to nodes by the corners of these cells. Bodies that touch have nodes
    at one place, but no two cells do."""
    fields = Fields(os.path.join(folder, name + ".xdmf"))
    values = {}
    for time, grid in zip(fields.times, fields.grids):
        X = fields.array(grid.find("Geometry").find("DataItem"))
        size = abs(X).max() or 1
        order, corners = [], []
        for _, nodes, index in fields.cells(grid):
            place = numpy.round(X / size, 9)
            middles = place[nodes].sum(axis=1)
            row = numpy.lexsort(middles.T)
            among = numpy.array([numpy.lexsort(place[cell].T) for cell in nodes[row]])
            order.append(index[row])
            corners.append(numpy.take_along_axis(nodes[row], among, axis=1).ravel())
        for field in fields.names(grid):
            data, at_nodes = fields.field(grid, field)
            if by_place:
                data = data[numpy.concatenate(corners if at_nodes else order)]
            values[float(time), field] = data
        values[float(time), "X"] = X[numpy.concatenate(corners)] if by_place else X
    return values


def fields_difference(folder, reference, name="vis", partly=False, by_place=False, modulus=0, exact=True):
    """Largest difference of two field outputs, relative to the largest value of each field at any time, and where it is;
    infinite when one has other times or fields. `partly`: what `folder` lacks does not count."""
    found, right = field_values(folder, name, by_place), field_values(reference, name, by_place)
    if not (set(found) <= set(right) if partly else set(found) == set(right)):
        return math.inf, f"times or fields {sorted(set(found) ^ set(right))}"
    scale = {}
    for (_, field), values in right.items():
        scale[field] = max(scale.get(field, 0), abs(values[numpy.isfinite(values)]).max(initial=0))
    worst = (0.0, "")
    for (time, field), values in found.items():
        other = right[time, field]
        if values.shape != other.shape or (numpy.isfinite(values) != numpy.isfinite(other)).any():
            return math.inf, f"shape of {field} at t = {time:g}"
        if not exact and field == "contact_status":
            continue
        if re.search("stress|von_mises|pressure|traction", field) and scale[field] < 1e-10 * modulus:
            continue
        good = numpy.isfinite(values)
        gap = abs(values[good] - other[good]).max(initial=0)
        if gap > 0:
            worst = max(worst, (float(gap / scale[field]) if scale[field] > 0 else math.inf, f"{field} at t = {time:g}"))
    return worst


def field_times(folder, name="vis"):
    root = xml.etree.ElementTree.parse(os.path.join(folder, name + ".xdmf")).getroot()
    return [float(time.get("Value")) for time in root.iter("Time")]
