#include "classes.hpp"
#include <cmath>
#include <impact/material/cohesive.hpp>

/// The options of damage, its split, its degradation, and of fatigue.
namespace impact {

namespace {

using Material = MaterialScenario;
using Law = MaterialParameters;
using MaterialRows = std::vector<OptionRow<Material>>;

/// A predicate of the law of materials whose damage is solved for.
template <class When> auto damaging(When when) {
  return [=](const Material& m, const Scenario& s) {
    return s.solves("damage") && m.law.damage != Damage::none && when(m.law);
  };
}

/// A predicate of the law of materials whose damage only the bounds of vi keep in its own.
template <class When> auto unbounded_but_for_vi(When when) {
  return [=](const Material& m, const Scenario& s) {
    return s.damage.bounds != DamageBounds::vi && damaging(when)(m, s);
  };
}

bool tires_beyond_bounds(const Material& m, const Scenario& s) {
  return s.has_motion() && s.damage.bounds != DamageBounds::vi && s.damage.bounds != DamageBounds::clip &&
         damaging([](const Law& law) { return law.fatigue_a > 0; })(m, s);
}

/// Degradations for the local energy of Damage::wu.
bool of_wu(Degradation ge) { return is_cohesive(ge) && ge != Degradation::lorentz; }

bool needs_damage_data(const Material& m, const Scenario& s) {
  return (s.has_motion() || s.solves("damage")) && m.law.damage != Damage::none;
}

void add_crack(MaterialRows& rows) {
  Rows row(rows, RestartKey::guarded, &Material::law);
  row.choice("damage", &Law::damage,
             "crack model: at2 damages from the start, at1 is elastic up to sqrt(3 E G_c/(8 gamma)), wu up "
             "to the "
             "strength, as is at1 with ge lorentz",
             "none", Damage::none, "at2", Damage::at2, "at1", Damage::at1, "wu", Damage::wu)
      .notation("(56)")
      .refused(
          damaging([](const Law& law) { return law.damage == Damage::wu && !of_wu(law.ge); }),
          "wants a degradation that knows the strength; allowed with <>ge linear, exponential or cornelissen")
      .denied(
          unbounded_but_for_vi([](const Law& law) { return law.damage != Damage::at2; }),
          "-damage_bounds: only the bounds of vi keep <>damage {damage} from damage below 0; allowed: vi");
  row.number("Gc", &Law::Gc, "N/m G_c (56)", {0, 1e9, true, false}, "Griffith's fracture energy")
      .otherwise("required with damage")
      .needed(needs_damage_data, "<>damage needs it");
  row.number("gamma", &Law::gamma, "m gamma (56)", {0, 1e3, true, false},
             "width of the phase layer: a crack is exp(-|x|/gamma) with at2, (1 - |x|/2 gamma)^2 with at1, "
             "1 - sin(|x|/gamma) with wu")
      .otherwise("required with damage")
      .needed(needs_damage_data, "<>damage needs it")
      .refused(
          damaging([](const Law& law) {
            return is_cohesive(law.ge) && law.cohesive.a1 < least_cohesive_slope(law);
          }),
          [](const Material& m) {
            const double longest = m.law.gamma * m.law.cohesive.a1 / least_cohesive_slope(m.law);
            return "is too long for <>strength {strength} with <>ge {ge}: what reaches it would break at "
                   "once; allowed: at most " +
                   number_text(longest) + ", better a fifth of that";
          });
  row.number("c", &Law::c, "m^2/(N.s) c (63)", or_word(positive, "inf", unbounded),
             "damage rate; inf: rate-independent");
  const auto has_no_rate = [](const Material& m) { return m.law.c == unbounded; };
  const std::string no_rate = "<>c is inf, damage without a rate";
  row.number("zeta", &Law::zeta, "1 zeta (63)", not_negative, "exponent in the damage rate")
      .idle(has_no_rate, no_rate);
  row.number("delta", &Law::delta, "1 delta (63)", fraction,
             "shift in the damage rate: (1 + delta - phi)^zeta / c")
      .idle(has_no_rate, no_rate);
  row.number("fatigue_a", &Law::fatigue_a, "m^2 a (F1)", not_negative,
             "growth of the fatigue variable with the stress power of damaged material; 0: no fatigue")
      .denied(tires_beyond_bounds, // its energy has a kink there
              "-damage_bounds \"{damage_bounds}\": lets the fatigue of <>fatigue_a drive phi beyond 1; "
              "allowed with fatigue: vi, clip");
  row.number("b_d", &Law::b_d, "N.s/m^2 b_d (62)", not_negative,
             "viscous stress 2 b_d dC/dt, of first order in time");
  row.flag("visc_degrade", &Law::visc_degrade, "damage weakens the viscous stress too")
      .idle([](const Material& m) { return m.law.b_d == 0; }, "<>b_d is 0");
}

/// Why the toughness of a material cannot change, where `when` says that it does, and what to do instead.
template <class When>
void refuse_where_toughness_is_one(OptionRow<Material>& row, When when, const std::string& remedy) {
  const auto law_of = [=](auto what) {
    return [=](const Material& m, const Scenario& s) {
      return s.has_motion() && s.solves("damage") && m.law.damage != Damage::none && when(m) && what(m.law);
    };
  };
  row.refused(law_of([](const Law& law) { return law.fatigue_a > 0; }),
              "goes without <>fatigue_a; remove one of them")
      .refused(
          law_of([](const Law& law) { return law.damage_gradient != DamageGradient::material; }),
          "the stress of the crack energy knows no toughness that changes; allowed with <>damage_gradient "
          "material" +
              remedy)
      .refused(law_of([](const Law& law) { return std::isfinite(law.c); }),
               "not available with a damage rate; allowed: <>c inf" + remedy)
      .refused(
          [=](const Material& m, const Scenario& s) {
            return law_of([](const Law&) { return true; })(m, s) && s.has_heat() &&
                   s.heat.form == HeatForm::energy;
          },
          "not available with -heat_form energy; allowed: entropy" + remedy);
}

/// A file with two columns, of the rate of strain or the temperature and of a factor on Gc.
void read_factors(const GivenOption& option, const OptionContext& context, std::string& path,
                  std::function<double(double)>& factor, const std::string& first) {
  if (option.text == "none") {
    path.clear();
    factor = {};
    return;
  }
  path = find_input_file(context.comm, option);
  const std::string text = read_input_file(context.comm, option, path);
  try {
    const LinearTable table = parse_table(text);
    for (std::size_t i = 0; i < table.value.size(); ++i)
      if (!(table.value[i] > 0) || table.t[i] < 0)
        throw std::invalid_argument("row " + std::to_string(i + 1) + ": a factor must be positive, and a " +
                                    first + " is not negative");
    factor = table;
  } catch (const std::invalid_argument& reason) {
    refuse_option(option, std::string(reason.what()) + "; allowed: a file with two columns of numbers, " +
                              first + " and factor > 0");
  }
}

void add_toughness_by_state(MaterialRows& rows) {
  Rows row(rows);
  const auto with = [&](OptionRow<Material>& of, std::string Material::*path) {
    const auto given = [=](const Material& m) { return !(m.*path).empty(); };
    of.otherwise("none").notation("(T1)");
    of.refused(
        [=](const Material& m, const Scenario& s) { return s.has_motion() && given(m) && m.fatigue.works(); },
        "goes without <>fatigue {fatigue}, which lowers the toughness too; remove one of them");
    refuse_where_toughness_is_one(of, given, ", or without this table");
  };
  auto& by_rate =
      row.file("Gc_rate", &Material::rate_table,
               "file with two columns rate, factor on Gc: the rate (in run units) at which the largest "
               "principal stretch of a cell grows or falls, over itself; straight between the rows, constant "
               "beyond them; it needs damage_gradient material");
  by_rate.read = [](Material& m, const GivenOption& option, const OptionContext& context) {
    read_factors(option, context, m.rate_table, m.toughness.rate, "rate");
  };
  with(by_rate, &Material::rate_table);
  auto& by_temperature =
      row.file("Gc_temperature", &Material::temperature_table,
               "file with two columns temperature (K), factor on Gc; straight between the rows, "
               "constant beyond them; with motion it needs damage_gradient material");
  by_temperature.read = [](Material& m, const GivenOption& option, const OptionContext& context) {
    read_factors(option, context, m.temperature_table, m.toughness.temperature, "temperature");
  };
  with(by_temperature, &Material::temperature_table);
  by_temperature.refused(
      [](const Material& m, const Scenario& s) {
        return !m.temperature_table.empty() && s.has_motion() && !s.has_heat();
      },
      "needs a temperature: a heat capacity (<>c_v); add it, or remove this table");
}

void add_toughness(MaterialRows& rows) {
  Rows row(rows, RestartKey::guarded, &Material::fatigue);
  const auto tiring = [](auto when) {
    return [=](const Material& m, const Scenario& s) {
      return s.has_motion() && s.solves("damage") && m.law.damage != Damage::none && m.fatigue.works() &&
             when(m, s);
    };
  };
  const std::string power = ", or <>fatigue power";
  auto& fatigue =
      row.choice(
             "fatigue", &ToughnessFatigue::law,
             "what fatigue lowers: power, the drive of damage, by the variable of fatigue_a (F1); asymptotic "
             "or logarithmic, the toughness, by that function of the degraded energy in tension, summed up "
             "while it grows (with motion they need damage_gradient material)",
             "power", FatigueLaw::power, "asymptotic", FatigueLaw::asymptotic, "logarithmic",
             FatigueLaw::logarithmic)
          .notation("f (F2)")
          .refused(
              tiring([](const Material& m, const Scenario&) { return m.law.ge == Degradation::ductile; }),
              "sums up elastic energy, and with <>ge ductile plastic strain damages; allowed with another "
              "<>ge" +
                  power);
  refuse_where_toughness_is_one(
      fatigue, [](const Material& m) { return m.fatigue.works(); }, power);
  row.number("fatigue_threshold", &ToughnessFatigue::threshold, "J/m^3 alpha_T (F2)",
             or_word(positive, "auto", 0),
             "of fatigue asymptotic and logarithmic: summed energy up to which the toughness stays; auto: "
             "Gc/(12 gamma)")
      .idle([](const Material& m) { return m.fatigue.law == FatigueLaw::power; },
            "<>fatigue is not asymptotic or logarithmic");
  row.number("fatigue_kappa", &ToughnessFatigue::kappa, "1 kappa (F2)", {0, 1e3, true, false},
             "of fatigue logarithmic: the toughness is gone at 10^(1/kappa) thresholds")
      .otherwise("required with fatigue logarithmic")
      .idle([](const Material& m) { return m.fatigue.law != FatigueLaw::logarithmic; },
            "<>fatigue is not logarithmic")
      .needed(
          tiring([](const Material& m, const Scenario&) { return m.fatigue.law == FatigueLaw::logarithmic; }),
          "<>fatigue logarithmic needs it");
  row.number("fatigue_mean_load", &ToughnessFatigue::mean_load, "J/m^3 alpha_N (F2)",
             or_word(positive, "none", 0),
             "of fatigue asymptotic and logarithmic: the growth of the energy counts times the energy over "
             "this, so that cycles about a higher mean load count more");
}

/// A predicate of materials with a split that asks for principal stretches.
template <class When> auto principal(When when) {
  return damaging([=](const Law& law) { return by_principal(law.split) && when(law); });
}

void add_split(MaterialRows& rows) {
  const auto star_convex = [](const Law& law) { return law.split == Split::star_convex; };
  Rows(rows)
      .choice(
          "split", &Material::split,
          "which energy drives damage, and is lost with it: spectral, that of principal stretches above "
          "1 and of dilation; no_tension, all that cracks can let go, so that they bear pressure alone; "
          "drucker_prager, what a cone of stresses without cohesion does not bear, so that strength grows "
          "with pressure; volumetric, all but volumetric compression; star_convex, the same less gamma* "
          "times that "
          "compression; none, all (the paper's run). The last three let shear drive it in compression "
          "too. auto: spectral in elastic bodies with 0 <= nu < 0.45 without heat or a cure of "
          "locking, else volumetric",
          "auto", Split::automatic, "volumetric", Split::volumetric, "none", Split::none, "spectral",
          Split::spectral, "star_convex", Split::star_convex, "no_tension", Split::no_tension,
          "drucker_prager", Split::drucker_prager)
      .notation("g_e2 (49)")
      .refused(principal([](const Law& law) { return law.equation_of_state != EquationOfState::none; }),
               "not available with <>eos, whose energy is no sum over principal stretches; allowed: <>eos "
               "none; choose volumetric or star_convex")
      .refused(
          principal([](const Law& law) { return law.split != Split::spectral && law.model == Model::j2; }),
          "not available with <>model j2: cracks that open as they like and flow are two inelastic strains, "
          "and nothing says how they share a deformation; allowed: <>model elastic; choose spectral, "
          "volumetric or star_convex")
      .refused(principal([](const Law& law) {
                 return law.split != Split::drucker_prager && 3 * law.K < 2 * law.G;
               }),
               "with nu < 0 its tensile part can be negative; allowed: nu >= 0; choose volumetric")
      .denied(unbounded_but_for_vi(star_convex),
              "-damage_bounds: only the bounds of vi keep <>split star_convex from damage below 0, because "
              "compression drives it backwards; allowed: vi");
  Rows(rows, RestartKey::guarded, &Material::law)
      .number("star_gamma", &Law::star_gamma, "1 gamma* (50''')", {0, 1e3, true, false},
              "of split star_convex: compression of volume counts this many times against the energy that "
              "drives damage; 0 would be volumetric")
      .otherwise("required with split star_convex")
      .needed([](const Material& m,
                 const Scenario& s) { return needs_damage_data(m, s) && m.split == Split::star_convex; },
              "<>split star_convex needs it")
      .idle([](const Material& m) { return m.split != Split::star_convex; }, "<>split is not star_convex");
}

/// Of <>split drucker_prager.
void add_strength_ratio(Rows<Material>& row) {
  const auto cone = [](const Law& law) { return law.split == Split::drucker_prager; };
  row.number("strength_ratio", &Material::strength_ratio, "1 r (50'''')", {1, 3, true, false},
             "of split drucker_prager: strength in uniaxial compression over that in tension; with more than "
             "3 an open "
             "crack would still bear")
      .otherwise("required with split drucker_prager")
      .needed([](const Material& m,
                 const Scenario& s) { return needs_damage_data(m, s) && m.split == Split::drucker_prager; },
              "<>split drucker_prager needs it")
      .idle([](const Material& m) { return m.split != Split::drucker_prager; },
            "<>split is not drucker_prager")
      .refused([=](const Material& m) { return cone(m.law) && !(m.law.cone > 0); },
               [](const Material& m) {
                 return "is not above that of a body whose volume alone is kept under pressure, " +
                        number_text(std::ceil(1e4 * least_strength_ratio(m.law)) / 1e4) +
                        " with its nu; allowed: more than that; remedy: <>split volumetric";
               });
}

void add_strength(MaterialRows& rows) {
  Rows row(rows);
  add_strength_ratio(row);
  row.number("strength", &Material::strength, "Pa f_t (56'')", {0, 1e12, true, false},
             "stress in uniaxial tension at which damage begins")
      .otherwise("required with ge linear, exponential, cornelissen or lorentz")
      .needed([](const Material& m,
                 const Scenario& s) { return needs_damage_data(m, s) && is_cohesive(m.law.ge); },
              "<>ge {ge} needs it")
      .refused(damaging([](const Law& law) { return !is_cohesive(law.ge); }),
               "has no effect with <>ge {ge}: E, Gc and gamma tell the strength; remove it, or add <>damage "
               "wu and "
               "<>ge linear, exponential or cornelissen, or <>damage at1 and <>ge lorentz");
  row.number("lorentz_p", &Material::lorentz_p, "1 p (56'')", {0.5, 100, false, false},
             "of ge lorentz: the larger, the steeper the stress falls at first and the longer its tail")
      .idle([](const Material& m) { return m.law.ge != Degradation::lorentz; }, "<>ge is not lorentz");
}

void add_degradation(MaterialRows& rows) {
  Rows row(rows, RestartKey::guarded, &Material::law);
  row.choice("ge", &Law::ge,
             "degradation of the elastic energy; ductile: (1 - phi)^(2 alpha/alpha_c), with the alpha of the "
             "step's start, so that steps want to be short where flow localises (-ts_adapt_dalpha); linear, "
             "exponential, cornelissen, with damage wu, and lorentz, with damage at1: elastic up to the "
             "strength, then the stress falls with the opening of the crack by that law",
             "quadratic", Degradation::quadratic, "cubic", Degradation::cubic, "ductile",
             Degradation::ductile, "linear", Degradation::linear, "exponential", Degradation::exponential,
             "cornelissen", Degradation::cornelissen, "lorentz", Degradation::lorentz)
      .notation("g_e1 (49), (56'')")
      .refused(damaging([](const Law& law) { return of_wu(law.ge) && law.damage != Damage::wu; }),
               "goes with another crack model; allowed: <>damage wu")
      .refused(damaging([](const Law& law) {
                 return law.ge == Degradation::lorentz && law.damage != Damage::at1;
               }),
               "goes with another crack model; allowed: <>damage at1")
      .refused(
          damaging([](const Law& law) { return law.ge == Degradation::ductile && law.model != Model::j2; }),
          "nothing damages without plastic strain; allowed with <>model j2; choose quadratic or cubic");
  add_strength(rows);
  row.number("cubic_s", &Law::cubic_s, "1 s", {0, 2, true, false},
             "slope of the cubic degradation at phi = 0")
      .otherwise("1e-4")
      .idle([](const Material& m) { return m.law.ge != Degradation::cubic; }, "<>ge is not cubic");
  row.number("alpha_c", &Law::alpha_c, "1 alpha_c", {0, 1e3, true, false},
             "plastic strain at which the ductile degradation is quadratic")
      .otherwise("required with ge ductile")
      .idle([](const Material& m) { return m.law.ge != Degradation::ductile; }, "<>ge is not ductile")
      .needed([](const Material& m,
                 const Scenario& s) { return needs_damage_data(m, s) && m.law.ge == Degradation::ductile; },
              "<>ge ductile needs it");
  row.choice("gp", &Law::gp, "degradation of the plastic energy: 1 or g_e1", "one", PlasticDegradation::one,
             "ge", PlasticDegradation::ge)
      .notation("g_p (54)")
      .idle([](const Material& m) { return m.law.model != Model::j2; }, "<>model is not j2");
  row.number("plastic_threshold", &Law::plastic_threshold, "J/m^3 W_0", not_negative,
             "plastic energy H_0 that does not drive damage, with gp ge: the drive is <H_0 - W_0>")
      .denied(unbounded_but_for_vi([](const Law& law) { return law.ge == Degradation::ductile; }),
              "-damage_bounds: only the bounds of vi keep <>ge ductile from damage above 1; allowed: vi")
      .refused(damaging([](const Law& law) { return law.softening != Softening::none; }),
               "not available with <>softening, whose plastic energy is a sum over the steps; allowed: 0, or "
               "softening none")
      .idle([](const Material& m) { return m.law.gp != PlasticDegradation::ge; }, "<>gp is not ge");
  row.choice("damage_gradient", &Law::damage_gradient, "gradient of phi in the crack energy", "spatial",
             DamageGradient::spatial, "material", DamageGradient::material)
      .notation("(56)");
  row.number("residual_stiffness", &Law::residual_stiffness, "1 k", {0, 1, false, true},
             "part of the stiffness that stays in a crack")
      .otherwise("1e-6");
}

} // namespace

void resolve_fatigue(MaterialScenario& m) {
  if (m.law.damage == Damage::none) return;
  m.fatigue.width = m.law.gamma;
  if (m.fatigue.threshold == 0) m.fatigue.threshold = m.law.Gc / (12 * m.law.gamma);
}

void resolve_strength(MaterialScenario& m) {
  if (m.law.split == Split::drucker_prager) m.law.cone = cone_of(m.law, m.strength_ratio);
  if (!is_cohesive(m.law.ge)) return;
  m.law.cohesive = cohesive_shape(m.law, m.lorentz_p);
  m.law.cohesive.a1 = cohesive_slope(m.law, m.strength);
}

void add_damage(std::vector<OptionRow<MaterialScenario>>& rows) {
  add_crack(rows);
  add_toughness(rows);
  add_toughness_by_state(rows);
  add_split(rows);
  add_degradation(rows);
}

} // namespace impact
