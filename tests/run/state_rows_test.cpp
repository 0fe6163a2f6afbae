#include "../mesh/small_mesh.hpp"
#include <bit>
#include <cstdint>
#include <gtest/gtest.h>
#include <impact/balance/ledger.hpp>
#include <impact/io/checkpoint.hpp>
#include <impact/problem/damage.hpp>
#include <impact/problem/heat.hpp>
#include <map>

namespace impact {
namespace {

// Plasticity, damage with the committed drive, viscosity, heat, a rigid body and contact on two bodies:
// everything that adds rows.
struct AllPhysics {
  Discretisation d;
  StateTable state;
  RigidBodies rigid;
  BoundaryData boundary;
  ContactSet contacts;
  std::optional<MotionProblem> motion;
  std::optional<DamageProblem> damage;
  std::optional<HeatProblem> heat;
  std::optional<Ledger> ledger;

  explicit AllPhysics(Mesh mesh, ContactMethod method)
      : d(discretise(std::move(mesh), {{PointLaw{law()}, {"lower"}}, {PointLaw{tool()}, {"upper"}, "tool"}},
                     Frame::plane_strain, 1)),
        rigid(d, {}, 1), boundary(d.mesh, {}, 1, rigid.body_of_node()) {
    declare_state(d, state);
    rigid.declare_state(state);
    ContactSettings settings;
    settings.id = "face";
    settings.method = method;
    settings.secondary = "upper_bottom";
    settings.primary = "lower top";
    ContactEnvironment environment;
    environment.modulus = 1;
    contacts.emplace_back(d.mesh, d.displacement, settings, environment, state);
    motion.emplace(d, state, boundary, contacts, false, ContactOperator::assembled, MatrixFormat::aij,
                   &rigid);
    DamageScenario bounds;
    bounds.bounds = DamageBounds::history;
    damage.emplace(d, state, boundary, bounds);
    heat.emplace(d, state, boundary, HeatScenario{.form = HeatForm::energy}, true);
    ledger.emplace(*motion, state, true, 1);
  }
  static MaterialParameters law() {
    MaterialParameters m;
    m.model = Model::j2;
    m.K = m.G = m.rho = m.Gc = m.gamma = m.b_d = m.c = m.c_v = m.fatigue_a = 1;
    m.sigma_y = 0.1;
    m.damage = Damage::at2;
    m.jc_failure = true;
    m.jc_d1 = 1;
    return m;
  }
  static MaterialParameters tool() {
    MaterialParameters m;
    m.model = Model::rigid;
    m.rho = 1;
    return m;
  }
};

using Rows = std::map<std::string, std::pair<Support, int>>;

// The rows of a run with all its physics, but for "step_control" of the time loop. A change here changes what
// a checkpoint holds: old ones cannot be read any more.
const Rows known = {
    {"u", {Support::vertex, 2}},
    {"v", {Support::vertex, 2}},
    {"a", {Support::vertex, 2}},
    {"mean_rate", {Support::vertex, 2}},           // guess of the next step
    {"prescribed_velocity", {Support::vertex, 2}}, // of dofs with acceleration data
    {"phi", {Support::vertex, 1}},
    {"theta", {Support::vertex, 1}},
    {"stress", {Support::cell_point, 5}},  // P and p of the motion, for the work of the next step
    {"ledger_heat", {Support::global, 3}}, // supplied, its entropy, entropy at the start
    {"history", {Support::cell_point, 5}}, // Cp^-1 and alpha
    {"drive", {Support::cell_point, 3}},
    {"fatigue", {Support::cell_point, 1}},
    {"jc_failure", {Support::cell_point, 1}},
    {"damage_history", {Support::cell_point, 1}},
    {"contact_face_multiplier", {Support::facet_point, 1}}, // by the method, see multipliers
    {"contact_face_left", {Support::facet_point, 2}},       // likewise
    {"contact_face_penalty", {Support::global, 4}},
    {"contact_face_totals", {Support::global, 10}},
    {"contact_face_carried", {Support::vertex, 2}},
    {"contact_face_force", {Support::vertex, 2}},
    {"rigid", {Support::global, 7}},            // angle and reactions of a body
    {"ledger_totals", {Support::global, 0}},    // as many as the ledger counts
    {"ledger_materials", {Support::global, 8}}, // four kinds of dissipation in each of two materials
    {"force_internal", {Support::vertex, 2}},
    {"force_external", {Support::vertex, 2}},
    {"force_contact", {Support::vertex, 2}},
    {"force_inertia", {Support::vertex, 2}},
    {"force_left", {Support::vertex, 2}}, // of the balance, by Newton's method
    {"a_before", {Support::vertex, 2}},
    {"bc_foundations", {Support::global, 2}}, // stored by springs, taken by dashpots
    {"force_damage", {Support::vertex, 1}},   // on prescribed phi
};

AllPhysics make(ContactMethod method) {
  return AllPhysics(
      run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("state_rows"), run_test::two_bodies(6)),
      method);
}

// Multipliers stand at the points of the facets, or at the nodes.
const std::map<ContactMethod, Support> multipliers = {{ContactMethod::gauss_points, Support::facet_point},
                                                      {ContactMethod::mortar, Support::vertex}};

// Numbers that use all bits, say where they belong and are the same wherever a place is stored twice: ghosts,
// padding lanes, all ranks of a global row.
std::vector<double> numbers(const AllPhysics& run, const StateRow& row, double salt) {
  std::vector<double> values(row.committed.size());
  const auto number = [&](double place, std::size_t k) {
    return std::sin(salt + 3 * place + 7 * static_cast<double>(k + row.name.size())) / 3;
  };
  const auto components = static_cast<std::size_t>(row.components);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = number(static_cast<double>(i), 0);
  if (row.support == Support::vertex)
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = number(static_cast<double>(run.d.mesh.global_node()[i / components]), i % components);
  if (row.support == Support::cell_point) {
    std::size_t next = 0;
    for (const CellGroup& g : run.d.groups)
      for (int b = 0; b < g.batch_count; ++b)
        for (int q = 0; q < point_count(g.shape); ++q)
          for (std::size_t k = 0; k < components; ++k)
            for (int l = 0; l < lanes; ++l)
              values[next++] = number(
                  static_cast<double>(g.cell_point[static_cast<std::size_t>(b * lanes + l)] * 16 + q), k);
  }
  return values;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

TEST(StateRows, AreExactlyTheKnownOnesAndAllAreKeptByCheckpoints) {
  for (const auto& [method, support] : multipliers) {
    SCOPED_TRACE(support == Support::vertex ? "mortar" : "gpts");
    const AllPhysics run = make(method);
    Rows missing = known;
    missing["contact_face_multiplier"].first = missing["contact_face_left"].first = support;
    for (const auto& row : run.state.rows()) {
      const auto found = missing.find(row->name);
      ASSERT_NE(found, missing.end()) << "row " << row->name << " is not known here";
      EXPECT_EQ(row->support, found->second.first) << row->name;
      if (found->second.second > 0) {
        EXPECT_EQ(row->components, found->second.second) << row->name;
      }
      EXPECT_TRUE(row->checkpointed) << row->name << " would be lost at a restart";
      EXPECT_TRUE(row->has_trial) << row->name << " would keep what a rejected step wrote";
      EXPECT_EQ(row->committed.size(), row->trial.size()) << row->name;
      missing.erase(found);
    }
    for (const auto& [name, shape] : missing) ADD_FAILURE() << "row " << name << " is not in the table";
  }
}

TEST(StateRows, RollbackAndCommitReachEveryValueOfEveryRow) {
  for (const auto& [method, support] : multipliers) {
    SCOPED_TRACE(support == Support::vertex ? "mortar" : "gpts");
    AllPhysics run = make(method);
    std::size_t values = 0;
    for (const auto& row : run.state.rows()) {
      row->committed = numbers(run, *row, 1);
      row->trial = numbers(run, *row, 2);
      values += row->committed.size();
    }
    EXPECT_GT(values, 0u);
    run.state.rollback();
    for (const auto& row : run.state.rows()) {
      EXPECT_TRUE(same_bits(row->committed, numbers(run, *row, 1))) << row->name << ": rollback changed t_n";
      EXPECT_TRUE(same_bits(row->trial, row->committed)) << row->name << " keeps what a rejected step wrote";
      row->trial = numbers(run, *row, 3);
    }
    run.state.commit();
    for (const auto& row : run.state.rows()) {
      EXPECT_TRUE(same_bits(row->committed, numbers(run, *row, 3))) << row->name << " lost an accepted step";
      EXPECT_TRUE(same_bits(row->trial, row->committed)) << row->name;
    }
  }
}

TEST(StateRows, ACheckpointReturnsEveryBitOfEveryRow) {
  for (const auto& [method, support] : multipliers) {
    SCOPED_TRACE(support == Support::vertex ? "mortar" : "gpts");
    AllPhysics run = make(method);
    for (const auto& row : run.state.rows()) {
      row->committed = numbers(run, *row, 4);
      row->trial = numbers(run, *row, 5); // of an attempt that is under way: not in the checkpoint
    }
    const std::string file = CheckpointWriter({run.d.mesh, run.d.groups, run.state},
                                              {run_test::fresh_dir("state_rows_checkpoint"), 1})
                                 .write({});
    for (const auto& row : run.state.rows()) {
      row->committed.assign(row->committed.size(), -7);
      row->trial.assign(row->trial.size(), -7);
    }
    read_checkpoint(open_checkpoint(PETSC_COMM_WORLD, file), {run.d.mesh, run.d.groups, run.state});
    for (const auto& row : run.state.rows()) {
      EXPECT_TRUE(same_bits(row->committed, numbers(run, *row, 4)))
          << row->name << " is not what was written";
      EXPECT_TRUE(same_bits(row->trial, row->committed)) << row->name;
    }
  }
}

} // namespace
} // namespace impact
