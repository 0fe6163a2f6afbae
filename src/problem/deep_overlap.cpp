#include <algorithm>
#include <impact/contact/box_tree.hpp>
#include <impact/math/vector3.hpp>
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/exchange.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/rigid_motion.hpp>
#include <limits>

namespace impact {

namespace {

// Cells are closed, so that no place is missed between two.
constexpr double closed = -1e-9;

using Place = Vector3;

struct SimplexPiece {
  std::array<Place, 4> corner;
  int body = 0;
};

double signed_volume(int dim, const Place& a, const Place& b, const Place& c, const Place& d) {
  const Place u = minus(b, a), v = minus(c, a);
  return dim == 2 ? u[0] * v[1] - u[1] * v[0] : determinant(u, v, minus(d, a));
}

bool inside(int dim, const SimplexPiece& cell, const Place& x) {
  const double whole = signed_volume(dim, cell.corner[0], cell.corner[1], cell.corner[2], cell.corner[3]);
  for (int i = 0; i <= dim; ++i) {
    std::array<Place, 4> with = cell.corner;
    with[at(i)] = x;
    if (!(signed_volume(dim, with[0], with[1], with[2], with[3]) > closed * whole)) return false;
  }
  return true;
}

// The cells of this rank as simplices with positive volume, in the reference configuration.
std::vector<SimplexPiece> simplices(const Discretisation& d, const std::vector<int>& body_of_node) {
  static constexpr int of_quad[2][3] = {{0, 1, 2}, {0, 2, 3}};
  static constexpr int of_hex[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                       {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  const int dim = d.dim();
  std::vector<SimplexPiece> all;
  for (const CellGroup& group : d.groups) {
    const int nodes = node_count(group.shape), pieces = nodes == dim + 1 ? 1 : dim == 2 ? 2 : 6;
    for (int b = 0; b < group.batch_count; ++b)
      for (int l = 0; l < group.lanes_in_use(b); ++l)
        for (int p = 0; p < pieces; ++p) {
          SimplexPiece cell{};
          for (int i = 0; i <= dim; ++i) {
            const int a = pieces == 1 ? i : dim == 2 ? of_quad[p][i] : of_hex[p][i];
            const int node = group.node[at((b * nodes + a) * lanes + l)];
            for (int k = 0; k < dim; ++k)
              cell.corner[at(i)][at(k)] = d.mesh.coordinates()[at(node * dim + k)];
            cell.body = body_of_node[at(node)];
          }
          if (signed_volume(dim, cell.corner[0], cell.corner[1], cell.corner[2], cell.corner[3]) < 0)
            std::swap(cell.corner[0], cell.corner[1]);
          all.push_back(cell);
        }
  }
  return all;
}

// [body] 1 where nodes of the side belong to it.
std::vector<int> bodies_of(const Discretisation& d, const Bodies& bodies, const std::string& side) {
  std::vector<int> holds(at(bodies.count), 0);
  for (int node : d.mesh.nodes(side)) holds[at(bodies.of_node[at(node)])] = 1;
  max_over_ranks(d.mesh.comm(), holds);
  return holds;
}

// [local node][dim + 1]: sum of the corners of the cells around it, and their number.
std::vector<double> sums_around(const Discretisation& d) {
  const int dim = d.dim();
  std::vector<double> sum(at((dim + 1) * d.mesh.node_count()), 0.0);
  for (const CellGroup& group : d.groups) {
    const int nodes = node_count(group.shape);
    for (int b = 0; b < group.batch_count; ++b)
      for (int l = 0; l < group.lanes_in_use(b); ++l)
        for (int i = 0; i < nodes * nodes; ++i) {
          const int node = group.node[at((b * nodes + i / nodes) * lanes + l)],
                    corner = group.node[at((b * nodes + i % nodes) * lanes + l)];
          for (int k = 0; k < dim; ++k)
            sum[at((dim + 1) * node + k)] += d.mesh.coordinates()[at(dim * corner + k)];
          sum[at((dim + 1) * node + dim)] += 1;
        }
  }
  return sum;
}

/// A place inside the cells around a node of a side, and its number among those of all ranks.
struct Inner {
  Place x;
  int number;
};

// Means of the corners of the cells around the owned nodes of a side. What is less deep is for the pairs to
// see, and where surfaces touch that place lies outside the other body.
std::vector<Inner> places_of(const Discretisation& d, const std::vector<double>& around,
                             const std::string& side) {
  std::vector<Inner> mine;
  const int dim = d.dim();
  for (int node : d.mesh.nodes(side)) {
    if (!d.mesh.owned(node)) continue;
    const double* sum = &around[at((dim + 1) * node)];
    Inner& inner = mine.emplace_back(Inner{{0, 0, 0}, static_cast<int>(mine.size())});
    for (int k = 0; k < dim; ++k) inner.x[at(k)] = sum[k] / sum[dim];
  }
  int end = 0;
  const int own = static_cast<int>(mine.size());
  MPI_Scan(&own, &end, 1, MPI_INT, MPI_SUM, d.mesh.comm());
  for (Inner& inner : mine) inner.number += end - own;
  return mine;
}

// The places of all ranks that may lie in cells of this one.
std::vector<Inner> near(MPI_Comm comm, const std::vector<Box>& cells, const std::vector<Inner>& places) {
  Box own;
  for (const Box& cell : cells) own.include(cell);
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  std::vector<Box> box(at(ranks));
  MPI_Allgather(&own, 6, MPI_DOUBLE, box.data(), 6, MPI_DOUBLE, comm);
  std::vector<std::vector<Inner>> out(at(ranks));
  for (const Inner& place : places) {
    Box point;
    point.include(place.x.data());
    for (std::size_t r = 0; r < box.size(); ++r)
      if (box[r].meets(point)) out[r].push_back(place);
  }
  std::vector<Inner> met;
  for (const auto& message : all_to_all(comm, out)) met.insert(met.end(), message.begin(), message.end());
  return met;
}

} // namespace

void refuse_deep_overlaps(const Discretisation& d, const ContactSet& contacts) {
  const auto matters = [](const ContactSettings& settings) {
    return !settings.rigid() && settings.primary != settings.secondary &&
           settings.initial != InitialOverlap::allow;
  };
  if (std::none_of(contacts.begin(), contacts.end(), [&](const auto& c) { return matters(c.settings()); }))
    return;
  const Bodies bodies = find_bodies(d.mesh);
  const std::vector<SimplexPiece> cells = simplices(d, bodies.of_node);
  std::vector<Box> boxes;
  for (const SimplexPiece& cell : cells) {
    Box& box = boxes.emplace_back();
    for (int i = 0; i <= d.dim(); ++i) box.include(cell.corner[at(i)].data());
  }
  const BoxTree tree(boxes);
  const std::vector<double> around = sums_around(d);
  std::vector<std::uint32_t> leaves;
  std::vector<int> found;
  for (const ContactInterface& contact : contacts) {
    const ContactSettings& settings = contact.settings();
    if (!matters(settings)) continue;
    for (const bool swapped : {false, true}) {
      const std::string &side = swapped ? settings.primary : settings.secondary,
                        &other = swapped ? settings.secondary : settings.primary;
      const std::vector<int> own = bodies_of(d, bodies, side), theirs = bodies_of(d, bodies, other);
      const std::vector<Inner> places = places_of(d, around, side);
      constexpr int none = std::numeric_limits<int>::max();
      int deep = none; // first node inside a cell of the other side's bodies
      for (const Inner& place : near(d.mesh.comm(), boxes, places)) {
        Box box;
        box.include(place.x.data());
        leaves.clear();
        found.clear();
        tree.find_leaves(box, leaves);
        for (std::uint32_t leaf : leaves) tree.find_boxes(box, leaf, found);
        for (int c : found)
          if (theirs[at(cells[at(c)].body)] && !own[at(cells[at(c)].body)] &&
              inside(d.dim(), cells[at(c)], place.x))
            deep = std::min(deep, place.number);
      }
      deep = min_over_ranks(d.mesh.comm(), deep);
      if (deep == none) continue;
      Place where{};
      for (const Inner& place : places)
        if (place.number == deep) where = place.x;
      sum_over_ranks(d.mesh.comm(), where); // one rank has it
      throw UserError(ExitCode::data, "contact " + settings.id + ": `" + side + "` lies around " +
                                          place_text(where.data(), d.dim()) + " inside the body of `" +
                                          other + "`, deeper than -contact_" + settings.id +
                                          "_search_radius sees; part the bodies, or use -contact_" +
                                          settings.id + "_initial allow to pass over it");
    }
  }
}

} // namespace impact
