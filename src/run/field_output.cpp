#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <impact/petsc/error.hpp>
#include <impact/run/durable_file.hpp>
#include <impact/run/field_output.hpp>
#include <impact/run/hdf5_file.hpp>
#include <impact/run/xdmf.hpp>
#include <map>
#include <set>
#include <string_view>

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

std::vector<Shape> shapes_on_any_rank(const Mesh& mesh) {
  std::vector<Shape> shapes;
  for (const Shape s : known_shapes())
    if (mesh.has_shape(s)) shapes.push_back(s);
  return shapes;
}

/// Global node numbers of all cells of this rank; in a mixed mesh each cell begins with its XDMF type.
std::vector<std::int64_t> connectivity(const Mesh& mesh, bool mixed) {
  std::vector<std::int64_t> list;
  for (const CellTable& table : mesh.cells()) {
    const auto nodes = static_cast<std::size_t>(node_count(table.shape));
    for (std::size_t c = 0; c < table.point.size(); ++c) {
      if (mixed) list.push_back(table.shape->names.xdmf);
      for (std::size_t a = 0; a < nodes; ++a)
        list.push_back(mesh.global_node()[static_cast<std::size_t>(table.connectivity[c * nodes + a])]);
    }
  }
  return list;
}

std::string frame_name(int number) {
  char name[32];
  std::snprintf(name, sizeof name, "%06d.h5", number);
  return name;
}

std::string mesh_name(int number) { return "mesh_" + std::to_string(number) + ".h5"; }

/// What the name of a file in our folder says: "000012.h5", "mesh_0.h5", or one of these with the ending of a
/// file that was not finished or set aside. Other names have the number -1.
struct OwnName {
  bool mesh = false, finished = false;
  int number = -1;
};

OwnName own_name(const std::string& name) {
  OwnName own;
  own.mesh = name.starts_with("mesh_");
  const char *begin = name.data() + (own.mesh ? 5 : 0), *end = name.data() + name.size();
  int number = -1;
  const auto [rest, error] = std::from_chars(begin, end, number);
  const std::string_view ending(rest, end);
  if (error != std::errc{} || number < 0 || !ending.starts_with(".h5")) return own;
  own.number = number;
  own.finished = ending == ".h5";
  return own;
}

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  try {
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      names.push_back(entry.path().filename().string());
  } catch (const std::filesystem::filesystem_error& error) {
    throw UserError(ExitCode::io, "cannot read directory " + folder + ": " + error.code().message());
  }
  return names;
}

void remove_file(const std::string& file) {
  std::error_code error;
  std::filesystem::remove(file, error);
  if (error) throw UserError(ExitCode::io, "cannot remove " + file + ": " + error.message());
}

/// Finished files of one kind by their number.
std::map<int, std::string> finished_files(const std::string& folder, bool meshes) {
  std::map<int, std::string> files;
  for (const std::string& name : names_in(folder))
    if (const OwnName own = own_name(name); own.finished && own.mesh == meshes) files[own.number] = name;
  return files;
}

/// Puts the complete file on the disk; after a failure nothing of it stays.
void publish(std::unique_ptr<hdf5::File> file, const std::string& target, const std::string& failure) {
  if (!failure.empty()) throw UserError(ExitCode::io, failure);
  try {
    replace_file(target, file->image());
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(target + ".tmp", ignored);
    throw;
  }
}

std::string without_extension(const std::string& path) {
  return path.ends_with(".xdmf") ? path.substr(0, path.size() - 5) : path;
}

} // namespace

/// `nodes_in_order` and the counts hold on every rank; files and the lists of what they contain live on rank
/// 0.
struct FieldOutput::Impl {
  MPI_Comm comm = MPI_COMM_NULL;
  int rank = 0;
  std::string path; // without extension
  XdmfFile xdmf;
  std::vector<int> nodes_in_order; // owned local nodes by global number
  std::size_t node_count = 0, cell_count = 0;
  std::uint64_t global_nodes = 0, global_cells = 0;
  std::vector<std::string> mesh_sums; // of xdmf.meshes
  std::size_t mesh_index = 0;         // into xdmf.meshes: the one of this run
  int next_mesh = 0, next_frame = 0;

  std::string folder() const { return path + ".fields"; }
  std::string file(const std::string& name) const { return folder() + "/" + name; }
  /// As the .xdmf names it.
  std::string relative(const std::string& name) const {
    return std::filesystem::path(folder()).filename().string() + "/" + name;
  }
  void take_numbering(const Mesh& mesh);
  std::vector<double> owned_values(const double* values, int components, int width) const;
  bool find_mesh(const std::string& sum, std::string& warning);
  void find_frames(double after, std::string& warning);
  XdmfFrame read_frame(const std::string& name) const;
  void set_aside(const std::string& name, const std::exception& error, std::string& warning) const;
  void remove_all_but_named() const;
  std::unique_ptr<hdf5::File> create(const std::string& target, std::uint64_t bytes) const;
  void write_mesh(const Mesh& mesh, const FieldFile& request, const std::string& sum);
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

/// Made in memory, see publish(). A disk that is too full says so here, before the fields are collected.
std::unique_ptr<hdf5::File> FieldOutput::Impl::create(const std::string& target, std::uint64_t bytes) const {
  require_space(target, bytes);
  return std::make_unique<hdf5::File>(target, hdf5::File::Mode::in_memory);
}

void FieldOutput::Impl::write_mesh(const Mesh& mesh, const FieldFile& request, const std::string& sum) {
  const std::vector<Shape> shapes = shapes_on_any_rank(mesh);
  const bool mixed = shapes.size() > 1;
  const std::vector<std::int64_t> cells = connectivity(mesh, mixed);
  std::int64_t mine = static_cast<std::int64_t>(cells.size()), length = 0;
  MPI_Allreduce(&mine, &length, 1, MPI_INT64_T, MPI_SUM, comm);
  const hsize_t width = mixed ? 1 : static_cast<hsize_t>(shapes.at(0)->nodes);

  const std::string name = mesh_name(next_mesh);
  std::unique_ptr<hdf5::File> h5;
  std::string failure;
  on_rank_zero(comm, [&] {
    h5 = create(file(name), margin + sizeof(double) * (3 * global_nodes + static_cast<std::uint64_t>(length) +
                                                       global_cells));
  });
  write_dataset(h5.get(), failure, "/geometry", 3, global_nodes,
                owned_values(mesh.coordinates().data(), mesh.dim(), 3));
  write_dataset(h5.get(), failure, "/topology", width, static_cast<hsize_t>(length) / width, cells);
  const bool regions = !request.regions.empty();
  if (regions) write_dataset(h5.get(), failure, "/region", 1, global_cells, request.region);
  on_rank_zero(comm, [&] {
    const XdmfMesh entry{relative(name), mixed ? "Mixed" : shapes[0]->names.xdmf_name, global_nodes,
                         global_cells,   static_cast<std::uint64_t>(length),           regions};
    if (failure.empty()) {
      h5->write("/cells", entry.cell_type);
      h5->write("/cell_count", std::vector<double>{static_cast<double>(global_cells)});
      h5->write("/checksum", sum);
      if (regions) h5->write("/regions", request.regions);
    }
    publish(std::move(h5), file(name), failure);
    mesh_index = xdmf.meshes.size();
    xdmf.meshes.push_back(entry);
    mesh_sums.push_back(sum);
    ++next_mesh;
  });
}

/// Renames a file that cannot be used and adds what the user is told.
void FieldOutput::Impl::set_aside(const std::string& name, const std::exception& error,
                                  std::string& warning) const {
  rename_durably(file(name), file(name) + ".damaged");
  warning +=
      std::string(warning.empty() ? "" : "; ") + error.what() + "; it was kept as " + file(name) + ".damaged";
}

/// Takes up the meshes that are there; true when this run's is among them. On rank 0.
bool FieldOutput::Impl::find_mesh(const std::string& sum, std::string& warning) {
  bool found = false;
  for (const auto& [number, name] : finished_files(folder(), true)) {
    next_mesh = number + 1;
    try {
      const hdf5::File h5(file(name), hdf5::File::Mode::read);
      std::uint64_t length = 1;
      for (const hsize_t n : h5.extent("/topology")) length *= n;
      const XdmfMesh entry{relative(name),
                           h5.read_text("/cells"),
                           h5.extent("/geometry").at(0),
                           static_cast<std::uint64_t>(h5.read_numbers("/cell_count").at(0)),
                           length,
                           h5.has("/region")};
      mesh_sums.push_back(h5.read_text("/checksum"));
      xdmf.meshes.push_back(entry);
    } catch (const std::exception& error) {
      set_aside(name, error, warning);
      continue;
    }
    if (mesh_sums.back() == sum) {
      mesh_index = mesh_sums.size() - 1;
      found = true;
    }
  }
  return found;
}

XdmfFrame FieldOutput::Impl::read_frame(const std::string& name) const {
  const hdf5::File h5(file(name), hdf5::File::Mode::read);
  const auto mesh = std::find(mesh_sums.begin(), mesh_sums.end(), h5.read_text("/mesh"));
  if (mesh == mesh_sums.end())
    throw UserError(ExitCode::io, "cannot use " + file(name) + ": its mesh is not there");
  XdmfFrame frame{
      h5.read_numbers("/time").at(0), relative(name), static_cast<std::size_t>(mesh - mesh_sums.begin()), {}};
  for (const bool on_nodes : {true, false})
    for (const std::string& field : h5.list(on_nodes ? "/node" : "/cell")) {
      const auto extent = h5.extent((on_nodes ? "/node/" : "/cell/") + field);
      frame.fields.push_back({field, on_nodes, extent.size() > 1 ? static_cast<int>(extent[1]) : 1});
    }
  return frame;
}

/// Takes the times up to `after` into the list. On rank 0.
void FieldOutput::Impl::find_frames(double after, std::string& warning) {
  for (const auto& [number, name] : finished_files(folder(), false)) {
    try {
      XdmfFrame frame = read_frame(name);
      // The number grows with the time; a file that breaks this was left by times that were dropped before.
      if (frame.time > after || (!xdmf.frames.empty() && frame.time <= xdmf.frames.back().time)) continue;
      xdmf.frames.push_back(std::move(frame));
      next_frame = number + 1;
    } catch (const std::exception& error) {
      set_aside(name, error, warning);
    }
  }
}

/// Of the files that may be ours, those stay that the .xdmf names, the mesh of this run, and what was set
/// aside.
void FieldOutput::Impl::remove_all_but_named() const {
  std::set<std::string> stays;
  if (!xdmf.meshes.empty()) stays.insert(xdmf.meshes[mesh_index].file);
  for (const XdmfFrame& frame : xdmf.frames) {
    stays.insert(frame.file);
    stays.insert(xdmf.meshes[frame.mesh].file);
  }
  for (const std::string& name : names_in(folder()))
    if (own_name(name).number >= 0 && stays.count(relative(name)) == 0 && !name.ends_with(".damaged"))
      remove_file(file(name));
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
  mine.add(file.region.data(), file.region.size() * sizeof(std::int64_t));
  mine.add(file.regions.data(), file.regions.size());
  const std::uint64_t value = mine.value();
  int size = 1;
  MPI_Comm_size(self.comm, &size);
  std::vector<std::uint64_t> all(static_cast<std::size_t>(size));
  MPI_Gather(&value, 1, MPI_UINT64_T, all.data(), 1, MPI_UINT64_T, 0, self.comm);
  Checksum whole;
  whole.add(all.data(), all.size() * sizeof(std::uint64_t));

  const std::string sum = to_hex(whole.value());
  int write_the_mesh = 1;
  on_rank_zero(self.comm, [&] {
    make_directories(self.folder());
    self.xdmf.title = file.title;
    self.xdmf.units = file.units;
    if (file.resume_after) {
      if (self.find_mesh(sum, warning_)) write_the_mesh = 0;
    } else {
      remove_file(self.path + ".xdmf");
      self.remove_all_but_named();
    }
  });
  MPI_Bcast(&write_the_mesh, 1, MPI_INT, 0, self.comm);
  if (write_the_mesh != 0) self.write_mesh(mesh, file, sum);
  if (!file.resume_after) return;
  on_rank_zero(self.comm, [&] {
    self.find_frames(*file.resume_after, warning_);
    if (self.xdmf.frames.empty())
      remove_file(self.path + ".xdmf");
    else
      self.replace_xdmf();
    self.remove_all_but_named();
  });
  warning_ = broadcast(self.comm, warning_);
  if (!self.xdmf.frames.empty()) last_time_ = self.xdmf.frames.back().time;
  MPI_Bcast(&last_time_, 1, MPI_DOUBLE, 0, self.comm);
}

FieldOutput::FieldOutput(FieldOutput&&) noexcept = default;
FieldOutput& FieldOutput::operator=(FieldOutput&&) noexcept = default;
FieldOutput::~FieldOutput() = default;

void FieldOutput::Impl::write_fields(hdf5::File* file, std::string& failure, XdmfFrame& frame,
                                     const std::vector<NodeField>& nodes,
                                     const std::vector<CellField>& cells) const {
  for (const NodeField& field : nodes) {
    const int width = static_cast<int>(stored_width(field.components));
    write_dataset(file, failure, "/node/" + field.name, static_cast<hsize_t>(width), global_nodes,
                  owned_values(field.values.data(), field.components, width));
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
    write_dataset(file, failure, "/cell/" + field.name, static_cast<hsize_t>(width), global_cells, rows);
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

  std::uint64_t bytes = margin;
  for (const NodeField& f : nodes) bytes += sizeof(double) * self.global_nodes * stored_width(f.components);
  for (const CellField& f : cells) bytes += sizeof(double) * self.global_cells * stored_width(f.components);
  auto& frames = self.xdmf.frames;
  XdmfFrame frame{time, {}, self.mesh_index, {}};
  std::string name;
  std::unique_ptr<hdf5::File> file;
  std::string failure;
  const auto same =
      std::find_if(frames.begin(), frames.end(), [&](const XdmfFrame& f) { return f.time == time; });
  on_rank_zero(self.comm, [&] {
    name = same != frames.end() ? std::filesystem::path(same->file).filename().string()
                                : frame_name(self.next_frame);
    frame.file = self.relative(name);
    file = self.create(self.file(name), bytes);
  });
  self.write_fields(file.get(), failure, frame, nodes, cells);
  on_rank_zero(self.comm, [&] {
    if (failure.empty()) {
      file->write("/mesh", self.mesh_sums[self.mesh_index]);
      file->write("/time", std::vector<double>{time});
    }
    publish(std::move(file), self.file(name), failure);
    if (same != frames.end()) {
      *same = frame;
    } else {
      frames.push_back(frame);
      ++self.next_frame;
    }
    self.replace_xdmf();
  });
  last_time_ = std::max(last_time_, time);
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
