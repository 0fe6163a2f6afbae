#include <cmath>
#include <gtest/gtest.h>
#include <impact/input/expression.hpp>
#include <impact/petsc/error.hpp>
#include <stdexcept>

namespace {

using impact::Expression;
using impact::ExpressionContext;

const double origin[3] = {0, 0, 0};

ExpressionContext context() {
  return {{{"v0", 33.}}, {{"load", impact::parse_table("t,p\n0,0\n1,2\n3,-2\n")}}};
}

double value(const std::string& text, double t = 0, double x = 0, double y = 0) {
  const ExpressionContext names = context();
  const double point[2] = {x, y};
  return Expression("-key", text, &names)(point, 2, t);
}

std::string refusal(const std::string& text) {
  try {
    value(text);
  } catch (const impact::UserError& error) {
    EXPECT_EQ(error.code(), impact::ExitCode::usage);
    return error.what();
  }
  return "accepted";
}

TEST(Expressions, UseCoordinatesTimeParametersAndTables) {
  EXPECT_DOUBLE_EQ(value("x + 10*y + 100*t + v0", 2, 3, 4), 3 + 40 + 200 + 33);
  EXPECT_DOUBLE_EQ(value("0.1*sin(2*pi*t)", 0.25), 0.1);
  EXPECT_DOUBLE_EQ(value("ln(e)"), 1);
  EXPECT_DOUBLE_EQ(value("min(3,max(1,2)) + abs(-4) + sqrt(9)"), 9);
  EXPECT_DOUBLE_EQ(value("t > 1 ? 5 : 7", 2), 5);
  EXPECT_DOUBLE_EQ(value("2^3 - (-t)", 1), 9);
}

TEST(Expressions, TheThirdCoordinateOfAPlanePointIsZero) {
  const double far[3] = {1, 2, 3};
  const Expression z("-key", "z");
  EXPECT_EQ(z(far, 2, 0), 0);
  EXPECT_EQ(z(far, 3, 0), 3);
}

TEST(Expressions, RampStepAndPulseSwitchAtTheirTimes) {
  EXPECT_EQ(value("ramp(t,1,3)", 0.5), 0);
  EXPECT_EQ(value("ramp(t,1,3)", 2), 0.5);
  EXPECT_EQ(value("ramp(t,1,3)", 4), 1);
  EXPECT_EQ(value("step(t,1)", 0.999), 0);
  EXPECT_EQ(value("step(t,1)", 1), 1);
  EXPECT_EQ(value("pulse(t,1,2)", 1), 1);
  EXPECT_EQ(value("pulse(t,1,2)", 2), 0);
  EXPECT_EQ(value("pulse(t,1,2)", 0.5), 0);
}

TEST(Expressions, TablesAreLinearBetweenRowsAndConstantBeyond) {
  EXPECT_EQ(value("load(t)", -1), 0);
  EXPECT_EQ(value("load(t)", 0.25), 0.5);
  EXPECT_EQ(value("load(t)", 1), 2);
  EXPECT_EQ(value("load(t)", 2), 0);
  EXPECT_EQ(value("load(2*t)", 5), -2);
}

TEST(Expressions, ACopyIsIndependentOfTheOriginal) {
  const ExpressionContext names = context();
  auto original = std::make_unique<Expression>("-key", "load(t) + v0", &names);
  Expression copy = *original;
  Expression assigned("-other", "0");
  assigned = *original;
  original.reset();
  EXPECT_EQ(copy(origin, 2, 1), 35);
  EXPECT_EQ(assigned(origin, 2, 1), 35);
  EXPECT_EQ(assigned.key(), "-key");
}

TEST(Expressions, AnUnknownNameIsShownWithItsPlaceAndTheKnownOnes) {
  const ExpressionContext names = context();
  try {
    Expression("-bc_push_uy", "0.1*sin(2*p*t)", &names);
    FAIL();
  } catch (const impact::UserError& error) {
    EXPECT_STREQ(error.what(), "-bc_push_uy \"0.1*sin(2*p*t)\": unknown name 'p' at character 10; "
                               "known: x y z t pi e v0 load(); functions: abs acos acosh asin asinh atan "
                               "atan2 atanh avg cos cosh cycle exp ln log log10 log2 max min pulse ramp rint "
                               "sign sin sinh sqrt step sum tan tanh");
  }
}

TEST(Expressions, WhatIsNoExpressionIsRefused) {
  EXPECT_EQ(refusal("x=2"),
            "-key \"x=2\": '=' at character 1 assigns; allowed: an expression, compare with ==");
  for (const char* text : {"", "1+", "sin(", "2x", "foo(3)", "1,2", "1 mm", "\"a\"", "load()", "load(1,2)",
                           "t = 1", "x+=1", "()"})
    EXPECT_NE(refusal(text), "accepted") << text;
  for (const char* text : {"x==2", "x<=2", "x>=2", "x!=2"}) EXPECT_EQ(refusal(text), "accepted") << text;
}

TEST(Expressions, AResultThatIsNotFiniteNamesPointAndTime) {
  const Expression wild("-bc_push_uy", "1/(t-2)");
  const double x[2] = {0.5, -1};
  EXPECT_EQ(wild(x, 2, 3), 1);
  for (const auto& [text, shown] : {std::pair{"1/(t-2)", "inf"}, std::pair{"sqrt(1-t)", "nan"}}) {
    try {
      Expression("-bc_push_uy", text)(x, 2, 2);
      FAIL() << text;
    } catch (const impact::UserError& error) {
      EXPECT_EQ(error.code(), impact::ExitCode::data);
      const std::string message = error.what();
      const std::string place = " at x=(0.5,-1), t=2; allowed: finite values everywhere and always";
      EXPECT_TRUE(message.ends_with(std::string(shown) + place)) << message;
    }
  }
}

TEST(Expressions, NamesWithAMeaningAreReserved) {
  for (const char* name :
       {"x", "y", "z", "t", "pi", "e", "sin", "ramp", "step", "pulse", "min", "max", "abs"})
    EXPECT_TRUE(impact::reserved_in_expressions(name)) << name;
  for (const char* name : {"v0", "load", "amp"}) EXPECT_FALSE(impact::reserved_in_expressions(name)) << name;
}

TEST(Tables, HeaderCommentsAndSeparatorsAreUnderstood) {
  const auto table = impact::parse_table("# measured\r\ntime;force\r\n0; 1\r\n\r\n2\t3 # end\n");
  ASSERT_EQ(table.t.size(), 2U);
  EXPECT_EQ(table(1), 2);
}

TEST(Tables, AFaultyLineIsNamed) {
  for (const auto& [csv, reason] :
       {std::pair{"0,0\n1,a\n", "line 2: two numbers expected"},
        std::pair{"0,0\n0,1\n", "line 2: the first column must increase"},
        std::pair{"0,0,0\n", "line 1: two numbers expected"},
        std::pair{"a,b\nc,d\n", "line 2: two numbers expected"}, std::pair{"# nothing\n", "no rows"}}) {
    try {
      impact::parse_table(csv);
      FAIL() << csv;
    } catch (const std::invalid_argument& error) {
      EXPECT_STREQ(error.what(), reason);
    }
  }
}

} // namespace
