#include "../mesh/small_mesh.hpp"
#include "io_error.hpp"
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <impact/io/checkpoint.hpp>
#include <impact/io/durable_file.hpp>
#include <impact/io/hdf5_reader.hpp>
#include <limits>
#include <map>

namespace impact {
namespace {

using namespace run_test;
namespace fs = std::filesystem;

/// Mesh, packed cells and a table with one row of every support, filled with values that say where they
/// belong.
struct Case {
  Mesh mesh;
  std::vector<CellGroup> groups;
  StateTable table;
  std::string surface;

  Case(Mesh made, std::string on) : mesh(std::move(made)), surface(std::move(on)) {
    std::vector<int> material(static_cast<std::size_t>(mesh.cell_count()), 0);
    int number = 0;
    for (const Group& g : mesh.groups())
      if (g.dim == mesh.dim()) {
        for (const PetscInt p : mesh.region_cells(g.name))
          material[static_cast<std::size_t>(p - mesh.cell_start())] = number;
        ++number;
      }
    groups = pack_cells(mesh, material);
    std::size_t points = 0;
    for (const CellGroup& g : groups)
      points += static_cast<std::size_t>(g.batch_count * point_count(g.shape) * lanes);
    const auto nodes = static_cast<std::size_t>(mesh.node_count());
    const auto facets = static_cast<std::size_t>(mesh.facets(surface).count());
    table.add({"u", Support::vertex, mesh.dim()}, nodes * static_cast<std::size_t>(mesh.dim()));
    table.add({"phi", Support::vertex, 1}, nodes);
    table.add({"history", Support::cell_point, 5}, points * 5);
    table.add({.name = "lambda", .support = Support::facet_point, .components = 2, .surface = surface},
              facets * 3 * 2);
    table.add({"steps", Support::global, 3, false}, 3);
    table.add({.name = "scratch", .support = Support::vertex, .components = 1, .checkpointed = false}, nodes);
  }

  CheckpointState state() { return {mesh, groups, table}; }

  // A number that depends on the place alone and uses all bits of a double.
  static double at(double x, double y, double z, int k) {
    return std::sin(3 * x + 5 * y + 7 * z + 11 * k) / 3;
  }

  /// The value that each double of a row should have.
  std::vector<double> expected(const StateRow& row) const {
    std::vector<double> values(row.committed.size());
    const auto dim = static_cast<std::size_t>(mesh.dim());
    const auto place = [&](int node, std::size_t i) {
      return i < dim ? mesh.coordinates()[static_cast<std::size_t>(node) * dim + i] : 0.0;
    };
    std::size_t next = 0;
    if (row.support == Support::vertex)
      for (int n = 0; n < mesh.node_count(); ++n)
        for (int k = 0; k < row.components; ++k)
          values[next++] = at(place(n, 0), place(n, 1), place(n, 2), k);
    if (row.support == Support::cell_point) // near node a of the cell: the order of the points is tested too
      for (const CellGroup& g : groups)
        for (int b = 0; b < g.batch_count; ++b)
          for (int q = 0; q < point_count(g.shape); ++q)
            for (int k = 0; k < row.components; ++k)
              for (int l = 0; l < lanes; ++l) {
                double x[3] = {0, 0, 0};
                for (int a = 0; a < node_count(g.shape); ++a) {
                  const int node =
                      g.node[static_cast<std::size_t>((b * node_count(g.shape) + a) * lanes + l)];
                  for (std::size_t i = 0; i < 3; ++i) x[i] += place(node, i) * (a == q ? 1 : 0.125);
                }
                values[next++] = at(x[0], x[1], x[2], k + g.material);
              }
    if (row.support == Support::facet_point) {
      const FacetTable facets = mesh.facets(surface);
      for (int f = 0; f < facets.count(); ++f)
        for (int k = 0; k < 6; ++k) {
          double x[3] = {0, 0, 0};
          for (int a = 0; a < facets.nodes_per_facet; ++a)
            for (std::size_t i = 0; i < 3; ++i)
              x[i] += place(facets.connectivity[static_cast<std::size_t>(f * facets.nodes_per_facet + a)], i);
          values[next++] = at(x[0], x[1], x[2], k);
        }
    }
    if (row.support == Support::global) values = {1.0 / 3, -0.0, 1e300};
    return values;
  }
  void fill() {
    for (const auto& row : table.rows()) {
      row->committed = expected(*row);
      if (row->has_trial) row->trial.assign(row->committed.size(), -7);
    }
  }
  /// Every bit of every checkpointed row as filled, in both halves.
  bool restored() const {
    bool same = true;
    const auto equal = [](const std::vector<double>& a, const std::vector<double>& b) {
      return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
        return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
      });
    };
    for (const auto& row : table.rows()) {
      if (!row->checkpointed) continue;
      const std::vector<double> right = expected(*row);
      same = same && equal(row->committed, right) && (!row->has_trial || equal(row->trial, right));
    }
    return same;
  }
};

const CheckpointValues some_values{
    0.1 + 0.2, 120, {{"options", "-a \"b c\"\n-d 1\n"}, {"empty", ""}, {"a \\ \"b\"", "1\\2\n"}}};

std::string write_checkpoint(const CheckpointState& state, const CheckpointValues& values,
                             CheckpointFolder folder) {
  return CheckpointWriter(state, std::move(folder)).write(values);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class CheckpointOn2DAnd3D : public testing::TestWithParam<bool> {
protected:
  std::string text() const { return GetParam() ? block(3) : two_bodies(6); }
  std::string surface() const { return GetParam() ? "top" : "lower top"; }
};

TEST_P(CheckpointOn2DAnd3D, RestoresEveryBitOfEverySupport) {
  const std::string dir = fresh_dir("roundtrip");
  Case written(mesh_of(PETSC_COMM_WORLD, dir, text()), surface());
  written.fill();
  const std::string file = write_checkpoint(written.state(), some_values, {dir, 2});

  Case fresh(mesh_of(PETSC_COMM_WORLD, dir, text()), surface());
  EXPECT_FALSE(all_ranks_agree(PETSC_COMM_WORLD, fresh.restored()));
  const auto found = newest_checkpoint(PETSC_COMM_WORLD, dir);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->file, file);
  EXPECT_TRUE(found->warnings.empty());
  EXPECT_EQ(found->values.time, some_values.time);
  EXPECT_EQ(found->values.step, 120);
  EXPECT_EQ(found->values.texts, some_values.texts);
  read_checkpoint(*found, fresh.state());
  EXPECT_TRUE(fresh.restored());
}

TEST_P(CheckpointOn2DAnd3D, MovesToMoreAndToFewerRanks) {
  const std::string dir = fresh_dir("ranks");
  int ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const bool one_of_few = rank_of(PETSC_COMM_WORLD) < std::max(1, ranks - 1);
  MPI_Comm few = MPI_COMM_NULL;
  MPI_Comm_split(PETSC_COMM_WORLD, one_of_few ? 0 : MPI_UNDEFINED, 0, &few);
  if (one_of_few) {
    Case written(mesh_of(few, dir, text()), surface());
    written.fill();
    write_checkpoint(written.state(), some_values, {dir + "/few", 2});
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  Case all(mesh_of(PETSC_COMM_WORLD, dir, text()), surface());
  read_checkpoint(*newest_checkpoint(PETSC_COMM_WORLD, dir + "/few"), all.state());
  EXPECT_TRUE(all.restored());

  write_checkpoint(all.state(), some_values, {dir + "/all", 2});
  if (one_of_few) {
    Case read(mesh_of(few, dir, text()), surface());
    read_checkpoint(*newest_checkpoint(few, dir + "/all"), read.state());
    EXPECT_TRUE(read.restored());
    MPI_Comm_free(&few);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
}

// A restart makes its mesh of what the checkpoint holds.
TEST_P(CheckpointOn2DAnd3D, HoldsTheFileOfTheMesh) {
  const std::string dir = fresh_dir("mesh");
  MeshRequest request;
  request.file = dir + "/mesh.msh";
  Case written(mesh_of(PETSC_COMM_WORLD, dir, text()), surface());
  const GmshFile file = read_mesh_file(PETSC_COMM_WORLD, request);
  CheckpointState state = written.state();
  state.file = &file;
  written.fill();
  const auto found = open_checkpoint(PETSC_COMM_WORLD, write_checkpoint(state, some_values, {dir, 2}));
  on_rank_zero(PETSC_COMM_WORLD, [&] { fs::remove(dir + "/mesh.msh"); });
  std::optional<GmshFile> stored = read_checkpoint_mesh_file(PETSC_COMM_WORLD, found);
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->x, file.x);
  const ElementRows before = rows_of(PETSC_COMM_WORLD, file), after = rows_of(PETSC_COMM_WORLD, *stored);
  EXPECT_EQ(before.cells, after.cells);
  EXPECT_EQ(before.boundary, after.boundary);
  Case loaded(build_mesh(PETSC_COMM_WORLD, request, std::move(*stored)), surface());
  read_checkpoint(found, loaded.state());
  EXPECT_TRUE(loaded.restored());
}

// The file is one that HDF5 reads, and the same for any ranks but for the order of its entities.
TEST_P(CheckpointOn2DAnd3D, IsAnHDF5FileWithADataSetForEachRow) {
  const std::string dir = fresh_dir("data_sets");
  Case written(mesh_of(PETSC_COMM_WORLD, dir, text()), surface());
  written.fill();
  const std::string name = write_checkpoint(written.state(), some_values, {dir, 2});
  const auto nodes = static_cast<hsize_t>(written.mesh.global_node_count());
  const auto dim = static_cast<hsize_t>(written.mesh.dim());
  on_rank_zero(PETSC_COMM_WORLD, [&] {
    const hdf5::Reader file(name);
    EXPECT_EQ(file.list("/state"), (std::vector<std::string>{"history", "lambda", "phi", "steps", "u"}));
    EXPECT_EQ(file.extent("/state/u"), (std::vector<hsize_t>{nodes, dim}));
    EXPECT_EQ(file.extent("/keys/vertex"), (std::vector<hsize_t>{nodes, 2}));
    EXPECT_EQ(file.numbers("/state/steps"), (std::vector<double>{1.0 / 3, -0.0, 1e300}));
    const std::vector<double> u = file.numbers("/state/u"), middle = file.rows("/state/u", 2, 3);
    EXPECT_TRUE(std::equal(middle.begin(), middle.end(), u.begin() + 2 * static_cast<std::ptrdiff_t>(dim)));
  });
}

TEST_P(CheckpointOn2DAnd3D, HoldsARowThatAnEarlierOneHadNot) {
  const std::string dir = fresh_dir("more_rows");
  Case written(mesh_of(PETSC_COMM_WORLD, dir, text()), surface()),
      fresh(mesh_of(PETSC_COMM_WORLD, dir, text()), surface());
  write_checkpoint(written.state(), some_values, {dir, 2});
  for (Case* c : {&written, &fresh})
    c->table.add({"theta", Support::vertex, 1}, static_cast<std::size_t>(c->mesh.node_count()));
  written.fill();
  read_checkpoint(open_checkpoint(PETSC_COMM_WORLD, write_checkpoint(written.state(), some_values, {dir, 2})),
                  fresh.state());
  EXPECT_TRUE(fresh.restored());
}

INSTANTIATE_TEST_SUITE_P(, CheckpointOn2DAnd3D, testing::Values(false, true), [](const auto& which) {
  return which.param ? "Hexahedra" : "TrianglesAndQuadrilaterals";
});

TEST(Checkpoint, RefusesAnotherMesh) {
  const std::string dir = fresh_dir("other_mesh");
  Case written(mesh_of(PETSC_COMM_WORLD, dir, two_bodies(6)), "lower top");
  const auto found =
      open_checkpoint(PETSC_COMM_WORLD, write_checkpoint(written.state(), some_values, {dir, 2}));
  for (const std::string& text : {two_bodies(6, 1e-3), two_bodies(5), two_bodies(7)}) {
    Case other(mesh_of(PETSC_COMM_WORLD, dir, text), "lower top");
    EXPECT_TRUE(contains(io_error_of([&] { read_checkpoint(found, other.state()); }), "another mesh"));
  }
}

TEST(Checkpoint, RefusesOtherRowsAndNamesThem) {
  const std::string dir = fresh_dir("other_rows");
  Case written(mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4)), "lower top");
  const auto found =
      open_checkpoint(PETSC_COMM_WORLD, write_checkpoint(written.state(), some_values, {dir, 2}));
  written.table.add({"theta", Support::vertex, 1}, static_cast<std::size_t>(written.mesh.node_count()));
  EXPECT_TRUE(contains(io_error_of([&] { read_checkpoint(found, written.state()); }), "theta (vertex, 1)"));
}

/// Three checkpoints of one case, keeping all; returns their names.
std::vector<std::string> three(Case& c, const std::string& dir) {
  std::vector<std::string> files;
  for (long step : {10, 20, 30}) {
    c.table.row("steps").committed[0] = static_cast<double>(step); // no two are alike
    files.push_back(write_checkpoint(c.state(), {0.1, step, {}}, {dir, 3}));
  }
  return files;
}

void change_byte(const std::string& file, std::uintmax_t at, int flip) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(at));
  const char c = static_cast<char>(stream.get() ^ flip);
  stream.seekp(static_cast<std::streamoff>(at));
  stream.put(c);
}

TEST(Checkpoint, FallsBackFromDamagedFilesWithAWarning) {
  const std::string dir = fresh_dir("damage");
  Case c(mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4)), "lower top");
  c.fill();
  const std::vector<std::string> files = three(c, dir);
  const auto manifest = [](const std::string& file) {
    return fs::path(file).replace_extension(".manifest").string();
  };
  const std::string good = files[1], bad = files[2], copy = dir + "/copy",
                    copy_manifest = dir + "/copy_manifest";
  const auto size = fs::file_size(bad);
  std::vector<std::pair<const char*, std::function<void()>>> damages = {
      {"bytes instead of", [&] { fs::resize_file(bad, size / 2); }},
      {"bytes instead of", [&] { fs::resize_file(bad, 0); }},
      {"bytes instead of", [&] { std::ofstream(bad, std::ios::app) << "x"; }},
      {"no such file", [&] { fs::remove(bad); }},
      {"checksum", [&] { fs::copy_file(good, bad, fs::copy_options::overwrite_existing); }},
      {"manifest is damaged", [&] { change_byte(manifest(bad), 40, 1); }},
      {"manifest is damaged", [&] { fs::resize_file(manifest(bad), 60); }},
      {"manifest is damaged", [&] { fs::resize_file(manifest(bad), 0); }},
      {"belongs to another",
       [&] { fs::copy_file(manifest(good), manifest(bad), fs::copy_options::overwrite_existing); }}};
  for (std::uintmax_t k = 0; k < 40; ++k)
    damages.push_back({"checksum", [&, k] { change_byte(bad, (size - 1) * k / 39, 1 << (k % 8)); }});

  on_rank_zero(PETSC_COMM_WORLD, [&] {
    fs::copy_file(bad, copy);
    fs::copy_file(manifest(bad), copy_manifest);
  });
  for (const auto& [reason, damage] : damages) {
    on_rank_zero(PETSC_COMM_WORLD, [&] {
      fs::copy_file(copy, bad, fs::copy_options::overwrite_existing);
      fs::copy_file(copy_manifest, manifest(bad), fs::copy_options::overwrite_existing);
      damage();
    });
    EXPECT_TRUE(contains(io_error_of([&] { open_checkpoint(PETSC_COMM_WORLD, bad); }), reason)) << reason;
    const auto found = newest_checkpoint(PETSC_COMM_WORLD, dir);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->file, good);
    EXPECT_EQ(found->values.step, 20);
    ASSERT_EQ(found->warnings.size(), 1U);
    EXPECT_TRUE(contains(found->warnings[0], bad) && contains(found->warnings[0], reason))
        << found->warnings[0];
  }
}

TEST(Checkpoint, NeverStartsAnewWhenAllAreDamaged) {
  const std::string dir = fresh_dir("all_damaged");
  Case c(mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4)), "lower top");
  EXPECT_FALSE(newest_checkpoint(PETSC_COMM_WORLD, dir));
  EXPECT_FALSE(newest_checkpoint(PETSC_COMM_WORLD, dir + "/nowhere"));
  const std::vector<std::string> files = three(c, dir);
  on_rank_zero(PETSC_COMM_WORLD, [&] {
    for (const std::string& file : files) fs::resize_file(file, 100);
  });
  const std::string message = io_error_of([&] { newest_checkpoint(PETSC_COMM_WORLD, dir); });
  for (const std::string& file : files) EXPECT_TRUE(contains(message, file)) << message;
}

TEST(Checkpoint, IgnoresAndClearsWhatAKillLeft) {
  const std::string dir = fresh_dir("kill");
  Case c(mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4)), "lower top");
  const std::string first = write_checkpoint(c.state(), {0.1, 10, {}}, {dir, 2});
  const std::string stale = dir + "/checkpoint_000002.h5.tmp", orphan = dir + "/checkpoint_000003.h5";
  on_rank_zero(PETSC_COMM_WORLD, [&] { // killed while writing 2; in another life before the manifest of 3
    std::ofstream(stale) << "half";
    fs::copy_file(first, orphan);
  });
  EXPECT_EQ(newest_checkpoint(PETSC_COMM_WORLD, dir)->file, first);
  EXPECT_TRUE(contains(io_error_of([&] { open_checkpoint(PETSC_COMM_WORLD, orphan); }), "not finished"));
  const std::string next = write_checkpoint(c.state(), {0.2, 20, {}}, {dir, 2});
  EXPECT_EQ(fs::path(next).filename(), "checkpoint_000004.h5");
  EXPECT_FALSE(fs::exists(stale));
  EXPECT_FALSE(fs::exists(orphan));
  EXPECT_TRUE(fs::exists(first));
  MPI_Barrier(PETSC_COMM_WORLD);
}

TEST(Checkpoint, KeepsTheNewestWhateverTheirSteps) {
  const std::string dir = fresh_dir("keep");
  Case c(mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4)), "lower top");
  std::vector<std::string> files;
  for (long step : {500, 10, 20}) files.push_back(write_checkpoint(c.state(), {0.1, step, {}}, {dir, 2}));
  EXPECT_FALSE(fs::exists(files[0]));
  EXPECT_TRUE(fs::exists(files[1]) && fs::exists(files[2]));
  EXPECT_EQ(newest_checkpoint(PETSC_COMM_WORLD, dir)->values.step, 20);
  write_checkpoint(c.state(), {0.1, 30, {}}, {dir, 0});
  EXPECT_EQ(newest_checkpoint(PETSC_COMM_WORLD, dir)->values.step, 30);
}

TEST(Checkpoint, SaysOnAllRanksWhyItCannotWrite) {
  const std::string dir = fresh_dir("unwritable");
  Case c(mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4)), "lower top");
  on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(dir + "/file") << "x"; });
  const std::string message = io_error_of([&] {
    write_checkpoint(c.state(), some_values, {dir + "/file/below", 2});
  });
  EXPECT_TRUE(contains(message, dir + "/file/below") && contains(message, "Not a directory")) << message;

  const std::string good = write_checkpoint(c.state(), some_values, {dir, 1});
  {
    const FileSizeLimit limit(2000);
    EXPECT_TRUE(contains(io_error_of([&] {
                           write_checkpoint(c.state(), some_values, {dir, 1});
                         }),
                         "File too large"));
  }
  EXPECT_EQ(newest_checkpoint(PETSC_COMM_WORLD, dir)->file, good);
}

} // namespace
} // namespace impact
