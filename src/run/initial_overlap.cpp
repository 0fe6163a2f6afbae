#include <cmath>
#include <cstdio>
#include <impact/petsc/ranks.hpp>
#include <impact/run/setup.hpp>
#include <impact/run/terminal.hpp>

namespace impact {

namespace {

// A restart on other ranks must find the same coordinates: sums of shifts agree but for rounding, so that the
// last digits are left away.
void round_off(std::vector<double>& shift, double tolerance) {
  const double quantum = std::exp2(std::floor(std::log2(1e-7 * tolerance)));
  for (double& value : shift) value = quantum * std::round(value / quantum);
}

// `moved`: what the overlap of the contact has moved in all, [local node][dim].
void report(const ContactSettings& contact, const std::vector<double>& moved, const Mesh& mesh) {
  if (moved.empty()) return;
  const std::size_t dim = at(mesh.dim());
  int count = 0;
  double farthest = 0;
  for (int node = 0; node < mesh.node_count(); ++node) {
    double square = 0;
    for (std::size_t k = 0; k < dim; ++k) square += moved[at(node) * dim + k] * moved[at(node) * dim + k];
    if (square > 0 && mesh.owned(node)) ++count;
    farthest = std::max(farthest, std::sqrt(square));
  }
  count = sum_over_ranks(mesh.comm(), count);
  farthest = max_over_ranks(mesh.comm(), farthest);
  check(PetscPrintf(mesh.comm(),
                    "impact: contact %s: %d nodes of `%s` overlapped `%s` and were moved out, by up to %.4g; "
                    "no stress comes of it\n",
                    contact.id.c_str(), count, contact.secondary.c_str(), contact.primary.c_str(), farthest));
}

} // namespace

void adjust_initial_overlaps(const Scenario& s, const std::vector<ObstacleBody>& obstacles,
                             std::unique_ptr<Setup>& setup) {
  constexpr int rounds = 5;
  std::vector<std::vector<double>> adjusted(setup->contacts.size());
  for (int round = 1, moved = 1; moved > 0; ++round) {
    moved = 0;
    for (std::size_t i = 0; i < adjusted.size(); ++i) {
      InitialOverlapReport overlap = setup->contacts[i].initial_overlap();
      if (overlap.nodes == 0) continue;
      const ContactSettings& contact = setup->contacts[i].settings();
      if (round > rounds)
        throw UserError(ExitCode::data,
                        "-contact_" + contact.id + "_initial adjust: " + std::to_string(overlap.nodes) +
                            " nodes of `" + contact.secondary + "` still overlap `" + contact.primary +
                            "` after " + std::to_string(rounds) + " moves" +
                            (adjusted.size() > 1 ? ", perhaps those of one contact into the bodies of another"
                                                 : "; the surface of `" + contact.primary +
                                                       "` is too coarse or too sharp there") +
                            "; part the surfaces in the mesh");
      round_off(overlap.shift, contact.initial_tol);
      adjusted[i].resize(overlap.shift.size(), 0.0);
      std::transform(overlap.shift.begin(), overlap.shift.end(), adjusted[i].begin(), adjusted[i].begin(),
                     std::plus());
      moved += overlap.nodes;
      try {
        setup = build_on(shifted_mesh(setup->discretisation.mesh, overlap.shift), s, obstacles);
      } catch (const UserError& error) { // of all ranks
        char way[32];
        std::snprintf(way, sizeof way, "%.4g", overlap.deepest);
        throw UserError(error.code(), "-contact_" + contact.id + "_initial adjust: moves " +
                                          std::to_string(overlap.nodes) + " nodes of `" + contact.secondary +
                                          "` by up to " + way + ", more than its cells have room for (" +
                                          error.what() +
                                          "); part the bodies in the mesh, or exchange the two sides");
      }
    }
  }
  for (std::size_t i = 0; i < adjusted.size(); ++i)
    report(setup->contacts[i].settings(), adjusted[i], setup->discretisation.mesh);
}

void tell_of_overlap(RunStage& stage, const ContactInterface& contact, double gap) {
  constexpr double told = 2e-3; // of the shortest edge
  const ContactSettings& settings = contact.settings();
  // What overlaps at nodes has been moved apart by now, or is left on purpose.
  if (settings.rigid() && settings.primary != "plane" && settings.initial != InitialOverlap::allow &&
      settings.method == ContactMethod::mortar && settings.multipliers == MultiplierSpace::dual &&
      gap < -told * stage.d.mesh.smallest_edge())
    check(PetscPrintf(
        stage.d.mesh.comm(),
        "impact: WARNING: contact %s: dual multipliers take the round obstacle for nearer than it is, by "
        "%.3g at the start, and press before it touches: take -contact_%s_multipliers standard, or finer "
        "facets (half as wide: a fourth of it)\n",
        settings.id.c_str(), -gap, settings.id.c_str()));
  if (!stage.inertia || settings.initial != InitialOverlap::allow ||
      !(gap < -told * stage.d.mesh.smallest_edge()))
    return;
  const bool springs = stage.coupling.explicit_step() || settings.enforce == Enforcement::penalty;
  check(PetscPrintf(
      stage.d.mesh.comm(),
      "impact: WARNING: contact %s: bodies overlap by %.3g and -contact_%s_initial allow leaves it "
      "so: with inertia %s; -ts_type static presses them in its first step, and a run with inertia "
      "goes on from its checkpoint by -restart, -restart_allow ts_type and another "
      "-output_<id>_file\n",
      settings.id.c_str(), -gap, settings.id.c_str(),
      springs ? "springs throw them apart" : "nothing presses there until they part"));
}

} // namespace impact
