#pragma once
#include <impact/kernel/point_data.hpp>

/// Growth of the fatigue variable of one batch of cells over a step (F1'), after the damage solve:
///   Fat = Fat_n + (a/gamma) (1 - phi) phi |W|,   W = 1/2 [ 1/2 (S_c + S_c,n) + S_d ] : (C - C_n)
/// S_c is the elastic stress of the undamaged body with the plastic state and the locking cure of the motion,
/// S_d = 2 b_d (C - C_n)/dt. In an elastic body 1/2 (S_c + S_c,n) : (C - C_n)/2 is the change of its energy
/// to third order, so that a few steps resolve a cycle; no rotation counts.
namespace impact {

struct FatigueInput {
  const Batch* X = nullptr;         ///< [node][dim] reference coordinates
  const Batch* u = nullptr;         ///< [node][dim] accepted displacement at t_{n+1}
  const Batch* u_n = nullptr;       ///< [node][dim] at t_n
  const Batch* phi = nullptr;       ///< [node] at t_{n+1}
  const Batch* theta = nullptr;     ///< [node] that the motion solve saw, or nullptr (= theta0)
  const Batch* theta_n = nullptr;   ///< [node] at t_n; with theta
  const Batch* history = nullptr;   ///< [point][history_size] at t_{n+1}; nullptr for Model::elastic
  const Batch* history_n = nullptr; ///< at t_n
  const Batch* fatigue_n = nullptr; ///< [point] Fat_n
  double dt = 1;
};

/// Sums over the points, per lane; fatigue_advance adds to them.
struct FatigueSums {
  Batch dissipation = 0; ///< int phi (Fat - Fat_n)/gamma
  Batch least = 0;       ///< smallest dissipation per volume at a point, at most 0
};

} // namespace impact
