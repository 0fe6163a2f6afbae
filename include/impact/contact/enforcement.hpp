#pragma once
#include <cmath>
#include <impact/contact/constraint.hpp>
#include <impact/contact/settings.hpp>
#include <impact/mesh/state_table.hpp>
#include <memory>
#include <petscvec.h>
#include <vector>

/// How gaps become pressures, and what makes the pressures right within and between the solves of the motion
/// (theory.md, contact). One file per method in src/contact/enforcement. The potential of a constraint and
/// its pressure are
///   psi(g, lambda) = (p^2 - lambda^2) / (2 eps),  p = -dpsi/dg = <lambda - eps g>   (75')
/// An enforcement of one's own derives from EnforcementMethod and is handed to the contact as
/// ContactSettings::own_enforcement: nothing else asks which method is on.
namespace impact {

class Constraints;
class Friction;

/// The rows of one contact in the state table that belong to its enforcement; evaluations read the trial
/// half.
struct EnforcementRows {
  StateRow* multiplier; ///< [constraint] lambda
  StateRow* penalty;    ///< named components below

  /// Components of the row "penalty".
  enum { value, last_gap, least, stiffens_at, components };
  double eps() const { return std::max(penalty->trial[value], penalty->trial[least]); }
  /// Whether any multiplier does. Collective.
  bool press_anywhere(MPI_Comm comm) const;
  /// Facets that came free inside a body have none (ContactInterface::expose).
  double lambda(int index) const {
    const auto place = static_cast<std::size_t>(index);
    return place < multiplier->trial.size() ? multiplier->trial[place] : 0;
  }
};

/// What an augmentation changes; equal on all ranks.
struct AugmentReport {
  double penetration = 0; ///< max(-g) over all points
  double largest_gap = 0; ///< max of |g|, at most p / eps, over the points with p > 0
  double multiplier = 0;  ///< largest new multiplier
  double change = 0;      ///< largest change of a multiplier over the largest new one
  double force_change =
      0; ///< that of the forces on the nodes, where augmentations no longer halve the change; else `change`
  double penalty = 0; ///< the penalty that was used
  int active = 0;
  bool settled =
      true; ///< nothing that presses changed what it faces since the solve, or is too deep to judge
  bool converged = false; ///< settled, and what the enforcement asks for
};

/// What a step of Newton's method made of the constraints.
struct SetChange {
  bool other = false; ///< others are active, or slide, on any rank: the next linear solve needs a new matrix
  int active = 0;     ///< of all ranks, where multipliers follow the iterates
};

/// Active gaps, and slips that must vanish, as Newton's method left them.
struct GapsLeft {
  /// To 1e-11 of a facet, and so that closing the rest takes no more than a given force against the penalty
  /// at any constraint, or to rounding of the coordinates. True where gaps are not closed in Newton's method.
  bool closed = true;
  double open = 0; ///< the largest, over the mean facet
};

/// More functions than usual: what a method may differ in from the plain penalty, one each.
class EnforcementMethod {
public:
  EnforcementMethod(const ContactSettings& settings, const EnforcementRows& rows)
      : settings_(&settings), rows_(rows) {}
  virtual ~EnforcementMethod() = default;

  double eps() const { return rows_.eps(); }

  /// Whether a constraint presses at this gap.
  virtual bool presses(int index, double gap) const { return rows_.lambda(index) - eps() * gap > 0; }
  /// Writes lambda, pressure and active of a constraint whose gap is known.
  virtual void press(Constraint& c) const;
  /// -dp/dg of an active constraint, or the weight of its gap in the linear solves.
  virtual double stiffness(const Constraint& /*c*/) const { return eps(); }
  /// Stored energy per reference area.
  virtual double potential(const Constraint& c) const;
  /// The depth in which a spring stores as much, without multipliers.
  virtual double depth(double potential) const { return std::sqrt(2 * potential / eps()); }

  /// Stress per slip of a sticking constraint.
  virtual double slip_weight() const { return eps(); }
  /// Of a sliding constraint: change of its traction by slip across the direction of the traction.
  virtual double turn_stiffness(const Constraint& c, const Traction& t) const;

  /// Whether pressures and tractions are those of their rows, which explicit steps find (impulses.hpp).
  virtual bool is_given() const { return false; }
  /// Whether multipliers hold gaps, which a penalty cannot do.
  virtual bool has_multipliers() const { return false; }
  /// Whether multipliers follow the iterates of Newton's method, whose linear solves close the active gaps.
  virtual bool closes_gaps() const { return false; }
  /// Whether multipliers follow the solves of Newton's method.
  virtual bool augments() const { return false; }
  /// What takes its place where it does not come to rest, or may not be used; null: itself.
  virtual std::unique_ptr<EnforcementMethod> fallback() const { return nullptr; }

  /// Before a step is tried. Collective, as what follows.
  virtual void begin_attempt(const Constraints& /*constraints*/, const Friction& /*friction*/) {}
  /// Before a step without inertia whose supports and obstacles have passed so deep into what nothing presses
  /// on yet. True where the method begins softly, which ends once it holds all of its penalty.
  virtual bool ease(const Constraints& /*constraints*/, double /*depth*/) { return false; }
  /// Before Newton's method starts from u.
  virtual void start_newton(const Constraints& /*constraints*/, Vec /*u*/) {}
  /// After its step du from u, which ended at `next`.
  virtual SetChange after_newton_step(const Constraints& /*constraints*/, Friction& /*friction*/, Vec /*u*/,
                                      Vec /*du*/, Vec /*next*/) {
    return {};
  }
  virtual GapsLeft gaps_left(const Constraints& /*constraints*/, const Friction& /*friction*/, Vec /*u*/,
                             double /*force*/) const {
    return {};
  }
  /// Whether a solve that ended at u, of which `report` tells, may be the last one.
  virtual bool converged(const AugmentReport& report, const Constraints& /*constraints*/,
                         const Friction& /*friction*/, Vec /*u*/) const {
    return report.settled;
  }
  /// Takes the proposed pressures for multipliers where it has some.
  virtual void augment(const AugmentReport& /*report*/, std::vector<double>& /*lambda*/) {}

protected:
  const ContactSettings* settings_;
  EnforcementRows rows_;
};

/// What the settings ask for, automatic values resolved; `conserving`: with inertia and exact work.
std::unique_ptr<EnforcementMethod> make_enforcement(const ContactSettings& settings,
                                                    const EnforcementRows& rows, bool conserving);
/// The methods, one file each; `conserving` likewise.
std::unique_ptr<EnforcementMethod> make_penalty(const ContactSettings& settings, const EnforcementRows& rows,
                                                bool conserving);
std::unique_ptr<EnforcementMethod> make_augmented(const ContactSettings& settings,
                                                  const EnforcementRows& rows);
std::unique_ptr<EnforcementMethod> make_impulse(const ContactSettings& settings, const EnforcementRows& rows);
std::unique_ptr<EnforcementMethod> make_semismooth(const ContactSettings& settings,
                                                   const EnforcementRows& rows);

/// What no pressure closes, because there are more constraints than the surfaces can meet, is let off below
/// this part of a facet.
inline constexpr double most_open = 1e-6;

} // namespace impact
