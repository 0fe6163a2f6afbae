#include "scenario_tables.hpp"
#include <cmath>
#include <impact/input/database.hpp>
#include <impact/input/expression.hpp>
#include <impact/material/hardening_table.hpp>
#include <impact/petsc/error.hpp>

/// The table of the options -material_<id>_..., and what is made of them.
namespace impact {

namespace {

using Material = MaterialInput;
using Law = MaterialDescription;

/// Place of a member of the law in a MaterialInput.
template <class Value, class Part> auto law(Value Part::*member) {
  return [member](auto& material) -> auto& { return material.scenario.law.*member; };
}

/// A number that must be given when its physics is on: 0 = absent.
OptionRow<Material> required(const std::string& name, double Law::*member, const OptionNote& note,
                             double high) {
  return number_row<Material>(name, law(member), note, {0, high, true, false}, {{"", 0.}});
}

std::vector<OptionRow<Material>> elastic_rows() {
  const NumberWords none = {{"", MaterialInput::absent}};
  return {
      list_row<Material>("region", [](auto& m) -> auto& { return m.scenario.regions; },
                         {"regions of the mesh made of it", "the id"}),
      choice_row<Material, Model>(
          "model", law(&Law::model),
          {"what the material can do beside damage; rigid: each body of its cells moves as "
           "a whole, with the mass that rho gives",
           "elastic"},
          {{"elastic", Model::elastic}, {"j2", Model::j2}, {"rigid", Model::rigid}}),
      number_row<Material>("E", &Material::E,
                           {"Young's modulus, with nu", "required, or K and G", "Pa", "E", "(52)-(53)"},
                           {0, 1e15, true, false}, none),
      number_row<Material>("nu", &Material::nu,
                           {"Poisson's ratio", "required, or K and G", "1", "nu", "(52)-(53)"},
                           {-1, 0.5, true, true}, none),
      number_row<Material>("K", &Material::K, {"bulk modulus, with G", "", "Pa", "K", "(52)"},
                           {0, 1e15, true, false}, none),
      number_row<Material>("G", &Material::G, {"shear modulus, with K", "", "Pa", "G", "(53)"},
                           {0, 1e15, true, false}, none),
      required("rho", &Law::rho,
               {"reference density", "required with inertia or a body force", "kg/m^3", "rho_0", "(3)"}, 1e6),
      choice_row<Material, std::optional<Locking>>(
          "locking", &Material::locking,
          {"cure of volumetric locking in quads and hexes; auto: mean "
           "for j2 and for nu from 0.45 on, else none",
           "auto"},
          {{"auto", std::nullopt},
           {"mean", Locking::mean},
           {"fbar", Locking::fbar},
           {"none", Locking::none}}),
  };
}

/// Per volume, or per mass with a unit that says so.
OptionRow<Material> capacity_row() {
  OptionRow<Material> row = number_row<Material>(
      "c_v", law(&Law::c_v),
      {"heat capacity at fixed elastic volume, that of free expansion, per reference volume; in J/(kg.K) "
       "it is multiplied by rho",
       "none: no heat", "J/(m^3.K)", "c_V", "(57)"},
      positive, {{"", 0.}});
  const auto per_volume = row.read;
  row.read = [per_volume](Material& target, const GivenOption& option, const OptionContext& context) {
    target.c_mass = MaterialInput::absent;
    if (!parse_number(option.text)) {
      try {
        target.c_mass = parse_quantity(option.text, parse_unit("J/(kg.K)").dimension, context.units);
      } catch (const std::invalid_argument&) {
        // per volume then, or a fault that is told so
      }
      if (target.c_mass > 0) return;
    }
    target.c_mass = MaterialInput::absent;
    per_volume(target, option, context);
  };
  return row;
}

/// A file with two columns, read and made into the law's table at once.
OptionRow<Material> hardening_table_row() {
  OptionRow<Material> row = file_row<Material>(
      "hardening_table", [](auto& m) -> auto& { return m.scenario.hardening_table; },
      {"file with two columns alpha, k (stress in run units) of hardening table: straight between the rows, "
       "constant after the last",
       "required with hardening table", "", "k_0", "(55a)"});
  const auto find = row.read;
  row.read = [find](Material& target, const GivenOption& option, const OptionContext& context) {
    find(target, option, context);
    const std::string text = read_input_file(context.comm, option, target.scenario.hardening_table);
    try {
      const LinearTable table = parse_table(text);
      std::vector<std::pair<double, double>> points;
      for (std::size_t i = 0; i < table.t.size(); ++i) points.emplace_back(table.t[i], table.value[i]);
      target.scenario.law.points = std::make_shared<const HardeningTable>(points);
      target.scenario.law.table = target.scenario.law.points.get();
    } catch (const std::invalid_argument& reason) {
      refuse_option(option, std::string(reason.what()) +
                                "; allowed: a file with two columns of numbers, alpha from 0 and k > 0");
    }
  };
  return row;
}

std::vector<OptionRow<Material>> hardening_rows() {
  const NumberWords none = {{"", MaterialInput::absent}};
  return {
      required("sigma_y", &Law::sigma_y,
               {"yield stress", "required with j2, but for hardening table or johnson_cook", "Pa", "sigma_y",
                "(55)"},
               1e15),
      list_row<Material>("hardening", &Material::hardening,
                         {"parts of k_0 = sigma_y + r (1 - exp(-s alpha)) + H alpha that must be given, they "
                          "add; or, alone, "
                          "johnson_cook or table",
                          "", "", "k_0", "(55')"},
                         {"none", "voce", "linear", "johnson_cook", "table"}),
      number_row<Material>("voce_r", law(&Law::voce_r),
                           {"saturation of the hardening", "0", "Pa", "r_p", "(55)"}, not_negative),
      number_row<Material>("voce_s", law(&Law::voce_s), {"rate of the saturation", "0", "1", "s_p", "(55)"},
                           not_negative),
      number_row<Material>("linear_h", &Material::linear_h, {"linear hardening modulus", "0", "Pa", "H"},
                           not_negative, none),
      hardening_table_row(),
      number_row<Material>("jc_a", &Material::jc_a,
                           {"Johnson-Cook: k = (A + B alpha^n) (1 + C ln(rate/rate0)) (1 - T*^m)",
                            "required with hardening johnson_cook", "Pa", "A", "(55a)"},
                           {0, 1e15, true, false}, none),
      number_row<Material>("jc_b", law(&Law::power_b),
                           {"its B", "required with hardening johnson_cook", "Pa", "B", "(55a)"},
                           {0, 1e15, true, false}, {{"", 0.}}),
      number_row<Material>("jc_n", law(&Law::power_n), {"its exponent of alpha", "1", "1", "n", "(55a)"},
                           {0, 1, true, false}),
      number_row<Material>("jc_c", law(&Law::rate_c),
                           {"rate factor 1 + C ln(rate/rate0) above the rate rate0, with any hardening", "0",
                            "1", "C", "(55a)"},
                           not_negative),
      number_row<Material>(
          "jc_rate0", &Material::rate_0,
          {"rate of alpha from which jc_c counts", "required with jc_c", "1/s", "rate0", "(55a)"}, positive,
          none),
      choice_row<Material, std::optional<Softening>>(
          "softening", &Material::softening,
          {"factor of the temperature on k; linear: 1 - w (theta - theta0); johnson_cook: 1 - T*^m; auto: "
           "johnson_cook with the hardening of that name where jc_theta_melt is given, else none",
           "auto", "", "f", "(55a)"},
          {{"auto", std::nullopt},
           {"none", Softening::none},
           {"linear", Softening::linear},
           {"johnson_cook", Softening::johnson_cook}}),
      number_row<Material>(
          "softening_w", law(&Law::softening_w),
          {"slope of the linear softening", "required with softening linear", "1/K", "w", "(55a)"},
          not_negative, {{"", 0.}}),
      number_row<Material>("jc_m", law(&Law::softening_m), {"exponent of T*", "1", "1", "m", "(55a)"},
                           positive),
      number_row<Material>("jc_theta_melt", law(&Law::theta_melt),
                           {"temperature of melting, where T* = (theta - theta_ref)/(theta_melt - theta_ref) "
                            "is 1 and k zero",
                            "required with softening johnson_cook", "K", "theta_melt", "(55a)"},
                           positive, {{"", 0.}}),
      number_row<Material>("jc_theta_ref", &Material::theta_ref,
                           {"temperature up to which T* is 0", "theta0", "K", "theta_ref", "(55a)"}, positive,
                           none),
  };
}

std::vector<OptionRow<Material>> thermal_rows() {
  return {
      number_row<Material>("taylor_quinney", law(&Law::taylor_quinney),
                           {"part of the plastic work that is dissipated", "0.9", "1", "chi"}, fraction),
      capacity_row(),
      number_row<Material>("conductivity", law(&Law::conductivity),
                           {"thermal conductivity; 0: no heat flows", "0", "W/(m.K)", "kappa", "(63)"},
                           not_negative),
      choice_row<Material, Conduction>(
          "conduction", law(&Law::conduction),
          {"heat flux isotropic where the body is now, or in the reference body (the paper's)", "spatial", "",
           "", "(63)"},
          {{"spatial", Conduction::spatial}, {"material", Conduction::material}}),
      choice_row<Material, ConductionDegradation>(
          "gtheta", law(&Law::gtheta),
          {"degradation of the conductivity by damage: g_e1 or 1", "ge", "", "g_theta", "(63)"},
          {{"ge", ConductionDegradation::ge}, {"one", ConductionDegradation::one}}),
      number_row<Material>("alpha_t", law(&Law::alpha_t),
                           {"thermal expansion", "0", "1/K", "alpha_t", "(46)"}, any_number),
      number_row<Material>("theta0", law(&Law::theta0),
                           {"reference temperature", "298.15", "K", "theta_0", "(46)"}, positive),
  };
}

std::vector<OptionRow<Material>> damage_rows() {
  return {
      choice_row<Material, Damage>("damage", law(&Law::damage),
                                   {"crack model: at2 damages from the start, at1 is elastic up to "
                                    "sqrt(3 E G_c/(8 gamma))",
                                    "none", "", "", "(56)"},
                                   {{"none", Damage::none}, {"at2", Damage::at2}, {"at1", Damage::at1}}),
      required("Gc", &Law::Gc, {"Griffith's fracture energy", "required with damage", "N/m", "G_c", "(56)"},
               1e9),
      required("gamma", &Law::gamma,
               {"width of the phase layer: a crack is exp(-|x|/gamma) with at2, (1 - |x|/2 gamma)^2 with at1",
                "required with damage", "m", "gamma", "(56)"},
               1e3),
      number_row<Material>("c", law(&Law::c),
                           {"damage rate; inf: rate-independent", "inf", "m^2/(N.s)", "c", "(63)"}, positive,
                           {{"inf", unbounded}}),
      number_row<Material>("zeta", law(&Law::zeta), {"exponent in the damage rate", "1", "1", "zeta", "(63)"},
                           not_negative),
      number_row<Material>(
          "delta", law(&Law::delta),
          {"shift in the damage rate: (1 + delta - phi)^zeta / c", "0", "1", "delta", "(63)"}, fraction),
      number_row<Material>(
          "fatigue_a", law(&Law::fatigue_a),
          {"growth of the fatigue variable with the stress power of damaged material; 0: no fatigue", "0",
           "m^2", "a", "(F1)"},
          not_negative),
      number_row<Material>("b_d", law(&Law::b_d),
                           {"viscous stress 2 b_d dC/dt", "0", "N.s/m^2", "b_d", "(62)"}, not_negative),
      flag_row<Material>("visc_degrade", law(&Law::visc_degrade),
                         {"damage weakens the viscous stress too", "off"}),
      choice_row<Material, Split>(
          "split", law(&Law::split),
          {"which energy drives damage: spectral, only that of principal stretches above 1 and of dilation; "
           "volumetric, all but volumetric compression, or none, all (the paper's run), so that shear drives "
           "it "
           "in compression too; auto: spectral where that is possible, in elastic bodies with 0 <= nu < 0.45 "
           "without heat, plane stress or a cure of locking, else volumetric",
           "auto", "", "g_e2", "(49)"},
          {{"auto", Split::automatic},
           {"volumetric", Split::volumetric},
           {"none", Split::none},
           {"spectral", Split::spectral}}),
      choice_row<Material, Degradation>(
          "ge", law(&Law::ge),
          {"degradation of the elastic energy; ductile: (1 - phi)^(2 alpha/alpha_c)", "quadratic", "", "g_e1",
           "(49)"},
          {{"quadratic", Degradation::quadratic},
           {"cubic", Degradation::cubic},
           {"ductile", Degradation::ductile}}),
      number_row<Material>("cubic_s", law(&Law::cubic_s),
                           {"slope of the cubic degradation at phi = 0", "1e-4", "1", "s"},
                           {0, 2, true, false}),
      required("alpha_c", &Law::alpha_c,
               {"plastic strain at which the ductile degradation is quadratic", "required with ge ductile",
                "1", "alpha_c"},
               1e3),
      choice_row<Material, PlasticDegradation>(
          "gp", law(&Law::gp), {"degradation of the plastic energy: 1 or g_e1", "one", "", "g_p", "(54)"},
          {{"one", PlasticDegradation::one}, {"ge", PlasticDegradation::ge}}),
      number_row<Material>("plastic_threshold", law(&Law::plastic_threshold),
                           {"plastic energy H_0 that does not drive damage, with gp ge: the drive is "
                            "<H_0 - W_0>",
                            "0", "J/m^3", "W_0"},
                           not_negative),
      choice_row<Material, DamageGradient>(
          "damage_gradient", law(&Law::damage_gradient),
          {"gradient of phi in the crack energy", "spatial", "", "", "(56)"},
          {{"spatial", DamageGradient::spatial}, {"material", DamageGradient::material}}),
      number_row<Material>("residual_stiffness", law(&Law::residual_stiffness),
                           {"part of the stiffness that stays in a crack", "1e-6", "1", "k"},
                           {0, 1, false, true}),
  };
}

[[noreturn]] void missing(const std::string& id, const std::string& name, const std::string& why) {
  throw UserError(ExitCode::usage, "-material_" + id + "_" + name + ": missing; " + why);
}

void check_rigid(const MaterialInput& input) {
  const Law& law = input.scenario.law;
  const std::string prefix = "-material_" + law.id + "_";
  const std::pair<const char*, bool> given[] = {
      {"E", !std::isnan(input.E)},  {"nu", !std::isnan(input.nu)},          {"K", !std::isnan(input.K)},
      {"G", !std::isnan(input.G)},  {"damage", law.damage != Damage::none}, {"b_d", law.b_d != 0},
      {"sigma_y", law.sigma_y != 0}};
  for (const auto& [name, is_given] : given)
    if (is_given)
      throw UserError(ExitCode::usage, prefix + name + ": has no meaning with " + prefix +
                                           "model rigid; allowed: region, rho; remove it");
}

void set_moduli(MaterialInput& input) {
  Law& result = input.scenario.law;
  const std::string prefix = "-material_" + result.id + "_";
  const std::string remedy =
      "give " + prefix + "E and " + prefix + "nu, or " + prefix + "K and " + prefix + "G";
  if (result.model == Model::rigid) return check_rigid(input);
  const bool by_E = !std::isnan(input.E) || !std::isnan(input.nu),
             by_K = !std::isnan(input.K) || !std::isnan(input.G);
  if (by_E && by_K) throw UserError(ExitCode::usage, prefix + "E: contradicts K and G; " + remedy);
  if (!by_K) {
    if (std::isnan(input.E)) missing(result.id, "E", remedy);
    if (std::isnan(input.nu)) missing(result.id, "nu", remedy);
    result.K = input.E / (3 * (1 - 2 * input.nu));
    result.G = input.E / (2 * (1 + input.nu));
    return;
  }
  if (std::isnan(input.K)) missing(result.id, "K", remedy);
  if (std::isnan(input.G)) missing(result.id, "G", remedy);
  result.K = input.K;
  result.G = input.G;
}

bool has_part(const MaterialInput& input, const std::string& part) {
  return std::find(input.hardening.begin(), input.hardening.end(), part) != input.hardening.end();
}

/// Hardening that brings its own yield stress, and stands alone.
void set_own_hardening(MaterialInput& input, const std::string& name, HardeningKind kind, double yield) {
  Law& law = input.scenario.law;
  const std::string prefix = "-material_" + law.id + "_", with = prefix + "hardening " + name;
  for (const std::string& part : input.hardening)
    if (part != name)
      throw UserError(ExitCode::usage, with + "," + part + ": " + name + " stands alone; remove " + part);
  if (law.sigma_y != 0)
    throw UserError(ExitCode::usage, prefix + "sigma_y: has no meaning with " + with +
                                         ", which tells the yield stress itself; remove it");
  law.hardening = kind;
  law.sigma_y = yield;
}

void set_hardening(MaterialInput& input) {
  Law& law = input.scenario.law;
  const std::string prefix = "-material_" + law.id + "_";
  if (law.rate_c > 0) {
    if (std::isnan(input.rate_0)) missing(law.id, "jc_rate0", "a rate is needed by " + prefix + "jc_c");
    law.rate_0 = input.rate_0;
  }
  if (has_part(input, "table")) {
    if (!law.table) missing(law.id, "hardening_table", "needed by " + prefix + "hardening table");
    return set_own_hardening(input, "table", HardeningKind::table, law.table->at(0).k);
  }
  if (!has_part(input, "johnson_cook")) return;
  const std::string needed = "needed by " + prefix + "hardening johnson_cook";
  if (std::isnan(input.jc_a)) missing(law.id, "jc_a", needed);
  if (law.power_b == 0) missing(law.id, "jc_b", needed);
  set_own_hardening(input, "johnson_cook", HardeningKind::power, input.jc_a);
}

void set_softening(MaterialInput& input) {
  Law& law = input.scenario.law;
  const std::string prefix = "-material_" + law.id + "_", linear = prefix + "softening linear";
  const bool by_name = law.hardening == HardeningKind::power && law.theta_melt > 0;
  law.softening = input.softening.value_or(by_name ? Softening::johnson_cook : Softening::none);
  law.theta_ref = std::isnan(input.theta_ref) ? law.theta0 : input.theta_ref;
  if (law.softening == Softening::linear) {
    if (law.softening_w == 0) missing(law.id, "softening_w", "a positive value is needed by " + linear);
    if (law.c_v == 0 && std::isnan(input.c_mass))
      missing(law.id, "c_v", linear + " needs a temperature that is solved for");
  }
  if (law.softening != Softening::johnson_cook) return;
  if (law.theta_melt == 0) missing(law.id, "jc_theta_melt", "needed by " + prefix + "softening johnson_cook");
  if (law.theta_melt <= law.theta_ref)
    throw UserError(ExitCode::usage, prefix + "jc_theta_melt: not above " + prefix + "jc_theta_ref " +
                                         number_text(law.theta_ref) + "; give the temperature of melting");
}

void set_plasticity(MaterialInput& input) {
  Law& result = input.scenario.law;
  if (result.model != Model::j2) return;
  set_hardening(input);
  set_softening(input);
  if (result.sigma_y == 0)
    missing(result.id, "sigma_y", "-material_" + result.id + "_model j2 needs a yield stress");
  for (const std::string& part : input.hardening) {
    const std::string needed = " is needed by -material_" + result.id + "_hardening " + part;
    if (part == "voce" && result.voce_r == 0) missing(result.id, "voce_r", "a positive value" + needed);
    if (part == "voce" && result.voce_s == 0) missing(result.id, "voce_s", "a positive value" + needed);
    if (part == "linear" && std::isnan(input.linear_h)) missing(result.id, "linear_h", "a value" + needed);
  }
}

void set_capacity(MaterialInput& input) {
  if (std::isnan(input.c_mass)) return;
  Law& result = input.scenario.law;
  if (result.rho == 0) missing(result.id, "rho", "-material_" + result.id + "_c_v is given per mass");
  result.c_v = input.c_mass * result.rho;
}

void check_damage(const Law& result) {
  if (result.damage == Damage::none) return;
  const std::string why = "-material_" + result.id + "_damage needs it";
  if (result.Gc == 0) missing(result.id, "Gc", why);
  if (result.gamma == 0) missing(result.id, "gamma", why);
  if (result.ge == Degradation::ductile && result.alpha_c == 0)
    missing(result.id, "alpha_c", "-material_" + result.id + "_ge ductile needs it");
}

} // namespace

OptionClass<MaterialInput> material_class() {
  std::vector<OptionRow<Material>> rows = elastic_rows();
  for (auto& row : hardening_rows()) rows.push_back(row);
  for (auto& row : thermal_rows()) rows.push_back(row);
  for (auto& row : damage_rows()) rows.push_back(row);
  return {"material", "materials",
          "`-material_<id>_like <other>` takes everything but the region from another material first.", rows};
}

bool keeps_volume(const MaterialParameters& law) {
  if (law.model == Model::rigid) return false;
  // Cook's membrane on 8 x 8 quadrilaterals is 7.6, 11 and 16 % too stiff at nu 0.3, 0.4 and 0.45 without a
  // cure; with the cell's mean volume it is 3.8 to 3.9 % at any of them.
  constexpr double least_nu = 0.45, rounding = 1e-9;
  const double nu = (3 * law.K - 2 * law.G) / (2 * (3 * law.K + law.G));
  return law.model == Model::j2 || nu >= least_nu - rounding;
}

// The split that does not break what is pressed, where check_split lets it be.
Split automatic_split(const MaterialInput& input, const Scenario& scenario) {
  const MaterialParameters& law = input.scenario.law;
  const bool cured = input.locking ? input.locking != Locking::none : keeps_volume(law);
  const bool possible = law.damage != Damage::none && law.model == Model::elastic && !cured &&
                        scenario.plane != PlaneMode::stress && !(scenario.solves("heat") && law.c_v != 0) &&
                        3 * law.K >= 2 * law.G;
  return possible ? Split::spectral : Split::volumetric;
}

Locking automatic_locking(const MaterialParameters& law, PlaneMode plane) {
  const bool curable = law.damage == Damage::none || law.split != Split::spectral;
  return plane != PlaneMode::stress && keeps_volume(law) && curable ? Locking::mean : Locking::none;
}

MaterialScenario resolve_material(const MaterialInput& given, const Scenario& scenario) {
  MaterialInput input = given;
  const bool moves = scenario.has_motion(), deforms = moves || scenario.solves("damage");
  if (!std::isnan(input.linear_h)) input.scenario.law.linear_h = input.linear_h;
  if (deforms || !std::isnan(input.E) || !std::isnan(input.K)) set_moduli(input);
  if (moves) set_plasticity(input);
  if (deforms) check_damage(input.scenario.law);
  set_capacity(input);
  MaterialScenario& material = input.scenario;
  if (material.law.split == Split::automatic) material.law.split = automatic_split(input, scenario);
  material.locking_automatic = !input.locking;
  material.law.locking = input.locking.value_or(automatic_locking(material.law, scenario.plane));
  return material;
}

} // namespace impact
