#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/run/checkpoint_file.hpp>
#include <impact/run/checkpoint_image.hpp>
#include <impact/run/durable_file.hpp>
#include <impact/run/watchdog.hpp>
#include <memory>
#include <petscviewerhdf5.h>
#include <sstream>
#include <thread>

namespace impact {

namespace {

constexpr const char* topology_name = "mesh"; // DMPlex finds what it stored by the names of the objects

/// Waits until all ranks have come here. A rank with trouble waits only so long: the others may be inside a
/// collective call that it has left, and never come.
void await_all(MPI_Comm comm, const std::string& trouble) {
  constexpr double patience = 5; // seconds
  MPI_Request request = MPI_REQUEST_NULL;
  int here = 0, done = 0;
  MPI_Ibarrier(comm, &request);
  if (trouble.empty()) {
    MPI_Wait(&request, MPI_STATUS_IGNORE);
    return;
  }
  for (const double start = MPI_Wtime(); done == 0 && MPI_Wtime() - start < patience;) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (done != 0) return;
  MPI_Comm_rank(comm, &here);
  std::fprintf(stderr, "impact: rank %d: %s\n", here, trouble.c_str());
  MPI_Abort(comm, static_cast<int>(ExitCode::io));
}

/// Runs PETSc calls that every rank takes part in; a failure on any rank is UserError(io) on all.
template <class Body> void file_access(MPI_Comm comm, const std::string& what, Body&& body) {
  const hdf5::Quiet quiet;
  std::string trouble;
  last_petsc_message();
  try {
    body();
  } catch (const PetscError& error) {
    trouble = what + ": " + error.what();
  }
  await_all(comm, trouble);
  throw_first(comm, ExitCode::io, trouble);
}

Handle<DM> named_clone(const Mesh& mesh, const std::string& name) {
  Handle<DM> dm;
  check(DMClone(mesh.dm(), dm.out()));
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(dm.get()), name.c_str()));
  return dm;
}

Handle<PetscViewer> open_viewer(MPI_Comm comm, const std::string& file, PetscFileMode mode) {
  Handle<PetscViewer> viewer;
  check(PetscViewerHDF5Open(comm, file.c_str(), mode, viewer.out()));
  check(PetscViewerPushFormat(viewer, PETSC_VIEWER_HDF5_PETSC));
  return viewer;
}

/// Where the doubles of a row live on the mesh: points of one stratum, each with its number of doubles.
struct RowPlaces {
  std::string section_name;
  PetscInt start = 0, end = 0; // chart
  std::vector<PetscInt> point;
  std::vector<int> doubles; // per entry of `point`
};

RowPlaces vertex_places(const Mesh& mesh, const StateRow& row) {
  RowPlaces places{"vertex_" + std::to_string(row.components),
                   mesh.vertex_point(0),
                   mesh.vertex_point(mesh.node_count()),
                   {},
                   {}};
  for (PetscInt p = places.start; p < places.end; ++p) places.point.push_back(p);
  places.doubles.assign(places.point.size(), row.components);
  return places;
}

RowPlaces cell_places(const Mesh& mesh, const StateRow& row) {
  RowPlaces places{"cell_" + std::to_string(row.components),
                   mesh.cell_start(),
                   mesh.cell_start() + mesh.cell_count(),
                   {},
                   {}};
  for (const CellTable& table : mesh.cells()) {
    places.point.insert(places.point.end(), table.point.begin(), table.point.end());
    places.doubles.resize(places.point.size(), point_count(table.shape) * row.components);
  }
  return places;
}

RowPlaces facet_places(const Mesh& mesh, const StateRow& row) {
  const FacetTable facets = mesh.facets(row.surface);
  int mine = facets.count() > 0 ? static_cast<int>(row.committed.size()) / facets.count() : 0, doubles = 0;
  MPI_Allreduce(&mine, &doubles, 1, MPI_INT, MPI_MAX, mesh.comm());
  RowPlaces places{"facet_" + row.surface + "_" + std::to_string(doubles), 0, 0, facets.point, {}};
  std::replace(places.section_name.begin(), places.section_name.end(), '/', '_');
  check(DMPlexGetHeightStratum(mesh.dm(), 1, &places.start, &places.end));
  places.doubles.assign(places.point.size(), doubles);
  return places;
}

RowPlaces places_of(const Mesh& mesh, const StateRow& row) {
  RowPlaces places = row.support == Support::vertex       ? vertex_places(mesh, row)
                     : row.support == Support::cell_point ? cell_places(mesh, row)
                                                          : facet_places(mesh, row);
  return places;
}

/// Lays the section of a row on a clone of the mesh's DM. Collective.
Handle<DM> section_dm(const Mesh& mesh, const RowPlaces& places) {
  Handle<DM> dm = named_clone(mesh, places.section_name);
  Handle<PetscSection> section;
  check(PetscSectionCreate(mesh.comm(), section.out()));
  check(PetscSectionSetChart(section, places.start, places.end));
  for (std::size_t k = 0; k < places.point.size(); ++k)
    check(PetscSectionSetDof(section, places.point[k], places.doubles[k]));
  check(PetscSectionSetUp(section));
  check(DMSetLocalSection(dm, section));
  return dm;
}

/// The place of a point's first double in the local vector of a section.
auto local_offset(PetscSection section) {
  return [section](PetscInt point) {
    PetscInt offset = 0;
    check(PetscSectionGetOffset(section, point, &offset));
    return offset;
  };
}

/// Calls copy(place in the row, offset_of(point) + number) for every double of a row, except those of points
/// with a negative offset; lanes that pad a batch (they repeat its last cell) only when asked for. False when
/// the row has another size than its places.
template <class Offset, class Copy>
bool for_each_double(const CheckpointState& state, const StateRow& row, const RowPlaces& places,
                     Offset&& offset_of, bool padding, Copy&& copy) {
  if (row.support != Support::cell_point) {
    std::size_t next = 0;
    for (std::size_t k = 0; k < places.point.size(); ++k) {
      const auto count = static_cast<std::size_t>(places.doubles[k]);
      if (next + count > row.committed.size()) return false;
      const PetscInt offset = offset_of(places.point[k]);
      for (std::size_t i = 0; i < count && offset >= 0; ++i)
        copy(next + i, static_cast<std::size_t>(offset) + i);
      next += count;
    }
    return next == row.committed.size();
  }
  std::size_t first = 0; // of the batch: [point][component][lane]
  constexpr auto width = static_cast<std::size_t>(lanes);
  for (const CellGroup& group : state.groups) {
    const auto per_cell = static_cast<std::size_t>(point_count(group.shape) * row.components);
    for (int b = 0; b < group.batch_count; ++b, first += per_cell * width) {
      if (first + per_cell * width > row.committed.size()) return false;
      const auto used = static_cast<std::size_t>(padding ? lanes : group.lanes_in_use(b));
      for (std::size_t l = 0; l < used; ++l) {
        const PetscInt offset = offset_of(group.cell_point[static_cast<std::size_t>(b) * width + l]);
        for (std::size_t i = 0; i < per_cell && offset >= 0; ++i)
          copy(first + i * width + l, static_cast<std::size_t>(offset) + i);
      }
    }
  }
  return first == row.committed.size();
}

const char* name_of(Support support) {
  switch (support) {
  case Support::vertex:
    return "vertex";
  case Support::cell_point:
    return "cell_point";
  case Support::facet_point:
    return "facet_point";
  default:
    return "global";
  }
}

/// One line per checkpointed row: what a run must have to be continued from it.
std::string row_list(const StateTable& table) {
  std::ostringstream text;
  for (const auto& row : table.rows())
    if (row->checkpointed)
      text << row->name << " (" << name_of(row->support) << ", " << row->components
           << (row->surface.empty() ? "" : ", " + row->surface) << ")\n";
  return text.str();
}

void check_size(const Mesh& mesh, const StateRow& row, bool good) {
  if (!all_ranks_agree(mesh.comm(), good))
    throw std::logic_error("state row " + row.name + " does not have the size of its mesh");
}

void write_mesh(const Mesh& mesh, PetscViewer viewer) {
  const Handle<DM> dm = named_clone(mesh, topology_name);
  check(DMPlexTopologyView(dm, viewer));
  check(DMPlexCoordinatesView(dm, viewer));
  check(DMPlexLabelsView(dm, viewer));
}

/// The keys of all points at their numbers in the stored topology. Collective.
void write_point_keys(const Mesh& mesh, PetscViewer viewer) {
  const std::vector<double> keys = point_keys(mesh);
  const Handle<DM> dm = named_clone(mesh, topology_name);
  Handle<IS> numbering;
  const PetscInt* number = nullptr;
  PetscInt count = 0, owned = 0;
  check(DMPlexCreatePointNumbering(dm, numbering.out()));
  check(ISGetLocalSize(numbering, &count));
  check(ISGetIndices(numbering, &number));
  for (PetscInt p = 0; p < count; ++p) owned += number[p] >= 0 ? 1 : 0;
  Handle<Vec> stored;
  check(VecCreateMPI(mesh.comm(), 2 * owned, PETSC_DETERMINE, stored.out()));
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(stored.get()), "point_keys"));
  for (PetscInt p = 0; p < count; ++p) {
    if (number[p] < 0) continue;
    const PetscInt place[2] = {2 * number[p], 2 * number[p] + 1};
    check(VecSetValues(stored, 2, place, &keys[static_cast<std::size_t>(2 * p)], INSERT_VALUES));
  }
  check(ISRestoreIndices(numbering, &number));
  check(VecAssemblyBegin(stored));
  check(VecAssemblyEnd(stored));
  check(VecView(stored, viewer));
}

void write_row(const CheckpointState& state, const StateRow& row, PetscViewer viewer,
               std::vector<std::string>& sections) {
  const Mesh& mesh = state.mesh;
  const RowPlaces places = places_of(mesh, row);
  const Handle<DM> topology = named_clone(mesh, topology_name), dm = section_dm(mesh, places);
  if (std::find(sections.begin(), sections.end(), places.section_name) == sections.end()) {
    check(DMPlexSectionView(topology, viewer, dm));
    sections.push_back(places.section_name);
  }
  PetscSection section = nullptr;
  Handle<Vec> local, global;
  check(DMGetLocalSection(dm, &section));
  check(DMCreateLocalVector(dm, local.out()));
  check(DMCreateGlobalVector(dm, global.out()));
  PetscScalar* value = nullptr;
  check(VecGetArray(local, &value));
  const bool good =
      for_each_double(state, row, places, local_offset(section), false,
                      [&](std::size_t from, std::size_t to) { value[to] = row.committed[from]; });
  check(VecRestoreArray(local, &value));
  check_size(mesh, row, good);
  check(DMLocalToGlobal(dm, local, INSERT_VALUES, global));
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(global.get()), row.name.c_str()));
  check(DMPlexGlobalVectorView(topology, viewer, dm, global));
}

bool in_sections(const StateRow& row) { return row.checkpointed && row.support != Support::global; }

/// Where the numbers of a row go in every checkpoint of a mesh.
struct RowPattern {
  RowPlaces places;
  std::vector<PetscInt> offset;   // per point of the chart: of its first double in this rank's; -1: another's
  std::size_t first = 0, own = 0; // this rank's doubles among those of all, and their number
  std::size_t row_size = 0;
  std::vector<FileRange> ranges;
};

/// The layout of the first checkpoint of a mesh, for those that follow.
struct Pattern {
  std::string rows; // as in row_list
  std::vector<RowPattern> row;
  CheckpointImage image;
};

constexpr const char* pattern_name = "impact_checkpoint_pattern"; // composed with the mesh: it lives as long

RowPattern row_pattern(const Mesh& mesh, const StateRow& row) {
  RowPattern pattern;
  pattern.places = places_of(mesh, row);
  pattern.row_size = row.committed.size();
  const Handle<DM> dm = section_dm(mesh, pattern.places);
  PetscSection section = nullptr;
  PetscInt own = 0, end = 0;
  check(DMGetGlobalSection(dm, &section));
  check(PetscSectionGetConstrainedStorageSize(section, &own));
  MPI_Scan(&own, &end, 1, MPIU_INT, MPI_SUM, mesh.comm());
  pattern.own = static_cast<std::size_t>(own);
  pattern.first = static_cast<std::size_t>(end - own);
  for (PetscInt p = pattern.places.start; p < pattern.places.end; ++p) {
    PetscInt doubles = 0, offset = 0;
    check(PetscSectionGetDof(section, p, &doubles));
    check(PetscSectionGetOffset(section, p, &offset));
    pattern.offset.push_back(doubles > 0 ? offset - (end - own) : -1);
  }
  return pattern;
}

/// Keeps the layout of a file that holds mesh and rows but not yet the values of the run. Nothing is kept
/// when HDF5 chose one that cannot be filled in place. Collective.
void keep_pattern(const CheckpointState& state, const std::string& file) {
  const MPI_Comm comm = state.mesh.comm();
  std::vector<RowPattern> rows;
  std::vector<FileRange> gaps;
  for (const auto& row : state.table.rows())
    if (in_sections(*row)) rows.push_back(row_pattern(state.mesh, *row));
  std::string found; // the ranges as bytes, to send them
  on_rank_zero(comm, [&] {
    const hdf5::File in(file, hdf5::File::Mode::read);
    std::size_t next = 0;
    for (const auto& row : state.table.rows()) {
      if (!in_sections(*row)) continue;
      const std::vector<FileRange> ranges =
          data_ranges(in, std::string("/topologies/") + topology_name + "/dms/" +
                              rows[next++].places.section_name + "/vecs/" + row->name + "/" + row->name);
      const std::size_t count = ranges.size();
      found.append(reinterpret_cast<const char*>(&count), sizeof count);
      found.append(reinterpret_cast<const char*>(ranges.data()), count * sizeof(FileRange));
    }
  });
  found = broadcast(comm, found);
  const char* at = found.data();
  bool good = true;
  for (RowPattern& row : rows) {
    std::size_t count = 0;
    std::memcpy(&count, at, sizeof count);
    row.ranges.resize(count);
    if (count > 0) std::memcpy(row.ranges.data(), at + sizeof count, count * sizeof(FileRange));
    at += sizeof count + count * sizeof(FileRange);
    std::uint64_t stored = 0, all = 0, own = row.own * sizeof(double);
    for (const FileRange& range : row.ranges) stored += range.bytes;
    MPI_Allreduce(&own, &all, 1, MPI_UINT64_T, MPI_SUM, comm);
    good = good && stored == all;
    gaps.insert(gaps.end(), row.ranges.begin(), row.ranges.end());
  }
  if (!good) return;
  std::unique_ptr<Pattern> pattern;
  agree_on_errors(comm, [&] {
    pattern = std::make_unique<Pattern>(
        Pattern{row_list(state.table), std::move(rows), CheckpointImage(comm, file, gaps)});
  });
  PetscContainer container = nullptr;
  check(PetscContainerCreate(comm, &container));
  check(PetscContainerSetUserDestroy(container, [](void* kept) -> PetscErrorCode {
    delete static_cast<Pattern*>(kept);
    return 0;
  }));
  check(PetscContainerSetPointer(container, pattern.release()));
  check(PetscObjectCompose(reinterpret_cast<PetscObject>(state.mesh.dm()), pattern_name,
                           reinterpret_cast<PetscObject>(container)));
  check(PetscContainerDestroy(&container));
}

/// The layout of the mesh's earlier checkpoint if the state still has the same rows. Collective.
const Pattern* kept_pattern(const CheckpointState& state) {
  PetscObject kept = nullptr;
  check(PetscObjectQuery(reinterpret_cast<PetscObject>(state.mesh.dm()), pattern_name, &kept));
  if (kept == nullptr) return nullptr;
  void* pointer = nullptr;
  check(PetscContainerGetPointer(reinterpret_cast<PetscContainer>(kept), &pointer));
  const auto* pattern = static_cast<const Pattern*>(pointer);
  bool same = pattern->rows == row_list(state.table);
  std::size_t next = 0;
  for (const auto& row : state.table.rows())
    if (same && in_sections(*row)) same = pattern->row[next++].row_size == row->committed.size();
  return all_ranks_agree(state.mesh.comm(), same) ? pattern : nullptr;
}

/// Fills an empty file as write_mesh, write_point_keys and write_row would. This rank's part: does not
/// communicate.
void write_in_pattern(const CheckpointState& state, const Pattern& pattern, const SharedFile& out) {
  pattern.image.write(out);
  out.begin_sync(); // the disk works while the next row is gathered
  std::size_t next = 0;
  for (const auto& row : state.table.rows()) {
    if (!in_sections(*row)) continue;
    const RowPattern& to = pattern.row[next++];
    const auto value = std::make_unique_for_overwrite<double[]>(to.own);
    const auto offset_of = [&](PetscInt point) {
      return to.offset[static_cast<std::size_t>(point - to.places.start)];
    };
    const double* from = row->committed.data();
    if (!for_each_double(state, *row, to.places, offset_of, false,
                         [&](std::size_t k, std::size_t place) { value[place] = from[k]; }))
      throw std::logic_error("state row " + row->name + " does not have the size of its mesh");
    write_ranges(out, to.ranges, to.first * sizeof(double), value.get(), to.own * sizeof(double));
    out.begin_sync();
  }
}

/// More than the file will need, over all ranks. Collective.
std::uint64_t expected_bytes(const CheckpointState& state) {
  PetscInt points = 0;
  check(DMPlexGetChart(state.mesh.dm(), nullptr, &points));
  // per point: cone and orientation (at most 6 each), sizes, labels, key; then its part of every section
  std::uint64_t per_point = 20 * sizeof(PetscInt) + 2 * sizeof(double), bytes = 0, all = 0;
  for (const auto& row : state.table.rows()) {
    if (!row->checkpointed) continue;
    per_point += 3 * sizeof(PetscInt);
    bytes += row->committed.size() * sizeof(double);
  }
  bytes += static_cast<std::uint64_t>(points) * per_point;
  if (state.file != nullptr) {
    bytes += state.file->x.size() * sizeof(double);
    for (const GmshBlock& block : state.file->blocks) bytes += (block.node.size() + 16) * sizeof(int);
  }
  bytes += static_cast<std::uint64_t>(state.mesh.node_count()) * 6 * sizeof(double);
  MPI_Allreduce(&bytes, &all, 1, MPI_UINT64_T, MPI_SUM, state.mesh.comm());
  return all + all / 4 + (std::uint64_t{1} << 20);
}

void write_on_rank_zero(const std::string& name, const CheckpointState& state,
                        const CheckpointValues& values) {
  hdf5::File file(name, hdf5::File::Mode::update);
  write_values(file, values);
  file.write("/impact/rows", row_list(state.table));
  for (const auto& row : state.table.rows())
    if (row->checkpointed && row->support == Support::global)
      file.write("/impact/globals/" + row->name, row->committed);
  file.set_attribute("/", "impact_checkpoint_version", checkpoint_version);
  file.close();
}

/// Migration from the points as stored to the points of `mesh`. Collective. Throws UserError(io) for another
/// mesh.
Handle<PetscSF> stored_points(const Mesh& mesh, PetscViewer viewer, const std::string& file) {
  const MPI_Comm comm = mesh.comm();
  PetscInt length = 0, here = PETSC_DECIDE;
  Handle<Vec> stored;
  on_rank_zero(comm, [&] {
    length = static_cast<PetscInt>(hdf5::File(file, hdf5::File::Mode::read).extent("/point_keys").at(0));
  });
  MPI_Bcast(&length, 1, MPIU_INT, 0, comm);
  file_access(comm, "cannot read checkpoint " + file, [&] {
    PetscInt points = length / 2;
    check(PetscSplitOwnership(comm, &here, &points));
    check(VecCreateMPI(comm, 2 * here, length, stored.out()));
    check(PetscObjectSetName(reinterpret_cast<PetscObject>(stored.get()), "point_keys"));
    check(VecLoad(stored, viewer));
  });
  const PetscScalar* value = nullptr;
  check(VecGetArrayRead(stored, &value));
  const std::vector<double> known(value, value + 2 * here);
  check(VecRestoreArrayRead(stored, &value));
  const std::vector<PetscInt> place = find_keys(comm, known, point_keys(mesh));

  Handle<PetscSF> point_sf;
  PetscSF shared = nullptr;
  PetscInt leaves = 0, owned = 0, all = 0;
  check(DMGetPointSF(mesh.dm(), &shared));
  check(PetscSFGetGraph(shared, nullptr, &leaves, nullptr, nullptr));
  owned = static_cast<PetscInt>(place.size()) - std::max<PetscInt>(leaves, 0);
  MPI_Allreduce(&owned, &all, 1, MPIU_INT, MPI_SUM, comm);
  const bool found = std::find(place.begin(), place.end(), PetscInt{-1}) == place.end();
  if (!all_ranks_agree(comm, found) || 2 * all != length)
    throw UserError(ExitCode::io,
                    "cannot use checkpoint " + file +
                        ": it belongs to another mesh; give the mesh, scale and refinement of its run");
  PetscLayout layout = nullptr;
  check(PetscLayoutCreateFromSizes(comm, here, PETSC_DETERMINE, 1, &layout));
  check(PetscSFCreate(comm, point_sf.out()));
  check(PetscSFSetGraphLayout(point_sf, layout, static_cast<PetscInt>(place.size()), nullptr,
                              PETSC_COPY_VALUES, place.data()));
  check(PetscLayoutDestroy(&layout));
  return point_sf;
}

void read_row(const CheckpointState& state, StateRow& row, PetscViewer viewer, PetscSF points) {
  const Mesh& mesh = state.mesh;
  const RowPlaces places = places_of(mesh, row);
  const Handle<DM> topology = named_clone(mesh, topology_name), dm = named_clone(mesh, places.section_name);
  Handle<PetscSF> migration;
  check(DMPlexSectionLoad(topology, viewer, dm, points, migration.out(), nullptr));
  Handle<Vec> local, global;
  check(DMCreateGlobalVector(dm, global.out()));
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(global.get()), row.name.c_str()));
  check(DMPlexGlobalVectorLoad(topology, viewer, dm, migration, global));
  check(DMCreateLocalVector(dm, local.out()));
  check(DMGlobalToLocal(dm, global, INSERT_VALUES, local));

  PetscSection section = nullptr;
  const PetscScalar* value = nullptr;
  bool good = true;
  check(DMGetLocalSection(dm, &section));
  for (std::size_t k = 0; k < places.point.size(); ++k) {
    PetscInt doubles = 0;
    check(PetscSectionGetDof(section, places.point[k], &doubles));
    good = good && doubles == places.doubles[k];
  }
  check(VecGetArrayRead(local, &value));
  good = good && for_each_double(state, row, places, local_offset(section), true,
                                 [&](std::size_t to, std::size_t from) { row.committed[to] = value[from]; });
  check(VecRestoreArrayRead(local, &value));
  check_size(mesh, row, good);
}

/// Rows of global support, and the check that the run has the rows that were written. Collective.
void read_on_rank_zero(const Checkpoint& checkpoint, const CheckpointState& state) {
  on_rank_zero(state.mesh.comm(), [&] {
    const hdf5::File file(checkpoint.file, hdf5::File::Mode::read);
    const std::string stored = file.read_text("/impact/rows"), wanted = row_list(state.table);
    const auto lines = [](std::string text) {
      text.resize(text.empty() ? 0 : text.size() - 1);
      for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;) text.replace(at, 1, "; ");
      return text;
    };
    if (stored != wanted)
      throw UserError(ExitCode::io, "cannot use checkpoint " + checkpoint.file + ": it holds " +
                                        lines(stored) + "; this run needs " + lines(wanted) +
                                        "; restart with the physics of its run");
    for (const auto& row : state.table.rows()) {
      if (!row->checkpointed || row->support != Support::global) continue;
      const std::vector<double> values = file.read_numbers("/impact/globals/" + row->name);
      if (values.size() != row->committed.size())
        throw UserError(ExitCode::io, "cannot use checkpoint " + checkpoint.file + ": row " + row->name +
                                          " has " + std::to_string(values.size()) + " values instead of " +
                                          std::to_string(row->committed.size()));
      row->committed = values;
    }
  });
}

} // namespace

std::string write_checkpoint(const CheckpointState& state, const CheckpointValues& values,
                             const CheckpointFolder& folder) {
  const MPI_Comm comm = state.mesh.comm();
  const std::uint64_t bytes = expected_bytes(state);
  const Pattern* pattern = kept_pattern(state);
  std::string file;
  on_rank_zero(comm, [&] {
    make_directories(folder.dir);
    file = next_checkpoint_file(folder.dir);
    // Ranks that write by themselves say when the disk is full; inside collective calls of HDF5 they would
    // wait for one another.
    if (pattern == nullptr) require_space(file, bytes);
  });
  file = broadcast(comm, file);
  const std::string temporary = file + ".tmp";
  try {
    const Watchdog watchdog(folder.patience + 1e-6 * static_cast<double>(bytes),
                            "cannot write checkpoint " + file +
                                ": the write does not end (-checkpoint_patience); look at the disk, then "
                                "-restart auto goes on from the one before");
    const std::string what = "cannot write checkpoint " + file;
    if (pattern != nullptr) {
      on_rank_zero(comm, [&] { SharedFile(temporary, what, SharedFile::Mode::create); });
      agree_on_errors(comm, [&] {
        write_in_pattern(state, *pattern, SharedFile(temporary, what, SharedFile::Mode::fill));
      });
    } else {
      file_access(comm, what, [&] {
        const Handle<PetscViewer> viewer = open_viewer(comm, temporary, FILE_MODE_WRITE);
        std::vector<std::string> sections;
        write_mesh(state.mesh, viewer);
        write_point_keys(state.mesh, viewer);
        for (const auto& row : state.table.rows())
          if (in_sections(*row)) write_row(state, *row, viewer, sections);
      });
      on_rank_zero(comm, [&] {
        if (state.file == nullptr) return;
        hdf5::File out(temporary, hdf5::File::Mode::update);
        write_stored_mesh(out, *state.file);
        out.close();
      });
      keep_pattern(state, temporary);
    }
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    std::string manifest;
    agree_on_errors(comm, [&] { // the other ranks sync what their nodes hold
      if (rank > 0) return sync_file(temporary);
      write_on_rank_zero(temporary, state, values);
      manifest = seal_checkpoint(file, values);
    });
    on_rank_zero(comm, [&] {
      publish_checkpoint(file, manifest);
      remove_old_checkpoints(folder);
    });
  } catch (const UserError& error) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    std::error_code ignored;
    if (rank == 0) std::filesystem::remove(temporary, ignored);
    throw UnfinishedFile(error.code(), error.what());
  }
  return file;
}

void read_checkpoint(const Checkpoint& checkpoint, CheckpointState state) {
  const Timed timed(Event::checkpoint_read);
  const MPI_Comm comm = state.mesh.comm();
  read_on_rank_zero(checkpoint, state);
  Handle<PetscViewer> viewer;
  const std::string what = "cannot read checkpoint " + checkpoint.file;
  file_access(comm, what, [&] { viewer = open_viewer(comm, checkpoint.file, FILE_MODE_READ); });
  const Handle<PetscSF> points = stored_points(state.mesh, viewer, checkpoint.file);
  file_access(comm, what, [&] {
    for (const auto& row : state.table.rows())
      if (in_sections(*row)) read_row(state, *row, viewer, points);
  });
  for (const auto& row : state.table.rows()) {
    if (!row->checkpointed) continue;
    if (row->support == Support::global)
      MPI_Bcast(row->committed.data(), static_cast<int>(row->committed.size()), MPI_DOUBLE, 0, comm);
    if (row->has_trial) row->trial = row->committed;
  }
}

std::optional<GmshFile> read_checkpoint_mesh_file(MPI_Comm comm, const Checkpoint& checkpoint) {
  std::optional<GmshFile> mesh;
  int found = 0;
  on_rank_zero(comm, [&] {
    mesh = read_stored_mesh(checkpoint.file);
    found = mesh ? 1 : 0;
  });
  MPI_Bcast(&found, 1, MPI_INT, 0, comm);
  if (found == 1 && !mesh) mesh.emplace();
  return mesh;
}

Mesh read_checkpoint_mesh(MPI_Comm comm, const Checkpoint& checkpoint, const PartitionWeights& weights) {
  Handle<DM> dm;
  file_access(comm, "cannot read checkpoint " + checkpoint.file, [&] {
    const Handle<PetscViewer> viewer = open_viewer(comm, checkpoint.file, FILE_MODE_READ);
    Handle<PetscSF> points;
    check(DMCreate(comm, dm.out()));
    check(DMSetType(dm, DMPLEX));
    check(PetscObjectSetName(reinterpret_cast<PetscObject>(dm.get()), topology_name));
    check(DMPlexTopologyLoad(dm, viewer, points.out()));
    check(DMPlexCoordinatesLoad(dm, viewer, points));
    check(DMPlexLabelsLoad(dm, viewer, points));
  });
  distribute(dm, weights);
  order_for_locality(dm);
  std::vector<Group> groups = groups_from_labels(dm);
  return Mesh(std::move(dm), std::move(groups));
}

} // namespace impact
