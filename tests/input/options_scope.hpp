#pragma once
#include <cstdio>
#include <fstream>
#include <impact/petsc/error.hpp>
#include <petscsys.h>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

/// An options database of its own for one test, in place of the program's.
class OptionsScope {
public:
  using Options = std::vector<std::pair<std::string, std::string>>;

  explicit OptionsScope(const Options& options = {}) {
    impact::check(PetscOptionsCreate(&database_));
    impact::check(PetscOptionsPush(database_));
    for (const auto& [key, value] : options)
      impact::check(PetscOptionsSetValue(nullptr, key.c_str(), value.c_str()));
  }
  OptionsScope(const OptionsScope&) = delete;
  OptionsScope& operator=(const OptionsScope&) = delete;
  ~OptionsScope() {
    PetscOptionsPop();
    PetscOptionsDestroy(&database_);
  }

  void set(const std::string& key, const std::string& value) {
    impact::check(PetscOptionsSetValue(nullptr, key.c_str(), value.c_str()));
  }
  void insert_file(const std::string& path) {
    impact::check(PetscOptionsInsertFile(PETSC_COMM_SELF, nullptr, path.c_str(), PETSC_TRUE));
  }

  /// A file of this process with the given content, in the folder of the test run; reused from call to call.
  static std::string file(const std::string& content, const std::string& ending = ".opts") {
    const std::string path = "options_scope_" + std::to_string(getpid()) + ending;
    std::ofstream(path) << content;
    return path;
  }

private:
  PetscOptions database_ = nullptr;
};
