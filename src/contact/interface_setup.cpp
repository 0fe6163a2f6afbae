#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/contact/face_point_form.hpp>
#include <impact/contact/gauss_point_form.hpp>
#include <impact/contact/interface.hpp>
#include <impact/contact/mortar_form.hpp>
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

// What is to be said of sides that share nodes: they meet across a notch, never around its outer corner.
// Empty where they do not.
std::string adjoining(const Mesh& mesh, const ContactSettings& settings) {
  if (settings.rigid() || settings.primary == settings.secondary) return "";
  std::vector<int> a = mesh.nodes(settings.secondary), b = mesh.nodes(settings.primary), common;
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  std::erase_if(common, [&](int node) { return !mesh.owned(node); });
  std::array<int, 2> mine = {0, static_cast<int>(common.size())}; // rank, nodes
  int count = 0, first = 0;
  std::array<double, 3> x{};
  MPI_Comm_rank(mesh.comm(), &mine[0]);
  if (common.empty()) mine[0] = std::numeric_limits<int>::max();
  MPI_Allreduce(&mine[0], &first, 1, MPI_INT, MPI_MIN, mesh.comm());
  MPI_Allreduce(&mine[1], &count, 1, MPI_INT, MPI_SUM, mesh.comm());
  if (count == 0) return "";
  if (!common.empty()) std::copy_n(&mesh.coordinates()[at(mesh.dim() * common[0])], mesh.dim(), x.begin());
  MPI_Bcast(x.data(), 3, MPI_DOUBLE, first, mesh.comm());
  return "contact " + settings.id + ": `" + settings.secondary + "` and `" + settings.primary +
         "` adjoin on one body: they share " + std::to_string(count) + (count == 1 ? " node" : " nodes") +
         ", at (" + number(x[0]) + ", " + number(x[1]) + (mesh.dim() == 3 ? ", " + number(x[2]) : "") +
         "); facets that share a node or have the body between them are no pairs, and -contact_" +
         settings.id + "_method auto is gpts. Are these two bodies? Give each its own nodes there";
}

void check_settings(ContactSettings& settings, int dim, bool adjoin) {
  // At the root of a notch a node of the mortar method sees a part of its facets alone, which comes and goes:
  // Newton's method cycles.
  if (settings.method == ContactMethod::automatic)
    settings.method = adjoin ? ContactMethod::gauss_points : ContactMethod::mortar;
  const bool mortar = settings.method == ContactMethod::mortar;
  if (mortar && settings.points > 0)
    throw usage(settings, "points",
                "Gauss points are for the method gpts, here it is mortar; take -contact_" + settings.id +
                    "_method gpts, or remove it");
  if (!mortar && settings.multipliers != MultiplierSpace::automatic)
    throw usage(settings, "multipliers",
                "shape functions are for the method mortar, here it is gpts; take -contact_" + settings.id +
                    "_method mortar, or remove it");
  if (settings.points == 0) settings.points = 2;
  if (settings.multipliers == MultiplierSpace::automatic)
    settings.multipliers = dim == 2 ? MultiplierSpace::standard : MultiplierSpace::dual;
  if (settings.impact == ImpactUpdate::conserving) {
    if (settings.enforce != Enforcement::automatic && settings.enforce != Enforcement::penalty)
      throw usage(settings, "impact",
                  "`conserving` is for the penalty; take -contact_" + settings.id +
                      "_enforce penalty, or stabilised with multipliers");
    settings.enforce = Enforcement::penalty;
  }
  if (settings.enforce == Enforcement::automatic)
    settings.enforce = mortar ? Enforcement::semismooth : Enforcement::auglag;
  if (!settings.rigid()) return;
  const bool plane = settings.primary == "plane";
  if (settings.friction > 0 && !plane && !mortar && dim == 2)
    throw usage(settings, "friction",
                "on a round rigid body in the plane is for the method mortar; here it is gpts");
  double* n = plane ? settings.plane_normal : settings.axis;
  if (dim == 2) n[2] = plane ? 0 : 1;
  if (dim == 2 && !plane) n[0] = n[1] = 0;
  const double length = std::hypot(n[0], n[1], n[2]);
  if (!(length > 0) || !std::isfinite(length))
    throw usage(settings, plane ? "plane_normal" : "axis", "has no length in the space of the mesh");
  for (int k = 0; k < 3; ++k) n[k] /= length;
  if (!plane && !(settings.radius > 0))
    throw usage(settings, "radius", "is missing: a rigid sphere or cylinder needs one");
}

void require_positive(const ContactSettings& settings, const std::string& key, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw usage(settings, key, number(value) + " is not a positive number");
}

} // namespace

ContactInterface::ContactInterface(const Mesh& mesh, const FieldLayout& displacement,
                                   const ContactSettings& settings, const ContactEnvironment& environment,
                                   StateTable& state)
    : mesh_(&mesh), layout_(&displacement), state_(&state), settings_(settings), environment_(environment),
      dim_(mesh.dim()) {
  ContactSurface secondary = make_surface(mesh, settings_.id, settings_.secondary), primary;
  if (!settings_.rigid()) primary = make_surface(mesh, settings_.id, settings_.primary);
  if (const std::string text = adjoining(mesh, settings_); !text.empty()) warnings_.push_back(text);
  check_settings(settings_, dim_, !warnings_.empty());
  set_automatic_values(secondary, primary);
  find_pole(secondary);
  if (settings_.method == ContactMethod::mortar)
    form_ = std::make_unique<MortarForm>(mesh, displacement, settings_, environment_.frame,
                                         std::move(secondary), primary);
  else if (const double hold_gap = std::min(settings_.gap_tol, 1e-3 * mean_length_); dim_ == 2)
    form_ = std::make_unique<GaussPointForm>(mesh, displacement, settings_, environment_.frame,
                                             std::move(secondary), primary, hold_gap);
  else
    form_ = std::make_unique<FacePointForm>(mesh, displacement, settings_, std::move(secondary), primary,
                                            hold_gap);
  declare_state(state);
  if (!settings_.carrier.empty()) form_->carry(ObstacleCarrier(mesh, settings_.carrier, pose_at(0).obstacle));
  form_->begin_attempt(pose_at(0), nullptr);
  const Handle<Vec> at_rest = displacement.make_global();
  update_search(at_rest);
}

void ContactInterface::set_automatic_values(const ContactSurface& secondary, const ContactSurface& primary) {
  std::array<double, 3> longest = {0, 0, -1e300},
                        sum = {0, 0, 0}; // secondary, primary, minus the shortest primary
  for (double length : secondary.length) {
    longest[0] = std::max(longest[0], length);
    sum[0] += length;
    sum[1] += 1;
  }
  for (double length : primary.length) {
    longest[1] = std::max(longest[1], length);
    longest[2] = std::max(longest[2], -length);
  }
  MPI_Allreduce(MPI_IN_PLACE, longest.data(), 3, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  const double h = sum[0] / sum[1];
  const double spacing = longest[0] / settings_.points;
  if (!settings_.rigid() && settings_.method == ContactMethod::gauss_points &&
      -longest[2] < spacing * (1 - 1e-9))
    warnings_.push_back("contact " + settings_.id + ": a facet of the primary surface `" + settings_.primary +
                        "` (" + number(-longest[2]) +
                        ") is shorter than the spacing of the points on the secondary surface `" +
                        settings_.secondary + "` (" + number(spacing) + "), so it may slip between them; " +
                        (settings_.primary == settings_.secondary ? "" : "swap the surfaces or ") +
                        "raise -contact_" + settings_.id + "_points");

  auto fill = [](double& value, double by) {
    if (automatic(value)) value = by;
  };
  const double size = environment_.length > 0 ? environment_.length : h;
  const double penalty = 10 * environment_.modulus / size;
  // Augmentations shrink the gap by k/(k + eps), k the stiffness against moving the surface. Steps far
  // shorter than a wave needs through a cell meet the cell's mass rather than its modulus: k about rho h/3
  // mass_shift.
  if (automatic(settings_.penalty) && settings_.enforce != Enforcement::penalty)
    inertia_penalty_ = 2.5 * environment_.density * size;
  if (automatic(settings_.penalty) && !(penalty > 0))
    throw usage(settings_, "penalty", "auto needs Young's modulus of a side; give a number");
  fill(settings_.penalty, penalty);
  // A start below the automatic one is made up for at once: four times that leaves a fifth of the gap where
  // the surface is as stiff as the penalty.
  fill(settings_.penalty_increment, settings_.penalty < penalty ? 4 * penalty : settings_.penalty);
  fill(settings_.penalty_max, 1e4 * (penalty > 0 ? penalty : settings_.penalty));
  fill(settings_.gap_tol, 1e-3 * h);
  fill(settings_.initial_tol, 1e-3 * h);
  settings_.local_search = automatic(settings_.search_radius);
  fill(settings_.search_radius, 2 * std::max(longest[0], longest[1]));
  require_positive(settings_, "penalty", settings_.penalty);
  require_positive(settings_, "penalty_increment", settings_.penalty_increment);
  require_positive(settings_, "penalty_max", settings_.penalty_max);
  require_positive(settings_, "gap_tol", settings_.gap_tol);
  require_positive(settings_, "pressure_tol", settings_.pressure_tol);
  require_positive(settings_, "search_radius", settings_.search_radius);
  if (!(settings_.friction >= 0) || !std::isfinite(settings_.friction))
    throw usage(settings_, "friction", number(settings_.friction) + " is negative or not a number");
  mean_length_ = h;
}

void ContactInterface::find_pole(const ContactSurface& secondary) {
  if (!settings_.rigid() || settings_.primary == "plane") return;
  // Towards the middle of the secondary side, in few digits: the same on any number of ranks.
  std::array<double, 4> sum{};
  const auto d = at(dim_);
  for (std::size_t i = 0; i < secondary.X.size(); ++i) sum[i % d] += secondary.X[i];
  sum[3] = static_cast<double>(secondary.X.size() / d);
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 4, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  std::array<double, 3> way{};
  double along = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    way[k] = sum[k] / sum[3] - settings_.centre[k];
    along += way[k] * settings_.axis[k];
  }
  if (settings_.primary == "rigid_cylinder")
    for (std::size_t k = 0; k < 3; ++k) way[k] -= along * settings_.axis[k];
  if (dim_ == 2) way[2] = 0;
  const double length = std::hypot(way[0], way[1], way[2]);
  if (!(length > 1e-3 * settings_.radius)) return;
  for (double& component : way) component = std::round(1024 * component / length);
  const double rounded = std::hypot(way[0], way[1], way[2]);
  for (std::size_t k = 0; k < 3; ++k) outward_[k] = way[k] / rounded;
  if (settings_.primary != "rigid_cylinder") return;
  // Across the axis to rounding.
  along = outward_[0] * settings_.axis[0] + outward_[1] * settings_.axis[1] + outward_[2] * settings_.axis[2];
  for (std::size_t k = 0; k < 3; ++k) outward_[k] -= along * settings_.axis[k];
  const double across = std::hypot(outward_[0], outward_[1], outward_[2]);
  for (double& component : outward_) component /= across;
}

void ContactInterface::declare_state(StateTable& state) {
  const std::string name = "contact_" + settings_.id;
  auto row = [&](const std::string& what, Support support, int components) {
    return StateRow{name + "_" + what, support, components};
  };
  const auto add = [&](const std::string& what, int components) {
    const auto [values, count] = form_->constraint_row(name + "_" + what, components);
    return &state.add(values, count);
  };
  multiplier_ = add("multiplier", 1);
  traction_ = frictional() ? add("traction", dim_ - 1) : nullptr;
  slip_ = frictional() ? add("slip", dim_) : nullptr;
  if (settings_.impact == ImpactUpdate::conserving && environment_.density > 0) {
    gap_ = add("gap", 1);
    for (std::vector<double>* half : {&gap_->committed, &gap_->trial})
      std::fill(half->begin(), half->end(), unknown_gap);
  }
  // Penalty, gap of the last augmentation, least penalty beside the inertia of the attempt.
  penalty_ = &state.add(row("penalty", Support::global, 3), 3);
  // Impulse, work, last force, displacement of the rigid body; energy of a conserving update; heat of
  // friction.
  const int totals = 2 * dim_ + 4 + (conserving() ? 1 : 0) + (frictional() ? 1 : 0);
  totals_ = &state.add(row("totals", Support::global, totals), at(totals));
  force_ = &state.add(row("force", Support::vertex, dim_), at(dim_ * mesh_->node_count()));
  penalty_->committed[0] = penalty_->trial[0] = settings_.penalty;
  const std::array<double, 3> start = obstacle_displacement(0);
  for (std::vector<double>* half : {&totals_->committed, &totals_->trial})
    std::copy(start.begin(), start.end(), half->begin() + 2 * dim_ + 1);
}

InitialOverlapReport ContactInterface::initial_overlap() {
  const Handle<Vec> at_rest = layout_->make_global();
  update_search(at_rest);
  const ContactNodes& nodes = form_->nodes();
  InitialOverlapReport report;
  const auto d = at(dim_);
  std::vector<double> shift(d * nodes.global.size(), 0.0), count(shift.size(), 0.0);
  struct {
    double depth = 0;
    int rank = 0;
  } mine, deepest;
  MPI_Comm_rank(mesh_->comm(), &mine.rank);
  std::array<double, 3> where{};
  form_->visit_overlaps(nodes.X, [&](int node, double depth, const std::array<double, 3>& direction) {
    if (depth > mine.depth) {
      mine.depth = depth;
      std::copy_n(&nodes.X[d * at(node)], d, where.begin());
    }
    for (std::size_t k = 0; k < d; ++k) shift[d * at(node) + k] += depth * direction[k];
    count[d * at(node)] += 1;
  });
  MPI_Allreduce(&mine, &deepest, 1, MPI_DOUBLE_INT, MPI_MAXLOC, mesh_->comm());
  MPI_Bcast(where.data(), 3, MPI_DOUBLE, deepest.rank, mesh_->comm());
  report.deepest = deepest.depth;
  report.shift = layout_->make_local();
  const bool forbidden =
      settings_.initial == InitialOverlap::error ||
      (settings_.initial == InitialOverlap::adjust && report.deepest > settings_.initial_tol);
  if (report.deepest > 0 && forbidden)
    throw UserError(ExitCode::data, "contact " + settings_.id + ": `" + settings_.secondary + "` overlaps `" +
                                        settings_.primary + "` by " + number(report.deepest) + " at (" +
                                        number(where[0]) + ", " + number(where[1]) +
                                        (dim_ == 3 ? ", " + number(where[2]) : "") +
                                        "); part the bodies, or use -contact_" + settings_.id +
                                        "_initial adjust with a larger _initial_tol (now " +
                                        number(settings_.initial_tol) + "), or allow");
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
  MPI_Allreduce(&moved, &report.nodes, 1, MPI_INT, MPI_SUM, mesh_->comm());
  return report;
}

} // namespace impact
