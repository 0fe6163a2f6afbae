#include <cmath>
#include <impact/contact/contact_heat.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>

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
  if (!conducts_) std::fill(paths_.conductance.begin(), paths_.conductance.end(), 0.0);
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

double ContactHeat::jump(std::size_t place, const std::vector<double>& theta) const {
  const std::size_t first = paths_.first[place], end = paths_.first[place + 1],
                    middle = first + paths_.secondary[place];
  // Shares of a side sum to one. Differences keep the digits that temperatures lose in a good joint.
  const double base = rigid() ? rigid_theta_ : theta[at(paths_.node[first])];
  double difference = 0;
  for (std::size_t k = first; k < end; ++k)
    difference += (k < middle ? 1 : -1) * paths_.share[k] * (theta[at(paths_.node[k])] - base);
  return difference;
}

void ContactHeat::add_residual(Vec theta, Vec r) const {
  const std::vector<double> values = weighted(theta);
  std::vector<double> lost(values.size(), 0.0);
  for (std::size_t c = 0; c < paths_.count(); ++c) {
    const std::size_t first = paths_.first[c], end = paths_.first[c + 1],
                      middle = first + paths_.secondary[c];
    const double flow = paths_.conductance[c] > 0 ? dt_ * paths_.conductance[c] * jump(c, values) : 0;
    // Where nothing lies opposite, and no rigid body, the secondary side keeps it all.
    const double mine = middle == end && !rigid() ? 1 : split_;
    for (std::size_t k = first; k < middle; ++k)
      lost[at(paths_.node[k])] += paths_.share[k] * (flow - mine * paths_.friction[c]);
    for (std::size_t k = middle; k < end; ++k)
      lost[at(paths_.node[k])] -= paths_.share[k] * (flow + (1 - mine) * paths_.friction[c]);
  }
  exchange_.add(lost, r);
}

void ContactHeat::add_tangent(Vec held, Mat K) const {
  if (!conducts_) return;
  const std::vector<double> out = exchange_.gather(held);
  const std::vector<PetscInt>& global = contact_->nodes().global;
  std::vector<PetscInt> rows;
  std::vector<double> row, block;
  for (std::size_t c = 0; c < paths_.count(); ++c) {
    if (!(paths_.conductance[c] > 0)) continue;
    const std::size_t first = paths_.first[c], n = paths_.first[c + 1] - first;
    rows.clear();
    row.clear();
    for (std::size_t k = first; k < first + n; ++k) {
      const std::size_t node = at(paths_.node[k]);
      rows.push_back(out[node] != 0 ? -1 : global[node]); // PETSc leaves these out
      row.push_back((k - first < paths_.secondary[c] ? 1 : -1) * paths_.share[k]);
    }
    block.resize(n * n);
    const double factor = weight_ * dt_ * paths_.conductance[c];
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
  for (std::size_t c = 0; c < paths_.count(); ++c) {
    const double in = paths_.conductance[c] > 0 ? -dt_ * paths_.conductance[c] * jump(c, values) : 0;
    sum[0] += in;
    sum[1] += paths_.friction[c];
    if (!rigid()) continue;
    for (std::size_t k = paths_.first[c]; k < paths_.first[c + 1]; ++k)
      given[at(paths_.node[k])] += paths_.share[k] * in;
  }
  exchange_.add(given, nodal);
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 2, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  return {sum[0], sum[1], rigid() ? sum[0] - (1 - split_) * sum[1] : 0};
}

} // namespace impact
