#include "classes.hpp"
#include <impact/material/cohesive.hpp>

/// The options of numbers that differ from place to place.
namespace impact {

namespace {

using Material = MaterialScenario;
using Place = PlaceScenario;
using Factor = PlaceScenario::Factor;

bool no_chance(const Material& m, const Scenario&) {
  const Place& place = m.place;
  return !(place.E.weibull > 0 || place.Gc.weibull > 0 || place.strength.weibull > 0);
}
const char* const none_of_them = "no <>E_weibull, <>Gc_weibull or <>strength_weibull is given";

} // namespace

void add_places(std::vector<OptionRow<MaterialScenario>>& rows) {
  Rows row(rows, RestartKey::guarded, &Material::place);
  // `misfit`: when the factor means nothing, and what to do then.
  using Misfit = std::pair<std::function<bool(const Material&)>, std::string>;
  const auto add = [&](const std::string& name, Factor Place::*factor, const std::string& of,
                       const std::vector<Misfit>& misfits) {
    const auto refuse = [&](OptionRow<Material>& option) {
      for (const auto& [misfit, remedy] : misfits)
        option.refused(
            [=, misfit = misfit](const Material& m, const Scenario& s) {
              return s.has_motion() && (m.place.*factor).given() && misfit(m);
            },
            remedy);
    };
    const std::size_t first = rows.size();
    refuse(
        row.expression(
               name + "_factor", [=](auto& place) -> auto& { return (place.*factor).expression; }, "1",
               positive,
               "factor on " + of + ", an expression of x, y, z at the middle of each cell; to three digits")
            .refused(
                [=](const Material& m, const Scenario&) {
                  const std::optional<Expression>& at_place = (m.place.*factor).expression;
                  return at_place && at_place->asks_for_time();
                },
                "does not change with t; allowed: an expression of x, y, z"));
    refuse(row.number(
        name + "_weibull", [=](auto& place) -> auto& { return (place.*factor).weibull; }, "1",
        or_word(positive, "none", 0),
        "modulus of a factor of chance on " + of +
            ": 1 - exp(-x^modulus) is the part of places with less than x times the value"));
    if (name == "E") return;
    for (std::size_t i = first; i < rows.size(); ++i)
      rows[i].idle([](const Material& m, const Scenario&) { return m.law.damage == Damage::none; },
                   "<>damage is none");
  };
  add("E", &Place::E, "the moduli, with nu",
      {{[](const Material& m) {
          return m.law.equation_of_state != EquationOfState::none || m.law.model == Model::rigid;
        },
        "belongs to K and G, not to an equation of state or a rigid body; allowed: <>eos none and <>model "
        "elastic or j2"}});
  add("Gc", &Place::Gc, "Gc", {});
  add("strength", &Place::strength, "the strength",
      {{[](const Material& m) { return m.law.damage != Damage::none && !is_cohesive(m.law.ge); },
        "has no effect with <>ge {ge}: E, Gc and gamma tell the strength; allowed with linear, exponential, "
        "cornelissen or lorentz"}});
  row.count("weibull_seed", &Place::seed, 0,
            "which of the fields of chance; E, Gc and strength have one each")
      .idle(no_chance, none_of_them);
  row.number(
         "weibull_length", &Place::length, "m", or_word(positive, "cell", 0),
         "edge of cubes, one of them with its corner at the origin, whose cells share a number of chance; "
         "cell: each cell has its own")
      .idle(no_chance, none_of_them);
}

} // namespace impact
