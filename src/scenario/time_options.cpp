#include "classes.hpp"
#include <algorithm>

/// The options of the time scheme and of its steps.
namespace impact {

namespace {

/// What PETSc's integrator reads itself: checked and listed here, handed over as a plain number.
void add_of_petsc(std::vector<OptionRow<Scenario>>& rows, RestartKey restart, const std::string& name,
                  const OptionNote& note, const Interval& range, bool whole = false) {
  const int least = whole ? static_cast<int>(range.low) : 0;
  rows.push_back({name, note, whole ? any_number : range,
                  whole ? "whole number >= " + std::to_string(least) : "", restart,
                  [=](Scenario& s, const GivenOption& option, const OptionContext& context) {
                    s.time.of_petsc[name] = whole ? read_count(option, least, std::numeric_limits<int>::max())
                                                  : read_number(option, note.unit, range, {}, context.units);
                  },
                  [=](const Scenario& s) {
                    const auto found = s.time.of_petsc.find(name);
                    return found == s.time.of_petsc.end() ? std::string() : number_text(found->second);
                  }});
}

void add_scheme_and_limits(std::vector<OptionRow<Scenario>>& rows) {
  using Coupling = CouplingScenario;
  Rows row(rows, RestartKey::guarded, &Scenario::time);
  Rows limit(rows, RestartKey::free, &Scenario::coupling);
  row.choice("ts_type", &TimeScenario::type,
             {"Newmark's method, or no inertia (t is the load factor)", "", "", "", "(97)-(98)"},
             {{"newmark", "newmark"}, {"static", "static"}});
  row.restart = RestartKey::free;
  row.number(
         "ts_dt", &TimeScenario::dt,
         {"time step; after a cut it grows back up to this", "required without -ts_times", "s", "Delta t"},
         positive, absent_at_zero)
      .needed([](const Scenario& s) { return s.time.table_times.empty() || s.time.table_dts.empty(); },
              "allowed: a time step > 0; or give -ts_times and -ts_dts");
  limit.number("ts_adapt_dphi", &Coupling::max_dphi,
               {"largest growth of phi in a step: dt shrinks down to a thousandth of -ts_dt while a crack "
                "runs faster; 0: no limit",
                "", "1"},
               {0, 1});
  limit.number("ts_adapt_dalpha", &Coupling::max_dalpha,
               {"largest growth of the plastic strain at a point in a step, likewise; 0: no limit", "", "1"},
               not_negative);
  limit.number("ts_adapt_dtheta", &Coupling::max_dtheta,
               {"largest change of the temperature at a node in a step, likewise; 0: no limit", "", "K"},
               not_negative);
  limit.number("ts_adapt_closing", &Coupling::max_closing,
               {"with inertia: a step in which the bodies, at their present speeds, would go deeper into "
                "each other than this many mean secondary facets is cut before it is solved; 0: no limit",
                "", "1"},
               not_negative);
  row.number("ts_period", &TimeScenario::period,
             {"of a cyclic load: steps hit the ends and the middles of its cycles exactly", "none", "s"},
             positive, absent_at_zero);
  row.number("ts_max_time", &TimeScenario::max_time, {"end of the run", "required without -ts_times", "s"},
             positive, absent_at_zero)
      .needed([](const Scenario& s) { return s.time.table_times.empty() || s.time.table_dts.empty(); },
              "allowed: the end of the run, > 0");
  row.count("ts_max_steps", &TimeScenario::max_steps, {"largest number of steps", "no limit"}, 1);
  row.number("ts_substeps", &TimeScenario::most_substeps,
             {"most sub-steps in a step that -damage_ts_dt and -heat_ts_dt may make", "1e5", "1"}, {1});
}

void add_table(std::vector<OptionRow<Scenario>>& rows) {
  const std::string pair = "allowed: -ts_times and -ts_dts together, or neither";
  Rows row(rows, RestartKey::free, &Scenario::time);
  row.numbers("ts_times", &TimeScenario::table_times,
              {"times between which the steps of -ts_dts hold, one more than these", "", "s"}, not_negative)
      .needed([](const Scenario& s) { return !s.time.table_dts.empty(); }, pair)
      .refused(
          [](const Scenario& s) {
            const auto& times = s.time.table_times;
            return std::adjacent_find(times.begin(), times.end(), std::greater_equal()) != times.end();
          },
          "not increasing; allowed: increasing times");
  row.numbers("ts_dts", &TimeScenario::table_dts, {"time steps between the times of -ts_times", "", "s"},
              positive)
      .needed([](const Scenario& s) { return !s.time.table_times.empty(); }, pair)
      .refused([](const Scenario& s) { return s.time.table_times.size() != s.time.table_dts.size() + 1; },
               [](const Scenario& s) {
                 return std::to_string(s.time.table_dts.size()) + " steps for " +
                        std::to_string(s.time.table_times.size()) +
                        " times; allowed: one step less than times";
               });
}

} // namespace

OptionGroup time_options() {
  OptionGroup group{"Time", "`-ts_max_time`, `-ts_times` and the `_times` of outputs are hit exactly."};
  add_scheme_and_limits(group.rows);
  add_table(group.rows);
  const auto add = [&](RestartKey restart, const std::string& name, const OptionNote& note,
                       const Interval& range,
                       bool whole = false) { add_of_petsc(group.rows, restart, name, note, range, whole); };
  constexpr RestartKey scheme = RestartKey::guarded, free = RestartKey::free;
  add(scheme, "ts_newmark_rho",
      {"spectral radius at infinite frequency: 1 damps nothing, 0 most; sets beta and gamma", "1", "1", "rho",
       "(97)-(98)"},
      {0, 1, false, false});
  add(scheme, "ts_newmark_beta", {"Newmark's beta, without -ts_newmark_rho", "1/4", "1", "beta"},
      {0, 1, true, false});
  add(scheme, "ts_newmark_gamma", {"Newmark's gamma, without -ts_newmark_rho", "1/2", "1", "gamma"},
      {0.5, 2, false, false});
  add(free, "ts_adapt_grow", {"factor of the step after enough easy ones", "1.5", "1"}, {1});
  add(free, "ts_adapt_easy_steps", {"easy steps in a row before the step grows", "4"}, {1}, true);
  add(free, "ts_adapt_easy_its", {"most iterations of an easy step", "10"}, {0}, true);
  add(free, "ts_adapt_scale_solve_failed", {"factor of the step after a failed try", "0.5", "1"}, {0, 1});
  add(free, "ts_adapt_dt_min", {"shortest step", "1e-10 of -ts_dt", "s"}, positive);
  add(free, "ts_adapt_dt_max", {"longest step", "-ts_dt", "s"}, positive);
  add(free, "ts_max_reject", {"refused tries of a step after which the run gives up", "10"}, {0}, true);
  group.complete = [](Scenario& s) {
    TimeScenario& time = s.time;
    if (time.table_times.empty() || time.table_dts.empty()) return;
    if (time.dt == 0) time.dt = *std::max_element(time.table_dts.begin(), time.table_dts.end());
    if (time.max_time == 0) time.max_time = time.table_times.back();
  };
  return group;
}

} // namespace impact
