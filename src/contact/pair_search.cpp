#include <algorithm>
#include <cmath>
#include <impact/contact/pair_search.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool all_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double v) { return std::isfinite(v); });
}

double square_of_move(const double* a, const double* b, int dim) {
  double square = 0;
  for (int k = 0; k < dim; ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
  return square;
}

double largest_move(const std::vector<double>& a, const std::vector<double>& b, int dim) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); i += at(dim))
    largest = std::max(largest, square_of_move(&a[i], &b[i], dim));
  return std::sqrt(largest);
}

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

int ContactNodes::slot(PetscInt node) const {
  const int place = position(global, node);
  return at(place) < global.size() && global[at(place)] == node ? place : -1;
}

void add_pairs_among(std::vector<PetscInt> nodes, NodePairs& pairs) {
  sort_unique(nodes);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = i + 1; j < nodes.size(); ++j) pairs.emplace_back(nodes[i], nodes[j]);
}

std::vector<double> ContactNodes::current(const std::vector<double>& u) const {
  std::vector<double> x = u;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += X[i];
  return x;
}

PairSearch::PairSearch(const Mesh& mesh, const FieldLayout& layout, const std::vector<PetscInt>& secondary,
                       const std::vector<double>& secondary_X, const ContactSurface& primary, double radius,
                       bool has_primary)
    : mesh_(&mesh), layout_(&layout), dim_(mesh.dim()), corners_(mesh.dim() == 2 ? 2 : 4),
      secondary_(secondary), primary_(primary.node), has_primary_(has_primary), radius_(radius),
      skin_(radius / 2), reach_(radius) {
  if (has_primary) neighbour_ = surface_neighbours(layout, primary);
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
}

void PairSearch::set_start(Vec u_n) {
  if (!u_n_) u_n_ = layout_->make_global();
  check(VecCopy(u_n, u_n_));
  static_start_ = static_.gather(u_n_);
  for (std::size_t i = 0; i < static_start_.size(); ++i) static_start_[i] += static_X_[i];
  fetch_start();
}

void PairSearch::fetch_start() { nodes_.start = nodes_.current(u_n_); }

PairSearch::Outcome PairSearch::update(Vec u) {
  if (!has_primary_ && !outdated_) return Outcome::kept;
  std::vector<double> x = static_.gather(u);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += static_X_[i];
  const bool finite = all_finite(x);
  // Not a number; moved since the list was built; moved since the start of the step, by side.
  std::array<double, 4> mine = {finite ? 0.0 : 1.0, 0, 0, 0}, all{};
  if (finite && !outdated_) mine[1] = largest_move(x, static_built_at_, dim_);
  if (finite && !static_start_.empty()) {
    mine[2] = largest_move(x, static_start_, dim_, secondary_slot_);
    mine[3] = largest_move(x, static_start_, dim_, primary_slot_);
  }
  MPI_Allreduce(mine.data(), all.data(), 4, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  // A displacement that is not finite ends the attempt elsewhere; the list in hand stays.
  if (all[0] > 0) return Outcome::kept;
  const double motion = all[2] + all[3];
  if (!outdated_ && all[1] <= skin_ / 2 && motion <= reach_) return Outcome::kept;
  reach_ = std::max(radius_, motion);
  Candidates found = search(x);
  const bool changed = !all_ranks_agree(mesh_->comm(), found.same_pairs(candidates_));
  candidates_ = std::move(found);
  static_built_at_ = std::move(x);
  outdated_ = false;
  fetch_nodes(u);
  return changed ? Outcome::other_pairs : Outcome::rebuilt;
}

Candidates PairSearch::search(const std::vector<double>& x) const {
  if (!has_primary_) return {};
  // In the form of the search: four corners, three coordinates.
  const auto corner_of = [&](int facet, std::size_t a) {
    return at(corners_ * facet) + std::min(a, at(corners_ - 1));
  };
  const auto coordinate = [&](int slot, std::size_t k) { return k < at(dim_) ? x[at(dim_ * slot) + k] : 0; };
  SearchSecondary secondary;
  for (int f = 0; f < static_cast<int>(secondary_.size()) / corners_; ++f)
    for (std::size_t a = 0; a < 4; ++a) {
      secondary.node.push_back(secondary_[corner_of(f, a)]);
      for (std::size_t k = 0; k < 3; ++k)
        secondary.x.push_back(coordinate(secondary_slot_[corner_of(f, a)], k));
    }
  std::vector<SearchFacet> primary(primary_.size() / at(corners_));
  for (int f = 0; f < static_cast<int>(primary.size()); ++f) {
    SearchFacet& facet = primary[at(f)];
    facet.neighbour = {neighbour_[at(2 * f)], neighbour_[at(2 * f + 1)]};
    for (std::size_t a = 0; a < 4; ++a) {
      facet.node[a] = primary_[corner_of(f, a)];
      for (std::size_t k = 0; k < 3; ++k) facet.x[3 * a + k] = coordinate(primary_slot_[corner_of(f, a)], k);
    }
  }
  return find_candidates(mesh_->comm(), secondary, primary, reach_ + skin_);
}

std::vector<PetscInt> PairSearch::primary_nodes(int secondary_facet) const {
  std::vector<PetscInt> nodes;
  if (candidates_.offset.empty()) return nodes; // against a rigid plane
  for (int c = candidates_.offset[at(secondary_facet)]; c < candidates_.offset[at(secondary_facet + 1)]; ++c)
    for (PetscInt node : candidates_.primary[at(candidates_.facet[at(c)])].node) nodes.push_back(node);
  return nodes;
}

void PairSearch::fetch_nodes(Vec u) {
  ContactNodes next;
  next.dim = dim_;
  next.corners = corners_;
  next.global = secondary_;
  for (const SearchFacet& facet : candidates_.primary) {
    next.global.insert(next.global.end(), facet.node.begin(), facet.node.end());
    for (PetscInt node : facet.neighbour)
      if (node >= 0) next.global.push_back(node);
  }
  sort_unique(next.global);
  for (PetscInt node : secondary_) next.secondary.push_back(position(next.global, node));
  for (const SearchFacet& facet : candidates_.primary) {
    for (int a = 0; a < corners_; ++a) next.primary.push_back(position(next.global, facet.node[at(a)]));
    for (PetscInt node : facet.neighbour)
      next.neighbour.push_back(node >= 0 ? position(next.global, node) : -1);
  }
  next.exchange = NodeExchange(mesh_->comm(), mesh_->owned_node_count(), dim_, next.global);
  const Handle<Vec> X = layout_->make_global();
  layout_->to_global(std::vector<double>(mesh_->coordinates().begin(), mesh_->coordinates().end()), X);
  next.X = next.exchange.gather(X);
  next.built_at = next.current(u);
  nodes_ = std::move(next);
  if (u_n_) fetch_start();
}

bool PairSearch::holds_for(const std::vector<double>& x) const {
  return !has_primary_ || largest_move(x, nodes_.built_at, dim_) <= skin_ / 2;
}

} // namespace impact
