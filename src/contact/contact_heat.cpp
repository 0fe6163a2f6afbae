#include <cmath>
#include <impact/contact/contact_heat.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

double split_of(const ContactSettings& settings) {
  if (!std::isnan(settings.friction_heat_split)) return settings.friction_heat_split;
  return settings.rigid() ? 1 : 0.5;
}

} // namespace

ContactHeat::ContactHeat(const Mesh& mesh, const ContactInterface& contact)
    : mesh_(&mesh), contact_(&contact), split_(split_of(contact.settings())),
      conducts_(contact.settings().conductance > 0 && (!rigid() || contact.settings().rigid_temperature)) {
  renew();
}

bool ContactHeat::renew() {
  if (searches_ == contact_->searches()) return false;
  searches_ = contact_->searches();
  const ContactNodes& nodes = contact_->nodes();
  exchange_ = NodeExchange(mesh_->comm(), mesh_->owned_node_count(), 1, nodes.global);
  NodePairs couplings = conducts_ ? contact_->constraints().form().couplings() : NodePairs();
  const bool same = all_ranks_agree(mesh_->comm(), couplings == couplings_);
  couplings_ = std::move(couplings);
  return !same;
}

void ContactHeat::begin(Vec u, Vec theta_n, double dt, double weight, double rigid_theta) {
  paths_ = contact_->heat_paths(u);
  for (HeatPath& path : paths_)
    if (!conducts_) path.conductance = 0;
  theta_n_ = exchange_.gather(theta_n);
  dt_ = dt;
  weight_ = weight;
  rigid_theta_ = rigid_theta;
}

std::vector<double> ContactHeat::weighted(Vec theta) const {
  std::vector<double> values = exchange_.gather(theta);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = weight_ * values[i] + (1 - weight_) * theta_n_[i];
  return values;
}

double ContactHeat::jump(const HeatPath& path, const std::vector<double>& theta) const {
  // Shares of a side sum to one. Differences keep the digits that temperatures lose in a good joint.
  const double base = rigid() ? rigid_theta_ : theta[at(path.node[0])];
  double difference = 0;
  for (std::size_t k = 0; k < path.node.size(); ++k)
    difference += (k < path.secondary ? 1 : -1) * path.share[k] * (theta[at(path.node[k])] - base);
  return difference;
}

double ContactHeat::flow(const HeatPath& path, const std::vector<double>& theta) const {
  return path.conductance > 0 ? dt_ * path.conductance * jump(path, theta) : 0;
}

void ContactHeat::add_residual(Vec theta, Vec r) const {
  const std::vector<double> values = weighted(theta);
  std::vector<double> lost(values.size(), 0.0);
  for (const HeatPath& path : paths_) {
    const double out = flow(path, values);
    // Where nothing lies opposite, and no rigid body, the secondary side keeps it all.
    const double mine = path.secondary == path.node.size() && !rigid() ? 1 : split_;
    for (std::size_t k = 0; k < path.secondary; ++k)
      lost[at(path.node[k])] += path.share[k] * (out - mine * path.friction);
    for (std::size_t k = path.secondary; k < path.node.size(); ++k)
      lost[at(path.node[k])] -= path.share[k] * (out + (1 - mine) * path.friction);
  }
  exchange_.add(lost, r);
}

void ContactHeat::add_tangent(Vec held, Mat K) const {
  if (!conducts_) return;
  const std::vector<double> out = exchange_.gather(held);
  std::vector<PetscInt> rows;
  std::vector<double> row, block;
  for (const HeatPath& path : paths_) {
    if (!(path.conductance > 0)) continue;
    const std::size_t n = path.node.size();
    rows.clear();
    row.clear();
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t node = at(path.node[k]);
      rows.push_back(out[node] != 0 ? -1 : contact_->nodes().global[node]); // PETSc leaves these out
      row.push_back((k < path.secondary ? 1 : -1) * path.share[k]);
    }
    block.resize(n * n);
    const double factor = weight_ * dt_ * path.conductance;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) block[n * i + j] = factor * row[i] * row[j];
    const auto size = static_cast<PetscInt>(n);
    check(MatSetValues(K, size, rows.data(), size, rows.data(), block.data(), ADD_VALUES));
  }
}

ContactHeat::Heat ContactHeat::book(Vec theta, Vec nodal) const {
  const std::vector<double> values = weighted(theta);
  std::vector<double> given(values.size(), 0.0);
  std::array<double, 2> sum{};
  for (const HeatPath& path : paths_) {
    const double in = -flow(path, values);
    sum[0] += in;
    sum[1] += path.friction;
    for (std::size_t k = 0; rigid() && k < path.node.size(); ++k)
      given[at(path.node[k])] += path.share[k] * in;
  }
  exchange_.add(given, nodal);
  sum_over_ranks(mesh_->comm(), sum);
  return {sum[0], sum[1], rigid() ? sum[0] - (1 - split_) * sum[1] : 0};
}

} // namespace impact
