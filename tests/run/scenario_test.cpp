#include "scenario_options.hpp"
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <impact/input/database.hpp>
#include <impact/input/spelling.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/scenario/scenario.hpp>
#include <set>
#include <sstream>

namespace {

using namespace scenario_options;
using impact::ExitCode;
using impact::read_scenario;
using impact::Scenario;

TEST(Scenario, TheBaseOfTheseTestsIsAccepted) { EXPECT_EQ(outcome(base()).message, ""); }

TEST(Scenario, PetscsOwnOptionsAreLeftToPetsc) {
  const Options options = with({{"-motion_ksp_type", "cg"},
                                {"-motion_pc_hypre_type", "boomeramg"},
                                {"-damage_snes_monitor", ""},
                                {"-coupling_snes_monitor", ""},
                                {"-uzawa_snes_max_it", "5"},
                                {"-ts_adapt_monitor", ""},
                                {"-mat_no_inode", ""},
                                {"-petscpartitioner_type", "simple"}});
  OptionsScope scope(OptionsScope::Options(options.begin(), options.end()));
  read_scenario(PETSC_COMM_SELF);
  std::set<std::string> left;
  for (const auto& option : impact::unread_options()) left.insert(option.key + " " + option.text);
  EXPECT_EQ(left, (std::set<std::string>{"-coupling_snes_monitor ", "-damage_snes_monitor ", "-mat_no_inode ",
                                         "-motion_ksp_type cg", "-motion_pc_hypre_type boomeramg",
                                         "-petscpartitioner_type simple", "-ts_adapt_monitor ",
                                         "-uzawa_snes_max_it 5"}));
}

TEST(Scenario, PetscSeesPlainNumbersWhereTheUserGaveUnits) {
  const Options options = with({{"-ts_dt", "1 ms"}, {"-ts_max_time", "0.3 s"}});
  OptionsScope scope(OptionsScope::Options(options.begin(), options.end()));
  const Scenario scenario = read_scenario(PETSC_COMM_SELF);
  EXPECT_EQ(scenario.time.dt, 1e-3);
  PetscReal dt = 0, end = 0;
  impact::check(PetscOptionsGetReal(nullptr, nullptr, "-ts_dt", &dt, nullptr));
  impact::check(PetscOptionsGetReal(nullptr, nullptr, "-ts_max_time", &end, nullptr));
  EXPECT_EQ(dt, 1e-3);
  EXPECT_EQ(end, 0.3);
}

TEST(Scenario, ModuliFollowFromYoungsModulusAndPoissonsRatio) {
  const Scenario scenario = read(base());
  // E = 9 K G / (3 K + G) and nu = (3 K - 2 G) / (6 K + 2 G).
  const double K = scenario.materials[0].law.K, G = scenario.materials[0].law.G;
  EXPECT_NEAR(9 * K * G / (3 * K + G), 72e9, 1e-3);
  EXPECT_NEAR((3 * K - 2 * G) / (6 * K + 2 * G), 0.33, 1e-14);
}

TEST(Scenario, HeatCapacityIsPerVolumeOrPerMass) {
  for (const char* text : {"2472800", "2472.8 kJ/(m^3.K)", "880 J/(kg.K)"}) {
    const Scenario scenario = read(with({{"-material_beam_c_v", text}}));
    for (const auto& material : scenario.materials) EXPECT_NEAR(material.law.c_v, 2472800, 1e-9) << text;
    EXPECT_TRUE(scenario.has_heat());
  }
  EXPECT_FALSE(read(base()).has_heat());
}

// What physics that is left out would need is not asked for, and motion without inertia needs no density.
TEST(Scenario, HeatAloneNeedsNoModuli) {
  const Scenario scenario = read(with({{"-physics", "heat"},
                                       {"-releases", "-"},
                                       {"-release_ring_inner", "-"},
                                       {"-release_ring_outer", "-"},
                                       {"-material_beam_E", "-"},
                                       {"-material_beam_nu", "-"},
                                       {"-material_beam_rho", "-"},
                                       {"-material_beam_c_v", "1e6"}}));
  EXPECT_TRUE(scenario.has_heat());
  EXPECT_FALSE(scenario.has_motion());
  EXPECT_FALSE(scenario.has_inertia());
  EXPECT_EQ(scenario.outputs[0].fields, std::vector<std::string>{"theta"});
  EXPECT_FALSE(read(with({{"-physics", "motion"}, {"-material_beam_c_v", "1e6"}})).has_heat());
}

TEST(Scenario, OwnModuliWinOverAnEquationOfStateTakenOverAndTheOtherWayRound) {
  const Options copper = {{"-material_wedge_eos", "mie_grueneisen"},
                          {"-material_wedge_eos_c0", "4 km/s"},
                          {"-material_wedge_G", "47 GPa"}};
  Options beam_like_wedge = copper;
  beam_like_wedge.insert(
      {{"-material_beam_like", "wedge"}, {"-material_wedge_like", "-"}, {"-material_wedge_rho", "8930"}});
  for (const Options& changes : {copper, beam_like_wedge}) {
    const Scenario scenario = read(with(changes));
    const impact::MaterialParameters &beam = scenario.materials[0].law, &wedge = scenario.materials[1].law;
    EXPECT_EQ(beam.equation_of_state, impact::EquationOfState::none);
    EXPECT_NEAR(beam.K, 72e9 / (3 * (1 - 2 * 0.33)), 1e-3);
    EXPECT_EQ(wedge.equation_of_state, impact::EquationOfState::mie_grueneisen);
    EXPECT_EQ(wedge.K, wedge.rho * 16e6);
    EXPECT_EQ(wedge.G, 47e9);
  }
}

TEST(Scenario, AMaterialTakesOverWhatItDoesNotOverride) {
  const Scenario scenario = read(with({{"-material_beam_like", "wedge"},
                                       {"-material_wedge_like", "-"},
                                       {"-material_wedge_K", "50 GPa"},
                                       {"-material_wedge_G", "20 GPa"},
                                       {"-material_wedge_region", "left part, right part"},
                                       {"-material_wedge_b_d", "10 Pa.s"},
                                       {"-material_beam_rho", "-"},
                                       {"-material_wedge_rho", "7800"}}));
  const auto &beam = scenario.materials[0], &wedge = scenario.materials[1];
  EXPECT_EQ(wedge.law.K, 50e9);
  EXPECT_NE(beam.law.K, 50e9); // its own E and nu win over K and G
  EXPECT_EQ(beam.law.rho, 7800);
  EXPECT_EQ(beam.law.b_d, 10);
  EXPECT_EQ(beam.regions, std::vector<std::string>{"beam"});
  EXPECT_EQ(wedge.regions, (std::vector<std::string>{"left part", "right part"}));
}

TEST(Scenario, DefaultsThatDependOnOthersAreFilledIn) {
  const Options cracked = {
      {"-material_beam_damage", "at2"}, {"-material_beam_Gc", "5 kN/m"}, {"-material_beam_gamma", "1 mm"}};
  EXPECT_EQ(read(with(cracked)).coupling.max_it, 1);
  Options still = cracked;
  still["-ts_type"] = "static";
  still["-material_beam_rho"] = "-";
  EXPECT_EQ(read(with(still)).coupling.max_it, 200);
  EXPECT_TRUE(read(with(still)).coupling.follow_cracks); // passes in which phi grows do not count
  still["-coupling_snes_max_it"] = "7";
  EXPECT_EQ(read(with(still)).coupling.max_it, 7);
  EXPECT_FALSE(read(with(still)).coupling.follow_cracks);
  const Scenario table =
      read(with({{"-ts_dt", "-"}, {"-ts_max_time", "-"}, {"-ts_times", "0,10,50"}, {"-ts_dts", "1,0.1"}}));
  EXPECT_EQ(table.time.dt, 1);
  EXPECT_EQ(table.time.max_time, 50);
  const Scenario j2 = read(with({{"-material_beam_model", "j2"}, {"-material_beam_sigma_y", "3e8"}}));
  EXPECT_FALSE(j2.materials[0].locking); // automatic
  EXPECT_EQ(j2.materials[0].law.locking, impact::Locking::mean);
  EXPECT_EQ(j2.outputs[0].every, 1);
  EXPECT_EQ(j2.outputs[0].file, "vis.xdmf");
}

TEST(Scenario, UnitsOfAConditionFollowItsType) {
  const double x[2] = {0, 0};
  const auto component = [&](const char* type, const char* value) {
    const Scenario scenario =
        read(with({{"-units", "mm_t_s_MPa"}, {"-bc_push_type", type}, {"-bc_push_uy", value}}));
    return (*scenario.bcs[0].component[1])(x, 2, 0);
  };
  EXPECT_EQ(component("displacement", "2 m"), 2000);
  EXPECT_EQ(component("velocity", "33 m/s"), 33000);
  EXPECT_EQ(component("body_force", "9.81 m/s^2"), 9810);
  EXPECT_EQ(component("traction", "3 GPa"), 3000);
  EXPECT_EQ(component("force", "5 kN"), 5000);
  const Scenario pressed =
      read(with({{"-bc_push_type", "pressure"}, {"-bc_push_uy", "-"}, {"-bc_push_value", "3 bar"}}));
  EXPECT_EQ((*pressed.bcs[0].value)(x, 2, 0), 3e5);
}

TEST(Scenario, ParametersAndTablesStandInRunUnits) {
  const Scenario scenario = read(with({{"-units", "mm_t_s_MPa"}, {"-bc_push_uy", "v0*load(t)"}}));
  const double x[2] = {0, 0};
  EXPECT_EQ((*scenario.bcs[0].component[1])(x, 2, 0.5), 16500);
}

TEST(Scenario, ThePrintedScenarioReadsBackTheSame) {
  const Options changes = {{"-title", "a long title - with (signs)"},
                           {"-units", "mm_t_s_MPa"},
                           {"-mesh_set_h", "0.1"},
                           {"-bc_push_uy", " -t*0.1 + load(t)"},
                           {"-material_beam_model", "j2"},
                           {"-material_beam_sigma_y", "368 MPa"},
                           {"-material_beam_locking", "fbar"},
                           {"-material_wedge_c", "0.001 m^2/(N.s)"},
                           {"-material_wedge_region", "part one,part two"},
                           {"-contact_tip_penalty", "1e8 N/mm^3"},
                           {"-contact_tip_gap_tol", "0.01 mm"},
                           {"-ts_times", "0,10,50"},
                           {"-ts_dts", "1,0.1"},
                           {"-output_vis_times", "1,2.5"}};
  const std::string first = impact::print_scenario(read(with(changes)));
  OptionsScope scope;
  scope.insert_file(OptionsScope::file(first));
  EXPECT_EQ(impact::print_scenario(read_scenario(PETSC_COMM_SELF)), first);
  for (const char* line :
       {"-material_beam_sigma_y 368\n", "-contact_tip_gap_tol 0.01\n", "-material_beam_locking fbar\n",
        "-bc_push_uy \" -t*0.1 + load(t)\"\n", "-mesh_set_h 0.1\n", "-contact_tip_search_radius auto\n",
        "-material_wedge_region \"part one,part two\"\n"})
    EXPECT_NE(first.find(line), std::string::npos) << line;
}

TEST(Scenario, AMissingGroupIsNamedWithThoseOfTheMesh) {
  const std::vector<impact::Group> groups = {{"beam", 2},  {"wedge", 2},  {"clamp", 1},  {"push", 1},
                                             {"slide", 1}, {"c_beam", 1}, {"c_wedge", 1}};
  const auto message = [&](const Options& changes) -> std::string {
    Options options = with({{"-bc_push_on", "push"},
                            {"-contact_tip_secondary", "c_wedge"},
                            {"-contact_tip_primary", "c_beam"},
                            {"-measure_tail_on", "clamp"}});
    for (const auto& [key, value] : changes) options[key] = value;
    const Scenario scenario = read(options);
    try {
      impact::check_groups(scenario, groups, 2);
    } catch (const impact::UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::data);
      return error.what();
    }
    return "accepted";
  };
  const std::string has = "; mesh has: beam, wedge (2D); clamp, push, slide, c_beam, c_wedge (1D)";
  EXPECT_EQ(message({}), "accepted");
  EXPECT_EQ(message({{"-bc_push_on", "wegde"}}), "-bc_push_on \"wegde\": no such physical group" + has);
  EXPECT_EQ(message({{"-contact_tip_primary", "beam"}}),
            "-contact_tip_primary \"beam\": is a group of dimension 2; allowed: dimension 1" + has);
  EXPECT_EQ(message({{"-contact_tip_primary", "plane"}}), "accepted");
  EXPECT_EQ(message({{"-bc_push_uz", "0"}}),
            "-bc_push_uz \"0\": the mesh is plane; allowed: x and y components");
  EXPECT_EQ(message({{"-dim", "3"}}),
            "-dim \"3\": the mesh has dimension 2; allowed: its dimension, or leave it out");
}

TEST(Scenario, HelpNamesEveryOptionWithItsUnit) {
  const std::string help = impact::option_help();
  std::istringstream lines(impact::option_reference());
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `-")) continue;
    const auto parts = table_cells(line);
    const std::string key = parts[0].substr(1, parts[0].size() - 2);
    const std::size_t at = help.find("  " + key + " <");
    ASSERT_NE(at, std::string::npos) << key;
    const std::string entry = help.substr(at, help.find('\n', at) - at);
    const std::string unit = parts[3].empty() ? "" : "[" + parts[3] + "]";
    EXPECT_NE(entry.find(unit), std::string::npos) << entry;
  }
}

std::filesystem::path source_folder() {
  const char* source = std::getenv("IMPACT_SOURCE_DIR");
  return source != nullptr ? std::filesystem::path(source)
                           : std::filesystem::path(__FILE__).parent_path() / ".." / "..";
}

TEST(Scenario, TheReferencePageIsThatOfTheProgram) {
  std::ifstream file(source_folder() / "options" / "README.md");
  std::ostringstream content;
  content << file.rdbuf();
  const std::string page = content.str(), begin = "<!-- impact -reference -->\n", end = "<!-- end -->";
  ASSERT_NE(page.find(begin), std::string::npos);
  const std::size_t from = page.find(begin) + begin.size();
  EXPECT_EQ(page.substr(from, page.find(end, from) - from), impact::option_reference());
}

TEST(Scenario, EveryRunInTheGalleryIsAccepted) {
  std::vector<std::filesystem::path> runs, fragments;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() / "options"))
    if (entry.path().extension() == ".opts") runs.push_back(entry.path());
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() / "options" / "solver"))
    if (entry.path().extension() == ".opts") fragments.push_back(entry.path());
  ASSERT_GE(runs.size(), 6U);
  ASSERT_GE(fragments.size(), 4U);
  const std::string mesh = base()["-mesh"];
  for (const auto& run : runs)
    for (const auto& fragment : fragments) {
      OptionsScope scope;
      scope.insert_file(run.string());
      scope.insert_file(fragment.string());
      scope.set("-mesh",
                mesh); // the file's own path is relative to the folder of an options file on the command line
      EXPECT_NO_THROW(read_scenario(PETSC_COMM_SELF)) << run << " " << fragment;
    }
}

} // namespace
