#pragma once
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/discretisation.hpp>

namespace impact {

/// Body forces: accelerations at the nodes times the mass of the cells of their regions alone, consistent or
/// lumped as the discretisation has it. Cells that have left count where their mass stays.
class BodyLoad {
public:
  /// Both must outlive this. Throws UserError(data).
  BodyLoad(const Discretisation& discretisation, const BoundaryData& boundary);

  /// Adds the forces at time t, N per unit thickness, to [node][dim], to be summed over ranks. Data that did
  /// not change since the last call cost no loop over cells. Throws UserError(data) where an expression has
  /// no value, on this rank alone.
  void add(double t, std::vector<double>& load);

private:
  struct Region {
    int condition;
    std::vector<char> inside;         ///< [group][batch][lane] the cell lies in the region
    std::vector<double> acceleration; ///< [node][dim] of which load_ was made
  };
  void assemble(const Region& region);

  const Discretisation& d_;
  const BoundaryData& boundary_;
  std::vector<Region> regions_;
  std::vector<int> weightless_; ///< of the discretisation, then
  std::vector<double> load_;    ///< [node][dim]
  std::vector<double> now_;     ///< work array
};

} // namespace impact
