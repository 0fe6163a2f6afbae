#include <cerrno>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <impact/petsc/error.hpp>
#include <impact/run/history_observer.hpp>
#include <impact/run/output_folder.hpp>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace impact {

namespace {

namespace fs = std::filesystem;

std::string own_name() {
  char host[256] = "", clock[32] = "";
  const std::time_t now = std::time(nullptr);
  gethostname(host, sizeof host - 1);
  std::strftime(clock, sizeof clock, "%Y-%m-%d %H:%M", std::localtime(&now));
  return "process " + std::to_string(getpid()) + " on " + host + ", since " + clock;
}

// A run that ends removes the file: the lock counts only while the name still leads to what was locked.
bool names(const std::string& file, int descriptor) {
  struct stat by_name {
  }, open{};
  return ::stat(file.c_str(), &by_name) == 0 && ::fstat(descriptor, &open) == 0 &&
         by_name.st_ino == open.st_ino && by_name.st_dev == open.st_dev;
}

int lock(const std::string& option, const std::string& folder, const std::string& file) {
  for (;;) {
    const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor < 0) throw UserError(ExitCode::io, "cannot write " + file + ": " + std::strerror(errno));
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(descriptor);
      throw UserError(ExitCode::io, "-" + option + " \"" + folder + "\": another run writes there (" +
                                        read_file(file) +
                                        "); wait for its end, or give this run a folder of its own");
    }
    if (names(file, descriptor)) return descriptor;
    ::close(descriptor);
  }
}

// Rows of steps beyond the start; without one nothing has been computed.
bool has_steps(const fs::path& history) {
  std::ifstream in(history);
  int rows = 0;
  for (std::string line; rows < 3 && std::getline(in, line);) rows += line.empty() || line[0] == '#' ? 0 : 1;
  return rows > 2;
}

fs::path free_folder(const fs::path& dir) {
  for (int n = 1;; ++n)
    if (fs::path folder = dir / ("earlier_" + std::to_string(n)); !fs::exists(folder)) return folder;
}

// The run writes these, by names below its folder.
std::vector<fs::path> own_files(const Scenario& s) {
  std::vector<fs::path> names{history_file_name(s)};
  if (default_checkpoint_dir(s) == s.checkpoint.dir) names.insert(names.begin(), "checkpoints");
  for (const OutputScenario& output : s.outputs)
    if (output.type == OutputScenario::Type::xdmf)
      for (const char* ending : {".xdmf", ".fields"})
        names.push_back(fs::path(output.file).replace_extension(ending));
  return names;
}

} // namespace

FolderLock::FolderLock(MPI_Comm comm, const std::string& option, const std::string& folder)
    : file_(folder + "/.impact.lock") {
  on_rank_zero(comm, [&] {
    try {
      make_directories(folder);
    } catch (const UserError& error) {
      throw UserError(ExitCode::io, "-" + option + " \"" + folder + "\": " + error.what() +
                                        "; allowed: a folder, or a path where one can be made");
    }
    descriptor_ = lock(option, folder, file_);
    const std::string name = own_name();
    if (::ftruncate(descriptor_, 0) != 0 || ::pwrite(descriptor_, name.data(), name.size(), 0) < 0)
      return; // a full disk: the lock holds without a name
  });
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  ::unlink(file_.c_str());
  ::close(descriptor_);
}

void set_earlier_run_aside(MPI_Comm comm, const Scenario& s, const std::optional<std::string>& resumed) {
  std::string moved;
  on_rank_zero(comm, [&] {
    std::error_code none;
    const fs::path here = s.output_dir;
    const bool goes_on =
        resumed && fs::equivalent(fs::path(*resumed).parent_path() / ".", s.checkpoint.dir, none);
    if (s.overwrite || goes_on || !has_steps(here / history_file_name(s))) return;
    const fs::path to = free_folder(here);
    for (const fs::path& name : own_files(s)) {
      if (!fs::exists(here / name, none)) continue;
      make_directories((to / name).parent_path().string());
      rename_file((here / name).string(), (to / name).string());
    }
    moved = to.string();
  });
  if (moved = broadcast(comm, moved); !moved.empty())
    check(PetscPrintf(
        comm, "impact: what an earlier run left in %s is now in %s (-output_overwrite on would replace it)\n",
        s.output_dir.c_str(), moved.c_str()));
}

} // namespace impact
