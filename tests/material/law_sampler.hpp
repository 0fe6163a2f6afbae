#pragma once
#include "reference_law.hpp"

#include <impact/material/point_law.hpp>

namespace reference {

/// Random states of a point.
struct Sampler : TensorSampler {
  using TensorSampler::TensorSampler;
  template <int d> impact::PointHistory<double, d> history(double size) {
    return {unimodular<d>(size), uniform(0, 0.05)};
  }
};

} // namespace reference
