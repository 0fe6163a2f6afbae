#pragma once
#include <cstdlib>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <string>
#include <utility>

namespace impact {

/// Meshes of the repository for tests; a .geo's mesh is written below the working folder.
inline MeshRequest example_mesh(const std::string& name, std::map<std::string, std::string> parameters = {}) {
  const char* source = std::getenv("IMPACT_SOURCE_DIR");
  MeshRequest request;
  request.file = std::string(source ? source : ".") + "/meshes/" + name + ".geo";
  request.parameters = std::move(parameters);
  request.work_dir = "mesh_test_files";
  return request;
}

/// Unit box with `n` cells along each edge; gmsh runs once for each kind.
inline Mesh make_block(Shape shape, int n) {
  static std::map<std::pair<Shape, int>, bool> made;
  MeshRequest request = example_mesh("block", {{"dim", std::to_string(dimension(shape))},
                                               {"simplex", shape->simplex() ? "1" : "0"},
                                               {"n", std::to_string(n)}});
  request.order = shape->order();
  if (shape->faces.empty() && shape->order() == 2 && !shape->simplex()) request.middles = Middles::edges;
  request.work_dir += "/block" + std::to_string(index_of(shape)) + "_" + std::to_string(n);
  if (std::exchange(made[{shape, n}], true)) {
    request.file = request.work_dir + "/block.msh";
    request.parameters.clear();
  }
  return read_mesh(PETSC_COMM_WORLD, request);
}

inline const Shape all_shapes[] = {Shape::tri3,  Shape::quad4, Shape::tet4,  Shape::hex8,  Shape::tri6,
                                   Shape::tet10, Shape::quad9, Shape::hex27, Shape::quad8, Shape::hex20};

inline double sum_over_ranks(double mine) {
  double all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return all;
}

inline double largest_over_ranks(double mine) {
  double all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return all;
}

/// The message of the UserError that `body` throws, checked to be the same kind on all ranks; "" when it
/// throws none.
template <class Body> std::string user_error(ExitCode& code, Body&& body) {
  try {
    body();
  } catch (const UserError& error) {
    code = error.code();
    return error.what();
  }
  code = ExitCode::ok;
  return "";
}

/// Coordinate i of a local node.
inline double x_of(const Mesh& mesh, int node, int i) {
  return mesh.coordinates()[static_cast<std::size_t>(node * mesh.dim() + i)];
}

/// Of all cells on all ranks, by their rule.
inline double volume(const Mesh& mesh) {
  double sum = 0;
  for (const CellTable& table : mesh.cells()) {
    const int dim = table.shape->dim, nodes = table.shape->nodes;
    for (std::size_t c = 0; c < table.point.size(); ++c)
      for (int q = 0; q < table.shape->points; ++q) {
        double J[3][3] = {};
        J[2][2] = dim == 2 ? 1 : 0;
        for (int a = 0; a < nodes; ++a)
          for (int i = 0; i < dim; ++i)
            for (int k = 0; k < dim; ++k)
              J[i][k] += x_of(mesh, table.connectivity[c * unsigned(nodes) + unsigned(a)], i) *
                         table.shape->dN[(q * nodes + a) * dim + k];
        sum += table.shape->weight[q] * (J[0][0] * (J[1][1] * J[2][2] - J[1][2] * J[2][1]) -
                                         J[0][1] * (J[1][0] * J[2][2] - J[1][2] * J[2][0]) +
                                         J[0][2] * (J[1][0] * J[2][1] - J[1][1] * J[2][0]));
      }
  }
  return sum_over_ranks(sum);
}

} // namespace impact
