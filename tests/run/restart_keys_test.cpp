#include "scenario_options.hpp"
#include <gtest/gtest.h>
#include <impact/scenario/scenario.hpp>
#include <sstream>

namespace {

using namespace scenario_options;
using impact::ExitCode;
using impact::RestartKey;

const std::string stored =
    "-units SI\n-mesh /old/place/beam.msh\n-mesh_set_n 5\n-materials beam\n"
    "-material_beam_E 7e10\n-bcs clamp,push\n-bc_push_uy \"0.1*sin(2*pi*t) + 1\"\n"
    "-function_load_table /old/place/load.csv\n-material_beam_hardening_table /old/k.csv\n"
    "-ts_dt 0.1\n-checkpoint_every 3\n-motion_tangent auto\n-outputs vis\n";

std::string with_change(const std::string& key, const std::string& value) {
  std::istringstream in(stored);
  std::string out;
  for (std::string line; std::getline(in, line);)
    if (!line.starts_with("-" + key + " ")) out += line + "\n";
  return value.empty() ? out : out + "-" + key + " " + value + "\n";
}

struct Answer {
  std::vector<std::string> notes;
  std::string error;
};

Answer compare(const std::string& now, const std::vector<std::string>& allow = {}) {
  try {
    return {impact::check_restart_options(stored, now, allow, "checkpoint_000007.h5"), ""};
  } catch (const impact::UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return {{}, error.what()};
  }
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(RestartKeys, TheSameOptionsPass) {
  EXPECT_EQ(compare(stored).error, "");
  EXPECT_TRUE(compare(stored).notes.empty());
  for (const auto& [key, value] : {std::pair("mesh", "/new/place/beam.msh"),
                                   {"function_load_table", "/new/place/load.csv"},
                                   {"material_beam_hardening_table", "/new/k.csv"}})
    EXPECT_EQ(compare(with_change(key, value)).error, "") << key;
}

TEST(RestartKeys, AnotherSchemeBringsItsOptions) {
  const std::string now = with_change("ts_newmark_rho", "0.8") + "-ts_type newmark\n";
  EXPECT_TRUE(holds(compare(now).error, "ts_newmark_rho"));
  EXPECT_EQ(compare(now, {"ts_type"}).error, "");
  const std::string stiffer = with_change("material_beam_E", "8e10") + "-ts_type newmark\n";
  EXPECT_TRUE(holds(compare(stiffer, {"ts_type"}).error, "material_beam_E"));
}

TEST(RestartKeys, FreeOptionsPassChangedAddedAndRemoved) {
  for (const auto& [key, value] : {std::pair("ts_dt", "0.2"),
                                   {"checkpoint_every", ""},
                                   {"motion_tangent", "symmetric"},
                                   {"outputs", "vis,more"},
                                   {"output_more_dt", "1"},
                                   {"walltime", "3600"},
                                   {"title", "again"}})
    EXPECT_EQ(compare(with_change(key, value)).error, "") << key;
}

TEST(RestartKeys, FrozenOptionsAreRefusedWithBothValuesWhateverIsAllowed) {
  for (const auto& [key, value] : {std::pair("units", "mm_t_s_MPa"),
                                   {"mesh", "/old/place/other.msh"},
                                   {"mesh_set_n", "6"},
                                   {"order", "2"},
                                   {"mesh_scale", "2"},
                                   {"dm_refine", "1"}}) {
    const std::string error = compare(with_change(key, value), {"units", "mesh", "bcs"}).error;
    EXPECT_TRUE(error.starts_with("-" + std::string(key) + ": \"" + value + "\" instead of ")) << error;
    EXPECT_TRUE(holds(error, "checkpoint_000007.h5")) << error;
  }
  EXPECT_TRUE(holds(compare(with_change("mesh_set_n", "6")).error, "\"6\" instead of \"5\""));
}

TEST(RestartKeys, GuardedOptionsAreRefusedUntilTheyAreAllowed) {
  const std::string change = with_change("bc_push_uy", "\"2*t\"");
  EXPECT_TRUE(
      holds(compare(change).error, "-bc_push_uy: \"2*t\" instead of \"0.1*sin(2*pi*t) + 1\" in checkpoint "))
      << compare(change).error;
  EXPECT_TRUE(holds(compare(change).error, "-restart_allow bc_push_uy"));
  for (const char* entry : {"bc_push_uy", "-bc_push_uy", "bc_push", "BC_push_uy"}) {
    const Answer answer = compare(change, {entry});
    EXPECT_EQ(answer.error, "") << entry;
    ASSERT_EQ(answer.notes.size(), 1U);
    EXPECT_TRUE(holds(answer.notes[0], "-bc_push_uy")) << answer.notes[0];
  }
  // The beginning of a name is one up to an underscore.
  EXPECT_NE(compare(change, {"bcs"}).error, "");
  // Also one that was added, and one that is gone.
  EXPECT_TRUE(
      holds(compare(with_change("bc_push_ux", "1")).error, "-bc_push_ux: \"1\" instead of (not given)"));
  EXPECT_TRUE(holds(compare(with_change("material_beam_E", "")).error,
                    "-material_beam_E: (not given) instead of \"7e10\""));
}

TEST(RestartKeys, AnEntryThatFitsNothingIsRefused) {
  const std::string error = compare(stored, {"bc_puhs"}).error;
  EXPECT_TRUE(holds(error, "-restart_allow \"bc_puhs\"")) << error;
  EXPECT_TRUE(holds(error, "allowed: ") && holds(error, "bc_push") && holds(error, "material_beam")) << error;
  EXPECT_FALSE(holds(error, "mesh_set_n") || holds(error, "output_")) << error; // frozen, free
}

// A new option is guarded until somebody has thought about it, and none of ours escapes the three lists.
TEST(RestartKeys, EveryOptionOfTheReferenceHasItsKind) {
  int free = 0, guarded = 0, frozen = 0;
  std::istringstream lines(impact::option_reference());
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `-")) continue;
    const std::string cell = table_cells(line)[0], key = cell.substr(2, cell.size() - 3);
    const RestartKey kind = impact::restart_key(key);
    (kind == RestartKey::free ? free : kind == RestartKey::frozen ? frozen : guarded) += 1;
    for (const char* word : {"material", "bc", "ic", "contact", "param", "function"})
      if (key.starts_with(std::string(word) + "_<id>") || key == std::string(word) + "s") {
        EXPECT_EQ(kind, RestartKey::guarded) << key;
      }
    for (const char* word : {"output", "probe", "measure", "release"})
      if (key.starts_with(std::string(word) + "_<id>") || key == std::string(word) + "s") {
        EXPECT_EQ(kind, RestartKey::free) << key;
      }
    for (const char* word : {"checkpoint", "walltime", "restart", "energy"})
      if (key.starts_with(word)) {
        EXPECT_EQ(kind, RestartKey::free) << key;
      }
  }
  EXPECT_EQ(frozen, 8); // units, dim, plane, mesh, order, mesh_serendipity, mesh_scale, dm_refine
  EXPECT_GT(free, 30);
  EXPECT_GT(guarded, 60);
}

} // namespace
