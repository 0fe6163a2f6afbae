#pragma once
#include <impact/time/integrator.hpp>

/// An integrator of one's own, which the program does not know: backward Euler, v = v_n + dt a, u = u_n + dt
/// v.
namespace impact::time_test {

inline constexpr Integrator backward_euler{.beta = 1, .gamma = 1, .alpha_m = 1, .s = 2};

} // namespace impact::time_test
