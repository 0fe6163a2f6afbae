#include <algorithm>
#include <impact/io/hdf5_reader.hpp>
#include <impact/petsc/error.hpp>

namespace impact::hdf5 {

namespace {

// The entry nearest to the cause; HDF5 puts the system's words there for failed reads.
std::string innermost_reason() {
  std::string reason;
  const auto collect = [](unsigned, const H5E_error2_t* entry, void* out) -> herr_t {
    if (entry->desc != nullptr && entry->desc[0] != '\0') *static_cast<std::string*>(out) = entry->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, collect, &reason);
  const std::string mark = "error message = '";
  if (const auto at = reason.find(mark); at != std::string::npos) {
    const auto from = at + mark.size();
    return reason.substr(from, reason.find('\'', from) - from);
  }
  return reason.empty() ? "HDF5 gives no reason" : reason;
}

hsize_t product(const std::vector<hsize_t>& extent) {
  hsize_t size = 1;
  for (const hsize_t n : extent) size *= n;
  return size;
}

} // namespace

template <class T> T Reader::checked(T code, const std::string& what) const {
  if (code < 0)
    throw UserError(ExitCode::io, "cannot read " + name_ + ": " + what + ": " + innermost_reason());
  return code;
}

Reader::Quiet::Quiet() {
  H5Eget_auto2(H5E_DEFAULT, &printing, &data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
Reader::Quiet::~Quiet() { H5Eset_auto2(H5E_DEFAULT, printing, data); }

Reader::Reader(std::string name)
    : name_(std::move(name)),
      id_(checked(H5Fopen(name_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), "open"), H5Fclose) {}

bool Reader::has(const std::string& path) const { return H5Lexists(id_, path.c_str(), H5P_DEFAULT) > 0; }

std::vector<std::string> Reader::list(const std::string& path) const {
  std::vector<std::string> names;
  if (!has(path)) return names;
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  const Id group(checked(H5Gopen2(id_, path.c_str(), H5P_DEFAULT), path), H5Gclose);
  checked(H5Literate(group, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, collect, &names), path);
  std::ranges::sort(names);
  return names;
}

std::vector<hsize_t> Reader::extent(const std::string& path) const {
  const Id set(checked(H5Dopen2(id_, path.c_str(), H5P_DEFAULT), path), H5Dclose);
  const Id space(checked(H5Dget_space(set), path), H5Sclose);
  std::vector<hsize_t> extent(static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space), path)));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  return extent;
}

std::vector<double> Reader::numbers(const std::string& path) const {
  return rows(path, 0, extent(path).at(0));
}

std::string Reader::text(const std::string& path) const {
  std::string text(product(extent(path)), '\0');
  if (text.empty()) return text;
  const Id set(checked(H5Dopen2(id_, path.c_str(), H5P_DEFAULT), path), H5Dclose);
  checked(H5Dread(set, H5T_NATIVE_CHAR, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()), path);
  return text;
}

std::vector<double> Reader::rows(const std::string& path, hsize_t first, hsize_t count) const {
  std::vector<hsize_t> slab = extent(path), start(slab.size(), 0);
  if (slab.empty() || first + count > slab[0])
    throw UserError(ExitCode::io, "cannot read " + name_ + ": " + path + ": too short");
  start[0] = first;
  slab[0] = count;
  std::vector<double> values(product(slab));
  if (values.empty()) return values;
  const Id set(checked(H5Dopen2(id_, path.c_str(), H5P_DEFAULT), path), H5Dclose);
  const Id space(checked(H5Dget_space(set), path), H5Sclose);
  const Id memory(checked(H5Screate_simple(static_cast<int>(slab.size()), slab.data(), nullptr), path),
                  H5Sclose);
  checked(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, slab.data(), nullptr), path);
  checked(H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()), path);
  return values;
}

} // namespace impact::hdf5
