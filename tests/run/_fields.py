"""Reads the field output of a run."""
import os
import sys

import numpy
from _runs import SOURCE

sys.path.insert(0, os.path.join(SOURCE, "tools"))
from fields import Fields  # noqa: E402


def pressed(run, k=-1):
    """Of the k-th time written to vis.xdmf: reference x, current x and contact pressure of the nodes that carry one, by x."""
    fields = Fields(os.path.join(run.dir, "vis.xdmf"))
    grid = fields.grids[k]
    x = fields.places(grid)[:, 0]
    u, p = (fields.field(grid, name)[0][:, 0] for name in ("u", "contact_pressure"))
    nodes = numpy.flatnonzero(p > 0)
    nodes = nodes[numpy.argsort(x[nodes])]
    return x[nodes], (x + u)[nodes], p[nodes]


def pressure_jump(folder, corners=3):
    """Of triangles (3 corners) or tetrahedra (4), at the last time: root mean square of what the mean pressures of neighbours
    differ by, over that of the pressure."""
    fields = Fields(os.path.join(folder, "vis.xdmf"))
    grid, sides = fields.grids[-1], {}
    pressure = fields.field(grid, "pressure")[0][:, 0]
    for cell, nodes in enumerate(fields.array(grid.find("Topology").find("DataItem"))[:, :corners]):
        for k in range(corners):
            sides.setdefault(tuple(sorted(numpy.delete(nodes, k))), []).append(cell)
    pairs = numpy.array([cells for cells in sides.values() if len(cells) == 2])
    return numpy.sqrt(numpy.mean((pressure[pairs[:, 0]] - pressure[pairs[:, 1]]) ** 2)) / numpy.std(pressure)


class Bodies:
    """Momentum and moment of momentum of plane quadrilaterals by 2 x 2 Gauss points, from the fields u and v."""

    def __init__(self, run, density):
        self.fields = Fields(os.path.join(run.dir, "vis.xdmf"))
        grid = self.fields.grids[0]
        self.x = self.fields.places(grid)[:, :2]
        ((_, self.cells, _),) = self.fields.cells(grid)
        self.density = density

    def moments(self, k):
        """The two components of the momentum at the k-th time and the moment of momentum about the origin."""
        grid = self.fields.grids[k]
        u, v = (self.fields.field(grid, name)[0][:, :2] for name in ("u", "v"))
        total = numpy.zeros(3)
        for xi in (-3**-0.5, 3**-0.5):
            for eta in (-3**-0.5, 3**-0.5):
                a, b = numpy.array([-1, 1, 1, -1]), numpy.array([-1, -1, 1, 1])
                N = (1 + a * xi) * (1 + b * eta) / 4
                d = numpy.array([a * (1 + b * eta), b * (1 + a * xi)]) / 4
                J = numpy.linalg.det(numpy.einsum("ia,cak->cik", d, self.x[self.cells]))
                place = numpy.einsum("a,cak->ck", N, (self.x + u)[self.cells])
                speed = numpy.einsum("a,cak->ck", N, v[self.cells])
                moment = place[:, 0] * speed[:, 1] - place[:, 1] * speed[:, 0]
                total += self.density * numpy.array([J @ speed[:, 0], J @ speed[:, 1], J @ moment])
        return total
