// The assembly of tests/bench/assembly_bench.cpp by deal.II: same law, mesh and quadrature, one rank, the loop over
// FEValues of its tutorials. usage: dealii_assembly <dim> <cells along an edge>
// Prints CPU nanoseconds per cell, the smallest of seven repetitions, of the residual and of residual plus tangent
// in a SparseMatrix.
#include <deal.II/base/multithread_info.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_renumbering.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/sparse_matrix.h>
#include <deal.II/lac/vector.h>
#include <deal.II/numerics/vector_tools.h>
#include <deal.II/physics/elasticity/kinematics.h>
#include <deal.II/physics/elasticity/standard_tensors.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>

using namespace dealii;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

template <int dim> struct Displacement : Function<dim> {
  Displacement() : Function<dim>(dim) {}
  double value(const Point<dim>& x, unsigned k) const override {
    if (k == 0) return 0.02 * x[0] * x[0] + 0.03 * x[1];
    return k == 1 && dim == 3 ? 0.03 * x[dim - 1] : 0.03 * x[0];
  }
};

template <int dim> void run(int n) {
  const double K = 70, G = 27;
  using Tensors = Physics::Elasticity::StandardTensors<dim>;
  Triangulation<dim> mesh;
  GridGenerator::subdivided_hyper_cube(mesh, n);
  FESystem<dim> element(FE_Q<dim>(1), dim);
  DoFHandler<dim> dofs(mesh);
  dofs.distribute_dofs(element);
  DoFRenumbering::Cuthill_McKee(dofs);
  AffineConstraints<double> held;
  DoFTools::make_zero_boundary_constraints(dofs, held);
  held.close();
  SparsityPattern pattern;
  {
    DynamicSparsityPattern full(dofs.n_dofs());
    DoFTools::make_sparsity_pattern(dofs, full, held, false);
    pattern.copy_from(full);
  }
  SparseMatrix<double> matrix(pattern);
  Vector<double> u(dofs.n_dofs()), force(dofs.n_dofs());
  VectorTools::interpolate(dofs, Displacement<dim>(), u);

  const QGauss<dim> points(2);
  FEValues<dim> values(element, points, update_gradients | update_JxW_values);
  const FEValuesExtractors::Vector motion(0);
  const unsigned size = element.n_dofs_per_cell();
  FullMatrix<double> cell_matrix(size, size);
  Vector<double> cell_force(size);
  std::vector<types::global_dof_index> index(size);
  std::vector<Tensor<2, dim>> H(points.size()), g(size);
  std::vector<SymmetricTensor<2, dim>> strain(size);

  const auto assemble = [&](bool with_tangent) {
    force = 0;
    if (with_tangent) matrix = 0;
    for (const auto& cell : dofs.active_cell_iterators()) {
      values.reinit(cell);
      values[motion].get_function_gradients(u, H);
      cell_matrix = 0;
      cell_force = 0;
      for (unsigned q = 0; q < points.size(); ++q) {
        const Tensor<2, dim> F = Physics::Elasticity::Kinematics::F(H[q]), inverse = invert(F);
        const SymmetricTensor<2, dim> b = Physics::Elasticity::Kinematics::b(F);
        const double J = determinant(F), scale = G * std::pow(J, -2.0 / 3);
        const double mean = scale * (trace(b) + (dim == 2 ? 1 : 0)) / 3, p = K / 2 * (J * J - 1);
        const SymmetricTensor<2, dim> deviator = scale * b - mean * Tensors::I, tau = deviator + p * Tensors::I;
        const Tensor<2, dim> full_tau(tau);
        const double weight = values.JxW(q);
        for (unsigned i = 0; i < size; ++i) {
          g[i] = values[motion].gradient(i, q) * inverse;
          strain[i] = symmetrize(g[i]);
          cell_force(i) += strain[i] * tau * weight;
        }
        if (!with_tangent) continue;
        const SymmetricTensor<4, dim> modulus =
            (K * J * J - 2.0 / 3 * mean) * Tensors::IxI + (2 * mean - 2 * p) * Tensors::S -
            2.0 / 3 * (outer_product(deviator, Tensors::I) + outer_product(Tensors::I, deviator));
        for (unsigned i = 0; i < size; ++i) {
          const SymmetricTensor<2, dim> stress = strain[i] * modulus;
          const Tensor<2, dim> turned = g[i] * full_tau;
          const unsigned component = element.system_to_component_index(i).first;
          for (unsigned j = 0; j <= i; ++j) {
            double entry = stress * strain[j];
            if (component == element.system_to_component_index(j).first)
              entry += turned[component] * g[j][component];
            cell_matrix(i, j) += entry * weight;
          }
        }
      }
      cell->get_dof_indices(index);
      if (!with_tangent) {
        held.distribute_local_to_global(cell_force, index, force);
        continue;
      }
      for (unsigned i = 0; i < size; ++i)
        for (unsigned j = i + 1; j < size; ++j) cell_matrix(i, j) = cell_matrix(j, i);
      held.distribute_local_to_global(cell_matrix, cell_force, index, matrix, force);
    }
  };
  for (const bool with_tangent : {false, true}) {
    assemble(with_tangent);
    double least = 1e99;
    for (int i = 0; i < 7; ++i) {
      const double start = cpu_seconds();
      assemble(with_tangent);
      least = std::min(least, cpu_seconds() - start);
    }
    std::printf("%dD, deal.II, %s: %.1f cpu-ns/cell\n", dim, with_tangent ? "residual + tangent" : "residual",
                least / mesh.n_active_cells() * 1e9);
  }
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  MultithreadInfo::set_thread_limit(1);
  if (std::atoi(argv[1]) == 2)
    run<2>(std::atoi(argv[2]));
  else
    run<3>(std::atoi(argv[2]));
}
