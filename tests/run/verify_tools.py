# labels: run
# timeout: 120
# long: 200
"""The tools: what render.py draws of runs with and without u, of cuts through solids, of several runs and as an animation;
compare_histories.py on balances; --help of each tool, with an example that runs where it is quick."""
import csv
import importlib.machinery
import os
import re
import shlex
import shutil
import subprocess
import sys
import warnings

import matplotlib
import numpy
from PIL import Image

from _runs import BREAKING_BLOCKS, PROGRAM, SOURCE, check, check_between, finish, long, mesh, require, run

sys.path.insert(0, os.path.join(SOURCE, "tools"))
import render  # noqa: E402
from fields import Cut, Fields  # noqa: E402

matplotlib.use("Agg")
BLOCKS = {**BREAKING_BLOCKS, "output_vis_every": 5, "ts_max_time": 0.03,
          **{f"material_{body}_{key}": value for body in ("lower", "upper")
             for key, value in {"c_v": 1e6, "conductivity": 50}.items()}}
run("run", BLOCKS)
run("coarse", {**BLOCKS, "mesh_set_n_lower": 3, "ts_max_time": 0.02})
# A restart on other ranks writes nodes and cells in another order, which no tool may see.
run("parts", {**BLOCKS, "ts_max_time": 0.02, "checkpoint_every": 100})
parts = run("parts", {**BLOCKS, "restart": "auto", "checkpoint_every": 100}, ranks=2)
whole, parts = Fields("run/vis.xdmf"), Fields("parts/vis.xdmf")
meshes = {grid.find("Geometry").find("DataItem").text for grid in parts.grids}
require(f"the restarted run has two meshes (is {len(meshes)}) and all times", len(meshes) == 2 and set(whole.times) <= set(parts.times))
common = [grid for grid, time in zip(parts.grids, parts.times) if time in whole.times]
for name in ("theta", "u", "phi", "region", "von_mises"):
    values = [[fields.field(grid, name)[0] for grid in grids] for fields, grids in ((whole, whole.grids), (parts, common))]
    check(f"restarted on two ranks: {name} in the order of the first mesh",
          max(abs(a - b).max() for a, b in zip(*values)) / max(numpy.ptp(a) for a in values[0]), 0, 1e-6, relative=False)
require("and the places", numpy.array_equal(whole.places(whole.grids[-1]), parts.places(parts.grids[-1])))
run("bare", {**BLOCKS, "output_vis_fields": "phi", "ts_max_time": 0.01})
SIDES = "left,right,bottom,top,back,front"
STRETCH = numpy.array([[0.02, 0.01, 0], [0.03, -0.01, 0.02], [0, 0.01, 0.015]])
for name, simplex in (("block", 0), ("tetrahedra", 1)):
    run(name, {"mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 4, "mesh_set_simplex": simplex, "materials": "solid",
               "units": "mm_t_s_MPa", "material_solid_E": 1000, "material_solid_nu": 0.3, "bcs": "whole", "bc_whole_on": SIDES,
               "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, "outputs": "vis", "output_vis_times": 1,
               **{f"bc_whole_u{axis}": "({}*x+{}*y+{}*z)*t".format(*row) for axis, row in zip("xyz", STRETCH.tolist())}})


def tool(*words):
    return subprocess.run([sys.executable, os.path.join(SOURCE, "tools", words[0]), *words[1:]], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)


figures = {}


def save(figure, path, keep=render.save):
    figures[path] = figure
    keep(figure, path)


render.save = save


def draw(words):
    """render.py in this process, where a warning is an error: exit status."""
    figures.clear()
    sys.argv = ["render.py", *shlex.split(words)]
    with warnings.catch_warnings():
        for kind in (RuntimeWarning, UserWarning):
            warnings.simplefilter("error", kind)
        try:
            render.main()
        except SystemExit as end:
            return end.code
    return 0


def panels(path):
    """Axes of a figure that show something, without the colour bar."""
    return [axis for axis in figures[path].axes if axis.axison and axis.get_title()]


def inked(path):
    """Part of the pixels that are not grey or white: the field."""
    pixels = numpy.asarray(Image.open(path).convert("RGB"), dtype=int)
    return float((numpy.ptp(pixels, axis=2) > 30).mean())


# Without u bodies are drawn where they were; a factor that is asked for needs it.
bare = tool("render.py", "bare/vis.xdmf", "--field", "phi", "--out", "bare/phi", "--range", "0", "1e-3")
require(f"phi without u: status {bare.returncode}", bare.returncode == 0)
check_between("phi without u: part of the picture that is coloured", inked("bare/phi_panel.png"), 0.2, 0.8)
asked = tool("render.py", "bare/vis.xdmf", "--field", "phi", "--out", "bare/phi", "--deform", "2")
require(f"--deform without u: {asked.stdout.strip()}", asked.returncode == 2 and "no field u" in asked.stdout)

# Axes, units, one scale.
require("two times of a run", draw("run/vis.xdmf --field theta --times 0,0.03 --out run/theta") == 0)
both = panels("run/theta_panel.png")
require("a panel for each time, and pictures of their own", len(both) == 2 and set(figures) == {
    "run/theta_000.png", "run/theta_001.png", "run/theta_panel.png"})
require("titles, axes and colours have units", [a.get_title() for a in both] == ["t = 0 s", "t = 0.03 s"]
        and [a.get_xlabel() for a in both] == ["x (m)"] * 2 and both[0].get_ylabel() == "y (m)"
        and figures["run/theta_panel.png"].axes[-1].get_ylabel() == "theta (K)")
require("several runs", draw("run/vis.xdmf coarse/vis.xdmf --field von_mises --times 0.01,0.02 --out sides") == 0)
sides = panels("sides_panel.png")
require("several runs: one figure, a column for each", list(figures) == ["sides_panel.png"] and [a.get_title() for a in sides] == [
    f"{name}, t = {t} s" for t in ("0.01", "0.02") for name in ("run", "coarse")])
peak = max(Fields(f"{name}/vis.xdmf").field(g, "von_mises")[0].max() for name in ("run", "coarse")
           for f in [Fields(f"{name}/vis.xdmf")] for g, t in zip(f.grids, f.times) if t in (0.01, 0.02))
check("several runs: the colours reach the largest stress of all", figures["sides_panel.png"].axes[-1].get_ylim()[1], peak, 1e-12)
require("a field that is not there is refused by name", draw("run/vis.xdmf --field psi --out run/psi") == 2)

# Cuts: what is linear in space is exact, anything else within the interpolation of cells of 1/4, h^2/8 times the second derivative
# along an edge; the plane may lie between cells or in their sides.
for name, section in (("block", 0.5), ("tetrahedra", 0.37)):
    fields = Fields(f"{name}/vis.xdmf")
    grid = fields.grids[-1]
    x, cells, u = fields.places(grid), fields.cells(grid), fields.field(grid, "u")[0]
    for point, normal, area in (((0, 0, section), (0, 0, 1), 1), ((0.4, 0.5, 0.5), (1, 0, 0), 1),
                                ((0.5, 0.5, 0.5), (1, 1, 1), 0.75 * 3**0.5), ((1, 1, 1), (0, 0, 2), 1)):
        cut = Cut(x, cells, point, normal)
        where = f"{name}, cut at {point} across {normal}"
        check(f"{where}: area", cut.area.sum(), area, 1e-12)
        check(f"{where}: off the plane", abs((cut.x - point) @ normal).max() / numpy.linalg.norm(normal), 0, 1e-12, relative=False)
        check(f"{where}: u, to what the solver leaves", abs(cut.at_vertices(u) - cut.x @ STRETCH.T).max(), 0, 1e-10, relative=False)
        edge = max(numpy.linalg.norm(x[nodes].max(axis=1) - x[nodes].min(axis=1), axis=1).max() for _, nodes, _ in cells)
        wave = abs(cut.at_vertices(numpy.sin(3 * x[:, 0])) - numpy.sin(3 * cut.x[:, 0])).max()
        check_between(f"{where}: error of a sine", wave, 0, 9 / 8 * edge**2)
require("a cut is drawn", draw("block/vis.xdmf --field u --component y --cut 0 0 0.5 0 0 1 --deform 0 --times 1 --out block/cut") == 0)
(cut,) = panels("block/cut_panel.png")
check_between("the cut fills its picture", inked("block/cut_panel.png"), 0.5, 0.95)
low, high = figures["block/cut_panel.png"].axes[-1].get_ylim()
require(f"colours of the cut are those of the plane: {low:.6g} to {high:.6g}", abs(low - 0) < 1e-9 and abs(high - 0.04) < 1e-9)
require("its axes are those of space", (cut.get_xlabel(), cut.get_ylabel()) == ("x (mm)", "y (mm)"))
require("a plane that meets nothing is refused", draw("block/vis.xdmf --field u --cut 0 0 5 0 0 1 --out block/cut") == 2)
require("the surface of a solid", draw("tetrahedra/vis.xdmf --field von_mises --times 1 --out tetrahedra/surface") == 0)

# Animations.
require("a film", draw("run/vis.xdmf --field phi --animate run/phi.gif --fps 4 --range 0 0.01") == 0)
film = Image.open("run/phi.gif")
times = Fields("run/vis.xdmf").times
check("a film has a frame for each time", film.n_frames, len(times), 0)
frames = []
for k in range(film.n_frames):
    film.seek(k)
    frames.append(numpy.asarray(film.convert("RGB"), dtype=int))
check_between("first and last frame differ", abs(frames[0] - frames[-1]).mean(), 1, 255)
check("a film's pace, ms", film.info["duration"], 250, 0)
status = draw("run/vis.xdmf --field phi --animate run/phi.mp4")
require(f"an .mp4 where there is ffmpeg, else a word: status {status}", status == (0 if shutil.which("ffmpeg") else 2))
require("a film of another kind is refused", draw("run/vis.xdmf --field phi --animate run/phi.avi") == 2)


# Histories.
def changed(column, change):
    with open("run/history.csv") as file:
        rows = [line.rstrip("\n").split(",") for line in file]
    k = [head.partition(" [")[0] for head in rows[0]].index(column)
    for row in rows[1:]:
        row[k] = repr(change(float(row[k])))
    with open("changed.csv", "w") as file:
        file.writelines(",".join(row) + "\n" for row in rows)
    return tool("compare_histories.py", "run/history.csv", "changed.csv", "--quiet")


require("rounding of balance is none of a difference", changed("balance", lambda x: 3e-16 - x).returncode == 0)
require("a balance beyond it is", "balance: 1.0" in changed("balance", lambda x: x + 1e-9).stdout)
done = changed("energy_elastic", lambda x: x * (1 + 1e-9))
require(f"an energy is: {done.stdout.strip()[:60]}", done.returncode == 1 and done.stdout.startswith("energy_elastic:"))

# The table of solvers: PETSc's own counts, what fails as such, nothing twice.
BENCH = ["bench_solvers", "--program", PROGRAM, "--cases", "2d_incompressible,2d_mortar_semismooth", "--sizes", "300", "--limit", "30",
         "--candidates", "default,gamg,cg_icc", "--rtol", "none", "--out", "solvers.csv"]
first = tool(*BENCH)
with open("solvers.csv", newline="") as file:
    runs = {(row["case"], row["candidate"]): row for row in csv.DictReader(file)}
require(f"status {first.returncode}, {len(runs)} runs of {len(first.stdout.splitlines())} lines",
        first.returncode in (0, 1) and len(runs) == 6 and first.stdout.count("| 2d_") == 2)
require("the defaults end well", all(runs[case, "default"]["status"] == "ok" for case in ("2d_incompressible", "2d_mortar_semismooth")))
require("incomplete Cholesky factors of what keeps its volume do not", runs["2d_incompressible", "cg_icc"]["status"] == "exit 5")
bench = importlib.machinery.SourceFileLoader("bench_solvers", os.path.join(SOURCE, "tools", "bench_solvers")).load_module()
meshed, options = bench.options_of("2d_incompressible", "300")
asked = {**meshed, **options, **bench.CANDIDATES["gamg"], "motion_ksp_converged_reason": ""}
log = run("asked", bench.words(asked)).log
row = runs["2d_incompressible", "gamg"]
check("linear iterations, as PETSc tells them", float(row["linear"]), sum(map(int, re.findall(r"Linear motion_ .* iterations (\d+)", log))), 0)
check("Newton iterations, as PETSc tells them", float(row["newton"]), len(re.findall(r"Linear motion_ solve converged", log)), 0)
check_between("CPU time of a run, s", float(row["cpu_s"]), 0.02, 20)
before = open("solvers.csv").read()
again = tool(*BENCH)
require("a second call runs nothing and says the same", open("solvers.csv").read() == before and again.stdout == first.stdout)

# Help and examples, in a folder that looks like the top of the repository with runs in it.
os.symlink(os.path.join(SOURCE, "tools"), "tools")
for link, name in (("fine", "run"), ("one", "run"), ("other", "run")):
    os.symlink(name, link)
# These install, build, or want the runs of a file of options/; check_format is a test of its own.
LONG = {"demo", "test", "install_packages", "bench_peers", "bench_solvers", "same_histories.py", "measure_messages.py", "check_format", "beam_wedge_observables.py", "plot_hertz.py", "plot_fatigue.py"}
names = sorted(name for name in os.listdir("tools") if os.access(f"tools/{name}", os.X_OK) and os.path.isfile(f"tools/{name}"))
require(f"{len(names)} tools", len(names) >= 13)
ran = 0
for name in names:
    python = open(f"tools/{name}", encoding="utf-8").readline().strip().endswith("python3")
    runs = name not in LONG and (long() or not name.startswith("check_"))  # those are tests of their own
    if runs and not long():  # it starts below
        status, said = 0, open(f"tools/{name}", encoding="utf-8").read()
    else:
        asked = subprocess.run([*([sys.executable] if python else []), f"tools/{name}", "--help"], stdout=subprocess.PIPE, text=True)
        status, said = asked.returncode, asked.stdout
    examples = re.findall(rf"^    (tools/{re.escape(name)}.*)", said, re.M)
    require(f"{name} --help has an example", status == 0 and examples)
    for example in examples[: None if long() else 1] if runs else ():
        ran += 1
        words = shlex.split(example)
        code = draw(shlex.join(words[1:])) if name == "render.py" else subprocess.run(
            [sys.executable, *words], stdout=subprocess.DEVNULL, cwd=SOURCE if name.startswith("check_") else None).returncode
        require(f"status {code}: {example}", code == 0)
require(f"{ran} examples ran", ran >= (10 if long() else 5))
finish()
