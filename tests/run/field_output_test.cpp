#include "../mesh/small_mesh.hpp"
#include "io_error.hpp"
#include <cmath>
#include <gtest/gtest.h>
#include <impact/io/durable_file.hpp>
#include <impact/io/field_output.hpp>
#include <impact/io/hdf5_reader.hpp>
#include <map>
#include <set>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace impact {
namespace {

using namespace run_test;
namespace fs = std::filesystem;

double shape_at(double x, double y, double z, int k) { return std::cos(x + 2 * y + 3 * z + k); }

/// One time as the tests write it: values that depend on place, component and time.
struct Fields {
  std::vector<double> u, phi, stress, material;

  Fields(const Mesh& mesh, double time) {
    const auto dim = static_cast<std::size_t>(mesh.dim());
    const auto place = [&](int node, std::size_t i) {
      return i < dim ? mesh.coordinates()[static_cast<std::size_t>(node) * dim + i] : 0.0;
    };
    for (int n = 0; n < mesh.node_count(); ++n) {
      for (int k = 0; k < mesh.dim(); ++k)
        u.push_back(time * shape_at(place(n, 0), place(n, 1), place(n, 2), k));
      phi.push_back(time + place(n, 0));
    }
    for (const CellTable& table : mesh.cells())
      for (std::size_t c = 0; c < table.point.size(); ++c) {
        const auto nodes = static_cast<std::size_t>(node_count(table.shape));
        double x[3] = {0, 0, 0};
        for (std::size_t a = 0; a < nodes; ++a)
          for (std::size_t i = 0; i < 3; ++i)
            x[i] += place(table.connectivity[c * nodes + a], i) / static_cast<double>(nodes);
        for (int k = 0; k < 6; ++k) stress.push_back(time * shape_at(x[0], x[1], x[2], k));
        material.push_back(static_cast<double>(nodes));
      }
  }
  std::vector<Field> all(int dim) const {
    return {{"u", true, dim, u},
            {"phi", true, 1, phi},
            {"stress", false, 6, stress},
            {"material", false, 1, material}};
  }
};

void write(FieldOutput& output, const Mesh& mesh, double time) {
  const Fields fields(mesh, time);
  output.write(time, fields.all(mesh.dim()));
}

/// The value of an attribute in a start tag, empty when it is not there.
std::string attribute_of(const std::string& tag, const std::string& name) {
  const std::string mark = " " + name + "=\"";
  const std::size_t at = tag.find(mark);
  if (at == std::string::npos) return {};
  return tag.substr(at + mark.size(), tag.find('"', at + mark.size()) - at - mark.size());
}

struct Item {
  std::string file, path; // the HDF5 file, and the data set in it
  std::vector<hsize_t> extent;
};
struct Grid {
  double time = -1;
  std::string topology;
  hsize_t cells = 0;
  std::map<std::string, Item> items;       // geometry, topology and attributes by name
  std::map<std::string, std::string> type; // AttributeType and Center of attributes
};

/// Reads the .xdmf, checking that tags are closed in order. On rank 0.
std::vector<Grid> read_xdmf(const std::string& file) {
  const std::string text = read_file(file);
  std::vector<Grid> grids;
  std::vector<std::string> open;
  std::string current;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const std::string tag = text.substr(at + 1, text.find('>', at) - at - 1);
    const std::string content =
        text.substr(at + tag.size() + 2, text.find('<', at + 1) - at - tag.size() - 2);
    const std::string name = tag.substr(0, tag.find_first_of(" /", 1));
    EXPECT_EQ(tag.find('<'), std::string::npos) << tag;
    if (name == "?xml") continue;
    if (name[0] == '/') {
      EXPECT_EQ(open.empty() ? "" : "/" + open.back(), name);
      if (!open.empty()) open.pop_back();
      continue;
    }
    if (!tag.ends_with("/")) open.push_back(name);
    if (name == "Grid" && attribute_of(tag, "GridType") == "Uniform") grids.emplace_back();
    if (name == "Time") grids.back().time = std::stod(attribute_of(tag, "Value"));
    if (name == "Topology") {
      grids.back().topology = attribute_of(tag, "TopologyType");
      grids.back().cells = std::stoul(attribute_of(tag, "NumberOfElements"));
      current = "topology";
    }
    if (name == "Geometry") current = "geometry";
    if (name == "Attribute") {
      current = attribute_of(tag, "Name");
      grids.back().type[current] = attribute_of(tag, "AttributeType") + " " + attribute_of(tag, "Center");
    }
    if (name == "DataItem") {
      Item& item = grids.back().items[current];
      std::istringstream numbers(attribute_of(tag, "Dimensions"));
      for (hsize_t n = 0; numbers >> n;) item.extent.push_back(n);
      item.file = (fs::path(file).parent_path() / content.substr(0, content.find(':'))).string();
      item.path = content.substr(content.find(':') + 1);
    }
  }
  EXPECT_TRUE(open.empty());
  return grids;
}

std::vector<double> numbers(const Item& item) { return hdf5::Reader(item.file).numbers(item.path); }

std::set<std::string> names_in(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

/// Every data set that the .xdmf names exists with its dimensions, and holds the values of the place it
/// belongs to.
void expect_right(const std::string& path, const Mesh& mesh, const std::vector<double>& times) {
  const std::vector<Grid> grids = read_xdmf(path + ".xdmf");
  ASSERT_EQ(grids.size(), times.size());
  const auto nodes = static_cast<hsize_t>(mesh.global_node_count()),
             cells = static_cast<hsize_t>(mesh.global_cell_count());
  for (std::size_t g = 0; g < grids.size(); ++g) {
    const Grid& grid = grids[g];
    EXPECT_EQ(grid.time, times[g]);
    EXPECT_EQ(grid.cells, cells);
    EXPECT_EQ(grid.type, (std::map<std::string, std::string>{{"u", "Vector Node"},
                                                             {"phi", "Scalar Node"},
                                                             {"stress", "Matrix Cell"},
                                                             {"material", "Scalar Cell"}}));
    for (const auto& [name, item] : grid.items)
      EXPECT_EQ(hdf5::Reader(item.file).extent(item.path), item.extent) << name;
    EXPECT_EQ(grid.items.at("u").extent, (std::vector<hsize_t>{nodes, 3}));
    EXPECT_EQ(grid.items.at("stress").extent, (std::vector<hsize_t>{cells, 6}));

    const auto x = numbers(grid.items.at("geometry")), u = numbers(grid.items.at("u"));
    const auto phi = numbers(grid.items.at("phi"));
    for (std::size_t n = 0; n < nodes; ++n) {
      for (int k = 0; k < 3; ++k) {
        const double right =
            k < mesh.dim() ? times[g] * shape_at(x[3 * n], x[3 * n + 1], x[3 * n + 2], k) : 0.0;
        EXPECT_EQ(u[3 * n + static_cast<std::size_t>(k)], right);
      }
      EXPECT_EQ(phi[n], times[g] + x[3 * n]);
    }
    const auto topology = numbers(grid.items.at("topology"));
    const auto stress = numbers(grid.items.at("stress")), material = numbers(grid.items.at("material"));
    const bool mixed = grid.topology == "Mixed";
    const std::map<double, std::size_t> size_of_type = {{4, 3}, {5, 4}, {6, 4}, {9, 8}};
    std::size_t at = 0;
    std::set<std::size_t> used;
    for (std::size_t c = 0; c < cells; ++c) {
      const std::size_t count = mixed ? size_of_type.at(topology[at++]) : 8;
      double centre[3] = {0, 0, 0};
      for (std::size_t a = 0; a < count; ++a, ++at) {
        used.insert(static_cast<std::size_t>(topology[at]));
        for (std::size_t i = 0; i < 3; ++i)
          centre[i] += x[3 * static_cast<std::size_t>(topology[at]) + i] / static_cast<double>(count);
      }
      EXPECT_EQ(material[c], static_cast<double>(count));
      for (int k = 0; k < 6; ++k)
        EXPECT_NEAR(stress[6 * c + static_cast<std::size_t>(k)],
                    times[g] * shape_at(centre[0], centre[1], centre[2], k), 1e-13);
    }
    EXPECT_EQ(at, topology.size());
    EXPECT_EQ(used.size(), nodes);
    EXPECT_EQ(*used.rbegin(), nodes - 1);
  }
}

void check_file(const std::string& path, const Mesh& mesh, const std::vector<double>& times) {
  on_rank_zero(PETSC_COMM_WORLD, [&] { expect_right(path, mesh, times); });
}

TEST(FieldOutput, IsCompleteAfterEveryWriteOnAMixedMesh) {
  const std::string dir = fresh_dir("fields_mixed"), path = dir + "/made/vis";
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(6));
  FieldOutput output(mesh, {path + ".xdmf", "a <\"title\"> & more", "SI: m, kg, s"});
  std::vector<double> times;
  for (const double t : {0.0, 0.1, 1.0 / 3}) {
    write(output, mesh, t);
    times.push_back(t);
    check_file(path, mesh, times);
  }
  on_rank_zero(PETSC_COMM_WORLD, [&] {
    const std::string text = read_file(path + ".xdmf");
    EXPECT_NE(text.find("Value=\"a &lt;&quot;title&quot;&gt; &amp; more\""), std::string::npos);
    EXPECT_NE(text.find("Value=\"SI: m, kg, s\""), std::string::npos);
  });
}

TEST(FieldOutput, WritesHexahedraAsOneTopology) {
  const std::string dir = fresh_dir("fields_hex"), path = dir + "/vis";
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, block(3));
  FieldOutput output(mesh, {path, "", ""});
  write(output, mesh, 0.5);
  check_file(path, mesh, {0.5});
  on_rank_zero(PETSC_COMM_WORLD, [&] {
    EXPECT_EQ(read_xdmf(path + ".xdmf")[0].topology, "Hexahedron");
    EXPECT_EQ(read_xdmf(path + ".xdmf")[0].items.at("topology").extent, (std::vector<hsize_t>{27, 8}));
  });
}

TEST(FieldOutput, RestartDropsLaterTimesAndRepeatsNone) {
  const std::string dir = fresh_dir("fields_restart"), path = dir + "/vis";
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4));
  {
    FieldOutput output(mesh, {path, "", ""});
    for (const double t : {0.0, 0.1, 0.2, 0.3}) write(output, mesh, t);
  }
  FieldOutput output(mesh, {path, "", "", 0.15});
  EXPECT_EQ(output.warning(), "");
  check_file(path, mesh, {0.0, 0.1});
  write(output, mesh, 0.25);
  write(output, mesh, 0.25);
  check_file(path, mesh, {0.0, 0.1, 0.25});
  on_rank_zero(PETSC_COMM_WORLD, [&] {
    EXPECT_EQ(names_in(path + ".fields"),
              (std::set<std::string>{"mesh_0.h5", "000000.h5", "000001.h5", "000002.h5"}));
  });
}

TEST(FieldOutput, ANewRunLeavesNoFilesOfAnEarlierOne) {
  const std::string dir = fresh_dir("fields_anew"), path = dir + "/vis";
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4));
  {
    FieldOutput output(mesh, {path, "", ""});
    for (const double t : {0.0, 0.1, 0.2}) write(output, mesh, t);
    on_rank_zero(PETSC_COMM_WORLD, [&] {
      for (const char* name : {"000003.h5.tmp", "000003.h5.space", "mesh_1.h5.tmp", "notes.txt"})
        std::ofstream(path + ".fields/" + name) << "x";
    });
  }
  FieldOutput anew(mesh, {path, "", ""});
  on_rank_zero(PETSC_COMM_WORLD, [&] { EXPECT_FALSE(fs::exists(path + ".xdmf")); });
  write(anew, mesh, 0.7);
  check_file(path, mesh, {0.7});
  on_rank_zero(PETSC_COMM_WORLD, [&] {
    EXPECT_EQ(names_in(path + ".fields"), (std::set<std::string>{"mesh_0.h5", "000000.h5", "notes.txt"}));
  });
}

/// Ends the process without any of its clean-up when somebody reads the values.
class DeadlyValues {
public:
  explicit DeadlyValues(std::size_t count)
      : count_(count),
        at_(mmap(nullptr, count * sizeof(double), PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)) {
    std::signal(SIGSEGV, SIG_DFL);
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
  }
  std::span<const double> span() const { return {static_cast<const double*>(at_), count_}; }

private:
  std::size_t count_;
  void* at_;
};

/// Runs `body` in a copy of this process; 0 when it came to its end.
int signal_that_ended(const std::function<void()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    body();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

// On one rank, as the process that dies is a copy of this one. reliability_kills_fields.py kills
// at every call.
TEST(FieldOutput, AKilledWriteLeavesTheEarlierTimesAndIsMadeUpFor) {
  const std::string dir = fresh_dir("fields_killed"), path = dir + "/vis";
  if (rank_of(PETSC_COMM_WORLD) == 0) {
    const Mesh mesh = mesh_of(PETSC_COMM_SELF, dir, two_bodies(12));
    {
      FieldOutput output(mesh, {path, "", ""});
      for (const double t : {0.0, 0.1}) write(output, mesh, t);
      for (const std::size_t last : {1U, 0U}) {
        const auto killed_write = [&] {
          const Fields fields(mesh, 0.2);
          const DeadlyValues deadly((last == 1 ? 6U : 1U) * static_cast<std::size_t>(mesh.cell_count()));
          std::vector<Field> all = fields.all(mesh.dim());
          all[3 - last].values = deadly.span();
          output.write(0.2, all);
        };
        EXPECT_EQ(signal_that_ended(killed_write), SIGSEGV);
        expect_right(path, mesh, {0.0, 0.1});
      }
    }
    FieldOutput resumed(mesh, {path, "", "", 0.15});
    EXPECT_EQ(resumed.warning(), "");
    EXPECT_EQ(names_in(path + ".fields"), (std::set<std::string>{"mesh_0.h5", "000000.h5", "000001.h5"}));
    write(resumed, mesh, 0.2);
    expect_right(path, mesh, {0.0, 0.1, 0.2});
  }
  MPI_Barrier(PETSC_COMM_WORLD);
}

TEST(FieldOutput, RestartTakesUpATimeThatTheXdmfDoesNotNameYet) {
  const std::string dir = fresh_dir("fields_unnamed"), path = dir + "/vis";
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4));
  {
    FieldOutput output(mesh, {path, "", ""});
    write(output, mesh, 0.0);
    on_rank_zero(PETSC_COMM_WORLD, [&] { fs::copy_file(path + ".xdmf", dir + "/before.xdmf"); });
    write(output, mesh, 0.1);
    on_rank_zero(PETSC_COMM_WORLD, [&] { fs::rename(dir + "/before.xdmf", path + ".xdmf"); });
  }
  check_file(path, mesh, {0.0});
  FieldOutput output(mesh, {path, "", "", 0.1});
  check_file(path, mesh, {0.0, 0.1});
}

TEST(FieldOutput, ContinuesAFileOfAnotherNumberOfRanks) {
  const std::string dir = fresh_dir("fields_ranks"), path = dir + "/vis";
  if (rank_of(PETSC_COMM_WORLD) == 0) {
    const Mesh alone = mesh_of(PETSC_COMM_SELF, dir, two_bodies(4));
    FieldOutput output(alone, {path, "", ""});
    write(output, alone, 0.0);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4));
  FieldOutput output(mesh, {path, "", "", 0.0});
  write(output, mesh, 0.1);
  check_file(path, mesh, {0.0, 0.1});
}

TEST(FieldOutput, SetsADamagedFileAsideAndKeepsTheOtherTimes) {
  const std::string dir = fresh_dir("fields_damaged"), path = dir + "/vis";
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4));
  {
    FieldOutput output(mesh, {path, "", ""});
    for (const double t : {0.0, 0.1, 0.2}) write(output, mesh, t);
  }
  // The mesh is written anew, and what was written on it belongs to it.
  for (const std::string name : {"000001.h5", "mesh_0.h5"}) {
    const std::string damaged = path + ".fields/" + name;
    on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(damaged) << "not HDF5"; });
    FieldOutput output(mesh, {path, "", "", 0.5});
    EXPECT_NE(output.warning().find("it was kept as " + damaged + ".damaged"), std::string::npos)
        << output.warning();
    check_file(path, mesh, {0.0, 0.2});
    on_rank_zero(PETSC_COMM_WORLD, [&] { EXPECT_EQ(read_file(damaged + ".damaged"), "not HDF5"); });
  }
}

TEST(FieldOutput, SaysOnAllRanksThatItCannotWrite) {
  const std::string dir = fresh_dir("fields_refused");
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4));
  on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(dir + "/file") << "x"; });
  const std::string message = io_error_of([&] { FieldOutput(mesh, {dir + "/file/vis", "", ""}); });
  EXPECT_NE(message.find(dir + "/file"), std::string::npos) << message;
  FieldOutput output(mesh, {dir + "/vis", "", ""});
  on_rank_zero(PETSC_COMM_WORLD, [&] { fs::remove_all(dir + "/vis.fields"); });
  EXPECT_NE(io_error_of([&] { write(output, mesh, 0.0); }).find(dir + "/vis.fields/000000.h5"),
            std::string::npos);
}

TEST(FieldOutput, KeepsTheOldTimesWhenTheDiskIsFullAndGoesOnLater) {
  const std::string dir = fresh_dir("fields_full"), path = dir + "/vis";
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(40));
  FieldOutput output(mesh, {path, "", ""});
  write(output, mesh, 0.1);
  {
    const FileSizeLimit limit(20000);
    const std::string message = io_error_of([&] { write(output, mesh, 0.2); });
    EXPECT_NE(message.find(path + ".fields/000001.h5"), std::string::npos) << message;
    EXPECT_NE(message.find("File too large"), std::string::npos) << message;
    check_file(path, mesh, {0.1});
  }
  write(output, mesh, 0.3);
  check_file(path, mesh, {0.1, 0.3});
}

TEST(FieldOutput, RefusesFieldsOfTheWrongSize) {
  const std::string dir = fresh_dir("fields_size");
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(4));
  FieldOutput output(mesh, {dir + "/vis", "", ""});
  const std::vector<double> values(3);
  EXPECT_THROW(output.write(0, {{"u", true, 2, values}}), std::logic_error);
  EXPECT_THROW(output.write(0, {{"a/b", false, 1, values}}), std::logic_error);
}

TEST(CellsInMeshOrder, BringsEachValueToItsCell) {
  const std::string dir = fresh_dir("fields_order");
  const Mesh mesh = mesh_of(PETSC_COMM_WORLD, dir, two_bodies(5));
  std::vector<int> material(static_cast<std::size_t>(mesh.cell_count()), 0);
  for (const PetscInt p : mesh.region_cells("upper"))
    material[static_cast<std::size_t>(p - mesh.cell_start())] = 1;
  const std::vector<CellGroup> groups = pack_cells(mesh, material);
  std::vector<double> by_batch;
  for (const CellGroup& g : groups)
    for (int b = 0; b < g.batch_count; ++b)
      for (int k = 0; k < 2; ++k)
        for (int l = 0; l < lanes; ++l)
          by_batch.push_back(
              k + 10.0 * static_cast<double>(g.cell_point[static_cast<std::size_t>(b * lanes + l)]));
  std::vector<double> expected;
  for (const CellTable& table : mesh.cells())
    for (const PetscInt point : table.point)
      for (int k = 0; k < 2; ++k) expected.push_back(k + 10.0 * static_cast<double>(point));
  EXPECT_EQ(cells_in_mesh_order(mesh, groups, 2, by_batch), expected);
}

} // namespace
} // namespace impact
