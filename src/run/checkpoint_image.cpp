#include <algorithm>
#include <filesystem>
#include <impact/run/checkpoint_image.hpp>

namespace impact {

namespace {

/// Ranges of a chunked data set whose chunks are slices of whole rows, so that each holds consecutive
/// numbers.
std::vector<FileRange> chunk_ranges(hid_t dataset, hid_t layout, const std::vector<hsize_t>& extent) {
  std::vector<hsize_t> chunk(extent.size()), at(extent.size(), 0);
  if (H5Pget_nfilters(layout) != 0 ||
      H5Pget_chunk(layout, static_cast<int>(chunk.size()), chunk.data()) != static_cast<int>(chunk.size()) ||
      !std::equal(chunk.begin() + 1, chunk.end(), extent.begin() + 1))
    return {};
  std::uint64_t row = sizeof(double);
  for (std::size_t i = 1; i < extent.size(); ++i) row *= extent[i];
  std::vector<FileRange> ranges;
  for (; at[0] < extent[0]; at[0] += chunk[0]) {
    unsigned filters = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t stored = 0;
    if (H5Dget_chunk_info_by_coord(dataset, at.data(), &filters, &address, &stored) < 0 ||
        address == HADDR_UNDEF || stored != row * chunk[0])
      return {};
    ranges.push_back({address, row * std::min<std::uint64_t>(chunk[0], extent[0] - at[0])});
  }
  return ranges;
}

} // namespace

std::vector<FileRange> data_ranges(const hdf5::File& file, const std::string& path) {
  const hdf5::Quiet quiet;
  const std::vector<hsize_t> extent = file.extent(path);
  const hdf5::Id dataset(H5Dopen2(file.id(), path.c_str(), H5P_DEFAULT), H5Dclose);
  const hdf5::Id type(H5Dget_type(dataset), H5Tclose);
  const hdf5::Id layout(H5Dget_create_plist(dataset), H5Pclose);
  if (extent.empty() || H5Tequal(type, H5T_NATIVE_DOUBLE) <= 0) return {};
  if (H5Pget_layout(layout) == H5D_CHUNKED) return chunk_ranges(dataset, layout, extent);
  const haddr_t address = H5Dget_offset(dataset);
  if (H5Pget_layout(layout) != H5D_CONTIGUOUS || address == HADDR_UNDEF) return {};
  return {{address, H5Dget_storage_size(dataset)}};
}

CheckpointImage::CheckpointImage(MPI_Comm comm, const std::string& file, std::vector<FileRange> gaps) {
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const SharedFile in(file, "cannot read " + file, SharedFile::Mode::read);
  gaps.push_back({in.size(), 0});
  std::sort(gaps.begin(), gaps.end(), [](const FileRange& a, const FileRange& b) { return a.at < b.at; });
  std::uint64_t common = in.size(), passed = 0, at = 0;
  for (const FileRange& gap : gaps) common -= gap.bytes;
  const auto begin_of = [&](int r) {
    return common / static_cast<std::uint64_t>(size) * static_cast<std::uint64_t>(r) +
           std::min(common % static_cast<std::uint64_t>(size), static_cast<std::uint64_t>(r));
  };
  const std::uint64_t begin = begin_of(rank), end = begin_of(rank + 1);
  for (const FileRange& gap : gaps) { // [at, gap.at) is common to all files; `passed` such bytes lie before
    const std::uint64_t here = gap.at - at;
    const std::uint64_t from = std::clamp(begin, passed, passed + here),
                        to = std::clamp(end, passed, passed + here);
    if (from < to) {
      parts_.push_back({at + (from - passed), std::vector<char>(to - from)});
      in.read(parts_.back().at, parts_.back().bytes.data(), parts_.back().bytes.size());
    }
    passed += here;
    at = gap.at + gap.bytes;
  }
}

void CheckpointImage::write(const SharedFile& out) const {
  for (const Part& part : parts_) out.write(part.at, part.bytes.data(), part.bytes.size());
}

void write_ranges(const SharedFile& out, const std::vector<FileRange>& ranges, std::uint64_t first,
                  const void* data, std::uint64_t bytes) {
  const auto* source = static_cast<const char*>(data);
  std::uint64_t passed = 0;
  for (const FileRange& range : ranges) {
    const std::uint64_t from = std::clamp(first, passed, passed + range.bytes),
                        to = std::clamp(first + bytes, passed, passed + range.bytes);
    if (from < to) out.write(range.at + (from - passed), source + (from - first), to - from);
    passed += range.bytes;
  }
}

} // namespace impact
