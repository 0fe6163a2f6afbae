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
  damage
};

struct BoundaryCondition {
  std::string id;
  std::vector<std::string> on;
  BcType type = BcType::displacement;
  std::optional<Expression> component[3]; ///< of whatever the type names; absent = free
  std::optional<Expression> rotation[3];  ///< of rigid bodies, about their centre of mass
  std::optional<Expression> value;        ///< scalar of pressure, damage
};

struct InitialCondition {
  std::string id;
  std::vector<std::string> on;
  std::optional<Expression> u[3], v[3], phi;
};

} // namespace impact
