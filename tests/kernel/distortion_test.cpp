#include "reference_cell.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <impact/kernel/distortion.hpp>

using namespace impact;
using reference::aluminium;

namespace {

/// Of u = A X on a cell with the corners of the unit one.
template <class Cell, Frame frame> CellDistortion distortion(const double (&A)[3][3]) {
  MaterialParameters m = aluminium();
  m.model = Model::elastic;
  const PointLaw law{m};
  Batch X[Cell::nodes * Cell::dim], u[Cell::nodes * Cell::dim];
  for (int a = 0; a < Cell::nodes; ++a)
    for (int i = 0; i < Cell::dim; ++i) {
      X[a * Cell::dim + i] = Batch(1.0 + double(Cell::sign[a][i]) / 2);
      u[a * Cell::dim + i] = Batch(0.0);
    }
  for (int a = 0; a < Cell::nodes; ++a)
    for (int i = 0; i < Cell::dim; ++i)
      for (int j = 0; j < Cell::dim; ++j) u[a * Cell::dim + i] += Batch(A[i][j]) * X[a * Cell::dim + j];
  MotionInput in;
  in.X = X;
  in.u = u;
  CellDistortion out;
  cell_distortion<Cell, frame>(law, in, out);
  return out;
}

TEST(Distortion, OfAnEvenDeformationInThePlane) {
  // F = (1.5, 0.4; 0, 0.8): b = (2.41, 0.32; 0.32, 0.64)
  const double A[3][3] = {{0.5, 0.4, 0}, {0, -0.2, 0}, {0, 0, 0}};
  const CellDistortion d = distortion<Quad4, Frame::plane_strain>(A);
  const double mean = (2.41 + 0.64) / 2, radius = std::hypot((2.41 - 0.64) / 2, 0.32);
  EXPECT_NEAR(d.least_J[0], 1.2, 1e-14);
  EXPECT_NEAR(d.largest_stretch[0], std::sqrt(mean + radius), 1e-14);
}

TEST(Distortion, OfABodyThatIsPressedTheStretchIsThatAcrossThePlane) {
  const double A[3][3] = {{-0.3, 0, 0}, {0, -0.3, 0}, {0, 0, 0}};
  const CellDistortion d = distortion<Quad4, Frame::plane_strain>(A);
  EXPECT_NEAR(d.least_J[0], 0.49, 1e-14);
  EXPECT_NEAR(d.largest_stretch[0], 1, 1e-14);
}

TEST(Distortion, OfATurnedCellInSpace) {
  // stretched by 2, 1/2 and 1/4 and turned by a quarter about z
  const double A[3][3] = {{-1, -0.5, 0}, {2, -1, 0}, {0, 0, -0.75}};
  const CellDistortion d = distortion<Hex8, Frame::solid>(A);
  EXPECT_NEAR(d.least_J[0], 0.25, 1e-14);
  EXPECT_NEAR(d.largest_stretch[0], 2, 1e-14);
}

TEST(Distortion, OfACellTurnedInsideOutTheSmallestVolumeCounts) {
  const double A[3][3] = {{-1.1, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  EXPECT_LT((distortion<Quad4, Frame::plane_strain>(A).least_J[0]), 0);
}

} // namespace
