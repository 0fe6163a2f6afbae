#include <algorithm>
#include <cmath>
#include <impact/balance/reactions.hpp>
#include <impact/petsc/ranks.hpp>

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

void Reactions::find(const std::vector<double>& force, Vec u, Vec v) {
  const Discretisation& d = motion_.discretisation();
  const auto dim = at(d.dim());
  const std::vector<double> moved = d.local_of(u);
  constexpr std::size_t numbers = 8; // of a condition: force, sum of u, nodes, sum of theta
  std::vector<double> sums(numbers * of_.size(), 0.0);
  for (std::size_t c = 0; c < of_.size(); ++c) {
    of_[c].moment = {};
    double* sum = &sums[numbers * c];
    sum[6] = static_cast<double>(of_[c].nodes.size());
    for (const int node : of_[c].nodes) {
      for (std::size_t k = 0; k < dim; ++k) sum[3 + k] += moved[at(node) * dim + k];
      if (theta_) sum[7] += theta_->trial[at(node)];
    }
  }
  for (const FixedDof& fixed : motion_.boundary().fixed())
    if (d.mesh.owned(fixed.dof / d.dim()))
      sums[numbers * at(fixed.condition) + at(fixed.component)] += d.thickness * force[at(fixed.dof)];
  if (const Foundations& foundations = motion_.foundations(); !foundations.empty()) {
    std::vector<Vector3> pushes(of_.size(), Vector3{});
    foundations.add_resultants(moved, foundations.damps() ? d.local_of(v) : std::vector<double>(), pushes);
    for (std::size_t c = 0; c < of_.size(); ++c)
      for (std::size_t k = 0; k < dim; ++k) sums[numbers * c + k] += d.thickness * pushes[c][k];
  }
  const RigidBodies& rigid = motion_.rigid();
  int rank = 0;
  MPI_Comm_rank(d.mesh.comm(), &rank);
  for (std::size_t b = 0; b < rigid.bodies().size(); ++b)
    for (std::size_t k = 0; k < 6; ++k) {
      const int c = rigid.bodies()[b].held[k];
      if (c < 0) continue;
      const double value = d.thickness * rigid.reactions(static_cast<int>(b))[k];
      if (k >= 3)
        of_[at(c)].moment[k - 3] += value;
      else if (k < dim && rank == 0) // the same on all ranks, which are summed below
        sums[numbers * at(c) + k] += value;
    }
  sum_over_ranks(d.mesh.comm(), sums);
  for (std::size_t c = 0; c < of_.size(); ++c) {
    const double* sum = &sums[numbers * c];
    const double count = std::max(1.0, sum[6]);
    of_[c].force = {sum[0], sum[1], sum[2]};
    of_[c].mean = {sum[3] / count, sum[4] / count, sum[5] / count};
    of_[c].mean_theta = sum[7] / count;
  }
}

void Reactions::append(HistoryFile::Row& row, const std::function<double(std::size_t)>& heat) const {
  static constexpr const char* axis[3] = {"x", "y", "z"};
  const auto dim = at(motion_.discretisation().dim());
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
    for (std::size_t k = 0; k < dim; ++k)
      if (prescribes_motion(type) || gives_way(type))
        row.emplace_back("reaction_" + id + "_" + axis[k], of_[c].force[k]);
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

HeatBook::HeatBook(MotionProblem& motion, StateTable& state, std::vector<std::string> contacts)
    : totals_(state.add({"ledger_heat", Support::global, 3}, 3)), contacts_(std::move(contacts)) {
  for (const BoundaryCondition& bc : motion.boundary().conditions())
    conditions_.push_back(is_thermal(bc.type) ? &state.add({"bc_" + bc.id + "_heat", Support::global, 1}, 1)
                                              : nullptr);
  for (const std::string& id : contacts_)
    conducted_.push_back(&state.add({"contact_" + id + "_heat", Support::global, 1}, 1));
}

double HeatBook::exchanged() const {
  double sum = 0;
  for (const std::vector<StateRow*>* rows : {&conditions_, &conducted_})
    for (const StateRow* row : *rows)
      if (row != nullptr) sum += std::abs(row->trial[0]);
  return std::max(sum, std::abs(supplied()));
}

void HeatBook::book(const StepRecord& step, double thickness) {
  const auto& [by_condition, by_contact, entropy] = *step.heat;
  for (std::size_t c = 0; c < by_condition.size(); ++c) {
    if (conditions_[c] != nullptr) conditions_[c]->trial[0] += thickness * by_condition[c];
    totals_.trial[0] += thickness * by_condition[c];
  }
  for (std::size_t c = 0; c < by_contact.size(); ++c) {
    conducted_[c]->trial[0] += thickness * by_contact[c].conducted;
    totals_.trial[0] += thickness * by_contact[c].outside;
  }
  totals_.trial[1] += thickness * entropy;
}

} // namespace impact
