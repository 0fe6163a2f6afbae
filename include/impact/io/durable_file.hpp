#pragma once
#include <impact/io/checksum.hpp>
#include <vector>

/// Files that a kill, a full disk or a flipped bit cannot turn into wrong ones: replaced in one step, written
/// through to the disk, recognised by a checksum. Every function works on the calling rank alone and throws
/// UserError(io) that names the file and the system's reason.
namespace impact {

/// Checksum of a whole file (checksum.hpp); `size` receives its length in bytes.
std::uint64_t file_checksum(const std::string& file, std::uint64_t& size);
/// The bytes of a file.
std::string read_file(const std::string& file);
/// Names in a directory, sorted; none where it is missing.
std::vector<std::string> names_in(const std::string& dir);
/// Makes a directory with its parents; one that exists is fine.
void make_directories(const std::string& dir);
/// Writes `text` to `<file>.tmp`, through to the disk, and renames it to `file`: a reader sees the old or the
/// new text.
void replace_file(const std::string& file, const std::string& text);
/// Renames within one directory; lasting only after the next sync of that directory (replace_file makes one).
void rename_file(const std::string& from, const std::string& to);
/// Renames within one directory and writes the directory's entry through to the disk.
void rename_durably(const std::string& from, const std::string& to);
/// Removes a file; one that is not there is fine.
void remove_file(const std::string& file);

/// An open file, read and written by place, so that several ranks can fill one. What it throws is
/// UserError(io) "<what> <name>: <reason>".
class DurableFile {
public:
  enum class Mode { read, create, update }; ///< `create` empties it, `update` wants it to exist
  /// `name` stands for the file in messages where that has another name for a while.
  DurableFile(const std::string& file, Mode mode, const std::string& name = {});
  ~DurableFile();
  DurableFile(const DurableFile&) = delete;
  DurableFile& operator=(const DurableFile&) = delete;

  std::uint64_t size() const;
  void read(std::uint64_t at, void* data, std::uint64_t bytes) const;
  void write(std::uint64_t at, const void* data, std::uint64_t bytes) const;
  void resize(std::uint64_t bytes) const;
  /// The disk begins to take what was written so far; a hint, without an error.
  void begin_sync() const;
  /// Waits until what the system holds of the file is on the disk.
  void sync() const;

private:
  [[noreturn]] void fail(int error) const;
  std::string what_;
  int id_ = -1;
};

} // namespace impact
