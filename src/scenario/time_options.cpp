#include "classes.hpp"
#include <algorithm>
#include <cmath>

/// The options of the time scheme and of its steps.
namespace impact {

namespace {

/// What PETSc's integrator reads itself: checked and listed here, handed over as a plain number.
void add_of_petsc(std::vector<OptionRow<Scenario>>& rows, RestartKey restart, const std::string& name,
                  const std::string& quantity, const Interval& range, const std::string& fallback,
                  const std::string& about) {
  OptionRow<Scenario>& row = Rows(rows, restart).number(name, &Scenario::thickness, quantity, range, about);
  const bool whole = quantity.empty();
  const int least = whole ? static_cast<int>(range.low) : 0;
  if (whole) row.range = any_number;
  row.allowed = whole ? "whole number >= " + std::to_string(least) : "";
  row.read = [=, unit = row.note.unit](Scenario& s, const GivenOption& option, const OptionContext& context) {
    s.time.of_petsc[name] = whole ? read_count(option, least, std::numeric_limits<int>::max())
                                  : read_number(option, unit, range, {}, context.units);
  };
  row.text = [=](const Scenario& s) {
    const auto found = s.time.of_petsc.find(name);
    return found == s.time.of_petsc.end() ? std::string() : number_text(found->second);
  };
  row.otherwise(fallback);
}

/// What steps by central differences cannot do, "" = nothing.
std::string hindrance(const Scenario& s) {
  for (const ContactScenario& contact : s.contacts) {
    const std::string of = "-contact_" + contact.id;
    if (contact.enforce == Enforcement::auglag || contact.enforce == Enforcement::semismooth)
      return "has contact by penalty or by impulses (" + of +
             "_enforce); take penalty, impulse or auto, or -ts_type newmark";
    if (contact.enforce == Enforcement::impulse && contact.method == ContactMethod::mortar)
      return "has impulses at points alone (" + of + "_method mortar); take gpts or auto";
    if (contact.impact != ImpactUpdate::automatic && contact.impact != ImpactUpdate::none)
      return "has no update of impacts (" + of + "_impact); take none or auto, or -ts_type newmark";
  }
  if (s.coupling.max_it > 1)
    return "makes one pass in a step (-coupling_snes_max_it " + std::to_string(s.coupling.max_it) +
           "); take 1, or -ts_type newmark";
  return "";
}

/// What no step that finds its load can do, "" = nothing.
std::string hindrance_of_any_path(const Scenario& s) {
  if (s.has_heat()) return "knows no heat, which flows over a time; remove that of materials, or this";
  if (!s.contacts.empty())
    return "knows no contact; prescribe the motion of nodes in the place of -contact_" +
           s.contacts.front().id + ", or remove this";
  if (s.time.period > 0) return "has no cycles; remove -ts_period, or this";
  for (const MaterialScenario& m : s.materials) {
    const std::string of = "-material_" + m.id, or_this = "; remove that, or this";
    const auto has_no_time = [&](const char* name) {
      return "has no time for rates to be of (" + of + name + ")" + or_this;
    };
    if (m.law.model == Model::rigid) return "knows no rigid bodies (" + of + "_model rigid)" + or_this;
    if (m.law.b_d > 0) return has_no_time("_b_d");
    if (std::isfinite(m.law.c)) return has_no_time("_c");
    if (m.law.rate_c > 0) return has_no_time("_jc_c");
    if (!m.rate_table.empty()) return has_no_time("_Gc_rate");
    if (m.law.fatigue_a > 0 || m.fatigue.works())
      return "has no cycles (" + of + (m.law.fatigue_a > 0 ? "_fatigue_a)" : "_fatigue)") + or_this;
    if (m.erosion.on) return "keeps all cells (" + of + "_erosion on)" + or_this;
  }
  return "";
}

/// Nor one that follows a crack.
std::string hindrance_of_path(const Scenario& s) {
  if (!s.has_motion() || s.has_inertia() || !s.has_damage())
    return "is for motion and damage with -ts_type static; take that, or remove it";
  if (s.damage.bounds != DamageBounds::vi || s.damage.substep > 0 || s.damage.theta != 1)
    return "goes with -damage_bounds vi and without -damage_ts_dt and -damage_theta; remove them, or this";
  if (s.coupling.max_it == 1) return "wants passes; remove -coupling_snes_max_it 1, or this";
  for (const MaterialScenario& m : s.materials)
    if (m.law.model == Model::j2)
      return "finds the load by elastic energy, which plastic flow is not (-material_" + m.id +
             "_model j2); remove that, or this";
  return hindrance_of_any_path(s);
}

/// Nor one that moves bodies by a length.
std::string hindrance_of_length(const Scenario& s) {
  if (!s.has_motion() || s.has_inertia())
    return "is for motion with -ts_type static; take that, or remove it";
  if (s.has_damage()) return "knows no damage; follow cracks by -ts_path_dissipation";
  return hindrance_of_any_path(s);
}

const std::string only_explicit = "is for -ts_type central_difference; take that, or remove it";

void add_scheme(std::vector<OptionRow<Scenario>>& rows) {
  Rows row(rows, RestartKey::guarded, &Scenario::time);
  row.choice("ts_type", &TimeScenario::type,
             "Newmark's method; no inertia (t is the load factor); or central differences with lumped mass, "
             "whose "
             "steps solve no equation of motion and are as short as the smallest cell wants",
             "newmark", "newmark", "static", "static", "central_difference", "central_difference")
      .notation("(97)-(98)")
      .refused([](const Scenario& s) { return s.explicit_steps() && !hindrance(s).empty(); }, hindrance);
  row.restart = RestartKey::free;
  const auto by_itself = [](const Scenario& s) { return s.explicit_steps(); };
  row.number("ts_dt", &TimeScenario::dt, "s Delta t", or_word(positive, "auto", 0),
             "time step; after a cut it grows back up to this; auto: the longest that is stable, of central "
             "differences alone")
      .otherwise("required without -ts_times; auto with central differences")
      .needed(
          [=](const Scenario& s) {
            return !by_itself(s) && (s.time.table_times.empty() || s.time.table_dts.empty());
          },
          "allowed: a time step > 0 (auto is for central differences); or give -ts_times and -ts_dts")
      .idle([=](const Scenario& s) { return !by_itself(s) && !s.time.table_dts.empty(); },
            "-ts_dts has the steps");
  row.number("ts_dt_cfl", &TimeScenario::cfl, "1", {0, 1, true, false},
             "steps are at most this part of the stable step, which is looked for again as cells deform")
      .refused([=](const Scenario& s) { return !by_itself(s); }, only_explicit);
  row.number("ts_bulk_viscosity_linear", &TimeScenario::bulk_linear, "1 b", {0, 0.2},
             "pressure rho l c b |D| against the rate D at which a cell shrinks; 0.06 damps what rings "
             "behind a shock")
      .refused([=](const Scenario& s) { return !by_itself(s); }, only_explicit);
  row.number("ts_bulk_viscosity_quadratic", &TimeScenario::bulk_quadratic, "1 a", not_negative,
             "pressure rho (a l D)^2 likewise; 1.2 spreads a shock over some five cells")
      .refused([=](const Scenario& s) { return !by_itself(s); }, only_explicit);
}

void add_limits(std::vector<OptionRow<Scenario>>& rows) {
  using Coupling = CouplingScenario;
  Rows limit(rows, RestartKey::free, &Scenario::coupling);
  limit
      .number("ts_adapt_dphi", &Coupling::max_dphi, "1", {0, 1},
              "largest growth of phi in a step: dt shrinks down to a thousandth of -ts_dt while a crack "
              "runs faster; 0: no limit")
      .idle(undamaged, no_damage);
  limit
      .number("ts_adapt_dalpha", &Coupling::max_dalpha, "1", not_negative,
              "largest growth of the plastic strain at a point in a step, likewise; 0: no limit")
      .idle(
          [](const Scenario& s) {
            return std::ranges::none_of(s.materials, [](const auto& m) { return m.law.model == Model::j2; });
          },
          "no material flows");
  limit
      .number("ts_adapt_dtheta", &Coupling::max_dtheta, "K", not_negative,
              "largest change of the temperature at a node in a step, likewise; 0: no limit")
      .idle(unheated, no_heat);
  limit
      .number("ts_adapt_closing", &Coupling::max_closing, "1", not_negative,
              "with inertia: a step in which the bodies, at their present speeds, would go deeper into each "
              "other than this many mean secondary facets is cut before it is solved; 0: no limit")
      .idle([](const Scenario& s) { return !s.has_inertia() || s.contacts.empty(); },
            "without inertia and contact bodies do not run into each other");
}

void add_ends(std::vector<OptionRow<Scenario>>& rows) {
  Rows row(rows, RestartKey::free, &Scenario::time);
  row.number("ts_period", &TimeScenario::period, "s", positive,
             "of a cyclic load: steps hit the ends and the middles of its cycles exactly")
      .otherwise("none");
  row.number("ts_max_time", &TimeScenario::max_time, "s", positive, "end of the run")
      .otherwise("required without -ts_times")
      .needed([](const Scenario& s) { return s.time.table_times.empty() || s.time.table_dts.empty(); },
              "allowed: the end of the run, > 0");
  row.count("ts_max_steps", &TimeScenario::max_steps, 1, "largest number of steps").otherwise("no limit");
  row.number("ts_substeps", &TimeScenario::most_substeps, "1", {1},
             "most sub-steps in a step that -damage_ts_dt and -heat_ts_dt may make")
      .otherwise("1e5")
      .idle([](const Scenario& s) { return s.damage.substep == 0 && s.heat.substep == 0; },
            "neither -damage_ts_dt nor -heat_ts_dt is given");
}

void add_path(std::vector<OptionRow<Scenario>>& rows) {
  Rows row(rows, RestartKey::guarded, &Scenario::coupling);
  row.number(
         "ts_path_length", &CouplingScenario::path_length, "m (P4)", positive,
         "static steps follow bodies through limits of their load and snap-back: they find the load, the t "
         "of conditions and column load_parameter, at which the node that moves most has moved by this "
         "along the way of the step before, in a step of -ts_dt, by less in a shorter one; -ts_max_time is "
         "of the path")
      .otherwise("none: t is the load")
      .refused([](const Scenario& s) { return !hindrance_of_length(s).empty(); }, hindrance_of_length);
  row.number("ts_path_dissipation", &CouplingScenario::path_dissipation, "J (P1)", positive,
             "static steps follow a crack, through snap-back too: they find the load, the t of conditions "
             "and column load_parameter, at which cracks take up this energy in a step of -ts_dt, less in a "
             "shorter one; loads that ask less of them grow by the step; -ts_max_time is of the path")
      .otherwise("none: t is the load")
      .refused([](const Scenario& s) { return !hindrance_of_path(s).empty(); }, hindrance_of_path);
}

void add_mass_scaling(std::vector<OptionRow<Scenario>>& rows) {
  Rows row(rows, RestartKey::guarded, &Scenario::time);
  row.number("ts_mass_scaling_dt", &TimeScenario::scaled_step, "s", positive,
             "cells whose stable step is shorter at the start get the mass for this one; body forces act on "
             "the mass without it")
      .otherwise("none")
      .refused([](const Scenario& s) { return !s.explicit_steps(); }, only_explicit);
  row.number("ts_mass_scaling_limit", &TimeScenario::scaling_limit, "1", not_negative,
             "most mass that may be added, over that of all bodies")
      .refused([](const Scenario& s) { return s.time.scaled_step == 0; },
               "is for -ts_mass_scaling_dt; give that, or remove it");
}

void add_table(std::vector<OptionRow<Scenario>>& rows) {
  const std::string pair = "allowed: -ts_times and -ts_dts together, or neither";
  Rows row(rows, RestartKey::free, &Scenario::time);
  row.numbers("ts_times", &TimeScenario::table_times, "s", not_negative,
              "times between which the steps of -ts_dts hold, one more than these; the first is that of the "
              "start")
      .needed([](const Scenario& s) { return !s.time.table_dts.empty(); }, pair)
      .refused([](const Scenario& s) { return !s.time.table_times.empty() && s.time.table_times[0] != 0; },
               "does not begin with 0, the start of a run; allowed: 0, then increasing times")
      .refused(
          [](const Scenario& s) {
            const auto& times = s.time.table_times;
            return std::ranges::adjacent_find(times, std::greater_equal()) != times.end();
          },
          "not increasing; allowed: increasing times");
  row.numbers("ts_dts", &TimeScenario::table_dts, "s", positive, "time steps between the times of -ts_times")
      .needed([](const Scenario& s) { return !s.time.table_times.empty(); }, pair)
      .refused([](const Scenario& s) { return s.time.table_times.size() != s.time.table_dts.size() + 1; },
               [](const Scenario& s) {
                 return std::to_string(s.time.table_dts.size()) + " steps for " +
                        std::to_string(s.time.table_times.size()) +
                        " times; allowed: one step less than times, of which the first is that of the start "
                        "(-ts_times 0,1 -ts_dts 0.1)";
               });
}

double longest_step(const TimeScenario& time) {
  return time.table_dts.empty() ? time.dt : *std::ranges::max_element(time.table_dts);
}

bool longer_than_all(const Scenario& s) {
  const auto least = s.time.of_petsc.find("ts_adapt_dt_min");
  const double longest = longest_step(s.time);
  return least != s.time.of_petsc.end() && longest > 0 && least->second > longest;
}

} // namespace

double TimeScenario::steps() const {
  double steps = dt > 0 ? std::max(1.0, max_time / dt) : HUGE_VAL;
  if (!table_times.empty()) {
    steps = std::max(0.0, max_time - table_times.back()) / table_dts.back();
    for (std::size_t i = 0; i < table_dts.size(); ++i) {
      const double length = std::min(table_times[i + 1], max_time) - table_times[i];
      steps += std::ceil(std::max(0.0, length) / table_dts[i] * (1 - 1e-9));
    }
  }
  return max_steps > 0 ? std::min<double>(steps, max_steps) : steps;
}

OptionGroup time_options() {
  OptionGroup group{"Time", "`-ts_max_time`, `-ts_times` and the `_times` of outputs are hit exactly."};
  add_scheme(group.rows);
  add_limits(group.rows);
  add_ends(group.rows);
  add_path(group.rows);
  add_mass_scaling(group.rows);
  add_table(group.rows);
  const auto add = [&](RestartKey restart, const auto&... said) {
    add_of_petsc(group.rows, restart, said...);
  };
  constexpr RestartKey scheme = RestartKey::guarded, free = RestartKey::free;
  add(scheme, "ts_newmark_rho", "1 rho (97)-(98)", fraction, "1",
      "spectral radius at infinite frequency: 1 damps nothing, 0 most; sets beta and gamma. After a kink of "
      "prescribed motion (a pulse, a ramp that stops) reactions and accelerations alternate for ever at 1");
  add(scheme, "ts_newmark_beta", "1 beta", Interval{0, 1, true}, "1/4",
      "Newmark's beta, without -ts_newmark_rho");
  add(scheme, "ts_newmark_gamma", "1 gamma", Interval{0.5, 2}, "1/2",
      "Newmark's gamma, without -ts_newmark_rho");
  for (OptionRow<Scenario>& row : group.rows)
    if (row.name.starts_with("ts_newmark_"))
      row.idle([](const Scenario& s) { return !s.has_inertia() || s.explicit_steps(); },
               "the steps of this -ts_type are not Newmark's");
  add(free, "ts_adapt_grow", "1", Interval{1}, "1.5", "factor of the step after enough easy ones");
  add(free, "ts_adapt_easy_steps", "", Interval{1}, "4", "easy steps in a row before the step grows");
  add(free, "ts_adapt_easy_its", "", Interval{0}, "10", "most iterations of an easy step");
  add(free, "ts_adapt_scale_solve_failed", "1", fraction, "0.5", "factor of the step after a failed try");
  add(free, "ts_adapt_dt_min", "s", positive, "1e-10 of -ts_dt", "shortest step");
  group.rows.back().refused(longer_than_all, [](const Scenario& s) {
    return "is longer than the longest step, " + number_text(longest_step(s.time)) +
           ", which could never be cut; allowed: a shorter one";
  });
  add(free, "ts_adapt_dt_max", "s", positive, "-ts_dt", "longest step");
  add(free, "ts_max_reject", "", Interval{0}, "10", "refused tries of a step after which the run gives up");
  group.complete = [](Scenario& s) {
    TimeScenario& time = s.time;
    if (time.table_times.empty() || time.table_dts.empty()) return;
    if (time.dt == 0) time.dt = *std::ranges::max_element(time.table_dts);
    if (time.max_time == 0) time.max_time = time.table_times.back();
  };
  return group;
}

} // namespace impact
