#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/contact/interface.hpp>
#include <impact/petsc/error.hpp>
#include <limits>

/// Construction of a ContactInterface and the overlap at the start.
namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
bool automatic(double value) { return std::isnan(value); }

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

UserError usage(const ContactSettings& settings, const std::string& key, const std::string& text) {
  return UserError(ExitCode::usage, "-contact_" + settings.id + "_" + key + ": " + text);
}

void check_settings(ContactSettings& settings) {
  if (settings.secondary == settings.primary)
    throw usage(settings, "primary",
                "`" + settings.primary + "` is also the secondary surface; name two different groups");
  if (settings.primary != "plane") return;
  double* n = settings.plane_normal;
  const double length = std::hypot(n[0], n[1]);
  if (!(length > 0))
    throw usage(settings, "plane_normal",
                "has no length in the plane of the mesh; give x,y of the outward normal");
  n[0] /= length;
  n[1] /= length;
}

void require_positive(const ContactSettings& settings, const std::string& key, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw usage(settings, key, number(value) + " is not a positive number");
}

} // namespace

ContactInterface::ContactInterface(const Mesh& mesh, const FieldLayout& displacement,
                                   const ContactSettings& settings, const ContactEnvironment& environment,
                                   StateTable& state)
    : mesh_(&mesh), layout_(&displacement), state_(&state), settings_(settings), environment_(environment) {
  check_settings(settings_);
  secondary_.surface = make_surface(mesh, settings_.id, settings_.secondary);
  if (!against_plane()) {
    primary_.surface = make_surface(mesh, settings_.id, settings_.primary);
    primary_.neighbour = surface_neighbours(displacement, primary_.surface);
  }
  points_ = make_points(secondary_.surface, settings_.id, settings_.points, environment_.frame);
  set_automatic_values();
  holds_.assign(points_.weight.size(), Hold());
  declare_state(state);
  build_search_nodes();
  const Handle<Vec> at_rest = displacement.make_global();
  update_search(at_rest);
}

void ContactInterface::set_automatic_values() {
  std::array<double, 3> longest = {0, 0, -1e300},
                        sum = {0, 0, 0}; // secondary, primary, minus the shortest primary
  for (double length : secondary_.surface.length) {
    longest[0] = std::max(longest[0], length);
    sum[0] += length;
    sum[1] += 1;
  }
  for (double length : primary_.surface.length) {
    longest[1] = std::max(longest[1], length);
    longest[2] = std::max(longest[2], -length);
  }
  MPI_Allreduce(MPI_IN_PLACE, longest.data(), 3, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  const double h = sum[0] / sum[1];
  const double spacing = longest[0] / settings_.points;
  if (!against_plane() && -longest[2] < spacing * (1 - 1e-9))
    warnings_.push_back(
        "contact " + settings_.id + ": a facet of the primary surface `" + settings_.primary + "` (" +
        number(-longest[2]) + ") is shorter than the spacing of the points on the secondary surface `" +
        settings_.secondary + "` (" + number(spacing) +
        "), so it may slip between them; swap the surfaces or raise -contact_" + settings_.id + "_points");

  auto fill = [](double& value, double by) {
    if (automatic(value)) value = by;
  };
  const double size = environment_.length > 0 ? environment_.length : h;
  const double penalty = 10 * environment_.modulus / size;
  // Augmentations shrink the gap by k/(k + eps), k the stiffness against moving the surface. Steps far
  // shorter than a wave needs through a cell meet the cell's mass rather than its modulus: k about rho h/3
  // mass_shift.
  if (automatic(settings_.penalty) && settings_.enforce == Enforcement::auglag)
    inertia_penalty_ = 2.5 * environment_.density * size;
  if (automatic(settings_.penalty) && !(penalty > 0))
    throw usage(settings_, "penalty", "auto needs Young's modulus of a side; give a number");
  fill(settings_.penalty, penalty);
  fill(settings_.penalty_increment, settings_.penalty);
  fill(settings_.penalty_max, 1e4 * (penalty > 0 ? penalty : settings_.penalty));
  fill(settings_.gap_tol, 1e-3 * h);
  fill(settings_.initial_tol, 1e-3 * h);
  fill(settings_.search_radius, 2 * std::max(longest[0], longest[1]));
  require_positive(settings_, "penalty", settings_.penalty);
  require_positive(settings_, "penalty_increment", settings_.penalty_increment);
  require_positive(settings_, "penalty_max", settings_.penalty_max);
  require_positive(settings_, "gap_tol", settings_.gap_tol);
  require_positive(settings_, "pressure_tol", settings_.pressure_tol);
  require_positive(settings_, "search_radius", settings_.search_radius);
  search_.radius = search_.reach = settings_.search_radius;
  search_.skin = settings_.search_radius / 2;
  hold_gap_ = std::min(settings_.gap_tol, 1e-3 * h);
}

void ContactInterface::declare_state(StateTable& state) {
  const std::string name = "contact_" + settings_.id;
  auto row = [&](const std::string& what, Support support, int components, const std::string& surface) {
    StateRow r;
    r.name = name + "_" + what;
    r.support = support;
    r.components = components;
    r.surface = surface;
    return r;
  };
  multiplier_ =
      &state.add(row("multiplier", Support::facet_point, 1, settings_.secondary), points_.weight.size());
  // Penalty, gap of the last augmentation, least penalty beside the inertia of the attempt.
  penalty_ = &state.add(row("penalty", Support::global, 3, ""), 3);
  totals_ = &state.add(row("totals", Support::global, 5, ""), 5); // impulse x y, work, last force x y
  force_ = &state.add(row("force", Support::vertex, 2, ""), at(2 * mesh_->node_count()));
  penalty_->committed[0] = penalty_->trial[0] = settings_.penalty;
}

void ContactInterface::build_search_nodes() {
  std::vector<PetscInt>& nodes = search_.own_nodes;
  nodes = secondary_.surface.node;
  nodes.insert(nodes.end(), primary_.surface.node.begin(), primary_.surface.node.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  search_.own_X.resize(2 * nodes.size());
  for (Side* side : {&secondary_, &primary_})
    for (std::size_t i = 0; i < side->surface.node.size(); ++i) {
      const auto place = std::lower_bound(nodes.begin(), nodes.end(), side->surface.node[i]) - nodes.begin();
      side->slot.push_back(static_cast<int>(place));
      for (std::size_t k = 0; k < 2; ++k)
        search_.own_X[2 * static_cast<std::size_t>(place) + k] = side->surface.X[2 * i + k];
    }
  search_.own = NodeExchange(mesh_->comm(), mesh_->owned_node_count(), 2, nodes);
}

InitialOverlapReport ContactInterface::initial_overlap() {
  const Handle<Vec> at_rest = layout_->make_global();
  update_search(at_rest);
  const std::vector<double> x = current(at_rest);
  InitialOverlapReport report;
  report.shift = layout_->make_local();
  std::vector<double> count = layout_->make_local();
  struct {
    double depth = 0;
    int rank = 0;
  } mine, deepest;
  MPI_Comm_rank(mesh_->comm(), &mine.rank);
  Point2<double> where = {0, 0};
  for (int f = 0; f < secondary_.surface.count(); ++f)
    for (int a = 0; a < 2; ++a) {
      const int* ends = &active_.secondary[at(2 * f)];
      auto place = [&](int node) { return Point2<double>{x[at(2 * node)], x[at(2 * node + 1)]}; };
      ContactPoint point;
      point.facet = f;
      if (!face(place(ends[a]), detail::right_normal(place(ends[0]), place(ends[1])), x, Hold(), point))
        continue;
      const double depth = -point.foot.gap;
      // Coordinates that were meant to touch differ by rounding of their own size.
      if (!(depth >
            1e-9 * (secondary_.surface.length[at(f)] + std::hypot(place(ends[a])[0], place(ends[a])[1]))))
        continue;
      if (depth > mine.depth) {
        mine.depth = depth;
        where = place(ends[a]);
      }
      for (int k = 0; k < 2; ++k) {
        report.shift[at(2 * secondary_.surface.local[at(2 * f + a)] + k)] += depth * point.foot.normal[at(k)];
        count[at(2 * secondary_.surface.local[at(2 * f + a)] + k)] += 1;
      }
    }
  MPI_Allreduce(&mine, &deepest, 1, MPI_DOUBLE_INT, MPI_MAXLOC, mesh_->comm());
  MPI_Bcast(where.data(), 2, MPI_DOUBLE, deepest.rank, mesh_->comm());
  report.deepest = deepest.depth;
  const bool forbidden =
      settings_.initial == InitialOverlap::error ||
      (settings_.initial == InitialOverlap::adjust && report.deepest > settings_.initial_tol);
  if (report.deepest > 0 && forbidden)
    throw UserError(ExitCode::data, "contact " + settings_.id + ": `" + settings_.secondary + "` overlaps `" +
                                        settings_.primary + "` by " + number(report.deepest) + " at (" +
                                        number(where[0]) + ", " + number(where[1]) +
                                        "); part the bodies, or use -contact_" + settings_.id +
                                        "_initial adjust with a larger _initial_tol (now " +
                                        number(settings_.initial_tol) + "), or allow");
  if (settings_.initial != InitialOverlap::adjust) {
    std::fill(report.shift.begin(), report.shift.end(), 0.0);
    return report;
  }
  // Both edges at a node, on any ranks, have their say; the node takes the mean.
  const Handle<Vec> total = layout_->make_global(), edges = layout_->make_global();
  layout_->add_to_global(report.shift, total);
  layout_->add_to_global(count, edges);
  layout_->to_local(total, report.shift);
  layout_->to_local(edges, count);
  int moved = 0;
  for (int node = 0; node < mesh_->node_count(); ++node) {
    if (count[at(2 * node)] == 0) continue;
    if (mesh_->owned(node)) ++moved;
    for (int k = 0; k < 2; ++k) report.shift[at(2 * node + k)] /= count[at(2 * node)];
  }
  MPI_Allreduce(&moved, &report.nodes, 1, MPI_INT, MPI_SUM, mesh_->comm());
  return report;
}

} // namespace impact
