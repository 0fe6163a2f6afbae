#include <gtest/gtest.h>
#include <impact/mesh/state_table.hpp>
#include <stdexcept>

namespace impact {

namespace {

StateRow named(const char* name, bool has_trial) {
  return {.name = name, .support = Support::global, .components = 2, .has_trial = has_trial};
}

TEST(StateTable, CommitTakesTheTrialHalfAndRollbackDropsIt) {
  StateTable table;
  StateRow& row = table.add(named("a", true), 4, 1.5);
  EXPECT_EQ(row.committed, std::vector<double>(4, 1.5));
  EXPECT_EQ(row.trial, row.committed);
  row.trial[2] = 7;
  table.rollback();
  EXPECT_EQ(row.trial[2], 1.5);
  row.trial[2] = 7;
  table.commit();
  EXPECT_EQ(row.committed[2], 7);
  EXPECT_EQ(row.trial[2], 7);
}

TEST(StateTable, ReferencesAndDataStayValid) {
  StateTable table;
  StateRow& first = table.add(named("first", true), 2);
  const double* data = first.committed.data();
  for (int k = 0; k < 100; ++k) table.add(named(("row" + std::to_string(k)).c_str(), false), 2);
  table.commit();
  table.rollback();
  EXPECT_EQ(&table.row("first"), &first);
  EXPECT_EQ(first.committed.data(), data);
  EXPECT_TRUE(table.row("row5").trial.empty());
}

TEST(StateTable, RefusesDoubleAndUnknownNamesAndOddSizes) {
  StateTable table;
  table.add(named("a", true), 2);
  EXPECT_THROW(table.add(named("a", true), 2), std::logic_error);
  EXPECT_THROW(table.add(named("b", true), 3), std::logic_error);
  EXPECT_THROW(table.row("c"), std::out_of_range);
  EXPECT_EQ(table.find("c"), nullptr);
}

} // namespace

} // namespace impact
