#pragma once
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <string>
#include <sys/resource.h>
#include <vector>

/// Small meshes and an empty directory per test, for tests of what a run writes.
namespace impact::run_test {

inline int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

/// The folder of one run of the test program, so that runs at the same time do not meet; it goes with the
/// program.
class RunFolder {
public:
  RunFolder() {
    on_rank_zero(PETSC_COMM_WORLD, [&] {
      std::string name = (std::filesystem::temp_directory_path() / "impact_test_XXXXXX").string();
      if (mkdtemp(name.data()) == nullptr) throw UserError(ExitCode::io, "cannot make the folder " + name);
      made_ = name;
    });
    path_ = broadcast(PETSC_COMM_WORLD, made_);
  }
  ~RunFolder() {
    std::error_code ignored;
    if (!made_.empty()) std::filesystem::remove_all(made_, ignored);
  }
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

private:
  std::string made_; // on the rank that made it
  std::filesystem::path path_;
};

/// An empty directory that all ranks know, of this run alone. Collective.
inline std::string fresh_dir(const std::string& name) {
  static const RunFolder folder;
  const auto dir = folder.path() / name;
  MPI_Barrier(PETSC_COMM_WORLD); // another rank may still read what the last test left there
  on_rank_zero(PETSC_COMM_WORLD, [&] {
    std::filesystem::remove_all(dir);
    std::filesystem::create_directories(dir);
  });
  return dir.string();
}

/// For its lifetime a file of this process cannot grow beyond `bytes`: writes fail as on a full disk.
class FileSizeLimit {
public:
  explicit FileSizeLimit(std::size_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
  void (*handler_)(int);
  rlimit before_{};
};

struct GmshText {
  std::string nodes, elements;
  int node_count = 0, element_count = 0;

  int node(double x, double y, double z = 0) {
    nodes += std::to_string(++node_count) + " " + std::to_string(x) + " " + std::to_string(y) + " " +
             std::to_string(z) + "\n";
    return node_count;
  }
  void element(int type, int group, const std::vector<int>& list) {
    elements += std::to_string(++element_count) + " " + std::to_string(type) + " 2 " + std::to_string(group) +
                " " + std::to_string(group);
    for (const int n : list) elements += " " + std::to_string(n);
    elements += "\n";
  }
  std::string text(const std::string& names) const {
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n" + names + "$EndPhysicalNames\n$Nodes\n" +
           std::to_string(node_count) + "\n" + nodes + "$EndNodes\n$Elements\n" +
           std::to_string(element_count) + "\n" + elements + "$EndElements\n";
  }
};

/// Quadrilaterals "lower" under triangles "upper", each with its own nodes on the line between them;
/// boundaries "lower top" (n edges) and "upper_bottom". `shift` moves the upper body to the right.
inline std::string two_bodies(int n, double shift = 0) {
  GmshText mesh;
  for (int body = 0; body < 2; ++body) {
    const double left = body == 0 ? 0 : shift;
    std::vector<int> id;
    for (int j = 0; j <= 2; ++j)
      for (int i = 0; i <= n; ++i) id.push_back(mesh.node(left + 0.25 * i, 0.25 * j + 0.5 * body));
    const auto at = [&](int i, int j) { return id[static_cast<std::size_t>(j * (n + 1) + i)]; };
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < n; ++i) {
        if (body == 0)
          mesh.element(3, 1, {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        else {
          mesh.element(2, 2, {at(i, j), at(i + 1, j), at(i + 1, j + 1)});
          mesh.element(2, 2, {at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
      }
    for (int i = 0; i < n; ++i)
      mesh.element(1, body == 0 ? 3 : 4, {at(i, body == 0 ? 2 : 0), at(i + 1, body == 0 ? 2 : 0)});
  }
  return mesh.text("4\n2 1 \"lower\"\n2 2 \"upper\"\n1 3 \"lower top\"\n1 4 \"upper_bottom\"\n");
}

/// A block of n x n x n hexahedra "block" with the boundary "top".
inline std::string block(int n) {
  GmshText mesh;
  std::vector<int> id;
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) id.push_back(mesh.node(0.5 * i, 0.5 * j, 0.5 * k));
  const auto at = [&](int i, int j, int k) {
    return id[static_cast<std::size_t>((k * (n + 1) + j) * (n + 1) + i)];
  };
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        mesh.element(5, 1,
                     {at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k), at(i, j, k + 1),
                      at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)});
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      mesh.element(3, 2, {at(i, j, n), at(i + 1, j, n), at(i + 1, j + 1, n), at(i, j + 1, n)});
  return mesh.text("2\n3 1 \"block\"\n2 2 \"top\"\n");
}

/// Writes a mesh file and reads it on `comm`; its cells in the regions `patched` share their volume in
/// patches. Collective on PETSC_COMM_WORLD or on a part of it with its rank 0.
inline Mesh mesh_of(MPI_Comm comm, const std::string& dir, const std::string& text, int order = 0,
                    const std::vector<std::vector<std::string>>& patched = {}) {
  const std::string file = dir + "/mesh.msh";
  on_rank_zero(comm, [&] { std::ofstream(file) << text; });
  MeshRequest request;
  request.file = file;
  request.work_dir = dir;
  request.order = order;
  request.patched = patched;
  return read_mesh(comm, request);
}

} // namespace impact::run_test
