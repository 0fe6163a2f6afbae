#pragma once
#include "../input/options_scope.hpp"
#include <impact/scenario/scenario.hpp>
#include <map>
#include <string>

/// Option sets for the tests of Scenario and what comes of reading them.
namespace scenario_options {

using Options = std::map<std::string, std::string>;

/// A complete small run; every id that the tests use is declared.
inline Options base() {
  static const std::string mesh = OptionsScope::file("not read by the options", ".geo");
  static const std::string table = OptionsScope::file("0,0\n1,1\n", ".csv");
  return {{"-mesh", mesh},
          {"-params", "v0"},
          {"-param_v0", "33 m/s"},
          {"-functions", "load"},
          {"-function_load_table", table},
          {"-materials", "beam,wedge"},
          {"-material_beam_E", "72 GPa"},
          {"-material_beam_nu", "0.33"},
          {"-material_beam_rho", "2810 kg/m^3"},
          {"-material_wedge_like", "beam"},
          {"-bcs", "push"},
          {"-bc_push_on", "wedge_bottom"},
          {"-bc_push_uy", "1e-3*t"},
          {"-ics", "fly"},
          {"-ic_fly_on", "wedge"},
          {"-ic_fly_vy", "v0"},
          {"-contacts", "tip"},
          {"-contact_tip_secondary", "wedge_top"},
          {"-contact_tip_primary", "beam_bottom"},
          {"-ts_dt", "1e-3"},
          {"-ts_max_time", "0.3"},
          {"-outputs", "vis"},
          {"-probes", "p1"},
          {"-probe_p1_at", "0.1,0.2"},
          {"-stops", "end"},
          {"-stop_end_when", "t > 100"},
          {"-releases", "ring"},
          {"-release_ring_inner", "0.1"},
          {"-release_ring_outer", "0.2"},
          {"-measures", "tail"},
          {"-measure_tail_on", "beam_left"}};
}

/// base() with changes; a value "-" removes the option.
inline Options with(const Options& changes) {
  Options options = base();
  for (const auto& [key, value] : changes) {
    if (value == "-")
      options.erase(key);
    else
      options[key] = value;
  }
  return options;
}

inline impact::Scenario read(const Options& options) {
  OptionsScope scope(OptionsScope::Options(options.begin(), options.end()));
  return impact::read_scenario(PETSC_COMM_SELF);
}

struct Outcome {
  impact::ExitCode code = impact::ExitCode::ok;
  std::string message;
};

inline Outcome outcome(const Options& options) {
  try {
    read(options);
  } catch (const impact::UserError& error) {
    return {error.code(), error.what()};
  }
  return {};
}

/// The cells of a row of a Markdown table.
inline std::vector<std::string> table_cells(const std::string& line) {
  std::vector<std::string> parts;
  for (std::size_t begin = line.find("| ") + 2; begin < line.size();) {
    const std::size_t end = line.find(" |", begin - 1);
    if (end == std::string::npos) break;
    parts.push_back(end >= begin ? line.substr(begin, end - begin) : "");
    begin = end + 3;
  }
  return parts;
}

} // namespace scenario_options
