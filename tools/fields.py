"""Reads the .xdmf files of a run and cuts what they hold, for the other tools and for scripts:

    from fields import Fields
    fields = Fields("run/vis.xdmf")
    grid = fields.grids[-1]
    x, (phi, on_nodes) = fields.places(grid), fields.field(grid, "phi")
"""
import os
import sys
import xml.etree.ElementTree as ElementTree

import h5py
import numpy as np

NODES = {4: 3, 5: 4, 6: 4, 9: 8, 35: 9, 36: 6, 37: 8, 38: 10, 48: 20, 50: 27}  # by XDMF cell type
TYPES = {"Triangle": 4, "Quadrilateral": 5, "Tetrahedron": 6, "Hexahedron": 9, "Triangle_6": 36, "Tetrahedron_10": 38,
         "Quadrilateral_9": 35, "Quadrilateral_8": 37, "Hexahedron_27": 50, "Hexahedron_20": 48}
GRID = [0, 8, 1, 11, 24, 9, 3, 10, 2, 16, 22, 17, 20, 26, 21, 19, 23, 18, 4, 12, 5, 15, 25, 13, 7, 14, 6]  # of Hexahedron_27
# Cells of second order are seen as linear ones between their nodes (Hexahedron_20: between its corners): the type of these, their
# corners.
PARTS = {35: (5, [(0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3)]),
         37: (4, [(0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)]),
         48: (9, [tuple(range(8))]),
         50: (9, [tuple(GRID[first + step] for step in (0, 1, 4, 3, 9, 10, 13, 12)) for first in (0, 1, 3, 4, 9, 10, 12, 13)]),
         36: (4, [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)]),
         38: (6, [(0, 4, 6, 7), (4, 1, 5, 8), (6, 5, 2, 9), (7, 8, 9, 3),
                  (6, 8, 4, 5), (6, 8, 5, 9), (6, 8, 9, 7), (6, 8, 7, 4)])}
FACES = {6: [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
         9: [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]}
TETRAHEDRA = {6: [(0, 1, 2, 3)], 9: [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]}

# Of -units, and what a field is in them.
SYSTEMS = {"SI": ("m", "s", "Pa"), "mm_t_s_MPa": ("mm", "s", "MPa"), "mm_kg_ms_GPa": ("mm", "ms", "GPa")}
QUANTITIES = {"u": "{0}", "v": "{0}/{1}", "a": "{0}/{1}$^2$", "theta": "K", "stress": "{2}", "von_mises": "{2}", "pressure": "{2}",
              "contact_pressure": "{2}", "contact_traction": "{2}", "contact_gap": "{0}", "contact_slip": "{0}",
              "length": "{0}", "time": "{1}"}
COMPONENTS = {3: ("x", "y", "z"), 6: ("xx", "yy", "zz", "xy", "yz", "xz")}


def stop(message):
    """One line and exit status 2: what the user can mend."""
    print(f"{os.path.basename(sys.argv[0])}: {message}", file=sys.stderr)
    sys.exit(2)


class Fields:
    """The grids of an .xdmf file, one for each time; arrays are read from its .h5 when they are asked for.

    Nodes and cells of all grids have the order of the first one: a restart on other ranks writes them in another one.
    """

    def __init__(self, path):
        self.path, self.dir = path, os.path.dirname(os.path.abspath(path))
        try:
            root = ElementTree.parse(path).getroot()
        except (OSError, ElementTree.ParseError) as error:
            stop(f"cannot read {path}: {error}")
        self.grids = [g for g in root.iter("Grid") if g.get("GridType") == "Uniform" and g.find("Time") is not None]
        if not self.grids:
            stop(f"{path} holds no times")
        self.times = np.array([float(g.find("Time").get("Value")) for g in self.grids])
        said = {i.get("Name"): i.get("Value") for i in root.iter("Information")}
        self.system = SYSTEMS.get(said.get("units"))
        self._cells, self._orders = {}, {}

    def unit(self, quantity):
        """Unit of a field, of "length" or of "time" as text in brackets, empty where it has none or the file does not say."""
        if self.system is None or quantity not in QUANTITIES:
            return ""
        return f" ({QUANTITIES[quantity].format(*self.system)})"

    def array(self, item):
        name, _, dataset = item.text.strip().partition(":")
        try:
            with h5py.File(os.path.join(self.dir, name), "r") as file:
                return file[dataset][()]
        except (OSError, KeyError) as error:
            stop(f"cannot read {dataset} of {name}: {error}")

    def names(self, grid):
        return [a.get("Name") for a in grid.iter("Attribute")]

    def places(self, grid):
        """Reference places of the nodes [node][3]."""
        x = self.array(grid.find("Geometry").find("DataItem"))
        order = self._order(grid)
        return x if order is None else x[order[0]]

    def field(self, grid, name):
        """Values [entity][component] and whether they live on nodes; None when the grid lacks the field."""
        for attribute in grid.iter("Attribute"):
            if attribute.get("Name") == name:
                values, on_nodes = self.array(attribute.find("DataItem")), attribute.get("Center") == "Node"
                order = self._order(grid)
                if order is not None:
                    values = values[order[0 if on_nodes else 1]]
                return values.reshape(len(values), -1), on_nodes
        return None

    def _order(self, grid):
        """Nodes and cells of a grid's mesh in the order of the first one's, as their own numbers; None where they are in it."""
        name = grid.find("Geometry").find("DataItem").text
        if not self._orders:
            self._orders[self.grids[0].find("Geometry").find("DataItem").text] = None
        if name not in self._orders:
            first, own = (self._keys(g) for g in (self.grids[0], grid))
            self._orders[name] = None
            if all(len(a) == len(b) for a, b in zip(first, own)):
                order = []
                for a, b in zip(first, own):
                    of_first, of_own = np.lexsort(a.T), np.lexsort(b.T)
                    order.append(np.empty_like(of_own))
                    order[-1][of_first] = of_own
                self._orders[name] = order
        return self._orders[name]

    def _keys(self, grid):
        """What tells nodes and cells of a mesh apart whatever their order: [node][4], places and, for nodes that lie on each other,
        the cells around them; [cell][1]."""
        x = self.array(grid.find("Geometry").find("DataItem"))
        spread = x @ np.sqrt([1.0, 2.0, 3.0])
        topology = grid.find("Topology")
        cells = self._sorted(self.array(topology.find("DataItem")), topology.get("TopologyType"))
        around, count = np.zeros((2, len(x)))
        of_cell = np.zeros((1 + max(index.max() for _, _, index in cells), 1))
        for _, nodes, index in cells:
            centre = spread[nodes].mean(axis=1)
            np.add.at(of_cell[:, 0], index, centre)
            for corner in nodes.T:
                np.add.at(around, corner, centre)
                np.add.at(count, corner, 1)
        return np.column_stack([around / np.maximum(count, 1), x[:, ::-1]]), of_cell

    def cells(self, grid):
        """Triples (type, connectivity [cell][node], indices of these cells among all), without cells that have left."""
        topology = self.grids[0 if self._order(grid) is not None else self.grids.index(grid)].find("Topology")
        item, kind = topology.find("DataItem"), topology.get("TopologyType")
        if item.text not in self._cells:  # most times share their mesh
            self._cells[item.text] = self._sorted(self.array(item), kind)
        eroded = self.field(grid, "eroded")
        if eroded is None or not eroded[0].any():
            return self._cells[item.text]
        return [(kind, nodes[there], index[there]) for kind, nodes, index in self._cells[item.text]
                for there in [eroded[0][index, 0] < 0.5]]

    @staticmethod
    def _sorted(data, kind):
        def linear(kind, nodes, index):
            kind, parts = PARTS.get(kind, (kind, [range(nodes.shape[1])]))
            return kind, np.concatenate([nodes[:, corners] for corners in parts]), np.tile(index, len(parts))

        if kind in TYPES:
            nodes = data.reshape(-1, NODES[TYPES[kind]])
            return [linear(TYPES[kind], nodes, np.arange(len(nodes)))]
        if kind != "Mixed":
            stop(f"cells of type {kind} are not supported")
        lists, at, cell = {}, 0, 0
        data = data.tolist()
        while at < len(data):
            size = NODES.get(data[at])
            if size is None:
                stop(f"cells of XDMF type {data[at]} are not supported")
            lists.setdefault(data[at], ([], []))[0].append(data[at + 1:at + 1 + size])
            lists[data[at]][1].append(cell)
            at, cell = at + 1 + size, cell + 1
        return [linear(kind, np.array(nodes), np.array(index)) for kind, (nodes, index) in lists.items()]


def solid(cells):
    return any(kind in FACES for kind, _, _ in cells)


def triangles(polygons):
    """Triangles of plane cells [triangle][3] and the cell of each."""
    parts = [(nodes[:, corners], index) for nodes, index in polygons
             for corners in ([(0, 1, 2)] if nodes.shape[1] == 3 else [(0, 1, 2), (0, 2, 3)])]
    return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])


def surface(cells):
    """Faces that belong to one cell only, as (nodes, cells) by number of nodes."""
    faces = {}
    for kind, connectivity, index in cells:
        for face in FACES.get(kind, ()):
            faces.setdefault(len(face), []).append((connectivity[:, face], index))
    polygons = []
    for parts in faces.values():
        nodes, index = np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
        _, first, count = np.unique(np.sort(nodes, axis=1), axis=0, return_index=True, return_counts=True)
        outer = first[count == 1]
        polygons.append((nodes[outer], index[outer]))
    return polygons


class Cut:
    """Where a plane cuts solid cells.

    `x` [vertex][3] are the vertices of the cut, `triangles` [triangle][3] name them, `cell` [triangle] is the cell that each
    lies in; `lines` [line][2] are the sides of the cells in the plane. `at_vertices` carries nodal values over: linearly along
    the edges of tetrahedra, six of which make a hexahedron, so that what is linear in space is exact.
    """

    def __init__(self, x, cells, point, normal):
        normal = np.asarray(normal, float)
        distance = (x - np.asarray(point, float)) @ (normal / np.linalg.norm(normal))
        distance[np.abs(distance) < 1e-12 * np.ptp(x, axis=0).max()] = 0
        nodes, owner = (np.concatenate(part) for part in zip(*(
            (connectivity[:, corners], index) for kind, connectivity, index in cells for corners in TETRAHEDRA.get(kind, ()))))
        for side in (1, -1):  # cells in front of a plane that is the back of the body
            edges, self.cell = self._cut(nodes, owner, side * distance)
            if len(edges):
                break
        # An edge that ends in the plane is its end.
        low, high = np.sort(edges, axis=-1).reshape(-1, 2).T
        low, high = np.where(distance[high] == 0, high, low), np.where(distance[low] == 0, low, high)
        key, name = np.unique(low * len(x) + high, return_inverse=True)
        self._low, self._high = key // max(len(x), 1), key % max(len(x), 1)
        step = distance[self._low] - distance[self._high]
        self._weight = np.divide(distance[self._low], step, out=np.zeros(len(key)), where=step != 0)
        self.x, self.triangles = self.at_vertices(x), name.reshape(-1, 3)
        a, b, c = np.swapaxes(self.x[self.triangles], 0, 1) if len(key) else np.zeros((3, 0, 3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        kept = area > 1e-14 * area.max(initial=0)
        self.triangles, self.cell, self.area = self.triangles[kept], self.cell[kept], area[kept] / 2
        # Sides that two triangles of one cell share lie inside of it.
        sides = np.sort(self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        rows, count = np.unique(np.column_stack([np.repeat(self.cell, 3), sides]), axis=0, return_counts=True)
        self.lines = np.unique(rows[count == 1, 1:], axis=0)

    @staticmethod
    def _cut(nodes, owner, distance):
        """Edges [triangle][3][2] that hold the corners, and the cells."""
        front = distance[nodes] > 0
        order = np.take_along_axis(nodes, np.argsort(~front, axis=1, kind="stable"), axis=1)
        count, edges, cells = front.sum(axis=1), [np.zeros((0, 3, 2), int)], [np.zeros(0, int)]
        for ahead, corners in ((1, ((0, 1), (0, 2), (0, 3))), (3, ((0, 3), (1, 3), (2, 3))),
                               (2, ((0, 2), (0, 3), (1, 3))), (2, ((0, 2), (1, 3), (1, 2)))):
            edges.append(order[count == ahead][:, corners])
            cells.append(owner[count == ahead])
        return np.concatenate(edges), np.concatenate(cells)

    def at_vertices(self, values):
        """Values [vertex] or [vertex][component] of nodal ones."""
        weight = self._weight.reshape(-1, *[1] * (values.ndim - 1))
        return (1 - weight) * values[self._low] + weight * values[self._high]
