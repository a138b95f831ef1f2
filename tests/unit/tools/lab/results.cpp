// SPDX-License-Identifier: Apache-2.0
//
// The page of results: its form, of given numbers and of a small scene. No time is expected here.
#include "tools/lab/results/results.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "rig/types.h"

namespace thew::tests {
namespace {

ResultsHead some_head(bool quick) {
  return {"2026-01-31", "a processor, 2 cores", "g++ 12", "abc123", 0.5, 1.5, 12.0, quick, ""};
}

TEST(ResultsPage, StatesWhereItsFiguresWereTaken) {
  const std::string page = results_page(some_head(false), {});
  for (const char* line :
       {"# Results\n", "- Date: 2026-01-31\n", "- Processor: a processor, 2 cores\n",
        "- Compiler: g++ 12\n", "- Commit: abc123\n",
        "- Load average of the machine: 0.5 before, 1.5 after", "- Time taken: 12 minutes\n"}) {
    EXPECT_NE(page.find(line), std::string::npos) << line << "\n" << page;
  }
  EXPECT_EQ(page.find("quick run"), std::string::npos);
  EXPECT_NE(results_page(some_head(true), {}).find("quick run"), std::string::npos);
  EXPECT_EQ(page.find("Interrupted"), std::string::npos);
  ResultsHead early = some_head(false);
  early.missing = "bar, peers";
  EXPECT_NE(results_page(early, {}).find("**Interrupted; not measured: bar, peers.**"),
            std::string::npos);
}

TEST(ResultsPage, HasItsTablesAsMarkdown) {
  const Table table{"", "Speed", "A note.", {"what", "figure"}, {{"contact", "3.1"}, {"a|b", ""}}};
  const std::string page = results_page(some_head(false), {table, table});
  const std::string wanted =
      "\n## Speed\n\n| what | figure |\n| --- | --- |\n| contact | 3.1 |\n| a\\|b |  |\n\nA "
      "note.\n";
  EXPECT_EQ(page.substr(page.size() - 2 * wanted.size()), wanted + wanted);
}

TEST(ResultsHead, IsOfThisMachine) {
  const ResultsHead head = results_head("abc", true);
  EXPECT_EQ(head.date.size(), 10u);
  EXPECT_NE(head.processor.find(" cores"), std::string::npos);
  EXPECT_FALSE(head.compiler.empty());
  EXPECT_EQ(head.commit, "abc");
  EXPECT_TRUE(head.quick);
}

TEST(Flexion, HasAFigureACommandAndATestInEachRow) {
  const Table table = flexion_table(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml", 3, 1);
  EXPECT_EQ(table.head, figure_head());
  ASSERT_GE(table.rows.size(), 10u);
  for (const auto& row : table.rows) {
    ASSERT_EQ(row.size(), 4u);
    EXPECT_TRUE(std::none_of(row.begin(), row.end(), [](auto& cell) { return cell.empty(); }))
        << row[0];
  }
  EXPECT_EQ(table.rows[0][0], "volume error as solved, at frames");
  EXPECT_LE(std::stod(table.rows[0][1]), 1e-12);
}

// All that is measured of muscles in contact, of more than one.
TEST(ResultsPage, StatesTheSpeedOfASceneOfSeveralMuscles) {
  const Table table = speed_table(THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml", true);
  EXPECT_EQ(table.rows.size(), 8u);
  for (const std::vector<std::string>& row : table.rows) {
    ASSERT_EQ(row.size(), table.head.size());
    EXPECT_GT(std::stod(row[1]), 0.0) << row[0];
  }
  // Its muscles hold themselves: gravity moves them by hundredths of a millimetre.
  EXPECT_EQ(table.rows[6][0], "sag of the first muscle held horizontally");
  EXPECT_GT(std::stod(table.rows[6][1]), 1e-3);
  EXPECT_LT(std::stod(table.rows[6][1]), 1.0);
}

}  // namespace
}  // namespace thew::tests
