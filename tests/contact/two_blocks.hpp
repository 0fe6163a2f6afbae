#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <impact/kernel/frame.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <string>
#include <vector>

/// Two rectangular blocks of quadrilaterals, one above the other, with meshes that do not match; for tests of
/// contact.
namespace impact::contact_test {

struct TwoBlocks {
  int lower_cells = 7, upper_cells = 5, layers = 2;
  double lower_left = 0, lower_right = 2.1, upper_left = 0.35, upper_right = 1.6;
  double gap = 0, angle = 0;
  Frame frame = Frame::plane_strain;
  bool bulge = false; ///< the lower surface is a shallow hill instead of flat
};

/// Rank of a cell by the centre of its undistorted place: body 0 or 1, part 0..1 along the block.
using Partition = std::function<int(int body, double part, int ranks)>;

inline int bodies_apart(int body, double part, int ranks) {
  if (ranks < 3) return body == 0 ? 0 : ranks - 1;
  return body == 1 ? 2 : part < 0.5 ? 0 : 1;
}
inline int bodies_mixed(int body, double part, int ranks) {
  return (static_cast<int>(part * 2.99) + body) % ranks;
}

inline std::array<double, 2> place(const TwoBlocks& b, double x, double y) {
  const double c = std::cos(b.angle), s = std::sin(b.angle);
  return {c * x - s * y, s * x + c * y};
}

/// Groups lower, upper (cells), lower_top, upper_bottom, lower_left, skin (edges). Collective.
inline Mesh make_blocks(MPI_Comm comm, const TwoBlocks& b, const Partition& partition) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  std::vector<double> x;
  std::vector<PetscInt> cells;
  std::vector<int> owner;
  for (int body = 0; body < 2 && rank == 0; ++body) {
    const int n = body == 0 ? b.lower_cells : b.upper_cells;
    const double left = body == 0 ? b.lower_left : b.upper_left,
                 right = body == 0 ? b.lower_right : b.upper_right;
    const auto first = static_cast<PetscInt>(x.size() / 2);
    for (int j = 0; j <= b.layers; ++j)
      for (int i = 0; i <= n; ++i) {
        const double X = left + (right - left) * i / n;
        double Y = body == 0 ? -0.6 + 0.6 * j / b.layers : b.gap + 0.6 * j / b.layers;
        if (b.bulge && body == 0 && j == b.layers) Y -= 0.12 * (X - 1) * (X - 1);
        const auto p = place(b, X, Y);
        x.insert(x.end(), p.begin(), p.end());
      }
    for (int j = 0; j < b.layers; ++j)
      for (int i = 0; i < n; ++i) {
        const PetscInt a = first + j * (n + 1) + i;
        cells.insert(cells.end(), {a, a + 1, a + n + 2, a + n + 1});
        owner.push_back(partition(body, (i + 0.5) / n, ranks));
      }
  }
  const auto count = static_cast<PetscInt>(owner.size());
  Handle<DM> dm;
  check(DMPlexCreateFromCellListPetsc(comm, 2, count, static_cast<PetscInt>(x.size() / 2), 4, PETSC_TRUE,
                                      cells.data(), 2, x.data(), dm.out()));
  std::vector<Group> groups = {{"lower", 2},        {"upper", 2},      {"lower_top", 1},
                               {"upper_bottom", 1}, {"lower_left", 1}, {"skin", 1}};
  for (const Group& group : groups) check(DMCreateLabel(dm, group.name.c_str()));
  DMLabel skin = nullptr;
  check(DMGetLabel(dm, "skin", &skin));
  check(DMPlexMarkBoundaryFaces(dm, 1, skin));
  if (rank == 0) {
    const int lower = b.layers * b.lower_cells;
    for (PetscInt c = 0; c < count; ++c) check(DMSetLabelValue(dm, c < lower ? "lower" : "upper", c, 2));
    auto mark = [&](const char* name, PetscInt cell, int side) {
      const PetscInt* cone = nullptr;
      check(DMPlexGetCone(dm, cell, &cone));
      check(DMSetLabelValue(dm, name, cone[side], 1));
    };
    for (int i = 0; i < b.lower_cells; ++i) mark("lower_top", lower - b.lower_cells + i, 2);
    for (int i = 0; i < b.upper_cells; ++i) mark("upper_bottom", lower + i, 0);
    for (int j = 0; j < b.layers; ++j) mark("lower_left", j * b.lower_cells, 3);
  }
  if (ranks > 1) {
    std::vector<PetscInt> sizes(static_cast<std::size_t>(ranks), 0), points;
    for (int r = 0; r < ranks && rank == 0; ++r)
      for (PetscInt c = 0; c < count; ++c)
        if (owner[static_cast<std::size_t>(c)] == r) {
          ++sizes[static_cast<std::size_t>(r)];
          points.push_back(c);
        }
    PetscPartitioner partitioner = nullptr;
    check(DMPlexGetPartitioner(dm, &partitioner));
    check(PetscPartitionerSetType(partitioner, PETSCPARTITIONERSHELL));
    check(PetscPartitionerShellSetPartition(partitioner, ranks, sizes.data(), points.data()));
    Handle<DM> distributed;
    check(DMPlexDistribute(dm, 0, nullptr, distributed.out()));
    dm = std::move(distributed);
  }
  return Mesh(std::move(dm), std::move(groups));
}

/// A displacement as a function of the undistorted place and the body (told apart by `upper` cells' nodes).
using Motion = std::function<std::array<double, 2>(int body, double X, double Y)>;

inline std::array<double, 2> undistorted(const TwoBlocks& b, double x, double y) {
  const double c = std::cos(b.angle), s = std::sin(b.angle);
  return {c * x + s * y, -s * x + c * y};
}

/// 1 at the nodes of the upper block. Collective.
inline std::vector<int> body_of(const Mesh& mesh) {
  std::vector<int> body(static_cast<std::size_t>(mesh.node_count()), 0);
  for (int node : mesh.nodes("upper")) body[static_cast<std::size_t>(node)] = 1;
  return body;
}

/// The motion, turned with the blocks, as a global vector. Collective.
inline Handle<Vec> displacement(const Mesh& mesh, const FieldLayout& layout, const TwoBlocks& b,
                                const Motion& motion) {
  std::vector<double> local = layout.make_local();
  const std::vector<int> body = body_of(mesh);
  for (std::size_t n = 0; n < body.size(); ++n) {
    const auto X = undistorted(b, mesh.coordinates()[2 * n], mesh.coordinates()[2 * n + 1]);
    const auto u = motion(body[n], X[0], X[1]);
    const auto turned = place(b, u[0], u[1]);
    local[2 * n] = turned[0];
    local[2 * n + 1] = turned[1];
  }
  Handle<Vec> u = layout.make_global();
  layout.to_global(local, u);
  return u;
}

/// Values of all nodes on all ranks by body and reference coordinates: body, X, Y -> two values. Collective.
using NodeValues = std::map<std::array<double, 3>, std::array<double, 2>>;

inline NodeValues node_map(const Mesh& mesh, const FieldLayout& layout, Vec global) {
  std::vector<double> local = layout.make_local();
  layout.to_local(global, local);
  const std::vector<int> body = body_of(mesh);
  std::vector<double> packed;
  for (std::size_t n = 0; n < body.size(); ++n)
    packed.insert(packed.end(), {static_cast<double>(body[n]), mesh.coordinates()[2 * n],
                                 mesh.coordinates()[2 * n + 1], local[2 * n], local[2 * n + 1]});
  int ranks = 1, mine = static_cast<int>(packed.size()), total = 0;
  MPI_Comm_size(mesh.comm(), &ranks);
  std::vector<int> sizes(static_cast<std::size_t>(ranks)), offsets;
  MPI_Allgather(&mine, 1, MPI_INT, sizes.data(), 1, MPI_INT, mesh.comm());
  for (int size : sizes) {
    offsets.push_back(total);
    total += size;
  }
  std::vector<double> all(static_cast<std::size_t>(total));
  MPI_Allgatherv(packed.data(), mine, MPI_DOUBLE, all.data(), sizes.data(), offsets.data(), MPI_DOUBLE,
                 mesh.comm());
  NodeValues map;
  for (std::size_t i = 0; i < all.size(); i += 5)
    map[{all[i], all[i + 1], all[i + 2]}] = {all[i + 3], all[i + 4]};
  return map;
}

} // namespace impact::contact_test
