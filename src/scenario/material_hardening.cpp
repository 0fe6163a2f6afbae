#include "classes.hpp"
#include <algorithm>
#include <cmath>
#include <impact/material/hardening.hpp>

/// The options of plastic flow: hardening, its rate and its softening by heat.
namespace impact {

namespace {

using Material = MaterialScenario;
using Law = MaterialParameters;
using MaterialRows = std::vector<OptionRow<Material>>;

bool has_part(const Material& m, const std::string& part) {
  return std::ranges::find(m.hardening, part) != m.hardening.end();
}

/// The hardening that brings its own yield stress, and stands alone; "" = none.
std::string own_yield(const Material& m) {
  for (const char* part : {"table", "johnson_cook"})
    if (has_part(m, part)) return part;
  return "";
}

/// A predicate of materials that flow plastically.
template <class When> auto flowing(When when) {
  return [=](const Material& m, const Scenario& s) {
    return s.has_motion() && m.law.model == Model::j2 && when(m);
  };
}
auto with_part(const std::string& part) {
  return flowing([=](const Material& m) {
    const std::string own = own_yield(m);
    return has_part(m, part) && (own.empty() || own == part);
  });
}
auto with_softening(Softening kind) {
  return flowing([=](const Material& m) { return softening_of(m) == kind; });
}

/// A file with two columns, read and made into the law's table at once.
void read_table(Material& target, const GivenOption& option, const OptionContext& context) {
  target.hardening_table = find_input_file(context.comm, option);
  const std::string text = read_input_file(context.comm, option, target.hardening_table);
  try {
    const LinearTable table = parse_table(text);
    std::vector<std::pair<double, double>> points;
    for (std::size_t i = 0; i < table.t.size(); ++i) points.emplace_back(table.t[i], table.value[i]);
    target.points = std::make_shared<const HardeningTable>(points);
    target.law.table = target.points.get();
  } catch (const std::invalid_argument& reason) {
    refuse_option(option, std::string(reason.what()) +
                              "; allowed: a file with two columns of numbers, alpha from 0 and k > 0");
  }
}

void add_curves(MaterialRows& rows) {
  const Interval stress{0, 1e15, true, false};
  Rows row(rows);
  Rows of_law(rows, RestartKey::guarded, &Material::law);
  row.number("sigma_y", &Material::sigma_y, "Pa sigma_y (55)", stress, "yield stress")
      .otherwise("required with j2, but for hardening table or johnson_cook")
      .needed(flowing([](const Material& m) { return own_yield(m).empty(); }),
              "<>model j2 needs a yield stress")
      .barred(flowing([](const Material& m) { return !own_yield(m).empty(); }), [](const Material& m) {
        return ": has no meaning with <>hardening " + own_yield(m) +
               ", which tells the yield stress itself; remove it";
      });
  row.list("hardening", &Material::hardening,
           "parts of k_0 = sigma_y + r (1 - exp(-s alpha)) + H alpha that must be given, they add; or, "
           "alone, johnson_cook or table. What is given of linear and voce adds though it is not named: with "
           "linear_h 0 and voce_r 0 it does not",
           {"none", "voce", "linear", "johnson_cook", "table"})
      .notation("k_0 (55')")
      .barred(flowing([](const Material& m) { return !own_yield(m).empty() && m.hardening.size() > 1; }),
              [](const Material& m) {
                const std::string own = own_yield(m), other = m.hardening[m.hardening[0] == own ? 1 : 0];
                return " " + own + "," + other + ": " + own + " stands alone; remove " + other;
              });
  of_law.number("voce_r", &Law::voce_r, "Pa r_p (55)", not_negative, "saturation of the hardening")
      .needed(with_part("voce"), "a positive value is needed by <>hardening voce");
  of_law.number("voce_s", &Law::voce_s, "1 s_p (55)", not_negative, "rate of the saturation")
      .needed(with_part("voce"), "a positive value is needed by <>hardening voce")
      .needed(flowing([](const Material& m) { return m.law.voce_r > 0; }),
              "a positive value is needed by <>voce_r");
  row.number("linear_h", &Material::linear_h, "Pa H", not_negative, "linear hardening modulus")
      .otherwise("0")
      .needed(with_part("linear"), "a value is needed by <>hardening linear");
  row.file("hardening_table", &Material::hardening_table,
           "file with two columns alpha, k (stress in run units) of hardening table: straight between the "
           "rows, constant after the last")
      .notation("k_0 (55a)")
      .otherwise("required with hardening table")
      .needed(with_part("table"), "needed by <>hardening table")
      .read = read_table;
  row.number("jc_a", &Material::jc_a, "Pa A (55a)", stress,
             "Johnson-Cook: k = (A + B alpha^n) (1 + C ln(rate/rate0)) (1 - T*^m)")
      .otherwise("required with hardening johnson_cook")
      .needed(with_part("johnson_cook"), "needed by <>hardening johnson_cook");
  of_law.number("jc_b", &Law::power_b, "Pa B (55a)", stress, "its B")
      .otherwise("required with hardening johnson_cook")
      .needed(with_part("johnson_cook"), "needed by <>hardening johnson_cook");
  of_law.number("jc_n", &Law::power_n, "1 n (55a)", {0, 1, true, false}, "its exponent of alpha");
}

void add_rate_and_softening(MaterialRows& rows) {
  Rows row(rows);
  Rows of_law(rows, RestartKey::guarded, &Material::law);
  of_law.number("jc_c", &Law::rate_c, "1 C (55a)", not_negative,
                "rate factor 1 + C ln(rate/rate0) above the rate rate0, with any hardening");
  of_law
      .choice("jc_rate_form", &Law::rate_form,
              "factors of the rate: 1 + C ln(rate/rate0) above rate0, or (1 + rate/rate0)^C; so for jc_d4",
              "log", RateForm::logarithm, "power", RateForm::power)
      .notation("R (55a)")
      .refused(
          [](const Material& m) {
            return m.law.rate_form == RateForm::power && m.law.rate_c == 0 && m.law.jc_d4 == 0;
          },
          "nothing hangs on the rate; needs <>jc_c or <>jc_d4");
  row.number("jc_rate0", &Material::rate_0, "1/s rate0 (55a)", positive,
             "rate of alpha from which jc_c counts")
      .otherwise("required with jc_c")
      .idle([](const Material& m) { return m.law.rate_c == 0 && m.law.jc_d4 == 0; },
            "neither <>jc_c nor <>jc_d4 is given")
      .needed(flowing([](const Material& m) { return m.law.rate_c > 0; }), "a rate is needed by <>jc_c")
      .needed(flowing([](const Material& m) { return m.law.jc_d4 != 0; }), "a rate is needed by <>jc_d4");
  row.choice("softening", &Material::softening,
             "factor of the temperature on k; linear: 1 - w (theta - theta0); johnson_cook: 1 - T*^m; auto: "
             "johnson_cook with the hardening of that name where jc_theta_melt is given, else none",
             "auto", std::nullopt, "none", Softening::none, "linear", Softening::linear, "johnson_cook",
             Softening::johnson_cook)
      .notation("f (55a)");
  of_law
      .number("softening_w", &Law::softening_w, "1/K w (55a)", or_word(not_negative, "", 0),
              "slope of the linear softening")
      .otherwise("required with softening linear")
      .needed(with_softening(Softening::linear), "a positive value is needed by <>softening linear");
  of_law.number("jc_m", &Law::softening_m, "1 m (55a)", positive, "exponent of T*")
      .idle([](const Material& m) { return m.law.softening != Softening::johnson_cook; },
            "<>softening is not johnson_cook");
  of_law
      .number(
          "jc_theta_melt", &Law::theta_melt, "K theta_melt (55a)", positive,
          "temperature of melting, where T* = (theta - theta_ref)/(theta_melt - theta_ref) is 1 and k zero")
      .otherwise("required with softening johnson_cook")
      .needed(with_softening(Softening::johnson_cook), "needed by <>softening johnson_cook")
      .needed(flowing([](const Material& m) { return m.law.jc_d5 != 0; }), "needed by <>jc_d5")
      .barred(flowing([](const Material& m) {
                return (m.law.softening == Softening::johnson_cook || m.law.jc_d5 != 0) &&
                       m.law.theta_melt <= m.law.theta_ref;
              }),
              [](const Material& m) {
                return ": not above <>jc_theta_ref " + number_text(m.law.theta_ref) +
                       "; give the temperature of melting";
              });
  row.number("jc_theta_ref", &Material::theta_ref, "K theta_ref (55a)", positive,
             "temperature up to which T* is 0")
      .otherwise("theta0")
      .idle([](const Material& m) { return m.law.softening != Softening::johnson_cook && m.law.jc_d5 == 0; },
            "neither <>softening is johnson_cook nor <>jc_d5 given");
}

void add_failure(MaterialRows& rows) {
  Rows of_law(rows, RestartKey::guarded, &Material::law);
  of_law
      .flag("jc_failure", &Law::jc_failure,
            "the failure measure D of Johnson and Cook is followed where the material flows, column "
            "jc_failure_max and field jc_failure: dD = dalpha/eps_f, eps_f = (D1 + D2 exp(D3 sigma*)) "
            "(1 + D4 ln(rate/rate0)) (1 + D5 T*), sigma* the mean stress over that of von Mises, tension "
            "positive; nothing but jc_softening and erosion_failure depends on it")
      .notation("D (55d)");
  of_law
      .number(
          "jc_softening", &Law::failure_softening, "1 D_c (55e)", {0, 1, true, false},
          "factor 1 - D_c D on k, D the failure measure at the start of the step, up to 1: what is left of "
          "the strength when a point has failed is 1 - D_c; local, so that the flow gathers in a band of "
          "one cell")
      .otherwise("0")
      .refused(
          [](const Material& m) {
            return m.law.failure_softening > 0 && !(m.law.jc_failure && m.law.model == Model::j2);
          },
          "needs <>jc_failure and <>model j2");
  const auto unfollowed = [](const Material& m) { return !m.law.jc_failure; };
  const std::string off = "<>jc_failure is off";
  of_law.number("jc_d1", &Law::jc_d1, "1 D1 (55d)", any_number, "its D1")
      .idle(unfollowed, off)
      .needed([](const Material& m) { return m.law.jc_failure && m.law.jc_d1 == 0 && m.law.jc_d2 == 0; },
              "<>jc_failure needs it, or <>jc_d2");
  of_law.number("jc_d2", &Law::jc_d2, "1 D2 (55d)", {0, 1e6, false, false}, "its D2").idle(unfollowed, off);
  of_law.number("jc_d3", &Law::jc_d3, "1 D3 (55d)", any_number, "its D3, negative in most metals")
      .idle(unfollowed, off);
  of_law.number("jc_d4", &Law::jc_d4, "1 D4 (55d)", any_number, "its D4, above the rate jc_rate0")
      .idle(unfollowed, off);
  of_law.number("jc_d5", &Law::jc_d5, "1 D5 (55d)", any_number, "its D5, with jc_theta_ref and jc_theta_melt")
      .idle(unfollowed, off);
}

} // namespace

Softening softening_of(const MaterialScenario& m) {
  const bool by_name = has_part(m, "johnson_cook") && m.law.theta_melt > 0;
  return m.softening.value_or(by_name ? Softening::johnson_cook : Softening::none);
}

void add_hardening(std::vector<OptionRow<MaterialScenario>>& rows) {
  add_curves(rows);
  add_rate_and_softening(rows);
  add_failure(rows);
}

void resolve_hardening(MaterialScenario& m) {
  Law& law = m.law;
  if (law.rate_c > 0 || law.jc_d4 != 0) law.rate_0 = m.rate_0;
  if (const std::string own = own_yield(m); own == "table") {
    law.hardening = HardeningKind::table;
    law.sigma_y = law.table->at(0).k;
  } else if (!own.empty()) {
    law.hardening = HardeningKind::power;
    law.sigma_y = m.jc_a;
  }
  law.softening = softening_of(m);
  law.theta_ref = std::isnan(m.theta_ref) ? law.theta0 : m.theta_ref;
}

} // namespace impact
