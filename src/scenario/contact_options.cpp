#include "classes.hpp"
#include <impact/scenario/petsc_options.hpp>

/// The options of contacts, -contact_<id>_...
namespace impact {

namespace {

using Contact = ContactScenario;
using ContactRows = std::vector<OptionRow<Contact>>;

const std::string rigid_sides = "plane, rigid_sphere, rigid_cylinder";

void add_sides(ContactRows& rows) {
  const auto is_facets = [](const Contact&, int dim) { return dim - 1; };
  Rows row(rows);
  row.text("secondary", &Contact::secondary, "name of a boundary", "boundary whose points are checked")
      .required()
      .refused([](const Contact& c) { return Contact::rigid_name(c.secondary); },
               "a rigid body is the primary side; exchange the two sides")
      .group_dimension = is_facets;
  row.text("primary", &Contact::primary, "name of a boundary, " + rigid_sides,
           "boundary that they meet, the same one again (a surface folds on itself, or several bodies under "
           "one name meet), or a rigid body")
      .required()
      .group_dimension = [](const Contact& c, int dim) { return c.rigid() ? -1 : dim - 1; };
  const auto only_of = [](std::initializer_list<const char*> bodies) {
    return [=, of = std::vector<std::string>(bodies.begin(), bodies.end())](const Contact& c) {
      return std::ranges::find(of, c.primary) == of.end();
    };
  };
  row.point("plane_point", &Contact::plane_point, "m", "a point of the rigid plane")
      .idle(only_of({"plane"}), "<>primary is no rigid plane");
  row.point("plane_normal", &Contact::plane_normal, "1", "normal of the rigid plane, away from its body")
      .idle(only_of({"plane"}), "<>primary is no rigid plane")
      .refused(
          [](const Contact& c) {
            return c.primary == "plane" &&
                   std::all_of(c.plane_normal, c.plane_normal + 3, [](double n) { return n == 0; });
          },
          "has no direction; allowed: a vector of any length but 0");
  const std::string round = "<>primary is no rigid sphere or cylinder";
  row.point("centre", &Contact::centre, "m", "of the rigid sphere, or a point on the axis of the cylinder")
      .idle(only_of({"rigid_sphere", "rigid_cylinder"}), round);
  row.point("axis", &Contact::axis, "1", "of the rigid cylinder; in the plane along z")
      .idle(only_of({"rigid_cylinder"}), "<>primary is no rigid cylinder");
  row.number("radius", &Contact::radius, "m", not_negative,
             "of the rigid sphere or cylinder, outside of which the bodies are")
      .idle(only_of({"rigid_sphere", "rigid_cylinder"}), round);
}

void add_methods(ContactRows& rows) {
  Rows row(rows);
  row.choice("method", &Contact::method,
             "constraints at Gauss points, or for mean gaps about the nodes (mortar); auto: mortar, gpts "
             "where both sides share nodes and with central differences",
             "auto", ContactMethod::automatic, "gpts", ContactMethod::gauss_points, "mortar",
             ContactMethod::mortar);
  row.choice("multipliers", &Contact::multipliers,
             "of the mortar: the shape functions, or functions biorthogonal to them on facets that are "
             "covered as a whole; auto: standard in the plane, dual in space and for friction with rigid "
             "obstacles at rest (-ts_type static)",
             "auto", MultiplierSpace::automatic, "standard", MultiplierSpace::standard, "dual",
             MultiplierSpace::dual);
  row.choice("enforce", &Contact::enforce,
             "augmented Lagrangian (Uzawa), penalty alone, or semismooth Newton with multipliers; impulses "
             "at the "
             "secondary nodes that give no energy, of central differences alone; auto: "
             "semismooth with mortar up to 1.5e6 unknowns in the plane and 2e4 in space, else auglag; with "
             "central "
             "differences penalty",
             "auto", Enforcement::automatic, "auglag", Enforcement::auglag, "penalty", Enforcement::penalty,
             "semismooth", Enforcement::semismooth, "impulse", Enforcement::impulse)
      .notation("(74)-(79)")
      .refused([](const Contact& c,
                  const Scenario& s) { return c.enforce == Enforcement::impulse && !s.explicit_steps(); },
               "is for -ts_type central_difference; take that, or another enforcement");
  row.number(
      "friction", &Contact::friction, "1 mu", not_negative,
      "Coulomb's coefficient of friction; bodies without damping take up vibrations from it in steps that "
      "resolve their waves, which _b_d takes (theory.md, flutter)");
}

void add_heat(ContactRows& rows) {
  Rows row(rows);
  row.number("conductance", &Contact::conductance, "W/(m^2.K) h_c (83')", not_negative,
             "heat that passes a closed place, per current area and temperature; 0: insulated. Where bodies "
             "close because they are warm and open as they lose it, a static run may have no answer but with "
             "_conductance_exponent")
      .refused([](const Contact&, const Scenario& s) { return !s.has_heat() && s.physics.empty(); },
               "no material has a heat capacity; give -material_{material}_c_v, or remove it");
  row.number("conductance_exponent", &Contact::conductance_exponent, "1 m (83')", not_negative,
             "m of h = h_c (p/p_0)^m, 0.95 of rough metals; 0: h = h_c")
      .barred([](const Contact& c,
                 const Scenario& s) { return c.conductance_exponent > 0 && s.has_heat() && !s.has_motion(); },
              ": bodies that stay where they are do not press; remove it, or solve motion too (-physics)");
  row.number("conductance_gap", &Contact::conductance_gap, "m", or_auto(not_negative),
             "places that are no further apart count as closed for heat, pressed or not; auto: 1e-6 of the "
             "mean secondary facet")
      .idle([](const Contact& c) { return !(c.conductance > 0); }, "<>conductance is 0")
      .idle([](const Contact& c) { return c.conductance_exponent > 0; },
            "heat goes with the pressure, by <>conductance_exponent");
  row.number("conductance_pressure", &Contact::conductance_pressure, "Pa p_0 (83')", positive,
             "p_0 of h = h_c (p/p_0)^m, of rough metals the hardness of the softer one")
      .otherwise("required with _conductance_exponent")
      .needed([](const Contact& c) { return c.conductance_exponent > 0; },
              "allowed: a pressure > 0; <>conductance_exponent needs it");
  row.number(
         "friction_heat_split", &Contact::friction_heat_split, "1 (84')", or_auto(fraction),
         "part of the frictional heat that enters the secondary side; auto: 0.5, or 1 against a rigid body")
      .idle([](const Contact& c, const Scenario& s) { return !(c.friction > 0 && s.has_heat()); },
            "<>friction is 0, or no temperature is solved for");
  row.expression("temperature", &Contact::temperature, "K", positive,
                 "of the rigid body over t; left out: it is insulated")
      .needed([](const Contact& c) { return c.rigid() && c.conductance > 0; },
              "allowed: an expression of t; a rigid body that conducts needs one")
      .refused([](const Contact& c) { return !c.rigid(); },
               "`{primary}` is a boundary, whose temperature is solved for; allowed: with " + rigid_sides +
                   " as the primary");
}

/// Data of augmentations beside an enforcement that makes none.
void tell_without_augmentations(ContactRows& rows) {
  for (OptionRow<Contact>& row : rows)
    if (row.name == "penalty_increment" || row.name == "penalty_max" || row.name == "penalty_growth" ||
        row.name == "gap_tol" || row.name == "pressure_tol")
      row.idle(
          [](const Contact& c, const Scenario& s) {
            return s.explicit_steps() ||
                   (c.enforce != Enforcement::automatic && c.enforce != Enforcement::auglag);
          },
          "nothing is augmented");
}

void add_penalties(ContactRows& rows) {
  Rows row(rows);
  row.number("penalty", &Contact::penalty, "N/m^3 epsilon_N (75)", or_auto(positive),
             "starting penalty; auto: 10 E/h, E of the softest cells at either surface, h the mean secondary "
             "facet, with auglag "
             "more in steps far below h/c_p and less for a first touch; with central "
             "differences what the part of the stable step that "
             "-ts_dt_cfl leaves, of 0.8 to 0.9, has room for (the log has it), twice as stiff where points "
             "of two bodies press a tenth of a facet deep: bodies enter each other, by a part of their "
             "strain that finer cells make less; a stiffer one takes shorter steps by itself, and impulses "
             "(_enforce) let nothing in");
  row.number("penalty_increment", &Contact::penalty_increment, "N/m^3", or_auto(positive),
             "added when the penalty grows; auto: the starting penalty, or four times its automatic value "
             "from a start below that");
  row.number("penalty_max", &Contact::penalty_max, "N/m^3", or_auto(positive),
             "largest penalty; auto: 1e4 times the automatic one")
      .refused([](const Contact& c) { return c.penalty > c.penalty_max; },
               "is less than the starting penalty; allowed: >= {penalty}");
  row.choice(
      "penalty_growth", &Contact::growth,
      "grow when an augmentation closed the gap by less than a factor 4, or at every one (the paper's)",
      "slow_gap", PenaltyGrowth::on_slow_gap, "always", PenaltyGrowth::every_augmentation);
  row.number("gap_tol", &Contact::gap_tol, "m (77)-(79)", or_auto(positive),
             "penetration at which augmentations end; auto: 1e-3 of the secondary facet");
  row.number("pressure_tol", &Contact::pressure_tol, "1", positive,
             "augmentations end where they change no multiplier by more than this part of the largest; in "
             "statics, where single points go on sharing a force otherwise, no force on a node by this part "
             "of the largest; with inertia what they leave is energy, which 1e-4 keeps to about 1e-7")
      .otherwise("1e-2");
  tell_without_augmentations(rows);
}

/// A contact whose update of velocities excludes the stabilised one; null: none.
const Contact* conserving(const Scenario& scenario) {
  for (const Contact& contact : scenario.contacts)
    if (contact.impact == ImpactUpdate::conserving) return &contact;
  return nullptr;
}

/// No update keeps the energy of multipliers where no body can take it up.
bool nothing_deforms(const Scenario& s) {
  return s.has_inertia() && !s.explicit_steps() &&
         std::all_of(s.materials.begin(), s.materials.end(),
                     [](const MaterialScenario& m) { return m.law.model == Model::rigid; });
}
void resolve_between_rigid(Contact& contact) {
  if (asks_for_damped_steps())
    contact.enforce = Enforcement::penalty;
  else
    contact.impact = ImpactUpdate::conserving;
}

void add_detection(ContactRows& rows) {
  Rows row(rows);
  row.count("points", &Contact::points, 1, "Gauss points per secondary facet and direction", 5)
      .otherwise("2");
  row.number("search_radius", &Contact::search_radius, "m", or_auto(positive),
             "facets are looked at as pairs up to this distance; auto: what can meet in a step, by the sizes "
             "of the facets and how far they move; overlaps are seen up to 0.8 of the smallest facet deep");
  row.choice(
      "initial", &Contact::initial,
      "bodies that overlap at the start: secondary nodes move out without stress, by _initial_tol at "
      "most; refused; left so: a static run presses them, with inertia only those do that are no deeper "
      "than 2e-3 of a facet",
      "adjust", InitialOverlap::adjust, "error", InitialOverlap::error, "allow", InitialOverlap::allow);
  row.number("initial_tol", &Contact::initial_tol, "m", or_auto(not_negative),
             "deepest overlap that is moved apart, or of curved facets counts as none; auto: 1e-3 of the "
             "secondary facet");
  row.choice(
         "impact", &Contact::impact,
         "treatment of the shock at touch; auto: stabilised, but none where another contact is conserving "
         "or damped steps (-ts_newmark_rho below 1) are longer than 1000 h/c_p; where no body deforms "
         "conserving, in damped steps a penalty without an update; "
         "conserving: a penalty whose work is exact, in the trapezoidal rule",
         "auto", ImpactUpdate::automatic, "stabilised", ImpactUpdate::stabilised, "conserving",
         ImpactUpdate::conserving, "none", ImpactUpdate::none)
      .refused(
          [](const Contact& c, const Scenario& s) {
            return c.impact == ImpactUpdate::stabilised && conserving(s) != nullptr;
          },
          [](const Contact&, const Scenario& s) {
            return "changes the integrator that the update of contact " + conserving(s)->id +
                   " conserves energy with; allowed beside conserving: conserving, none";
          })
      .idle([](const Contact& c,
               const Scenario& s) { return !s.has_inertia() && c.impact == ImpactUpdate::stabilised; },
            "nothing has inertia");
}

} // namespace

OptionClass<ContactScenario> contact_class() {
  OptionClass<Contact> table{"contact", "contacts", "Contact",
                             "The secondary side carries the points that must not enter the primary one: "
                             "take the finer, softer or smaller side.",
                             &Scenario::contacts};
  add_sides(table.rows);
  add_obstacle(table.rows);
  add_methods(table.rows);
  add_heat(table.rows);
  add_penalties(table.rows);
  add_detection(table.rows);
  table.complete = [](Contact& contact, const Scenario& s) {
    if (contact.rigid_mass > 0 && contact.rigid()) contact.carrier = "obstacle_" + contact.id;
    if (nothing_deforms(s) && contact.impact == ImpactUpdate::automatic &&
        contact.enforce == Enforcement::automatic)
      resolve_between_rigid(contact);
  };
  return table;
}

} // namespace impact
