// SPDX-License-Identifier: Apache-2.0
//
// The quick run of `thew paper`: all files there, and all that does not depend on the clock shown.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/unit/rig/temp.h"
#include "tools/lab/paper/command.h"

namespace thew::tests {
namespace {

class Paper : public TempFolder {};

TEST_F(Paper, TheQuickRunShowsWhatItMust) {
  CommandOptions options;
  options.out = folder / "paper";
  options.progress = "none";
  ASSERT_EQ(paper_command(options, true, {}), ExitCode::kDone);
  for (const char* file :
       {"report.html",          "table1.csv",         "table1_ratios.csv", "table1_errors.csv",
        "table2.csv",           "table2_muscles.csv", "distance.csv",      "neo_hookean.csv",
        "fem_penalty.csv",      "printed_errors.csv", "verdicts.csv",      "figure2_finger.png",
        "figure3_muscles.png",  "figure4_zone.png",   "figure5_zone.png",  "figure5_zone.svg",
        "figure6_cow.png",      "figure7_ball.png",   "figure7_cube.png",  "figure7_arm.png",
        "figure7_arm_skin.png", "figure8.svg",        "cube_load.png",     "holes.png"}) {
    EXPECT_TRUE(std::filesystem::exists(options.out / file)) << file;
  }
  std::ifstream in(options.out / "verdicts.csv");
  std::string line;
  int verdicts = 0;
  while (std::getline(in, line)) {
    const bool timed = line.find("over") != std::string::npos;
    verdicts += line.find(",yes,") != std::string::npos || line.find(",no,") != std::string::npos;
    if (!timed) {
      EXPECT_EQ(line.find(",no,"), std::string::npos) << line;
    }
  }
  EXPECT_EQ(verdicts, 9);
}

}  // namespace
}  // namespace thew::tests
