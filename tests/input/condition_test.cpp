#include <cmath>
#include <gtest/gtest.h>
#include <impact/input/condition.hpp>
#include <impact/petsc/error.hpp>
#include <map>

namespace impact {
namespace {

using Numbers = std::map<std::string, double>;

Condition::Value in(const Numbers& numbers) {
  return [&numbers](const std::string& name) { return numbers.at(name); };
}

std::vector<double> peaks_of(Condition& c) {
  std::vector<double> values;
  for (const Condition::Peak& peak : c.peaks()) values.push_back(peak.value);
  return values;
}

TEST(Condition, ComparesNamedNumbersWithTheirPeaks) {
  Condition broken("-stop_broken_when", "force < 0.1*peak(force) && t > t0", {{"t0", 2}});
  EXPECT_EQ(broken.names(), (std::vector<std::string>{"force", "t"}));
  EXPECT_EQ(broken.peaks().at(0).text, "force");
  const double force[] = {0, 10, 0.9, 0.9, 1.1, 0.5};
  const bool expected[] = {false, false, false, true, false, true};
  for (int t = 0; t < 6; ++t) {
    const Numbers numbers = {{"force", force[t]}, {"t", t}};
    broken.note(in(numbers));
    EXPECT_EQ(broken.holds(in(numbers)), expected[t]) << t;
  }
  EXPECT_EQ(peaks_of(broken), std::vector<double>{10});
}

TEST(Condition, PeaksAreOfAnyExpressionAndCanBeSet) {
  Condition c("-stop_c_when", "abs(x) < 0.5*peak( max(abs(x), y*(1+1)) ) || peak(y)>speak");
  EXPECT_EQ(c.peaks().at(0).text, " max(abs(x), y*(1+1)) ");
  EXPECT_EQ(c.peaks().at(1).text, "y");
  EXPECT_EQ(c.names().size(), 3u);
  c.peaks().at(0).value = 8;
  c.peaks().at(1).value = 1;
  const Numbers numbers = {{"x", -3}, {"y", 0}, {"speak", 5}};
  c.note(in(numbers));
  EXPECT_EQ(peaks_of(c), (std::vector<double>{8, 1}));
  EXPECT_TRUE(c.holds(in(numbers)));
  EXPECT_FALSE(c.holds(in({{"x", -5}, {"y", 0}, {"speak", 5}})));
}

TEST(Condition, WhatIsNoNumberNeitherHoldsNorCounts) {
  Condition c("-stop_c_when", "tip > 3 || peak(tip) > 3");
  Numbers numbers = {{"tip", std::nan("")}};
  c.note(in(numbers));
  EXPECT_FALSE(c.holds(in(numbers)));
  numbers["tip"] = 2;
  c.note(in(numbers));
  numbers["tip"] = std::nan("");
  c.note(in(numbers));
  EXPECT_EQ(peaks_of(c), std::vector<double>{2});
}

TEST(Condition, SaysWhatIsWrong) {
  const std::pair<const char*, const char*> rows[] = {
      {"a = 1", "'=' at character 2 assigns; allowed: an expression, compare with =="},
      {"peak(peak(a)) > 1", "a peak in a peak; allowed: peak(name)"},
      {"peak > 1", "peak takes an argument in brackets; allowed: peak(name)"},
      {"peak(a > 1", "peak takes an argument in brackets; allowed: peak(name)"},
      {"a >",
       "allowed: an expression of columns of the history, t, peak() and numbers in the units of the run"},
      {"a, 2", "one value expected, not a list"}};
  for (const auto& [text, message] : rows) {
    try {
      Condition("-stop_x_when", text);
      ADD_FAILURE() << text;
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find("-stop_x_when \"" + std::string(text) + "\": "), 0u)
          << error.what();
    }
  }
}

} // namespace
} // namespace impact
