# labels: run
# timeout: 60
"""The stable step of explicit steps on tetrahedra of many sizes: longer than that of the fastest cell alone, shorter than that of the
whole body, whose frequencies are found here; the body keeps its energy at it; mass scaling by it; on two ranks the same."""
import re
import subprocess

import numpy
from _runs import check, check_between, finish, mesh, require, run

E, NU, RHO = 1e6, 0.3, 1000.0
with open("ball.geo", "w", encoding="ascii") as file:
    file.write("""// A ball, fine at its foot.
Point(1) = {0, 0, 0}; Point(2) = {0, -1, 0, 0.07}; Point(3) = {1, 0, 0, 0.3}; Point(4) = {0, 1, 0, 0.3}; Point(5) = {0, 0, 1, 0.3};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2}; Circle(5) = {3, 1, 5};
Line(6) = {1, 2}; Line(7) = {1, 4}; Line(8) = {1, 3}; Line(9) = {1, 5};
Curve Loop(1) = {1, 5, 4}; Surface(1) = {1}; Curve Loop(2) = {2, 3, -5}; Surface(2) = {2};
Curve Loop(3) = {6, 1, -8}; Plane Surface(3) = {3}; Curve Loop(4) = {8, 2, -7}; Plane Surface(4) = {4};
Curve Loop(5) = {7, 3, -9}; Plane Surface(5) = {5}; Curve Loop(6) = {9, 4, -6}; Plane Surface(6) = {6};
Surface Loop(1) = {1 : 6}; Volume(1) = {1}; Physical Volume("ball") = {1};
""")
subprocess.run(["gmsh", "-v", "1", "-3", "-format", "msh22", "ball.geo", "-o", "ball.msh"], check=True)


def read():
    """Coordinates and tetrahedra of the mesh."""
    with open("ball.msh", encoding="ascii") as file:
        lines = file.read().split("\n")
    first, many = lines.index("$Nodes") + 2, lines.index("$Elements") + 2
    x = {int(w[0]): [float(v) for v in w[1:]] for w in (line.split() for line in lines[first:lines.index("$EndNodes")])}
    cells = [line.split() for line in lines[many:lines.index("$EndElements")]]
    cells = [[int(v) for v in w[-4:]] for w in cells if w[1] == "4"]
    number = {node: i for i, node in enumerate(sorted({v for cell in cells for v in cell}))}
    return numpy.array([x[node] for node in number]), [[number[v] for v in cell] for cell in cells]


def steps(x, cells):
    """2/omega of the fastest cell alone and of the free body, with the mass at the nodes."""
    lame, shear = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
    law = numpy.diag([2 * shear] * 3 + [shear] * 3) + numpy.pad(numpy.full((3, 3), lame), (0, 3))
    stiffness, mass, fastest = numpy.zeros((x.size, x.size)), numpy.zeros(x.size), 0.0
    for cell in cells:
        sides = x[cell[1:]] - x[cell[0]]
        volume, slopes = abs(numpy.linalg.det(sides)) / 6, numpy.linalg.inv(sides)
        strain = numpy.zeros((6, 12))
        for a, g in enumerate(numpy.hstack([-slopes.sum(axis=1, keepdims=True), slopes]).T):
            strain[:, 3 * a:3 * a + 3] = [[g[0], 0, 0], [0, g[1], 0], [0, 0, g[2]], [g[1], g[0], 0], [0, g[2], g[1]], [g[2], 0, g[0]]]
        one = volume * strain.T @ law @ strain
        fastest = max(fastest, numpy.linalg.eigvalsh(one)[-1] / (RHO * volume / 4))
        dofs = [3 * node + k for node in cell for k in range(3)]
        stiffness[numpy.ix_(dofs, dofs)] += one
        mass[dofs] += RHO * volume / 4
    whole = numpy.linalg.eigvalsh(stiffness / numpy.sqrt(numpy.outer(mass, mass)))[-1]
    return 2 / numpy.sqrt(fastest), 2 / numpy.sqrt(whole)


def told(r):
    return float(re.search(r"the stable step of the cells is ([^,]+),", r.log).group(1))


BALL = {"mesh": "ball.msh", "materials": "ball", "material_ball_E": E, "material_ball_nu": NU, "material_ball_rho": RHO, "ts_type": "central_difference",
        "material_ball_locking": "none", "ics": "v", "ic_v_on": "ball", "ic_v_vx": "1e-5*sin(3*y)*x", "ic_v_vy": "1e-5*cos(40*x*z)", "ts_max_time": 1e9}
x, cells = read()
alone, whole = steps(x, cells)
print(f"     {len(cells)} tetrahedra, {len(x)} nodes: 2/omega of the fastest cell {alone:.4g}, of the body {whole:.4g}")
r = run("ball", {**BALL, "ts_dt_cfl": 1, "ts_max_steps": 3000, "outputs": "h", "output_h_type": "csv", "output_h_every": 100})
step = told(r)
check_between("stable step over that of the fastest cell alone", step / alone, 1, 10)  # 0.72 by the bounds of cells alone
check_between("over that of the body", step / whole, 0.4, 1)
total = r["energy_kinetic"] + r["energy_elastic"] + r["energy_numerical"]
check("energy after 3000 of these steps, over that of the start", abs(total / total[0] - 1).max(), 0, 1e-6, relative=False)
two = run("two", {**BALL, "ts_max_steps": 2}, ranks=2)
check("stable step on two ranks", told(two), step, 1e-9)
check("with second order, over the linear one", told(run("second", {**BALL, "order": 2, "ts_max_steps": 2})) / step, 0.4, 0.15)

print("mass scaling")
SCALED = {**BALL, "ts_max_steps": 2, "ts_mass_scaling_limit": 1}
for part, most in ((0.999, 0), (1.5, 0.05)):
    scaled = run("scaled", {**SCALED, "ts_mass_scaling_dt": part * step})
    added = re.search(r"mass scaling adds (\S+) kg to (\d+) cells", scaled.log)
    many = int(added.group(2)) if added else 0
    check_between(f"{part} of the stable step: part of the cells that get mass", many / len(cells), 1e-9 if most else 0, 0.2 if most else 0)
    check_between(f"{part} of the stable step: the step that is stable then, over it", told(scaled) / step, max(part, 1) * (1 - 1e-9), 10)
require("nothing else is told", "WARNING" not in scaled.log)

print("a rank that has cells of a rigid body alone")
apart = run("apart", {"mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 6, "mesh_set_n_upper": 2, "mesh_set_gap": 0.1, "materials": "lower,upper",
                      "material_lower_model": "rigid", "material_lower_rho": RHO, "material_upper_E": E, "material_upper_nu": NU, "material_upper_rho": RHO,
                      "ics": "v", "ic_v_on": "upper", "ic_v_vy": "0.1*sin(3*x)", "petscpartitioner_type": "simple", "ts_type": "central_difference",
                      "ts_max_steps": 200, "ts_max_time": 1e9}, ranks=2)
require("ends", "200" in apart.log and "-ts_max_steps" in apart.log)
finish()
