#include <algorithm>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/force_balance.hpp>
#include <numeric>

namespace impact {

namespace {

// The stiffest material that meets at each of these nodes.
std::vector<int> stiffest_material(const Discretisation& d, const std::vector<std::size_t>& nodes) {
  std::vector<int> order(d.materials.size()), stiffest(nodes.size(), 0);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return d.materials[at(a)].law.parameters.K < d.materials[at(b)].law.parameters.K;
  });
  for (int m : order) {
    std::vector<double> touched = d.scalar.make_local();
    for (const CellGroup& group : d.groups)
      if (group.material == m)
        for (int node : group.node) touched[at(node)] = 1;
    add_up(d.scalar, touched);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (touched[nodes[i]] > 0) stiffest[i] = m;
  }
  return stiffest;
}

} // namespace

ForceBalance::ForceBalance(const Discretisation& d) : dim_(d.dim()), comm_(d.mesh.comm()) {
  const Mesh& mesh = d.mesh;
  // The local node of each owned entry.
  PetscInt start = 0, end = 0;
  const Handle<Vec> any = d.scalar.make_global();
  check(VecGetOwnershipRange(any, &start, &end));
  std::vector<std::size_t> node(at(end - start));
  for (int i = 0; i < mesh.node_count(); ++i)
    if (mesh.owned(i)) node[at(mesh.global_node()[at(i)] - start)] = at(i);
  const Bodies bodies = find_bodies(mesh);
  const std::vector<int> material = stiffest_material(d, node);
  std::vector<int> number(at(bodies.count) * d.materials.size(), 0);
  for (std::size_t i = 0; i < node.size(); ++i) {
    part_of_node_.push_back(bodies.of_node[node[i]] * static_cast<int>(d.materials.size()) + material[i]);
    number[at(part_of_node_.back())] = 1;
  }
  max_over_ranks(comm_, number);
  for (int& n : number) n = n > 0 ? parts_++ : -1;
  for (int& part : part_of_node_) part = number[at(part)];

  const auto coordinates = mesh.coordinates();
  double sizes[2] = {0, 0};
  for (double x : coordinates) sizes[0] = std::max(sizes[0], std::abs(x));
  for (const CellTable& table : mesh.cells()) {
    const auto n = at(node_count(table.shape)), dim = at(dim_);
    for (std::size_t i = 0; i < table.connectivity.size(); ++i)
      for (std::size_t k = 0; k < dim; ++k)
        sizes[1] = std::max(sizes[1], std::abs(coordinates[at(table.connectivity[i]) * dim + k] -
                                               coordinates[at(table.connectivity[i / n * n]) * dim + k]));
  }
  max_over_ranks(comm_, sizes);
  extent_ = sizes[0];
  largest_cell_ = sizes[1];
  const auto parts = at(parts_);
  sums_.resize(2 * parts);
  rounding_.resize(parts);
  largest_.resize(parts);
  last_.resize(parts);
  least_rounding_.resize(parts);
}

void ForceBalance::forget() { std::fill(rounding_.begin(), rounding_.end(), 0.0); }

void ForceBalance::start() {
  first_ = -1;
  std::fill(largest_.begin(), largest_.end(), 0.0);
  for (std::vector<double>* least : {&last_, &least_rounding_})
    std::fill(least->begin(), least->end(), HUGE_VAL);
}

void ForceBalance::note_tangent(Vec u, Vec cells, Vec all, bool weighs_gaps) {
  // What contact and rigid bodies add is of places that are sums themselves: of a turned arm, a centre and
  // what a predictor extrapolates. A disc that has rolled for its diameter is left with 1.5e-15. Weights by
  // which linear solves close gaps are a thousand times penalties: of small loads no more may be excused than
  // the rounding of the gap itself.
  constexpr double last_digits = 1e-15, of_gaps = 5e-16;
  const double of_places = weighs_gaps ? of_gaps : 4e-15;
  forget();
  const Entries moves(u), bulk(cells), whole(all);
  const auto dim = at(dim_);
  for (std::size_t i = 0; i < part_of_node_.size(); ++i) {
    double moved = 0;
    for (std::size_t k = dim * i; k < dim * (i + 1); ++k) moved = std::max(moved, std::abs(moves[k]));
    for (std::size_t k = dim * i; k < dim * (i + 1); ++k) {
      const double error = last_digits * std::abs(bulk[k]) * (moved + largest_cell_) +
                           of_places * std::abs(whole[k] - bulk[k]) * (moved + extent_);
      rounding_[at(part_of_node_[i])] += error * error;
    }
  }
}

void ForceBalance::judge(Vec f, double atol, double rtol) {
  const auto parts = at(parts_), dim = at(dim_);
  std::fill(sums_.begin(), sums_.begin() + parts_, 0.0);
  std::copy(rounding_.begin(), rounding_.end(), sums_.begin() + parts_);
  const Entries values(f);
  for (std::size_t i = 0; i < part_of_node_.size(); ++i)
    for (std::size_t k = dim * i; k < dim * (i + 1); ++k)
      sums_[at(part_of_node_[i])] += values[k] * values[k];
  sum_over_ranks(comm_, sums_);
  if (first_ < 0) {
    first_ = 0;
    for (std::size_t p = 0; p < parts; ++p) first_ += sums_[p];
    first_ = std::sqrt(first_);
  }
  // Constraints at no pressure come and go with the last digits. Where they leave one by one, because what a
  // small load lifts pulls at the last of them, the residual does not fall either: it is larger than that.
  const double allowed_part = other_set_ ? 0.02 : 1;
  // What pressures that run away leave by turning with their facets, of a tangent that runs away, too, is no
  // rounding. Contacts that close make that of a solve larger, by up to 1e7.
  constexpr double most_growth = 1e8;
  force_ = std::max(atol, rtol * first_);
  ratio_ = 0;
  for (std::size_t p = 0; p < parts; ++p) {
    const double norm = std::sqrt(sums_[p]);
    largest_[p] = std::max(largest_[p], norm);
    const double of_tangent = std::sqrt(sums_[parts + p]);
    if (of_tangent > 0) least_rounding_[p] = std::min(least_rounding_[p], of_tangent);
    const double rounding =
        norm > 0.5 * last_[p] ? allowed_part * std::min(of_tangent, most_growth * least_rounding_[p]) : 0;
    const double settled = aim_ == Aim::settled && last_[p] < HUGE_VAL ? 0.01 * last_[p] : 0;
    last_[p] = norm;
    const double allowed = std::max({atol, rtol * std::min(largest_[p], first_), rounding, settled});
    // A part without residual is balanced whatever its tolerance; one with a residual that is no number
    // never.
    if (!(norm == 0)) ratio_ = norm <= HUGE_VAL && allowed > 0 ? std::max(ratio_, norm / allowed) : HUGE_VAL;
  }
}

SNESConvergedReason ForceBalance::test(SNES snes, PetscInt iteration, PetscReal norm) {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  check(SNESConvergedDefault(snes, iteration, 0, 0, norm, &reason, nullptr));
  if (reason < 0) return reason;
  PetscReal atol = 0, rtol = 0;
  Vec f = nullptr;
  check(SNESGetTolerances(snes, &atol, &rtol, nullptr, nullptr, nullptr));
  check(SNESGetFunction(snes, &f, nullptr, nullptr));
  judge(f, atol, rtol);
  if (!holds()) return SNES_CONVERGED_ITERATING;
  return norm <= atol ? SNES_CONVERGED_FNORM_ABS : SNES_CONVERGED_FNORM_RELATIVE;
}

} // namespace impact
