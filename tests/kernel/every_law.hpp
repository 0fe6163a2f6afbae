#pragma once
#include "../material/law_sampler.hpp"

#include <string>

namespace reference {

/// A test of all laws takes each so-many-th of them: with sanitizers a law takes a second on a large cell,
/// whose kernels are those of the others.
template <class Cell> constexpr int law_stride() {
#ifdef __SANITIZE_ADDRESS__
  return Cell::nodes > 10 ? 11 : Cell::nodes > 4 ? 5 : 1;
#else
  return 1;
#endif
}

/// Every combination of the law's options, named for the message of a failure; the hardening laws with every
/// fifth of them.
template <class F> void for_every_law(F&& f) {
  using namespace impact;
  int number = 0, states = 0;
  for (const Model model : {Model::elastic, Model::j2})
    for (const Damage damage : {Damage::none, Damage::at2, Damage::at1, Damage::wu})
      for (const Split split : {Split::volumetric, Split::none, Split::star_convex, Split::spectral,
                                Split::no_tension, Split::drucker_prager})
        for (const Degradation ge :
             {Degradation::quadratic, Degradation::cubic, Degradation::ductile, Degradation::exponential,
              Degradation::cornelissen, Degradation::lorentz})
          for (const PlasticDegradation gp : {PlasticDegradation::one, PlasticDegradation::ge})
            for (const DamageGradient gradient : {DamageGradient::spatial, DamageGradient::material})
              for (const Locking locking : {Locking::none, Locking::mean, Locking::fbar})
                for (const int viscous : {0, 1, 2}) {
                  // refused by the options
                  if (by_principal(split) && split != Split::spectral && model == Model::j2) continue;
                  if (ge == Degradation::ductile && model != Model::j2) continue;
                  const bool of_wu = is_cohesive(ge) && ge != Degradation::lorentz;
                  if (of_wu != (damage == Damage::wu)) continue;
                  if (ge == Degradation::lorentz && damage != Damage::at1) continue;
                  // damage's own terms meet the locking cures and the viscosity under at2
                  if (damage != Damage::none && damage != Damage::at2 &&
                      (locking == Locking::fbar || viscous == 2))
                    continue;
                  MaterialParameters m = aluminium();
                  m.alpha_c = 0.04;
                  m.model = model, m.damage = damage, m.split = split, m.ge = ge, m.gp = gp;
                  m.damage_gradient = gradient, m.locking = locking;
                  m.star_gamma = split == Split::star_convex ? 1.5 : 0;
                  m.cone = split == Split::drucker_prager ? 0.3 : 0;
                  if (is_cohesive(ge)) reference::set_strength(m, 300e6);
                  m.b_d = viscous ? 1e5 : 0;
                  m.visc_degrade = viscous == 2;
                  m.residual_stiffness = 1e-6;
                  const int hardening =
                      m.model == Model::j2 && ++number % 5 == 0 ? number / 5 % reference::hardening_kinds : 0;
                  reference::set_hardening(m, hardening);
                  const bool state = !by_principal(split) && ++states % 7 == 0;
                  if (state) reference::set_state(m, states % 2);
                  f(m, "hardening " + std::to_string(hardening) + " model " + std::to_string(int(model)) +
                           " damage " + std::to_string(int(damage)) + " split " + std::to_string(int(split)) +
                           " ge " + std::to_string(int(ge)) + " gp " + std::to_string(int(gp)) +
                           " gradient " + std::to_string(int(gradient)) + " locking " +
                           std::to_string(int(locking)) + " viscous " + std::to_string(viscous) + " state " +
                           std::to_string(state));
                }
}

} // namespace reference
