#pragma once
#include <impact/kernel/damage.hpp>

/// Choices of the solution method that the user makes by options.
namespace impact {

enum class DamageBounds { vi, history, clip, none };
enum class TangentChoice { automatic, consistent, symmetric };
enum class ContactOperator { assembled, shell };

struct DamageScenario {
  DamageForm form = DamageForm::multiplied;
  double theta = 1;
  DamageBounds bounds = DamageBounds::vi;
};

struct CouplingScenario {
  int max_it = 1;
  double atol = 1e-4;
};

} // namespace impact
