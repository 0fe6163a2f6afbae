#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/contact/resolve_settings.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <limits>

namespace impact {

std::string contact_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

namespace {

bool automatic(double value) { return std::isnan(value); }

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
         ", at (" + contact_number(x[0]) + ", " + contact_number(x[1]) +
         (mesh.dim() == 3 ? ", " + contact_number(x[2]) : "") +
         "); facets that share a node or have the body between them are no pairs, and -contact_" +
         settings.id + "_method auto is gpts. Are these two bodies? Give each its own nodes there";
}

void check_settings(ContactSettings& settings, const Mesh& mesh, bool adjoin) {
  const int dim = mesh.dim();
  // At the root of a notch a node of the mortar method sees a part of its facets alone, which comes and goes:
  // Newton's method cycles.
  if (settings.method == ContactMethod::automatic)
    settings.method = adjoin ? ContactMethod::gauss_points : ContactMethod::mortar;
  // At the corners of a face of second order int N_a dA_0 is zero or less.
  if (mesh.order() == 2) settings.at_nodes = false;
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
  // A node sticks or slips by its own force and slip, which the shape functions mix with its neighbours'. At
  // rest, where slip turns round, Newton's method then jumps to and fro between sets of nodes that stick.
  // Facets in part beside deformable ones, and motion, are the worse for dual functions.
  if (settings.multipliers == MultiplierSpace::automatic)
    settings.multipliers = dim == 3 || (settings.rigid() && settings.friction > 0 && !settings.inertia)
                               ? MultiplierSpace::dual
                               : MultiplierSpace::standard;
  if (settings.impact == ImpactUpdate::conserving) {
    if (settings.enforce != Enforcement::automatic && settings.enforce != Enforcement::penalty)
      throw usage(settings, "impact",
                  "`conserving` is for the penalty; take -contact_" + settings.id +
                      "_enforce penalty, or stabilised with multipliers");
    settings.enforce = Enforcement::penalty;
  }
  // The weights by which the semismooth method closes gaps are not for iterative methods: a ball on a plate,
  // 8e4 unknowns, takes 1000 iterations of conjugate gradients for 90 of the augmented Lagrangian.
  if (settings.enforce == Enforcement::automatic)
    settings.enforce = mortar && is_factorised(mesh) ? Enforcement::semismooth : Enforcement::auglag;
  if (!settings.rigid()) return;
  const bool plane = settings.primary == "plane";
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
    throw usage(settings, key, contact_number(value) + " is not a positive number");
}

// The numbers that the user left to the program; the mean length of the secondary facets.
double set_automatic_values(ContactSettings& settings, const ContactEnvironment& environment, MPI_Comm comm,
                            const ContactSurface& secondary, const ContactSurface& primary,
                            std::vector<std::string>& warnings) {
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
  max_over_ranks(comm, longest);
  sum_over_ranks(comm, sum);
  const double h = sum[0] / sum[1];
  const double spacing = longest[0] / settings.points;
  if (!settings.rigid() && settings.method == ContactMethod::gauss_points &&
      -longest[2] < spacing * (1 - 1e-9))
    warnings.push_back("contact " + settings.id + ": a facet of the primary surface `" + settings.primary +
                       "` (" + contact_number(-longest[2]) +
                       ") is shorter than the spacing of the points on the secondary surface `" +
                       settings.secondary + "` (" + contact_number(spacing) +
                       "), so it may slip between them; " +
                       (settings.primary == settings.secondary ? "" : "swap the surfaces or ") +
                       "raise -contact_" + settings.id + "_points");

  auto fill = [](double& value, double by) {
    if (automatic(value)) value = by;
  };
  const double size = environment.length > 0 ? environment.length : h;
  const bool needless = settings.enforce == Enforcement::impulse; // any number will do
  const double penalty = needless && !(environment.modulus > 0) ? 1 : 10 * environment.modulus / size;
  if (automatic(settings.penalty) && !(penalty > 0))
    throw usage(settings, "penalty",
                "auto needs Young's modulus of a side; give a number: the largest pressure "
                "over the depth that you allow");
  settings.automatic_penalty = automatic(settings.penalty);
  fill(settings.penalty, penalty);
  // A start below the automatic one is made up for at once: four times that leaves a fifth of the gap where
  // the surface is as stiff as the penalty.
  fill(settings.penalty_increment, settings.penalty < penalty ? 4 * penalty : settings.penalty);
  fill(settings.penalty_max, 1e4 * (penalty > 0 ? penalty : settings.penalty));
  fill(settings.gap_tol, 1e-3 * h);
  fill(settings.initial_tol, 1e-3 * h);
  settings.local_search = automatic(settings.search_radius);
  fill(settings.search_radius, 2 * std::max(longest[0], longest[1]));
  for (const auto& [key, value] :
       std::array<std::pair<const char*, double>, 6>{{{"penalty", settings.penalty},
                                                      {"penalty_increment", settings.penalty_increment},
                                                      {"penalty_max", settings.penalty_max},
                                                      {"gap_tol", settings.gap_tol},
                                                      {"pressure_tol", settings.pressure_tol},
                                                      {"search_radius", settings.search_radius}}})
    require_positive(settings, key, value);
  if (!(settings.friction >= 0) || !std::isfinite(settings.friction))
    throw usage(settings, "friction", contact_number(settings.friction) + " is negative or not a number");
  return h;
}

} // namespace

ResolvedSettings resolve_settings(const Mesh& mesh, const ContactSettings& given,
                                  const ContactEnvironment& environment, const ContactSurface& secondary,
                                  const ContactSurface& primary) {
  ResolvedSettings resolved{given, 0, 0, {}};
  ContactSettings& settings = resolved.settings;
  if (const std::string text = adjoining(mesh, settings); !text.empty()) resolved.warnings.push_back(text);
  settings.inertia = environment.density > 0;
  check_settings(settings, mesh, !resolved.warnings.empty());
  const bool of_inertia = automatic(settings.penalty);
  resolved.mean_length =
      set_automatic_values(settings, environment, mesh.comm(), secondary, primary, resolved.warnings);
  // Augmentations shrink the gap by k/(k + eps), k the stiffness against moving the surface. Steps far
  // shorter than a wave needs through a cell meet the cell's mass rather than its modulus: k about rho h/3
  // mass_shift.
  if (of_inertia)
    resolved.inertia_penalty =
        2.5 * environment.density * (environment.length > 0 ? environment.length : resolved.mean_length);
  return resolved;
}

} // namespace impact
