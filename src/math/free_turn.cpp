#include <impact/math/free_turn.hpp>
#include <limits>

namespace impact {

namespace {

constexpr int most_iterations = 100;

Vector3 turned_back(const Vector3& turn, const Vector3& x) {
  return rotation_of({-turn[0], -turn[1], -turn[2]}) * x;
}

} // namespace

Vector3 free_turn(const Matrix3& inverse_of_inertia, const Vector3& momentum, double dt) {
  Vector3 turn{}, next{};
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most_iterations; ++i) {
    Vector3 mean = turned_back(turn, momentum);
    for (std::size_t k = 0; k < 3; ++k) mean[k] = dt / 2 * (mean[k] + momentum[k]);
    next = inverse_of_inertia * mean;
    const double change = length(minus(next, turn));
    turn = next;
    if (change == 0 || (change < 1e-14 * length(turn) && change >= last)) break; // only rounding is left
    last = change;
  }
  return turn;
}

Matrix3 momentum_by_turn(const Matrix3& inertia, const Vector3& turn) {
  Matrix3 mean = rotation_of({-turn[0], -turn[1], -turn[2]});
  for (std::size_t i = 0; i < 9; ++i) mean[i] = (mean[i] + unit_matrix[i]) / 2;
  return inverse(mean) * inertia;
}

} // namespace impact
