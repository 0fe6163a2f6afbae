#include <algorithm>
#include <cmath>
#include <impact/contact/facet_parts.hpp>
#include <impact/contact/pair_search.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

bool all_finite(const ContactValues& x) {
  return std::all_of(x.begin(), x.end(), [](double v) { return std::isfinite(v); });
}

double square_of_move(const double* a, const double* b, int dim) {
  double square = 0;
  for (int k = 0; k < dim; ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
  return square;
}

// Largest move of a node over what it may move by.
double largest_part(const std::vector<double>& a, const std::vector<double>& b, int dim,
                    const std::vector<double>& slack) {
  double largest = 0;
  for (std::size_t i = 0; i < slack.size(); ++i)
    largest =
        std::max(largest, square_of_move(&a[at(dim) * i], &b[at(dim) * i], dim) / (slack[i] * slack[i]));
  return std::sqrt(largest);
}

// With local sizes facets are a pair nearer than this part of the longest sides of both, and their nodes may
// move by this part of them until the list is made anew.
constexpr double local_part = 0.4, local_slack = 0.1;

// Of the nodes [slot].
double largest_move(const std::vector<double>& a, const std::vector<double>& b, int dim,
                    const std::vector<int>& slots) {
  double largest = 0;
  for (int slot : slots)
    largest = std::max(largest, square_of_move(&a[at(dim * slot)], &b[at(dim * slot)], dim));
  return std::sqrt(largest);
}

int position(const std::vector<PetscInt>& sorted, PetscInt value) {
  return static_cast<int>(std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin());
}

} // namespace

NodeExchange::NodeExchange(MPI_Comm comm, PetscInt owned, int components, const std::vector<PetscInt>& nodes)
    : size_(nodes.size() * static_cast<std::size_t>(components)) {
  std::vector<PetscInt> dofs;
  dofs.reserve(size_);
  for (PetscInt node : nodes)
    for (PetscInt k = 0; k < components; ++k) dofs.push_back(node * components + k);
  PetscLayout layout = nullptr;
  check(PetscLayoutCreate(comm, &layout));
  check(PetscLayoutSetLocalSize(layout, owned * components));
  check(PetscLayoutSetUp(layout));
  check(PetscSFCreate(comm, sf_.out()));
  check(PetscSFSetGraphLayout(sf_, layout, static_cast<PetscInt>(size_), nullptr, PETSC_OWN_POINTER,
                              dofs.data()));
  check(PetscLayoutDestroy(&layout));
  check(PetscSFSetUp(sf_));
}

std::vector<double> NodeExchange::gather(Vec global) const {
  std::vector<double> values(size_);
  const PetscScalar* owned = nullptr;
  check(VecGetArrayRead(global, &owned));
  check(PetscSFBcastBegin(sf_, MPIU_SCALAR, owned, values.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf_, MPIU_SCALAR, owned, values.data(), MPI_REPLACE));
  check(VecRestoreArrayRead(global, &owned));
  return values;
}

void NodeExchange::add(const std::vector<double>& values, Vec global) const {
  PetscScalar* owned = nullptr;
  check(VecGetArray(global, &owned));
  check(PetscSFReduceBegin(sf_, MPIU_SCALAR, values.data(), owned, MPIU_SUM));
  check(PetscSFReduceEnd(sf_, MPIU_SCALAR, values.data(), owned, MPIU_SUM));
  check(VecRestoreArray(global, &owned));
}

int ContactNodes::slot(PetscInt node) const {
  const int place = position(global, node);
  return at(place) < global.size() && global[at(place)] == node ? place : -1;
}

void add_pairs_among(std::vector<PetscInt> nodes, NodePairs& pairs) {
  sort_unique(nodes);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = i + 1; j < nodes.size(); ++j) pairs.emplace_back(nodes[i], nodes[j]);
}

std::vector<double> ContactNodes::current(const ContactValues& u) const {
  std::vector<double> x = u;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += X[i];
  return x;
}

PairSearch::PairSearch(const Mesh& mesh, const FieldLayout& layout, const std::vector<PetscInt>& secondary,
                       const std::vector<double>& secondary_X, const ContactSurface& primary,
                       SearchRange range, Primary kind)
    : mesh_(&mesh), layout_(&layout), dim_(mesh.dim()), per_facet_(stored_nodes(mesh)), secondary_(secondary),
      primary_(primary.node), kind_(kind), radius_(range.radius),
      local_(range.local && kind == Primary::other) {
  if (kind != Primary::rigid) neighbour_ = surface_neighbours(layout, primary);
  std::vector<PetscInt> nodes = secondary_;
  nodes.insert(nodes.end(), primary_.begin(), primary_.end());
  sort_unique(nodes);
  static_X_.resize(at(dim_) * nodes.size());
  const auto place = [&](const std::vector<PetscInt>& node, const std::vector<double>& X,
                         std::vector<int>& slot) {
    for (std::size_t i = 0; i < node.size(); ++i) {
      slot.push_back(position(nodes, node[i]));
      for (std::size_t k = 0; k < at(dim_); ++k) static_X_[at(dim_ * slot.back()) + k] = X[at(dim_) * i + k];
    }
  };
  place(secondary_, secondary_X, secondary_slot_);
  place(primary_, primary.X, primary_slot_);
  static_ = NodeExchange(mesh.comm(), mesh.owned_node_count(), dim_, nodes);
  static_slack_.assign(nodes.size(), local_ ? HUGE_VAL : skin() / 2);
  smallest_ = std::min(tighten(secondary_slot_, static_X_, static_slack_),
                       tighten(primary_slot_, static_X_, static_slack_));
  smallest_ = min_over_ranks(mesh.comm(), smallest_);
  if (!std::isfinite(smallest_)) smallest_ = radius_; // no facet is left on either side
  if (kind == Primary::rigid) return;
  const SearchSecondary own = secondary_at(static_X_);
  const std::vector<SearchFacet> other = primary_at(static_X_);
  if (find_shapes(own, other) && kind == Primary::itself) prepare_self_contact(own, other);
}

void PairSearch::begin_attempt(Vec u_n) {
  PetscBool again = PETSC_FALSE;
  look_.of_all_ranks = false;
  if (!attempt_from_) attempt_from_ = layout_->make_global();
  if (found_) check(VecEqual(attempt_from_, u_n, &again)); // as all ranks have, or none
  if (again) {
    const bool same = all_ranks_agree(mesh_->comm(), list_.candidates.same_pairs(found_->candidates));
    restored_ = same ? Outcome::rebuilt : Outcome::other_pairs;
    list_ = std::move(*found_);
  }
  found_.reset();
  check(VecCopy(u_n, attempt_from_));
}

void PairSearch::set_start(Vec u_n) {
  if (!u_n_) u_n_ = layout_->make_global();
  check(VecCopy(u_n, u_n_));
  static_start_ = static_.gather(u_n_);
  for (std::size_t i = 0; i < static_start_.size(); ++i) static_start_[i] += static_X_[i];
  fetch_start();
}

void PairSearch::fetch_start() { list_.nodes.start = list_.nodes.current(u_n_); }

void PairSearch::look(Vec u) {
  std::vector<double>& x = look_.x = static_.gather(u);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += static_X_[i];
  const bool finite = all_finite(x);
  look_.moves = {finite ? 0.0 : 1.0, 0, 0, 0};
  if (finite && !list_.outdated) look_.moves[1] = largest_part(x, list_.built_at, dim_, static_slack_);
  if (finite && !static_start_.empty()) {
    look_.moves[2] = largest_move(x, static_start_, dim_, secondary_slot_);
    look_.moves[3] = largest_move(x, static_start_, dim_, primary_slot_);
  }
}

void PairSearch::look(Vec u, Tally& tally) {
  if (stays()) return;
  look(u);
  tally.largest(look_.moves);
  look_.of_all_ranks = true;
}

PairSearch::Outcome PairSearch::update(Vec u) {
  if (stays()) return Outcome::kept;
  if (!std::exchange(look_.of_all_ranks, false)) {
    look(u);
    max_over_ranks(mesh_->comm(), look_.moves);
  }
  const auto& [infinite, since_built, of_secondary, of_primary] = look_.moves;
  const Outcome owed = std::exchange(restored_, Outcome::kept);
  // A displacement that is not finite ends the attempt elsewhere; the list in hand stays.
  if (infinite > 0) return owed;
  const double motion = motion_ = of_secondary + of_primary;
  if (!list_.outdated && since_built <= 1 && motion <= list_.reach) return owed;
  List before = std::exchange(list_, {});
  // A step that moves alike finds the list long enough.
  list_.reach = local_ ? std::max(smallest_, 1.25 * motion) : std::max(radius_, motion);
  list_.candidates = search(look_.x);
  fetch_nodes();
  if (body_) drop_neighbours(u);
  list_.built_at = std::move(look_.x);
  list_.outdated = false;
  const bool changed = !all_ranks_agree(mesh_->comm(), list_.candidates.same_pairs(before.candidates));
  if (attempt_from_ && !found_) found_ = std::move(before);
  return changed || owed == Outcome::other_pairs ? Outcome::other_pairs : Outcome::rebuilt;
}

std::array<double, 12> PairSearch::in_space(const int* slot, const ContactValues& x) const {
  std::array<double, 12> corner{};
  const int last = stored_corners(per_facet_) - 1;
  for (int a = 0; a < 4; ++a) std::copy_n(&x[at(dim_ * slot[std::min(a, last)])], dim_, &corner[at(3 * a)]);
  return corner;
}

// A facet of second order is its straight one and sum N_e d_e over the middles of its sides and its own, d_e
// their offset from those of the straight facet. The sum of |N_e| is at most 4/3 on edges and triangles, 2 on
// quadrilaterals.
double PairSearch::bulge(const int* slot, const ContactValues& x) const {
  const int corners = stored_corners(per_facet_);
  double square = 0;
  const int middles = is_wide_triangle(per_facet_, slot) ? corners : per_facet_ - corners; // none of its own
  for (int e = 0; e < middles; ++e) {
    double offset = 0;
    for (int k = 0; k < dim_; ++k) {
      const auto of = [&](int a) { return x[at(dim_ * slot[a] + k)]; };
      const double straight =
          e < corners ? (of(e) + of((e + 1) % corners)) / 2 : (of(0) + of(1) + of(2) + of(3)) / 4;
      const double d = of(corners + e) - straight;
      offset += d * d;
    }
    square = std::max(square, offset);
  }
  return (corners == 4 ? 2 : 4.0 / 3) * std::sqrt(square);
}

double PairSearch::tighten(const std::vector<int>& slot, const std::vector<double>& X,
                           std::vector<double>& slack) const {
  double smallest = HUGE_VAL;
  for (std::size_t i = 0; i < slot.size(); i += at(per_facet_)) {
    const double size = longest_side(in_space(&slot[i], X).data(), 4, 3);
    smallest = std::min(smallest, size);
    for (std::size_t a = i; local_ && a < i + at(per_facet_); ++a)
      slack[at(slot[a])] = std::min(slack[at(slot[a])], local_slack * size);
  }
  return smallest;
}

SearchSecondary PairSearch::secondary_at(const ContactValues& x) const {
  SearchSecondary secondary;
  const bool curved = stored_corners(per_facet_) < per_facet_;
  for (std::size_t f = 0; f < secondary_.size(); f += at(per_facet_)) {
    const std::array<double, 12> corner = in_space(&secondary_slot_[f], x);
    secondary.x.insert(secondary.x.end(), corner.begin(), corner.end());
    for (int a = 0; a < 4; ++a) secondary.node.push_back(secondary_[f + at(std::min(a, per_facet_ - 1))]);
    if (curved) secondary.bulge.push_back(bulge(&secondary_slot_[f], x));
  }
  return secondary;
}

std::vector<SearchFacet> PairSearch::primary_at(const ContactValues& x) const {
  std::vector<SearchFacet> primary(primary_.size() / at(per_facet_));
  for (std::size_t f = 0; f < primary.size(); ++f) {
    const std::size_t first = at(per_facet_) * f;
    primary[f].neighbour = {neighbour_[2 * f], neighbour_[2 * f + 1]};
    primary[f].x = in_space(&primary_slot_[first], x);
    primary[f].bulge = bulge(&primary_slot_[first], x);
    for (int a = 0; a < static_cast<int>(primary[f].node.size()); ++a)
      primary[f].node[at(a)] = primary_[first + at(std::min(a, per_facet_ - 1))];
  }
  return primary;
}

Candidates PairSearch::search(const ContactValues& x) const {
  if (kind_ == Primary::rigid) return {};
  if (local_)
    return find_candidates(mesh_->comm(), secondary_at(x), primary_at(x), list_.reach - smallest_,
                           local_part + local_slack);
  return find_candidates(mesh_->comm(), secondary_at(x), primary_at(x), list_.reach + skin());
}

std::vector<PetscInt> PairSearch::primary_nodes(int secondary_facet) const {
  if (list_.candidates.offset.empty()) return added_; // against a rigid plane, sphere or cylinder
  std::vector<PetscInt> nodes;
  for (int c : list_.candidates.of(at(secondary_facet))) {
    const GlobalFacet& facet = list_.candidates.primary[at(list_.candidates.facet[at(c)])].node;
    nodes.insert(nodes.end(), facet.begin(), facet.begin() + per_facet_);
  }
  return nodes;
}

void PairSearch::fetch_nodes() {
  ContactNodes next;
  next.dim = dim_;
  next.per_facet = per_facet_;
  next.global = secondary_;
  next.global.insert(next.global.end(), added_.begin(), added_.end());
  for (const SearchFacet& facet : list_.candidates.primary) {
    next.global.insert(next.global.end(), facet.node.begin(), facet.node.begin() + per_facet_);
    for (PetscInt node : facet.neighbour)
      if (node >= 0) next.global.push_back(node);
  }
  sort_unique(next.global);
  for (PetscInt node : secondary_) next.secondary.push_back(position(next.global, node));
  for (const SearchFacet& facet : list_.candidates.primary) {
    for (int a = 0; a < per_facet_; ++a) next.primary.push_back(position(next.global, facet.node[at(a)]));
    for (PetscInt node : facet.neighbour)
      next.neighbour.push_back(node >= 0 ? position(next.global, node) : -1);
  }
  next.exchange = NodeExchange(mesh_->comm(), mesh_->owned_node_count(), dim_, next.global);
  const Handle<Vec> X = layout_->make_global();
  layout_->to_global(std::vector<double>(mesh_->coordinates().begin(), mesh_->coordinates().end()), X);
  next.X = next.exchange.gather(X);
  list_.nodes = std::move(next);
  if (u_n_) fetch_start();
}

double PairSearch::pairs_per_facet() const {
  std::array<double, 2> sum{};
  const std::vector<int>& offset = list_.candidates.offset;
  for (std::size_t f = 0; f + 1 < offset.size(); ++f)
    if (offset[f + 1] > offset[f]) sum = {sum[0] + offset[f + 1] - offset[f], sum[1] + 1};
  sum_over_ranks(mesh_->comm(), sum);
  return sum[1] > 0 ? sum[0] / sum[1] : 0;
}

double PairSearch::range() const { return local_ ? 2 * local_part * smallest_ : radius_; }

double PairSearch::nearest_nodes(const ContactValues& u) const {
  const std::vector<double> x = list_.nodes.current(u);
  double square = HUGE_VAL;
  const auto& offset = list_.candidates.offset;
  for (std::size_t f = 0; f + 1 < offset.size(); ++f)
    for (int c = offset[f]; c < offset[f + 1]; ++c)
      for (int a = 0; a < per_facet_; ++a)
        for (int b = 0; b < per_facet_; ++b) {
          const int s = list_.nodes.secondary[at(per_facet_) * f + at(a)],
                    p = list_.nodes.primary[at(per_facet_ * list_.candidates.facet[at(c)] + b)];
          square = std::min(square, square_of_move(&x[at(dim_ * s)], &x[at(dim_ * p)], dim_));
        }
  return std::sqrt(square);
}

} // namespace impact
