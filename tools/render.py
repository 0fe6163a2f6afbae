#!/usr/bin/env python3
"""Draw a field of an .xdmf file on the deformed mesh: one picture per time and one with all of them.

    render.py vis.xdmf --field phi --times 0.1,0.2 --out pictures/crack [--deform 1] [--zoom auto]

Writes pictures/crack_000.png ... and pictures/crack_panel.png. Solids show their surface seen from --view.
"""
import argparse
import os
import sys
import xml.etree.ElementTree as ElementTree

import h5py
import numpy as np

NODES = {4: 3, 5: 4, 6: 4, 9: 8}  # by XDMF cell type
TYPES = {"Triangle": 4, "Quadrilateral": 5, "Tetrahedron": 6, "Hexahedron": 9}
FACES = {6: [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
         9: [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]}


def stop(message):
    print(f"render.py: {message}", file=sys.stderr)
    sys.exit(2)


class Fields:
    """The grids of an .xdmf file; arrays are read from its .h5 when they are asked for."""

    def __init__(self, path):
        self.dir = os.path.dirname(os.path.abspath(path))
        try:
            root = ElementTree.parse(path).getroot()
        except (OSError, ElementTree.ParseError) as error:
            stop(f"cannot read {path}: {error}")
        self.grids = [g for g in root.iter("Grid") if g.get("GridType") == "Uniform" and g.find("Time") is not None]
        if not self.grids:
            stop(f"{path} holds no times")
        self.times = np.array([float(g.find("Time").get("Value")) for g in self.grids])

    def array(self, item):
        name, _, dataset = item.text.strip().partition(":")
        try:
            with h5py.File(os.path.join(self.dir, name), "r") as file:
                return file[dataset][()]
        except (OSError, KeyError) as error:
            stop(f"cannot read {dataset} of {name}: {error}")

    def names(self, grid):
        return [a.get("Name") for a in grid.iter("Attribute")]

    def field(self, grid, name):
        """Values [entity][component] and whether they live on nodes; None when the grid lacks the field."""
        for attribute in grid.iter("Attribute"):
            if attribute.get("Name") == name:
                values = self.array(attribute.find("DataItem"))
                return values.reshape(len(values), -1), attribute.get("Center") == "Node"
        return None

    def cells(self, grid):
        """Pairs (type, connectivity [cell][node], indices of these cells among all)."""
        topology = grid.find("Topology")
        data, kind = self.array(topology.find("DataItem")), topology.get("TopologyType")
        if kind in TYPES:
            return [(TYPES[kind], data.reshape(-1, NODES[TYPES[kind]]), np.arange(len(data)))]
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
        return [(kind, np.array(nodes), np.array(index)) for kind, (nodes, index) in lists.items()]


def surface(cells):
    """Faces that belong to one cell only, as (nodes, cells) by number of nodes."""
    seen = {}
    for kind, connectivity, index in cells:
        for face in FACES[kind]:
            for nodes, cell in zip(connectivity[:, face], index):
                seen.setdefault(tuple(sorted(nodes)), []).append((nodes, cell))
    polygons = {}
    for faces in seen.values():
        if len(faces) == 1:
            polygons.setdefault(len(faces[0][0]), []).append(faces[0])
    return [(np.array([f[0] for f in group]), np.array([f[1] for f in group])) for group in polygons.values()]


def view_axes(view, upward):
    """Two unit vectors of the picture plane and the one towards the eye, from azimuth and elevation in degrees about the
    axis x, y or z that stands upright."""
    a, e = np.radians(view)
    right = np.array([-np.sin(a), np.cos(a), 0])
    eye = np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
    turns = {"z": 0, "x": 1, "y": 2}[upward]
    return tuple(np.roll(axis, turns) for axis in (right, np.cross(eye, right), eye))


class Picture:
    """What is drawn at one time: polygons in the plane, the value of each node or cell, and the time."""

    def __init__(self, fields, k, options):
        grid = fields.grids[k]
        self.time = fields.times[k]
        found = fields.field(grid, options.field)
        if found is None:
            stop(f"no field {options.field} at time {self.time:g}; there are: {', '.join(fields.names(grid))}")
        values, self.on_nodes = found
        self.values = reduced(values, options)
        x = fields.array(grid.find("Geometry").find("DataItem"))
        if options.deform != 0:
            u = fields.field(grid, "u")
            if u is None:
                stop("no field u to deform the mesh with; write it, or ask for --deform 0")
            x = x + options.deform * u[0][:, :3]
        cells = fields.cells(grid)
        solid = any(kind in FACES for kind, _, _ in cells)
        self.polygons = surface(cells) if solid else [(c, index) for _, c, index in cells]
        self.depth = None
        if solid:
            right, up, eye = view_axes(options.view, options.up)
            self.depth, x = x @ eye, np.stack([x @ right, x @ up], axis=1)
        self.x = x[:, :2]

    def box_of(self, level):
        """Corners of the region where the value is at least `level`, or None."""
        inside = np.zeros(len(self.x), bool)
        for nodes, index in self.polygons:
            high = self.values[nodes].max(axis=1) if self.on_nodes else self.values[index]
            inside[nodes[high >= level].ravel()] = True
        return (self.x[inside].min(axis=0), self.x[inside].max(axis=0)) if inside.any() else None


def reduced(values, options):
    """One number per entity: the asked component, the only one, or the length of a vector."""
    if options.component is not None:
        if not 0 <= options.component < values.shape[1]:
            stop(f"field {options.field} has components 0 to {values.shape[1] - 1}")
        return values[:, options.component]
    if values.shape[1] == 1:
        return values[:, 0]
    if values.shape[1] == 3:
        return np.linalg.norm(values, axis=1)
    return stop(f"field {options.field} has {values.shape[1]} components; choose one with --component")


def choose_times(fields, text):
    """Indices of the written times nearest to the asked ones; without a wish, six spread over all."""
    if not text:
        return sorted(set(np.linspace(0, len(fields.times) - 1, 6).round().astype(int)))
    if text == "all":
        return list(range(len(fields.times)))
    try:
        return [int(np.argmin(np.abs(fields.times - float(t)))) for t in text.split(",")]
    except ValueError:
        return stop(f"--times {text}: give numbers separated by commas, or all")


def window(pictures, zoom, high):
    """Limits of the picture: all of the mesh, where the field is large, or as given."""
    low_corner = np.min([p.x.min(axis=0) for p in pictures], axis=0)
    high_corner = np.max([p.x.max(axis=0) for p in pictures], axis=0)
    margin = 0.03 * (high_corner - low_corner).max()
    whole = (low_corner - margin, high_corner + margin)
    if zoom is None:
        return whole
    if zoom != "auto":
        try:
            x0, x1, y0, y1 = (float(v) for v in zoom.split(","))
        except ValueError:
            stop(f"--zoom {zoom}: give x0,x1,y0,y1 or auto")
        return np.array([x0, y0]), np.array([x1, y1])
    boxes = [b for b in (p.box_of(0.5 * high) for p in pictures) if b is not None]
    if high <= 0 or not boxes:
        return whole
    a, b = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
    half = np.maximum(0.65 * (b - a), 0.4 * (b - a).max() + 0.04 * (high_corner - low_corner).max())
    return np.maximum((a + b) / 2 - half, whole[0]), np.minimum((a + b) / 2 + half, whole[1])


def draw(axis, picture, norm, cmap, limits, edges):
    from matplotlib.collections import PolyCollection
    from matplotlib.tri import Triangulation
    # Edges fade as cells get small in the picture, and vanish where they would only darken it.
    count = sum(len(index) for _, index in picture.polygons)
    share = np.prod(limits[1] - limits[0]) / max(np.prod(np.ptp(picture.x, axis=0)), 1e-300)
    width = np.clip(14 / np.sqrt(max(count * min(share, 1.0), 1)), 0, 0.5) if edges else 0
    line = {"linewidths": width if width > 0.06 else 0, "edgecolors": (0.25, 0.25, 0.25, 0.55)}
    smooth = picture.on_nodes and picture.depth is None
    if smooth:
        triangles = np.concatenate([c for nodes, _ in picture.polygons
                                    for c in ([nodes] if nodes.shape[1] == 3 else [nodes[:, [0, 1, 2]], nodes[:, [0, 2, 3]]])])
        # Narrow bands interpolate the values; gouraud shading would interpolate the colours and leave the colour map.
        values = np.nan_to_num(picture.values, nan=norm.vmin)
        axis.tricontourf(Triangulation(picture.x[:, 0], picture.x[:, 1], triangles), values,
                         levels=np.linspace(norm.vmin, norm.vmax, 129), norm=norm, cmap=cmap, extend="both")
    polygons = picture.polygons
    if picture.depth is not None and len(polygons) > 1:
        # What is nearer hides what is farther, whatever its shape: triangles repeat their last corner.
        polygons = [(np.concatenate([np.hstack([nodes, nodes[:, [-1] * (4 - nodes.shape[1])]]) for nodes, _ in polygons]),
                     np.concatenate([index for _, index in polygons]))]
    for nodes, index in polygons:
        if smooth:
            if line["linewidths"]:
                axis.add_collection(PolyCollection(picture.x[nodes], facecolors="none", **line))
            continue
        values = picture.values[nodes].mean(axis=1) if picture.on_nodes else picture.values[index]
        order = np.arange(len(nodes)) if picture.depth is None else np.argsort(picture.depth[nodes].mean(axis=1))
        faces = PolyCollection(picture.x[nodes[order]], array=values[order], norm=norm, cmap=cmap, rasterized=True,
                               linewidths=line["linewidths"], edgecolors=line["edgecolors"] if line["linewidths"] else "face")
        axis.add_collection(faces)
    axis.set_xlim(limits[0][0], limits[1][0])
    axis.set_ylim(limits[0][1], limits[1][1])
    axis.set_aspect("equal")
    axis.set_title(f"t = {picture.time:.4g}", fontsize=9)


def save(figure, path):
    try:
        figure.savefig(path, dpi=200, bbox_inches="tight")
    except OSError as error:
        stop(f"cannot write {path}: {error}")
    print(path)


def draw_all(pictures, options, norm, limits):
    import matplotlib.pyplot as plt
    from matplotlib.cm import ScalarMappable
    colours = ScalarMappable(norm, options.cmap)
    label = options.label or options.field + ("" if options.component is None else f" [{options.component}]")
    size = limits[1] - limits[0]
    aspect = float(np.clip(size[1] / size[0], 0.15, 3))
    for number, picture in enumerate(pictures):
        figure, axis = plt.subplots(figsize=(6.3, 5.2 * aspect + 0.7), layout="constrained")
        draw(axis, picture, norm, options.cmap, limits, options.edges)
        axis.tick_params(labelsize=8)
        figure.colorbar(colours, ax=axis, label=label, pad=0.02, aspect=25)
        save(figure, f"{options.out}_{number:03d}.png")
        plt.close(figure)
    columns = 1 if len(pictures) == 1 else 2 if len(pictures) <= 4 or aspect < 0.4 else 3
    rows = -(-len(pictures) // columns)
    width = 6.4 / columns
    figure, axes = plt.subplots(rows, columns, figsize=(7.2, rows * (width * aspect + 0.3)), squeeze=False,
                                layout="constrained")
    for axis, picture in zip(axes.flat, pictures):
        draw(axis, picture, norm, options.cmap, limits, options.edges)
        axis.set_xticks([])
        axis.set_yticks([])
    for axis in axes.flat[len(pictures):]:
        axis.set_axis_off()
    figure.colorbar(colours, ax=axes, label=label, pad=0.02, aspect=25)
    save(figure, f"{options.out}_panel.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xdmf")
    parser.add_argument("--field", required=True)
    parser.add_argument("--times", help="comma list (the nearest written ones are taken) or all; default: six")
    parser.add_argument("--out", required=True, help="beginning of the file names")
    parser.add_argument("--deform", type=float, default=1, help="factor on the displacement u (default 1)")
    parser.add_argument("--zoom", help="auto (where the field is large) or x0,x1,y0,y1")
    parser.add_argument("--component", type=int, help="component of a vector or tensor (default: length of a vector)")
    parser.add_argument("--range", type=float, nargs=2, metavar=("LOW", "HIGH"), help="of the colours")
    parser.add_argument("--cmap", help="name of a matplotlib colour map")
    parser.add_argument("--label", help="text at the colour bar (default: the field's name)")
    parser.add_argument("--view", type=float, nargs=2, default=(-60, 25), metavar=("AZIMUTH", "ELEVATION"),
                        help="degrees, for solids (default -60 25)")
    parser.add_argument("--up", choices="xyz", default="z", help="axis that stands upright, for solids (default z)")
    parser.add_argument("--no-edges", dest="edges", action="store_false", help="leave the mesh lines out")
    options = parser.parse_args()

    import matplotlib
    matplotlib.use("Agg")
    from matplotlib.colors import Normalize
    fields = Fields(options.xdmf)
    pictures = [Picture(fields, k, options) for k in choose_times(fields, options.times)]
    finite = np.concatenate([p.values[np.isfinite(p.values)] for p in pictures])
    if finite.size == 0:
        stop(f"field {options.field} has no finite value")
    low, high = options.range or ((0.0, 1.0) if options.field == "phi" else (finite.min(), finite.max()))
    if high <= low:
        high = low + (abs(low) or 1.0) * 1e-9
    options.cmap = options.cmap or ("magma_r" if options.field == "phi" else "viridis")
    if options.cmap not in matplotlib.colormaps:
        stop(f"--cmap {options.cmap}: no such colour map")
    try:
        os.makedirs(os.path.dirname(options.out) or ".", exist_ok=True)
    except OSError as error:
        stop(f"cannot make the directory of {options.out}: {error}")
    draw_all(pictures, options, Normalize(low, high), window(pictures, options.zoom, finite.max()))


if __name__ == "__main__":
    main()
