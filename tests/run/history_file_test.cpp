#include "../mesh/small_mesh.hpp"
#include "io_error.hpp"
#include <cmath>
#include <gtest/gtest.h>
#include <impact/io/durable_file.hpp>
#include <impact/io/history_file.hpp>
#include <limits>
#include <sstream>

namespace impact {
namespace {

using run_test::FileSizeLimit;
using run_test::fresh_dir;
using run_test::io_error_of;

HistoryFile::Row row(double step) { return {{"step", step}, {"time", step / 3}, {"energy", -step * 1e-300}}; }

/// The file's text, on all ranks.
std::string text_of(const std::string& file) {
  std::string text;
  on_rank_zero(PETSC_COMM_WORLD, [&] { text = read_file(file); });
  return broadcast(PETSC_COMM_WORLD, text);
}

std::vector<std::string> lines_of(const std::string& file) {
  std::istringstream in(text_of(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(HistoryFile, HoldsOneLineOfNamesAndExactNumbers) {
  const std::string file = fresh_dir("history") + "/below/history.csv";
  HistoryFile history(PETSC_COMM_WORLD, file);
  const double values[] = {0.1, 1.0 / 3, -0.0, 5e-324, std::numeric_limits<double>::max(), 123456789, 1e22};
  HistoryFile::Row first = {{"step", 0}};
  for (int k = 0; k < 7; ++k) first.push_back({"c" + std::to_string(k), values[k]});
  history.write(first);
  const auto lines = lines_of(file); // read while the file is open: the row is there at once
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0], "step,c0,c1,c2,c3,c4,c5,c6");
  std::istringstream cells(lines[1]);
  std::string cell;
  std::getline(cells, cell, ',');
  EXPECT_EQ(cell, "0");
  for (const double value : values) {
    std::getline(cells, cell, ',');
    EXPECT_EQ(std::strtod(cell.c_str(), nullptr), value) << cell;
    EXPECT_EQ(cell[0] == '-', std::signbit(value)) << cell;
  }
}

TEST(HistoryFile, FillsMissingColumnsWithNanWhateverTheirOrder) {
  const std::string file = fresh_dir("history_nan") + "/history.csv";
  HistoryFile history(PETSC_COMM_WORLD, file);
  history.write({{"step", 0}, {"a", 1}, {"b", 2}});
  history.write({{"b", 3}, {"step", 1}});
  history.write({{"step", 2}, {"a", std::nan("")}, {"b", -std::numeric_limits<double>::infinity()}});
  EXPECT_EQ(text_of(file), "step,a,b\n0,1,2\n1,nan,3\n2,nan,-inf\n");
  EXPECT_ANY_THROW(history.write({{"step", 3}, {"new", 1}}));
  EXPECT_EQ(text_of(file), "step,a,b\n0,1,2\n1,nan,3\n2,nan,-inf\n");
}

TEST(HistoryFile, RestartGivesTheTextOfTheUninterruptedRun) {
  const std::string dir = fresh_dir("history_restart"), whole = dir + "/whole.csv", cut = dir + "/cut.csv";
  {
    HistoryFile history(PETSC_COMM_WORLD, whole);
    for (int n = 0; n <= 9; ++n) history.write(row(n));
    HistoryFile first(PETSC_COMM_WORLD, cut);
    for (int n = 0; n <= 7; ++n) first.write(row(n));
  }
  for (const char* rest : {"", "8,0.3", "8", "\n"}) { // what a kill may leave of a row
    on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(cut, std::ios::app) << rest; });
    HistoryFile second(PETSC_COMM_WORLD, cut, 5);
    for (int n = 6; n <= 9; ++n) second.write(row(n));
    EXPECT_EQ(text_of(cut), text_of(whole));
  }
}

TEST(HistoryFile, StartsAnewWithoutAnOldFileAndWithoutResuming) {
  const std::string file = fresh_dir("history_new") + "/history.csv";
  const auto unit = [](const std::string& column) { return column == "time" ? " [ms]" : ""; };
  HistoryFile(PETSC_COMM_WORLD, file, 5, unit).write(row(6));
  EXPECT_EQ(lines_of(file)[0], "step,time [ms],energy");
  HistoryFile(PETSC_COMM_WORLD, file, 6).write(row(7)); // units are passed over
  EXPECT_EQ(lines_of(file).size(), 3U);
  HistoryFile(PETSC_COMM_WORLD, file).write(row(0));
  EXPECT_EQ(lines_of(file).size(), 2U);
}

TEST(HistoryFile, RefusesToContinueOtherColumnsOrOtherFiles) {
  const std::string dir = fresh_dir("history_other"), file = dir + "/history.csv", other = dir + "/notes.txt";
  HistoryFile(PETSC_COMM_WORLD, file).write(row(0));
  HistoryFile resumed(PETSC_COMM_WORLD, file, 0);
  const std::string message = io_error_of([&] { resumed.write({{"step", 1}, {"probe_p1_u", 2}}); });
  EXPECT_NE(message.find("probe_p1_u"), std::string::npos) << message;
  EXPECT_NE(message.find(file), std::string::npos) << message;
  on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(other) << "dear diary\n"; });
  EXPECT_NE(io_error_of([&] { HistoryFile(PETSC_COMM_WORLD, other, 3); }), "");
  EXPECT_EQ(text_of(other), "dear diary\n");
}

TEST(HistoryFile, SaysOnAllRanksThatTheDiskRefuses) {
  const std::string dir = fresh_dir("history_refused");
  on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(dir + "/file") << "x"; });
  const std::string below = dir + "/file/history.csv";
  EXPECT_NE(io_error_of([&] { HistoryFile(PETSC_COMM_WORLD, below); }).find("Not a directory"),
            std::string::npos);
  HistoryFile full(PETSC_COMM_WORLD, "/dev/full");
  const std::string message = io_error_of([&] { full.write(row(0)); });
  EXPECT_NE(message.find("/dev/full: No space left on device"), std::string::npos) << message;

  const std::string file = dir + "/history.csv";
  HistoryFile history(PETSC_COMM_WORLD, file);
  history.write(row(0));
  const std::string before = text_of(file);
  {
    const FileSizeLimit limit(before.size() + 10);
    EXPECT_NE(io_error_of([&] { history.write(row(1)); }), "");
    EXPECT_EQ(text_of(file), before);
  }
  history.write(row(1));
  EXPECT_EQ(lines_of(file).size(), 3U);
}

} // namespace
} // namespace impact
