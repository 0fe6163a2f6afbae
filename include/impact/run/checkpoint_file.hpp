#pragma once
#include <cstdint>
#include <impact/mesh/gmsh.hpp>
#include <impact/petsc/error.hpp>
#include <impact/run/checkpoint.hpp>
#include <impact/run/hdf5_file.hpp>
#include <optional>

/// The parts a checkpoint is made of: its place in the directory (rank 0 alone) and the identity of mesh
/// points.
namespace impact {

inline constexpr double checkpoint_version = 1;

/// A name in `dir` that was never used before: one above the highest number there.
std::string next_checkpoint_file(const std::string& dir);
/// Writes <file>.tmp through to the disk and returns the manifest of `file`.
std::string seal_checkpoint(const std::string& file, const CheckpointValues& values);
/// Turns <file>.tmp into `file` and writes its manifest, both names through to the disk.
void publish_checkpoint(const std::string& file, const std::string& manifest);
/// Removes all but the newest `keep` and whatever unfinished files earlier kills left.
void remove_old_checkpoints(const CheckpointFolder& folder);
/// Why a file cannot be trusted, empty when size, checksum and manifest agree.
std::string fault_of_checkpoint(const std::string& file);
void write_values(hdf5::File& file, const CheckpointValues& values);
CheckpointValues read_values(const hdf5::File& file);

/// The mesh of the run as its file had it, before it was refined, distributed and ordered.
void write_stored_mesh(hdf5::File& file, const GmshFile& mesh);
/// What write_stored_mesh wrote into a checkpoint; none in those of older versions. Throws UserError(io).
std::optional<GmshFile> read_stored_mesh(const std::string& checkpoint);

/// Two numbers per mesh point, [point][2], that depend on the coordinates and regions of the cells around it
/// and on the place of the point in them, not on ranks or numbering; equal on all ranks that share a point.
/// Integers below 2^53, so that sums are exact in any order. Collective.
std::vector<double> point_keys(const Mesh& mesh);

/// For each of `wanted` ([k][2]) the place of the same key in the list that the ranks' `known` ([k][2]) form
/// together in rank order; -1 where there is none or more than one. Collective.
std::vector<PetscInt> find_keys(MPI_Comm comm, const std::vector<double>& known,
                                const std::vector<double>& wanted);

} // namespace impact
