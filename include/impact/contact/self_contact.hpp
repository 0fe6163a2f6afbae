#pragma once
#include <array>
#include <mpi.h>
#include <vector>

/// What tells a surface that may meet itself, or the skin of several bodies under one name, which of its
/// pairs of facets may touch, and which facet of a pair is the secondary one (theory.md, contact). All is
/// judged in the reference configuration, from what does not depend on the number of ranks and turns with the
/// bodies.
namespace impact {

/// A facet reduced to what the rules need.
struct FacetShape {
  std::array<double, 3> centre{}, normal{}; ///< mean of the corners; outward unit normal
  double size = 0;                          ///< longest side
  int body = 0;
};

/// `x`: four corners of three coordinates, of which one with fewer corners repeats the last; in the plane the
/// third coordinate is zero and the body lies to the left of the way from the first corner to the second.
FacetShape facet_shape(int dim, const std::array<double, 12>& x, int body);

/// Outward normals whose product lies below minus this number oppose each other (100 degrees and more).
inline constexpr double least_opposition = 0.17;

class SelfContact {
public:
  SelfContact() = default;
  /// `shapes`: reference facets of this rank's cells, each facet on one rank. Collective.
  SelfContact(MPI_Comm comm, int dim, const std::vector<FacetShape>& shapes);

  /// False for facets of one body that are neighbours along its surface (normals that do not oppose, centres
  /// nearer than 1.1 times both sizes), and for those that have it between them: each centre behind the other
  /// facet, nearer than `range`. Symmetric.
  static bool may_touch(const FacetShape& a, const FacetShape& b, double range);
  /// How far `other` lies behind `facet` through one body, over it; infinite where it does not.
  static double thickness(const FacetShape& facet, const FacetShape& other);
  /// True when `a` is the secondary facet of the pair: exactly one of (a, b) and (b, a), unless they are
  /// equal. The side is decided by the difference of the normals, or where these are nearly equal of the
  /// centres, in directions that no symmetry of the surface shares: two sides of a gap, a notch or a fold are
  /// decided alike facet by facet.
  bool is_secondary(const FacetShape& a, const FacetShape& b) const;

private:
  std::array<std::array<double, 3>, 3> direction_{}; // orthonormal
  std::size_t dim_ = 2;
};

} // namespace impact
