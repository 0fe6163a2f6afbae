#include "box_mesh.hpp"
#include "example_meshes.hpp"
#include "small_mesh.hpp"
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

// Meshes whose nodes stand in the middle of edges too.

namespace impact {

namespace {

/// Largest distance of a node from the middle of the corners around it, over all cells.
double largest_bend(const Mesh& mesh) {
  double bend = 0;
  for (const CellTable& table : mesh.cells()) {
    EXPECT_EQ(table.shape->order(), 2);
    const auto nodes = static_cast<std::size_t>(table.shape->nodes);
    for (std::size_t c = 0; c < table.connectivity.size(); c += nodes)
      for (int a = 0; a < table.shape->nodes; ++a) {
        const auto node = [&](int b) { return table.connectivity[c + static_cast<std::size_t>(b)]; };
        const std::vector<int> around = corners_around(table.shape, a);
        for (int i = 0; i < mesh.dim(); ++i) {
          double mean = 0;
          for (const int b : around) mean += x_of(mesh, node(b), i) / static_cast<double>(around.size());
          bend = std::max(bend, std::abs(x_of(mesh, node(a), i) - mean));
        }
      }
  }
  return largest_over_ranks(bend);
}

const Shape second_order[] = {Shape::tri6,  Shape::tet10, Shape::quad9,
                              Shape::hex27, Shape::quad8, Shape::hex20};

// Each edge and face of each cell finds the node in its own middle, whatever way DMPlex turns the cell: gmsh
// writes these files.
TEST(SecondOrder, NodesStandInTheMiddleOfTheEdgesAndFacesOfTheirCells) {
  for (const Shape shape : second_order) {
    const Mesh mesh = make_block(shape, 3);
    EXPECT_EQ(mesh.order(), 2);
    EXPECT_TRUE(mesh.has_shape(shape));
    EXPECT_LT(largest_bend(mesh), 1e-12);
    EXPECT_NEAR(volume(mesh), 1, 1e-12);
  }
}

TEST(SecondOrder, CellsInsideOutAreTurnedWithAllTheirNodes) {
  for (const Shape shape : second_order) {
    const Mesh mesh = run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("mirrored"),
                                        run_test::box_mesh(shape, 2, [](std::array<double, 3> x, bool) {
                                          return std::array<double, 3>{1 - x[0], x[1], x[2]};
                                        }));
    EXPECT_LT(largest_bend(mesh), 1e-12) << shape->names.plural;
    EXPECT_NEAR(volume(mesh), 1, 1e-12);
  }
}

TEST(SecondOrder, OrderTwoGivesAMeshOfFirstOrderNodesOnItsEdgesAndInItsBoxes) {
  for (const auto& [shape, middles] : {std::pair{Shape::tri3, Middles::all},
                                       {Shape::tet4, Middles::all},
                                       {Shape::quad4, Middles::all},
                                       {Shape::hex8, Middles::all},
                                       {Shape::quad4, Middles::edges},
                                       {Shape::hex8, Middles::edges}})
    for (const int refine : {0, middles == Middles::all ? 1 : 0}) {
      make_block(shape, 2); // the file
      MeshRequest request;
      request.file = "mesh_test_files/block" + std::to_string(index_of(shape)) + "_2/block.msh";
      request.middles = middles;
      request.refine = refine;
      const Mesh plain = read_mesh(PETSC_COMM_WORLD, request);
      request.order = 2;
      const Mesh mesh = read_mesh(PETSC_COMM_WORLD, request);
      EXPECT_EQ(mesh.order(), 2);
      EXPECT_EQ(mesh.global_cell_count(), plain.global_cell_count());
      EXPECT_LT(largest_bend(mesh), 1e-15);
      EXPECT_NEAR(volume(mesh), 1, 1e-12);
      EXPECT_EQ(mesh.smallest_edge(), plain.smallest_edge());
      // Euler: V - E + C = 1 in the plane, V - E + F - C = 1 in space with 2 F = facets C + boundary.
      double boundary = 0;
      for (const char* side : {"left", "right", "bottom", "top", "back", "front"})
        if (mesh.find_group(side) != nullptr) boundary += sum_over_ranks(mesh.facets(side).count());
      const double V = plain.global_node_count(), C = plain.global_cell_count(),
                   F = (static_cast<double>(shape->facets.size()) * C + boundary) / 2,
                   E = mesh.dim() == 2 ? V + C - 1 : V + F - C - 1;
      const bool amid = !shape->simplex() && middles == Middles::all;
      const double nodes = V + E + (amid ? C : 0) + (amid && mesh.dim() == 3 ? F : 0);
      EXPECT_EQ(mesh.global_node_count(), nodes);
      EXPECT_EQ(sum_over_ranks(mesh.owned_node_count()), nodes);
    }
}

std::string disc(bool boxes) {
  return std::string(R"(SetFactory("OpenCASCADE");
Disk(1) = {0, 0, 0, 1, 1};
Mesh.MeshSizeMin = 0.4;
Mesh.MeshSizeMax = 0.4;
Physical Surface("body") = {1};
Physical Curve("rim") = {1};
)") + (boxes ? "Recombine Surface \"*\";\n" : "");
}

// The area of a circle by parabolas errs 4th order in h where that of chords errs in h^2. Quadrilaterals too,
// and triangles among them.
TEST(SecondOrder, GmshGivesCurvedEdges) {
  for (const bool boxes : {false, true}) {
    const std::string dir = run_test::fresh_dir("disc");
    on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(dir + "/disc.geo") << disc(boxes); });
    MeshRequest request;
    request.file = dir + "/disc.geo";
    request.work_dir = dir;
    const double chords = volume(read_mesh(PETSC_COMM_WORLD, request)) - std::numbers::pi;
    request.order = 2;
    const Mesh mesh = read_mesh(PETSC_COMM_WORLD, request);
    EXPECT_LT(chords, -0.03);
    EXPECT_NEAR(volume(mesh), std::numbers::pi, 1e-3);
    EXPECT_EQ(mesh.has_shape(Shape::quad9), boxes);
    EXPECT_GT(largest_bend(mesh), 0.01);
    for (const int node : mesh.nodes("rim"))
      EXPECT_NEAR(std::hypot(x_of(mesh, node, 0), x_of(mesh, node, 1)), 1, 1e-9);
    EXPECT_EQ(mesh.facets("rim").nodes_per_facet, 3);
    request.file = dir + "/disc.msh"; // as it was written
    request.order = 0;
    EXPECT_EQ(volume(read_mesh(PETSC_COMM_WORLD, request)), volume(mesh));
  }
}

// A triangle with a bulge at its long side: 1/2 + 2/3 of the chord times the height.
std::string triangle(const std::string& nodes) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"body\"\n1 2 "
         "\"side\"\n$EndPhysicalNames\n"
         "$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0.5 0 0\n5 0.6 0.6 0\n6 0 0.5 0\n$EndNodes\n"
         "$Elements\n2\n1 9 2 1 1 " +
         nodes + "\n2 8 2 2 2 2 3 5\n$EndElements\n";
}

TEST(SecondOrder, ClockwiseCellsAreTurnedWithTheNodesOfTheirEdges) {
  const std::string dir = run_test::fresh_dir("turned");
  for (const char* nodes : {"1 2 3 4 5 6", "1 3 2 6 5 4", "3 2 1 5 4 6"}) {
    const Mesh mesh = run_test::mesh_of(PETSC_COMM_WORLD, dir, triangle(nodes));
    EXPECT_NEAR(volume(mesh), 0.5 + 2.0 / 3 * std::sqrt(2.0) * 0.1 * std::sqrt(2.0), 1e-14) << nodes;
    const FacetTable side = mesh.facets("side");
    EXPECT_EQ(sum_over_ranks(side.count()), 1);
    for (int f = 0; f < side.count(); ++f) EXPECT_EQ(x_of(mesh, side.connectivity[2], 0), 0.6);
    EXPECT_EQ(mesh.nodes("side").size(), static_cast<std::size_t>(mesh.node_count() > 0 ? 3 : 0));
  }
}

// gmsh and VTK name the last two edges of a tetrahedron in opposite order; the bulge of one shows which.
TEST(SecondOrder, TetrahedraHaveTheEdgesOfTheFile) {
  const std::string head =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"body\"\n$EndPhysicalNames\n"
      "$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0.5 0 0\n6 0.5 0.5 0\n7 0 0.5 0\n8 0 0 0.5\n"
      "9 0 0.5 0.5\n10 0.5 0 0.5\n$EndNodes\n$Elements\n1\n1 11 2 1 1 ";
  const std::string dir = run_test::fresh_dir("tetrahedron");
  for (const char* nodes : {"1 2 3 4 5 6 7 8 9 10", "1 3 2 4 7 6 5 8 10 9"}) {
    const Mesh mesh = run_test::mesh_of(PETSC_COMM_WORLD, dir, head + nodes + "\n$EndElements\n");
    EXPECT_LT(largest_bend(mesh), 1e-15);
    EXPECT_NEAR(volume(mesh), 1.0 / 6, 1e-15);
  }
}

TEST(SecondOrder, RefusesWhatItCannotUse) {
  const std::string dir = run_test::fresh_dir("refused");
  const auto refusal = [&](const std::string& text, int order = 0, int refine = 0) {
    ExitCode code{};
    on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(dir + "/mesh.msh") << text; });
    MeshRequest request;
    request.file = dir + "/mesh.msh";
    request.order = order;
    request.refine = refine;
    std::string says = user_error(code, [&] { read_mesh(PETSC_COMM_WORLD, request); });
    EXPECT_EQ(code, ExitCode::data) << says;
    return says;
  };
  const std::string good = triangle("1 2 3 4 5 6");
  const auto replaced = [&](const std::string& what, const std::string& with) {
    std::string text = good;
    const std::size_t place = text.find(what);
    EXPECT_NE(place, std::string::npos) << what;
    return text.replace(place, what.size(), with);
  };
  EXPECT_NE(refusal(good, 1).find("of second order, -order is 1"), std::string::npos);
  EXPECT_NE(refusal(good, 0, 1).find("-dm_refine"), std::string::npos);
  EXPECT_NE(refusal(replaced("0.6 0.6 0", "0.1 0.1 0")).find("inverted"), std::string::npos);
  const auto second = [&](const std::string& count, const std::string& nodes, const std::string& element) {
    std::string text = replaced("$Nodes\n6\n", "$Nodes\n" + count + "\n");
    text.replace(text.find("$EndNodes"), 9, nodes + "$EndNodes");
    return text.replace(text.find("$Elements\n2\n"), 12, "$Elements\n3\n3 " + element + "\n");
  };
  EXPECT_NE(refusal(second("7", "7 1 1 0\n", "2 2 1 1 2 7 3")).find("first and of second order"),
            std::string::npos);
  EXPECT_NE(refusal(second("10", "7 1 1 0\n8 0.5 0.5 0\n9 1 0.5 0\n10 0.5 1 0\n", "9 2 1 1 2 7 3 9 10 8"))
                .find("two nodes in the middle of one edge"),
            std::string::npos);
  const std::string box = run_test::box_mesh(Shape::quad9, 2);
  std::string mixed = box;
  const std::size_t first = mixed.find(" 10 2 1 1 "), line = mixed.find('\n', first),
                    last = mixed.rfind(' ', line);
  mixed.replace(last, line - last, "").replace(first, 4, " 16 "); // the first cell without its middle node
  EXPECT_NE(refusal(mixed).find("belong to no cell"), std::string::npos);
  const std::size_t node = mixed.find("\n7 0.25 0.25 0\n");
  ASSERT_NE(node, std::string::npos);
  mixed.erase(node, 14).replace(mixed.find("$Nodes\n25"), 9, "$Nodes\n24");
  EXPECT_NE(refusal(mixed).find("with and without nodes in their middle"), std::string::npos);
}

} // namespace
} // namespace impact
