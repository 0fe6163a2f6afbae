#include <algorithm>
#include <impact/balance/reactions.hpp>

namespace impact {

Reactions::Reactions(MotionProblem& motion, const StateTable& state)
    : motion_(motion), theta_(state.find("theta")) {
  const Mesh& mesh = motion_.discretisation().mesh;
  for (const BoundaryCondition& bc : motion_.boundary().conditions()) {
    std::vector<int>& nodes = of_.emplace_back().nodes;
    for (const std::string& name : bc.on)
      for (int node : mesh.nodes(name))
        if (mesh.owned(node)) nodes.push_back(node);
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  }
}

void Reactions::find(const std::vector<double>& force, const std::vector<double>& u) {
  const Discretisation& d = motion_.discretisation();
  const auto dim = static_cast<std::size_t>(d.dim());
  for (OfCondition& c : of_) {
    c.force = c.moment = c.mean = {};
    c.count = static_cast<double>(c.nodes.size());
    c.mean_theta = 0;
    for (const int node : c.nodes) {
      for (std::size_t k = 0; k < dim; ++k) c.mean[k] += u[static_cast<std::size_t>(node) * dim + k];
      if (theta_) c.mean_theta += theta_->trial[static_cast<std::size_t>(node)];
    }
  }
  for (const FixedDof& fixed : motion_.boundary().fixed())
    if (d.mesh.owned(fixed.dof / d.dim()))
      of_[static_cast<std::size_t>(fixed.condition)].force[static_cast<std::size_t>(fixed.component)] +=
          d.thickness * force[static_cast<std::size_t>(fixed.dof)];
  const RigidBodies& rigid = motion_.rigid();
  int rank = 0;
  MPI_Comm_rank(d.mesh.comm(), &rank);
  for (std::size_t b = 0; b < rigid.bodies().size(); ++b)
    for (std::size_t k = 0; k < 6; ++k) {
      const int c = rigid.bodies()[b].held[k];
      if (c < 0) continue;
      const double value = d.thickness * rigid.reactions(static_cast<int>(b))[k];
      if (k >= 3)
        of_[static_cast<std::size_t>(c)].moment[k - 3] += value;
      else if (k < dim && rank == 0) // the same on all ranks, which are summed below
        of_[static_cast<std::size_t>(c)].force[k] += value;
    }
  constexpr std::size_t numbers = 8;
  std::vector<double> sums;
  for (const OfCondition& c : of_)
    sums.insert(sums.end(),
                {c.force[0], c.force[1], c.force[2], c.mean[0], c.mean[1], c.mean[2], c.count, c.mean_theta});
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, d.mesh.comm());
  for (std::size_t i = 0; i < of_.size(); ++i) {
    const double* sum = &sums[numbers * i];
    const double count = std::max(1.0, sum[6]);
    of_[i].force = {sum[0], sum[1], sum[2]};
    of_[i].mean = {sum[3] / count, sum[4] / count, sum[5] / count};
    of_[i].mean_theta = sum[7] / count;
  }
}

void Reactions::append(HistoryFile::Row& row, const std::function<double(std::size_t)>& heat) const {
  static constexpr const char* axis[3] = {"x", "y", "z"};
  const auto dim = static_cast<std::size_t>(motion_.discretisation().dim());
  const auto& conditions = motion_.boundary().conditions();
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    const BcType type = conditions[c].type;
    const std::string& id = conditions[c].id;
    if (type == BcType::body_force || type == BcType::damage) continue;
    if (is_thermal(type)) {
      row.emplace_back("heat_" + id, heat(c));
      row.emplace_back("mean_" + id + "_theta", of_[c].mean_theta);
      continue;
    }
    const bool holds = type == BcType::fix || type == BcType::displacement || type == BcType::symmetry ||
                       type == BcType::velocity || type == BcType::acceleration;
    for (std::size_t k = 0; k < dim; ++k)
      if (holds) row.emplace_back("reaction_" + id + "_" + axis[k], of_[c].force[k]);
    for (std::size_t k = 0; k < 3; ++k)
      if (turns(static_cast<int>(c), k)) row.emplace_back("moment_" + id + "_" + axis[k], of_[c].moment[k]);
    for (std::size_t k = 0; k < dim; ++k) row.emplace_back("mean_" + id + "_u" + axis[k], of_[c].mean[k]);
  }
}

bool Reactions::turns(int condition, std::size_t axis) const {
  const auto& bodies = motion_.rigid().bodies();
  return std::any_of(bodies.begin(), bodies.end(),
                     [&](const RigidBody& body) { return body.held[3 + axis] == condition; });
}

} // namespace impact
