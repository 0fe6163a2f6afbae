#include <algorithm>
#include <cmath>
#include <impact/contact/edge_points.hpp>
#include <impact/contact/facet_parts.hpp>
#include <impact/contact/interface.hpp>
#include <impact/contact/mortar_form.hpp>
#include <impact/contact/ray_points.hpp>
#include <impact/contact/resolve_settings.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <map>

/// Construction of a ContactInterface and the overlap at the start.
namespace impact {

namespace {

bool has_wide_triangles(const ContactSurface& surface) {
  const std::size_t width = at(surface.per_facet);
  bool any = false;
  for (std::size_t first = 0; first < surface.node.size(); first += width)
    any = any || is_wide_triangle(surface.per_facet, &surface.node[first]);
  return any;
}

// Gauss points of second order have one kind of facet.
void refuse_mixed_surfaces(const FormRequest& request) {
  const ContactSettings& settings = request.settings;
  throw_first(request.mesh.comm(), ExitCode::data,
              has_wide_triangles(request.secondary) || has_wide_triangles(request.primary)
                  ? "contact " + settings.id +
                        ": Gauss points on triangles of second order in a mesh that has "
                        "hexahedra too are not available; allowed: -contact_" +
                        settings.id + "_method mortar, or cells of first order (-order 1, gmsh -order 1)"
                  : "");
}

std::unique_ptr<ContactForm> make_form(const FormRequest& request) {
  if (request.settings.method == ContactMethod::mortar) return std::make_unique<MortarForm>(request);
  refuse_mixed_surfaces(request);
  return stored_nodes(request.mesh) == 2 ? make_edge_point_form(request) : make_ray_point_form(request);
}

std::vector<int> numbers_at_start(const FacetTable& then, const FacetTable& now) {
  std::map<PetscInt, int> number;
  for (int f = 0; f < then.count(); ++f) number[then.point[at(f)]] = f;
  std::vector<int> numbers;
  for (const PetscInt facet : now.point) {
    const auto found = number.find(facet);
    numbers.push_back(found == number.end() ? -1 : found->second);
  }
  return numbers;
}

// Of constraints, which are their facets' in their order, the numbers that they had at the start; -1: their
// facet came free.
std::vector<int> places_at_start(const std::vector<int>& facets, std::size_t constraints) {
  std::vector<int> place;
  const int of_facet = facets.empty() ? 0 : static_cast<int>(constraints / facets.size());
  for (const int facet : facets)
    for (int q = 0; q < of_facet; ++q) place.push_back(facet < 0 ? -1 : of_facet * facet + q);
  return place;
}

} // namespace

ContactInterface::ContactInterface(const Mesh& mesh, const FieldLayout& displacement,
                                   const ContactSettings& settings, const ContactEnvironment& environment,
                                   StateTable& state)
    : mesh_(&mesh), layout_(&displacement), state_(&state), environment_(environment) {
  ContactSurface secondary = make_surface(mesh, settings.id, settings.secondary), primary;
  if (!settings.rigid()) primary = make_surface(mesh, settings.id, settings.primary);
  ResolvedSettings resolved = resolve_settings(mesh, settings, environment, secondary, primary);
  settings_ = std::move(resolved.settings);
  warnings_ = std::move(resolved.warnings);
  outward_ = pole_of(settings_, mesh, secondary);
  mean_length_ = resolved.mean_length;
  make_constraints(std::move(secondary), primary);
  declare_state(state);
  method_ = make_enforcement(settings_, rows_, constraints_->conserving());
  fallback_ = method_->fallback();
  if (method_->has_multipliers()) inertia_penalty_ = resolved.inertia_penalty;
  use_method();
  place_obstacle();
  const Handle<Vec> at_rest = displacement.make_global();
  update_search(at_rest);
}

void ContactInterface::make_constraints(ContactSurface secondary, const ContactSurface& primary) {
  constraints_.emplace(*mesh_, *layout_,
                       make_form({*mesh_, *layout_, settings_, environment_.frame, std::move(secondary),
                                  primary, std::min(settings_.gap_tol, 1e-3 * mean_length_)}),
                       mean_length_, frictional());
}

void ContactInterface::place_obstacle() {
  ContactForm& form = constraints_->form();
  if (!settings_.carrier.empty()) form.carry(Obstacle(*mesh_, settings_.carrier, pose().obstacle));
  form.begin_attempt(pose(), nullptr);
}

FacetTable ContactInterface::facets(const std::string& side) const {
  const auto found = live_.find(side);
  return found == live_.end() ? mesh_->facets(side) : found->second.facets;
}

void ContactInterface::expose(const std::vector<char>& eroded, Vec u) {
  ContactSurface sides[2];
  for (const bool primary : {false, true}) {
    const std::string& name = primary ? settings_.primary : settings_.secondary;
    if (ContactSettings::rigid_name(name)) continue;
    LiveSide& side = live_[name];
    if (side.body.empty()) side.body = nodes_of_bodies(*mesh_, mesh_->nodes(name));
    side.facets = mesh_->live_facets(name, eroded, side.body);
    ContactSurface& surface = sides[primary ? 1 : 0] = surface_of(*mesh_, name, side.facets);
    surface.at_start = numbers_at_start(mesh_->facets(name), side.facets);
  }
  const double way = constraints_->form().way();
  settings_.exposed = true;
  Handle<Vec> fixed = constraints_->release_fixed();
  SurfaceRow left = constraints_->release_left();
  const std::vector<int> facets = sides[0].at_start;
  make_constraints(std::move(sides[0]), sides[1]);
  const std::size_t points = constraints_->form().constraint_row("", 1).second;
  constraints_->declare(points, false, nullptr);
  constraints_->take_fixed(std::move(fixed));
  use_method();
  place_obstacle();
  constraints_->form().keep_way(way);
  update_search(u);
  const std::vector<int> place = places_at_start(facets, points);
  if (left) left.change_surface(place);
  constraints_->leave_jumps(std::move(left));
  if (!frictional()) return;
  friction_.change_surface(place);
  constraints_->form().anchor(u);
}

void ContactInterface::declare_state(StateTable& state) {
  const std::string name = "contact_" + settings_.id + "_";
  const auto add = [&](const std::string& what, int components) {
    const auto [values, count] = constraints_->form().constraint_row(name + what, components);
    return &state.add(values, count);
  };
  const auto add_global = [&](const std::string& what, int components) {
    return &state.add(StateRow{name + what, Support::global, components}, at(components));
  };
  const int dim = mesh_->dim();
  rows_.multiplier = add("multiplier", 1);
  if (frictional()) friction_ = Friction(settings_.friction, *add("traction", dim - 1), *add("slip", dim));
  StateRow* gap = nullptr;
  if (settings_.impact == ImpactUpdate::conserving && environment_.density > 0) {
    gap = add("gap", 1);
    for (std::vector<double>* half : {&gap->committed, &gap->trial})
      std::fill(half->begin(), half->end(), unknown_gap);
  }
  constraints_->declare(rows_.multiplier->trial.size(), rows_.multiplier->support == Support::vertex, gap);
  if (!settings_.rigid()) {
    StateRow* const left = add("left", 2);
    if (!settings_.iterated) constraints_->leave_jumps(SurfaceRow(*left));
  }
  rows_.penalty = add_global("penalty", EnforcementRows::components);
  totals_ = add_global("totals", 3 * dim + 4 + (gap != nullptr ? 1 : 0) + (frictional() ? 1 : 0));
  for (const auto& [row, what] : {std::pair(&force_, "force"), std::pair(&carried_, "carried")})
    *row = &state.add(StateRow{name + what, Support::vertex, dim}, at(dim * mesh_->node_count()));
  force_->rewritten = carried_->rewritten = !settings_.iterated;
  rows_.penalty->committed[EnforcementRows::value] = rows_.penalty->trial[EnforcementRows::value] =
      settings_.penalty;
  put_obstacle(0);
}

void ContactInterface::put_obstacle(double t) {
  const Vector place = rigid_displacement(settings_, mesh_->dim(), t);
  for (std::vector<double>* half : {&totals_->committed, &totals_->trial})
    std::copy(place.begin(), place.end(), totals(*half).obstacle);
}

void ContactInterface::begin_at(double t, Vec u) {
  put_obstacle(t);
  const double overlap = -reach(u).gap;
  if (overlap <= settings_.initial_tol || settings_.initial == InitialOverlap::allow) return;
  throw UserError(
      ExitCode::data,
      "contact " + settings_.id + ": `" + settings_.secondary + "` overlaps `" + settings_.primary + "` by " +
          contact_number(overlap) +
          " where it begins; an obstacle that is led begins where its data say at the time of the "
          "restart; part the bodies, or use -contact_" +
          settings_.id + "_initial allow");
}

ContactInterface::Totals ContactInterface::totals(std::vector<double>& half) const {
  const auto d = at(mesh_->dim());
  double* row = half.data();
  return {row, row + d, row + d + 1, row + 2 * d + 1, row + 3 * d + 1, row + 3 * d + 4, &half.back()};
}

// Where bodies of second order overlap their curved facets tell, as Gauss points see them: the straight parts
// in which mortar integrates leave these by h^2/24R. Null where they are of both kinds.
std::unique_ptr<ContactForm> ContactInterface::curved_form(Vec at_rest) const {
  if (mesh_->order() != 2 || settings_.method != ContactMethod::mortar) return nullptr;
  ContactSurface secondary = surface_of(*mesh_, settings_.secondary, facets(settings_.secondary)), primary;
  if (!settings_.rigid()) primary = surface_of(*mesh_, settings_.primary, facets(settings_.primary));
  if (!all_ranks_agree(mesh_->comm(), !has_wide_triangles(secondary) && !has_wide_triangles(primary)))
    return nullptr;
  ContactSettings settings = settings_;
  settings.method = ContactMethod::gauss_points;
  settings.friction = 0;
  std::unique_ptr<ContactForm> form =
      make_form({*mesh_, *layout_, settings, environment_.frame, std::move(secondary), primary, 0});
  if (!settings.carrier.empty()) form->carry(Obstacle(*mesh_, settings.carrier, pose().obstacle));
  form->begin_attempt(pose(), nullptr);
  form->update(at_rest, [](int, double) { return false; });
  return form;
}

InitialOverlapReport ContactInterface::initial_overlap() {
  const Handle<Vec> at_rest = layout_->make_global();
  update_search(at_rest);
  const std::unique_ptr<ContactForm> curved = curved_form(at_rest);
  const ContactForm& form = curved ? *curved : constraints_->form();
  const ContactNodes& nodes = form.nodes();
  InitialOverlapReport report;
  const auto d = at(mesh_->dim());
  std::vector<double> shift(d * nodes.global.size(), 0.0), count(shift.size(), 0.0);
  struct {
    double depth = 0;
    std::array<double, 3> where{};
  } deepest;
  form.visit_overlaps(nodes.X, [&](int node, double depth, const std::array<double, 3>& direction) {
    if (depth > deepest.depth) {
      deepest.depth = depth;
      std::copy_n(&nodes.X[d * at(node)], d, deepest.where.begin());
    }
    for (std::size_t k = 0; k < d; ++k) shift[d * at(node) + k] += depth * direction[k];
    count[d * at(node)] += 1;
  });
  deepest = of_least(mesh_->comm(), -deepest.depth, deepest);
  const std::array<double, 3>& where = deepest.where;
  report.deepest = deepest.depth;
  report.shift = layout_->make_local();
  // Facets of second order follow a round surface to some 1e-5 of their length: less than the tolerance is
  // theirs.
  const bool refuses = settings_.initial == InitialOverlap::error,
             forbidden = settings_.initial != InitialOverlap::allow &&
                         (report.deepest > settings_.initial_tol || (refuses && mesh_->order() == 1));
  if (report.deepest > 0 && forbidden)
    throw UserError(
        ExitCode::data,
        "contact " + settings_.id + ": `" + settings_.secondary + "` overlaps `" + settings_.primary +
            "` by " + contact_number(report.deepest) + " at (" + contact_number(where[0]) + ", " +
            contact_number(where[1]) + (mesh_->dim() == 3 ? ", " + contact_number(where[2]) : "") +
            "); part the bodies, or use -contact_" + settings_.id + "_initial adjust" +
            (report.deepest > settings_.initial_tol
                 ? " with a larger _initial_tol (now " + contact_number(settings_.initial_tol) + ")"
                 : "") +
            ", or allow");
  if (settings_.initial != InitialOverlap::adjust) return report;
  // All facets at a node, on any ranks, have their say; the node takes the mean.
  const Handle<Vec> total = layout_->make_global(), facets = layout_->make_global();
  nodes.exchange.add(shift, total);
  nodes.exchange.add(count, facets);
  std::vector<double> said = layout_->make_local();
  layout_->to_local(total, report.shift);
  layout_->to_local(facets, said);
  int moved = 0;
  for (int node = 0; node < mesh_->node_count(); ++node) {
    if (said[d * at(node)] == 0) continue;
    if (mesh_->owned(node)) ++moved;
    for (std::size_t k = 0; k < d; ++k) report.shift[d * at(node) + k] /= said[d * at(node)];
  }
  report.nodes = sum_over_ranks(mesh_->comm(), moved);
  return report;
}

} // namespace impact
