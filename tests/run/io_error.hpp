#pragma once
#include <functional>
#include <gtest/gtest.h>
#include <impact/petsc/error.hpp>
#include <string>

namespace impact::run_test {

/// What the failure of reading or writing says that `body` ends with; empty where it ends well.
inline std::string io_error_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::io) << error.what();
    return error.what();
  }
  return {};
}

} // namespace impact::run_test
