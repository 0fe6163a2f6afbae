#include <cmath>
#include <gtest/gtest.h>
#include <impact/math/rotation.hpp>
#include <numbers>
#include <random>

namespace impact {
namespace {

double distance(const Matrix3& a, const Matrix3& b) {
  double largest = 0;
  for (std::size_t i = 0; i < 9; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

class Rotations : public ::testing::Test {
protected:
  double number() { return spread_(generator_); }
  Vector3 vector(double length) {
    Vector3 v = {number(), number(), number()};
    const double size = std::hypot(v[0], v[1], v[2]);
    for (double& x : v) x *= length / size;
    return v;
  }

private:
  std::mt19937 generator_{7};
  std::uniform_real_distribution<double> spread_{-1, 1};
};

TEST_F(Rotations, VectorsComeBackAtAnyAngle) {
  for (double angle : {1e-12, 1e-7, 1e-3, 0.5, 2.0, 3.0, std::numbers::pi - 1e-7}) {
    const Vector3 v = vector(angle);
    const Vector3 again = rotation_vector(rotation_of(v));
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(again[k], v[k], 1e-15 + 2e-15 * angle) << angle;
  }
}

TEST_F(Rotations, AreOrthogonalAndTurnTheRightWay) {
  const Matrix3 R = rotation_of({0, 0, 0.3});
  EXPECT_NEAR(R[0], std::cos(0.3), 1e-16);
  EXPECT_NEAR(R[3], std::sin(0.3), 1e-16);
  for (int i = 0; i < 20; ++i) {
    const Matrix3 Q = rotation_of(vector(0.2 * i));
    EXPECT_LT(distance(Q * transposed(Q), unit_matrix), 4e-15);
    EXPECT_NEAR(determinant(Q), 1, 4e-15);
  }
}

TEST_F(Rotations, CayleysVectorMovesAlongTheMiddle) {
  const Vector3 c = vector(1.3), x0 = vector(2);
  const Matrix3 R = cayley(c);
  const Vector3 x1 = R * x0;
  Vector3 middle;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = (x0[k] + x1[k]) / 2;
  const Vector3 way = cross(c, middle), again = cayley_vector(R);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(way[k], x1[k] - x0[k], 1e-15);
    EXPECT_NEAR(again[k], c[k], 1e-15);
  }
  // The same rotation: 2 tan(angle/2) along the axis.
  const Vector3 v = rotation_vector(R);
  EXPECT_NEAR(2 * std::tan(std::hypot(v[0], v[1], v[2]) / 2), 1.3, 1e-14);
}

TEST_F(Rotations, TheNearestOneIsTheFactorOfStretchAndTurn) {
  for (int i = 0; i < 20; ++i) {
    const Matrix3 R = rotation_of(vector(0.15 * i));
    Matrix3 B;
    for (double& entry : B) entry = number();
    Matrix3 U = B * transposed(B); // positive
    for (std::size_t k = 0; k < 9; k += 4) U[k] += 0.1;
    EXPECT_LT(distance(nearest_rotation(R * U), R), 3e-15);
  }
  Matrix3 mirror = unit_matrix;
  mirror[0] = -1;
  EXPECT_TRUE(std::isnan(nearest_rotation(mirror)[0]));
}

TEST_F(Rotations, AxialVectorsSumMoments) {
  const Vector3 r = vector(1), f = vector(2), moment = cross(r, f);
  Matrix3 A;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t j = 0; j < 3; ++j) A[3 * k + j] = f[k] * r[j];
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(axial(A)[k], moment[k], 1e-15);
    EXPECT_NEAR((cross_matrix(r) * f)[k], moment[k], 1e-15);
  }
  Matrix3 B = {2, 1, 0, -1, 3, 0.5, 0.2, 0, 1};
  EXPECT_LT(distance(B * inverse(B), unit_matrix), 1e-15);
}

} // namespace
} // namespace impact
