#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <impact/petsc/error.hpp>
#include <impact/run/durable_file.hpp>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace impact {

namespace {

[[noreturn]] void fail(const std::string& what, const std::string& file, int error) {
  throw UserError(ExitCode::io, what + " " + file + ": " + std::strerror(error));
}

class Descriptor {
public:
  Descriptor(const std::string& file, int flags, const char* what) : file_(file), what_(what) {
    do id_ = ::open(file.c_str(), flags | O_CLOEXEC, 0666);
    while (id_ < 0 && errno == EINTR);
    if (id_ < 0) fail(what_, file_, errno);
  }
  ~Descriptor() {
    if (id_ >= 0) ::close(id_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  std::size_t read(char* data, std::size_t bytes) const {
    for (;;) {
      const ssize_t got = ::read(id_, data, bytes);
      if (got >= 0) return static_cast<std::size_t>(got);
      if (errno != EINTR) fail(what_, file_, errno);
    }
  }
  void write(const char* data, std::size_t bytes) const {
    while (bytes > 0) {
      const ssize_t put = ::write(id_, data, bytes);
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) fail(what_, file_, errno);
      data += put;
      bytes -= static_cast<std::size_t>(put);
    }
  }
  void allocate(std::uintmax_t bytes) const {
    const int error = ::posix_fallocate(id_, 0, static_cast<off_t>(bytes));
    if (error != 0) fail(what_, file_, error);
  }
  void begin_sync() const { ::sync_file_range(id_, 0, 0, SYNC_FILE_RANGE_WRITE); }
  // Some file systems cannot sync a directory and say EINVAL; there is nothing better to do on them.
  void sync() const {
    if (::fsync(id_) != 0 && errno != EINVAL && errno != ENOTSUP) fail(what_, file_, errno);
  }

private:
  std::string file_;
  const char* what_;
  int id_ = -1;
};

std::string folder_of(const std::string& file) {
  const std::string folder = std::filesystem::path(file).parent_path().string();
  return folder.empty() ? "." : folder;
}

} // namespace

void Checksum::add(const void* data, std::size_t bytes) {
  const auto* byte = static_cast<const unsigned char*>(data);
  std::uint64_t value = value_;
  for (std::size_t i = 0; i < bytes; ++i) value = (value ^ byte[i]) * 1099511628211ULL;
  value_ = value;
}

std::string to_hex(std::uint64_t value) {
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; value >>= 4) text[i] = "0123456789abcdef"[value & 15];
  return text;
}

namespace {

constexpr std::uint64_t piece_bytes = std::uint64_t{8} << 20;

std::uint64_t piece_checksum(const SharedFile& in, std::uint64_t at, std::uint64_t bytes,
                             std::vector<char>& buffer) {
  constexpr std::size_t block = 64;
  std::array<std::uint64_t, 8> sum;
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = k + 1;
  while (bytes > 0) {
    const std::size_t held = std::min<std::uint64_t>(bytes, buffer.size());
    in.read(at, buffer.data(), held);
    const std::size_t whole = (held + block - 1) / block * block;
    std::memset(buffer.data() + held, 0, whole - held);
    for (std::size_t from = 0; from < whole; from += block) {
      std::array<std::uint64_t, 8> word;
      std::memcpy(word.data(), buffer.data() + from, block);
      for (std::size_t k = 0; k < sum.size(); ++k)
        sum[k] = std::rotl((sum[k] ^ word[k]) * 0x9e3779b97f4a7c15ULL, 29);
    }
    at += held;
    bytes -= held;
  }
  Checksum all;
  all.add(sum.data(), sizeof sum);
  return all.value();
}

} // namespace

std::uint64_t file_checksum(const std::string& file, std::uintmax_t& size) {
  constexpr std::uint64_t most_threads = 4; // copying from the system's cache does not gain from more
  const SharedFile in(file, "cannot read " + file, SharedFile::Mode::read);
  const std::uint64_t length = in.size();
  std::vector<std::uint64_t> sums((length + piece_bytes - 1) / piece_bytes);
  const std::uint64_t threads = std::clamp<std::uint64_t>(
      std::min<std::uint64_t>(sums.size(), std::thread::hardware_concurrency()), 1, most_threads);
  std::vector<std::exception_ptr> failures(threads);
  const auto work = [&](std::uint64_t first) noexcept {
    try {
      std::vector<char> buffer(std::size_t{1} << 18); // stays in the cache next to the processor
      for (std::uint64_t k = first; k < sums.size(); k += threads)
        sums[k] =
            piece_checksum(in, k * piece_bytes, std::min(piece_bytes, length - k * piece_bytes), buffer);
    } catch (...) {
      failures[first] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::uint64_t k = 1; k < threads; ++k) others.emplace_back(work, k);
    work(0);
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  Checksum all;
  all.add(sums.data(), sums.size() * sizeof(std::uint64_t));
  all.add(&length, sizeof length);
  size = length;
  return all.value();
}

std::string read_file(const std::string& file) {
  const Descriptor in(file, O_RDONLY, "cannot read");
  std::string text;
  std::array<char, 1 << 16> buffer;
  while (const std::size_t got = in.read(buffer.data(), buffer.size())) text.append(buffer.data(), got);
  return text;
}

void make_directories(const std::string& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir.empty() ? "." : dir, error);
  if (error) throw UserError(ExitCode::io, "cannot make directory " + dir + ": " + error.message());
}

void replace_file(const std::string& file, const std::string& text) {
  const std::string temporary = file + ".tmp";
  {
    const Descriptor out(temporary, O_WRONLY | O_CREAT | O_TRUNC, "cannot write");
    out.write(text.data(), text.size());
    out.sync();
  }
  rename_durably(temporary, file);
}

void rename_file(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) fail("cannot write", to, errno);
}

void rename_durably(const std::string& from, const std::string& to) {
  rename_file(from, to);
  Descriptor(folder_of(to), O_RDONLY | O_DIRECTORY, "cannot write").sync();
}

void sync_file(const std::string& file) { Descriptor(file, O_RDONLY, "cannot write").sync(); }

void begin_sync(const std::string& file) { Descriptor(file, O_RDONLY, "cannot write").begin_sync(); }

void require_space(const std::string& file, std::uintmax_t bytes) {
  const std::string probe = file + ".space";
  try {
    Descriptor(probe, O_WRONLY | O_CREAT | O_TRUNC, "cannot write").allocate(bytes);
  } catch (const UserError& error) {
    ::unlink(probe.c_str());
    throw UserError(ExitCode::io,
                    std::string(error.what()) + " (" + std::to_string(bytes) + " bytes are needed)");
  }
  ::unlink(probe.c_str());
}

SharedFile::SharedFile(const std::string& file, std::string what, Mode mode) : what_(std::move(what)) {
  const int flags = mode == Mode::create ? O_WRONLY | O_CREAT | O_TRUNC
                    : mode == Mode::fill ? O_WRONLY
                                         : O_RDONLY;
  do id_ = ::open(file.c_str(), flags | O_CLOEXEC, 0666);
  while (id_ < 0 && errno == EINTR);
  if (id_ < 0) fail(errno);
}

SharedFile::~SharedFile() { ::close(id_); }

void SharedFile::fail(int error) const { throw UserError(ExitCode::io, what_ + ": " + std::strerror(error)); }

std::uint64_t SharedFile::size() const {
  struct stat status {};
  if (::fstat(id_, &status) != 0) fail(errno);
  return static_cast<std::uint64_t>(status.st_size);
}

void SharedFile::read(std::uint64_t at, void* data, std::uint64_t bytes) const {
  for (auto* to = static_cast<char*>(data); bytes > 0;) {
    const ssize_t got = ::pread(id_, to, bytes, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(got < 0 ? errno : EIO);
    to += got;
    at += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::uint64_t>(got);
  }
}

void SharedFile::write(std::uint64_t at, const void* data, std::uint64_t bytes) const {
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

void SharedFile::begin_sync() const { ::sync_file_range(id_, 0, 0, SYNC_FILE_RANGE_WRITE); }

} // namespace impact
