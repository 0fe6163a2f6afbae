#include <cmath>
#include <gtest/gtest.h>
#include <impact/input/units.hpp>
#include <stdexcept>

namespace {

using impact::parse_number;
using impact::parse_quantity;
using impact::parse_unit;
using impact::UnitSystem;

std::string reason(const char* text, const char* unit, const UnitSystem& system) {
  try {
    parse_quantity(text, parse_unit(unit).dimension, system);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

// Table 1 of the paper, in SI and in the two other systems; the columns are written out by hand.
struct Conversion {
  const char *text, *unit;
  double si, mm_t_s, mm_kg_ms;
};
const Conversion table1[] = {
    {"72 GPa", "Pa", 72e9, 72000, 72},
    {"2810 kg/m^3", "kg/m^3", 2810, 2.81e-9, 2.81e-6},
    {"368 MPa", "Pa", 368e6, 368, 0.368},
    {"0.5 mm", "m", 5e-4, 0.5, 0.5},
    {"0.001 m^2/(N.s)", "m^2/(N.s)", 1e-3, 1000, 1000},
    {"3e6 N.s/m^2", "N.s/m^2", 3e6, 3, 3},
    {"4950.6 N/m", "N/m", 4950.6, 4.9506, 4.9506e-3},
    {"1e8 N/mm^3", "N/m^3", 1e17, 1e8, 1e5},
    {"33 m/s", "m/s", 33, 33000, 33},
    {"9.81 m/s^2", "m/s^2", 9.81, 9810, 9.81e-3},
    {"2.3e-5 1/K", "1/K", 2.3e-5, 2.3e-5, 2.3e-5},
    {"10 us", "s", 1e-5, 1e-5, 1e-2},
    {"2 min", "s", 120, 120, 120000},
    {"5 %", "1", 0.05, 0.05, 0.05},
};

TEST(Units, ATablesValuesAreConvertedExactly) {
  for (const Conversion& row : table1) {
    const auto dimension = parse_unit(row.unit).dimension;
    EXPECT_EQ(parse_quantity(row.text, dimension, *impact::unit_system("SI")), row.si) << row.text;
    EXPECT_EQ(parse_quantity(row.text, dimension, *impact::unit_system("mm_t_s_MPa")), row.mm_t_s)
        << row.text;
    EXPECT_EQ(parse_quantity(row.text, dimension, *impact::unit_system("mm_kg_ms_GPa")), row.mm_kg_ms)
        << row.text;
  }
}

TEST(Units, ABareNumberIsInTheUnitsOfTheRun) {
  for (const char* name : {"SI", "mm_t_s_MPa", "mm_kg_ms_GPa"})
    for (const char* unit : {"Pa", "kg/m^3", "N.s/m^2", "1"})
      EXPECT_EQ(parse_quantity("12.5", parse_unit(unit).dimension, *impact::unit_system(name)), 12.5);
}

TEST(Units, EachSystemIsConsistent) {
  // Force = mass * acceleration and stress = force / area must hold with factor one in the system's own
  // units.
  const auto factor = [](const char* unit, const char* system) {
    return parse_quantity("1 " + std::string(unit), parse_unit(unit).dimension, *impact::unit_system(system));
  };
  EXPECT_EQ(factor("t.mm/s^2", "mm_t_s_MPa"), 1);
  EXPECT_EQ(factor("N", "mm_t_s_MPa"), 1);
  EXPECT_EQ(factor("MPa", "mm_t_s_MPa"), 1);
  EXPECT_EQ(factor("mJ", "mm_t_s_MPa"), 1);
  EXPECT_EQ(factor("kg.mm/ms^2", "mm_kg_ms_GPa"), 1);
  EXPECT_EQ(factor("kN", "mm_kg_ms_GPa"), 1);
  EXPECT_EQ(factor("GPa", "mm_kg_ms_GPa"), 1);
  EXPECT_EQ(factor("J", "mm_kg_ms_GPa"), 1);
}

TEST(Units, DifferentSpellingsOfAUnitAgree) {
  for (const char* other : {"N s/m^2", "N*s/m^2", "Pa.s", "Pa s", "s.N/m/m", "kg/(m.s)", "J.s/m^3",
                            "(N/m)/(m/s)", "1/(m/(N.s/m))"})
    EXPECT_EQ(parse_unit(other).dimension, parse_unit("N.s/m^2").dimension) << other;
  EXPECT_EQ(parse_quantity("1 m^-1", parse_unit("1/m").dimension, {}), 1);
  EXPECT_EQ(parse_quantity("72GPa", parse_unit("Pa").dimension, {}), 72e9);
  EXPECT_EQ(parse_quantity("(-1)", parse_unit("1").dimension, {}), -1);
  EXPECT_EQ(parse_quantity(" (-2 mm) ", parse_unit("m").dimension, {}), -2e-3);
  EXPECT_THROW(parse_quantity("((1)", parse_unit("1").dimension, {}), std::invalid_argument);
  EXPECT_NEAR(parse_quantity("90 deg", {}, {}), std::acos(0.), 1e-15);
}

TEST(Units, AWrongDimensionNamesWhatIsAllowed) {
  EXPECT_EQ(reason("72 m", "Pa", {}),
            "'m' has the wrong dimension; allowed: a number in Pa, or one with a unit of that kind");
  EXPECT_EQ(reason("72 m", "Pa", *impact::unit_system("mm_t_s_MPa")),
            "'m' has the wrong dimension; allowed: a number in MPa, or one with a unit of that kind");
  EXPECT_EQ(reason("0.3 m", "1", {}), "'m' has the wrong dimension; allowed: a number without a unit");
}

TEST(Units, AnUnknownUnitAndJunkAreRefused) {
  EXPECT_EQ(reason("72 GPs", "Pa", {}),
            "unknown unit 'GPs'; allowed: a number in Pa, or one with a unit of that kind");
  for (const char* text : {"",
                           " ",
                           "GPa",
                           "abc",
                           "1,5",
                           "0x10",
                           "inf",
                           "nan",
                           "1e400",
                           "-1e400",
                           "1e-400 GPa",
                           "1 2",
                           "1 GPa GPa)",
                           "1 (GPa",
                           "1 GPa/",
                           "1 /m",
                           "1 m^",
                           "1 m^99",
                           "1 m^x",
                           "1 m^2/N.s",
                           "1..2",
                           "1e99999999999",
                           "1 ((((((((((((m"})
    EXPECT_NE(reason(text, "Pa", {}), "accepted") << text;
}

TEST(Units, NumbersAreReadToTheLastDigit) {
  EXPECT_EQ(parse_number("0.1"), 0.1);
  EXPECT_EQ(parse_number("+.5e+1"), 5.);
  EXPECT_EQ(parse_number("-2."), -2.);
  EXPECT_EQ(parse_number("2.5", -9), 2.5e-9);
  EXPECT_EQ(parse_number("1e300", -600), 1e-300);
  for (const char* junk : {"", "-", "+", ".", "e5", "1e", "1e+", "--1", "+-1", "1 1", " 1x"})
    EXPECT_FALSE(parse_number(junk).has_value()) << junk;
}

TEST(Units, PrintedNumbersReadBackTheSame) {
  for (const double value : {0.1, 1. / 3, 7.2e10, -2.81e-9, 5e-324, 1.7976931348623157e308, 0.})
    EXPECT_EQ(parse_number(impact::number_text(value)), value);
}

TEST(Units, SymbolsNameTheSystemsOwnUnits) {
  const auto symbol = [](const char* unit, const char* system) {
    return impact::unit_symbol(parse_unit(unit).dimension, *impact::unit_system(system));
  };
  EXPECT_EQ(symbol("Pa", "SI"), "Pa");
  EXPECT_EQ(symbol("Pa", "mm_t_s_MPa"), "MPa");
  EXPECT_EQ(symbol("Pa", "mm_kg_ms_GPa"), "GPa");
  EXPECT_EQ(symbol("kg/m^3", "mm_t_s_MPa"), "t/mm^3");
  EXPECT_EQ(symbol("N/m", "mm_t_s_MPa"), "N/mm");
  EXPECT_EQ(symbol("m^2/(N.s)", "mm_t_s_MPa"), "1/(MPa.s)");
  EXPECT_EQ(symbol("%", "SI"), "1");
  // A symbol is itself a unit with the value one in its system.
  for (const char* name : {"SI", "mm_t_s_MPa", "mm_kg_ms_GPa"})
    for (const Conversion& row : table1) {
      const auto dimension = parse_unit(row.unit).dimension;
      const std::string own = impact::unit_symbol(dimension, *impact::unit_system(name));
      EXPECT_EQ(parse_quantity("1 " + own, dimension, *impact::unit_system(name)), 1) << own;
    }
}

} // namespace
