"""The one comparison of two runs: their histories, column by column (tools/comparison.py), and their fields, value by value,
relative to the scale of each field."""
import math
import os
import re
import sys
import xml.etree.ElementTree

import numpy
from _runs import SOURCE, read_history

sys.path.insert(0, os.path.join(SOURCE, "tools"))
from comparison import difference  # noqa: E402, F401 (for the scripts)
from fields import Fields  # noqa: E402


def history(folder):
    return read_history(os.path.join(folder, "history.csv"))


def largest_modulus(said):
    """Largest of the moduli that the options give as plain numbers, 0 without any."""
    return max((float(n) for n in re.findall(r"-material_\w+_[EK][ \n]+([0-9.]+(?:e[+-]?\d+)?)(?=\s|$)", said)), default=0)


def field_values(folder, name, by_place):
    """Arrays of the field output by (time, field). `by_place`: in an order of places instead of the file's, which hangs on
    the ranks: cells by their middles, and what belongs to nodes by the corners of these cells. Bodies that touch have nodes
    at one place, but no two cells do."""
    fields = Fields(os.path.join(folder, name + ".xdmf"))
    values = {}
    for time, grid in zip(fields.times, fields.grids):
        X = fields.places(grid)
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
