#pragma once
#include <cstdint>
#include <functional>
#include <hdf5.h>
#include <mpi.h>
#include <span>
#include <string>
#include <vector>

/// Writing of HDF5 files, in which each rank puts its own rows. Failures are UserError(io) that name the file
/// and the reason.
namespace impact::hdf5 {

/// The part of this rank in rows that go over all ranks, in their order. The constructor is collective.
struct Slab {
  std::uint64_t first = 0, own = 0, all = 0;
  Slab(MPI_Comm comm, std::size_t rows);
};

enum class Kind { real, integer, character }; ///< 64 bits each; one byte

/// A data set, and the part of this rank: numbers from `first` on, all indices counted. All ranks name the
/// same sets; a rank with nothing to write gives no bytes. `mine` is called once, when its turn comes, and
/// its answer read before the next one is asked for. It must not communicate.
struct DataSet {
  std::string path; ///< its groups are made
  Kind kind;
  std::vector<hsize_t> extent; ///< over all ranks
  std::uint64_t first = 0;
  std::function<std::span<const std::byte>()> mine = {};
};

/// Rows of `width` numbers each, made when their turn comes.
DataSet rows(std::string path, Kind kind, const Slab& slab, std::uint64_t width,
             std::function<std::span<const std::byte>()> mine);

template <class Numbers> std::span<const std::byte> bytes_of(const Numbers& numbers) {
  return std::as_bytes(std::span(numbers));
}

template <class Values>
inline constexpr Kind kind_of = std::is_same_v<typename Values::value_type, char>     ? Kind::character
                                : std::is_same_v<typename Values::value_type, double> ? Kind::real
                                                                                      : Kind::integer;

/// Rows of `width` numbers each that live long enough.
template <class Values>
DataSet rows(std::string path, const Slab& slab, std::uint64_t width, const Values& values) {
  return rows(std::move(path), kind_of<Values>, slab, width, [&values] { return bytes_of(values); });
}

/// Values that live long enough, of rank 0 alone.
template <class Values> DataSet whole(MPI_Comm comm, std::string path, const Values& values) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  DataSet set{std::move(path), kind_of<Values>, {values.size()}};
  if (rank == 0) set.mine = [&values] { return bytes_of(values); };
  return set;
}

struct Written {
  std::uint64_t bytes = 0, checksum = 0; ///< size and sum of the file, as file_checksum finds them
};

/// Writes `<name>.tmp`, through to the disk, and renames it to `name`; nothing of it stays after a failure.
/// HDF5 lays the file out on rank 0 without touching the disk, where it would wait for other ranks or crash
/// at the end of the program when one of them is refused; then each rank puts its numbers where they belong.
/// Collective. Throws on all ranks.
Written write_file(MPI_Comm comm, const std::string& name, const std::vector<DataSet>& sets);

} // namespace impact::hdf5
