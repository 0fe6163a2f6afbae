#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <impact/petsc/error.hpp>
#include <impact/run/durable_file.hpp>
#include <impact/run/field_output.hpp>
#include <impact/run/hdf5_file.hpp>
#include <impact/run/xdmf.hpp>

namespace impact {

namespace {

constexpr std::size_t piece = std::size_t{1}
                              << 22; // values per message: counts stay far below what an int holds

/// Hands every rank's values, rank by rank and in pieces, to `sink` on rank 0. `sink` must not throw.
/// Collective.
template <class T>
void collect(MPI_Comm comm, const std::vector<T>& mine,
             const std::function<void(const T*, std::size_t)>& sink) {
  constexpr bool real = std::is_same_v<T, double>;
  const MPI_Datatype type = real ? MPI_DOUBLE : MPI_INT64_T;
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const std::int64_t count = static_cast<std::int64_t>(mine.size());
  std::vector<std::int64_t> counts(static_cast<std::size_t>(size));
  MPI_Gather(&count, 1, MPI_INT64_T, counts.data(), 1, MPI_INT64_T, 0, comm);
  if (rank != 0) {
    for (std::size_t done = 0; done < mine.size(); done += piece)
      MPI_Send(mine.data() + done, static_cast<int>(std::min(piece, mine.size() - done)), type, 0, 0, comm);
    return;
  }
  for (std::size_t done = 0; done < mine.size(); done += piece)
    sink(mine.data() + done, std::min(piece, mine.size() - done));
  std::vector<T> buffer;
  for (int r = 1; r < size; ++r) {
    const auto total = static_cast<std::size_t>(counts[static_cast<std::size_t>(r)]);
    for (std::size_t done = 0; done < total; done += piece) {
      buffer.resize(std::min(piece, total - done));
      MPI_Recv(buffer.data(), static_cast<int>(buffer.size()), type, r, 0, comm, MPI_STATUS_IGNORE);
      sink(buffer.data(), buffer.size());
    }
  }
}

constexpr std::uint64_t margin = 1 << 16; // bytes for HDF5's own records and the .xdmf

// Vectors of plane problems get a third component.
constexpr unsigned stored_width(int components) {
  return components == 2 ? 3U : static_cast<unsigned>(components);
}

int xdmf_type(Shape shape) {
  switch (shape) {
  case Shape::tri3:
    return 4;
  case Shape::quad4:
    return 5;
  case Shape::tet4:
    return 6;
  default:
    return 9;
  }
}

const char* xdmf_name(Shape shape) {
  switch (shape) {
  case Shape::tri3:
    return "Triangle";
  case Shape::quad4:
    return "Quadrilateral";
  case Shape::tet4:
    return "Tetrahedron";
  default:
    return "Hexahedron";
  }
}

std::vector<Shape> shapes_on_any_rank(const Mesh& mesh) {
  std::vector<Shape> shapes;
  for (const Shape s : {Shape::tri3, Shape::quad4, Shape::tet4, Shape::hex8})
    if (mesh.has_shape(s)) shapes.push_back(s);
  return shapes;
}

/// Global node numbers of all cells of this rank; in a mixed mesh each cell begins with its XDMF type.
std::vector<std::int64_t> connectivity(const Mesh& mesh, bool mixed) {
  std::vector<std::int64_t> list;
  for (const CellTable& table : mesh.cells()) {
    const auto nodes = static_cast<std::size_t>(node_count(table.shape));
    for (std::size_t c = 0; c < table.point.size(); ++c) {
      if (mixed) list.push_back(xdmf_type(table.shape));
      for (std::size_t a = 0; a < nodes; ++a)
        list.push_back(mesh.global_node()[static_cast<std::size_t>(table.connectivity[c * nodes + a])]);
    }
  }
  return list;
}

std::string frame_group(int number) {
  char name[32];
  std::snprintf(name, sizeof name, "/fields/%06d", number);
  return name;
}

std::string without_extension(const std::string& path) {
  return path.ends_with(".xdmf") ? path.substr(0, path.size() - 5) : path;
}

} // namespace

/// `nodes_in_order` and the counts hold on every rank; files and the list of what they contain live on rank
/// 0.
struct FieldOutput::Impl {
  MPI_Comm comm = MPI_COMM_NULL;
  int rank = 0;
  std::string path; // without extension
  XdmfFile xdmf;
  std::vector<int> nodes_in_order; // owned local nodes by global number
  std::size_t node_count = 0, cell_count = 0;
  std::uint64_t global_nodes = 0, global_cells = 0;
  int mesh_number = 0, next_frame = 0;

  std::string h5() const { return path + ".h5"; }
  void take_numbering(const Mesh& mesh);
  std::vector<double> owned_values(const double* values, int components, int width) const;
  std::string resume(double after, std::uint64_t mesh_sum);
  void read_meshes(const hdf5::File& file);
  void read_frames(hdf5::File& file, double after);
  void write_mesh(const Mesh& mesh, std::uint64_t sum);
  template <class T>
  void write_dataset(hdf5::File* file, std::string& failure, const std::string& name, hsize_t width,
                     hsize_t rows, const std::vector<T>& mine) const;
  void write_fields(hdf5::File* file, std::string& failure, XdmfFrame& frame,
                    const std::vector<NodeField>& nodes, const std::vector<CellField>& cells) const;
  void replace_xdmf() const { replace_file(path + ".xdmf", xdmf.text()); }
};

void FieldOutput::Impl::take_numbering(const Mesh& mesh) {
  node_count = static_cast<std::size_t>(mesh.node_count());
  cell_count = static_cast<std::size_t>(mesh.cell_count());
  global_nodes = static_cast<std::uint64_t>(mesh.global_node_count());
  global_cells = static_cast<std::uint64_t>(mesh.global_cell_count());
  for (int n = 0; n < mesh.node_count(); ++n)
    if (mesh.owned(n)) nodes_in_order.push_back(n);
  std::sort(nodes_in_order.begin(), nodes_in_order.end(), [&](int a, int b) {
    return mesh.global_node()[static_cast<std::size_t>(a)] < mesh.global_node()[static_cast<std::size_t>(b)];
  });
}

/// Values of owned nodes in global order, rows widened with zeros from `components` to `width`.
std::vector<double> FieldOutput::Impl::owned_values(const double* values, int components, int width) const {
  std::vector<double> rows;
  rows.reserve(nodes_in_order.size() * static_cast<std::size_t>(width));
  for (const int n : nodes_in_order) {
    rows.insert(rows.end(), values + std::ptrdiff_t{n} * components,
                values + std::ptrdiff_t{n + 1} * components);
    rows.resize(rows.size() + static_cast<std::size_t>(width - components), 0.0);
  }
  return rows;
}

/// One data set from the values of all ranks. `file` is null on the other ranks and after a failure; rank 0
/// receives what is sent to it in any case, or the others would wait for ever. Collective.
template <class T>
void FieldOutput::Impl::write_dataset(hdf5::File* file, std::string& failure, const std::string& name,
                                      hsize_t width, hsize_t rows, const std::vector<T>& mine) const {
  constexpr bool real = std::is_same_v<T, double>;
  hdf5::Id dataset;
  hsize_t next = 0;
  const auto guarded = [&](const auto& body) {
    if (!file || !failure.empty()) return;
    try {
      body();
    } catch (const std::exception& error) {
      failure = error.what();
    }
  };
  guarded([&] {
    const std::vector<hsize_t> extent =
        width == 1 ? std::vector<hsize_t>{rows} : std::vector<hsize_t>{rows, width};
    dataset = file->make_dataset(name, real ? H5T_IEEE_F64LE : H5T_STD_I64LE, extent);
  });
  // A row may be cut between two pieces, so whole rows are put together first.
  std::vector<T> pending;
  collect<T>(comm, mine, [&](const T* values, std::size_t count) {
    guarded([&] {
      pending.insert(pending.end(), values, values + count);
      const hsize_t whole = pending.size() / width;
      file->write_slab(dataset, real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, next, whole, pending.data());
      pending.erase(pending.begin(), pending.begin() + static_cast<std::ptrdiff_t>(whole * width));
      next += whole;
    });
  });
}

void FieldOutput::Impl::write_mesh(const Mesh& mesh, std::uint64_t sum) {
  const std::vector<Shape> shapes = shapes_on_any_rank(mesh);
  const bool mixed = shapes.size() > 1;
  const std::vector<std::int64_t> cells = connectivity(mesh, mixed);
  std::int64_t mine = static_cast<std::int64_t>(cells.size()), length = 0;
  MPI_Allreduce(&mine, &length, 1, MPI_INT64_T, MPI_SUM, comm);
  const hsize_t width = mixed ? 1 : static_cast<hsize_t>(impact::node_count(shapes.at(0)));

  const std::string group = "/mesh/" + std::to_string(mesh_number);
  std::unique_ptr<hdf5::File> file;
  std::string failure;
  on_rank_zero(comm, [&] {
    require_space(h5(), margin + sizeof(double) * (3 * global_nodes + static_cast<std::uint64_t>(length)));
    file = std::make_unique<hdf5::File>(h5(), std::filesystem::exists(h5()) ? hdf5::File::Mode::update
                                                                            : hdf5::File::Mode::create);
  });
  write_dataset(file.get(), failure, group + "/geometry", 3, global_nodes,
                owned_values(mesh.coordinates().data(), mesh.dim(), 3));
  write_dataset(file.get(), failure, group + "/topology", width, static_cast<hsize_t>(length) / width, cells);
  on_rank_zero(comm, [&] {
    if (!failure.empty()) throw UserError(ExitCode::io, failure);
    XdmfMesh entry{group, mixed ? "Mixed" : xdmf_name(shapes[0]), global_nodes, global_cells,
                   static_cast<std::uint64_t>(length)};
    file->write(group + "/cells", entry.cell_type);
    file->set_attribute(group, "cell_count", static_cast<double>(global_cells));
    file->write(group + "/checksum", to_hex(sum)); // last: it says that the rest is there
    file->close();
    xdmf.meshes.push_back(entry);
  });
}

void FieldOutput::Impl::read_meshes(const hdf5::File& file) {
  for (int m = 0;; ++m) {
    const std::string group = "/mesh/" + std::to_string(m);
    if (!file.has(group + "/checksum")) return;
    const auto topology = file.extent(group + "/topology");
    std::uint64_t length = 1;
    for (const hsize_t n : topology) length *= n;
    xdmf.meshes.push_back({group, file.read_text(group + "/cells"), file.extent(group + "/geometry").at(0),
                           static_cast<std::uint64_t>(file.attribute(group, "cell_count", 0)), length});
  }
}

/// Times up to `after` are taken into the list; later ones, and one that a kill left unfinished, are removed.
void FieldOutput::Impl::read_frames(hdf5::File& file, double after) {
  for (const std::string& name : file.list("/fields")) {
    const std::string group = "/fields/" + name;
    const double time = file.attribute(group, "time", after + 1), mesh = file.attribute(group, "mesh", -1);
    if (!(time <= after) || mesh < 0 || mesh >= static_cast<double>(xdmf.meshes.size())) {
      file.remove(group);
      continue;
    }
    XdmfFrame frame{time, group, static_cast<std::size_t>(mesh), {}};
    for (const bool on_nodes : {true, false})
      for (const std::string& field : file.list(group + (on_nodes ? "/node" : "/cell"))) {
        const auto extent = file.extent(group + (on_nodes ? "/node/" : "/cell/") + field);
        frame.fields.push_back({field, on_nodes, extent.size() > 1 ? static_cast<int>(extent[1]) : 1});
      }
    next_frame = std::max(next_frame, std::stoi(name) + 1);
    xdmf.frames.push_back(std::move(frame));
  }
}

/// Takes up the old file, on rank 0; returns a warning when it could not be read and was set aside.
std::string FieldOutput::Impl::resume(double after, std::uint64_t mesh_sum) {
  mesh_number = -1;
  try {
    hdf5::File file(h5(), hdf5::File::Mode::update);
    read_meshes(file);
    read_frames(file, after);
    for (std::size_t m = 0; m < xdmf.meshes.size(); ++m)
      if (file.read_text(xdmf.meshes[m].group + "/checksum") == to_hex(mesh_sum))
        mesh_number = static_cast<int>(m);
    // What a kill left of a mesh that was being written.
    const std::string unfinished = "/mesh/" + std::to_string(xdmf.meshes.size());
    if (file.has(unfinished)) file.remove(unfinished);
    file.close();
    return {};
  } catch (const std::exception& error) {
    xdmf.meshes.clear();
    xdmf.frames.clear();
    mesh_number = -1;
    next_frame = 0;
    std::string aside;
    for (int k = 1; aside.empty() || std::filesystem::exists(aside); ++k)
      aside = path + ".damaged-" + std::to_string(k) + ".h5";
    rename_durably(h5(), aside);
    return std::string(error.what()) + "; it was kept as " + aside +
           ", the field output starts anew from here";
  }
}

FieldOutput::FieldOutput(const Mesh& mesh, const FieldFile& file) : impl_(std::make_unique<Impl>()) {
  Impl& self = *impl_;
  self.comm = mesh.comm();
  MPI_Comm_rank(self.comm, &self.rank);
  self.path = without_extension(file.path);
  self.take_numbering(mesh);

  // The checksums of the ranks, in their order: another distribution has another numbering and needs its own
  // mesh.
  Checksum mine;
  const auto points = self.owned_values(mesh.coordinates().data(), mesh.dim(), 3);
  const auto cells = connectivity(mesh, true);
  mine.add(points.data(), points.size() * sizeof(double));
  mine.add(cells.data(), cells.size() * sizeof(std::int64_t));
  const std::uint64_t value = mine.value();
  int size = 1;
  MPI_Comm_size(self.comm, &size);
  std::vector<std::uint64_t> all(static_cast<std::size_t>(size));
  MPI_Gather(&value, 1, MPI_UINT64_T, all.data(), 1, MPI_UINT64_T, 0, self.comm);
  Checksum whole;
  whole.add(all.data(), all.size() * sizeof(std::uint64_t));

  int write_the_mesh = 0;
  on_rank_zero(self.comm, [&] {
    const std::filesystem::path target(self.path);
    make_directories(target.parent_path().string());
    self.xdmf.title = file.title;
    self.xdmf.units = file.units;
    self.xdmf.data_file = target.filename().string() + ".h5";
    if (file.resume_after && std::filesystem::exists(self.h5())) {
      warning_ = self.resume(*file.resume_after, whole.value());
    } else {
      std::filesystem::remove(self.path + ".xdmf");
      hdf5::File(self.h5(), hdf5::File::Mode::create).close();
      self.mesh_number = -1;
    }
    write_the_mesh = self.mesh_number < 0 ? 1 : 0;
    if (write_the_mesh != 0) self.mesh_number = static_cast<int>(self.xdmf.meshes.size());
  });
  warning_ = broadcast(self.comm, warning_);
  MPI_Bcast(&write_the_mesh, 1, MPI_INT, 0, self.comm);
  if (write_the_mesh != 0) self.write_mesh(mesh, whole.value());
  on_rank_zero(self.comm, [&] {
    if (!self.xdmf.frames.empty()) self.replace_xdmf();
  });
}

FieldOutput::FieldOutput(FieldOutput&&) noexcept = default;
FieldOutput& FieldOutput::operator=(FieldOutput&&) noexcept = default;
FieldOutput::~FieldOutput() = default;

void FieldOutput::Impl::write_fields(hdf5::File* file, std::string& failure, XdmfFrame& frame,
                                     const std::vector<NodeField>& nodes,
                                     const std::vector<CellField>& cells) const {
  for (const NodeField& field : nodes) {
    const int width = static_cast<int>(stored_width(field.components));
    write_dataset(file, failure, frame.group + "/node/" + field.name, static_cast<hsize_t>(width),
                  global_nodes, owned_values(field.values.data(), field.components, width));
    frame.fields.push_back({field.name, true, width});
  }
  for (const CellField& field : cells) {
    const int width = static_cast<int>(stored_width(field.components));
    std::vector<double> rows;
    rows.reserve(cell_count * static_cast<std::size_t>(width));
    for (std::size_t c = 0; c < cell_count; ++c) {
      const double* row = field.values.data() + c * static_cast<std::size_t>(field.components);
      rows.insert(rows.end(), row, row + field.components);
      rows.resize(rows.size() + static_cast<std::size_t>(width - field.components), 0.0);
    }
    write_dataset(file, failure, frame.group + "/cell/" + field.name, static_cast<hsize_t>(width),
                  global_cells, rows);
    frame.fields.push_back({field.name, false, width});
  }
}

void FieldOutput::write(double time, const std::vector<NodeField>& nodes,
                        const std::vector<CellField>& cells) {
  Impl& self = *impl_;
  const auto fits = [](const auto& field, std::size_t entities) {
    return field.components > 0 &&
           field.values.size() == entities * static_cast<std::size_t>(field.components) &&
           !field.name.empty() && field.name.find('/') == std::string::npos;
  };
  const bool good =
      std::all_of(nodes.begin(), nodes.end(), [&](const NodeField& f) { return fits(f, self.node_count); }) &&
      std::all_of(cells.begin(), cells.end(), [&](const CellField& f) { return fits(f, self.cell_count); });
  if (!all_ranks_agree(self.comm, good))
    throw std::logic_error("field output: a field has a wrong size or an impossible name");

  XdmfFrame frame{time, frame_group(self.next_frame), static_cast<std::size_t>(self.mesh_number), {}};
  std::unique_ptr<hdf5::File> file;
  std::string failure;
  // HDF5 does not survive a disk that fills while it writes, so the space is asked for before the file is
  // touched.
  std::uint64_t bytes = margin;
  for (const NodeField& f : nodes) bytes += sizeof(double) * self.global_nodes * stored_width(f.components);
  for (const CellField& f : cells) bytes += sizeof(double) * self.global_cells * stored_width(f.components);
  on_rank_zero(self.comm, [&] {
    require_space(self.h5(), bytes);
    file = std::make_unique<hdf5::File>(self.h5(), hdf5::File::Mode::update);
    if (file->has(frame.group)) file->remove(frame.group); // left by a write that failed
    file->make_group(frame.group);
  });
  self.write_fields(file.get(), failure, frame, nodes, cells);
  on_rank_zero(self.comm, [&] {
    if (!failure.empty()) throw UserError(ExitCode::io, failure);
    auto& frames = self.xdmf.frames;
    for (std::size_t k = 0; k < frames.size(); ++k)
      if (frames[k].time == time) {
        file->remove(frames[k].group);
        frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(k));
        break;
      }
    file->set_attribute(frame.group, "mesh", self.mesh_number);
    file->set_attribute(frame.group, "time", time);
    file->close();
    frames.push_back(frame);
    self.replace_xdmf();
  });
  ++self.next_frame;
}

std::vector<double> cells_in_mesh_order(const Mesh& mesh, const std::vector<CellGroup>& groups,
                                        int components, std::span<const double> by_batch) {
  std::vector<std::size_t> place(static_cast<std::size_t>(mesh.cell_count()));
  std::size_t next = 0;
  for (const CellTable& table : mesh.cells())
    for (const PetscInt point : table.point)
      place[static_cast<std::size_t>(point - mesh.cell_start())] = next++;

  const auto width = static_cast<std::size_t>(components);
  std::vector<double> values(place.size() * width, 0.0);
  std::size_t batch = 0;
  for (const CellGroup& group : groups)
    for (int b = 0; b < group.batch_count; ++b, ++batch)
      for (int l = 0; l < group.lanes_in_use(b); ++l) {
        const PetscInt point = group.cell_point[static_cast<std::size_t>(b * lanes + l)];
        const std::size_t row = place[static_cast<std::size_t>(point - mesh.cell_start())] * width;
        for (std::size_t k = 0; k < width; ++k)
          values[row + k] =
              by_batch[(batch * width + k) * static_cast<std::size_t>(lanes) + static_cast<std::size_t>(l)];
      }
  return values;
}

} // namespace impact
