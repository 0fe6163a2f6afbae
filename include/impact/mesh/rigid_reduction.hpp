#pragma once
#include <impact/math/rotation.hpp>
#include <petscsys.h>
#include <span>
#include <vector>

/// How matrix blocks over the dofs of nodes become blocks over the few unknowns of the rigid bodies that
/// these nodes belong to. The unknowns of a body, translation and rotation times a length, take the place of
/// the dofs of two of its nodes; its other dofs have no part in the matrix.
namespace impact {

/// One body at one state.
struct RigidPlace {
  std::array<PetscInt, 2> slot{}; ///< global nodes whose dofs stand for translation and rotation
  std::array<char, 6> held{};     ///< 1: translation 0..2, rotation 3..5 prescribed; in the plane 0, 1, 5
  double length = 1;              ///< that makes a rotation a displacement
  Vector3 centre{};               ///< of mass, in the reference configuration
  Matrix3 readiness{};            ///< to turn: mass over inertia, in the axes of the reference configuration
  Matrix3 trial = unit_matrix;    ///< reference arms to those of the variation of u
  Matrix3 test = unit_matrix;     ///< and to those of the test functions: the middle of the step
};

class RigidReduction {
public:
  explicit RigidReduction(int dim) : dim_(dim) {}

  int dim() const { return dim_; }
  int rotations() const { return dim_ == 3 ? 3 : 1; }
  std::vector<RigidPlace>& bodies() { return bodies_; }
  const std::vector<RigidPlace>& bodies() const { return bodies_; }

  /// Component k of displacement per unit of the body's unknowns [dim + rotations] at a reference place
  /// [dim], with the arms of `of`: RigidPlace::trial or test.
  void modes(const RigidPlace& body, const Matrix3& of, const double* X, int k, double* mode) const;
  /// Rows of the matrix of a body's unknowns, -1 where prescribed: [dim + rotations].
  void rows(const RigidPlace& body, PetscInt* row) const;

  /// A node of a block.
  struct Node {
    PetscInt node = 0;           ///< global
    int body = -1;               ///< -1: it moves freely
    const double* X = nullptr;   ///< [dim] of a node of a body
    const char* fixed = nullptr; ///< [dim] 1: prescribed, of a free node
  };
  /// The block [node][dim][node][dim] over the unknowns: test^T K trial. Keeps its space between calls.
  class Block {
  public:
    void build(const RigidReduction& reduction, std::span<const Node> nodes, std::span<const double> K);
    std::span<const PetscInt> rows() const { return rows_; } ///< -1: none
    std::span<const double> values() const { return values_; }

  private:
    std::vector<PetscInt> rows_;
    std::vector<double> values_, left_, right_, half_;
    std::vector<std::size_t> start_;
    std::vector<std::pair<int, std::size_t>> placed_; // of a body: its first unknown here
  };

private:
  int dim_;
  std::vector<RigidPlace> bodies_;
};

} // namespace impact
