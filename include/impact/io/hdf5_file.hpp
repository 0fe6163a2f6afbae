#pragma once
#include <cstdint>
#include <functional>
#include <hdf5.h>
#include <mpi.h>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// HDF5 files whose data sets all ranks write and read by themselves, each its own rows. Failures are
/// UserError(io) that name the file and the reason. File sizes and offsets are 64 bits wide.
namespace impact::hdf5 {

/// Owns one HDF5 identifier.
class Id {
public:
  using Close = herr_t (*)(hid_t);
  Id() = default;
  Id(hid_t id, Close closer) : id_(id), close_(closer) {}
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Id& operator=(Id&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Id() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }

private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// A file to be read by this rank alone; HDF5 prints nothing of its own while it is open.
class Reader {
public:
  explicit Reader(std::string name);

  bool has(const std::string& path) const;                      ///< whose group exists
  std::vector<std::string> list(const std::string& path) const; ///< names in a group, sorted; none if missing
  std::vector<hsize_t> extent(const std::string& path) const;
  std::vector<double> numbers(const std::string& path) const;
  std::string text(const std::string& path) const;
  /// `count` rows (the slowest index) from the row `first` on.
  std::vector<double> rows(const std::string& path, hsize_t first, hsize_t count) const;

private:
  template <class T> T checked(T code, const std::string& what) const;

  struct Quiet {
    H5E_auto2_t printing = nullptr;
    void* data = nullptr;
    Quiet();
    ~Quiet();
    Quiet(const Quiet&) = delete;
    Quiet& operator=(const Quiet&) = delete;
  };

  std::string name_;
  Quiet quiet_; ///< before the file and after it
  Id id_;
};

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
