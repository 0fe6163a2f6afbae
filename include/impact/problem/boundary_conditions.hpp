#pragma once
#include <impact/input/expression.hpp>
#include <optional>
#include <string>
#include <vector>

/// What the user says of boundaries and of the start (options/README.md, groups "boundary conditions",
/// "initial conditions").
namespace impact {

enum class BcType {
  fix,
  displacement,
  symmetry,
  velocity,
  acceleration,
  traction,
  pressure,
  force,
  body_force,
  foundation,
  absorbing,
  damage,
  temperature,
  heat_flux,
  convection,
  heat_source
};

inline bool prescribes_motion(BcType type) {
  return type == BcType::fix || type == BcType::displacement || type == BcType::symmetry ||
         type == BcType::velocity || type == BcType::acceleration;
}
/// Springs and dashpots.
inline bool gives_way(BcType type) { return type == BcType::foundation || type == BcType::absorbing; }
inline bool is_thermal(BcType type) {
  return type == BcType::temperature || type == BcType::heat_flux || type == BcType::convection ||
         type == BcType::heat_source;
}

struct BoundaryCondition {
  std::string id;
  std::vector<std::string> on;
  BcType type = BcType::displacement;
  std::optional<Expression> component[3]; ///< of whatever the type names; absent = free
  std::optional<Expression> rotation[3];  ///< of rigid bodies, about their centre of mass
  /// Scalar of pressure and damage; temperature, heat flux inwards per reference area, temperature around a
  /// convection, heat source per reference volume.
  std::optional<Expression> value;
  std::optional<Expression> coefficient; ///< of convection: heat flux per reference area and kelvin
  /// Of a foundation, along the normal and across it: traction over displacement, over velocity; of places.
  std::optional<Expression> stiffness[2], damping[2];
};

struct InitialCondition {
  std::string id;
  std::vector<std::string> on;
  std::optional<Expression> u[3], v[3], phi, theta;
};

} // namespace impact
