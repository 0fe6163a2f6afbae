#include <algorithm>
#include <impact/petsc/field_solver.hpp>
#include <impact/solve/augmentation.hpp>
#include <impact/time/types.hpp>

namespace impact {

Augmentation::Augmentation(TS ts, MotionProblem& motion, MotionSolver& solver)
    : motion_(motion), solver_(solver), shell_{[this](PetscInt number, Vec u) { return pass(number, u); },
                                               &time_mailbox(ts), false},
      contact_force_(motion.discretisation().displacement.make_global()),
      left_(motion.discretisation().displacement.make_global()) {
  check(SNESCreate(motion_.discretisation().mesh.comm(), snes_.out()));
  check(SNESSetOptionsPrefix(snes_, "uzawa_"));
  make_pass_shell(snes_, shell_);
  // The tolerances of gap and pressure belong to each contact: a pass changes 1 until all of them are met.
  check(SNESSetTolerances(snes_, 0.5, 0, 0, 30, PETSC_DEFAULT));
  check(SNESSetFromOptions(snes_));
}

void Augmentation::begin_attempt() {
  passes_ = 0;
  failure_.clear();
}

SNESConvergedReason Augmentation::solve(Vec u, Aim aim) {
  aim_ = aim;
  check(SNESSolve(snes_, nullptr, u));
  const SNESConvergedReason reason = Get(SNESGetConvergedReason)(snes_);
  if (reason < 0 && failure_.empty()) failure_ = std::string("uzawa: ") + SNESConvergedReasons[reason];
  return reason;
}

void Augmentation::meet(Vec u) {
  motion_.contacts().meet(!solver_.loose().empty(), first_touch_);
  motion_.contacts().start_newton(u);
}

PassResult Augmentation::pass(PetscInt number, Vec u) {
  PassResult result;
  result.inner = solve_pass(number, u);
  passes_ += 1;
  if (result.inner < 0) {
    explain(result.inner);
    return result;
  }
  check(VecCopy(solver_.left(), left_));
  // Of the present multipliers and of the places that the solve knew: both may change below.
  check(VecSet(contact_force_, 0));
  ContactSet& contacts = motion_.contacts();
  contacts.add_forces(u, -1, contact_force_);
  // A body that moved beyond the skin may touch facets that the list did not hold.
  const bool kept = !solver_.refresh_contact(u);
  if (number == 1)
    for (ContactInterface& contact : contacts) contact.start_augmentation();
  const AugmentReport review = contacts.review(u);
  const bool converged = review.converged && kept && !rough_;
  result.change = converged ? 0 : 1;
  if (converged) return result;
  // Multipliers change only where another solve follows, and not by penalties of places that it did not know.
  if (first_touch_) {
    first_touch_ = !kept || !review.settled;
    if (first_touch_) return result;
  }
  for (ContactInterface& contact : contacts) contact.augment(u);
  contacts.meet(!solver_.loose().empty(), false);
  rough_ = contacts.demands().augments;
  return result;
}

// The motion at the multipliers of this pass.
SNESConvergedReason Augmentation::solve_pass(PetscInt number, Vec u) {
  LooseBodies& loose = solver_.loose();
  solver_.refresh_contact(u);
  solver_.approach(u);
  // What presses nothing yet is brought to rest on penalties, roughly: their forces grow with the way, and
  // the semismooth method, whose gaps close at once, begins from the pressures that they find.
  const ContactDemands demands = motion_.contacts().demands();
  if (number == 1)
    first_touch_ = (demands.closes_gaps || demands.augments) && !loose.empty() && !loose.rest(u);
  meet(u);
  // Before the last augmentation a residual that falls to a tenth is exact enough, once all points have found
  // out whether they touch: multipliers that are no use lead Newton's method astray. A first touch overshoots
  // to a thousand times the load and comes down from there.
  Aim aim = aim_;
  if (first_touch_)
    aim = Aim::thousandth;
  else if (number > 1 && rough_)
    aim = Aim::tenth;
  else if (number == 1 && demands.augments && aim == Aim::balance)
    aim = Aim::settled;
  rough_ = aim != aim_;
  constexpr PetscInt enough = 15; // for a first touch, or it has the wrong way
  constexpr double softer = 0.1;
  const PetscInt most = solver_.most_iterations();
  SNESConvergedReason reason =
      solver_.solve(u, aim, first_touch_ ? std::min(most, enough) : most, !first_touch_);
  for (PetscInt look = 0; first_touch_ && reason == SNES_DIVERGED_MAX_IT && loose.must_look() && look < most;
       ++look) {
    solver_.refresh_contact(u);
    meet(u);
    reason = solver_.solve(u, aim, std::min(most, enough), false);
  }
  // Springs as stiff as facets throw the more nodes off the more of them lift: softer ones follow the body.
  for (const double factor : {softer, softer, 1 / (softer * softer)}) {
    if (!first_touch_ || reason >= 0) break;
    const bool last = factor > 1;
    if (last) first_touch_ = rough_ = false;
    motion_.contacts().scale_penalties(factor);
    loose.start_attempt();
    solver_.restart(u);
    meet(u);
    reason = solver_.solve(u, last ? aim_ : aim, last ? most : std::min(most, enough), last);
  }
  if (rough_ && reason >= 0 && !first_touch_ && motion_.contacts().review(u).converged) {
    rough_ = false;
    reason = solver_.solve(u, aim_, most);
  }
  return reason;
}

void Augmentation::explain(SNESConvergedReason reason) {
  failure_ = std::string("motion: ") + SNESConvergedReasons[reason];
  if (reason == SNES_DIVERGED_LOCAL_MIN) failure_ += " (Newton's method does not come to rest)";
  if (reason != SNES_DIVERGED_LINEAR_SOLVE && reason != SNES_DIVERGED_FUNCTION_DOMAIN)
    if (const std::string place = place_of_largest(motion_.discretisation(), solver_.left()); !place.empty())
      failure_ += ", the largest force left at " + place;
  const ArcLength* const arc = solver_.arc_length();
  if (const std::string trouble = arc ? arc->trouble() : ""; !trouble.empty())
    failure_ += " (" + trouble + ")";
  if (const std::string adrift = solver_.loose().adrift(); !adrift.empty()) failure_ += " (" + adrift + ")";
}

} // namespace impact
