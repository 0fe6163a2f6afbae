#pragma once
#include <impact/io/checkpoint.hpp>
#include <impact/io/hdf5_writer.hpp>

/// A checkpoint's place in its directory. On rank 0 alone.
namespace impact {

/// A name in `dir` that was never used before: one above the highest number there.
std::string next_checkpoint_file(const std::string& dir);
/// Writes the manifest of a checkpoint whose file is on the disk. Had the disk only the manifest after a
/// crash, the checkpoint would count as damaged and the one before, which is removed later, as the newest.
void publish_checkpoint(const Checkpoint& checkpoint, const hdf5::Written& written);
/// Removes all but the newest `keep` and whatever unfinished files earlier kills left.
void remove_old_checkpoints(const CheckpointFolder& folder);

/// Lines, each with its end, as one with semicolons between them.
std::string in_one_line(const std::string& lines);

} // namespace impact
