#include <algorithm>
#include <cmath>
#include <impact/kernel/mortar_face.hpp>

namespace impact {

Point3 facet_normal(const FaceCorners& x) {
  // A triangle repeats its third corner: the diagonals of the quadrilateral are then two of its sides.
  return unit(cross(minus(x[2], x[0]), minus(x[3], x[1])));
}

double clearance(const FaceCorners& x, const FaceCorners& p) {
  const auto ball = [](const FaceCorners& corner) {
    Point3 middle{};
    double square = 0;
    for (const Point3& c : corner)
      for (std::size_t k = 0; k < 3; ++k) middle[k] += c[k] / 4;
    for (const Point3& c : corner) square = std::max(square, dot(minus(c, middle), minus(c, middle)));
    return std::pair(middle, std::sqrt(square));
  };
  const auto [mine, radius] = ball(x);
  const auto [other, reach] = ball(p);
  const Point3 d = minus(other, mine), n = cross(minus(x[2], x[0]), minus(x[3], x[1]));
  const double along = dot(d, n) / std::sqrt(dot(n, n)),
               across = std::sqrt(std::max(0., dot(d, d) - along * along));
  return across - std::abs(along) - radius - reach;
}

} // namespace impact
