#pragma once
#include <cstdint>
#include <hdf5.h>
#include <string>
#include <utility>
#include <vector>

/// The few calls of plain (serial) HDF5 that rank 0 needs. Failures are UserError(io) that name the file and
/// HDF5's innermost reason. File sizes and offsets are 64 bits wide.
namespace impact::hdf5 {

/// Switches HDF5's own error printing off for its lifetime; the reason is in our message.
class Quiet {
public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

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
  /// Closes now; false when HDF5 could not (a full disk shows here at the latest).
  bool close() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }

private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// An open file; what it throws names the file.
class File {
public:
  /// in_memory: nothing is on the disk, because HDF5 crashes at the end of a program when a disk fills while
  /// it writes; see image().
  enum class Mode { create, update, read, in_memory };
  File(std::string name, Mode mode);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  hid_t id() const { return id_; }
  const std::string& name() const { return name_; }
  bool has(const std::string& path) const; ///< every link on the way exists
  std::vector<std::string>
  list(const std::string& path) const;      ///< names in a group, sorted; none if it is missing
  void make_group(const std::string& path); ///< with its parents; one that exists is fine

  /// An empty data set of `type` (parents are made); write_slab fills rows [first, first + rows) of it.
  Id make_dataset(const std::string& path, hid_t type, const std::vector<hsize_t>& extent);
  void write_slab(const Id& dataset, hid_t type, hsize_t first, hsize_t rows, const void* data);

  void write(const std::string& path, const std::vector<double>& values);
  void write(const std::string& path, const std::string& text);
  std::vector<double> read_numbers(const std::string& path) const;
  std::string read_text(const std::string& path) const;
  std::vector<hsize_t> extent(const std::string& path) const;

  void set_attribute(const std::string& path, const std::string& name, double value);
  /// `fallback` when there is no such attribute.
  double attribute(const std::string& path, const std::string& name, double fallback) const;

  /// Writes everything out and closes.
  void close();
  /// The bytes of a file in memory, as they have to stand on the disk.
  std::string image() const;

private:
  [[noreturn]] void fail(const std::string& what) const;
  template <class T> T checked(T code, const std::string& what) const {
    if (code < 0) fail(what);
    return code;
  }

  std::string name_;
  Mode mode_;
  Id id_;
};

} // namespace impact::hdf5
