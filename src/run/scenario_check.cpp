#include "scenario_tables.hpp"
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <impact/input/database.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <impact/run/output_folder.hpp>
#include <map>

/// What no single option can tell: defaults that hang on others, missing and contradicting options, names of
/// groups.
namespace impact {

std::pair<std::string, std::string> unsymmetric_force(const Scenario& scenario) {
  for (const MaterialScenario& material : scenario.materials)
    if (material.law.model == Model::rigid)
      return {"-material_" + material.law.id + "_model rigid", "other models"};
  for (const BoundaryCondition& bc : scenario.bcs)
    if (bc.type == BcType::pressure) return {"-bc_" + bc.id + "_type pressure", "dead loads"};
  for (const ContactScenario& contact : scenario.contacts) {
    if (contact.rigid_mass > 0)
      return {"-contact_" + contact.id + "_rigid_mass", "rigid bodies that move as told"};
    if (contact.friction > 0) return {"-contact_" + contact.id + "_friction", "no friction"};
  }
  return {};
}

namespace {

[[noreturn]] void fail(const std::string& message) { throw UserError(ExitCode::usage, message); }

bool any_plastic(const Scenario& scenario) {
  return std::any_of(scenario.materials.begin(), scenario.materials.end(),
                     [](const MaterialScenario& material) { return material.law.model == Model::j2; });
}

bool any_fatigue(const Scenario& scenario) {
  return scenario.has_motion() && scenario.has_damage() &&
         std::any_of(scenario.materials.begin(), scenario.materials.end(),
                     [](const MaterialScenario& material) {
                       return material.law.damage != Damage::none && material.law.fatigue_a > 0;
                     });
}

void complete_time(TimeScenario& time) {
  if (time.table_times.empty() || time.table_dts.empty()) return;
  if (time.dt == 0) time.dt = *std::max_element(time.table_dts.begin(), time.table_dts.end());
  if (time.max_time == 0) time.max_time = time.table_times.back();
}

void complete_output(OutputScenario& output, const Scenario& scenario) {
  if (output.dt == 0 && output.every == 0 && output.cycles == 0 && output.times.empty()) output.every = 1;
  if (output.file.empty())
    output.file = output.type == OutputScenario::Type::csv ? "history.csv" : output.id + ".xdmf";
  if (output.type == OutputScenario::Type::csv || !output.fields.empty()) return;
  output.fields = {"u"};
  if (!scenario.has_motion()) output.fields.clear();
  if (scenario.has_inertia()) output.fields.emplace_back("v");
  if (scenario.has_damage()) output.fields.emplace_back("phi");
  if (scenario.has_heat()) output.fields.emplace_back("theta");
  if (!scenario.has_motion()) return;
  output.fields.insert(output.fields.end(), {"stress", "von_mises", "pressure"});
  if (any_plastic(scenario)) output.fields.emplace_back("alpha");
  if (any_fatigue(scenario)) output.fields.emplace_back("fatigue");
  if (!scenario.contacts.empty())
    output.fields.insert(output.fields.end(), {"contact_pressure", "contact_gap", "contact_status"});
  if (std::any_of(scenario.contacts.begin(), scenario.contacts.end(),
                  [](const ContactScenario& contact) { return contact.friction > 0; }))
    output.fields.insert(output.fields.end(), {"contact_traction", "contact_slip"});
}

void check_time(const TimeScenario& time) {
  if (time.table_times.empty() != time.table_dts.empty())
    fail(std::string(time.table_times.empty() ? "-ts_times" : "-ts_dts") +
         ": missing; allowed: -ts_times and -ts_dts together, or neither");
  for (std::size_t i = 1; i < time.table_times.size(); ++i)
    if (time.table_times[i] <= time.table_times[i - 1])
      fail("-ts_times \"" + numbers_text(time.table_times) + "\": not increasing; allowed: increasing times");
  if (!time.table_times.empty() && time.table_times.size() != time.table_dts.size() + 1)
    fail("-ts_dts \"" + numbers_text(time.table_dts) + "\": " + std::to_string(time.table_dts.size()) +
         " steps for " + std::to_string(time.table_times.size()) +
         " times; allowed: one step less than times");
  if (time.dt == 0) fail("-ts_dt: missing; allowed: a time step > 0; or give -ts_times and -ts_dts");
  if (time.max_time == 0) fail("-ts_max_time: missing; allowed: the end of the run, > 0");
}

void check_materials(const Scenario& scenario) {
  if (scenario.materials.empty())
    fail("-materials: missing; allowed: a comma list of ids, one for each material");
  std::map<std::string, std::string> owner;
  bool body_force = false;
  for (const BoundaryCondition& bc : scenario.bcs) body_force = body_force || bc.type == BcType::body_force;
  for (const MaterialScenario& material : scenario.materials) {
    const std::string prefix = "-material_" + material.law.id + "_";
    for (const std::string& region : material.regions)
      if (const auto [at, fresh] = owner.emplace(region, material.law.id); !fresh)
        fail(prefix + "region \"" + region + "\": is made of material " + at->second +
             " already; give each region to one material");
    if (material.law.rho == 0 && (scenario.has_inertia() || body_force))
      fail(prefix + "rho: missing; needed by " +
           (body_force ? std::string("a body force") : "inertia; or run without it: -ts_type static"));
  }
}

void check_condition(const BoundaryCondition& bc) {
  const std::string prefix = "-bc_" + bc.id + "_",
                    scalars = "types pressure, damage, temperature, heat_flux, convection and heat_source";
  const bool scalar = bc.type == BcType::pressure || bc.type == BcType::damage || is_thermal(bc.type);
  const bool bare = bc.type == BcType::fix || bc.type == BcType::symmetry;
  const bool turns = bc.type == BcType::displacement || bc.type == BcType::velocity;
  const auto look = [](const std::optional<Expression>& given, bool allowed, const std::string& remedy) {
    if (given && !allowed)
      fail(given->key() + " \"" + given->text() + "\": has no meaning for this type; " + remedy);
    return given.has_value();
  };
  bool components = false;
  for (const auto& component : bc.component)
    components |= look(component, !scalar && !bare,
                       "remove it" + (scalar ? ", " + prefix + "value is what it takes"
                                             : ", or choose " + prefix + "type displacement"));
  for (const auto& turn : bc.rotation)
    components |= look(turn, turns, "allowed with types displacement and velocity, of rigid bodies");
  if (!look(bc.value, scalar, "allowed with " + scalars) && scalar)
    fail(prefix + "value: missing; allowed: an expression; the " + scalars + " need it");
  if (!look(bc.coefficient, bc.type == BcType::convection, "allowed with type convection") &&
      bc.type == BcType::convection)
    fail(prefix + "h: missing; allowed: an expression; type convection needs it");
  if (!scalar && !bare && !components)
    fail(prefix + "ux: missing; allowed: at least one of " + prefix + "ux, " + prefix + "uy, " + prefix +
         "uz");
}

/// A wrong power of ten makes a step that does not end.
void check_substeps(const Scenario& s, const char* option, double substep) {
  const double most = s.time.most_substeps;
  const double step = s.time.dt > 0 ? s.time.dt : 0;
  if (substep > 0 && step / substep > most)
    fail(std::string("-") + option + ": makes " + number_text(std::round(step / substep)) +
         " sub-steps in each step of -ts_dt; allowed: at most " + number_text(most) +
         " (-ts_substeps); take longer ones, a shorter -ts_dt, or raise -ts_substeps");
}

void check_heat(const Scenario& scenario) {
  const bool heat = scenario.has_heat(), asked = !scenario.physics.empty();
  if (!heat && asked && scenario.solves("heat"))
    fail("-physics \"heat\": no material has a heat capacity; give -material_" +
         scenario.materials.front().law.id + "_c_v");
  if (!asked)
    for (const BoundaryCondition& bc : scenario.bcs)
      if (!heat && is_thermal(bc.type))
        fail("-bc_" + bc.id +
             "_type: acts on the temperature, and no material has a heat capacity; give "
             "-material_" +
             scenario.materials.front().law.id + "_c_v, or remove it");
  if (heat)
    for (const MaterialScenario& material : scenario.materials)
      if (material.law.c_v == 0)
        fail("-material_" + material.law.id +
             "_c_v: missing; allowed: a heat capacity > 0; other materials have "
             "one, and heat is solved in all of them");
  if (!scenario.has_motion() && !heat && !scenario.has_damage())
    fail("-physics \"damage\": no material has damage; give -material_" + scenario.materials.front().law.id +
         "_damage");
}

void check_contact(const ContactSettings& contact) {
  const std::string prefix = "-contact_" + contact.id + "_";
  const double* n = contact.plane_normal;
  if (contact.primary == "plane" && n[0] == 0 && n[1] == 0 && n[2] == 0)
    fail(prefix + "plane_normal \"0,0,0\": has no direction; allowed: a vector of any length but 0");
  if (ContactSettings::rigid_name(contact.secondary))
    fail(prefix + "secondary \"" + contact.secondary +
         "\": a rigid body is the primary side; exchange the two sides");
  if (contact.penalty > contact.penalty_max)
    fail(prefix + "penalty_max \"" + number_text(contact.penalty_max) +
         "\": is less than the starting penalty; allowed: >= " + number_text(contact.penalty));
}

void check_obstacle(const ContactScenario& contact, const Scenario& scenario) {
  const std::string prefix = "-contact_" + contact.id + "_";
  const bool inertia = !std::isnan(contact.rigid_inertia);
  const auto given = [](const auto& components) {
    return std::find_if(std::begin(components), std::end(components),
                        [](const auto& c) { return c.has_value(); });
  };
  if (contact.rigid_mass == 0) {
    const auto turn = given(contact.rigid_r);
    const std::string name = inertia                         ? prefix + "rigid_inertia"
                             : contact.rigid_length > 0      ? prefix + "rigid_length"
                             : turn != contact.rigid_r.end() ? (*turn)->key()
                                                             : "";
    if (!name.empty())
      fail(name + ": is for a rigid body with mass; give " + prefix + "rigid_mass, or remove it");
    return;
  }
  const std::string mass = prefix + "rigid_mass \"" + number_text(contact.rigid_mass) + "\": ";
  if (!contact.rigid())
    fail(mass + "`" + contact.primary +
         "` is a boundary of the mesh; allowed: with plane, rigid_sphere, rigid_cylinder as the primary; a "
         "meshed body has the mass of its material");
  if (contact.rigid_length > 0 && (contact.primary != "rigid_cylinder" || inertia))
    fail(prefix + "rigid_length \"" + number_text(contact.rigid_length) + "\": " +
         (inertia ? "beside " + prefix + "rigid_inertia there is nothing for it to say"
                  : "`" + contact.primary + "` has none; allowed: with rigid_cylinder") +
         "; remove it");
  if (scenario.has_heat())
    fail(mass + "not available with heat; allowed: runs without; mesh the body, or prescribe its motion");
  if (scenario.contact_operator == ContactOperator::shell)
    fail("-contact_operator \"shell\": not with the rigid body of -contact_" + contact.id +
         "_rigid_mass; allowed: assembled, the default");
}

void check_contact_heat(const ContactScenario& contact, const Scenario& scenario) {
  const std::string prefix = "-contact_" + contact.id + "_";
  if (contact.conductance > 0 && !scenario.has_heat() && scenario.physics.empty())
    fail(prefix + "conductance \"" + number_text(contact.conductance) +
         "\": no material has a heat capacity; give -material_" + scenario.materials.front().law.id +
         "_c_v, or remove it");
  if (contact.conductance_exponent > 0 && contact.conductance_pressure == 0)
    fail(prefix + "conductance_pressure: missing; allowed: a pressure > 0; " + prefix +
         "conductance_exponent needs it");
  if (contact.temperature && !contact.rigid())
    fail(contact.temperature->key() + " \"" + contact.temperature->text() + "\": `" + contact.primary +
         "` is a boundary, whose temperature is solved for; allowed: with plane, rigid_sphere, "
         "rigid_cylinder as the primary");
  if (contact.rigid() && contact.conductance > 0 && !contact.temperature)
    fail(prefix + "temperature: missing; allowed: an expression of t; a rigid body that conducts needs one");
}

void check_impact_updates(const Scenario& scenario) {
  const auto taking = [&](ImpactUpdate update) {
    return std::find_if(scenario.contacts.begin(), scenario.contacts.end(),
                        [&](const ContactSettings& contact) { return contact.impact == update; });
  };
  const auto conserving = taking(ImpactUpdate::conserving), stabilised = taking(ImpactUpdate::stabilised);
  if (conserving != scenario.contacts.end() && stabilised != scenario.contacts.end())
    fail("-contact_" + stabilised->id +
         "_impact \"stabilised\": changes the integrator that the update of contact " + conserving->id +
         " conserves energy with; allowed beside conserving: conserving, none");
}

void check_split(const Scenario& scenario, const MaterialScenario& material) {
  const MaterialParameters& law = material.law;
  const std::string prefix = "-material_" + law.id + "_";
  if (law.split != Split::spectral) return;
  const std::string key = prefix + "split \"spectral\": ", remedy = "; choose volumetric";
  if (law.model == Model::j2)
    fail(key + "the return map wants one factor for the whole deviator, the split has two; allowed: " +
         prefix + "model elastic" + remedy);
  if (law.locking != Locking::none)
    fail(key + "not available with " + prefix +
         "locking, which shares the volume between points; allowed: none" + remedy);
  if (scenario.has_heat() && law.c_v != 0)
    fail(key + "the heat balance does not know its entropy; allowed: runs without heat" + remedy);
  if (scenario.plane == PlaneMode::stress)
    fail(key + "not available with -plane stress; allowed: strain, axisymmetric, or meshes in space" +
         remedy);
  if (3 * law.K < 2 * law.G)
    fail(key + "with nu < 0 its tensile part can be negative; allowed: nu >= 0" + remedy);
}

/// What a law of damage needs from the other options.
void check_damage(const Scenario& scenario) {
  if (!scenario.has_damage()) return;
  for (const MaterialScenario& material : scenario.materials) {
    const MaterialParameters& law = material.law;
    if (law.damage == Damage::none) continue;
    const std::string prefix = "-material_" + law.id + "_";
    check_split(scenario, material);
    const bool ductile = law.ge == Degradation::ductile, at1 = law.damage == Damage::at1;
    if ((at1 || ductile) && scenario.damage.bounds != DamageBounds::vi)
      fail("-damage_bounds: only the bounds of vi keep " + prefix +
           (at1 ? "damage at1 from damage below 0" : "ge ductile from damage above 1") + "; allowed: vi");
    if (ductile && law.model != Model::j2)
      fail(prefix + "ge \"ductile\": nothing damages without plastic strain; allowed with " + prefix +
           "model j2; choose quadratic or cubic");
    if (law.plastic_threshold > 0 && law.softening != Softening::none)
      fail(prefix + "plastic_threshold \"" + number_text(law.plastic_threshold) + "\": not available with " +
           prefix + "softening, whose plastic energy is a sum over the steps; allowed: 0, or softening none");
    if (law.plastic_threshold > 0 && law.gp != PlasticDegradation::ge)
      fail(prefix + "plastic_threshold \"" + number_text(law.plastic_threshold) +
           "\": has no effect, plastic energy drives damage only with " + prefix +
           "gp ge; add it, or remove this");
  }
}

std::string plane_name(PlaneMode plane) {
  return plane == PlaneMode::axisymmetric ? "axisymmetric" : plane == PlaneMode::stress ? "stress" : "strain";
}

void check_plane_stress(const Scenario& scenario) {
  if (scenario.plane != PlaneMode::stress) return;
  for (const MaterialScenario& material : scenario.materials)
    if (!material.locking_automatic && material.law.locking != Locking::none)
      fail("-material_" + material.law.id + "_locking \"" +
           (material.law.locking == Locking::mean ? "mean" : "fbar") +
           "\": has no meaning with -plane stress, where the volume is free; allowed: auto, none");
}

void check_checkpoints(const Scenario& scenario) {
  const CheckpointScenario& checkpoint = scenario.checkpoint;
  if (checkpoint.walltime > 0 && checkpoint.margin() >= checkpoint.walltime)
    fail("-walltime_margin \"" + number_text(checkpoint.walltime_margin) +
         "\": leaves nothing of the wall time; allowed: less than -walltime, " +
         number_text(checkpoint.walltime));
}

// Half of an unsymmetric matrix would be taken for all of it without a word.
void check_matrix(const Scenario& scenario) {
  if (scenario.matrix != MatrixFormat::sbaij) return;
  const auto refuse = [](const std::string& what, const std::string& allowed) {
    fail("-motion_mat_type \"sbaij\": needs a symmetric tangent, that of " + what +
         " is not; allowed: " + allowed + "choose -motion_mat_type aij");
  };
  if (const auto [what, allowed] = unsymmetric_force(scenario); !what.empty()) refuse(what, allowed + "; ");
  if (scenario.tangent == TangentChoice::symmetric) return;
  for (const MaterialScenario& material : scenario.materials) {
    const bool flows = material.law.model == Model::j2, fbar = material.law.locking == Locking::fbar;
    if (flows || fbar)
      refuse("-material_" + material.law.id + (flows ? "_model j2" : "_locking fbar"),
             "elastic materials without F-bar; add -motion_tangent symmetric, or ");
  }
}

// Fatigue drives phi beyond 1, where its energy has a kink.
void check_fatigue(const Scenario& scenario) {
  if (!any_fatigue(scenario)) return;
  const DamageBounds bounds = scenario.damage.bounds;
  if (bounds == DamageBounds::vi || bounds == DamageBounds::clip) return;
  for (const MaterialScenario& material : scenario.materials)
    if (material.law.fatigue_a > 0)
      fail(std::string("-damage_bounds \"") + (bounds == DamageBounds::none ? "none" : "history") +
           "\": lets the fatigue of -material_" + material.law.id +
           "_fatigue_a drive phi beyond 1; allowed with fatigue: vi, clip");
}

void check_outputs(const Scenario& scenario) {
  std::map<std::string, std::string> writer;
  for (const OutputScenario& output : scenario.outputs) {
    const std::string prefix = "-output_" + output.id + "_";
    if (output.cycles > 0 && scenario.time.period == 0)
      fail(prefix + "cycles \"" + std::to_string(output.cycles) +
           "\": counts the cycles of a load whose period is not given; add -ts_period, or remove it");
    const bool csv = output.type == OutputScenario::Type::csv;
    if (csv && !output.fields.empty())
      fail(prefix + "fields: has no meaning for type csv; the columns of the history are fixed, use -probes "
                    "and -measures");
    if (const auto [at, fresh] = writer.emplace(output.file, output.id); !fresh)
      fail(prefix + "file \"" + output.file + "\": is written by output " + at->second +
           " already; choose another name");
  }
}

std::string groups_text(const std::vector<Group>& groups) {
  std::string text;
  for (int dim = 3; dim >= 0; --dim) {
    std::string names;
    for (const Group& group : groups)
      if (group.dim == dim) names += (names.empty() ? "" : ", ") + group.name;
    if (!names.empty()) text += (text.empty() ? "" : "; ") + names + " (" + std::to_string(dim) + "D)";
  }
  return text.empty() ? "none" : text;
}

class GroupCheck {
public:
  GroupCheck(const std::vector<Group>& groups, int dim) : groups_(groups), dim_(dim) {}

  /// `dims`: allowed dimensions of the group; empty: any.
  void operator()(const std::string& key, const std::string& name, const std::vector<int>& dims) const {
    const Group* found = nullptr;
    for (const Group& group : groups_)
      if (group.name == name) found = &group;
    if (!found) data(key + " \"" + name + "\": no such physical group; mesh has: " + groups_text(groups_));
    if (dims.empty() || std::find(dims.begin(), dims.end(), found->dim) != dims.end()) return;
    data(key + " \"" + name + "\": is a group of dimension " + std::to_string(found->dim) +
         "; allowed: dimension " + std::to_string(dims.front()) + "; mesh has: " + groups_text(groups_));
  }

  void component(const std::optional<Expression>& third) const {
    if (dim_ == 2 && third)
      data(third->key() + " \"" + third->text() + "\": the mesh is plane; allowed: x and y components");
  }

  [[noreturn]] static void data(const std::string& message) { throw UserError(ExitCode::data, message); }

private:
  const std::vector<Group>& groups_;
  int dim_;
};

void check_obstacle_motion(const ContactScenario& contact, const Scenario& scenario, const GroupCheck& check,
                           int dim) {
  if (contact.carrier.empty()) return;
  check.component(contact.rigid_u[2]);
  for (std::size_t k = 0; k < 2; ++k)
    if (dim == 2 && contact.rigid_r[k])
      GroupCheck::data(contact.rigid_r[k]->key() + " \"" + contact.rigid_r[k]->text() +
                       "\": the mesh is plane; allowed: rz");
  const bool ring = scenario.plane == PlaneMode::axisymmetric,
             held = ring || (contact.primary == "plane" && std::isnan(contact.rigid_inertia));
  bool moves = false;
  for (std::size_t k = 0; k < 3; ++k) {
    if (k < static_cast<std::size_t>(dim)) moves = moves || !(contact.rigid_u[k] || (ring && k == 0));
    if (dim == 3 || k == 2) moves = moves || !(contact.rigid_r[k] || held);
  }
  if (!moves)
    fail("-contact_" + contact.id + "_rigid_mass \"" + number_text(contact.rigid_mass) +
         "\": the whole motion is prescribed, and nothing is left that a mass could change; allowed: leave a "
         "component of -contact_" +
         contact.id + "_rigid_u out, or the mass");
}

void check_condition_groups(const Scenario& scenario, const GroupCheck& check, int dim) {
  for (const BoundaryCondition& bc : scenario.bcs) {
    const bool surface = bc.type == BcType::traction || bc.type == BcType::pressure ||
                         bc.type == BcType::heat_flux || bc.type == BcType::convection;
    const bool volume = bc.type == BcType::body_force || bc.type == BcType::heat_source;
    for (const std::string& name : bc.on)
      check("-bc_" + bc.id + "_on", name,
            surface  ? std::vector<int>{dim - 1}
            : volume ? std::vector<int>{dim}
                     : std::vector<int>{});
    check.component(bc.component[2]);
    if (dim == 2)
      for (int k = 0; k < 2; ++k)
        if (bc.rotation[k])
          GroupCheck::data(bc.rotation[k]->key() + " \"" + bc.rotation[k]->text() +
                           "\": the mesh is plane; allowed: rz");
  }
  for (const InitialCondition& ic : scenario.ics) {
    for (const std::string& name : ic.on) check("-ic_" + ic.id + "_on", name, {});
    check.component(ic.u[2]);
    check.component(ic.v[2]);
  }
}

} // namespace

// Whether motion waits for what damage and heat make of its solution.
bool iterates(const Scenario& scenario) {
  return scenario.has_damage() ||
         (scenario.has_heat() &&
          std::any_of(scenario.materials.begin(), scenario.materials.end(), [](const auto& material) {
            return material.law.alpha_t != 0 || material.law.softening != Softening::none;
          }));
}

void complete(Scenario& scenario) {
  for (ContactScenario& contact : scenario.contacts)
    if (contact.rigid_mass > 0 && contact.rigid()) contact.carrier = "obstacle_" + contact.id;
  complete_time(scenario.time);
  if (scenario.coupling.max_it == 0) {
    scenario.coupling.follow_cracks = scenario.has_motion() && !scenario.has_inertia() && iterates(scenario);
    scenario.coupling.max_it = scenario.coupling.follow_cracks ? 200 : 1;
  }
  scenario.coupling.moves = scenario.has_motion();
  scenario.coupling.crack_level = scenario.crack_level;
  scenario.coupling.length_unit = scenario.units.length == -3 ? "mm" : "m";
  const auto& steps = scenario.time.table_dts;
  scenario.coupling.dt = steps.empty() ? scenario.time.dt : *std::max_element(steps.begin(), steps.end());
  if (scenario.checkpoint.wall < 0) scenario.checkpoint.wall = CheckpointScenario().wall;
  if (scenario.checkpoint.dir.empty()) scenario.checkpoint.dir = default_checkpoint_dir(scenario);
  for (OutputScenario& output : scenario.outputs) complete_output(output, scenario);
  for (ProbeScenario& probe : scenario.probes)
    if (probe.fields.empty()) probe.fields = {"u"};
  for (MeasureScenario& measure : scenario.measures)
    if (measure.fields.empty()) measure.fields = {"u"};
}

void check_scenario(const Scenario& scenario) {
  check_time(scenario.time);
  check_materials(scenario);
  if (scenario.dim == 3 && scenario.plane != PlaneMode::strain)
    fail("-plane \"" + plane_name(scenario.plane) +
         "\": the problem has three dimensions; allowed with -dim 2");
  check_plane_stress(scenario);
  for (const BoundaryCondition& bc : scenario.bcs) check_condition(bc);
  check_heat(scenario);
  check_substeps(scenario, "damage_ts_dt", scenario.damage.substep);
  check_substeps(scenario, "heat_ts_dt", scenario.heat.substep);
  for (const ContactScenario& contact : scenario.contacts) {
    check_contact(contact);
    check_obstacle(contact, scenario);
    check_contact_heat(contact, scenario);
  }
  check_impact_updates(scenario);
  check_damage(scenario);
  check_checkpoints(scenario);
  check_matrix(scenario);
  check_fatigue(scenario);
  check_outputs(scenario);
}

void check_groups(const Scenario& scenario, const std::vector<Group>& groups, int dim) {
  if (scenario.dim != 0 && scenario.dim != dim)
    GroupCheck::data("-dim \"" + std::to_string(scenario.dim) + "\": the mesh has dimension " +
                     std::to_string(dim) + "; allowed: its dimension, or leave it out");
  if (dim == 3 && scenario.plane != PlaneMode::strain)
    GroupCheck::data("-plane \"" + plane_name(scenario.plane) +
                     "\": the mesh has dimension 3; allowed: plane meshes");
  const GroupCheck check(groups, dim);
  for (const MaterialScenario& material : scenario.materials)
    for (const std::string& region : material.regions)
      check("-material_" + material.law.id + "_region", region, {dim});
  check_condition_groups(scenario, check, dim);
  for (const ContactScenario& contact : scenario.contacts) {
    check_obstacle_motion(contact, scenario, check, dim);
    check("-contact_" + contact.id + "_secondary", contact.secondary, {dim - 1});
    if (!contact.rigid()) check("-contact_" + contact.id + "_primary", contact.primary, {dim - 1});
  }
  for (const ProbeScenario& probe : scenario.probes)
    if (!probe.region.empty()) check("-probe_" + probe.id + "_on", probe.region, {dim});
  for (const MeasureScenario& measure : scenario.measures)
    check("-measure_" + measure.id + "_on", measure.on, {});
}

} // namespace impact
