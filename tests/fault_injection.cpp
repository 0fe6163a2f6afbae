#include "fault_injection.hpp"
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <limits>
#include <memory>
#include <petscts.h>
#include <string>
#include <sys/types.h>
#include <unistd.h>
#include <vector>

namespace {

std::vector<std::string> words_of_fault() {
  const char* text = std::getenv("IMPACT_FAULT");
  std::vector<std::string> words(1);
  for (const char* c = text ? text : ""; *c != '\0'; ++c) {
    if (*c == ':')
      words.emplace_back();
    else
      words.back() += *c;
  }
  return words;
}

struct FileFault {
  bool kills = false, fills = false;
  long from = 0;
  std::string part = "checkpoint_";
};

const FileFault& file_fault() {
  static const FileFault fault = [] {
    FileFault made;
    const std::vector<std::string> words = words_of_fault();
    made.kills = words[0] == "kill";
    made.fills = words[0] == "full";
    if (words.size() > 1) made.from = std::atol(words[1].c_str());
    if (words.size() > 2) made.part = words[2];
    return made;
  }();
  return fault;
}

std::atomic<long> calls{0};

/// Evaluations of the motion's residual that still have a value; negative: all.
long sound_evaluations = -1;

/// True when the call on that path must fail.
bool fails(const char* path) {
  const FileFault& fault = file_fault();
  if (std::strstr(path, fault.part.c_str()) == nullptr) return false;
  const long number = ++calls;
  if (fault.kills && number == fault.from) kill(getpid(), SIGKILL);
  if (!fault.fills || number < fault.from) return false;
  errno = ENOSPC;
  return true;
}

bool fails(int file) {
  if (!file_fault().kills && !file_fault().fills) return false;
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length <= 0) return false;
  path[length] = '\0';
  return fails(path);
}

/// The library's function behind ours.
template <class Function> Function* original(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

} // namespace

// These stand before the library's functions for every part of the program.
namespace {

PetscErrorCode (*motion_residual)(SNES, Vec, Vec, void*) = nullptr;

PetscErrorCode faulty_residual(SNES snes, Vec x, Vec f, void* context) {
  if (const PetscErrorCode code = motion_residual(snes, x, f, context); code != 0 || sound_evaluations < 0)
    return code;
  if (sound_evaluations == 0) return SNESSetFunctionDomainError(snes);
  --sound_evaluations;
  return PetscErrorCode(0);
}

} // namespace

extern "C" {

ssize_t write(int file, const void* data, size_t bytes) {
  static const auto real = original<ssize_t(int, const void*, size_t)>("write");
  return fails(file) ? -1 : real(file, data, bytes);
}
ssize_t pwrite(int file, const void* data, size_t bytes, off_t at) {
  static const auto real = original<ssize_t(int, const void*, size_t, off_t)>("pwrite");
  return fails(file) ? -1 : real(file, data, bytes, at);
}
ssize_t pwrite64(int file, const void* data, size_t bytes, off64_t at) {
  static const auto real = original<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
  return fails(file) ? -1 : real(file, data, bytes, at);
}
int ftruncate(int file, off_t length) noexcept {
  static const auto real = original<int(int, off_t)>("ftruncate");
  return fails(file) ? -1 : real(file, length);
}
int fsync(int file) {
  static const auto real = original<int(int)>("fsync");
  return fails(file) ? -1 : real(file);
}
int rename(const char* from, const char* to) noexcept {
  static const auto real = original<int(const char*, const char*)>("rename");
  return fails(to) ? -1 : real(from, to);
}

// The residual of the motion is given to its solver through here.
PetscErrorCode SNESSetFunction(SNES snes, Vec f, PetscErrorCode (*residual)(SNES, Vec, Vec, void*),
                               void* context) {
  static const auto real =
      original<PetscErrorCode(SNES, Vec, PetscErrorCode(*)(SNES, Vec, Vec, void*), void*)>("SNESSetFunction");
  const char* prefix = nullptr;
  if (const PetscErrorCode code = SNESGetOptionsPrefix(snes, &prefix); code != 0) return code;
  if (prefix == nullptr || std::string(prefix) != "motion_") return real(snes, f, residual, context);
  motion_residual = residual;
  return real(snes, f, faulty_residual, context);
}

} // extern "C"

namespace impact {

namespace {

/// The row that every evaluation at a quadrature point, or at a node where there is no history, depends on.
StateRow* poisoned_row(StateTable& table) {
  for (const char* name : {"history", "phi"})
    if (table.find(name)) return &table.row(name);
  return nullptr;
}

} // namespace

StepProbe fault_probe() {
  const std::vector<std::string> words = words_of_fault();
  if (words[0] != "nan" && words[0] != "domain") return {};
  const auto number = [&](std::size_t i, long fallback) {
    return words.size() > i ? std::atol(words[i].c_str()) : fallback;
  };
  const long step_of_fault = number(1, 1), rank_of_fault = number(2, 0), tries = number(3, 1);
  StepProbe probe;
  if (words[0] == "domain") {
    const long evaluation = number(2, 1);
    probe.before = [=](const Attempt& attempt, long step, StateTable&) {
      sound_evaluations = step == step_of_fault && attempt.number == 1 ? evaluation - 1 : -1;
    };
    return probe;
  }
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank != rank_of_fault) return {};
  auto kept = std::make_shared<std::vector<double>>();
  probe.before = [=](const Attempt& attempt, long step, StateTable& table) {
    StateRow* row = poisoned_row(table);
    if (step != step_of_fault || attempt.number > tries || !row || row->committed.empty()) return;
    *kept = row->committed;
    row->committed[0] = row->trial[0] = std::numeric_limits<double>::quiet_NaN();
  };
  probe.after = [=](const Attempt&, long, StateTable& table) {
    StateRow* row = poisoned_row(table);
    if (kept->empty() || !row) return;
    row->committed = *kept;
    kept->clear();
  };
  return probe;
}

} // namespace impact
