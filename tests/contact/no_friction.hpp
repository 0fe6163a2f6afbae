#pragma once
#include <gtest/gtest.h>
#include <impact/petsc/error.hpp>
#include <impact/petsc/handle.hpp>
#include <petscvec.h>

namespace impact::contact_test {

/// Two set-ups alike but for the coefficient, `smooth` without one: the rough one pushes otherwise, and like
/// the smooth one while a projection suspends its friction; the smooth one loses nothing. `norm`: of a
/// vector.
template <class Sliding, class Norm>
void expect_friction_only_in(Sliding& rough, Sliding& smooth, Norm&& norm) {
  const Handle<Vec> with = rough.residual(rough.u), without = smooth.residual(smooth.u);
  rough.contact.begin_projection();
  smooth.contact.begin_projection();
  const Handle<Vec> suspended = rough.residual(rough.u), projected = smooth.residual(smooth.u);
  check(VecAXPY(with, -1, without));
  check(VecAXPY(suspended, -1, projected));
  EXPECT_GT(norm(with), 0.01 * norm(without));
  EXPECT_LE(norm(suspended), 1e-14 * norm(projected));
  smooth.contact.end_projection();
  EXPECT_EQ(smooth.contact.step(smooth.u).friction_loss, 0);
}

} // namespace impact::contact_test
