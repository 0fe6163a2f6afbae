#include "field_series.hpp"
#include <algorithm>
#include <impact/io/durable_file.hpp>
#include <impact/io/field_output.hpp>
#include <impact/io/hdf5_writer.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

namespace {

// Vectors of plane problems get a third component.
constexpr int stored_width(int components) { return components == 2 ? 3 : components; }

std::vector<Shape> shapes_of(const Mesh& mesh) {
  std::vector<Shape> shapes;
  for (const Shape s : known_shapes())
    if (mesh.has_shape(s)) shapes.push_back(s);
  return shapes;
}

/// Global node numbers of all cells of this rank; in a mixed mesh each cell begins with its XDMF type.
std::vector<std::int64_t> connectivity(const Mesh& mesh, bool mixed) {
  std::vector<std::int64_t> list;
  for (const CellTable& table : mesh.cells()) {
    const std::size_t nodes = at(node_count(table.shape));
    for (std::size_t c = 0; c < table.point.size(); ++c) {
      if (mixed) list.push_back(table.shape->names.xdmf);
      for (std::size_t a = 0; a < nodes; ++a)
        list.push_back(mesh.global_node()[at(table.connectivity[c * nodes + a])]);
    }
  }
  return list;
}

/// The rows of the nodes that this rank owns, which it holds in their global order, or of all its cells;
/// widened with zeros from `components` to `width`.
std::vector<double> rows_of(const Mesh& mesh, bool nodes, std::span<const double> values, int components,
                            int width) {
  std::vector<double> rows;
  const int count = nodes ? mesh.node_count() : mesh.cell_count();
  rows.reserve(at(count) * at(width));
  for (int k = 0; k < count; ++k) {
    if (nodes && !mesh.owned(k)) continue;
    const auto row = values.begin() + std::ptrdiff_t{k} * components;
    rows.insert(rows.end(), row, row + components);
    rows.resize(rows.size() + at(width - components), 0.0);
  }
  return rows;
}

std::string without_extension(const std::string& path) {
  return path.ends_with(".xdmf") ? path.substr(0, path.size() - 5) : path;
}

} // namespace

/// The mesh as the file of it holds it. The sums of its parts tell distributions apart: another one has
/// another numbering and needs its own file.
struct FieldMesh {
  hdf5::Slab nodes, cells, numbers; // the last of the topology
  bool mixed;
  std::vector<double> points;
  std::vector<std::int64_t> topology;
  XdmfMesh entry;
  std::string sum;

  FieldMesh(const Mesh& mesh, const FieldFile& request, const std::vector<Shape>& shapes)
      : nodes(mesh.comm(), at(mesh.owned_node_count())), cells(mesh.comm(), at(mesh.cell_count())),
        numbers(mesh.comm(), connectivity(mesh, shapes.size() > 1).size()), mixed(shapes.size() > 1),
        points(rows_of(mesh, true, mesh.coordinates(), mesh.dim(), 3)),
        topology(connectivity(mesh, mixed)), entry{
                                                 {},          mixed ? "Mixed" : shapes.at(0)->names.xdmf_name,
                                                 nodes.all,   cells.all,
                                                 numbers.all, !request.regions.empty()} {
    std::array<std::uint64_t, 4> sums{checksum(hdf5::bytes_of(points), 3 * nodes.first),
                                      checksum(hdf5::bytes_of(topology), numbers.first),
                                      checksum(hdf5::bytes_of(request.region), cells.first)};
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), 3, MPI_UINT64_T, MPI_SUM, mesh.comm());
    sums[3] = checksum(request.regions);
    sum = to_hex(checksum(hdf5::bytes_of(sums)));
  }
};

void FieldOutput::write_mesh(const FieldMesh& stored, const FieldFile& request) {
  const MPI_Comm comm = mesh_->comm();
  const std::uint64_t width =
      stored.mixed || stored.cells.all == 0 ? 1 : stored.numbers.all / stored.cells.all;
  const std::vector<double> cell_count{static_cast<double>(stored.cells.all)};
  std::vector<hdf5::DataSet> sets{
      hdf5::rows("/geometry", stored.nodes, 3, stored.points),
      hdf5::rows("/topology", stored.mixed ? stored.numbers : stored.cells, width, stored.topology),
      hdf5::whole(comm, "/cells", stored.entry.cell_type), hdf5::whole(comm, "/cell_count", cell_count),
      hdf5::whole(comm, "/checksum", stored.sum)};
  if (stored.entry.regions) {
    sets.push_back(hdf5::rows("/region", stored.cells, 1, request.region));
    sets.push_back(hdf5::whole(comm, "/regions", request.regions));
  }
  const std::string name = broadcast(comm, series_->next_mesh_name());
  hdf5::write_file(comm, series_->file(name), sets);
  on_rank_zero(comm, [&] {
    XdmfMesh entry = stored.entry;
    entry.file = series_->relative(name);
    series_->add_mesh(entry, stored.sum);
  });
}

FieldOutput::FieldOutput(const Mesh& mesh, const FieldFile& file)
    : mesh_(&mesh), series_(std::make_unique<FieldSeries>(without_extension(file.path))) {
  const MPI_Comm comm = mesh.comm();
  const FieldMesh stored(mesh, file, shapes_of(mesh));
  int write_the_mesh = 1;
  on_rank_zero(comm, [&] {
    make_directories(series_->folder());
    series_->xdmf.title = file.title;
    series_->xdmf.units = file.units;
    if (file.resume_after) {
      if (series_->find_meshes(stored.sum, warning_)) write_the_mesh = 0;
    } else {
      remove_file(series_->xdmf_file());
      series_->remove_all_but_named();
    }
  });
  MPI_Bcast(&write_the_mesh, 1, MPI_INT, 0, comm);
  if (write_the_mesh != 0) write_mesh(stored, file);
  if (!file.resume_after) return;
  on_rank_zero(comm, [&] {
    series_->find_frames(*file.resume_after, warning_);
    if (series_->xdmf.frames.empty())
      remove_file(series_->xdmf_file());
    else
      series_->replace_xdmf();
    series_->remove_all_but_named();
  });
  warning_ = broadcast(comm, warning_);
  if (!series_->xdmf.frames.empty()) last_time_ = series_->xdmf.frames.back().time;
  MPI_Bcast(&last_time_, 1, MPI_DOUBLE, 0, comm);
}

FieldOutput::FieldOutput(FieldOutput&&) noexcept = default;
FieldOutput& FieldOutput::operator=(FieldOutput&&) noexcept = default;
FieldOutput::~FieldOutput() = default;

void FieldOutput::write(double time, const std::vector<Field>& fields) {
  const MPI_Comm comm = mesh_->comm();
  const bool good = std::ranges::all_of(fields, [&](const Field& field) {
    const int entities = field.on_nodes ? mesh_->node_count() : mesh_->cell_count();
    return field.components > 0 && field.values.size() == at(entities * field.components) &&
           !field.name.empty() && field.name.find('/') == std::string::npos;
  });
  if (!all_ranks_agree(comm, good))
    throw std::logic_error("field output: a field has a wrong size or an impossible name");

  const hdf5::Slab nodes(comm, at(mesh_->owned_node_count())), cells(comm, at(mesh_->cell_count()));
  XdmfFrame frame{time, {}, series_->mesh, {}};
  std::vector<double> rows; // of one field after the other
  std::vector<hdf5::DataSet> sets;
  for (const Field& field : fields) {
    const int width = stored_width(field.components);
    frame.fields.push_back({field.name, field.on_nodes, width});
    sets.push_back(hdf5::rows((field.on_nodes ? "/node/" : "/cell/") + field.name, hdf5::Kind::real,
                              field.on_nodes ? nodes : cells, static_cast<std::uint64_t>(width), [&, width] {
                                rows = rows_of(*mesh_, field.on_nodes, field.values, field.components, width);
                                return hdf5::bytes_of(rows);
                              }));
  }
  const std::vector<double> times{time};
  std::string name, sum;
  on_rank_zero(comm, [&] {
    name = series_->frame_name(time);
    sum = series_->mesh_sum();
  });
  name = broadcast(comm, name);
  sets.push_back(hdf5::whole(comm, "/mesh", sum));
  sets.push_back(hdf5::whole(comm, "/time", times));
  hdf5::write_file(comm, series_->file(name), sets);
  on_rank_zero(comm, [&] {
    frame.file = series_->relative(name);
    series_->add_frame(frame);
  });
  last_time_ = std::max(last_time_, time);
}

std::vector<double> cells_in_mesh_order(const Mesh& mesh, const std::vector<CellGroup>& groups,
                                        int components, std::span<const double> by_batch) {
  std::vector<std::size_t> place(at(mesh.cell_count()));
  std::size_t next = 0;
  for (const CellTable& table : mesh.cells())
    for (const PetscInt point : table.point) place[at(point - mesh.cell_start())] = next++;

  const std::size_t width = at(components);
  std::vector<double> values(place.size() * width, 0.0);
  std::size_t batch = 0;
  for (const CellGroup& group : groups)
    for (int b = 0; b < group.batch_count; ++b, ++batch)
      for (int l = 0; l < group.lanes_in_use(b); ++l) {
        const PetscInt point = group.cell_point[at(b * lanes + l)];
        const std::size_t row = place[at(point - mesh.cell_start())] * width;
        for (std::size_t k = 0; k < width; ++k)
          values[row + k] = by_batch[(batch * width + k) * at(lanes) + at(l)];
      }
  return values;
}

} // namespace impact
