#pragma once
#include <impact/io/checkpoint.hpp>
#include <impact/io/hdf5_file.hpp>

/// A checkpoint's place in its directory. On rank 0 alone.
namespace impact {

/// A name in `dir` that was never used before: one above the highest number there.
std::string next_checkpoint_file(const std::string& dir);
/// Turns <file>.tmp into the file that the checkpoint names and writes its manifest, both names through to
/// the disk.
void publish_checkpoint(const Checkpoint& checkpoint, const hdf5::Written& written);
/// Removes all but the newest `keep` and whatever unfinished files earlier kills left.
void remove_old_checkpoints(const CheckpointFolder& folder);

/// Lines, each with its end, as one with semicolons between them.
std::string in_one_line(std::string lines);

} // namespace impact
