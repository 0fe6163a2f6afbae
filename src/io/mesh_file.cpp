#include <algorithm>
#include <impact/io/mesh_file.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/log.hpp>
#include <limits>

namespace impact {

namespace {

constexpr const char* version = "impact mesh 1";

/// One rank's look at a file; whatever is wrong with it is a UserError(io) with the remedy.
class Part {
public:
  Part(const std::string& name, int rank, int ranks) : file_(name), rank_(rank), ranks_(ranks) {}

  GmshFile read() const {
    GmshFile mesh;
    set_head(mesh, head());
    const std::vector<hsize_t> nodes = extent("/mesh/nodes"), cells = extent("/mesh/cells"),
                               boundary = extent("/mesh/boundary");
    if (nodes[1] != 3 || cells[0] < 1 || cells[1] < 2 || cells[1] > 1 + max_nodes ||
        boundary[1] != cells[1] + 1 || nodes[0] > static_cast<hsize_t>(std::numeric_limits<int>::max()))
      throw UserError(ExitCode::data, "its data sets have other sizes than those of a mesh");
    const hsize_t first = begin(cells[0], rank_), last = begin(cells[0], rank_ + 1);
    const hsize_t from = first_behind(boundary[0], first), to = first_behind(boundary[0], last);
    mesh.x = file_.rows("/mesh/nodes", begin(nodes[0], rank_),
                        begin(nodes[0], rank_ + 1) - begin(nodes[0], rank_));
    set_rows(mesh, {at(cells[1]), integers("/mesh/cells", first, last), integers("/mesh/boundary", from, to)},
             static_cast<std::int64_t>(nodes[0]));
    return mesh;
  }

private:
  hsize_t begin(hsize_t all, int rank) const {
    return static_cast<hsize_t>(part_begin(static_cast<std::int64_t>(all), rank, ranks_));
  }
  std::string head() const {
    if (!file_.has("/mesh") || !file_.has("/mesh/about"))
      throw UserError(ExitCode::data, "it holds no mesh of impact (/mesh/about is missing)");
    const std::string about = file_.text("/mesh/about"), first = about.substr(0, about.find('\n'));
    if (first != version)
      throw UserError(ExitCode::data,
                      first.starts_with("impact mesh ")
                          ? "it was written by another version of impact (" + first.substr(7) +
                                ", this one reads " + (version + 7) + ")"
                          : "it holds no mesh of impact (/mesh/about does not begin with a version)");
    return about.substr(std::min(about.size(), first.size() + 1));
  }
  std::vector<hsize_t> extent(const std::string& path) const {
    if (!file_.has(path)) throw UserError(ExitCode::data, path + " is missing");
    std::vector<hsize_t> extent = file_.extent(path);
    if (extent.size() != 2) throw UserError(ExitCode::data, path + " is no table");
    return extent;
  }
  std::vector<std::int64_t> integers(const std::string& path, hsize_t first, hsize_t last) const {
    const std::vector<double> numbers = file_.rows(path, first, last - first);
    return {numbers.begin(), numbers.end()};
  }
  /// The first of the elements of boundaries whose cell is not before `cell`: they stand by rising cell.
  hsize_t first_behind(hsize_t elements, hsize_t cell) const {
    hsize_t low = 0;
    while (low < elements) {
      const hsize_t middle = low + (elements - low) / 2;
      if (file_.rows("/mesh/boundary", middle, 1)[0] < static_cast<double>(cell))
        low = middle + 1;
      else
        elements = middle;
    }
    return low;
  }

  hdf5::Reader file_;
  int rank_, ranks_;
};

} // namespace

StoredMesh::StoredMesh(MPI_Comm comm, const GmshFile& mesh)
    : comm_(comm), mesh_(mesh), about_(std::string(version) + "\n" + head_of(mesh)),
      rows_(rows_of(comm, mesh)), nodes_(comm, mesh.x.size() / 3),
      cells_(comm, rows_.cells.size() / rows_.width),
      boundary_(comm, rows_.boundary.size() / (1 + rows_.width)) {}

std::vector<hdf5::DataSet> StoredMesh::data_sets() const {
  return {hdf5::whole(comm_, "/mesh/about", about_), hdf5::rows("/mesh/nodes", nodes_, 3, mesh_.x),
          hdf5::rows("/mesh/cells", cells_, rows_.width, rows_.cells),
          hdf5::rows("/mesh/boundary", boundary_, 1 + rows_.width, rows_.boundary)};
}

std::uint64_t write_mesh_file(MPI_Comm comm, const std::string& name, const GmshFile& mesh) {
  const StoredMesh stored(comm, mesh);
  const std::vector<hdf5::DataSet> sets = stored.data_sets();
  hdf5::write_file(comm, name, sets);
  return sets[2].extent[0];
}

GmshFile read_stored_mesh(MPI_Comm comm, const std::string& name) {
  const Timed timed(Event::mesh_read);
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  GmshFile mesh;
  agree_on_errors(comm, [&] {
    try {
      mesh = Part(name, rank, ranks).read();
    } catch (const UserError& error) {
      if (error.code() != ExitCode::data) throw;
      throw UserError(ExitCode::io,
                      "cannot use " + name + ": " + error.what() +
                          "; allowed: a file that -mesh_convert of this version wrote: make it anew "
                          "from the .msh or .geo");
    }
  });
  return mesh;
}

} // namespace impact
