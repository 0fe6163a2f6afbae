# labels: run
# timeout: 240
# long: 200
"""Every column that a run writes is described by one row of `impact -reference`, with its unit, and every row by a run; field
files hold what options/README.md says, in its shapes and order."""
import os
import re
import subprocess

import h5py
import numpy
import _runs as runs

PAGE = subprocess.run([runs.PROGRAM, "-reference"], stdout=subprocess.PIPE, text=True, env=runs.ENVIRONMENT).stdout


def rows(section):
    body = PAGE.split(f"### {section}\n")[1].split("\n###")[0]
    return [[cell.strip().strip("`") for cell in line.strip("|").split(" | ")]
            for line in body.splitlines() if line.startswith("| `")]


FIELDS = {row[0]: row for row in rows("Fields")}
COLUMNS = rows("Columns of the history")


def pattern(name):
    name = re.sub(r"<axis>", "[xyz]", name)
    name = name.replace("<field>", "(?:" + "|".join(rf"{f}(?:_?[xyz]+)?" for f in FIELDS) + ")")
    return re.compile(re.sub(r"<\w+>", r"\\w+", name))


PATTERNS = [(pattern(row[0]), row) for row in COLUMNS]
seen = set()


def check_header(run, plane=True, units=True):
    header = open(os.path.join(run.dir, "history.csv")).readline().strip()
    wrong = []
    for head in header.split(","):
        name, _, unit = head.partition(" ")
        row = next((row for expression, row in PATTERNS if expression.fullmatch(name)), None)
        if row is None:
            wrong.append(f"{name} in no row")
            continue
        seen.add(row[0])
        said = row[1].replace("m or m^2", "m" if plane else "m^2")
        if row[0].endswith("<field>"):
            field = max((f for f in FIELDS if re.search(rf"_{f}(_?[xyz]+)?$", name)), key=len)
            said = FIELDS[field][3]
        if units and unit.strip("[]") != said:
            wrong.append(f"{head} instead of [{said}]")
    runs.require(f"{run.dir}: every column stands in the table, with its unit {wrong}", not wrong)
    return header


def block(**more):
    return {"mesh": runs.mesh("block.geo"), "ts_type": "static", "materials": "solid", "material_solid_E": 1000,
            "material_solid_nu": 0.25, "ts_dt": 0.5, "ts_max_time": 1, **more}


FAILURE = {"material_lower_jc_failure": "on", "material_lower_jc_d1": 0.1}
# Everything at once: two blocks that flow, break, heat, rub and are prescribed, in motion.
HEAT = {"material_lower_c_v": 1e4, "material_lower_theta0": 300, "material_upper_c_v": 1e4, "material_upper_theta0": 300,
        "contact_face_conductance": 10}
rich = runs.run("rich", {
    **runs.BREAKING_BLOCKS, **HEAT, "contact_face_friction": 0.3, "material_lower_b_d": 1, "material_lower_c": 1, **FAILURE,
    "bcs": "hold,warm", "bc_warm_on": "upper_top", "bc_warm_type": "temperature", "bc_warm_value": 310,
    "probes": "p", "probe_p_at": "0.5,0.4", "probe_p_fields": ",".join(f for f in FIELDS if f not in ("fatigue", "eroded") and "contact" not in f),
    "measures": "m", "measure_m_on": "upper_bottom", "measure_m_fields": ",".join(f for f in FIELDS if "contact" in f),
    "output_vis_fields": ",".join(f for f in FIELDS if f not in ("fatigue", "eroded")), "history_materials": "on",
    "coupling_error": "on", "ts_max_time": 0.03, "output_vis_every": 5}, refused=None, takes_back=True)
check_header(rich)
# A body that turns as told; a cell that tires.
turned = runs.run("turned", {
    "mesh": runs.mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 1, "materials": "box", "material_box_region": "solid",
    "material_box_model": "rigid", "material_box_rho": 1000, "bcs": "turn", "bc_turn_on": "solid", "bc_turn_rz": "t",
    "ts_dt": 0.1, "ts_max_time": 0.2})
check_header(turned, plane=False)
check_header(runs.run("tired", block(
    mesh_set_n=1, material_solid_damage="at2", material_solid_Gc=1, material_solid_gamma=1, material_solid_fatigue_a=1e-3, bcs="hold",
    bc_hold_on="solid", bc_hold_ux="0.01*t*x", bc_hold_uy=0, probes="p", probe_p_at="0.5,0.5", probe_p_fields="fatigue")))
# Cells that leave with their mass.
check_header(runs.run("worn", block(
    mesh_set_n=1, ts_type="central_difference", material_solid_rho=1, material_solid_erosion="on", material_solid_erosion_stretch=1.5,
    material_solid_erosion_mass="remove",
    bcs="hold", bc_hold_on="solid", bc_hold_ux="t*x", bc_hold_uy=0, probes="p", probe_p_at="0.5,0.5", probe_p_fields="eroded")))
# A crack that finds its load, a ring around it.
check_header(runs.run("followed", block(
    mesh_set_n=4, material_solid_damage="at2", material_solid_split="volumetric", material_solid_Gc=1, material_solid_gamma=1, bcs="hold,pull",
    bc_hold_on="left", bc_hold_ux=0, bc_hold_uy=0, bc_pull_on="right", bc_pull_ux="0.01*t", ts_path_dissipation=1, releases="ring",
    release_ring_at="0.5,0.5", release_ring_inner=0.1, release_ring_outer=0.4)))

# Cracks are told as they are: phi is prescribed everywhere, nothing moves.
CRACK = {"mesh": runs.mesh("block.geo"), "mesh_set_n": 20, "physics": "damage", "ts_type": "static", "materials": "solid",
         "material_solid_E": 1, "material_solid_nu": 0, "material_solid_damage": "at2", "material_solid_Gc": 1,
         "material_solid_gamma": 0.1, "bcs": "crack", "bc_crack_on": "solid", "bc_crack_type": "damage", "ts_dt": 0.25, "ts_max_time": 1}
TIP, OTHER = "crack_solid_tip_", "crack_solid_2_tip_"


def cracked(name, phi, **more):
    """The same cracks on 1 and 3 ranks, in the long form on 2, too."""
    all_of = [runs.run(f"{name}_{n}", {**CRACK, "bc_crack_value": phi, **more}, ranks=n) for n in ((1, 2, 3) if runs.long() else (1, 3))]
    columns = [c for c in all_of[0].history if c.startswith("crack_") and "measure" not in c]
    runs.require(f"{name}: {len(all_of)} numbers of ranks tell the same, to the last bit",
                 all(numpy.array_equal(all_of[0][c], r[c], equal_nan=True) for r in all_of[1:] for c in columns))
    return all_of[0]


# Damaged most at the tip of a slit that ends in the middle, then through to the other side at once.
run = cracked("runs", "(abs(y-0.5)<0.01 ? (t<0.6 ? 0.8*exp(-abs(x-0.5)) : (x>0.49 ? 0.95+0.05*x : 0.8)) : 0)")
runs.require("before there is no crack, and it has no tip", run["crack_solid_count"][0] == 0 and numpy.isnan(run[TIP + "x"][0]))
runs.check("it began at the tip of the slit", run["crack_solid_origin_x"][-1], 0.5, 1e-12)
runs.check("its tip is at the other side", run[TIP + "x"][-1], 1, 1e-12)
run = cracked("there", "(abs(y-0.5)<0.01 ? 1 : 0)")
runs.check("there at once from side to side: it ends at the other one", run[TIP + "x"][0], 1, 1e-12)
# Two that grow towards each other and pass; both bend into one at the end.
TWO = ("(abs(y-0.25)<0.01 && x<0.31+0.4*t ? 1 : abs(y-0.75)<0.01 && x>0.79-0.4*t ? 1 : t>0.9 && abs(x-0.5)<0.01 && "
       "y>0.24 && y<0.76 ? 1 : 0)")
run = cracked("two", TWO, crack_tips=2)
check_header(run)
runs.require("two cracks, then one", list(run["crack_solid_count"]) == [2, 2, 2, 2, 1])
for k, x in enumerate((0.3, 0.4, 0.5, 0.6)):
    runs.check(f"tip of the first, t = {k / 4}", run[TIP + "x"][k], x, 1e-12)
    runs.check("of the second", run[OTHER + "x"][k], 0.8 - 0.1 * k, 1e-11)
# Gamma is 0.1: after 0.5 s it has gone 0.2.
runs.check("speed of the first, on the first stretch", run["crack_solid_speed"][1], 0, 1e-12, relative=False)
for k, speed in ((2, 0.4), (3, 0.4)):
    runs.check(f"speed of the first, t = {k / 4}", run["crack_solid_speed"][k], speed, 1e-11)
runs.check("speed of the second", run["crack_solid_2_speed"][2], 0.4, 1e-11)
runs.require("each on its own height", abs(run[TIP + "y"][:4] - 0.25).max() < 1e-12 and abs(run[OTHER + "y"][:4] - 0.75).max() < 1e-12)
runs.require("after they have met the older one has the tip", numpy.isnan(run[OTHER + "x"][4]) and run[TIP + "y"][4] > 0.7)
for end in (0.5, 1):
    runs.run("resumed", {**CRACK, "bc_crack_value": TWO, "crack_tips": 2, "ts_max_time": end, "restart": "auto" if end == 1 else "none"},
             ranks=2 if end == 1 else 1)
runs.require("resumed on two ranks: the same cracks", all(numpy.array_equal(runs.read_history("resumed/history.csv")[c], run[c], equal_nan=True)
                                                          for c in run.history if c.startswith("crack_") and "measure" not in c))
check_header(runs.run("sprung", block(bcs="base", bc_base_on="bottom", bc_base_type="foundation", bc_base_stiffness=1, bc_base_stiffness_tangential=1,
                                      bc_base_damping=1)))
check_header(runs.run("scaled", block(ts_type="central_difference", ts_dt="auto", ts_max_time=1e-3, ts_mass_scaling_dt=1e-3,
                                      ts_mass_scaling_limit=1e3, material_solid_rho=1000)))
runs.require(f"every row of the table is written by some run {[r[0] for r in COLUMNS if r[0] not in seen]}", seen == {row[0] for row in COLUMNS})

def text(dataset):
    return dataset[()].tobytes().decode()


# Field files by the words of options/README.md alone: a body strained evenly, all components of the stress different.
EPS = 1e-6 * numpy.array([[1, 6, 5], [6, 2, 4], [5, 4, 3]])
runs.run("strained", block(mesh_set_dim=3, mesh_set_n=2, bcs="hold", bc_hold_on="solid", outputs="vis", output_vis_times=1, **{
    f"bc_hold_u{a}": "+".join(f"{EPS[i][j]:.17g}*{b}" for j, b in enumerate("xyz")) for i, a in enumerate("xyz")}))
with h5py.File("strained/vis.fields/mesh_0.h5") as grid, h5py.File("strained/vis.fields/000001.h5") as file:
    x, cells, region = grid["geometry"][()], grid["topology"][()], grid["region"][()]
    runs.require("nodes, cells and regions in their shapes", x.shape == (27, 3) and cells.shape == (8, 8) and region.shape == (8,)
                 and text(grid["cells"]) == "Hexahedron" and text(file["mesh"]) == text(grid["checksum"]) and file["time"][0] == 1)
    runs.check("u [node][3]", abs(file["node/u"][()] - x @ EPS).max(), 0, 1e-18, relative=False)
    stress = 1000 * 0.25 / 1.25 / 0.5 * EPS.trace() * numpy.eye(3) + 1000 / 1.25 * EPS
    runs.check("stress [cell][6] is xx yy zz xy yz xz", abs(file["cell/stress"][()] - stress[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]).max()
               / abs(stress).max(), 0, 1e-4, relative=False)
    runs.require("cells of half a metre: their nodes are theirs", abs(numpy.ptp(x[cells], axis=1) - 0.5).max() < 1e-9)
for name, ranks in (("rich", 1), ("rich_2", 2)):
    if ranks == 2:
        runs.run(name, {**runs.BREAKING_BLOCKS, "ts_max_time": 0.004}, ranks=2)
    with h5py.File(f"{name}/vis.fields/mesh_0.h5") as grid:
        names = {int(line.split()[0]): line.split()[1:] for line in text(grid["regions"]).splitlines()}
        of_cell = [names[number][0] for number in grid["region"][()]]
        y = grid["geometry"][()][grid["topology"][()]].mean(axis=1)[:, 1]
    runs.require(f"region of each cell, {ranks} ranks", names == {1: ["lower", "lower"], 2: ["upper", "upper"]}
                 and (numpy.array(of_cell) == numpy.where(y < 1, "lower", "upper")).all() and len(set(of_cell)) == 2)

# The heads of the terminal, in any order of words: a head that none describes would be left over.
line = next(line for line in rich.log.splitlines() if line.lstrip().startswith("step "))
runs.require("the head of the terminal is its table", line.split() == " ".join(row[0] for row in rows("Columns of the terminal")).split())

# In another system of units the numbers change with the words; numpy's own reader takes the header.
mm = check_header(runs.run("mm", block(units="mm_t_s_MPa", bcs="hold,pull", bc_hold_on="bottom", bc_hold_type="fix", bc_pull_on="top",
                                       bc_pull_uy=0.01)), units=False)
runs.require("units of the run's system", "reaction_pull_y [N]" in mm and "energy_elastic [mJ]" in mm and "mean_pull_uy [mm]" in mm)
runs.require("a ratio has none", ",balance," in mm)
table = numpy.genfromtxt("mm/history.csv", delimiter=",", names=True)
runs.require("numpy reads it by name", table["reaction_pull_y_N"][-1] == runs.read_history("mm/history.csv")["reaction_pull_y"][-1])

# A run goes on in a file whose header has no units, from before there were any.
text = open("mm/history.csv").read()
with open("mm/history.csv", "w") as file:
    file.write(re.sub(r" \[[^]]*\]", "", text.split("\n")[0]) + "\n" + text.split("\n", 1)[1])
runs.run("mm", block(units="mm_t_s_MPa", bcs="hold,pull", bc_hold_on="bottom", bc_hold_type="fix", bc_pull_on="top", bc_pull_uy=0.01,
                     ts_max_time=1.5, restart="auto"))
runs.check("rows after going on with an old header", len(runs.read_history("mm/history.csv")["time"]), 4, 0)
runs.finish()
