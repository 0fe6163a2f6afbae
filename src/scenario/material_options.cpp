#include "classes.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

/// The options of materials, -material_<id>_..., and the law that is made of them: elasticity and heat here,
/// hardening and damage in files of their own.
namespace impact {

namespace {

using Material = MaterialScenario;
using Law = MaterialParameters;
using MaterialRows = std::vector<OptionRow<Material>>;

bool given(double number) { return !std::isnan(number); }
bool by_K(const Material& m) { return given(m.K) || given(m.G); }
bool of_state(const Material& m) { return m.law.equation_of_state != EquationOfState::none; }
bool is_rigid(const Material& m) { return m.law.model == Model::rigid; }

/// Whether moduli are looked at: heat alone does without.
bool wants_moduli(const Material& m, const Scenario& s) {
  return s.has_motion() || s.solves("damage") || given(m.E) || given(m.K);
}

/// A region that an earlier material has already: what to say of it, "" = none.
std::string taken_region(const Material& m, const Scenario& s) {
  for (const Material& other : s.materials) {
    if (other.id == m.id) break;
    for (const std::string& region : m.regions)
      if (std::ranges::find(other.regions, region) != other.regions.end())
        return " \"" + region + "\": is made of material " + other.id +
               " already; give each region to one material";
  }
  return "";
}

void add_elasticity(MaterialRows& rows) {
  const Interval modulus{0, 1e15, true, false};
  const std::string fallback = "required, or K and G", remedy = "give <>E and <>nu, or <>K and <>G";
  const std::string told = ": has no meaning with <>eos, whose bulk modulus is rho c0^2; give <>G alone";
  const auto by_young = [](const Material& m, const Scenario& s) {
    return wants_moduli(m, s) && !is_rigid(m) && !by_K(m) && !of_state(m);
  };
  const auto by_bulk = [](const Material& m, const Scenario& s) {
    return wants_moduli(m, s) && !is_rigid(m) && by_K(m) && !of_state(m);
  };
  Rows row(rows);
  row.list("region", &Material::regions, "regions of the mesh made of it")
      .otherwise("the id")
      .barred([](const Material& m, const Scenario& s) { return !taken_region(m, s).empty(); }, taken_region)
      .group_dimension = [](const Material&, int dim) { return dim; };
  Rows of_law(rows, RestartKey::guarded, &Material::law);
  of_law.choice("model", &Law::model,
                "what the material can do beside damage; rigid: each body of its cells moves as a whole, "
                "with the mass that rho gives",
                "elastic", Model::elastic, "j2", Model::j2, "rigid", Model::rigid);
  row.number("E", &Material::E, "Pa E (52)-(53)", modulus, "Young's modulus, with nu")
      .otherwise(fallback)
      .needed(by_young, remedy)
      .barred(by_bulk, ": contradicts K and G; " + remedy)
      .barred(of_state, told);
  row.number("nu", &Material::nu, "1 nu (52)-(53)", {-1, 0.5, true, true}, "Poisson's ratio")
      .otherwise(fallback)
      .needed(by_young, remedy)
      .barred(by_bulk, ": contradicts K and G; " + remedy)
      .barred(of_state, told);
  row.number("K", &Material::K, "Pa K (52)", modulus, "bulk modulus, with G")
      .needed(by_bulk, remedy)
      .barred(of_state, told);
  row.number("G", &Material::G, "Pa G (53)", modulus, "shear modulus, with K or an equation of state")
      .needed(by_bulk, remedy)
      .needed([](const Material& m) { return of_state(m) && !is_rigid(m); },
              "the shear modulus is needed beside <>eos, which tells the bulk modulus");
  of_law.number("rho", &Law::rho, "kg/m^3 rho_0 (3)", {0, 1e6, true, false}, "reference density")
      .otherwise("required with inertia or a body force")
      .needed([](const Material& m) { return given(m.c_mass); }, "<>c_v is given per mass")
      .needed(of_state, "the bulk modulus of <>eos is rho c0^2")
      .needed(
          [](const Material&, const Scenario& s) {
            return std::ranges::any_of(s.bcs, [](const auto& bc) { return bc.type == BcType::body_force; });
          },
          "needed by a body force")
      .needed([](const Material&, const Scenario& s) { return s.has_inertia(); },
              "needed by inertia; or run without it: -ts_type static");
  row.choice(
         "locking", &Material::locking,
         "cure of volumetric locking: mean, the volume of a cell, of linear triangles and tetrahedra that of "
         "patches of 2 and of 8 (none under splits by principal stretches), of quadrilaterals and hexahedra "
         "of second order a linear function in it; fbar, that of the centroid, in other cells; auto: mean "
         "for j2 and for nu from 0.45 on, else none, as where all cells are simplices of second order and "
         "K is at most 100 G",
         "auto", std::nullopt, "mean", Locking::mean, "fbar", Locking::fbar, "none", Locking::none)
      .refused([](const Material& m,
                  const Scenario& s) { return s.plane == PlaneMode::stress && m.locking != Locking::none; },
               "has no meaning with -plane stress, where the volume is free; allowed: auto, none");
}

/// Whether the pressure of an equation of state feels heat.
bool heats(const Material& m, const Scenario& s) {
  return of_state(m) && s.solves("heat") && m.has_capacity();
}
/// Gamma^2 c_V theta_0: what a body that is pressed is stiffer by where no heat leaves it.
double adiabatic_part(const Material& m) {
  const double c_v = given(m.c_mass) ? m.c_mass * m.law.rho : m.c_v;
  return m.eos_gamma * m.eos_gamma * c_v * m.law.theta0;
}

void add_state(MaterialRows& rows) {
  const Interval speed{0, 1e6, true, false};
  const auto without = [](const Material& m) { return !of_state(m); };
  const std::string useless = ": has no meaning without <>eos; add <>eos mie_grueneisen, or remove it";
  Rows row(rows);
  Rows of_law(rows, RestartKey::guarded, &Material::law);
  of_law
      .choice("eos", &Law::equation_of_state,
              "equation of state, in the place of the volumetric energy (52), for high pressure; "
              "mie_grueneisen: from shocks with the speed U_s = c0 + s u_p; with rho and G in the place of E "
              "and nu, the bulk modulus is rho c0^2",
              "none", EquationOfState::none, "mie_grueneisen", EquationOfState::mie_grueneisen)
      .notation("p (52a)")
      .refused(
          [](const Material& m, const Scenario& s) { return of_state(m) && s.plane == PlaneMode::stress; },
          "not available with -plane stress, where nothing is pressed hard; allowed: strain, "
          "axisymmetric, or meshes in space; choose none");
  row.number("eos_c0", &Material::eos_c0, "m/s c_0 (52a)", speed, "speed of weak shocks, that of sound")
      .otherwise("required with eos mie_grueneisen")
      .needed(of_state, "<>eos mie_grueneisen needs it")
      .barred(without, useless);
  of_law
      .number("eos_s", &Law::eos_s, "1 s (52a)", {0, 10, false, false},
              "growth of the speed of shocks with that of the material")
      .barred(without, useless);
  row.number("eos_gamma", &Material::eos_gamma, "1 Gamma (52a)", {0, 20, false, false},
             "Grueneisen's Gamma, with heat: the pressure Gamma c_v (theta - theta0)")
      .otherwise("required with eos mie_grueneisen and heat")
      .needed(heats, "<>eos mie_grueneisen needs it with heat")
      .barred(without, useless)
      .refused(
          [](const Material& m, const Scenario& s) { return heats(m, s) && m.eos_gamma > 2 * m.law.eos_s; },
          [](const Material& m) {
            return "is above twice <>eos_s " + number_text(m.law.eos_s) +
                   ", where the energy has no lower bound; allowed: 0 to 2 s";
          })
      .refused([](const Material& m,
                  const Scenario& s) { return heats(m, s) && std::numbers::e * adiabatic_part(m) > m.law.K; },
               "Gamma^2 c_v theta0 is more than a third of rho c0^2, and the energy not positive; check the "
               "units of <>c_v and <>eos_c0");
}

/// Per volume, or per mass with a unit that says so.
void read_capacity(Material& target, const GivenOption& option, const OptionContext& context) {
  target.c_mass = Material::absent;
  try {
    if (!parse_number(option.text))
      target.c_mass = parse_quantity(option.text, parse_unit("J/(kg.K)").dimension, context.units);
  } catch (const std::invalid_argument&) {
    // per volume then, or a fault that is told so
  }
  if (target.c_mass > 0) return;
  target.c_mass = Material::absent;
  target.c_v = read_number(option, "J/(m^3.K)", positive, {}, context.units);
}

bool does_not_flow(const Material& m, const Scenario& s) {
  return s.has_motion() && m.law.model == Model::elastic;
}

bool conducts_nothing(const Material& m) { return m.law.conductivity == 0; }
bool feels_no_heat(const Material& m, const Scenario& s) {
  return s.solves("heat") && !m.has_capacity() && !is_rigid(m);
}

void add_heat(MaterialRows& rows) {
  const std::string cold = "<>c_v is not given, and no temperature is solved for",
                    insulating = "<>conductivity is 0";
  Rows row(rows, RestartKey::guarded, &Material::law);
  row.number(
         "taylor_quinney", &Law::taylor_quinney, "1 chi", fraction,
         "part of the plastic work without rate that is dissipated; what a rate adds to the stress always is")
      .idle(does_not_flow, "<>model is elastic");
  Rows(rows)
      .number(
          "c_v", &Material::c_v, "J/(m^3.K) c_V (57)", positive,
          "heat capacity at fixed elastic volume, that of free expansion, or with eos at fixed volume; per "
          "reference volume; in J/(kg.K) it is multiplied by rho")
      .otherwise("none: no heat")
      .needed(
          [](const Material& m, const Scenario& s) {
            return s.has_motion() && m.law.model == Model::j2 && !m.has_capacity() &&
                   softening_of(m) == Softening::linear;
          },
          "<>softening linear needs a temperature that is solved for")
      .needed(
          [](const Material& m, const Scenario& s) {
            return s.solves("heat") && !m.has_capacity() &&
                   std::ranges::any_of(s.materials,
                                       [](const Material& other) { return other.has_capacity(); });
          },
          "allowed: a heat capacity > 0; other materials have one, and heat is solved in all of them")
      .read = read_capacity;
  row.number("conductivity", &Law::conductivity, "W/(m.K) kappa (63)", not_negative,
             "thermal conductivity; 0: no heat flows")
      .idle(feels_no_heat, cold);
  row.choice("conduction", &Law::conduction,
             "heat flux isotropic where the body is now, or in the reference body (the paper's)", "spatial",
             Conduction::spatial, "material", Conduction::material)
      .notation("(63)")
      .idle(feels_no_heat, cold)
      .idle(conducts_nothing, insulating);
  row.choice("gtheta", &Law::gtheta, "degradation of the conductivity by damage: g_e1 or 1", "ge",
             ConductionDegradation::ge, "one", ConductionDegradation::one)
      .notation("g_theta (63)")
      .idle(feels_no_heat, cold)
      .idle(conducts_nothing, insulating);
  Rows(rows)
      .number("alpha_t", &Material::alpha_t, "1/K alpha_t (46)", any_number, "thermal expansion")
      .barred(of_state, ": follows from <>eos_gamma; remove it")
      .idle(feels_no_heat, cold);
  row.number("theta0", &Law::theta0, "K theta_0 (46)", positive, "reference temperature")
      .idle(feels_no_heat, cold);
}

/// Data of laws that the material does not have.
template <class When>
void tell_where_idle(MaterialRows& rows, std::size_t first, When when, const std::string& reason) {
  for (std::size_t i = first; i < rows.size(); ++i)
    if (rows[i].name != "damage" && rows[i].name != "b_d") rows[i].idle(when, reason);
}
bool stays_whole(const Material& m, const Scenario& s) {
  return s.solves("damage") && m.law.damage == Damage::none && !is_rigid(m);
}

/// What a rigid material would be told in vain.
void bar_from_rigid(MaterialRows& rows) {
  for (OptionRow<Material>& row : rows)
    for (const char* name : {"E", "nu", "K", "G", "eos", "damage", "b_d", "sigma_y"})
      if (row.name == name)
        row.barred([](const Material& m, const Scenario& s) { return is_rigid(m) && wants_moduli(m, s); },
                   ": has no meaning with <>model rigid; allowed: region, rho; remove it");
}

/// The split that does not break what is pressed, where the rules of the option let it be.
Split automatic_split(const Material& m, const Scenario& scenario) {
  const Law& law = m.law;
  const bool cured = m.locking ? m.locking != Locking::none : keeps_volume(law);
  const bool possible = law.damage != Damage::none && law.model == Model::elastic && !cured && !of_state(m) &&
                        !(scenario.solves("heat") && m.has_capacity()) && 3 * law.K >= 2 * law.G;
  return possible ? Split::spectral : Split::volumetric;
}

/// The law from what the user said.
void resolve(Material& m, const Scenario& scenario) {
  Law& law = m.law;
  if (of_state(m)) {
    law.K = law.rho * m.eos_c0 * m.eos_c0;
    law.G = m.G;
  } else if (given(m.K)) {
    law.K = m.K;
    law.G = m.G;
  } else if (given(m.E)) {
    law.K = m.E / (3 * (1 - 2 * m.nu));
    law.G = m.E / (2 * (1 + m.nu));
  }
  law.c_v = given(m.c_mass) ? m.c_mass * law.rho : m.c_v;
  law.alpha_t = m.alpha_t;
  if (heats(m, scenario)) {
    law.eos_gamma = m.eos_gamma;
    law.alpha_t = m.eos_gamma * law.c_v / (3 * (law.K - adiabatic_part(m))); // at theta_0 and without stress
  }
  law.sigma_y = m.sigma_y;
  if (given(m.linear_h)) law.linear_h = m.linear_h;
  if (scenario.has_motion() && law.model == Model::j2) resolve_hardening(m);
  law.split = m.split == Split::automatic ? automatic_split(m, scenario) : m.split;
  law.locking = m.locking.value_or(automatic_locking(law, scenario.plane));
  resolve_strength(m);
  resolve_fatigue(m);
}

} // namespace

OptionClass<MaterialScenario> material_class() {
  OptionClass<Material> table{
      "material", "materials", "Materials",
      "`-material_<id>_like <other>` takes everything but the region from another material first.",
      &Scenario::materials};
  add_elasticity(table.rows);
  add_state(table.rows);
  const std::size_t flow = table.rows.size();
  add_hardening(table.rows);
  tell_where_idle(table.rows, flow, does_not_flow, "<>model is elastic");
  add_heat(table.rows);
  const std::size_t damage = table.rows.size();
  add_damage(table.rows);
  tell_where_idle(table.rows, damage, stays_whole, "<>damage is none");
  add_erosion(table.rows);
  add_places(table.rows);
  bar_from_rigid(table.rows);
  table.inherits = true;
  table.finish = [](Material& m, OptionContext&) {
    if (m.regions.empty()) m.regions = {m.id};
  };
  table.complete = resolve;
  return table;
}

bool keeps_volume(const MaterialParameters& law) {
  if (law.model == Model::rigid) return false;
  // Cook's membrane on 8 x 8 quadrilaterals is 7.6, 11 and 16 % too stiff at nu 0.3, 0.4 and 0.45 without a
  // cure; with the cell's mean volume it is 3.8 to 3.9 % at any of them.
  constexpr double least_nu = 0.45, rounding = 1e-9;
  const double nu = (3 * law.K - 2 * law.G) / (2 * (3 * law.K + law.G));
  return law.model == Model::j2 || nu >= least_nu - rounding;
}

Locking automatic_locking(const MaterialParameters& law, PlaneMode plane) {
  return plane != PlaneMode::stress && keeps_volume(law) ? Locking::mean : Locking::none;
}

} // namespace impact
