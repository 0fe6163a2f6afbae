#pragma once
#include <impact/io/hdf5_id.hpp>
#include <string>
#include <vector>

/// Reading of HDF5 files. Failures are UserError(io) that name the file and the reason. File sizes and
/// offsets are 64 bits wide.
namespace impact::hdf5 {

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

} // namespace impact::hdf5
