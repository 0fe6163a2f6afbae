#include <cmath>
#include <gtest/gtest.h>
#include <impact/solve/newton_hooks.hpp>
#include <vector>

using impact::NewtonWatch;

namespace {

struct Seen {
  int at = 0, cycle = 0; // iterate at which the watch speaks, 0: never; what it says
  bool stalls = false;
};

Seen watch(const std::vector<double>& norms, bool full_steps = true) {
  NewtonWatch watch;
  watch.start(full_steps);
  for (std::size_t i = 0; i < norms.size(); ++i) {
    watch.note(norms[i]);
    if (watch.cycle() > 0 || watch.stalls()) return {static_cast<int>(i), watch.cycle(), watch.stalls()};
  }
  return {};
}

// A start that converges, and then rounds of `period` norms, the same but for two per cent.
std::vector<double> circles(int period, int rounds) {
  std::vector<double> norms = {1e5, 3e3, 70};
  for (int i = 0; i < period * rounds; ++i) {
    const int place = i % period;
    norms.push_back((1 + 0.7 * place * (period + 1 - place)) * (1 + 0.02 * (i / period % 2)));
  }
  return norms;
}

// Once is no matter: the answer of the first linear solve is often too long.
TEST(NewtonWatch, CountsStepsInARowThatSearchesCutFarFromBalance) {
  NewtonWatch watch;
  watch.start(false);
  watch.note(1);
  watch.note_step(0.1);
  EXPECT_EQ(watch.cut_steps(), 1);
  watch.note_step(1);
  EXPECT_EQ(watch.cut_steps(), 0);
  watch.note_step(0.4);
  watch.note_step(0.3);
  EXPECT_EQ(watch.cut_steps(), 2);
  watch.note(1e-4);
  EXPECT_EQ(watch.cut_steps(), 0);
  watch.start(false);
  watch.note(1);
  EXPECT_EQ(watch.cut_steps(), 0);
}

} // namespace

TEST(NewtonWatch, SeesCyclesBeforeTheirFourthRound) {
  for (int period = 2; period <= 6; ++period) {
    const Seen seen = watch(circles(period, 3));
    EXPECT_EQ(seen.cycle, period);
    EXPECT_FALSE(seen.stalls);
    EXPECT_GT(seen.at, 2 + period);
    EXPECT_LT(seen.at, 3 + 3 * period);
  }
  EXPECT_EQ(watch(circles(7, 3)).at, 0); // longer ones are left to the limit of the iterations
}

TEST(NewtonWatch, SaysNothingOfWhatConverges) {
  // Norms of runs: a friction that settles, a far start, oscillations that fade by a tenth per round.
  EXPECT_EQ(watch({2e6, 2.5e5, 2.9e3, 1.5e3, 9.9e2, 7e2, 5.1e2, 3.8e2, 24, 4e-6}).at, 0);
  EXPECT_EQ(watch({52, 29, 24, 28, 24, 18, 9, 15, 0.05, 1e-4, 1e-9}).at, 0);
  std::vector<double> fades;
  for (int i = 0; i < 20; ++i) fades.push_back((i % 2 == 0 ? 3 : 5) * std::pow(0.9, i / 2));
  EXPECT_EQ(watch(fades).at, 0);
}

TEST(NewtonWatch, WhatCreepsStalls) { // a ball on a plate that breaks, 0.01 after 25 iterations
  const Seen seen = watch({1.3e4,  2266,   226,    81,     76,     46.8,   20.3,   7.43,   3.00,   1.39,
                           0.7324, 0.4263, 0.2670, 0.1780, 0.1245, 0.0905, 0.0679, 0.0523, 0.0411, 0.0330});
  EXPECT_TRUE(seen.stalls);
  EXPECT_LE(seen.at, 18);
}

TEST(NewtonWatch, StallsOnlyWhereStepsAreTakenInFull) {
  const std::vector<double> norms = {3e5, 0.1, 2e-6, 1.9e-6, 1.85e-6, 1.8e-6, 1.7e-6, 1.65e-6, 1.6e-6};
  const Seen seen = watch(norms);
  EXPECT_TRUE(seen.stalls);
  EXPECT_EQ(seen.cycle, 0);
  EXPECT_EQ(seen.at, 7);
  EXPECT_EQ(watch(norms, false).at, 0);
  // Four small changes are no stall.
  EXPECT_EQ(watch({3e5, 0.1, 2e-6, 1.9e-6, 1.85e-6, 1.8e-6, 1.7e-6, 1e-9}).at, 0);
}

TEST(NewtonWatch, ASetThatShrinksDoesNotGoRound) { // leaves of a spring that part, 100 facets
  NewtonWatch watch;
  watch.start(true);
  int active = 60;
  for (double norm : circles(2, 9)) {
    watch.note_set(active--);
    watch.note(norm);
    EXPECT_EQ(watch.cycle(), 0);
  }
  for (double norm : circles(2, 4)) watch.note(norm);
  EXPECT_EQ(watch.cycle(), 2);
}

TEST(NewtonWatch, ASetThatShrinksDoesNotStall) {
  NewtonWatch watch;
  watch.start(true);
  watch.note(5e4);
  double norm = 0.02;
  for (int active = 60; active > 40; --active, norm *= 0.95) {
    watch.note_set(active);
    watch.note(norm);
    EXPECT_FALSE(watch.stalls());
  }
  for (int i = 0; i < 5; ++i, norm *= 0.95) watch.note(norm);
  EXPECT_TRUE(watch.stalls());
}

TEST(NewtonWatch, SeesStepsInFullThatLeave) { // a ball pressed into steel that flows, with friction
  const auto leaves = [](const std::vector<double>& norms, bool full) {
    NewtonWatch watch;
    watch.start(full);
    for (double norm : norms) watch.note(norm);
    return watch.leaves();
  };
  EXPECT_TRUE(leaves({20, 37, 25, 86, 170, 907}, true));
  EXPECT_FALSE(leaves({20, 37, 25, 86, 170, 907}, false));
  EXPECT_FALSE(leaves({20, 37, 25, 86, 170, 200}, true));
  EXPECT_FALSE(leaves({1, 3, 9, 4, 10, 2e-3}, true));
}

TEST(NewtonWatch, ForgetsTheSolveBefore) {
  NewtonWatch watch;
  watch.start(true);
  for (double norm : circles(2, 3)) watch.note(norm);
  EXPECT_EQ(watch.cycle(), 2);
  watch.start(true);
  EXPECT_EQ(watch.cycle(), 0);
  for (double norm : {1.0, 2.0, 1.0, 2.0}) watch.note(norm);
  EXPECT_EQ(watch.cycle(), 0);
}
