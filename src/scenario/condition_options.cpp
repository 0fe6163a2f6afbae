#include "classes.hpp"
#include <algorithm>

/// The options of boundary and initial conditions, -bc_<id>_... and -ic_<id>_...
namespace impact {

namespace {

using Bc = BoundaryCondition;

/// What the value or the components of a condition are.
struct ConditionKind {
  const char* name;
  BcType type;
  const char* unit; ///< SI
  enum class By { nothing, components, value } by = By::components;
  enum class On { any, facets, cells } on = On::any;
  Interval range = any_number;
};
using By = ConditionKind::By;
using On = ConditionKind::On;

const ConditionKind kinds[] = {
    {"fix", BcType::fix, "1", By::nothing},
    {"displacement", BcType::displacement, "m"},
    {"symmetry", BcType::symmetry, "1", By::nothing},
    {"velocity", BcType::velocity, "m/s"},
    {"acceleration", BcType::acceleration, "m/s^2"},
    {"traction", BcType::traction, "Pa", By::components, On::facets},
    {"pressure", BcType::pressure, "Pa", By::value, On::facets},
    {"force", BcType::force, "N"},
    {"body_force", BcType::body_force, "m/s^2", By::components, On::cells},
    {"foundation", BcType::foundation, "1", By::nothing, On::facets},
    {"absorbing", BcType::absorbing, "1", By::nothing, On::facets},
    {"damage", BcType::damage, "1", By::value, On::any, fraction},
    {"temperature", BcType::temperature, "K", By::value, On::any, positive},
    {"heat_flux", BcType::heat_flux, "W/m^2", By::value, On::facets},
    {"convection", BcType::convection, "K", By::value, On::facets, positive},
    {"heat_source", BcType::heat_source, "W/m^3", By::value, On::cells},
};

const ConditionKind& kind_of(const Bc& bc) {
  return *std::ranges::find_if(kinds, [&](const ConditionKind& kind) { return kind.type == bc.type; });
}

bool is_by(const Bc& bc, By by) { return kind_of(bc).by == by; }
bool turns(const Bc& bc) { return bc.type == BcType::displacement || bc.type == BcType::velocity; }
bool has_components(const Bc& bc) {
  const auto given = [](const auto& component) { return component.has_value(); };
  return std::any_of(bc.component, bc.component + 3, given) ||
         std::any_of(bc.rotation, bc.rotation + 3, given);
}

const std::string meaningless = "has no meaning for this type; ",
                  scalars = "types pressure, damage, temperature, heat_flux, convection and heat_source";

/// The rows of springs and dashpots.
void add_foundation(Rows<Bc>& row) {
  const auto add = [&](const std::string& name, auto place, const std::string& quantity,
                       const std::string& about) -> auto& {
    return row.expression(name, place, quantity, not_negative, about + "; an expression of x, y, z")
        .refused([](const Bc& bc) { return bc.type != BcType::foundation; },
                 meaningless + "allowed with type foundation")
        .refused([=](const Bc& bc) { return place(bc) && place(bc)->asks_for_time(); },
                 "does not change with t; allowed: an expression of x, y, z");
  };
  add(
      "stiffness", [](auto& bc) -> auto& { return bc.stiffness[0]; }, "Pa/m k_n (3')",
      "springs of a foundation against displacement along the normal of the undeformed surface: traction "
      "over displacement")
      .needed(
          [](const Bc& bc) {
            return bc.type == BcType::foundation && !bc.stiffness[0] && !bc.stiffness[1] && !bc.damping[0] &&
                   !bc.damping[1];
          },
          "allowed: at least one of <>stiffness, <>stiffness_tangential, <>damping, <>damping_tangential");
  add(
      "stiffness_tangential", [](auto& bc) -> auto& { return bc.stiffness[1]; }, "Pa/m k_t (3')",
      "the same across the normal");
  add(
      "damping", [](auto& bc) -> auto& { return bc.damping[0]; }, "Pa.s/m c_n (3')",
      "dashpots of a foundation against velocity along the normal: traction over velocity");
  add(
      "damping_tangential", [](auto& bc) -> auto& { return bc.damping[1]; }, "Pa.s/m c_t (3')",
      "the same across the normal");
}

/// Adds what the type of a condition demands of its other rows.
void add_demands(std::vector<OptionRow<Bc>>& rows) {
  for (OptionRow<Bc>& row : rows) {
    if (row.name[0] == 'u')
      row.refused([](const Bc& bc) { return is_by(bc, By::value); },
                  meaningless + "remove it, <>value is what it takes")
          .refused([](const Bc& bc) { return is_by(bc, By::nothing); },
                   meaningless + "remove it, or choose <>type displacement");
    if (row.name == "ux")
      row.needed([](const Bc& bc) { return is_by(bc, By::components) && !has_components(bc); },
                 "allowed: at least one of <>ux, <>uy, <>uz");
    if (row.name[0] == 'r')
      row.refused([](const Bc& bc) { return !turns(bc); },
                  meaningless + "allowed with types displacement and velocity, of rigid bodies");
    if (row.name == "type")
      row.barred([](const Bc& bc,
                    const Scenario& s) { return s.physics.empty() && !s.has_heat() && is_thermal(bc.type); },
                 ": acts on the temperature, and no material has a heat capacity; give "
                 "-material_{material}_c_v, or remove it")
          .barred(
              [](const Bc& bc, const Scenario& s) {
                return s.solves("damage") && !s.has_damage() && bc.type == BcType::damage;
              },
              ": acts on the damage, and no material has any; give -material_{material}_damage, or "
              "remove it")
          .barred(
              [](const Bc& bc, const Scenario& s) {
                return bc.type == BcType::absorbing && s.has_motion() && !s.has_inertia();
              },
              ": waves need inertia; allowed with -ts_type newmark and central_difference, or type "
              "foundation")
          .barred(
              [](const Bc& bc, const Scenario& s) {
                return (bc.damping[0] || bc.damping[1]) &&
                       (s.coupling.path_length > 0 || s.coupling.path_dissipation > 0);
              },
              ": dashpots feel a velocity, which steps along a path do not have; leave <>damping and "
              "<>damping_tangential out");
  }
}

} // namespace

OptionClass<BoundaryCondition> boundary_class() {
  OptionClass<Bc> table{"bc", "bcs", "Boundary conditions",
                        "Values are expressions of x, y, z (reference coordinates) and t.", &Scenario::bcs};
  std::vector<std::pair<std::string, BcType>> types;
  for (const ConditionKind& kind : kinds) types.emplace_back(kind.name, kind.type);
  const auto unit_of = [](const Bc& bc) { return std::string(kind_of(bc).unit); };
  Rows row(table.rows);
  row.groups("on", &Bc::on, "groups of the mesh: boundaries, points, or regions with all their nodes",
             [](const Bc& bc, int dim) {
               return kind_of(bc).on == On::facets ? dim - 1 : kind_of(bc).on == On::cells ? dim : 0;
             });
  row.choice(
      "type", &Bc::type,
      "what is prescribed: traction is dead, per reference area; pressure follows, per current area, "
      "positive inwards; force is a total, of a plane problem on its -thickness, of a ring on all of "
      "it, spread over the reference area, the length of lines or "
      "evenly over points; body_force is per mass; heat_flux is inwards, per reference area, "
      "heat_source per reference volume; convection is a flux h (value - theta); symmetry holds one plane "
      "normal to an axis; foundation is springs and dashpots, which hold an inclined plane of symmetry, too; "
      "absorbing lets waves of the material beneath leave, those along the normal without an echo (3')",
      types);
  row.components("u", &Bc::component, by_type,
                 "component of what the type prescribes, of a displacement, velocity, force, traction, ..; "
                 "left out: free, or no load",
                 Rows<Bc>::Of::places, unit_of);
  row.components(
      "r", &Bc::rotation, by_type,
      "rotation of rigid bodies about their centre of mass, or with type velocity its rate; about fixed "
      "axes, in space the rotation vector where all three are given; left out: free",
      Rows<Bc>::Of::turns,
      [](const Bc& bc) { return std::string(bc.type == BcType::velocity ? "1/s" : "1"); });
  row.expression(
         "value", &Bc::value, by_type, any_number,
         "scalar of pressure, damage (phi), temperature, heat_flux and heat_source; of convection the "
         "temperature around",
         unit_of, [](const Bc& bc) { return kind_of(bc).range; })
      .needed([](const Bc& bc) { return is_by(bc, By::value) && !has_components(bc); },
              "allowed: an expression; the " + scalars + " need it")
      .refused([](const Bc& bc) { return !is_by(bc, By::value); }, meaningless + "allowed with " + scalars);
  row.expression("h", &Bc::coefficient, "W/(m^2.K) h", not_negative,
                 "coefficient of convection, per reference area")
      .needed([](const Bc& bc) { return bc.type == BcType::convection; },
              "allowed: an expression; type convection needs it")
      .refused([](const Bc& bc) { return bc.type != BcType::convection; },
               meaningless + "allowed with type convection");
  add_foundation(row);
  add_demands(table.rows);
  return table;
}

OptionClass<InitialCondition> initial_class() {
  using Ic = InitialCondition;
  OptionClass<Ic> table{
      "ic", "ics", "Initial conditions",
      "Boundary conditions win over initial ones; type acceleration starts with their velocity.",
      &Scenario::ics};
  Rows row(table.rows);
  row.groups("on", &Ic::on, "groups of the mesh", [](const Ic&, int) { return 0; });
  table.rows.back().refused(
      [](const Ic& ic) {
        const auto given = [](const auto& value) { return bool(value); };
        return !std::ranges::any_of(ic.u, given) && !std::ranges::any_of(ic.v, given) && !ic.phi && !ic.theta;
      },
      "begins with nothing: no value is given; allowed: beside <>ux .., <>vx .., <>phi or <>theta");
  row.components("u", &Ic::u, "m", "initial displacement");
  row.components("v", &Ic::v, "m/s", "initial velocity");
  row.expression("phi", &Ic::phi, "1 phi", fraction, "initial damage")
      .barred(
          [](const Ic&, const Scenario& s) { return s.solves("damage") && !s.has_damage(); },
          ": damages nothing, for no material has damage; give -material_{material}_damage, or remove it");
  row.expression("theta", &Ic::theta, "K theta", positive,
                 "initial temperature; other than _theta0 of the material it stresses what is held, and the "
                 "first static step brings balance")
      .otherwise("_theta0 of the material");
  return table;
}

} // namespace impact
