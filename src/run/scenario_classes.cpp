#include "scenario_tables.hpp"
#include <impact/run/columns.hpp>

/// The tables of the options whose names hold an id: -material_<id>_..., -bc_<id>_..., and so on.
namespace impact {

namespace {

/// Rows `<stem>x`, `<stem>y`, `<stem>z` of an array of three expressions.
template <class Struct, class Place, class UnitOf>
void add_components(std::vector<OptionRow<Struct>>& rows, const std::string& stem, Place place,
                    const std::string& about, UnitOf unit_of, const std::string& unit) {
  for (int k = 0; k < 3; ++k)
    rows.push_back(expression_row<Struct>(
        stem + "xyz"[k], [=](auto& target) -> auto& { return place(target)[k]; }, {about, "", unit},
        unit_of));
}

std::vector<std::string> all_fields() {
  std::vector<std::string> names;
  for (const FieldNote& field : field_notes()) names.emplace_back(field.name);
  return names;
}

using Contact = ContactScenario;

NumberWords automatic() { return {{"auto", Contact::automatic}}; }

std::vector<OptionRow<Contact>> contact_side_rows() {
  std::vector<OptionRow<Contact>> rows = {
      text_row<Contact>("secondary", &Contact::secondary, {"boundary whose points are checked", "required"},
                        "name of a boundary"),
      text_row<Contact>("primary", &Contact::primary,
                        {"boundary that they meet, the same one again (a surface folds on itself, or "
                         "several bodies under one name meet), or a rigid body",
                         "required"},
                        "name of a boundary, plane, rigid_sphere, rigid_cylinder"),
      point_row<Contact>("plane_point", [](auto& c) -> auto& { return c.plane_point; },
                         {"a point of the rigid plane", "0,0,0", "m"}),
      point_row<Contact>("plane_normal", [](auto& c) -> auto& { return c.plane_normal; },
                         {"normal of the rigid plane, away from its body", "0,1,0", "1"}),
      point_row<Contact>("centre", [](auto& c) -> auto& { return c.centre; },
                         {"of the rigid sphere, or a point on the axis of the cylinder", "0,0,0", "m"}),
      point_row<Contact>("axis", [](auto& c) -> auto& { return c.axis; },
                         {"of the rigid cylinder; in the plane along z", "0,0,1", "1"}),
      number_row<Contact>("radius", &Contact::radius,
                          {"of the rigid sphere or cylinder, outside of which the bodies are", "0", "m"},
                          not_negative),
  };
  add_components<Contact>(
      rows, "rigid_u", [](auto& c) -> auto& { return c.rigid_u; },
      "displacement of the rigid body over t; left out: none, or with a mass free",
      [](const Contact&) { return std::string("m"); }, "m");
  rows.push_back(number_row<Contact>("rigid_mass", &Contact::rigid_mass,
                                     {"of the rigid body, which then moves freely as the region "
                                      "obstacle_<id>; of plane bodies for the whole "
                                      "thickness; left out: it moves as told",
                                      "", "kg", "M"},
                                     positive, {{"", 0.}}));
  rows.push_back(number_row<Contact>(
      "rigid_inertia", &Contact::rigid_inertia,
      {"its moment of inertia about any axis through its centre; auto: 2/5 M R^2 of a sphere, M R^2/2 of a "
       "cylinder about its axis, also in the plane; a plane does not turn",
       "auto", "kg.m^2", "J"},
      positive, automatic()));
  rows.push_back(number_row<Contact>(
      "rigid_length", &Contact::rigid_length,
      {"of a rigid cylinder in space, for its inertia across the axis", "", "m"}, positive, {{"", 0.}}));
  add_components<Contact>(
      rows, "rigid_r", [](auto& c) -> auto& { return c.rigid_r; },
      "rotation of a rigid body with mass about its centre over t, as with -bc_<id>_rx; left out: free",
      [](const Contact&) { return std::string("1"); }, "1");
  return rows;
}

std::vector<OptionRow<Contact>> enforcement_rows() {
  return {
      choice_row<Contact, ContactMethod>("method", &Contact::method,
                                         {"constraints at Gauss points, or for mean gaps about the nodes "
                                          "(mortar); auto: mortar, gpts where both sides share nodes",
                                          "auto"},
                                         {{"auto", ContactMethod::automatic},
                                          {"gpts", ContactMethod::gauss_points},
                                          {"mortar", ContactMethod::mortar}}),
      choice_row<Contact, MultiplierSpace>("multipliers", &Contact::multipliers,
                                           {"of the mortar: the shape functions, or functions biorthogonal "
                                            "to them on facets that are covered as a "
                                            "whole; auto: standard in the plane, dual in space",
                                            "auto"},
                                           {{"auto", MultiplierSpace::automatic},
                                            {"standard", MultiplierSpace::standard},
                                            {"dual", MultiplierSpace::dual}}),
      choice_row<Contact, Enforcement>(
          "enforce", &Contact::enforce,
          {"augmented Lagrangian (Uzawa), penalty alone, or semismooth Newton with multipliers; auto: "
           "semismooth with mortar, else auglag",
           "auto", "", "", "(74)-(79)"},
          {{"auto", Enforcement::automatic},
           {"auglag", Enforcement::auglag},
           {"penalty", Enforcement::penalty},
           {"semismooth", Enforcement::semismooth}}),
      number_row<Contact>("friction", &Contact::friction,
                          {"Coulomb's coefficient of friction", "0", "1", "mu"}, not_negative),
      number_row<Contact>("conductance", &Contact::conductance,
                          {"heat that passes a closed place, per current area and temperature; 0: insulated",
                           "0", "W/(m^2.K)", "h_c", "(83')"},
                          not_negative),
      number_row<Contact>(
          "conductance_exponent", &Contact::conductance_exponent,
          {"m of h = h_c (p/p_0)^m, 0.95 of rough metals; 0: h = h_c", "0", "1", "m", "(83')"}, not_negative),
      number_row<Contact>("conductance_pressure", &Contact::conductance_pressure,
                          {"p_0 of h = h_c (p/p_0)^m, of rough metals the hardness of the softer one",
                           "required with _conductance_exponent", "Pa", "p_0", "(83')"},
                          positive, {{"", 0.}}),
      number_row<Contact>("friction_heat_split", &Contact::friction_heat_split,
                          {"part of the frictional heat that enters the secondary side; auto: 0.5, or 1 "
                           "against a rigid body",
                           "auto", "1", "", "(84')"},
                          fraction, automatic()),
      expression_row<Contact>(
          "temperature", [](auto& c) -> auto& { return c.temperature; },
          {"of the rigid body over t; left out: it is insulated", "", "K"},
          [](const Contact&) { return std::string("K"); }, positive),
      number_row<Contact>("penalty", &Contact::penalty,
                          {"starting penalty; auto: 10 E/h, E of the softest body, h the mean secondary "
                           "facet, with auglag more in steps far below h/c_p",
                           "auto", "N/m^3", "epsilon_N", "(75)"},
                          positive, automatic()),
      number_row<Contact>("penalty_increment", &Contact::penalty_increment,
                          {"added when the penalty grows; auto: the starting penalty, or four times its "
                           "automatic value from a start below that",
                           "auto", "N/m^3"},
                          not_negative, automatic()),
      number_row<Contact>("penalty_max", &Contact::penalty_max,
                          {"largest penalty; auto: 1e4 times the automatic one", "auto", "N/m^3"}, positive,
                          automatic()),
      choice_row<Contact, PenaltyGrowth>(
          "penalty_growth", &Contact::growth,
          {"grow when an augmentation closed the gap by less than a factor 4, or at every one (the "
           "paper's)",
           "slow_gap"},
          {{"slow_gap", PenaltyGrowth::on_slow_gap}, {"always", PenaltyGrowth::every_augmentation}}),
      number_row<Contact>("gap_tol", &Contact::gap_tol,
                          {"penetration at which augmentations end; auto: 1e-3 of the secondary facet",
                           "auto", "m", "", "(77)-(79)"},
                          positive, automatic()),
      number_row<Contact>(
          "pressure_tol", &Contact::pressure_tol,
          {"augmentations end where they change no multiplier by more than this part of the largest; in "
           "statics, where single points go on sharing a force otherwise, no force on a node by "
           "this part of the largest",
           "1e-2", "1"},
          positive),
  };
}

std::vector<OptionRow<Contact>> detection_rows() {
  return {
      count_row<Contact>("points", &Contact::points, {"Gauss points per secondary facet and direction", "2"},
                         1, 5),
      number_row<Contact>(
          "search_radius", &Contact::search_radius,
          {"facets are looked at as pairs up to this distance; auto: what can meet in a step, by the sizes "
           "of "
           "the facets and how far they move; overlaps are seen up to 0.8 of the smallest facet deep",
           "auto", "m"},
          positive, automatic()),
      choice_row<Contact, InitialOverlap>("initial", &Contact::initial,
                                          {"bodies that overlap at the start: secondary nodes move out "
                                           "without stress, by _initial_tol at most; refused; left so",
                                           "error"},
                                          {{"adjust", InitialOverlap::adjust},
                                           {"error", InitialOverlap::error},
                                           {"allow", InitialOverlap::allow}}),
      number_row<Contact>(
          "initial_tol", &Contact::initial_tol,
          {"deepest overlap that is moved apart; auto: 1e-3 of the secondary facet", "auto", "m"},
          not_negative, automatic()),
      choice_row<Contact, ImpactUpdate>("impact", &Contact::impact,
                                        {"treatment of the shock at touch; auto: stabilised, but none "
                                         "where another contact is conserving or nothing has a stiffness; "
                                         "conserving: a penalty whose work is exact, in the trapezoidal rule",
                                         "auto"},
                                        {{"auto", ImpactUpdate::automatic},
                                         {"stabilised", ImpactUpdate::stabilised},
                                         {"conserving", ImpactUpdate::conserving},
                                         {"none", ImpactUpdate::none}}),
  };
}

} // namespace

std::string condition_unit(BcType type) {
  switch (type) {
  case BcType::displacement:
    return "m";
  case BcType::velocity:
    return "m/s";
  case BcType::acceleration:
  case BcType::body_force:
    return "m/s^2";
  case BcType::traction:
  case BcType::pressure:
    return "Pa";
  case BcType::force:
    return "N";
  case BcType::temperature:
  case BcType::convection:
    return "K";
  case BcType::heat_flux:
    return "W/m^2";
  case BcType::heat_source:
    return "W/m^3";
  case BcType::fix:
  case BcType::symmetry:
  case BcType::damage:
    break;
  }
  return "1";
}

Interval condition_range(BcType type) {
  return type == BcType::damage                                      ? fraction
         : type == BcType::temperature || type == BcType::convection ? positive
                                                                     : any_number;
}

OptionClass<ParameterScenario> parameter_class() {
  OptionRow<ParameterScenario> value = number_row<ParameterScenario>(
      "", &ParameterScenario::value, {"value of the parameter `<id>` in every expression", "required", "any"},
      any_number);
  value.read = [](ParameterScenario& target, const GivenOption& option, const OptionContext& context) {
    try {
      target.value = parse_any_quantity(option.text, context.units);
    } catch (const std::invalid_argument& reason) {
      refuse_option(option, reason.what());
    }
  };
  value.allowed = "number, alone or with a unit";
  return {"param", "params", "Parameters are names in every expression, with values in run units.", {value}};
}

OptionClass<FunctionScenario> function_class() {
  return {"function",
          "functions",
          "`<id>(t)` in an expression interpolates the table linearly; beyond its ends it is constant.",
          {file_row<FunctionScenario>("table", &FunctionScenario::file,
                                      {"two columns of numbers: t, value", "required"})}};
}

OptionClass<BoundaryCondition> boundary_class() {
  using Bc = BoundaryCondition;
  std::vector<OptionRow<Bc>> rows = {
      list_row<Bc>("on", &Bc::on,
                   {"groups of the mesh: boundaries, points, or regions with all their nodes", "required"}),
      choice_row<Bc, BcType>(
          "type", &Bc::type,
          {"what is prescribed: traction is dead, per reference area; pressure follows, per current area, "
           "positive inwards; force is a total, spread over the reference area, the length of lines or "
           "evenly over points; body_force is per mass; "
           "heat_flux is inwards, per reference area, heat_source per reference volume; convection is a flux "
           "h (value - theta)",
           "displacement"},
          {{"fix", BcType::fix},
           {"displacement", BcType::displacement},
           {"symmetry", BcType::symmetry},
           {"velocity", BcType::velocity},
           {"acceleration", BcType::acceleration},
           {"traction", BcType::traction},
           {"pressure", BcType::pressure},
           {"force", BcType::force},
           {"body_force", BcType::body_force},
           {"damage", BcType::damage},
           {"temperature", BcType::temperature},
           {"heat_flux", BcType::heat_flux},
           {"convection", BcType::convection},
           {"heat_source", BcType::heat_source}}),
  };
  const auto unit_of = [](const Bc& bc) { return condition_unit(bc.type); };
  add_components<Bc>(
      rows, "u", [](auto& bc) -> auto& { return bc.component; },
      "component of what the type prescribes, of a displacement, velocity, force, traction, ..; left out: "
      "free, "
      "or no load",
      unit_of, "by type");
  add_components<Bc>(
      rows, "r", [](auto& bc) -> auto& { return bc.rotation; },
      "rotation of rigid bodies about their centre of mass, or with type velocity its rate; about fixed "
      "axes, "
      "in space the rotation vector where all three are given; left out: free",
      [](const Bc& bc) { return std::string(bc.type == BcType::velocity ? "1/s" : "1"); }, "by type");
  rows.push_back(expression_row<Bc>(
      "value", [](auto& bc) -> auto& { return bc.value; },
      {"scalar of pressure, damage (phi), temperature, heat_flux and heat_source; of convection the "
       "temperature around",
       "", "by type"},
      unit_of, any_number, [](const Bc& bc) { return condition_range(bc.type); }));
  rows.push_back(expression_row<Bc>(
      "h", [](auto& bc) -> auto& { return bc.coefficient; },
      {"coefficient of convection, per reference area", "", "W/(m^2.K)", "h"},
      [](const Bc&) { return std::string("W/(m^2.K)"); }, not_negative));
  return {"bc", "bcs", "Values are expressions of x, y, z (reference coordinates) and t.", rows};
}

OptionClass<InitialCondition> initial_class() {
  using Ic = InitialCondition;
  std::vector<OptionRow<Ic>> rows = {
      list_row<Ic>("on", &Ic::on, {"groups of the mesh", "required"}),
  };
  add_components<Ic>(
      rows, "u", [](auto& ic) -> auto& { return ic.u; }, "initial displacement",
      [](const Ic&) { return std::string("m"); }, "m");
  add_components<Ic>(
      rows, "v", [](auto& ic) -> auto& { return ic.v; }, "initial velocity",
      [](const Ic&) { return std::string("m/s"); }, "m/s");
  rows.push_back(expression_row<Ic>(
      "phi", [](auto& ic) -> auto& { return ic.phi; }, {"initial damage", "", "1", "phi"},
      [](const Ic&) { return std::string("1"); }, fraction));
  rows.push_back(expression_row<Ic>(
      "theta", [](auto& ic) -> auto& { return ic.theta; },
      {"initial temperature", "_theta0 of the material", "K", "theta"},
      [](const Ic&) { return std::string("K"); }, positive));
  return {"ic", "ics", "Boundary conditions win over initial ones.", rows};
}

OptionClass<ContactScenario> contact_class() {
  std::vector<OptionRow<Contact>> rows = contact_side_rows();
  for (auto& row : enforcement_rows()) rows.push_back(row);
  for (auto& row : detection_rows()) rows.push_back(row);
  return {"contact", "contacts",
          "The secondary side carries the points that must not enter the primary one: take the finer, softer "
          "or smaller "
          "side.",
          rows};
}

OptionClass<OutputScenario> output_class() {
  using Output = OutputScenario;
  return {"output",
          "outputs",
          "Without `_dt`, `_every`, `_cycles` and `_times` every accepted step is written. The history has a "
          "row for "
          "each step, unless `_cycles` says otherwise.",
          {
              choice_row<Output, Output::Type>("type", &Output::type,
                                               {"fields for ParaView, or the history table", "xdmf"},
                                               {{"xdmf", Output::Type::xdmf}, {"csv", Output::Type::csv}}),
              list_row<Output>("fields", &Output::fields,
                               {"what an xdmf output holds", "all that the physics has, without a"},
                               all_fields()),
              number_row<Output>("dt", &Output::dt,
                                 {"written at the first step at or after each multiple", "", "s"}, positive,
                                 {{"", 0.}}),
              count_row<Output>("every", &Output::every, {"written every so many steps"}, 1),
              count_row<Output>(
                  "cycles", &Output::cycles,
                  {"written in the middle and at the end of every so many cycles of -ts_period, the "
                   "history too"},
                  1),
              numbers_row<Output>("times", &Output::times,
                                  {"times that are hit exactly and written", "", "s"}, not_negative),
              text_row<Output>("file", &Output::file, {"name below -output_dir", "<id>.xdmf, history.csv"},
                               "file name"),
          }};
}

OptionClass<ProbeScenario> probe_class() {
  using Probe = ProbeScenario;
  return {
      "probe",
      "probes",
      "Values at a material point, as columns `probe_<id>_<field>` of the history.",
      {
          point_row<Probe>("at", [](auto& p) -> auto& { return p.at; },
                           {"reference coordinates", "required", "m"}),
          text_row<Probe>("on", &Probe::region, {"region, where two bodies meet", "any"}, "name of a region"),
          list_row<Probe>(
              "fields", &Probe::fields,
              {"what is written; contact fields are of its surface, the gap nan beyond its reach", "u"},
              all_fields()),
      }};
}

OptionClass<MeasureScenario> measure_class() {
  using Measure = MeasureScenario;
  return {"measure",
          "measures",
          "Values over a group, as columns `measure_<id>_<field>` of the history.",
          {
              text_row<Measure>("on", &Measure::on, {"group of the mesh", "required"}, "name of a group"),
              list_row<Measure>(
                  "fields", &Measure::fields,
                  {"what is written; contact fields are of its surface, the gap nan beyond its reach", "u"},
                  all_fields()),
              choice_row<Measure, Measure::Of>("of", &Measure::of, {"what is taken of the values", "mean"},
                                               {{"mean", Measure::Of::mean},
                                                {"min", Measure::Of::min},
                                                {"max", Measure::Of::max},
                                                {"sum", Measure::Of::sum}}),
          }};
}

OptionClass<StopScenario> stop_class() {
  return {
      "stop",
      "stops",
      "A run ends with exit status 0, a checkpoint and its last output when one of these holds at the end of "
      "a "
      "step. `peak(x)` is the largest value that x has had since t = 0, for any x; t is the time, `&&` and "
      "`||` join comparisons.",
      {
          text_row<StopScenario>(
              "when", &StopScenario::when,
              {"what ends the run, as in reaction_top_y < 0.1*peak(reaction_top_y): an expression of "
               "columns of the history and of parameters",
               "required"},
              "condition on columns by name"),
      }};
}

} // namespace impact
