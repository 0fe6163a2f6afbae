#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <impact/petsc/error.hpp>
#include <impact/run/durable_file.hpp>
#include <unistd.h>

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

std::uint64_t file_checksum(const std::string& file, std::uintmax_t& size) {
  const Descriptor in(file, O_RDONLY, "cannot read");
  std::string buffer(std::size_t{1} << 20, '\0');
  Checksum sum;
  size = 0;
  while (const std::size_t got = in.read(buffer.data(), buffer.size())) {
    sum.add(buffer.data(), got);
    size += got;
  }
  return sum.value();
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

void rename_durably(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) fail("cannot write", to, errno);
  Descriptor(folder_of(to), O_RDONLY | O_DIRECTORY, "cannot write").sync();
}

void sync_file(const std::string& file) { Descriptor(file, O_RDONLY, "cannot write").sync(); }

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

} // namespace impact
