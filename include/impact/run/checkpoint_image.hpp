#pragma once
#include <cstdint>
#include <impact/run/durable_file.hpp>
#include <impact/run/hdf5_file.hpp>
#include <mpi.h>
#include <string>
#include <vector>

/// What all checkpoints of one mesh have in common, kept as bytes: HDF5 and PETSc lay out the first file, and
/// the ones that follow need only their numbers put in its gaps.
namespace impact {

struct FileRange {
  std::uint64_t at = 0, bytes = 0;
};

/// Where the doubles of a data set lie in its file, in their order; empty when they are not stored there one
/// after the other as this machine holds them.
std::vector<FileRange> data_ranges(const hdf5::File& file, const std::string& path);

class CheckpointImage {
public:
  /// Reads this rank's share of all bytes of `file` outside `gaps`. Throws UserError(io).
  CheckpointImage(MPI_Comm comm, const std::string& file, std::vector<FileRange> gaps);
  /// Writes that share. Throws UserError(io).
  void write(const SharedFile& out) const;

private:
  struct Part {
    std::uint64_t at;
    std::vector<char> bytes;
  };
  std::vector<Part> parts_;
};

/// Puts the bytes [first, first + bytes) of the data that fill `ranges` one after the other. Throws
/// UserError(io).
void write_ranges(const SharedFile& out, const std::vector<FileRange>& ranges, std::uint64_t first,
                  const void* data, std::uint64_t bytes);

} // namespace impact
