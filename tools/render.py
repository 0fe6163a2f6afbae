#!/usr/bin/env python3
"""Draw a field of .xdmf files on the deformed mesh: one picture per time and one with all of them, or an animation.

    tools/render.py run/vis.xdmf --field phi --out run/phi
    tools/render.py run/vis.xdmf --field von_mises --times 0.1,0.2 --zoom auto --out run/stress
    tools/render.py run/vis.xdmf --field phi --animate run/phi.gif
    tools/render.py block/vis.xdmf --field stress --component yy --cut 0 0 0.5  0 0 1 --times 1 --out block/middle
    tools/render.py coarse/vis.xdmf fine/vis.xdmf --field phi --times 0.2 --out both

Writes run/phi_000.png ... and run/phi_panel.png; of several runs only the panel, a column for each. Solids show their
surface seen from --view, or with --cut what lies in a plane.
"""
import argparse
import os
import shutil

import numpy as np
from fields import COMPONENTS, Cut, Fields, solid, stop, surface, triangles


def view_axes(view, upward):
    """Two unit vectors of the picture plane and the one towards the eye, from azimuth and elevation in degrees about the
    axis x, y or z that stands upright."""
    a, e = np.radians(view)
    right = np.array([-np.sin(a), np.cos(a), 0])
    eye = np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
    turns = {"z": 0, "x": 1, "y": 2}[upward]
    return tuple(np.roll(axis, turns) for axis in (right, np.cross(eye, right), eye))


def plane_axes(normal, upward):
    """Two unit vectors in the plane of a cut and their names, along the axes of space where the plane lies along them."""
    normal = normal / np.linalg.norm(normal)
    axes = np.eye(3)
    if (flat := int(np.argmax(np.abs(normal)))) >= 0 and abs(normal[flat]) > 1 - 1e-9:
        first, second = (k for k in range(3) if k != flat)
        return axes[first], axes[second], "xyz"[first], "xyz"[second]
    up = axes["xyz".index(upward)]
    if abs(normal @ up) > 0.99:
        up = axes[("xyz".index(upward) + 1) % 3]
    up = up - (up @ normal) * normal
    up /= np.linalg.norm(up)
    return np.cross(up, normal), up, "across in the plane", "up in the plane"


class Picture:
    """What is drawn of one run at one time: polygons in the plane, the value of each node or cell, and the time.

    `x` [node][2]; `polygons` pairs (nodes [polygon][corner], cells [polygon]); `depth` [node] where nearer ones hide others;
    `lines` [line][2] the sides of cells where polygons are finer than these."""

    def __init__(self, fields, k, options):
        grid = fields.grids[k]
        self.time, self.unit = fields.times[k], fields.unit
        found = fields.field(grid, options.field)
        if found is None:
            stop(f"no field {options.field} in {fields.path} at time {self.time:g}; there are: {', '.join(fields.names(grid))}")
        values, self.on_nodes = found
        self.values = reduced(values, options)
        x = fields.places(grid)
        u = fields.field(grid, "u")
        if u is not None:
            x = x + (1 if options.deform is None else options.deform) * u[0][:, :3]
        elif options.deform:
            stop(f"no field u in {fields.path} to deform the mesh with; write it, or leave --deform away")
        cells = fields.cells(grid)
        self.depth = self.lines = self.axes = None
        self.names = ("x", "y")
        if options.cut and not solid(cells):
            stop(f"--cut: {fields.path} is plane; leave --cut away")
        if options.cut:
            self.cut(x, cells, options)
        elif solid(cells):
            right, up, eye = self.axes = view_axes(options.view, options.up)
            self.polygons, self.depth = surface(cells), x @ eye
            self.x = np.stack([x @ right, x @ up], axis=1)
            self.names = ("in the plane of the picture", "")
        else:
            self.polygons, self.x = [(c, index) for _, c, index in cells], x[:, :2]

    def cut(self, x, cells, options):
        point, normal = np.array(options.cut[:3]), np.array(options.cut[3:])
        if not np.any(normal):
            stop("--cut: the normal is zero; give a point and a direction, x y z nx ny nz")
        across = Cut(x, cells, point, normal)
        if not len(across.triangles):
            low, high = x.min(axis=0), x.max(axis=0)
            stop("--cut: the plane meets no cell; the bodies lie between "
                 + " and ".join("(" + ", ".join(f"{v:.4g}" for v in corner) + ")" for corner in (low, high)))
        first, second, *self.names = plane_axes(normal, options.up)
        self.x = np.stack([across.x @ first, across.x @ second], axis=1)
        self.polygons, self.lines = [(across.triangles, across.cell)], across.lines
        if self.on_nodes:
            self.values = across.at_vertices(self.values)

    def shown(self):
        """The finite values that the picture shows."""
        values = np.concatenate([self.values[nodes if self.on_nodes else index].ravel() for nodes, index in self.polygons])
        return values[np.isfinite(values)]

    def box_of(self, level):
        """Corners of the region where the value is at least `level`, or None."""
        inside = np.zeros(len(self.x), bool)
        for nodes, index in self.polygons:
            high = self.values[nodes].max(axis=1) if self.on_nodes else self.values[index]
            inside[nodes[high >= level].ravel()] = True
        return (self.x[inside].min(axis=0), self.x[inside].max(axis=0)) if inside.any() else None


def component_index(options, count):
    """Number of the component that is asked for by number or name."""
    names = COMPONENTS.get(count, ())
    text = options.component
    if text in names:
        return names.index(text)
    if text.isdigit() and int(text) < count:
        return int(text)
    return stop(f"--component {text}: field {options.field} has {', '.join(names) or 'one component'} (0 to {count - 1})")


def reduced(values, options):
    """One number per entity: the asked component, the only one, or the length of a vector. Notes what it is for the label."""
    count = values.shape[1]
    if options.component is not None:
        k = component_index(options, count)
        options.name = options.field if count == 1 else f"{options.field} {COMPONENTS.get(count, range(count))[k]}"
        return values[:, k]
    if count == 1:
        options.name = options.field
        return values[:, 0]
    if count == 3:
        options.name = f"|{options.field}|"
        return np.linalg.norm(values, axis=1)
    return stop(f"field {options.field} has the components {', '.join(COMPONENTS.get(count, ()))}; choose one with --component")


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
    used = [p.x[np.unique(np.concatenate([nodes.ravel() for nodes, _ in p.polygons]))] for p in pictures]
    low_corner, high_corner = np.min([x.min(axis=0) for x in used], axis=0), np.max([x.max(axis=0) for x in used], axis=0)
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


def draw(axis, picture, norm, limits, options, title=""):
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.tri import Triangulation
    inches = axis.get_window_extent().width / axis.figure.dpi / (limits[1] - limits[0])[0]
    shade = (0.25, 0.25, 0.25, 0.55)

    def widths(nodes):
        """Of the lines of each cell: they fade as it gets small in the picture, where they would only darken it."""
        if not options.edges:
            return 0
        x, y = picture.x[nodes].transpose(2, 0, 1)
        area = 0.5 * np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1))
        width = np.clip(6 * inches * np.sqrt(area), 0, 0.5)
        return np.where(width > 0.15, width, 0)

    smooth = picture.on_nodes and picture.depth is None
    if smooth:
        # Narrow bands interpolate the values; gouraud shading would interpolate the colours and leave the colour map.
        values = np.nan_to_num(picture.values, nan=norm.vmin)
        axis.tricontourf(Triangulation(*picture.x.T, triangles(picture.polygons)[0]), values,
                         levels=np.linspace(norm.vmin, norm.vmax, 129), norm=norm, cmap=options.cmap, extend="both")
    polygons = picture.polygons
    if picture.depth is not None and len(polygons) > 1:
        # What is nearer hides what is farther, whatever its shape: triangles repeat their last corner.
        polygons = [(np.concatenate([np.hstack([nodes, nodes[:, [-1] * (4 - nodes.shape[1])]]) for nodes, _ in polygons]),
                     np.concatenate([index for _, index in polygons]))]
    for nodes, index in polygons:
        if smooth:
            if picture.lines is None:
                axis.add_collection(PolyCollection(picture.x[nodes], facecolors="none", linewidths=widths(nodes), edgecolors=shade))
            continue
        values = picture.values[nodes].mean(axis=1) if picture.on_nodes else picture.values[index]
        order = np.arange(len(nodes)) if picture.depth is None else np.argsort(picture.depth[nodes].mean(axis=1))
        # Thin sides in the colour of the face hide the seams between faces.
        colours = ScalarMappable(norm, options.cmap).to_rgba(values[order])
        line = np.broadcast_to(widths(nodes[order]) if picture.lines is None else 0, len(order))
        sides = np.where(line[:, None] > 0, [shade], colours)
        axis.add_collection(PolyCollection(picture.x[nodes[order]], facecolors=colours, edgecolors=sides, rasterized=True,
                                           linewidths=np.where(line > 0, line, 0.2)))
    if picture.lines is not None:
        ends = picture.x[picture.lines]
        width = np.clip(6 * inches * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 0, 0.5) if options.edges else 0
        axis.add_collection(LineCollection(ends, linewidths=np.where(width > 0.15, width, 0) if options.edges else 0, colors=[shade]))
    axis.set_xlim(limits[0][0], limits[1][0])
    axis.set_ylim(limits[0][1], limits[1][1])
    axis.set_aspect("equal")
    axis.tick_params(labelsize=7)
    axis.ticklabel_format(scilimits=(-3, 4), useMathText=True)
    for offset in (axis.xaxis.offsetText, axis.yaxis.offsetText):
        offset.set_fontsize(7)
    length = picture.unit("length")
    for label, name in ((axis.set_xlabel, picture.names[0]), (axis.set_ylabel, picture.names[1])):
        label(name + length if name else "", fontsize=8)
    axis.set_title(title, fontsize=9)
    if picture.axes:
        draw_triad(axis, picture, limits)


def draw_triad(axis, picture, limits):
    """The directions of x, y and z beside a solid, in the corner that is farthest from it."""
    from matplotlib.transforms import ScaledTranslation
    corners = np.array([[x, y] for x in (0, 1) for y in (0, 1)])
    places = (picture.x - limits[0]) / (limits[1] - limits[0])
    corner = max(corners, key=lambda c: np.linalg.norm(places - (0.1 + 0.8 * c), axis=1).min())
    inwards = ScaledTranslation(*(30 / 72 * (1 - 2 * corner)), axis.figure.dpi_scale_trans)
    where = {"xy": corner, "xycoords": axis.transAxes + inwards, "textcoords": "offset points", "color": "0.3"}
    for k, name in enumerate("xyz"):
        tip = np.array([picture.axes[0][k], picture.axes[1][k]])
        axis.annotate("", **where, xytext=16 * tip, arrowprops={"arrowstyle": "<-", "lw": 0.7, "color": "0.3", "shrinkA": 0, "shrinkB": 0})
        axis.annotate(name, **where, xytext=22 * tip, fontsize=7, ha="center", va="center")


def save(figure, path):
    try:
        figure.savefig(path, dpi=200, bbox_inches="tight")
    except OSError as error:
        stop(f"cannot write {path}: {error}")
    print(path)


def time_text(picture):
    unit = picture.unit("time").strip(" ()")
    return f"t = {picture.time:.4g}" + (f" {unit}" if unit else "")


class Sheet:
    """How all figures of a call look: colours, limits, names of the runs."""

    def __init__(self, runs, options):
        shown = np.concatenate([p.shown() for pictures in runs for p in pictures])
        if shown.size == 0:
            stop(f"field {options.field} has no finite value")
        low, high = options.range or ((0.0, 1.0) if options.field == "phi" else (shown.min(), shown.max()))
        if high <= low:
            high = low + (abs(low) or 1.0) * 1e-9
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize
        self.norm = Normalize(low, high)
        self.colours = ScalarMappable(self.norm, options.cmap)
        self.options = options
        self.limits = window([p for pictures in runs for p in pictures], options.zoom, shown.max())
        size = self.limits[1] - self.limits[0]
        self.aspect = float(np.clip(size[1] / size[0], 0.15, 3))
        self.label = options.label or options.name + runs[0][0].unit(options.field)

    def figure(self, columns, rows, width):
        """A figure and its axes [row][column], each `width` inches wide, with the colour bar beside them."""
        import matplotlib.pyplot as plt
        height = rows * (0.92 * width * self.aspect + 0.3) + 0.4
        figure, axes = plt.subplots(rows, columns, figsize=(columns * width + 1.1, max(height, 1.7)), squeeze=False, layout="constrained",
                                    sharex=True, sharey=True)
        bar = figure.colorbar(self.colours, ax=axes, pad=0.02, aspect=20, fraction=0.05)
        bar.set_label(self.label, fontsize=8)
        bar.ax.tick_params(labelsize=7)
        bar.formatter.set_useMathText(True)
        bar.ax.yaxis.offsetText.set_fontsize(7)
        return figure, axes

    def draw(self, axis, picture, title=""):
        draw(axis, picture, self.norm, self.limits, self.options, title)


def draw_all(runs, names, options):
    """The pictures of one run and the panel of all."""
    import matplotlib.pyplot as plt
    sheet = Sheet(runs, options)
    if len(runs) == 1:
        for number, picture in enumerate(runs[0]):
            figure, axes = sheet.figure(1, 1, 5.4)
            sheet.draw(axes[0][0], picture, time_text(picture))
            save(figure, f"{options.out}_{number:03d}.png")
            plt.close(figure)
    # Times of one run fill rows; several runs have a column each, at a single time as many as fit beside each other.
    flat = [(p, time_text(p) if len(runs) == 1 else f"{name}, {time_text(p)}")
            for together in zip(*runs) for p, name in zip(together, names)]
    columns = len(runs) if len(runs) > 1 and len(runs[0]) > 1 else \
        1 if len(flat) == 1 else 2 if len(flat) <= 4 or sheet.aspect < 0.4 else 3
    figure, axes = sheet.figure(columns, -(-len(flat) // columns), max(6.4 / columns, 2.2))
    for axis, (picture, title) in zip(axes.flat, flat):
        sheet.draw(axis, picture, title)
        axis.label_outer()
    for axis in axes.flat[len(flat):]:
        axis.set_axis_off()
    for axis in axes.flat[max(len(flat) - columns, 0):len(flat)]:  # the lowest of each column
        axis.xaxis.set_tick_params(labelbottom=True)
        axis.set_xlabel(runs[0][0].names[0] + runs[0][0].unit("length"), fontsize=8)
    save(figure, f"{options.out}_panel.png")


def animate(runs, names, options):
    """A frame for each time into a .gif (by Pillow), or an .mp4 by ffmpeg."""
    from matplotlib.animation import FFMpegWriter, PillowWriter
    film = options.animate
    sheet = Sheet(runs, options)
    columns = 1 if len(runs) == 1 else 2 if len(runs) <= 4 else 3
    figure, axes = sheet.figure(columns, -(-len(runs) // columns), 5.4 if len(runs) == 1 else 3.6)
    for axis in axes.flat[len(runs):]:
        axis.set_axis_off()
    # Frames of one even size, as films want them.
    width, height = (2 * np.ceil(figure.get_size_inches() * 120 / 2)).astype(int)
    figure.set_size_inches(width / 120, height / 120)
    writer = (PillowWriter if film.endswith(".gif") else FFMpegWriter)(fps=options.fps)
    try:
        with writer.saving(figure, film, dpi=120):
            for frame in zip(*runs):
                for axis, picture, name in zip(axes.flat, frame, names):
                    axis.clear()
                    sheet.draw(axis, picture, time_text(picture) if len(runs) == 1 else f"{name}, {time_text(picture)}")
                writer.grab_frame()
    except OSError as error:
        stop(f"cannot write {film}: {error}")
    print(film)


def check_film(path):
    if path.endswith(".mp4"):
        if not shutil.which("ffmpeg"):
            stop("--animate: .mp4 needs the program ffmpeg, which is not installed (apt-get install ffmpeg); .gif needs nothing more")
    elif not path.endswith(".gif"):
        stop(f"--animate {path}: a name that ends in .gif or .mp4")


def run_names(paths, titles):
    """What tells runs apart: the titles that are given, or the part of their paths that differs."""
    if titles:
        names = titles.split(",")
        if len(names) != len(paths):
            stop(f"--titles: {len(names)} for {len(paths)} files")
        return names
    folders = [os.path.basename(os.path.dirname(os.path.abspath(p))) for p in paths]
    return folders if len(set(folders)) == len(paths) else [os.path.splitext(p)[0] for p in paths]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xdmf", nargs="+", help="several: side by side, in the same colours")
    parser.add_argument("--field", required=True)
    parser.add_argument("--times", help="comma list (the nearest written ones are taken) or all; default: six, all of an animation")
    parser.add_argument("--out", help="beginning of the names of pictures")
    parser.add_argument("--animate", metavar="FILM", help="an animation in place of pictures: .gif, or .mp4 where ffmpeg is installed")
    parser.add_argument("--fps", type=float, default=8, help="times in a second of the animation (default %(default)g)")
    parser.add_argument("--deform", type=float, help="factor on the displacement u (default 1 where it is written)")
    parser.add_argument("--cut", type=float, nargs=6, metavar=("X", "Y", "Z", "NX", "NY", "NZ"),
                        help="of solids: what lies in the plane through a point with a normal, in deformed bodies")
    parser.add_argument("--zoom", help="auto (where the field is large) or x0,x1,y0,y1")
    parser.add_argument("--component", help="of a vector or tensor: x, yy or a number (default: length of a vector)")
    parser.add_argument("--range", type=float, nargs=2, metavar=("LOW", "HIGH"), help="of the colours")
    parser.add_argument("--cmap", help="name of a matplotlib colour map")
    parser.add_argument("--label", help="text at the colour bar (default: the field's name and unit)")
    parser.add_argument("--titles", help="of several runs, a comma list (default: their folders)")
    parser.add_argument("--view", type=float, nargs=2, default=(-60, 25), metavar=("AZIMUTH", "ELEVATION"),
                        help="degrees, for solids (default -60 25)")
    parser.add_argument("--up", choices="xyz", default="z", help="axis that stands upright, for solids (default z)")
    parser.add_argument("--no-edges", dest="edges", action="store_false", help="leave the mesh lines out")
    options = parser.parse_args()
    if not options.out and not options.animate:
        parser.error("give --out for pictures or --animate for a film")

    import matplotlib
    matplotlib.use("Agg")
    options.cmap = options.cmap or ("magma_r" if options.field == "phi" else "viridis")
    if options.cmap not in matplotlib.colormaps:
        stop(f"--cmap {options.cmap}: no such colour map")
    options.cmap = matplotlib.colormaps[options.cmap].with_extremes(bad="0.85")  # a gap where nothing is near
    if options.animate:
        check_film(options.animate)
    names = run_names(options.xdmf, options.titles)
    files = [Fields(path) for path in options.xdmf]
    if len({f.system for f in files}) > 1:
        stop("the runs are in different systems of units; their colours would not compare")
    times = files[0].times[choose_times(files[0], "all" if options.animate and not options.times else options.times)]
    runs = [[Picture(f, int(np.argmin(np.abs(f.times - t))), options) for t in times] for f in files]
    target = options.animate or options.out
    try:
        os.makedirs(os.path.dirname(target) or ".", exist_ok=True)
    except OSError as error:
        stop(f"cannot make the directory of {target}: {error}")
    (animate if options.animate else draw_all)(runs, names, options)


if __name__ == "__main__":
    main()
