#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <impact/io/durable_file.hpp>
#include <impact/petsc/error.hpp>
#include <sys/stat.h>
#include <unistd.h>

namespace impact {

namespace fs = std::filesystem;

DurableFile::DurableFile(const std::string& file, Mode mode, const std::string& name)
    : what_((mode == Mode::read ? "cannot read " : "cannot write ") + (name.empty() ? file : name)) {
  const int flags = mode == Mode::read     ? O_RDONLY
                    : mode == Mode::create ? O_WRONLY | O_CREAT | O_TRUNC
                                           : O_WRONLY;
  do id_ = ::open(file.c_str(), flags | O_CLOEXEC, 0666);
  while (id_ < 0 && errno == EINTR);
  if (id_ < 0) fail(errno);
}

DurableFile::~DurableFile() { ::close(id_); }

void DurableFile::fail(int error) const {
  throw UserError(ExitCode::io, what_ + ": " + std::strerror(error));
}

std::uint64_t DurableFile::size() const {
  struct stat status {};
  if (::fstat(id_, &status) != 0) fail(errno);
  return static_cast<std::uint64_t>(status.st_size);
}

void DurableFile::read(std::uint64_t at, void* data, std::uint64_t bytes) const {
  for (auto* to = static_cast<char*>(data); bytes > 0;) {
    const ssize_t got = ::pread(id_, to, bytes, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(got < 0 ? errno : EIO);
    to += got;
    at += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::uint64_t>(got);
  }
}

void DurableFile::write(std::uint64_t at, const void* data, std::uint64_t bytes) const {
  // In pieces: Linux takes up to ten times as long for tens of megabytes in one call.
  constexpr std::uint64_t piece = 1U << 20;
  for (const auto* from = static_cast<const char*>(data); bytes > 0;) {
    const ssize_t put = ::pwrite(id_, from, std::min(bytes, piece), static_cast<off_t>(at));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) fail(errno);
    from += put;
    at += static_cast<std::uint64_t>(put);
    bytes -= static_cast<std::uint64_t>(put);
  }
}

void DurableFile::resize(std::uint64_t bytes) const {
  if (::ftruncate(id_, static_cast<off_t>(bytes)) != 0) fail(errno);
}

void DurableFile::begin_sync() const { ::sync_file_range(id_, 0, 0, SYNC_FILE_RANGE_WRITE); }

// Some file systems cannot sync a directory and say EINVAL; there is nothing better to do on them.
void DurableFile::sync() const {
  if (::fsync(id_) != 0 && errno != EINVAL && errno != ENOTSUP) fail(errno);
}

std::uint64_t file_checksum(const std::string& file, std::uint64_t& size) {
  const DurableFile in(file, DurableFile::Mode::read);
  std::vector<std::byte> buffer(std::size_t{1} << 18); // stays in the cache next to the processor
  size = in.size();
  std::uint64_t sum = 0;
  for (std::uint64_t at = 0; at < size; at += buffer.size()) {
    const std::size_t held = std::min<std::uint64_t>(size - at, buffer.size());
    in.read(at, buffer.data(), held);
    sum += checksum(std::span(buffer).first(held), at / 8);
  }
  return sum;
}

std::string read_file(const std::string& file) {
  const DurableFile in(file, DurableFile::Mode::read);
  std::string text(in.size(), '\0');
  in.read(0, text.data(), text.size());
  return text;
}

std::vector<std::string> names_in(const std::string& dir) {
  std::vector<std::string> names;
  std::error_code error;
  fs::directory_iterator entries(dir, error);
  if (error == std::errc::no_such_file_or_directory) return names;
  if (error) throw UserError(ExitCode::io, "cannot read directory " + dir + ": " + error.message());
  for (const auto& entry : entries) names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

void make_directories(const std::string& dir) {
  std::error_code error;
  fs::create_directories(dir.empty() ? "." : dir, error);
  if (error) throw UserError(ExitCode::io, "cannot make directory " + dir + ": " + error.message());
}

void replace_file(const std::string& file, const std::string& text) {
  const std::string temporary = file + ".tmp";
  {
    const DurableFile out(temporary, DurableFile::Mode::create);
    out.write(0, text.data(), text.size());
    out.sync();
  }
  rename_durably(temporary, file);
}

void rename_file(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0)
    throw UserError(ExitCode::io, "cannot write " + to + ": " + std::strerror(errno));
}

void rename_durably(const std::string& from, const std::string& to) {
  rename_file(from, to);
  const std::string folder = fs::path(to).parent_path().string();
  const DurableFile directory(folder.empty() ? "." : folder, DurableFile::Mode::read, to);
  directory.sync();
}

void remove_file(const std::string& file) {
  std::error_code error;
  fs::remove(file, error);
  if (error) throw UserError(ExitCode::io, "cannot remove " + file + ": " + error.message());
}

} // namespace impact
