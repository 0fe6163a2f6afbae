"""The assembly of tests/bench/assembly_bench.cpp by dolfinx: same law, mesh, quadrature and displacement, one rank.
usage: python3 dolfinx_assembly.py <dim> <cells along an edge>
Prints CPU nanoseconds per cell, the smallest of seven repetitions, of the residual and of residual plus tangent
assembled into PETSc's AIJ matrix. The generated code is compiled for this machine."""
import sys
import time

import numpy
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import petsc
from mpi4py import MPI

K, G = 70.0, 27.0
dim, n = int(sys.argv[1]), int(sys.argv[2])
cell = mesh.CellType.quadrilateral if dim == 2 else mesh.CellType.hexahedron
corners = [[0.0] * dim, [1.0] * dim]
box = (mesh.create_rectangle if dim == 2 else mesh.create_box)(MPI.COMM_SELF, corners, [n] * dim, cell)
space = fem.VectorFunctionSpace(box, ("Lagrange", 1))
u, du, test = fem.Function(space), ufl.TrialFunction(space), ufl.TestFunction(space)
if dim == 2:
    u.interpolate(lambda x: numpy.vstack((0.02 * x[0] ** 2 + 0.03 * x[1], 0.03 * x[0])))
else:
    u.interpolate(lambda x: numpy.vstack((0.02 * x[0] ** 2 + 0.03 * x[1], 0.03 * x[2], 0.03 * x[0])))

F = ufl.Identity(dim) + ufl.grad(u)
J = ufl.det(F)
trace = ufl.tr(F.T * F) + (1 if dim == 2 else 0)
energy = K / 2 * ((J**2 - 1) / 2 - ufl.ln(J)) + G / 2 * (J ** (-2.0 / 3) * trace - 3)
residual = ufl.derivative(energy * ufl.dx(metadata={"quadrature_degree": 2}), u, test)
native = {"cffi_extra_compile_args": ["-O3", "-march=native", "-ffast-math"], "cffi_libraries": ["m"]}


def compiled(form):
    try:
        return fem.form(form, jit_options=native)
    except TypeError:  # before 0.6
        return fem.form(form, jit_params=native)


vector_form, matrix_form = compiled(residual), compiled(ufl.derivative(residual, u, du))
facets = mesh.locate_entities_boundary(box, dim - 1, lambda x: numpy.full(x.shape[1], True))
held = fem.dirichletbc(numpy.zeros(dim), fem.locate_dofs_topological(space, dim - 1, facets), space)
vector, matrix = petsc.create_vector(vector_form), petsc.create_matrix(matrix_form)


def assemble_residual():
    with vector.localForm() as local:
        local.set(0)
    petsc.assemble_vector(vector, vector_form)


def assemble_both():
    assemble_residual()
    matrix.zeroEntries()
    petsc.assemble_matrix(matrix, matrix_form, bcs=[held])
    matrix.assemble()


for name, assemble in ("residual", assemble_residual), ("residual + tangent", assemble_both):
    assemble()
    seconds = []
    for _ in range(7):
        start = time.process_time()
        assemble()
        seconds.append(time.process_time() - start)
    print(f"{dim}D, dolfinx, {name}: {min(seconds) / n**dim * 1e9:.1f} cpu-ns/cell")
