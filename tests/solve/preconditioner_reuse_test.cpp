#include <gtest/gtest.h>
#include <impact/petsc/preconditioner_reuse.hpp>
#include <random>

using impact::PreconditionerReuse;

TEST(PreconditionerReuse, ServesUntilItsExtraIterationsCostAsMuchAsANewOne) {
  PreconditionerReuse reuse(15);
  EXPECT_FALSE(reuse.serves());
  reuse.note(5, 2); // new: 2.5 iterations for a decade
  EXPECT_TRUE(reuse.serves());
  EXPECT_EQ(reuse.most(2), 5 + 15 + 1);
  reuse.note(10, 4); // as fast as when it was new
  for (int i = 0; i < 3; ++i) reuse.note(9, 2);
  EXPECT_TRUE(reuse.serves()); // 12 more
  EXPECT_EQ(reuse.most(2), 5 + 3 + 1);
  reuse.note(9, 2);
  EXPECT_FALSE(reuse.serves());
  reuse.note(5, 2);
  reuse.forget();
  EXPECT_FALSE(reuse.serves());
}

TEST(PreconditionerReuse, WithoutCostEachSolveHasANewOne) {
  PreconditionerReuse reuse(0);
  reuse.note(5, 8);
  EXPECT_FALSE(reuse.serves());
}

// One that ages by any amounts from solve to solve, the same whenever it was made: no fixed number of solves
// between two of them, chosen in hindsight, costs half as much.
TEST(PreconditionerReuse, CostsAtMostTwiceTheBestPeriodInHindsight) {
  constexpr double cost = 15;
  constexpr int solves = 200, fresh = 4;
  std::mt19937 random(1);
  for (int sample = 0; sample < 50; ++sample) {
    const double pace = std::uniform_real_distribution<>(0, 3)(random);
    const auto extra = [pace](int age) { return static_cast<PetscInt>(pace * age); };
    PreconditionerReuse reuse(cost);
    double total = 0;
    for (int i = 0, age = 0; i < solves; ++i, ++age) {
      if (!reuse.serves()) total += cost, age = 0;
      total += fresh + static_cast<double>(extra(age));
      reuse.note(fresh + extra(age), 2);
    }
    double best = HUGE_VAL;
    for (int period = 1; period <= solves; ++period) {
      double sum = 0;
      for (int i = 0; i < solves; ++i)
        sum += fresh + static_cast<double>(extra(i % period)) + (i % period == 0 ? cost : 0);
      best = std::min(best, sum);
    }
    EXPECT_LE(total, 2 * best) << "pace " << pace;
  }
}
