#pragma once
#include <impact/mesh/middle_values.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/problem/surface_load.hpp>

namespace impact {

/// Heat sources in regions, and fluxes and convection on surfaces, over one step. All is an energy per unit
/// thickness; `supplied` counts it by condition, this rank's part.
class HeatLoads {
public:
  HeatLoads(const Discretisation& discretisation, const BoundaryData& boundary);

  /// Evaluates the data at both ends of a step, of which the start counts where `theta`, the weight of the
  /// end, is less than 1. Throws UserError(data) where an expression has no value, on this rank alone.
  void evaluate(double t_n, double t, double theta);
  bool on_surfaces() const { return !surfaces_.empty(); }

  /// What does not depend on the temperature of the end, into load [node] and supplied.
  void add_start(double theta, double dt, const std::vector<double>& theta_n, std::vector<double>& load,
                 std::vector<double>& supplied) const;
  /// What surfaces take in at the temperature of the end: `weight` is its part of the step's length.
  void add_end(double weight, const std::vector<double>& temperature, std::vector<double>& load,
               std::vector<double>& supplied) const;
  /// Its derivative into the matrix of a residual that takes loads with a minus, without held nodes; the
  /// caller assembles.
  void add_tangent(double weight, const std::vector<char>& held, const MiddleValues* middles,
                   Mat matrix) const;

private:
  struct Source {
    int condition;
    std::vector<char> inside;     ///< [group][batch][lane] the cell lies in the region
    std::vector<double> value[2]; ///< [group][batch][point][lane] at t_n and t_{n+1}
  };
  struct Surface {
    const LoadedFacets* load;
    SurfaceHeat heat[2]; ///< at t_n and t_{n+1}
  };
  void evaluate(double t, int end);

  const Discretisation& d_;
  const BoundaryData& boundary_;
  std::vector<double> X_;
  std::vector<Source> sources_;
  std::vector<Surface> surfaces_;
};

} // namespace impact
