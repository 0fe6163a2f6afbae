#include <algorithm>
#include <impact/petsc/error.hpp>
#include <impact/solve/coupling.hpp>
#include <utility>

/// Where the motion of a step begins.
namespace impact {

namespace {

// Of the step before: loads go on for as long as that, and may end after it.
constexpr double farthest = 2;

} // namespace

// The last increment, scaled: prescribed nodes do not jump ahead of their neighbours, and unlike dt v_n it
// does not follow the alternation of v that an undamped integrator keeps at frequencies far above 1/dt. A
// step that is far longer than the one before takes it only where it leaves less force than standing still:
// under a load that is held it would lead past the next equilibrium, or turn cells inside out. Nor does a
// body that nothing holds any more go on for ever.
void Coupling::guess(const Attempt& attempt, Vec u) {
  const FieldLayout& layout = fields_.motion.discretisation().displacement;
  const std::vector<double>& start = fields_.state.row("u").committed;
  const std::vector<double>& rate = fields_.state.row("mean_rate").committed;
  const double before = std::exchange(last_step_.trial[0], attempt.dt);
  std::vector<double> ahead = start;
  for (std::size_t i = 0; i < ahead.size(); ++i) ahead[i] += attempt.dt * rate[i];
  layout.to_global(ahead, u);
  if (!settings_.moves || path_ || solver_.arc_length() || before == 0) return;
  const bool adrift = is_adrift(attempt.t_n);
  if (attempt.dt <= farthest * before && !adrift) return;
  const Handle<Vec> still = layout.make_global();
  layout.to_global(start, still);
  const PetscReal after = solver_.left_at(u), now = solver_.left_at(still);
  if (!(after < now) || (adrift && now <= 2 * after + solver_.atol())) check(VecCopy(still, u));
}

// Whether bodies that contact alone holds are held by none.
bool Coupling::is_adrift(double t) {
  ContactSet& contacts = fields_.motion.contacts();
  if (solver_.loose().empty()) return false;
  const bool borne = std::any_of(contacts.begin(), contacts.end(),
                                 [](const ContactInterface& contact) { return contact.bears(); });
  if (borne) {
    let_go_ = false;
  } else if (t > 0 && !std::exchange(let_go_, true)) {
    check(PetscPrintf(fields_.motion.discretisation().mesh.comm(),
                      "impact: at t = %.7g nothing holds the bodies that contact alone holds: they stay "
                      "where they are\n",
                      t));
  }
  return !borne;
}

} // namespace impact
