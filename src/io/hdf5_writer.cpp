#include <array>
#include <filesystem>
#include <impact/io/durable_file.hpp>
#include <impact/io/hdf5_id.hpp>
#include <impact/io/hdf5_writer.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <map>

namespace impact::hdf5 {

namespace {

/// HDF5 writes these parts of a file beside the numbers in its data sets: words of eight bytes by their
/// number.
using Words = std::map<std::uint64_t, std::array<char, 8>>;

/// A driver of HDF5 whose file is in memory, as far as it was written.
struct LayoutDriver : H5FD_t {
  haddr_t end = 0;
  Words* words = nullptr;

  static LayoutDriver& of(H5FD_t* file) { return *static_cast<LayoutDriver*>(file); }
  static H5FD_t* open(const char*, unsigned, hid_t access, haddr_t) {
    auto* driver = new LayoutDriver();
    driver->words = *static_cast<Words* const*>(H5Pget_driver_info(access));
    return driver;
  }
  static herr_t close(H5FD_t* file) {
    delete &of(file);
    return 0;
  }
  static haddr_t get_end(const H5FD_t* file, H5FD_mem_t) {
    return static_cast<const LayoutDriver*>(file)->end;
  }
  static herr_t set_end(H5FD_t* file, H5FD_mem_t, haddr_t address) {
    of(file).end = address;
    return 0;
  }
  char& byte(haddr_t at) { return (*words)[at / 8][at % 8]; }
  static herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, size_t bytes, const void* from) {
    for (std::size_t i = 0; i < bytes; ++i) of(file).byte(at + i) = static_cast<const char*>(from)[i];
    return 0;
  }
  static herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, size_t bytes, void* to) {
    for (std::size_t i = 0; i < bytes; ++i) static_cast<char*>(to)[i] = of(file).byte(at + i);
    return 0;
  }
  static const H5FD_class_t& description() {
    static const H5FD_class_t description = [] {
      H5FD_class_t d{};
      d.name = "impact_layout";
      d.maxaddr = HADDR_MAX - 1;
      d.fc_degree = H5F_CLOSE_STRONG;
      d.fapl_size = sizeof(Words*);
      d.open = open;
      d.close = close;
      d.get_eoa = d.get_eof = get_end;
      d.set_eoa = set_end;
      d.read = read;
      d.write = write;
      return d;
    }();
    return description;
  }
};

/// Where the numbers of the data sets go, by their order, and the size of the file.
struct Layout {
  std::vector<std::uint64_t> at; // [set], then the size
  Words words;
};

template <class T> T checked(T code, const std::string& path) {
  if (code < 0) throw std::logic_error("HDF5 cannot lay out " + path);
  return code;
}

Layout lay_out(const std::vector<DataSet>& sets) {
  Layout layout;
  Words* const words = &layout.words;
  const Id driver(checked(H5FDregister(&LayoutDriver::description()), "driver"), H5FDunregister),
      access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose), parents(H5Pcreate(H5P_LINK_CREATE), H5Pclose),
      creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_driver(access, driver, &words);
  H5Pset_alignment(access, 1, 8);
  H5Pset_create_intermediate_group(parents, 1);
  H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
  H5Pset_obj_track_times(creation, false); // equal numbers make equal files
  const Id file(checked(H5Fcreate("layout", H5F_ACC_TRUNC, H5P_DEFAULT, access), "file"), H5Fclose);
  for (const DataSet& set : sets) {
    const hid_t type = set.kind == Kind::real      ? H5T_IEEE_F64LE
                       : set.kind == Kind::integer ? H5T_STD_I64LE
                                                   : H5T_NATIVE_CHAR;
    const Id space(
        checked(H5Screate_simple(static_cast<int>(set.extent.size()), set.extent.data(), nullptr), set.path),
        H5Sclose);
    const Id made(
        checked(H5Dcreate2(file, set.path.c_str(), type, space, parents, creation, H5P_DEFAULT), set.path),
        H5Dclose);
    const haddr_t at = H5Dget_offset(made); // undefined for a set without numbers
    layout.at.push_back(at == HADDR_UNDEF ? 0 : at);
    if (layout.at.back() % 8 != 0) throw std::logic_error("HDF5 does not align " + set.path);
  }
  hsize_t size = 0;
  checked(H5Fflush(file, H5F_SCOPE_GLOBAL), "file");
  checked(H5Fget_filesize(file, &size), "file");
  layout.at.push_back(size);
  return layout;
}

/// Consecutive words go out together. Returns their sum.
std::uint64_t write_words(const DurableFile& out, const Words& words) {
  std::uint64_t sum = 0;
  for (auto at = words.begin(); at != words.end();) {
    const std::uint64_t first = at->first;
    std::vector<std::array<char, 8>> run;
    for (; at != words.end() && at->first == first + run.size(); ++at) run.push_back(at->second);
    out.write(8 * first, run.data(), 8 * run.size());
    sum += checksum(bytes_of(run), first);
  }
  return sum;
}

std::uint64_t write_own_part(const DurableFile& out, const std::vector<DataSet>& sets,
                             const std::vector<std::uint64_t>& offset) {
  std::uint64_t sum = 0;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    if (!sets[k].mine) continue;
    const std::span<const std::byte> bytes = sets[k].mine();
    const std::uint64_t at = offset[k] + (sets[k].kind == Kind::character ? 1 : 8) * sets[k].first;
    out.write(at, bytes.data(), bytes.size());
    out.begin_sync(); // the disk works while the next set is gathered
    sum += checksum(bytes, at / 8);
  }
  return sum;
}

} // namespace

Slab::Slab(MPI_Comm comm, std::size_t rows) : own(rows) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Exscan(&own, &first, 1, MPI_UINT64_T, MPI_SUM, comm);
  MPI_Allreduce(&own, &all, 1, MPI_UINT64_T, MPI_SUM, comm);
  if (rank == 0) first = 0;
}

DataSet rows(std::string path, Kind kind, const Slab& slab, std::uint64_t width,
             std::function<std::span<const std::byte>()> mine) {
  DataSet set{std::move(path), kind, {slab.all}, slab.first * width, std::move(mine)};
  if (width > 1) set.extent.push_back(width);
  return set;
}

Written write_file(MPI_Comm comm, const std::string& name, const std::vector<DataSet>& sets) {
  const std::string temporary = name + ".tmp";
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  Layout layout;
  layout.at.resize(sets.size() + 1);
  try {
    on_rank_zero(comm, [&] {
      layout = lay_out(sets);
      DurableFile(temporary, DurableFile::Mode::create, name).resize(layout.at.back());
    });
    MPI_Bcast(layout.at.data(), static_cast<int>(layout.at.size()), MPI_UINT64_T, 0, comm);
    std::uint64_t sum = 0;
    agree_on_errors(comm, [&] {
      const DurableFile out(temporary, DurableFile::Mode::update, name);
      sum = write_own_part(out, sets, layout.at);
      if (rank == 0) sum += write_words(out, layout.words);
      out.sync(); // on each rank what its node holds
    });
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm);
    on_rank_zero(comm, [&] { rename_durably(temporary, name); });
    return {layout.at.back(), sum};
  } catch (...) {
    if (rank == 0) {
      std::error_code ignored;
      std::filesystem::remove(temporary, ignored);
    }
    throw;
  }
}

} // namespace impact::hdf5
