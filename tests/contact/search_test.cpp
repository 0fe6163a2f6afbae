#include "two_blocks.hpp"
#include <algorithm>
#include <gtest/gtest.h>
#include <impact/contact/edge_points.hpp>
#include <impact/contact/search.hpp>
#include <impact/contact/surface.hpp>
#include <numbers>
#include <random>
#include <set>

using namespace impact;
using namespace impact::contact_test;

namespace {

// Triangles and quadrilaterals scattered over a flat box; every rank makes the same ones from the same seed.
struct Scatter {
  SearchSecondary secondary;
  std::vector<SearchFacet> primary;

  Scatter(int secondary_count, int primary_count) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> anywhere(0, 10), high(0, 2), small(-0.2, 0.2);
    auto facet = [&](PetscInt first, bool triangle) {
      SearchFacet f{{first, first + 1, first + 2, triangle ? first + 2 : first + 3}, {-1, -1}, {}};
      const std::array<double, 3> centre = {anywhere(random), anywhere(random), high(random)};
      for (std::size_t i = 0; i < 12; ++i) f.x[i] = centre[i % 3] + small(random);
      if (triangle) std::copy_n(f.x.begin() + 6, 3, f.x.begin() + 9);
      return f;
    };
    for (int s = 0; s < secondary_count; ++s) {
      const SearchFacet f = facet(4 * s, s % 2 == 0);
      secondary.node.insert(secondary.node.end(), f.node.begin(), f.node.begin() + 4);
      secondary.x.insert(secondary.x.end(), f.x.begin(), f.x.end());
    }
    for (int p = 0; p < primary_count; ++p) {
      primary.push_back(facet(1000000 + 4 * p, p % 3 == 0));
      if (p % 10 == 0) primary.back().node[1] = 4 * (p % secondary_count); // shares a node with a secondary
    }
  }
};

using PairSet = std::set<std::array<PetscInt, 8>>;

PairSet pairs(const SearchSecondary& secondary, const Candidates& found) {
  PairSet all;
  for (std::size_t s = 0; s + 1 < found.offset.size(); ++s)
    for (int c = found.offset[s]; c < found.offset[s + 1]; ++c) {
      const SearchFacet& p =
          found.primary[static_cast<std::size_t>(found.facet[static_cast<std::size_t>(c)])];
      std::array<PetscInt, 8> pair{};
      std::copy_n(&secondary.node[4 * s], 4, pair.begin());
      std::copy_n(p.node.begin(), 4, pair.begin() + 4);
      all.insert(pair);
    }
  return all;
}

// By the definition, every facet against every facet.
PairSet by_hand(const SearchSecondary& secondary, const std::vector<SearchFacet>& primary, double reach) {
  PairSet all;
  for (std::size_t s = 0; s < secondary.node.size() / 4; ++s)
    for (const SearchFacet& p : primary) {
      const double* x = &secondary.x[12 * s];
      bool near = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto range = [k](const double* corner) {
          return std::minmax({corner[k], corner[3 + k], corner[6 + k], corner[9 + k]});
        };
        const auto mine = range(x), other = range(p.x.data());
        near = near && other.first - mine.second <= reach && mine.first - other.second <= reach;
      }
      std::array<PetscInt, 8> pair{};
      std::copy_n(&secondary.node[4 * s], 4, pair.begin());
      std::copy_n(p.node.begin(), 4, pair.begin() + 4);
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 4; b < 8; ++b) near = near && pair[a] != pair[b];
      if (near) all.insert(pair);
    }
  return all;
}

} // namespace

TEST(ContactSearch, FindsExactlyThePairsOfTheDefinitionInSortedOrder) {
  const Scatter scatter(300, 400);
  const Candidates found = match_boxes(scatter.secondary, scatter.primary, 0.3);
  const PairSet expected = by_hand(scatter.secondary, scatter.primary, 0.3);
  ASSERT_GT(expected.size(), 500U);
  EXPECT_EQ(pairs(scatter.secondary, found), expected);
  EXPECT_EQ(found.facet.size(), expected.size()); // each once
  for (std::size_t s = 0; s + 1 < found.offset.size(); ++s)
    EXPECT_TRUE(
        std::is_sorted(found.facet.begin() + found.offset[s], found.facet.begin() + found.offset[s + 1]));
  EXPECT_TRUE(std::is_sorted(found.primary.begin(), found.primary.end(),
                             [](const SearchFacet& a, const SearchFacet& b) { return a.node < b.node; }));
}

TEST(ContactSearch, TreesOfEverySizeFindThePairsOfTheDefinition) {
  for (const int count : {0, 1, 7, 8, 9, 64, 65, 513}) {
    const Scatter scatter(41, count);
    EXPECT_EQ(pairs(scatter.secondary, match_boxes(scatter.secondary, scatter.primary, 0.9)),
              by_hand(scatter.secondary, scatter.primary, 0.9))
        << count;
  }
  // All boxes alike.
  Scatter same(3, 0);
  for (int p = 0; p < 100; ++p)
    same.primary.push_back({{900 + p, 1000 + p, 1100 + p, 1100 + p}, {-1, -1}, {}});
  EXPECT_EQ(match_boxes(same.secondary, same.primary, 20).facet.size(), 300U);
}

TEST(ContactSearch, RanksTogetherFindWhatOneRankFinds) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const Scatter whole(300, 400);
  const Candidates serial = match_boxes(whole.secondary, whole.primary, 0.3);
  SearchSecondary mine;
  std::vector<int> number;
  for (int s = 0; s < 300; ++s)
    if (s * 7 % ranks == rank) {
      number.push_back(s);
      const std::size_t i = static_cast<std::size_t>(s);
      mine.node.insert(mine.node.end(), &whole.secondary.node[4 * i], &whole.secondary.node[4 * i] + 4);
      mine.x.insert(mine.x.end(), &whole.secondary.x[12 * i], &whole.secondary.x[12 * i] + 12);
    }
  std::vector<SearchFacet> primary;
  for (int p = 0; p < 400; ++p)
    if (p * 3 / 400 % ranks == rank) primary.push_back(whole.primary[static_cast<std::size_t>(p)]);
  const Candidates found = find_candidates(PETSC_COMM_WORLD, mine, primary, 0.3);
  std::size_t compared = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    const auto s = static_cast<std::size_t>(number[i]);
    ASSERT_EQ(found.offset[i + 1] - found.offset[i], serial.offset[s + 1] - serial.offset[s]);
    for (int c = 0; c < found.offset[i + 1] - found.offset[i]; ++c, ++compared) {
      const auto a = static_cast<std::size_t>(found.facet[static_cast<std::size_t>(found.offset[i] + c)]);
      const auto b = static_cast<std::size_t>(serial.facet[static_cast<std::size_t>(serial.offset[s] + c)]);
      EXPECT_EQ(found.primary[a].node, serial.primary[b].node);
      EXPECT_EQ(found.primary[a].x, serial.primary[b].x);
    }
  }
  EXPECT_GT(compared, 0U);
}

TEST(ContactSearch, AnEmptySurfaceOnARankMeetsNothing) {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  const Scatter whole(20, 30);
  const Candidates found = find_candidates(PETSC_COMM_WORLD, rank == 0 ? whole.secondary : SearchSecondary{},
                                           rank == 0 ? whole.primary : std::vector<SearchFacet>{}, 100);
  EXPECT_EQ(found.facet.empty(), rank != 0);
  EXPECT_EQ(found.offset.size(), rank == 0 ? 21U : 1U);
}

TEST(ContactSurface, GaussRulesIntegratePolynomialsExactly) {
  for (int points = 1; points <= 16; ++points) {
    const GaussRule rule = gauss_rule(points);
    for (int degree = 0; degree <= 2 * points - 1; ++degree) {
      double sum = 0;
      for (std::size_t q = 0; q < rule.xi.size(); ++q) sum += rule.weight[q] * std::pow(rule.xi[q], degree);
      EXPECT_NEAR(sum, degree % 2 == 0 ? 2.0 / (degree + 1) : 0, 1e-13)
          << points << " points, degree " << degree;
    }
    EXPECT_TRUE(std::is_sorted(rule.xi.begin(), rule.xi.end()));
  }
  EXPECT_NEAR(gauss_rule(2).xi[1], 1 / std::numbers::sqrt3, 1e-15);
}

TEST(ContactSurface, FacetsLookOutwardAndKnowTheirNeighboursAcrossRanks) {
  for (const Partition& partition : {Partition(bodies_apart), Partition(bodies_mixed)}) {
    const TwoBlocks b;
    const Mesh mesh = make_blocks(PETSC_COMM_WORLD, b, partition);
    const FieldLayout layout(mesh, "u", 2);
    ContactSurface top = make_surface(mesh, "pair", "lower_top");
    const std::vector<PetscInt> neighbour = surface_neighbours(layout, top);
    int count = top.count(), ends = 0;
    for (int f = 0; f < top.count(); ++f) {
      const double* X = &top.X[static_cast<std::size_t>(4 * f)];
      EXPECT_NEAR(top.length[static_cast<std::size_t>(f)], 0.3, 1e-14);
      EXPECT_LT(X[2] - X[0], 0); // outward normal (t_y, -t_x) up: the way goes to the left
      // Right end first: nothing before the rightmost edge, nothing after the leftmost.
      EXPECT_EQ(neighbour[static_cast<std::size_t>(2 * f)]<0, X[0]> 2.1 - 1e-9);
      EXPECT_EQ(neighbour[static_cast<std::size_t>(2 * f + 1)] < 0, X[2] < 1e-9);
      for (int a = 0; a < 2; ++a)
        if (neighbour[static_cast<std::size_t>(2 * f + a)] < 0) ++ends;
    }
    MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &ends, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_EQ(count, 7);
    EXPECT_EQ(ends, 2);
    ContactSettings settings;
    settings.points = 3;
    const FormPoints points = EdgePoints::make_points(top, settings, Frame::plane_strain);
    double area = 0;
    for (double weight : points.weight) area += weight;
    MPI_Allreduce(MPI_IN_PLACE, &area, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_NEAR(area, 2.1, 1e-13);
  }
}

TEST(ContactSurface, PointsFollowTheConeOfTheFacet) {
  const Mesh mesh = make_blocks(PETSC_COMM_WORLD, {}, bodies_mixed);
  for (const char* group : {"lower_top", "upper_bottom", "lower_left"}) {
    ContactSurface surface = make_surface(mesh, "pair", group);
    ContactSettings settings;
    settings.points = 2;
    const FacetTable facets = mesh.facets(group);
    const FormPoints points = EdgePoints::make_points(surface, settings, Frame::plane_strain);
    for (int f = 0; f < surface.count(); ++f) {
      const PetscInt* cone = nullptr;
      check(DMPlexGetCone(mesh.dm(), facets.point[static_cast<std::size_t>(f)], &cone));
      const auto first = static_cast<std::size_t>(cone[0] - mesh.point(0));
      const auto i = static_cast<std::size_t>(f);
      double distance = 0;
      for (std::size_t k = 0; k < 2; ++k) {
        const double x =
            points.shape[2 * i][0] * surface.X[4 * i + k] + points.shape[2 * i][1] * surface.X[4 * i + 2 + k];
        distance = std::hypot(distance, x - mesh.coordinates()[2 * first + k]);
      }
      // The first point is the one nearer to the first vertex of the cone.
      EXPECT_NEAR(distance, surface.length[i] * (1 - 1 / std::numbers::sqrt3) / 2, 1e-14);
    }
  }
}
