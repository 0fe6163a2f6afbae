#include <algorithm>
#include <impact/petsc/error.hpp>
#include <impact/run/hdf5_file.hpp>

namespace impact::hdf5 {

namespace {

// The entry nearest to the cause; HDF5 puts the system's words there for failed reads and writes.
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

Id scalar() { return {H5Screate(H5S_SCALAR), H5Sclose}; }

} // namespace

Quiet::Quiet() {
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
Quiet::~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }

void File::fail(const std::string& what) const {
  throw UserError(ExitCode::io, std::string(mode_ == Mode::read ? "cannot read " : "cannot write ") + name_ +
                                    ": " + what + ": " + innermost_reason());
}

File::File(std::string name, Mode mode) : name_(std::move(name)), mode_(mode) {
  const Quiet quiet;
  const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // Objects forgotten by an earlier failure must not keep a file half open.
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  if (mode == Mode::in_memory) H5Pset_fapl_core(access, std::size_t{1} << 22, 0);
  const hid_t id = mode == Mode::create || mode == Mode::in_memory
                       ? H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access)
                       : H5Fopen(name_.c_str(), mode == Mode::read ? H5F_ACC_RDONLY : H5F_ACC_RDWR, access);
  id_ = Id(checked(id, "open"), H5Fclose);
}

File::~File() {
  const Quiet quiet;
  id_.close();
}

bool File::has(const std::string& path) const {
  const Quiet quiet;
  for (std::size_t at = path.find('/', 1);; at = path.find('/', at + 1)) {
    if (H5Lexists(id_, path.substr(0, at).c_str(), H5P_DEFAULT) <= 0) return false;
    if (at == std::string::npos) return true;
  }
}

std::vector<std::string> File::list(const std::string& path) const {
  const Quiet quiet;
  std::vector<std::string> names;
  if (!has(path)) return names;
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  const Id group(checked(H5Gopen2(id_, path.c_str(), H5P_DEFAULT), path), H5Gclose);
  checked(H5Literate(group, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, collect, &names), path);
  std::sort(names.begin(), names.end());
  return names;
}

void File::make_group(const std::string& path) {
  const Quiet quiet;
  if (has(path)) return;
  const Id parents(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(parents, 1);
  Id(checked(H5Gcreate2(id_, path.c_str(), parents, H5P_DEFAULT, H5P_DEFAULT), path), H5Gclose);
}

Id File::make_dataset(const std::string& path, hid_t type, const std::vector<hsize_t>& extent) {
  const Quiet quiet;
  const Id parents(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(parents, 1);
  const Id space(checked(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), path),
                 H5Sclose);
  return {checked(H5Dcreate2(id_, path.c_str(), type, space, parents, H5P_DEFAULT, H5P_DEFAULT), path),
          H5Dclose};
}

void File::write_slab(const Id& dataset, hid_t type, hsize_t first, hsize_t rows, const void* data) {
  const Quiet quiet;
  if (rows == 0) return;
  const Id file_space(checked(H5Dget_space(dataset), "data space"), H5Sclose);
  std::vector<hsize_t> count(
      static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(file_space), "rank")));
  std::vector<hsize_t> start(count.size(), 0);
  H5Sget_simple_extent_dims(file_space, count.data(), nullptr);
  start[0] = first;
  count[0] = rows;
  checked(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
          "slab");
  const Id space(checked(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), "slab"),
                 H5Sclose);
  checked(H5Dwrite(dataset, type, space, file_space, H5P_DEFAULT, data), "write");
}

void File::write(const std::string& path, const std::vector<double>& values) {
  write_slab(make_dataset(path, H5T_NATIVE_DOUBLE, {values.size()}), H5T_NATIVE_DOUBLE, 0, values.size(),
             values.data());
}

void File::write(const std::string& path, const std::string& text) {
  write_slab(make_dataset(path, H5T_NATIVE_CHAR, {text.size()}), H5T_NATIVE_CHAR, 0, text.size(),
             text.data());
}

std::vector<hsize_t> File::extent(const std::string& path) const {
  const Quiet quiet;
  const Id dataset(checked(H5Dopen2(id_, path.c_str(), H5P_DEFAULT), path), H5Dclose);
  const Id space(checked(H5Dget_space(dataset), path), H5Sclose);
  std::vector<hsize_t> extent(static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space), path)));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  return extent;
}

std::vector<double> File::read_numbers(const std::string& path) const {
  const Quiet quiet;
  hsize_t size = 1;
  for (hsize_t n : extent(path)) size *= n;
  std::vector<double> values(size);
  const Id dataset(checked(H5Dopen2(id_, path.c_str(), H5P_DEFAULT), path), H5Dclose);
  if (size > 0)
    checked(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), path);
  return values;
}

std::string File::read_text(const std::string& path) const {
  const Quiet quiet;
  std::string text(extent(path).at(0), '\0');
  const Id dataset(checked(H5Dopen2(id_, path.c_str(), H5P_DEFAULT), path), H5Dclose);
  if (!text.empty())
    checked(H5Dread(dataset, H5T_NATIVE_CHAR, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()), path);
  return text;
}

void File::set_attribute(const std::string& path, const std::string& name, double value) {
  const Quiet quiet;
  const Id object(checked(H5Oopen(id_, path.c_str(), H5P_DEFAULT), path), H5Oclose);
  const Id attribute(
      checked(H5Acreate2(object, name.c_str(), H5T_NATIVE_DOUBLE, scalar(), H5P_DEFAULT, H5P_DEFAULT), path),
      H5Aclose);
  checked(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), path);
}

double File::attribute(const std::string& path, const std::string& name, double fallback) const {
  const Quiet quiet;
  if (H5Aexists_by_name(id_, path.c_str(), name.c_str(), H5P_DEFAULT) <= 0) return fallback;
  const Id attribute(
      checked(H5Aopen_by_name(id_, path.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), path), H5Aclose);
  double value = fallback;
  checked(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), path);
  return value;
}

void File::close() {
  const Quiet quiet;
  if (mode_ != Mode::read) checked(H5Fflush(id_, H5F_SCOPE_GLOBAL), "flush");
  if (!id_.close()) fail("close");
}

std::string File::image() const {
  const Quiet quiet;
  checked(H5Fflush(id_, H5F_SCOPE_GLOBAL), "flush");
  std::string bytes(static_cast<std::size_t>(checked(H5Fget_file_image(id_, nullptr, 0), "size")), '\0');
  checked(H5Fget_file_image(id_, bytes.data(), bytes.size()), "image");
  return bytes;
}

} // namespace impact::hdf5
