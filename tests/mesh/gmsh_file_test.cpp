#include "example_meshes.hpp"
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <impact/mesh/gmsh.hpp>

namespace impact {

namespace {

// Two unit squares side by side: region "left half", region "right half" with blank in the name, boundary
// "foot".
const std::string head = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
const std::string names =
    "$PhysicalNames\n3\n1 7 \"foot\"\n2 1 \"left half\"\n2 2 \"right half\"\n$EndPhysicalNames\n";
const std::string entities = "$Entities\n0 1 2 0\n1 0 0 0 2 0 0 1 7 0\n"
                             "1 0 0 0 1 1 0 1 1 0\n2 1 0 0 2 1 0 1 2 0\n$EndEntities\n";
const std::string nodes = "$Nodes\n1 6 1 6\n2 1 0 6\n1\n2\n3\n4\n5\n6\n"
                          "0 0 0\n1 0 0\n2 0 0\n0 1 0\n1 1 0\n2 1 0\n$EndNodes\n";
const std::string elements =
    "$Elements\n3 4 1 4\n1 1 1 2\n1 1 2\n2 2 3\n2 1 3 1\n3 1 2 5 4\n2 2 3 1\n4 2 3 6 5\n$EndElements\n";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

Mesh read_text(const std::string& text, const std::string& name = "case.msh", MeshRequest request = {}) {
  on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(name, std::ios::binary) << text; });
  request.file = name;
  return read_mesh(PETSC_COMM_WORLD, request);
}

const std::string good = head + names + entities + nodes + elements;

TEST(GmshFile, ReadsNamesWithBlanks) {
  const Mesh mesh = read_text(good);
  EXPECT_EQ(mesh.global_cell_count(), 2);
  EXPECT_EQ(sum_over_ranks(static_cast<double>(mesh.region_cells("right half").size())), 1);
  EXPECT_EQ(sum_over_ranks(mesh.facets("foot").count()), 2);
}

TEST(GmshFile, RefinesTrianglesBehindQuadrilaterals) {
  const std::string mixed = replaced(good, "2 2 3 1\n4 2 3 6 5", "2 2 2 1\n4 2 3 6");
  MeshRequest request;
  request.refine = 1;
  EXPECT_EQ(read_text(mixed, "mixed.msh", request).global_cell_count(), 8);
}

TEST(GmshFile, TurnsClockwiseCells) {
  const Mesh mesh = read_text(replaced(replaced(good, "3 1 2 5 4", "3 4 5 2 1"), "4 2 3 6 5", "4 5 6 3 2"));
  EXPECT_EQ(mesh.global_cell_count(), 2);
  const FacetTable foot = mesh.facets("foot");
  for (int f = 0; f < foot.count(); ++f) // outward is downward, so the tangent looks to the right
    EXPECT_GT(
        mesh.coordinates()[static_cast<std::size_t>(2 *
                                                    foot.connectivity[static_cast<std::size_t>(2 * f + 1)])],
        mesh.coordinates()[static_cast<std::size_t>(2 * foot.connectivity[static_cast<std::size_t>(2 * f)])]);
}

TEST(GmshFile, ReadsBinaryLikeText) {
  std::string text = "$MeshFormat\n4.1 1 8\n";
  const auto put = [&](auto... values) {
    (..., text.append(reinterpret_cast<const char*>(&values), sizeof values));
  };
  using S = std::int64_t;
  put(1);
  text += "\n$EndMeshFormat\n" + names + "$Entities\n";
  put(S{0}, S{1}, S{2}, S{0});
  put(1, 0., 0., 0., 2., 0., 0., S{1}, 7, S{0});
  put(1, 0., 0., 0., 1., 1., 0., S{1}, 1, S{0});
  put(2, 1., 0., 0., 2., 1., 0., S{1}, 2, S{0});
  text += "\n$EndEntities\n$Nodes\n";
  put(S{1}, S{6}, S{1}, S{6}, 2, 1, 0, S{6}, S{1}, S{2}, S{3}, S{4}, S{5}, S{6});
  for (int n = 0; n < 6; ++n) put(double(n % 3), double(n / 3), 0.);
  text += "\n$EndNodes\n$Elements\n";
  put(S{3}, S{4}, S{1}, S{4}, 1, 1, 1, S{2}, S{1}, S{1}, S{2}, S{2}, S{2}, S{3});
  put(2, 1, 3, S{1}, S{3}, S{1}, S{2}, S{5}, S{4}, 2, 2, 3, S{1}, S{4}, S{2}, S{3}, S{6}, S{5});
  text += "\n$EndElements\n";
  const Mesh mesh = read_text(text, "binary.msh");
  EXPECT_EQ(mesh.global_cell_count(), 2);
  EXPECT_EQ(mesh.global_node_count(), 6);
  EXPECT_EQ(sum_over_ranks(mesh.facets("foot").count()), 2);
  ExitCode code{};
  for (std::size_t length = 30; length < text.size(); length += 37) // cut anywhere
    EXPECT_NE(user_error(code, [&] { read_text(text.substr(0, length), "cut.msh"); }), "") << length;
}

TEST(GmshFile, ReadsVersion22WithoutOverlap) {
  const std::string old =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names +
      "$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 2 0 0\n4 0 1 0\n5 1 1 0\n6 2 1 0\n$EndNodes\n"
      "$Elements\n4\n1 1 2 7 1 1 2\n2 1 2 7 1 2 3\n3 3 2 1 1 1 2 5 4\n4 3 2 2 2 2 3 6 5\n$EndElements\n";
  EXPECT_EQ(read_text(old).global_cell_count(), 2);
  ExitCode code{};
  const std::string twice =
      replaced(replaced(old, "$Elements\n4", "$Elements\n5"), "4 3 2 2 2", "5 3 2 2 1 1 2 5 4\n4 3 2 2 2");
  EXPECT_NE(user_error(code, [&] { read_text(twice); }).find("write version 4.1"), std::string::npos);
  EXPECT_EQ(code, ExitCode::data);
}

TEST(GmshFile, RefusesWhatItCannotUse) {
  struct Case {
    std::string text, says;
    ExitCode code;
  };
  const std::string unnamed =
      replaced(replaced(good, "1 1 0 1 1 0\n", "1 1 0 0 0\n"), "2 1 0 1 2 0\n", "2 1 0 0 0\n");
  const Case cases[] = {
      {"", "empty", ExitCode::io},
      {"hello, I am text\n", "mesh file of gmsh", ExitCode::io},
      {replaced(good, "4.1 0 8", "9.9 0 8"), "version 9.9", ExitCode::io},
      {replaced(good, "4.1 0 8", "4.1 0 4"), "data size", ExitCode::io},
      {good.substr(0, good.size() - 40), "too early", ExitCode::io},
      {head + names + entities + nodes, "no $Elements", ExitCode::io},
      {replaced(good, "2 1 0\n$EndNodes", "2 nan 0\n$EndNodes"), "not finite", ExitCode::data},
      {replaced(good, "2 1 0\n$EndNodes", "2 x 0\n$EndNodes"), "not a number", ExitCode::io},
      {replaced(good, "2 1 0\n$EndNodes", "2 1 0.1\n$EndNodes"), "plane", ExitCode::data},
      {replaced(good, "4 2 3 6 5", "4 2 3 9 5"), "node 9", ExitCode::io},
      {replaced(good, "4 2 3 6 5", "4 2 3 3 5"), "twice in it", ExitCode::data},
      {replaced(replaced(good, "$Elements\n3 4", "$Elements\n3 5"), "2 2 3 1\n", "2 2 3 2\n5 1 2 5 4\n"),
       "same nodes", ExitCode::data},
      {replaced(good, "4 2 3 6 5", "4 2 6 3 5"), "folded cell", ExitCode::data}, // crosses itself
      {replaced(replaced(good, "2 0 0\n0 1", "0.1 0 0\n0 1"), "2 1 0\n$EndNodes", "0.1 1 0\n$EndNodes"),
       "overlapping", ExitCode::data}, // folded back over its neighbour
      {replaced(good, "2 1 0\n$EndNodes", "1 0.5 0\n$EndNodes"), "cell", ExitCode::data},
      {replaced(good, "2 1 0\n$EndNodes", "0.5 0.6 0\n$EndNodes"), "cell", ExitCode::data},
      {replaced(replaced(good, "$Elements\n3 4", "$Elements\n2 3"), "2 2 3 1\n4 2 3 6 5\n", ""),
       "belong to no cell", ExitCode::data},
      {replaced(good, "2 2 3 1\n", "2 2 36 1\n"), "order", ExitCode::data},
      {replaced(good, "2 2 3 1\n", "3 2 6 1\n"), "prisms", ExitCode::data},
      {replaced(good, "1 1 2\n2 2 3", "1 1 5\n2 2 3"), "foot", ExitCode::data}, // a line inside a cell
      {replaced(good, "1 1 2\n2 2 3", "1 1 6\n2 2 3"), "foot", ExitCode::data},
      {replaced(unnamed, "2 0 0 1 7 0", "2 0 0 0 0"), "no physical groups", ExitCode::data},
      {unnamed, "no physical group of cells", ExitCode::data},
      {replaced(good, "\"foot\"", "\"left half\""), "two dimensions", ExitCode::data},
      {replaced(good, "\"foot\"", "\"depth\""), "reserved", ExitCode::data},
      {replaced(good, "$Nodes\n1 6", "$Nodes\n99999999999 6"), "impossible", ExitCode::io},
      {replaced(good, "2 1 0 6\n", "2 1 0 8888888888\n"), "impossible", ExitCode::io},
      {replaced(good, "2 1 0 6\n1\n2", "2 1 0 6\n1\n1"), "occurs twice", ExitCode::io},
  };
  for (const Case& c : cases) {
    ExitCode code{};
    const std::string message = user_error(code, [&] { read_text(c.text); });
    EXPECT_NE(message.find(c.says), std::string::npos) << c.says << ": " << message;
    EXPECT_NE(message.find("case.msh"), message.find("mesh: "))
        << message; // says which file or that it is the mesh
    EXPECT_EQ(code, c.code) << message;
  }
}

// Each byte position in turn is overwritten; whatever comes, it is a mesh or a UserError on all ranks.
TEST(GmshFile, SurvivesEverySingleWrongByte) {
  int refused = 0;
  for (std::size_t k = 0; k < good.size(); k += 3)
    for (const char wrong : {'9', '-', ' '}) {
      std::string text = good;
      text[k] = wrong;
      ExitCode code{};
      refused += user_error(code, [&] { read_text(text); }).empty() ? 0 : 1;
      EXPECT_TRUE(code == ExitCode::ok || code == ExitCode::data || code == ExitCode::io) << text;
    }
  EXPECT_GT(refused, 200);
}

TEST(GmshProgram, QuotesItsOwnErrorLine) {
  on_rank_zero(PETSC_COMM_WORLD, [] { std::ofstream("broken.geo") << "Point(1) = {0, 0, 0};\nnonsense\n"; });
  MeshRequest request;
  request.file = "broken.geo";
  ExitCode code{};
  EXPECT_NE(user_error(code, [&] { read_mesh(PETSC_COMM_WORLD, request); }).find("syntax error"),
            std::string::npos);
  EXPECT_EQ(code, ExitCode::io);
}

TEST(GmshProgram, RefusesParametersThatTheGeometryDoesNotHave) {
  ExitCode code{};
  const MeshRequest request = example_mesh("cook", {{"nn", "3"}});
  EXPECT_NE(user_error(code, [&] { read_mesh(PETSC_COMM_WORLD, request); }).find("nn"), std::string::npos);
  EXPECT_EQ(code, ExitCode::usage);
}

TEST(GmshProgram, PassesParameters) {
  EXPECT_EQ(read_mesh(PETSC_COMM_WORLD, example_mesh("cook", {{"n", "3"}})).global_cell_count(), 9);
  EXPECT_EQ(read_mesh(PETSC_COMM_WORLD, example_mesh("cook")).global_cell_count(), 64);
}

TEST(ReadMesh, RefusesMissingAndStrangeFiles) {
  ExitCode code{};
  MeshRequest request;
  request.file = "nowhere.msh";
  EXPECT_NE(user_error(code, [&] { read_mesh(PETSC_COMM_WORLD, request); }).find("no such file"),
            std::string::npos);
  EXPECT_EQ(code, ExitCode::io);
  request.file = "mesh.stl";
  EXPECT_NE(
      user_error(code, [&] { read_mesh(PETSC_COMM_WORLD, request); }).find("allowed .msh, .geo, and .h5"),
      std::string::npos);
}

} // namespace

} // namespace impact
