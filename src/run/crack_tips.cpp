#include <algorithm>
#include <cmath>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/run/crack_tips.hpp>

namespace impact {

namespace {

using Place = std::array<double, 3>;

double distance2(const Place& a, const Place& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

class Search {
public:
  Search(const Mesh& mesh, const std::vector<char>& cracked)
      : mesh_(mesh), bodies_(find_bodies(mesh, cracked)) {}

  int count() const { return bodies_.count; }
  int body(int node) const { return bodies_.of_node[at(node)]; }

  Place place(int node) const {
    Place x{};
    const int dim = mesh_.dim();
    for (int k = 0; k < dim; ++k) x[at(k)] = mesh_.coordinates()[at(node * dim + k)];
    return x;
  }

  // The place of the largest value among the nodes of a body (-1: of any) that have one; of equal values that
  // with the smallest coordinates, so that no partition shows. `body` becomes the node's. Collective.
  Place largest(int& body, const std::function<double(int)>& value) const {
    std::array<double, 5> best{-HUGE_VAL, 0, 0, 0, -1};
    for (int i = 0; i < mesh_.node_count(); ++i) {
      if (this->body(i) < 0 || (body >= 0 && this->body(i) != body)) continue;
      const Place x = place(i);
      best = std::max(best, {value(i), -x[0], -x[1], -x[2], static_cast<double>(this->body(i))});
    }
    int ranks = 1;
    MPI_Comm_size(mesh_.comm(), &ranks);
    std::vector<std::array<double, 5>> all(at(ranks));
    MPI_Allgather(best.data(), 5, MPI_DOUBLE, all.data(), 5, MPI_DOUBLE, mesh_.comm());
    best = *std::ranges::max_element(all);
    body = static_cast<int>(best[4]);
    return {-best[1], -best[2], -best[3]};
  }

  Place farthest(int body, const Place& from) const {
    return largest(body, [&](int i) { return distance2(place(i), from); });
  }

  Place origin(int body, const std::vector<double>& before) const {
    const auto phi = [&](int i) { return before[at(i)]; };
    double most = 0;
    for (int i = 0; i < mesh_.node_count(); ++i)
      if (this->body(i) == body) most = std::max(most, phi(i));
    most = max_over_ranks(mesh_.comm(), most);
    const auto end = [&](const Place& other) {
      return largest(body,
                     [&](int i) { return phi(i) < most - 0.01 ? -HUGE_VAL : distance2(place(i), other); });
    };
    const Place a = end(largest(body, phi)), b = end(a);
    const double depth_a = depth(a), depth_b = depth(b);
    if (std::abs(depth_a - depth_b) > 1e-3 * mesh_.smallest_edge()) return depth_a < depth_b ? a : b;
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (std::abs(a[k] - b[k]) > std::abs(a[axis] - b[axis])) axis = k;
    return a[axis] <= b[axis] ? a : b;
  }

  // How far a place lies inside the box around the mesh. Collective.
  double depth(const Place& a) const {
    std::array<double, 6> box; // -least, largest
    box.fill(-HUGE_VAL);
    for (int i = 0; i < mesh_.node_count(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        box[k] = std::max(box[k], -place(i)[k]);
        box[3 + k] = std::max(box[3 + k], place(i)[k]);
      }
    max_over_ranks(mesh_.comm(), box);
    double depth = HUGE_VAL;
    for (std::size_t k = 0; k < at(mesh_.dim()); ++k)
      depth = std::min({depth, a[k] + box[k], box[3 + k] - a[k]});
    return depth;
  }

  // Numbers of nodes of the bodies.
  std::vector<int> sizes() const {
    std::vector<int> sizes(at(count()), 0);
    for (int i = 0; i < mesh_.node_count(); ++i)
      if (mesh_.owned(i) && body(i) >= 0) ++sizes[at(body(i))];
    sum_over_ranks(mesh_.comm(), sizes);
    return sizes;
  }

private:
  const Mesh& mesh_;
  Bodies bodies_;
};

} // namespace

void follow_speed(Crack& crack, double t, double length) {
  if (crack.since < 0) crack.since = t;
  const double way = std::sqrt(distance2(crack.tip, crack.from)), time = t - crack.since;
  if (way >= (1 - 1e-9) * length && time > 0) {
    crack.speed = way / time;
    crack.from = crack.tip;
    crack.since = t;
  } else if (crack.speed * time > length) {
    crack.speed = length / time;
  }
}

int follow_cracks(const Mesh& mesh, const std::vector<char>& cracked, const std::vector<double>& before,
                  std::vector<Crack>& known) {
  const bool none = std::ranges::all_of(cracked, [](char flag) { return flag == 0; });
  for (Crack& crack : known) crack.joined = crack.there;
  if (all_ranks_agree(mesh.comm(), none)) return 0;
  const Search search(mesh, cracked);
  std::vector<int> sizes = search.sizes(); // 0 once a body is somebody's
  for (Crack& crack : known) {
    const bool begins = !crack.there;
    if (begins) {
      // The first of the largest ones has the smallest coordinates.
      const int most = *std::ranges::max_element(sizes);
      if (most == 0) continue;
      int next = -1;
      search.largest(next, [&](int i) { return sizes[at(search.body(i))] == most ? 0 : -HUGE_VAL; });
      crack.there = true;
      crack.origin = search.origin(next, before);
    }
    int body = -1;
    search.largest(body, [&](int i) { return -distance2(search.place(i), crack.origin); });
    int& size = sizes[at(body)];
    crack.joined = size == 0;
    size = 0;
    if (!crack.joined) crack.tip = search.farthest(body, crack.origin);
    if (begins) crack.from = crack.tip;
  }
  return search.count();
}

} // namespace impact
