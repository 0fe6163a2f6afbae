#include <algorithm>
#include <array>
#include <cstring>
#include <impact/run/checkpoint_file.hpp>
#include <map>

namespace impact {

namespace {

using Key = std::array<double, 2>;

std::uint64_t mixed(std::uint64_t x) { // the finaliser of splitmix64
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

std::uint64_t combined(std::uint64_t seed, std::uint64_t value) {
  return mixed(seed + 0x9e3779b97f4a7c15ULL + mixed(value));
}

// 40 bits each: some thousand of them can be added in doubles without rounding.
Key key_of(std::uint64_t a, std::uint64_t b) {
  return {static_cast<double>(a >> 24), static_cast<double>(b >> 24)};
}

std::uint64_t bits(double x) {
  std::uint64_t value;
  x += 0.0; // one zero, whatever its sign
  std::memcpy(&value, &x, sizeof value);
  return value;
}

std::vector<std::uint64_t> region_marks(const Mesh& mesh) {
  std::vector<std::uint64_t> mark(static_cast<std::size_t>(mesh.cell_count()), 0);
  for (const Group& group : mesh.groups()) {
    if (group.dim != mesh.dim()) continue;
    std::uint64_t name = 0;
    for (const char c : group.name) name = combined(name, static_cast<unsigned char>(c));
    for (const PetscInt point : mesh.region_cells(group.name))
      mark[static_cast<std::size_t>(point - mesh.cell_start())] += mixed(name);
  }
  return mark;
}

// A facet between two ranks is summed from both sides. Sums of integers: the order does not matter.
void add_over_ranks(const Mesh& mesh, std::vector<double>& values) {
  PetscSF sf = nullptr;
  PetscInt roots = 0;
  check(DMGetPointSF(mesh.dm(), &sf));
  check(PetscSFGetGraph(sf, &roots, nullptr, nullptr, nullptr));
  if (roots < 0) return;
  const std::vector<double> leaf = values;
  check(PetscSFReduceBegin(sf, MPIU_REAL, leaf.data(), values.data(), MPI_SUM));
  check(PetscSFReduceEnd(sf, MPIU_REAL, leaf.data(), values.data(), MPI_SUM));
  const std::vector<double> root = values;
  check(PetscSFBcastBegin(sf, MPIU_REAL, root.data(), values.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf, MPIU_REAL, root.data(), values.data(), MPI_REPLACE));
}

/// Sends rows to the ranks `target[k]`; returns what this rank got and from whom. Collective.
struct Parcel {
  double key[2];
  std::int64_t tag; // place in the list of known keys, or in the sender's list of wanted ones
  std::int64_t from;
};

std::vector<Parcel> exchange(MPI_Comm comm, const std::vector<Parcel>& out, const std::vector<int>& target) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  const auto ranks = static_cast<std::size_t>(size);
  std::vector<int> send(ranks, 0), receive(ranks, 0), from(ranks + 1, 0), to(ranks + 1, 0);
  for (const int t : target) ++send[static_cast<std::size_t>(t)];
  MPI_Alltoall(send.data(), 1, MPI_INT, receive.data(), 1, MPI_INT, comm);
  for (std::size_t r = 0; r < ranks; ++r) {
    to[r + 1] = to[r] + send[r];
    from[r + 1] = from[r] + receive[r];
  }
  std::vector<Parcel> sorted(out.size()), got(static_cast<std::size_t>(from[ranks]));
  std::vector<int> next(to.begin(), to.end() - 1);
  for (std::size_t k = 0; k < out.size(); ++k)
    sorted[static_cast<std::size_t>(next[static_cast<std::size_t>(target[k])]++)] = out[k];
  MPI_Datatype parcel = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(sizeof(Parcel), MPI_BYTE, &parcel);
  MPI_Type_commit(&parcel);
  MPI_Alltoallv(sorted.data(), send.data(), to.data(), parcel, got.data(), receive.data(), from.data(),
                parcel, comm);
  MPI_Type_free(&parcel);
  return got;
}

// Keys meet on the rank that their bits name.
std::vector<int> meeting_ranks(const std::vector<Parcel>& parcels, int size) {
  std::vector<int> target;
  for (const Parcel& p : parcels)
    target.push_back(
        static_cast<int>(mixed(static_cast<std::uint64_t>(p.key[0])) % static_cast<unsigned>(size)));
  return target;
}

std::vector<Parcel> parcels(const std::vector<double>& keys, std::int64_t first_tag, int rank) {
  std::vector<Parcel> list;
  for (std::size_t k = 0; k < keys.size() / 2; ++k)
    list.push_back({{keys[2 * k], keys[2 * k + 1]}, first_tag + static_cast<std::int64_t>(k), rank});
  return list;
}

} // namespace

std::vector<double> point_keys(const Mesh& mesh) {
  PetscInt end = 0;
  check(DMPlexGetChart(mesh.dm(), nullptr, &end));
  std::vector<double> part[2];
  for (auto& p : part) p.assign(static_cast<std::size_t>(end), 0);
  const std::vector<std::uint64_t> mark = region_marks(mesh);
  const PetscInt vertex_start = mesh.vertex_point(0), vertex_end = mesh.vertex_point(mesh.node_count());
  const auto dim = static_cast<std::size_t>(mesh.dim());

  for (PetscInt cell = mesh.cell_start(); cell < mesh.cell_start() + mesh.cell_count(); ++cell) {
    PetscInt size = 0, *closure = nullptr;
    check(DMPlexGetTransitiveClosure(mesh.dm(), cell, PETSC_TRUE, &size, &closure));
    std::uint64_t identity = mark[static_cast<std::size_t>(cell - mesh.cell_start())];
    for (PetscInt k = 0; k < size; ++k) {
      if (closure[2 * k] < vertex_start || closure[2 * k] >= vertex_end) continue;
      const auto node = static_cast<std::size_t>(closure[2 * k] - vertex_start);
      for (std::size_t i = 0; i < dim; ++i)
        identity = combined(identity, bits(mesh.coordinates()[node * dim + i]));
    }
    for (PetscInt k = 0; k < size; ++k) {
      const auto place = static_cast<std::uint64_t>(2 * k);
      const Key key = key_of(combined(identity, place), combined(identity, place + 1));
      for (std::size_t i = 0; i < 2; ++i) part[i][static_cast<std::size_t>(closure[2 * k])] += key[i];
    }
    check(DMPlexRestoreTransitiveClosure(mesh.dm(), cell, PETSC_TRUE, &size, &closure));
  }
  for (auto& p : part) add_over_ranks(mesh, p);
  std::vector<double> keys(2 * static_cast<std::size_t>(end));
  for (std::size_t k = 0; k < keys.size(); ++k) keys[k] = part[k % 2][k / 2];
  return keys;
}

std::vector<PetscInt> find_keys(MPI_Comm comm, const std::vector<double>& known,
                                const std::vector<double>& wanted) {
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  std::int64_t mine = static_cast<std::int64_t>(known.size() / 2), before = 0;
  MPI_Exscan(&mine, &before, 1, MPI_INT64_T, MPI_SUM, comm);
  if (rank == 0) before = 0;

  const auto offers = parcels(known, before, rank), questions = parcels(wanted, 0, rank);
  std::map<Key, std::int64_t> place;
  for (const Parcel& p : exchange(comm, offers, meeting_ranks(offers, size))) {
    const auto [at, is_new] = place.try_emplace({p.key[0], p.key[1]}, p.tag);
    if (!is_new) at->second = -1;
  }
  std::vector<Parcel> answers;
  std::vector<int> back;
  for (Parcel p : exchange(comm, questions, meeting_ranks(questions, size))) {
    const auto found = place.find({p.key[0], p.key[1]});
    back.push_back(static_cast<int>(p.from));
    p.from = found == place.end() ? -1 : found->second;
    answers.push_back(p);
  }
  std::vector<PetscInt> result(wanted.size() / 2, -1);
  for (const Parcel& p : exchange(comm, answers, back))
    result[static_cast<std::size_t>(p.tag)] = static_cast<PetscInt>(p.from);
  return result;
}

} // namespace impact
