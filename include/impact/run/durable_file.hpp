#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

/// Files that a kill, a full disk or a flipped bit cannot turn into wrong ones: replaced in one step, written
/// through to the disk, recognised by a checksum. Every function works on the calling rank alone and throws
/// UserError(io) that names the file and the system's reason.
namespace impact {

/// 64-bit FNV-1a. Each byte enters through invertible operations, so a change of a single byte is always
/// seen.
class Checksum {
public:
  void add(const void* data, std::size_t bytes);
  std::uint64_t value() const { return value_; }

private:
  std::uint64_t value_ = 14695981039346656037ULL;
};

/// `value` as 16 hexadecimal digits.
std::string to_hex(std::uint64_t value);

/// Checksum of a whole file; `size` receives its length in bytes. Words of eight bytes go in turn into eight
/// independent sums, so that it keeps up with memory; a step of a sum, (sum ^ word) * odd number, rotated,
/// can be undone, so a change within one word is always seen. Pieces of 8 MiB are summed by up to four
/// threads; their sums and the size make one by FNV-1a.
std::uint64_t file_checksum(const std::string& file, std::uintmax_t& size);
/// The bytes of a file.
std::string read_file(const std::string& file);
/// Makes a directory with its parents; one that exists is fine.
void make_directories(const std::string& dir);
/// Writes `text` to `<file>.tmp`, through to the disk, and renames it to `file`: a reader sees the old or the
/// new text.
void replace_file(const std::string& file, const std::string& text);
/// Renames within one directory; lasting only after the next sync of that directory (replace_file makes one).
void rename_file(const std::string& from, const std::string& to);
/// Renames within one directory and writes the directory's entry through to the disk.
void rename_durably(const std::string& from, const std::string& to);
/// Waits until what the system holds of a file is on the disk.
void sync_file(const std::string& file);
/// Asks the system to begin writing a file to the disk and returns at once; sync_file waits for the rest.
void begin_sync(const std::string& file);
/// Throws unless the file system of `file` can take `bytes` more (quotas included): they are allocated and
/// given back.
void require_space(const std::string& file, std::uintmax_t bytes);

/// A file that several ranks fill, each its own ranges. What it throws is UserError(io) "<what>: <reason>".
class SharedFile {
public:
  enum class Mode { create, fill, read }; ///< `create` empties it, `fill` wants it to exist
  SharedFile(const std::string& file, std::string what, Mode mode);
  ~SharedFile();
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;

  std::uint64_t size() const;
  void read(std::uint64_t at, void* data, std::uint64_t bytes) const;
  void write(std::uint64_t at, const void* data, std::uint64_t bytes) const;
  /// The disk begins to take what was written so far; a hint, without an error.
  void begin_sync() const;

private:
  [[noreturn]] void fail(int error) const;
  std::string what_;
  int id_ = -1;
};

} // namespace impact
