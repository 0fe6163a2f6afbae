#include "classes.hpp"

/// The options of erosion: which cells leave their bodies, and when.
namespace impact {

namespace {

using Material = MaterialScenario;
using Rule = ErosionRule;

bool damages_here(const Material& m, const Scenario& s) {
  return s.solves("damage") && m.law.damage != Damage::none;
}

/// A contact that cannot do without the constraints that it had, "" = none. By Newton's method pressures are
/// kept for each constraint, but for penalties without exact work.
std::string hindering_contact(const Scenario& s) {
  for (const ContactScenario& c : s.contacts) {
    const std::string of = "-contact_" + c.id;
    const bool points = c.method == ContactMethod::gauss_points ||
                        (c.method == ContactMethod::automatic && s.explicit_steps());
    if (!points)
      return of + "_method: mean gaps (mortar) follow no surface that changes; take gpts" +
             (s.explicit_steps() ? "" : ", and " + of + "_enforce penalty");
    if (c.enforce == Enforcement::impulse)
      return of + "_enforce: impulses are kept for facets, which go and come; take penalty";
    if (s.explicit_steps()) continue;
    if (c.enforce != Enforcement::penalty)
      return of + "_enforce: multipliers belong to facets, which go and come; take penalty";
    if (c.impact == ImpactUpdate::conserving)
      return of + "_impact: gaps are kept for facets, which go and come; take auto, stabilised or none";
  }
  return "";
}

constexpr auto eroding(auto when) {
  return [=](const Material& m, const Scenario& s) { return m.erosion.on && when(m, s); };
}
bool off(const Material& m) { return !m.erosion.on; }

void add_criteria(std::vector<OptionRow<MaterialScenario>>& rows) {
  Rows row(rows, RestartKey::guarded, &Material::erosion);
  row.number(
         "erosion_points", &Rule::points, "1", {0, 1, true, false},
         "part of the points of a cell that must have reached erosion_phi, _strain or _failure; 1: all of "
         "them, less than one over their number: any")
      .idle(off, "<>erosion is off");
  row.number("erosion_phi", &Rule::phi, "1 phi", {0, 1, true, false},
             "with damage: a cell is broken where phi is this at its points; broken cells leave, where "
             "erosion_J, _stretch or _step is given when one of these is met, too")
      .barred(eroding([](const Material& m, const Scenario& s) {
                return m.erosion.phi != Rule{}.phi && !damages_here(m, s);
              }),
              ": nothing damages here; remove it")
      .idle(off, "<>erosion is off");
  row.number("erosion_strain", &Rule::strain, "1 alpha", or_word(positive, "none", Rule::none),
             "a cell leaves at this plastic strain at its points")
      .refused(eroding([](const Material& m, const Scenario&) {
                 return m.erosion.strain < Rule::none && m.law.model != Model::j2;
               }),
               "nothing flows; allowed with <>model j2")
      .idle(off, "<>erosion is off");
  row.flag("erosion_failure", &Rule::failure, "a cell leaves when jc_failure is 1 at its points")
      .notation("(55d)")
      .refused(eroding([](const Material& m, const Scenario&) {
                 return m.erosion.failure && !(m.law.jc_failure && m.law.model == Model::j2);
               }),
               "needs <>jc_failure and <>model j2")
      .idle(off, "<>erosion is off");
  row.choice(
         "erosion_mass", &Rule::keeps_mass,
         "the mass of a cell that leaves stays with its nodes, which fly on, or goes with it, and with it "
         "momentum and kinetic energy; nodes without any mass stand still; heat and crack energy stay",
         "keep", true, "remove", false)
      .refused(eroding([](const Material& m, const Scenario& s) {
                 return !m.erosion.keeps_mass && !s.explicit_steps();
               }),
               "leaves nodes that no equation moves; take keep, or -ts_type central_difference")
      .idle(off, "<>erosion is off");
  row.number("erosion_J", &Rule::J, "1 J", {0, 1, false, true},
             "a cell (with damage: a broken one, erosion_phi) leaves when its volume at any point is at most "
             "this part of the first one")
      .idle(off, "<>erosion is off");
  row.number(
         "erosion_stretch", &Rule::stretch, "1", or_word({1, 1e3, true, false}, "none", Rule::none),
         "a cell (with damage: a broken one) leaves when the largest principal stretch at any of its points "
         "is this")
      .idle(off, "<>erosion is off");
  row.number(
         "erosion_step", &Rule::step, "1", {0, 1, false, true},
         "a cell (with damage: a broken one) leaves when its stable step is below this part of that of the "
         "undeformed cell")
      .idle(off, "<>erosion is off");
}

} // namespace

void add_erosion(std::vector<OptionRow<MaterialScenario>>& rows) {
  Rows row(rows, RestartKey::guarded, &Material::erosion);
  row.flag(
         "erosion", &Rule::on,
         "cells that fail by any of the criteria below leave their bodies, as do those that lose their "
         "volume (with damage: that are broken then): they bear no force, their faces inside come free "
         "for contact (-contact_<id>_method gpts, -contact_<id>_enforce penalty), mass (erosion_mass), heat "
         "and crack energy stay with their nodes, what else they stored is dissipated_erosion")
      .notation("(7)")
      .refused(
          eroding([](const Material&, const Scenario& s) { return s.has_motion() && !s.has_inertia(); }),
          "nothing holds the nodes of a static run whose cells have left; allowed: with -ts_type newmark or "
          "central_difference")
      .refused(eroding([](const Material& m, const Scenario&) { return m.law.model == Model::rigid; }),
               "has no meaning with <>model rigid; remove it")
      .denied(eroding([](const Material&, const Scenario& s) { return !hindering_contact(s).empty(); }),
              [](const Material&, const Scenario& s) { return hindering_contact(s) + ", or no <>erosion"; });
  add_criteria(rows);
}

} // namespace impact
