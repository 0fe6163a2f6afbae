#pragma once
#include <impact/contact/impulse_rows.hpp>
#include <impact/mesh/state_table.hpp>
#include <impact/problem/motion.hpp>
#include <impact/solve/body_work.hpp>
#include <span>
#include <vector>

/// Rigid bodies of the mesh, obstacles with mass among them, in steps by central differences (theory.md, 9b):
/// the centre of mass as any node, the rotation by half a step's torque, a free turn that keeps momentum and
/// energy exactly, and the other half. Where the bodies stand is a row of the table; their nodes follow.
namespace impact {

class ExplicitBodies : public ImpulseBodies {
public:
  /// Adds the row "rigid_motion" where there are bodies. The references must outlive the object.
  ExplicitBodies(MotionProblem& motion, StateTable& state);

  bool empty() const { return rigid_.empty(); }
  /// Into the committed half: where bodies stand and how fast, from displacement and velocity. Collective.
  void start(Vec u, Vec v);
  /// Turns the arms of contacts as the committed state has them, after a start or a restart.
  void resume();
  /// The longest step in which no body turns too far for its turn to be found.
  double longest() const;

  /// New places after a step of length dt, to the nodes of u.
  void move(double dt, Vec u);
  /// Torque and acceleration of the start by forces f_k, each with a factor; the first step is dt long. To
  /// the nodes of a. Collective.
  struct Force {
    Vec f;
    double factor;
  };
  void start_forces(double t, double dt, std::span<const Force> forces, Vec a);
  /// After `move`: the forces at the new places give acceleration, torque and velocity there, t being their
  /// time; again, where more of them are known. `stiffness`: of each body what this rank's contacts added to
  /// it (ContactInterface::add_residual). Returns the largest frequency of the bodies by these, squared.
  /// Collective.
  double push(double t, std::span<const Force> forces, std::span<const double> stiffness, Vec a);
  /// Velocities of the nodes, `later` by this time at the acceleration of now.
  void put_velocity(Vec v, double later = 0) const;
  /// x = 0 on their nodes.
  void leave_out(Vec x) const;
  void strike(Vec f, Vec gain) const override { rigid_.strike(f, gain, RigidBodies::ArmsAt::end); }
  void bound(Vec sizes, Vec most) const override;

  /// Of the last step.
  const BodyWork& work() const { return work_; }
  /// BodyWork::kept of the committed state, at the start of a step of length dt.
  double kept(double dt) const;

private:
  /// One body in the row. Forces and moments are those of the nodes, without the reactions of prescribed
  /// motion, which acceleration and torque have in them.
  struct Motion {
    Vector3 moved{};
    Matrix3 turned = unit_matrix;
    Vector3 velocity{}, spin{}; ///< spin: angular momentum about the centre of mass
    Vector3 acceleration{}, torque{};
    Vector3 force{};
    Matrix3 moment{}; ///< sum of f Y^T, Y the reference arm
  };
  static constexpr std::size_t size = sizeof(Motion) / sizeof(double);
  Motion body(const std::vector<double>& half, std::size_t b) const;
  void keep(std::vector<double>& half, std::size_t b, const Motion& motion) const;
  Vector3 velocity_of(std::size_t b, const Matrix3& R, const Vector3& spin) const;
  void sum_up(std::span<const Force> forces, std::span<const double> stiffness);
  void prescribe(std::size_t b, double t, double dt, double share, Motion& m, const Motion* before) const;
  Vector3 prescribed_turn(std::size_t b, double t, double dt, const Matrix3& R) const;
  Vector3 spin_for(std::size_t b, double dt, const Matrix3& R, const Vector3& spin,
                   const Vector3& turn) const;
  void book(std::size_t b, const Motion& before, const Motion& half, const Motion& after);
  void put_acceleration(const std::vector<double>& half, Vec a) const;
  template <class Field> void set_nodes(Vec x, Field&& field) const;

  RigidBodies& rigid_;
  MPI_Comm comm_;
  int dim_;
  std::vector<RigidBodies::OwnedNode> nodes_;
  StateRow* row_ = nullptr;
  std::vector<Matrix3> inertia_, inverse_; ///< in the axes of the reference configuration
  std::vector<double> sums_;               ///< [body][force, moment, stiffness]
  std::vector<Vector3> turn_;              ///< rotation vectors of the step
  double dt_ = 0;
  BodyWork work_;
};

} // namespace impact
