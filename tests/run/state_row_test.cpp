#include "../mesh/small_mesh.hpp"
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <impact/io/checkpoint.hpp>
#include <impact/problem/discretisation.hpp>

// What a physics that comes later gets for one line of code: a row of the state table survives an accepted
// step, a refused one, a checkpoint and the move to another number of ranks.
namespace impact {
namespace {

using namespace run_test;

Discretisation discretisation(MPI_Comm comm, const std::string& dir) {
  MaterialParameters law;
  law.model = Model::j2;
  law.damage = Damage::at2;
  law.K = 2;
  law.G = 1;
  law.sigma_y = 1;
  law.Gc = 1;
  law.gamma = 1;
  Mesh mesh = mesh_of(comm, dir, two_bodies(6));
  std::vector<std::string> regions;
  for (const Group& group : mesh.groups())
    if (group.dim == mesh.dim()) regions.push_back(group.name);
  return discretise(std::move(mesh), {{PointLaw{law}, regions}}, Frame::plane_strain, 1);
}

/// The state of a run on this mesh with a row of each support that no code knows by name.
struct WithDummies {
  Discretisation d;
  StateTable table;
  const std::string surface = "lower top";

  WithDummies(MPI_Comm comm, const std::string& dir) : d(discretisation(comm, dir)) {
    declare_state(d, table);
    const std::size_t facet_values = static_cast<std::size_t>(d.mesh.facets(surface).count()) * 2;
    std::size_t points = 0;
    for (const CellGroup& g : d.groups)
      points += static_cast<std::size_t>(g.batch_count * point_count(g.shape) * lanes);
    // The one line per row that new physics writes:
    table.add({"dummy_vertex", Support::vertex, 2}, d.node_values(2));
    table.add({"dummy_cell", Support::cell_point, 3}, 3 * points);
    table.add({.name = "dummy_facet", .support = Support::facet_point, .components = 1, .surface = surface},
              facet_values);
    table.add({"dummy_global", Support::global, 2}, 2);
  }

  CheckpointState state() { return {d.mesh, d.groups, table}; }

  static double at(const double* x, int component) {
    return std::sin(3 * x[0] + 5 * x[1] + 7 * component) / 3;
  }

  /// Values that belong to places, so that they can be recognised on any distribution.
  std::vector<double> expected(const StateRow& row, double factor) const {
    std::vector<double> values;
    const auto X = d.mesh.coordinates();
    const auto place = [&](int node) { return &X[static_cast<std::size_t>(2 * node)]; };
    const auto add = [&](const double* x, int k) { values.push_back(factor * at(x, k)); };
    if (row.support == Support::vertex)
      for (int n = 0; n < d.mesh.node_count(); ++n)
        for (int k = 0; k < row.components; ++k) add(place(n), k);
    if (row.support == Support::cell_point)
      for (const CellGroup& g : d.groups)
        for (int b = 0; b < g.batch_count; ++b)
          for (int q = 0; q < point_count(g.shape); ++q)
            for (int k = 0; k < row.components; ++k)
              for (int l = 0; l < lanes; ++l)
                add(place(g.node[static_cast<std::size_t>(
                        (b * node_count(g.shape) + q % node_count(g.shape)) * lanes + l)]),
                    k);
    if (row.support == Support::facet_point) {
      const FacetTable facets = d.mesh.facets(surface);
      for (int f = 0; f < facets.count(); ++f)
        for (int a = 0; a < 2; ++a)
          add(place(facets.connectivity[static_cast<std::size_t>(f * facets.nodes_per_facet + a)]), a);
    }
    if (row.support == Support::global) values = {factor / 3, -factor};
    return values;
  }

  std::vector<StateRow*> dummies() {
    std::vector<StateRow*> found;
    for (const char* name : {"dummy_vertex", "dummy_cell", "dummy_facet", "dummy_global"})
      found.push_back(&table.row(name));
    return found;
  }
  void fill_trial(double factor) {
    for (StateRow* row : dummies()) row->trial = expected(*row, factor);
  }
  /// Bit for bit in both halves.
  bool holds(double factor) {
    bool same = true;
    for (StateRow* row : dummies()) {
      const std::vector<double> right = expected(*row, factor);
      for (const std::vector<double>* half : {&row->committed, &row->trial})
        same = same &&
               std::equal(half->begin(), half->end(), right.begin(), right.end(), [](double a, double b) {
                 return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
               });
    }
    return all_ranks_agree(d.mesh.comm(), same);
  }
};

TEST(StateRow, ANewRowSurvivesAcceptedAndRefusedSteps) {
  WithDummies run(PETSC_COMM_WORLD, fresh_dir("row_steps"));
  run.fill_trial(1);
  run.table.commit(); // accepted
  EXPECT_TRUE(run.holds(1));
  run.fill_trial(2);
  EXPECT_FALSE(run.holds(1));
  run.table.rollback(); // refused
  EXPECT_TRUE(run.holds(1));
}

TEST(StateRow, ANewRowSurvivesACheckpointAndTheMoveToOtherRanks) {
  const std::string dir = fresh_dir("row_moves");
  int ranks = 1, rank = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  const CheckpointValues values{0.5, 7, {{"options", ""}}};

  WithDummies all(PETSC_COMM_WORLD, dir);
  all.fill_trial(1);
  all.table.commit();
  CheckpointWriter(all.state(), {dir + "/all", 2}).write(values);

  WithDummies same(PETSC_COMM_WORLD, dir);
  EXPECT_FALSE(same.holds(1));
  read_checkpoint(*newest_checkpoint(PETSC_COMM_WORLD, dir + "/all"), same.state());
  EXPECT_TRUE(same.holds(1));

  // Onto rank 0 alone, and from there back onto all.
  MPI_Comm one = MPI_COMM_NULL;
  MPI_Comm_split(PETSC_COMM_WORLD, rank == 0 ? 0 : MPI_UNDEFINED, 0, &one);
  if (rank == 0) {
    WithDummies few(one, dir);
    read_checkpoint(*newest_checkpoint(one, dir + "/all"), few.state());
    EXPECT_TRUE(few.holds(1));
    few.fill_trial(3);
    few.table.commit();
    CheckpointWriter(few.state(), {dir + "/few", 2}).write(values);
    MPI_Comm_free(&one);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  WithDummies back(PETSC_COMM_WORLD, dir);
  read_checkpoint(*newest_checkpoint(PETSC_COMM_WORLD, dir + "/few"), back.state());
  EXPECT_TRUE(back.holds(3));
}

// A checkpoint that lacks the row is refused by name: the new physics is never started from zeros in silence.
TEST(StateRow, ACheckpointWithoutTheNewRowIsRefused) {
  const std::string dir = fresh_dir("row_missing");
  WithDummies run(PETSC_COMM_WORLD, dir);
  run.fill_trial(1);
  run.table.commit();
  CheckpointWriter(run.state(), {dir, 2}).write({0.5, 7, {}});
  WithDummies more(PETSC_COMM_WORLD, dir);
  more.table.add({"dummy_later", Support::vertex, 1}, more.d.node_values(1));
  try {
    read_checkpoint(*newest_checkpoint(PETSC_COMM_WORLD, dir), more.state());
    FAIL() << "a missing row was read";
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::io);
    EXPECT_NE(std::string(error.what()).find("dummy_later (vertex, 1)"), std::string::npos) << error.what();
  }
}

} // namespace
} // namespace impact
