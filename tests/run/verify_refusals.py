"""Inputs that cannot be meant are refused: each row is a command, its exit status and words of its message, on one rank and
on two. They ran to their end before, with status 0 and a wrong answer."""
# labels: run
# timeout: 120
# long: 200
import os
import subprocess

from _runs import ENVIRONMENT, PROGRAM, check, cores, finish, long, require, run


def write_mesh(name, left=0.0, inner=False):
    """A unit square of 2 x 2 quadrilaterals in triangles, its left side at `left`; `inner` labels its middle line."""
    nodes = [(left + 0.5 * i, 0.5 * j) for j in range(3) for i in range(3)]
    cells = [(3 * j + i + 1, 3 * j + i + 2, 3 * j + i + 5, 3 * j + i + 4) for j in range(2) for i in range(2)]
    lines = {"bottom": [(1, 2), (2, 3)], "right": [(3, 6), (6, 9)], "top": [(9, 8), (8, 7)], "left": [(7, 4), (4, 1)]}
    if inner:
        lines["mid"] = [(4, 5), (5, 6)]
    groups = ["solid"] + list(lines)
    elements = [f"2 2 1 1 {t[0]} {t[1]} {t[2]}" for a, b, c, d in cells for t in ((a, b, c), (a, c, d))]
    for number, line in enumerate(lines.values(), 2):
        elements += [f"1 2 {number} {number} {a} {b}" for a, b in line]
    with open(name, "w") as file:
        file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n" % len(groups))
        file.writelines(f'{2 if g == "solid" else 1} {k} "{g}"\n' for k, g in enumerate(groups, 1))
        file.write("$EndPhysicalNames\n$Nodes\n%d\n" % len(nodes))
        file.writelines(f"{k} {x} {y} 0\n" for k, (x, y) in enumerate(nodes, 1))
        file.write("$EndNodes\n$Elements\n%d\n" % len(elements))
        file.writelines(f"{k} {e}\n" for k, e in enumerate(elements, 1))
        file.write("$EndElements\n")
    return name


def write_cells(name, nodes, cells):
    """Cells of 3 or 4 corners, numbers from 1, in the group `solid`; the first line of nodes is `bottom`."""
    with open(name, "w") as file:
        file.write('$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 "solid"\n1 2 "bottom"\n$EndPhysicalNames\n')
        file.write(f"$Nodes\n{len(nodes)}\n" + "".join(f"{k} {x} {y} 0\n" for k, (x, y) in enumerate(nodes, 1)) + "$EndNodes\n")
        file.write(f"$Elements\n{len(cells) + 1}\n1 1 2 2 1 1 2\n")
        file.writelines(f"{k} {len(c) - 1} 2 1 1 {' '.join(map(str, c))}\n" for k, c in enumerate(cells, 2))
        file.write("$EndElements\n")
    return name


def write_wedge(name, n=6, notch=False, space=False):
    """A triangle with a sharp tip, or, upside down, a notch in a block; `left` and `right` share the tip. `space`: a layer of it."""
    tip = "1, 0.5, 0" if notch else "1, 1, 0"
    corners = ["0, 0, 0", "2, 0, 0"] + (["2, 1, 0", "1.05, 1, 0", tip, "0.95, 1, 0", "0, 1, 0"] if notch else [tip])
    count, right = len(corners), 4 if notch else 2
    text = "".join(f"Point({k}) = {{{x}, {1 / n}}};\n" for k, x in enumerate(corners, 1))
    text += "".join(f"Line({k}) = {{{k}, {k % count + 1}}};\n" for k in range(1, count + 1))
    text += f"Curve Loop(1) = {{1:{count}}}; Plane Surface(1) = {{1}};\n"
    if space:
        text += "o[] = Extrude{0, 0, 0.3}{ Surface{1}; Layers{1}; };\n"
        names = {"solid": "Volume", **dict.fromkeys(("bottom", "right", "left", "rs", "ls"), "Surface")}
    else:
        names = {"solid": "Surface", **dict.fromkeys(("bottom", "right", "left", "rs", "ls"), "Curve")}
    number = {"solid": 1, "bottom": 1, "right": right, "left": right + 1, "rs": 2, "ls": 7}
    for group, kind in names.items():
        if notch or group not in ("rs", "ls"):
            place = f"o[{number[group] + 1}]" if space and group != "solid" else number[group]
            text += f'Physical {kind}("{group}") = {{{place}}};\n'
    return write(name.replace(".msh", ".geo"), text)


def write(name, text, encoding="utf-8"):
    with open(name, "w", encoding=encoding) as file:
        file.write(text)
    return name


def without(options, *beginnings):
    return {key: value for key, value in options.items() if not key.startswith(beginnings)}


def more(options, **changes):
    return {**options, **changes}


SQUARE = write_mesh("square.msh")
CASES = write("cases.geo", "DefineConstant[ h = 1, H = 2 ];\n")
GEO = write("square.geo", 'DefineConstant[ n = {2, Name "cells"}, kind = "plain" ];\nm = n; // mesh_set_m has no effect\n'
            "Point(1) = {0, 0, 0};\nExtrude{1, 0, 0}{ Point{1}; Layers{m}; }\nExtrude{0, 1, 0}{ Line{1}; Layers{m}; }\n"
            'Physical Surface("solid") = {5}; Physical Curve("bottom") = {1}; Physical Curve("top") = {2};\n')
write("loop.opts", f"-mesh {SQUARE}\n-options_file other.opts\n")
write("other.opts", "-options_file loop.opts\n")
write("marked.opts", f"-mesh {SQUARE}\n", "utf-8-sig")

PULL = {
    "mesh": SQUARE, "materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3, "material_solid_rho": 1000,
    "bcs": "hold,push", "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_push_on": "top", "bc_push_uy": "0.1*t",
    "ts_type": "static", "ts_dt": 0.1, "ts_max_time": 1,
}
INNER = {**PULL, "mesh": write_mesh("inner.msh", inner=True)}
CRACK = {**PULL, "material_solid_damage": "at2", "material_solid_Gc": 200, "material_solid_gamma": 0.5}
HEAT = {**without(PULL, "bc_"), "material_solid_c_v": 1000, "material_solid_conductivity": 10, "physics": "heat", "bcs": "air",
        "bc_air_on": "left", "bc_air_type": "convection", "bc_air_value": 300, "bc_air_h": 10}


def start_words(options):
    return [word for key, value in options.items() for word in ("-" + key, str(value))]


# claim, options, exit status, words of the message
ROWS = [
    ("a pressure inside a body", more(without(INNER, "bc_push"), bcs="hold,p", bc_p_on="mid", bc_p_type="pressure", bc_p_value="1e3*t"), 3,
     ['-bc_p_on "mid": has a facet inside a body, near (', "allowed: facets on the outside"]),
    ("a contact surface inside a body", more(INNER, contacts="c", contact_c_secondary="mid", contact_c_primary="plane"), 3,
     ['contact c: boundary "mid": has a facet inside a body']),
    ("phi above 1 at the start", more(CRACK, ics="seed", ic_seed_on="solid", ic_seed_phi="2*x"), 3,
     ['-ic_seed_phi "2*x": 2 at x=(1,', "t=0; allowed: 0 <= value <= 1"]),
    ("a number of phi above 1", more(CRACK, ics="seed", ic_seed_on="solid", ic_seed_phi="2"), 2, ["out of range; allowed: 0 <= value <= 1"]),
    ("phi below 0 on a boundary", more(CRACK, bcs="hold,push,d", bc_d_on="left", bc_d_type="damage", bc_d_value="(-1)"), 3,
     ['-bc_d_value "(-1)": -1 at x=(0,', "t=0; allowed: 0 <= value <= 1"]),
    ("phi above 1 later", more(CRACK, bcs="hold,push,d", bc_d_on="left", bc_d_type="damage", bc_d_value="4*t"), 3,
     ['-bc_d_value "4*t": 1.2', "t=0.3", "allowed: 0 <= value <= 1"]),
    ("rings left of the axis", more(PULL, mesh=write_mesh("left.msh", left=-3.0), plane="axisymmetric"), 3,
     ['-plane "axisymmetric": x is the radius, and the mesh has a node at (-']),
    ("a word for a number of the mesh", more(PULL, mesh=GEO, mesh_set_n="abc"), 2, ['-mesh_set_n "abc"', "allowed: a number"]),
    ("a number for a word of the mesh", more(PULL, mesh=GEO, mesh_set_kind="3"), 2, ['-mesh_set_kind "3"', "allowed: a word"]),
    ("a constant that the mesh does not ask for", more(PULL, mesh=GEO, mesh_set_m="3"), 2, ['has no parameter "m"', "allowed: kind, n"]),
    ("constants that differ by case", more(PULL, mesh=CASES, mesh_set_h="3"), 2, ["declares h and H", "options know no case"]),
    ("a negative coefficient of convection", more(HEAT, bc_air_h="5-10*t"), 3, ['-bc_air_h "5-10*t": -', "allowed: >= 0"]),
    ("an absolute temperature below zero around", more(HEAT, bc_air_value="300-400*t"), 3, ['-bc_air_value "300-400*t": -', "allowed: > 0 K"]),
    ("two displacements that agree at the ends alone",
     more(PULL, bcs="hold,push,side", bc_side_on="right", bc_side_uy="0.1*t*y+t*(1-t)*(y > 0.9)"), 3,
     ["-bc_push and -bc_side prescribe different uy (0.0", "at t=0.1) on a common node at (1, 1)"]),
    ("two velocities that agree at the ends alone",
     more(PULL, bcs="hold,push,side", bc_push_type="velocity", bc_push_uy="0.1", bc_side_on="right", bc_side_type="velocity",
          bc_side_uy="y > 0.9 ? 0.2*t : 0"), 3, ["-bc_push and -bc_side prescribe different uy", "at t=0.1)"]),
    ("two motions of a rigid body that agree at the ends alone",
     more(without(PULL, "material_solid_E", "material_solid_nu", "bc_hold"), material_solid_model="rigid", ts_type="newmark",
          bcs="push,side", bc_side_on="left", bc_side_uy="0.1*t+t*(1-t)", bc_push_ux="0", bc_push_rz="0"), 3,
     ["-bc_push and -bc_side prescribe different uy (0.01", "of the rigid body"]),
    ("two motions of a rigid body that part for a tenth of the time",
     more(without(PULL, "material_solid_E", "material_solid_nu", "bc_hold"), material_solid_model="rigid", ts_type="newmark", ts_dt=0.07,
          bcs="push,side", bc_side_on="left", bc_side_uy="0.1*t+0.05*(t > 0.3 && t < 0.4)", bc_push_ux="0", bc_push_rz="0"), 3,
     ["-bc_push and -bc_side prescribe different uy (0.034999999999999996, 0.08499999999999999 at t=0.35", "of the rigid body"]),
    ("two temperatures that agree at the ends alone",
     more(without(HEAT, "bc_"), bcs="hot,warm", bc_hot_on="top", bc_hot_type="temperature", bc_hot_value="400", bc_warm_on="right",
          bc_warm_type="temperature", bc_warm_value="400+t*(1-t)"), 3,
     ["-bc_hot and -bc_warm prescribe different temperatures (400, 400.0", "on a common node at (1, 1)"]),
    ("two phi on a node", more(CRACK, bcs="hold,push,a,b", bc_a_on="left", bc_a_type="damage", bc_a_value="0.5", bc_b_on="top",
                               bc_b_type="damage", bc_b_value="0.6"), 3, ["-bc_a and -bc_b prescribe different phi (0.5, 0.6"]),
    *[(f"unknown: {name}", more(PULL, **{name: value}), 2, [f"unknown option -{name}; did you mean -{near}"])
      for name, value, near in (
          ("motion_ksp_typ", "gmres", "motion_ksp_type?"), ("motion_pc_typ", "lu", "motion_pc_type?"), ("ksp_type", "gmres", "motion_ksp_type?"),
          ("snes_max_it", 3, "motion_snes_max_it?"), ("ts_newmark_rh", 1, "ts_newmark_rho?"), ("ts_max", 3, "ts_max_reject, -ts_max_steps"),
          ("motion_mg_levels_ksp_typ", "cg", "motion_mg_levels_ksp_type?"), ("motion_ksp_monitor_true", "", "motion_ksp_monitor_true_residual?"),
          ("coupling_snes_rtol", 1e-3, "coupling_snes_atol?"), ("damage_ksp_typ", "cg", "damage_ksp_type?"))],
    *[(claim, {**without(PULL, "bc_push"), "bcs": "hold", "mesh": write_cells(f"cells{k}.msh", nodes, cells), "ts_type": "static"}, 3, [words])
      for k, (claim, nodes, cells, words) in enumerate((
          ("a bow-tie", [(0, 0), (1, 0), (0.2, 1), (1.2, 1)], [(1, 2, 3, 4)], "folded cell"),
          ("an arrow", [(0, 0), (1, 0), (0.35, 0.35), (0, 1)], [(1, 2, 3, 4)], "points inwards"),
          ("a collapsed quadrilateral", [(0, 0), (1, 0), (1, 0), (0, 1)], [(1, 2, 3, 4)], "collapsed cell: two of its nodes stand at (1, 0, 0)"),
          ("a hanging node", [(0, 0), (2, 0), (2, 1), (0, 1), (1, 1), (1, 2), (0, 2), (2, 2)], [(1, 2, 3, 4), (4, 5, 6, 7), (5, 3, 8, 6)],
           "hanging node at (1, 1, 0): it lies on the edge from (")))],
    ("a refinement too many", more(PULL, dm_refine=10, mesh_cells=1e6), 3, ["mesh of 8 cells, 8.389e+06 after 10 refinements", "-mesh_cells"]),
    ("a .geo without end", more(PULL, mesh=write("endless.geo", "For i In {0:1000000000}\n a = i;\nEndFor\n"), mesh_wall=1), 3,
     ["gmsh has worked for 1 s and is stopped", "-mesh_wall"]),
    ("a command in a word for the mesh", more(PULL, mesh=GEO, mesh_set_kind='x";SystemCall "ls'), 2, ["allowed: a number or one word"]),
    ("sub-steps without number", more(CRACK, damage_ts_dt=1e-10), 2, ["-damage_ts_dt: makes 1e+09 sub-steps in each step of -ts_dt; allowed: at most 1e+05 (-ts_substeps)"]),
    ("sub-steps beyond a bound of one's own", more(CRACK, damage_ts_dt=1e-3, ts_substeps=99), 2, ["makes 100 sub-steps", "at most 99"]),
    ("no steps", more(PULL, ts_max_steps=0), 2, ['-ts_max_steps "0": out of range; allowed: a whole number >= 1']),
    ("an overlap that one contact alone has", more(without(PULL, "bc_push"), mesh=write_wedge("wedge.msh"), bcs="hold", contacts="c", contact_c_secondary="left",
     contact_c_primary="plane", contact_c_plane_point="0,0.9", contact_c_plane_normal="0,-1", contact_c_initial="error"), 3, ["contact c: `left` overlaps `plane` by 0.1"]),
    ("other capitals of a unit", more(PULL, material_solid_E="200 Gpa"), 2, ["unknown unit 'Gpa'; did you mean GPa?"]),
    ("a sign for a blank", [*start_words(PULL), "-ts_dt=0.5"], 2, ["a blank parts name and value: -ts_dt 0.5"]),
    ("forces that are not finite", more(PULL, ts_type="newmark", bc_push_uy="1/(t-0.5)"), 3, ["the forces of which an acceleration is asked are not finite"]),
    *[(f"YAML: {words}", [*start_words(PULL), "-options_file", write(f"bad{k}.yml", text)], 2, [f"bad{k}.yml", words]) for k, (text, words) in enumerate((
        ("materials: solid\nts:\n  dt: [1, 2\n", "line 3: a bracket is missing"), ("title: x\n\tts_dt: 2\n", "line 2: a tab in front"),
        ("title: x\nts_dt 0.1\n", "line 2: no \"name: value\""), ("ts:\n  dt: 1\ntitle: x\nts_dt: 2\n", "-ts_dt: given twice in"),))],
    ("more options than PETSc keeps", ["-options_file", write("many.opts", "".join(f"-param_a{k} 1\n" for k in range(600)))], 2, ["no more than 512 options"]),
    ("a minus in a file", [*start_words(PULL), "-options_file", write("minus.opts", '-bc_push_ux "-t*10"\n')], 2, ["a value that begins with a minus needs brackets: (-t)"]),
    ("a file of options without its option", ["run.opts"], 2, ["`run.opts` on the command line belongs to no option", "-options_file"]),
    ("a word too many", [*start_words(PULL), "extra"], 2, ["`extra` on the command line belongs to no option"]),
    ("times of steps that begin late", more(PULL, ts_times="0.5,1", ts_dts="0.1"), 2, ['-ts_times "0.5,1": does not begin with 0']),
    ("an option of nobody", more(PULL, foo="1"), 2, ["unknown option -foo   (`impact -reference`"]),
    ("a misspelt solver before a dry run", more(PULL, motion_ksp_typ="cg", dry_run="on"), 2, ["unknown option -motion_ksp_typ"]),
    *[(f"without effect: {name}", more(PULL, **{name: value}), 2, [f"-{name}", words]) for name, value, words in (
        ("motion_snes_fd", "", "not available"), ("motion_snes_fd_color", "", "not available"),
        ("motion_snes_mf_operator", "", "not available"), ("motion_snes_convergence_test", "skip", "not available"),
        ("ts_rtol", 1e-3, "not available"), ("motion_ksp_type", "qcg", "take cg"),
        ("motion_mg_levels_ksp_type", "cg", "nothing in this run reads"), ("vec_tpye", "mpi", "nothing in this run reads"))],
    # Before a mesh is asked for: there is none.
    *[(f"no value of PETSc's: {name} {value}", more(PULL, motion_ksp_type="gmres", mesh=write("never.geo", 'Error("read"); Exit;\n'), **{name: value}), 2,
       [f'-{name} "{value}": {words}']) for name, value, words in (
          ("motion_ksp_rtol", "abc", "not a number; allowed: a number"), ("motion_ksp_rtol", "2", "out of range; allowed: 0 <= value < 1"),
          ("motion_ksp_rtol", "-1", "out of range"), ("motion_ksp_max_it", "-3", "out of range; allowed: a whole number >= 1"),
          ("motion_snes_max_it", "-3", "out of range; allowed: a whole number >= 1"), ("motion_snes_atol", "-1", "out of range; allowed: >= 0"),
          ("damage_snes_max_it", "0", "out of range"), ("damage_ksp_rtol", "1", "out of range"), ("heat_ksp_max_it", "-1", "out of range"),
          ("uzawa_snes_max_it", "-3", "out of range"), ("motion_snes_linesearch_damping", "0", "out of range; allowed: 0 < value <= 1"),
          ("motion_sub_ksp_rtol", "-1", "out of range"), ("motion_sub_pc_type", "luu", "not available; allowed: none, "), ("motion_snes_stol", "1e-3", "out of range"),
          ("motion_pc_type", "hypr", "not available; allowed: none, jacobi"), ("motion_snes_linesearch_type", "btt", "not available; allowed:"),
          ("motion_snes_type", "nasm", "cannot solve this problem; allowed: newtonls"), ("damage_snes_type", "newtonls", "cannot solve this problem; allowed: vi"),
          ("motion_pc_factor_mat_solver_type", "mumpss", "PETSc refuses it"), ("motion_mat_mumps_icntl_14", "abc", "PETSc refuses it"))],
    ("a preconditioner that wants another matrix", more(PULL, motion_ksp_type="gmres", motion_pc_type="bddc"), 2,
     ["PETSc cannot solve with -motion_ksp_type gmres -motion_pc_type bddc"]),
    ("beta beside rho", more(PULL, ts_type="newmark", ts_newmark_rho=0.5, ts_newmark_beta=0.3), 2, ["not together with -ts_newmark_beta"]),
    ("an options file that leads back to itself", ["-options_file", "loop.opts"], 2,
     ["leads back to itself: loop.opts, other.opts, loop.opts"]),
    ("an options file with a byte-order mark", ["-options_file", "marked.opts"], 2, ["begins with a byte-order mark"]),
    ("a displacement that turns cells inside out at t = 0", more(PULL, bc_push_uy="0.1*t-1.5"), 3, ["the state at t = 0 has no energy", "begin with 0"]),
]


EVERY = ROWS
if not long():  # one in three, of those that are alike one in six
    ALIKE = [row for row in ROWS if row[0].startswith(("unknown: ", "without effect: ", "no value of PETSc's: "))]
    ROWS = [row for row in ROWS if row not in ALIKE][::3] + ALIKE[::6]


def start(options, ranks):
    words = options if isinstance(options, list) else start_words(options)
    command = (["mpirun", "-n", str(ranks)] if ranks > 1 else []) + [PROGRAM] + words + ["-output_dir", "out"]
    with cores(ranks):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT)
    return done.returncode, [line for line in done.stdout.splitlines() if line.startswith("impact: ")]


for claim, options, status, words in ROWS:
    code, lines = start(options, 1)
    message = lines[-1] if lines else "nothing"
    require(f"{claim}: status {code}, {message[:200]}", code == status and all(word in message for word in words))
# What one rank alone may see ends the job on all of them with one line.
for claim, options, status, words in [row for row in EVERY if row[0] in (
        "a pressure inside a body", "phi above 1 later", "a negative coefficient of convection",
        "two displacements that agree at the ends alone")]:
    code, lines = start(options, 2)
    require(f"{claim}, two ranks: status {code}", code == status and any(all(w in line for w in words) for line in lines))

# What may be meant is told; with -options_strict it is refused.
USELESS = more(PULL, motion_pc_gamg_threshold=0.1)
code, lines = start(USELESS, 1)
require("what the solver does not read", code == 0 and any("nothing in this run reads -motion_pc_gamg_threshold" in line for line in lines))
require("the same, strictly", start(more(USELESS, options_strict="on"), 1)[0] == 2)
code, lines = start(more(PULL, damage_ksp_type="cg"), 1)
require("of a field that is not solved", code == 0 and any("does not solve these fields: -damage_ksp_type" in line for line in lines))
require("more sub-steps, where these are meant", start(more(CRACK, damage_ts_dt=1e-7, ts_substeps=2e6, dry_run="on"), 1)[0] == 0)
for claim, options, words in [
        ("a crack narrower than two cells", more(CRACK, material_solid_gamma=0.1), "-material_solid_gamma 0.1 is 0.2 times its narrowest cell 0.5"),
        ("a crack wider than its body", more(CRACK, material_solid_gamma=50), "-material_solid_gamma 50 is 50 times the size 1 of its body"),
        ("a time behind the end", more(PULL, outputs="v", output_v_times="0.1,5"), "-output_v_times 5 lies behind the end, -ts_max_time 1"),
        *[(f"behind the end: {key}", more(PULL, **{"outputs": "v", key: value, **extra}), f"-{key} {value} lies behind the end, -ts_max_time 1, about {steps} steps")
          for key, value, steps, extra in (("output_v_dt", 5, 10, {}), ("ts_dt", 3, 1, {}), ("ts_period", 8, 10, {}), ("checkpoint_every", 11, 10, {}),
                                           ("output_v_cycles", 3, 10, {"ts_period": 0.5}), ("output_v_every", 5, 4, {"ts_max_steps": 4}))],
        ("more steps than there are", more(PULL, outputs="v", output_v_every=1000), "-output_v_every 1000 lies behind the end"),
        ("more steps than a table has", more(without(PULL, "ts_dt"), outputs="v", output_v_every=31, ts_times="0,0.5,1", ts_dts="0.1,0.02"),
         "-output_v_every 31 lies behind the end, -ts_max_time 1, about 30 steps")]:
    code, lines = start(more(options, dry_run="on"), 1)
    require(claim, code == 0 and any("WARNING: " + words in line for line in lines))
ring = subprocess.run([PROGRAM, *start_words(PULL)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                      env={**ENVIRONMENT, "PETSC_OPTIONS": "-options_file loop.opts"})
require("a ring of options files in PETSC_OPTIONS", ring.returncode == 2 and "leads back to itself" in ring.stdout)
os.makedirs("broken")
write("broken/gmsh", "#!/bin/sh\necho 'Info    : Meshing 2D...'\nkill -SEGV $$\n")
os.chmod("broken/gmsh", 0o755)
crash = subprocess.run([PROGRAM, *start_words(more(PULL, mesh=GEO)), "-output_dir", "out"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                       env={**ENVIRONMENT, "PATH": "broken:" + os.environ["PATH"]})
require("a gmsh that fails itself", crash.returncode == 4 and "gmsh itself failed (Segmentation fault), after \"Info    : Meshing 2D...\"" in crash.stdout)
write("plain_file", "")
folder = subprocess.run([PROGRAM, *start_words(PULL), "-output_dir", "plain_file/x"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                        env=ENVIRONMENT)
require("an output folder that cannot be made", folder.returncode == 4 and '-output_dir "plain_file/x": cannot make' in folder.stdout)

# Sides that share nodes: around a sharp tip nothing strikes (it "overlapped" there), across a notch they meet.
for dim, space in ((2, False), (3, True)):
    CORNER = more(without(PULL, "bc_push"), contacts="c", contact_c_secondary="left", contact_c_primary="right", material_solid_nu=0, outputs="none")
    for method in ("auto", "gpts", "mortar") if long() else ("auto",):
        r = run(f"tip{dim}{method}", more(CORNER, mesh=write_wedge("tip.geo", space=space), bcs="hold", contact_c_method=method, ts_dt=1))
        said = [line for line in r.log.splitlines() if "adjoin" in line]
        require(f"around a tip, {dim}D, {method}: told once with nodes and remedy",
                len(said) == 1 and f"share {2 if space else 1} node" in said[0] and "(1, 1" in said[0] and "Give each its own nodes" in said[0])
        check(f"around a tip, {dim}D, {method}: force", abs(r["contact_c_force_x"][-1]), 0, 0, relative=False)
NOTCH = more(CORNER, mesh=write_wedge("notch.geo", n=12, notch=True), bcs="hold,push", bc_push_on="ls,rs", bc_push_ux="0.2*t*(1-x)*y", ts_dt=0.2)
for ranks in (1, 2) if long() else (2,):
    r = run(f"notch{ranks}", NOTCH, ranks=ranks)
    require(f"a notch closes, {ranks} ranks: {r['contact_c_active'][-1]:.0f} places press", r["contact_c_active"][-1] > 5)
    check(f"a notch closes, {ranks} ranks: overlap", min(r["contact_c_gap_min"][-1], 0), 0, 1e-4, relative=False)

# An overlap of one contact that its moves cannot undo is not a fault of the mesh.
write("tool.geo", "Point(1)={0,0,0};Point(2)={1,0,0};Point(3)={1,0.1,0};Point(4)={0,0.1,0};Line(1)={1,2};Line(2)={2,3};Line(3)={3,4};Line(4)={4,1};\n"
      "Curve Loop(1)={1:4};Plane Surface(1)={1};Point(5)={0.3,0.08,0};Point(6)={0.7,0.08,0};Point(7)={0.7,1,0};Point(8)={0.5,0.03,0};Line(5)={5,8};\n"
      "Line(6)={8,6};Line(7)={6,7};Line(8)={7,5};Curve Loop(2)={5:8};Plane Surface(2)={2};Mesh.MeshSizeMax=0.1;Mesh.MeshSizeMin=0.1;\n"
      'Physical Surface("plate")={1};Physical Surface("tool")={2};Physical Curve("top")={3};Physical Curve("bottom")={1};Physical Curve("foot")={5,6};\n')
TOOL = more(without(PULL, "bc_push"), mesh="tool.geo", material_solid_region="plate,tool", bcs="hold", contacts="c", contact_c_secondary="foot",
            contact_c_primary="top", contact_c_initial="adjust", contact_c_initial_tol=0.2)
for ranks in (1, 2) if long() else (1,):
    code, lines = start(TOOL, ranks)
    require(f"moves that a mesh has no room for, {ranks} ranks: status {code}, {lines[-1]}", code == 3 and sum(
        "-contact_c_initial adjust: moves 7 nodes of `foot` by up to 0.07215, more than" in line for line in lines) == 1)

# What is asked of the program itself is answered, and nothing else is done.
for words, code, said in (([], 2, "-options_file run.opts"), (["--help"], 0, "-reference"), (["-help"], 0, "-reference"),
                          ([*start_words(PULL), "-h"], 0, "-reference"), ([*start_words(PULL), "--version"], 0, "PETSc 3."),
                          ([*start_words(PULL), "-help"], 0, "-motion_snes_type <now")):
    done = subprocess.run([PROGRAM, *words[:-1], *(["-output_dir", "asked"] if words[1:] else []), *words[-1:]], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT)
    require(f"asked {words[-1:]}: status {done.returncode}", done.returncode == code and said in done.stdout and not os.path.exists("asked"))

# A byte-order mark before a table is none of its numbers.
pulled = [run(name, more(PULL, functions="f", function_f_table=write(name + ".csv", "0 0\n1 1\n", encoding), bc_push_uy="0.1*f(t)"))
          for name, encoding in (("plain", "utf-8"), ("marked", "utf-8-sig"))]
check("table with a byte-order mark: elastic energy at the end", pulled[1]["energy_elastic"][-1], pulled[0]["energy_elastic"][-1], 0.0)
# Paths in a file that another one names are beside it.
os.makedirs("deep")
os.replace(write_mesh("part.msh"), "deep/part.msh")
write("deep/part.opts", "-mesh part.msh\n")
write("whole.opts", "-options_file deep/part.opts\n")
check("mesh beside the file that names it: elastic energy at the end",
      run("deep_run", more(without(PULL, "mesh"), options_file="whole.opts"))["energy_elastic"][-1], pulled[0]["energy_elastic"][-1], 0.25)
require("dead loads and forces inside a body act", run("inside", more(
    without(INNER, "bc_push"), bcs="hold,p", bc_p_on="mid", bc_p_type="force", bc_p_uy="1e3*t")).code == 0)
check("their reaction", run("inside2", more(without(INNER, "bc_push"), bcs="hold,p", bc_p_on="mid", bc_p_type="force", bc_p_uy="1e3*t"), ranks=2)[
    "reaction_hold_y"][-1], -1000.0, 1e-8)
finish()
