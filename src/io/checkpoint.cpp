#include "checkpoint_folder.hpp"
#include "entities.hpp"
#include <algorithm>
#include <csignal>
#include <cstring>
#include <impact/io/durable_file.hpp>
#include <impact/io/hdf5_reader.hpp>
#include <impact/io/mesh_file.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/log.hpp>
#include <petscsf.h>
#include <sstream>
#include <sys/time.h>
#include <unistd.h>

namespace impact {

namespace {

// A signal handler may touch nothing that is not there beforehand.
std::array<char, 1024> last_words{};

void give_up(int) {
  const ssize_t said = ::write(STDERR_FILENO, last_words.data(), std::strlen(last_words.data()));
  ::_exit(said < 0 ? static_cast<int>(ExitCode::internal) : static_cast<int>(ExitCode::io));
}

void set_timer(double seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  timer.it_value.tv_usec =
      static_cast<suseconds_t>((seconds - static_cast<double>(timer.it_value.tv_sec)) * 1e6);
  setitimer(ITIMER_REAL, &timer, nullptr);
}

/// Ends the process with `message` on the terminal and exit status 4 when it is not destroyed within
/// `seconds`: for collective writes, in which a rank waits for ever on the others. One at a time; uses
/// SIGALRM.
class Watchdog {
public:
  Watchdog(double seconds, const std::string& message) {
    const std::string text = "impact: " + message + "\n";
    const std::size_t length = std::min(text.size(), last_words.size() - 1);
    std::copy_n(text.begin(), length, last_words.begin());
    last_words[length] = '\0';
    std::signal(SIGALRM, give_up);
    set_timer(seconds);
  }
  ~Watchdog() {
    set_timer(0);
    std::signal(SIGALRM, SIG_DFL);
  }
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
};

/// One line per checkpointed row: what a run must have to be continued from it.
std::string row_list(const StateTable& table) {
  constexpr const char* supports[] = {"vertex", "cell_point", "facet_point", "global"};
  std::ostringstream text;
  for (const auto& row : table.rows())
    if (row->checkpointed)
      text << row->name << " (" << supports[static_cast<int>(row->support)] << ", " << row->components
           << (row->surface.empty() ? "" : ", " + row->surface) << ")\n";
  return text.str();
}

bool lists(const std::string& rows, const std::string& name) {
  return ("\n" + rows).find("\n" + name + " (") != std::string::npos;
}

/// Such a list without the rows of these names that the other list lacks.
std::string without(const std::string& rows, const std::vector<std::string>& names,
                    const std::string& other) {
  std::istringstream lines(rows);
  std::string left;
  for (std::string line; std::getline(lines, line);) {
    const std::string name = line.substr(0, line.find(" ("));
    if (std::ranges::find(names, name) == names.end() || lists(other, name)) left += line + "\n";
  }
  return left;
}

/// The rows of the one list that the other one has not so.
std::string beyond(const std::string& rows, const std::string& other) {
  std::istringstream lines(rows);
  std::string left;
  for (std::string line; std::getline(lines, line);)
    if (("\n" + other).find("\n" + line + "\n") == std::string::npos) left += line + "\n";
  return left.empty() ? "nothing more" : in_one_line(left);
}

/// "/state" of a row, "/keys" of a set of entities.
std::string path_in(const std::string& group, std::string name) {
  std::ranges::replace(name, '/', '_');
  return group + "/" + name;
}

const Entities& set_of(const StateRow& row, const std::vector<Entities>& sets) {
  const std::string name = entities_name(row);
  return *std::ranges::find_if(sets, [&](const Entities& set) { return set.name == name; });
}

/// A row in the order of its entities. The buffer is that of all rows, one after the other.
hdf5::DataSet state_set(const CheckpointState& state, const StateRow& row, const Entities& set,
                        std::vector<double>& buffer) {
  const std::size_t width = row_width(state.mesh, state.groups, row);
  return hdf5::rows(path_in("/state", row.name), hdf5::Kind::real, set.slab, width,
                    [&state, &row, &set, &buffer, width] {
                      buffer.assign(set.slab.own * width, 0.0);
                      for_each_place(state.mesh, state.groups, row, false, [&](const RowPlace& place) {
                        for (std::size_t i = 0; i < place.count; ++i)
                          buffer[place.entity * width + i] = row.committed[place.at + i * place.stride];
                      });
                      return hdf5::bytes_of(buffer);
                    });
}

/// From the entities as stored, each rank a slab of them, to those of this rank, ghosts included. Collective.
/// Throws UserError(io) for another mesh.
Handle<PetscSF> from_stored(MPI_Comm comm, const std::string& file, const Entities& set, PetscLayout* slabs) {
  PetscInt begin = 0, own = PETSC_DECIDE, all = static_cast<PetscInt>(set.slab.all);
  check(PetscSplitOwnership(comm, &own, &all));
  MPI_Scan(&own, &begin, 1, MPIU_INT, MPI_SUM, comm);
  begin -= own;
  std::vector<double> known;
  bool found = true;
  agree_on_errors(comm, [&] {
    const hdf5::Reader stored(file);
    const std::string path = path_in("/keys", set.name);
    found = stored.extent(path).at(0) == set.slab.all;
    if (found) known = stored.rows(path, static_cast<hsize_t>(begin), static_cast<hsize_t>(own));
  });
  const std::vector<PetscInt> place = find_keys(comm, known, begin, set.keys);
  found = found && std::ranges::find(place, PetscInt{-1}) == place.end();
  if (!all_ranks_agree(comm, found))
    throw UserError(ExitCode::io,
                    "cannot use checkpoint " + file +
                        ": it belongs to another mesh; give the mesh, scale and refinement of its run");
  Handle<PetscSF> sf;
  check(PetscLayoutCreateFromSizes(comm, own, all, 1, slabs));
  check(PetscSFCreate(comm, sf.out()));
  check(PetscSFSetGraphLayout(sf, *slabs, static_cast<PetscInt>(place.size()), nullptr, PETSC_COPY_VALUES,
                              place.data()));
  return sf;
}

void read_row(const CheckpointState& state, const std::string& file, const Entities& set, PetscSF sf,
              PetscLayout slabs, StateRow& row) {
  const std::size_t width = row_width(state.mesh, state.groups, row);
  PetscInt begin = 0, end = 0;
  check(PetscLayoutGetRange(slabs, &begin, &end));
  std::vector<double> slab, mine(set.keys.size() / 2 * width);
  agree_on_errors(state.mesh.comm(), [&] {
    slab = hdf5::Reader(file).rows(path_in("/state", row.name), static_cast<hsize_t>(begin),
                                   static_cast<hsize_t>(end - begin));
    if (slab.size() != static_cast<std::size_t>(end - begin) * width)
      throw UserError(ExitCode::io,
                      "cannot use checkpoint " + file + ": row " + row.name + " has another size");
  });
  MPI_Datatype entity = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(width), MPI_DOUBLE, &entity);
  MPI_Type_commit(&entity);
  check(PetscSFBcastBegin(sf, entity, slab.data(), mine.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf, entity, slab.data(), mine.data(), MPI_REPLACE));
  MPI_Type_free(&entity);
  for_each_place(state.mesh, state.groups, row, true, [&](const RowPlace& place) {
    for (std::size_t i = 0; i < place.count; ++i)
      row.committed[place.at + i * place.stride] = mine[place.entity * width + i];
  });
  if (row.has_trial) row.trial = row.committed;
}

} // namespace

CheckpointWriter::CheckpointWriter(const CheckpointState& state, CheckpointFolder folder)
    : state_(state), folder_(std::move(folder)) {}

CheckpointWriter::~CheckpointWriter() = default;

std::string CheckpointWriter::write(const CheckpointValues& values) {
  const MPI_Comm comm = state_.mesh.comm();
  Checkpoint checkpoint{{}, values, row_list(state_.table), {}};
  on_rank_zero(comm, [&] {
    make_directories(folder_.dir);
    checkpoint.file = next_checkpoint_file(folder_.dir);
  });
  checkpoint.file = broadcast(comm, checkpoint.file);

  if (entities_.empty()) entities_ = entities_of(state_.mesh, state_.table);
  std::vector<double> buffer;
  std::vector<hdf5::DataSet> sets;
  for (const Entities& set : entities_)
    sets.push_back(hdf5::rows(path_in("/keys", set.name), hdf5::Kind::real, set.slab, 2,
                              [&set] { return std::as_bytes(std::span(set.keys).first(2 * set.slab.own)); }));
  for (const auto& row : state_.table.rows())
    if (row->checkpointed) sets.push_back(state_set(state_, *row, set_of(*row, entities_), buffer));
  std::optional<StoredMesh> mesh;
  if (state_.file != nullptr)
    std::ranges::move(mesh.emplace(comm, *state_.file).data_sets(), std::back_inserter(sets));
  double megabytes = 0;
  for (const hdf5::DataSet& set : sets)
    megabytes +=
        8e-6 * static_cast<double>(set.extent.size() > 1 ? set.extent[0] * set.extent[1] : set.extent[0]);
  const Watchdog watchdog(folder_.patience + megabytes,
                          "cannot write checkpoint " + checkpoint.file +
                              ": the write does not end (-checkpoint_patience); look at the disk, then "
                              "-restart auto goes on from the one before");
  const hdf5::Written written = hdf5::write_file(comm, checkpoint.file, sets);
  on_rank_zero(comm, [&] {
    publish_checkpoint(checkpoint, written);
    remove_old_checkpoints(folder_);
  });
  return checkpoint.file;
}

void read_checkpoint(const Checkpoint& checkpoint, CheckpointState state, const OtherRows& others) {
  const Timed timed(Event::checkpoint_read);
  const MPI_Comm comm = state.mesh.comm();
  const std::string &stored = checkpoint.rows, wanted = row_list(state.table);
  const std::string has = without(stored, others.in_vain, wanted),
                    needs = without(wanted, others.lacking, stored);
  if (has != needs)
    throw UserError(ExitCode::io, "cannot use checkpoint " + checkpoint.file + ": where it holds " +
                                      beyond(has, needs) + " this run needs " + beyond(needs, has) +
                                      "; restart with the physics of its run, and its -contact_<id>_method, "
                                      "_enforce and _impact where rows of contacts differ");
  for (const Entities& set : entities_of(state.mesh, state.table)) {
    std::vector<StateRow*> rows; // none of what the facets of a new contact know
    for (const auto& row : state.table.rows())
      if (row->checkpointed && entities_name(*row) == set.name && lists(stored, row->name))
        rows.push_back(row.get());
    if (rows.empty()) continue;
    PetscLayout slabs = nullptr;
    const Handle<PetscSF> sf = from_stored(comm, checkpoint.file, set, &slabs);
    for (StateRow* row : rows) read_row(state, checkpoint.file, set, sf, slabs, *row);
    check(PetscLayoutDestroy(&slabs));
  }
}

std::optional<GmshFile> read_checkpoint_mesh_file(MPI_Comm comm, const Checkpoint& checkpoint) {
  int found = 0;
  on_rank_zero(comm, [&] { found = hdf5::Reader(checkpoint.file).has("/mesh") ? 1 : 0; });
  MPI_Bcast(&found, 1, MPI_INT, 0, comm);
  if (found == 0) return {};
  return read_stored_mesh(comm, checkpoint.file);
}

} // namespace impact
