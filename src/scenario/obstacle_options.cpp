#include "classes.hpp"
#include <impact/petsc/error.hpp>

/// The options of rigid obstacles, -contact_<id>_rigid_...: how they move, and the mass of those that move
/// freely.
namespace impact {

namespace {

using Contact = ContactScenario;

bool has_inertia(const Contact& contact) { return !std::isnan(contact.rigid_inertia); }

/// Whether everything that a rigid obstacle with mass could do is prescribed, and needs no mass for that, as
/// rotations do.
bool needs_no_mass(const Contact& c, PlaneMode plane, int dim) {
  const bool ring = plane == PlaneMode::axisymmetric,
             held = ring || (c.primary == "plane" && !has_inertia(c));
  bool moves = false;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (k < dim) moves = moves || !(c.rigid_u[i] || (ring && k == 0));
    if (dim == 3 || k == 2) moves = moves || c.rigid_r[i] || !held;
  }
  return !moves;
}

void add_mass(std::vector<OptionRow<Contact>>& rows) {
  Rows row(rows);
  row.number("rigid_mass", &Contact::rigid_mass, "kg M", positive,
             "of the rigid body, which then moves freely as the region obstacle_<id>; of plane bodies for "
             "the whole thickness; left out: it moves as told")
      .refused([](const Contact& c) { return !c.rigid(); },
               "`{primary}` is a boundary of the mesh; allowed: with plane, rigid_sphere, rigid_cylinder as "
               "the primary; a meshed body has the mass of its material")
      .refused([](const Contact&, const Scenario& s) { return s.has_heat(); },
               "not available with heat; allowed: runs without; mesh the body, or prescribe its motion")
      .denied([](const Contact&, const Scenario& s) { return s.contact_operator == ContactOperator::shell; },
              "-contact_operator \"shell\": not with the rigid body of <>rigid_mass; allowed: assembled, the "
              "default");
  row.number("rigid_inertia", &Contact::rigid_inertia, "kg.m^2 J", or_auto(positive),
             "its moment of inertia about any axis through its centre; auto: 2/5 M R^2 of a sphere, M R^2/2 "
             "of a cylinder about its axis, also in the plane; a plane does not turn");
  row.number("rigid_length", &Contact::rigid_length, "m", positive,
             "of a rigid cylinder in space, for its inertia across the axis")
      .refused([](const Contact& c) { return c.rigid_mass > 0 && has_inertia(c); },
               "beside <>rigid_inertia there is nothing for it to say; remove it")
      .refused([](const Contact& c) { return c.rigid_mass > 0 && c.primary != "rigid_cylinder"; },
               "`{primary}` has none; allowed: with rigid_cylinder; remove it");
}

} // namespace

void add_obstacle(std::vector<OptionRow<ContactScenario>>& rows) {
  const std::size_t first = rows.size();
  Rows row(rows);
  row.components("rigid_u", &Contact::rigid_u, "m",
                 "displacement of the rigid body over t; left out: none, or with a mass free");
  add_mass(rows);
  row.components(
      "rigid_r", &Contact::rigid_r, "1",
      "rotation of a rigid body with mass about its centre over t, as with -bc_<id>_rx; left out: free",
      Rows<Contact>::Of::turns);
  for (std::size_t i = first; i < rows.size(); ++i) {
    if (rows[i].name.starts_with("rigid_u")) { // an obstacle that moves as told stays in the plane anyway
      rows[i].refused([](const Contact& c) { return !c.rigid(); },
                      "`{primary}` is a boundary of the mesh, which moves as its body does; allowed: with "
                      "plane, rigid_sphere, rigid_cylinder as the primary; remove it");
      const auto misfit = rows[i].misfit;
      rows[i].misfit = [=](const Contact& c, int dim) {
        return c.carrier.empty() || !misfit ? std::string() : misfit(c, dim);
      };
    } else if (rows[i].name != "rigid_mass") {
      rows[i].barred(
          [](const Contact& c) { return c.rigid_mass == 0; },
          std::string(": is for a rigid body with mass; give <>rigid_mass") +
              (rows[i].name.starts_with("rigid_r") ? " (any, where all of its motion is told)" : "") +
              ", or remove it");
    }
  }
}

void check_obstacle_motion(const Scenario& scenario, int dim) {
  for (const Contact& contact : scenario.contacts)
    if (!contact.carrier.empty() && needs_no_mass(contact, scenario.plane, dim))
      throw UserError(ExitCode::usage,
                      "-contact_" + contact.id + "_rigid_mass \"" + number_text(contact.rigid_mass) +
                          "\": the whole motion is prescribed, and nothing is left that a mass could change; "
                          "allowed: leave a component of -contact_" +
                          contact.id + "_rigid_u out, or the mass");
}

} // namespace impact
