#include <algorithm>
#include <cmath>
#include <impact/contact/obstacle.hpp>
#include <impact/math/rotation.hpp>
#include <impact/math/vector3.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

struct Corner {
  std::array<double, 3> X{};
  PetscInt node = 0;
};

// All nodes of a region on all ranks, by their coordinates: the same order for every partition.
std::vector<Corner> nodes_of(const Mesh& mesh, const std::string& region) {
  const auto dim = index(mesh.dim());
  std::vector<double> mine;
  for (int node : mesh.nodes(region)) {
    if (!mesh.owned(node)) continue;
    mine.insert(mine.end(), {0, 0, 0, static_cast<double>(mesh.global_node()[index(node)])});
    std::copy_n(&mesh.coordinates()[dim * index(node)], dim, mine.end() - 4);
  }
  int ranks = 0, size = static_cast<int>(mine.size());
  MPI_Comm_size(mesh.comm(), &ranks);
  std::vector<int> sizes(index(ranks)), first(index(ranks) + 1, 0);
  MPI_Allgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, mesh.comm());
  for (std::size_t r = 0; r < sizes.size(); ++r) first[r + 1] = first[r] + sizes[r];
  std::vector<double> all(index(first.back()));
  MPI_Allgatherv(mine.data(), size, MPI_DOUBLE, all.data(), sizes.data(), first.data(), MPI_DOUBLE,
                 mesh.comm());
  std::vector<Corner> nodes;
  for (std::size_t i = 0; i < all.size(); i += 4)
    nodes.push_back({{all[i], all[i + 1], all[i + 2]}, static_cast<PetscInt>(all[i + 3])});
  std::sort(nodes.begin(), nodes.end(), [](const Corner& a, const Corner& b) { return a.X < b.X; });
  return nodes;
}

// Nodes that span the space as widely as may be: each the farthest from the span of those before, the first
// from the mean. Refined meshes have more nodes than are needed.
std::vector<Corner> widest(const std::vector<Corner>& nodes, std::size_t count) {
  std::vector<Corner> chosen;
  std::vector<std::array<double, 3>> axis; // unit vectors of the span
  std::array<double, 3> origin{};
  for (const Corner& node : nodes)
    for (std::size_t k = 0; k < 3; ++k) origin[k] += node.X[k] / static_cast<double>(nodes.size());
  double size = 0;
  while (chosen.size() < count) {
    double farthest = 0;
    std::array<double, 3> way{};
    const Corner* next = nullptr;
    for (const Corner& node : nodes) {
      Vector3 d = minus(node.X, origin);
      for (const Vector3& a : axis) {
        const double along = dot(d, a);
        for (std::size_t k = 0; k < 3; ++k) d[k] -= along * a[k];
      }
      const double distance = std::hypot(d[0], d[1], d[2]);
      // Of equals the first, whatever their last digits say.
      if (next != nullptr && !(distance > (1 + 1e-9) * farthest)) continue;
      farthest = distance;
      way = d;
      next = &node;
    }
    size = std::max(size, farthest);
    if (next == nullptr || !(farthest > 1e-9 * size)) return {};
    if (!chosen.empty()) {
      for (double& component : way) component /= farthest;
      axis.push_back(way);
    }
    chosen.push_back(*next);
    origin = chosen.front().X;
  }
  return chosen;
}

} // namespace

Obstacle::Obstacle(const Mesh& mesh) : dim_(index(mesh.dim())) {}

Obstacle::Obstacle(const Mesh& mesh, const std::string& region, const RigidObstacle& at_rest)
    : Obstacle(mesh) {
  pose_.obstacle = at_rest;
  const std::vector<Corner> corners = widest(nodes_of(mesh, region), dim_ + 1);
  if (corners.empty())
    throw UserError(ExitCode::data, "region " + region + ": spans no space; an obstacle cannot move with it");
  // The pole of a cylinder in space would turn with it.
  if (dim_ == 3 && at_rest.shape == RigidObstacle::Shape::cylinder) pose_.obstacle.outward = {};
  Matrix3 edges = unit_matrix; // columns
  for (std::size_t b = 0; b < dim_; ++b)
    for (std::size_t k = 0; k < dim_; ++k) edges[3 * k + b] = corners[b + 1].X[k] - corners[0].X[k];
  const Matrix3 slopes = inverse(edges); // rows: gradients of the weights of corners 1, 2, 3
  for (std::size_t b = 0; b <= dim_; ++b) node_.push_back(corners[b].node);
  for (std::size_t k = 0; k < dim_; ++k)
    for (std::size_t b = 0; b < dim_; ++b) {
      axis_[k][b + 1] = slopes[3 * b + k];
      axis_[k][0] -= slopes[3 * b + k];
    }
  shares_.place[0] = 1;
  for (std::size_t k = 0; k < dim_; ++k)
    for (std::size_t b = 0; b <= dim_; ++b)
      shares_.place[b] += axis_[k][b] * (pose_.obstacle.point[k] - corners[0].X[k]);
  shares_.direction = of_direction(pose_.obstacle.direction);
}

Obstacle::Weights Obstacle::of_direction(const std::array<double, 3>& at_rest) const {
  Weights weights{};
  for (std::size_t k = 0; k < dim_; ++k)
    for (std::size_t b = 0; b <= dim_; ++b) weights[b] += at_rest[k] * axis_[k][b];
  return weights;
}

void Obstacle::locate(const ContactNodes& nodes) {
  slot_.clear();
  for (PetscInt node : node_) slot_.push_back(nodes.slot(node));
}

RigidObstacle Obstacle::at(const ContactValues& u) const {
  RigidObstacle now = pose_.obstacle;
  for (std::size_t b = 0; b < slot_.size(); ++b)
    for (std::size_t k = 0; k < dim_; ++k) {
      const double moved = u[dim_ * index(slot_[b]) + k];
      now.point[k] += shares_.place[b] * moved;
      now.pole[k] += shares_.place[b] * moved;
      now.direction[k] += shares_.direction[b] * moved;
    }
  return now;
}

CarriedFunction Obstacle::gap(const RigidObstacle& now, const std::array<double, 3>& x) const {
  if (carried()) return carried_gap(now, x);
  const ObstacleGap gap = gap_to(now, x); // whose direction is a unit vector and stays
  CarriedFunction f;
  f.value = gap.gap;
  f.by_place = gap.normal;
  f.place_place = gap.curvature;
  return f;
}

std::array<std::array<double, 3>, 2> Obstacle::tangents() const {
  const std::array<double, 3>& n = pose_.obstacle.direction;
  if (dim_ == 2) return {{{-n[1], n[0], 0}, {}}};
  return tangents_of(n);
}

void Obstacle::anchor(const ContactNodes& nodes, const ContactValues& x) {
  pose_.moved = {};
  per_facet_ = index(nodes.per_facet);
  start_.resize(dim_ * nodes.secondary.size());
  for (std::size_t i = 0; i < start_.size(); ++i)
    start_[i] = x[dim_ * index(nodes.secondary[i / dim_]) + i % dim_];
  if (!carried()) return;
  // Places are brought back to the reference configuration, where their weights are known.
  std::array<double, 3> centre{};
  Matrix3 turned{}; // columns: where the axes x, y, z point
  for (std::size_t b = 0; b < slot_.size(); ++b)
    for (std::size_t k = 0; k < dim_; ++k) {
      const double coordinate = x[dim_ * index(slot_[b]) + k];
      centre[k] += shares_.place[b] * coordinate;
      for (std::size_t j = 0; j < dim_; ++j) turned[3 * k + j] += axis_[j][b] * coordinate;
    }
  carried_.assign(nodes.secondary.size(), shares_.place);
  for (std::size_t i = 0; i < carried_.size(); ++i)
    for (std::size_t j = 0; j < dim_; ++j) {
      double along = 0;
      for (std::size_t k = 0; k < dim_; ++k) along += turned[3 * k + j] * (start_[dim_ * i + k] - centre[k]);
      for (std::size_t b = 0; b <= dim_; ++b) carried_[i][b] += along * axis_[j][b];
    }
}

void Obstacle::add_slip(const ContactNodes& nodes, int facet, std::span<const double> weight,
                        const std::array<double, 3>& tangent, const ContactValues& u, double& value,
                        PlaneSlip& slip) const {
  const int* secondary = &nodes.secondary[index(nodes.per_facet * facet)];
  slip = {};
  if (!carried()) {
    for (std::size_t a = 0; a < weight.size(); ++a)
      for (std::size_t k = 0; k < dim_; ++k) {
        const std::size_t i = dim_ * index(secondary[a]) + k;
        value += weight[a] * tangent[k] * (nodes.X[i] + u[i] - nodes.start[i] - pose_.moved[k]);
      }
    slip.function.by_place = tangent;
    return;
  }
  slip.shares.direction = of_direction(tangent);
  std::array<double, 3> t = tangent, q{};
  const auto seen = [&](int slot, std::size_t k) { // from the first corner of the facet
    const std::size_t i = dim_ * index(slot) + k, o = dim_ * index(secondary[0]) + k;
    return (nodes.X[i] - nodes.X[o]) + (u[i] - u[o]);
  };
  for (std::size_t a = 0; a < weight.size(); ++a) {
    const Weights& opposite = carried_[per_facet_ * index(facet) + a];
    for (std::size_t b = 0; b <= dim_; ++b) slip.shares.place[b] += weight[a] * opposite[b];
    for (std::size_t k = 0; k < dim_; ++k) q[k] += weight[a] * seen(secondary[a], k);
  }
  for (std::size_t b = 0; b < slot_.size(); ++b)
    for (std::size_t k = 0; k < dim_; ++k) {
      q[k] -= slip.shares.place[b] * seen(slot_[b], k);
      t[k] += slip.shares.direction[b] * u[dim_ * index(slot_[b]) + k];
    }
  slip.function = carried_product(q, t);
  value += slip.function.value;
}

void Obstacle::add_gradient(const CarriedFunction& f, std::span<const double> shape, const Shares& shares,
                            double factor, double* gradient) const {
  for (std::size_t a = 0; a < shape.size(); ++a)
    for (std::size_t k = 0; k < dim_; ++k) gradient[dim_ * a + k] += factor * shape[a] * f.by_place[k];
  gradient += dim_ * shape.size();
  for (std::size_t b = 0; b < slot_.size(); ++b) {
    const std::array<double, 3> g = gradient_by(f, {-shares.place[b], shares.direction[b]});
    for (std::size_t k = 0; k < dim_; ++k) gradient[dim_ * b + k] += factor * g[k];
  }
}

void Obstacle::add_hessian(const CarriedFunction& f, std::span<const double> shape, const Shares& shares,
                           double factor, double* block) const {
  const std::size_t count = shape.size() + slot_.size(), n = dim_ * count;
  if (!carried()) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        block[n * i + j] +=
            factor * shape[i / dim_] * shape[j / dim_] * f.place_place[3 * (i % dim_) + j % dim_];
    return;
  }
  const auto share = [&](std::size_t node) -> CarriedShare {
    if (node < shape.size()) return {shape[node], 0};
    return {-shares.place[node - shape.size()], shares.direction[node - shape.size()]};
  };
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b) {
      const std::array<double, 9> H = hessian_by(f, share(a), share(b));
      for (std::size_t i = 0; i < dim_; ++i)
        for (std::size_t j = 0; j < dim_; ++j)
          block[n * (dim_ * a + i) + dim_ * b + j] += factor * H[3 * i + j];
    }
}

void Obstacle::chain(int facet, const double* by_places, double* by_corners) const {
  std::fill(by_corners, by_corners + dim_ * slot_.size(), 0.0);
  for (std::size_t l = 0; l < per_facet_; ++l)
    for (std::size_t b = 0; b < slot_.size(); ++b)
      for (std::size_t k = 0; k < dim_; ++k)
        by_corners[dim_ * b + k] += carried_[per_facet_ * index(facet) + l][b] * by_places[dim_ * l + k];
}

void Obstacle::chain_block(int facet, std::span<const double> block, std::vector<double>& chained) const {
  const std::size_t half = dim_ * per_facet_, m = 2 * half, n = half + dim_ * slot_.size();
  std::vector<double> rows(m * n); // columns chained
  for (std::size_t i = 0; i < m; ++i) {
    std::copy_n(&block[m * i], half, &rows[n * i]);
    chain(facet, &block[m * i + half], rows.data() + n * i + half); // of no corners where none carries it
  }
  chained.assign(n * n, 0.0);
  std::copy_n(rows.begin(), half * n, chained.begin());
  for (std::size_t l = 0; l < per_facet_; ++l)
    for (std::size_t b = 0; b < slot_.size(); ++b)
      for (std::size_t k = 0; k < dim_; ++k)
        for (std::size_t j = 0; j < n; ++j)
          chained[n * (half + dim_ * b + k) + j] +=
              carried_[per_facet_ * index(facet) + l][b] * rows[n * (half + dim_ * l + k) + j];
}

std::array<double, 3> pole_of(const ContactSettings& settings, const Mesh& mesh,
                              const ContactSurface& secondary) {
  Vector3 outward{};
  if (!settings.rigid() || settings.primary == "plane") return outward;
  // Towards the middle of the secondary side, in few digits: the same on any number of ranks.
  std::array<double, 4> sum{};
  const auto d = index(mesh.dim());
  for (std::size_t i = 0; i < secondary.X.size(); ++i) sum[i % d] += secondary.X[i];
  sum[3] = static_cast<double>(secondary.X.size() / d);
  sum_over_ranks(mesh.comm(), sum);
  const Vector3 axis = {settings.axis[0], settings.axis[1], settings.axis[2]};
  const auto drop_axis = [&](Vector3& way) {
    const double along = dot(way, axis);
    for (std::size_t k = 0; k < 3; ++k) way[k] -= along * axis[k];
  };
  const bool cylinder = settings.primary == "rigid_cylinder";
  Vector3 way{};
  for (std::size_t k = 0; k < 3; ++k) way[k] = sum[k] / sum[3] - settings.centre[k];
  if (cylinder) drop_axis(way);
  if (d == 2) way[2] = 0;
  const double length = std::hypot(way[0], way[1], way[2]);
  if (!(length > 1e-3 * settings.radius)) return outward;
  for (double& component : way) component = std::round(1024 * component / length);
  const double rounded = std::hypot(way[0], way[1], way[2]);
  for (std::size_t k = 0; k < 3; ++k) outward[k] = way[k] / rounded;
  if (!cylinder) return outward;
  // Across the axis to rounding.
  drop_axis(outward);
  const double across = std::hypot(outward[0], outward[1], outward[2]);
  for (double& component : outward) component /= across;
  return outward;
}

std::array<double, 3> rigid_displacement(const ContactSettings& settings, int dim, double t) {
  std::array<double, 3> displacement{};
  for (std::size_t k = 0; settings.rigid() && k < index(dim); ++k)
    if (settings.rigid_motion[k]) displacement[k] = settings.rigid_motion[k](t);
  return displacement;
}

ObstaclePose rigid_pose(const ContactSettings& settings, int dim, double t,
                        const std::array<double, 3>& outward, const double* before) {
  using Body = RigidObstacle::Shape;
  const bool plane = settings.primary == "plane", sphere = settings.primary == "rigid_sphere";
  const std::array<double, 3> now = rigid_displacement(settings, dim, t);
  ObstaclePose pose;
  RigidObstacle& obstacle = pose.obstacle;
  obstacle.shape = plane ? Body::plane : sphere ? Body::sphere : Body::cylinder;
  obstacle.radius = settings.radius;
  obstacle.outward = outward;
  for (std::size_t k = 0; k < 3; ++k) {
    obstacle.point[k] = (plane ? settings.plane_point : settings.centre)[k] + now[k];
    obstacle.direction[k] = (plane ? settings.plane_normal : settings.axis)[k];
    obstacle.pole[k] = obstacle.point[k] + settings.radius * outward[k];
    pose.moved[k] = now[k] - before[k];
  }
  return pose;
}

} // namespace impact
