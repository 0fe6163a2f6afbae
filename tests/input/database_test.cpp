#include "options_scope.hpp"
#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <impact/input/database.hpp>
#include <impact/input/known_options.hpp>
#include <impact/input/option_text.hpp>
#include <impact/input/spelling.hpp>
#include <impact/petsc/error.hpp>

namespace {

using impact::GivenOption;
using impact::option_text;
using impact::UnitSystem;

TEST(OptionDatabase, ValuesAreReadAsTextWithoutBlanksAround) {
  OptionsScope options(
      {{"-title", "  a wedge -fast and slow "}, {"-dry_run", ""}, {"-bc_push_uy", " -t*0.1"}});
  EXPECT_EQ(option_text("title"), "a wedge -fast and slow");
  EXPECT_EQ(option_text("dry_run"), "");
  EXPECT_EQ(option_text("bc_push_uy"), "-t*0.1");
  EXPECT_EQ(option_text("fast"), std::nullopt);
  EXPECT_EQ(option_text("TITLE"), option_text("title"));
}

TEST(OptionDatabase, OptionsThatNobodyReadAreListed) {
  OptionsScope options({{"-title", "x"}, {"-motion_ksp_type", "cg"}, {"-log_view", ""}});
  option_text("title");
  const auto left = impact::unread_options();
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].key + " " + left[0].text, "-motion_ksp_type cg");
}

TEST(OptionDatabase, PetscIsNotSaidToRefuseWhatIsOurs) {
  OptionsScope options({{"-bc_slide_ux", "0"}, {"-motion_ksp_max_it", "-7"}});
  EXPECT_EQ(impact::refused_option("Point 0 is not a quadrilateral [2, 1912)"), "");
  EXPECT_NE(impact::refused_option("Maximum number of iterations -7 must be non-negative")
                .find("-motion_ksp_max_it \"-7\": PETSc refuses it"),
            std::string::npos);
  OptionsScope steps({std::pair<std::string, std::string>{"-ts_max_steps", "3"}});
  EXPECT_EQ(impact::refused_option("Error reported by MUMPS in solve phase: INFOG(1)=-3"), "");
}

TEST(OptionDatabase, ALineOfAnOptionsFileReadsBackTheSame) {
  for (const std::string value :
       {"a b", "-t*0.1", "(-t)", "72 GPa", "x > 1 ? 2 : 3", "1e-3*t", "\ttab", "[1]", "{a}", "100%"}) {
    const auto file = OptionsScope::file("# comment\n" + impact::option_line("bc_push_uy", value) +
                                         impact::option_line("title", "end"));
    OptionsScope options;
    options.insert_file(file);
    const std::string trimmed = value[0] == '\t' ? value.substr(1) : value;
    EXPECT_EQ(option_text("bc_push_uy"), trimmed);
    EXPECT_EQ(option_text("title"), "end") << value;
  }
}

TEST(Spelling, AMissingAWrongAndASwappedLetterAreOneEdit) {
  EXPECT_EQ(impact::edit_distance("gamma", "gama"), 1);
  EXPECT_EQ(impact::edit_distance("gamma", "gamna"), 1);
  EXPECT_EQ(impact::edit_distance("gamma", "gamam"), 1);
  EXPECT_EQ(impact::edit_distance("Gamma", "gamma"), 0);
  EXPECT_EQ(impact::edit_distance("abc", ""), 3);
  EXPECT_EQ(impact::nearest_name("gamam", {"Gc", "gamma", "game"}, 2), "gamma");
  EXPECT_EQ(impact::nearest_name("zzz", {"Gc", "gamma"}, 2), "");
}

TEST(Spelling, ListsAreSplitAtCommas) {
  EXPECT_EQ(impact::split_list(" a, b c ,d"), (std::vector<std::string>{"a", "b c", "d"}));
  EXPECT_EQ(impact::split_list("a,,b"), (std::vector<std::string>{"a", "", "b"}));
  EXPECT_TRUE(impact::split_list("  ").empty());
}

TEST(OptionText, RangesAreShownInTheUnitsOfTheRun) {
  const impact::Interval stress{0, 1e15, true, false};
  EXPECT_EQ(impact::interval_text(stress, "Pa", {}), "0 < value <= 1e+15 Pa");
  EXPECT_EQ(impact::interval_text(stress, "Pa", *impact::unit_system("mm_t_s_MPa")),
            "0 < value <= 1e+09 MPa");
  EXPECT_EQ(impact::interval_text(impact::positive, "1", {}), "> 0");
  EXPECT_EQ(impact::interval_text(impact::any_number, "m", {}), "");
}

TEST(OptionText, RangesAreCheckedAfterConversion) {
  const impact::Interval stress{0, 1e15, true, false};
  const UnitSystem mm = *impact::unit_system("mm_t_s_MPa");
  const auto read = [&](const char* text) { return impact::read_number({"-k", text}, "Pa", stress, {}, mm); };
  EXPECT_EQ(read("1e6 GPa"), 1e9);
  EXPECT_EQ(read("1e9"), 1e9);
  EXPECT_THROW(read("1.1e6 GPa"), impact::UserError);
  EXPECT_THROW(read("72e9"), impact::UserError); // pascals typed where MPa are meant
  EXPECT_THROW(read("0"), impact::UserError);
}

TEST(OptionText, WordsStandForNumbers) {
  const impact::NumberWords words = {{"inf", impact::unbounded}};
  EXPECT_EQ(impact::read_number({"-k", "inf"}, "1", impact::positive, words, {}), impact::unbounded);
  EXPECT_EQ(impact::number_or_word(impact::unbounded, words), "inf");
  EXPECT_THROW(impact::read_number({"-k", "auto"}, "1", impact::positive, words, {}), impact::UserError);
}

TEST(OptionText, OneNumberWithAUnitIsAnExpressionToo) {
  impact::OptionContext context;
  context.units = *impact::unit_system("mm_t_s_MPa");
  const double x[2] = {0, 0};
  EXPECT_EQ(impact::read_expression({"-k", "2 m"}, "m", context)(x, 2, 0), 2000);
  EXPECT_EQ(impact::read_expression({"-k", "-2 m"}, "m", context)(x, 2, 0), -2000);
  EXPECT_EQ(impact::read_expression({"-k", "2"}, "m", context)(x, 2, 0), 2);
  EXPECT_EQ(impact::read_expression({"-k", "2*t"}, "m", context)(x, 2, 3), 6);
  EXPECT_THROW(impact::read_expression({"-k", "2 s"}, "m", context), impact::UserError);
  EXPECT_THROW(impact::read_expression({"-k", "2 mm*t"}, "m", context), impact::UserError);
}

} // namespace
