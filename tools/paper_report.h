// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/image.h"
#include "tools/progress.h"
#include "tools/svg_chart.h"

namespace thew {

/// A table as it is read: CSV beside the report and in it.
struct PaperTable {
  std::string file, title, note;
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
};

/// A bound of the issue and what was found.
struct PaperVerdict {
  std::string what, found, wanted;
  bool met = false;
  std::string reason;  ///< where it is missed
};

/// Gathers what the experiments find; writes tables and figures at once, the report at the end.
class PaperReport {
 public:
  PaperReport(const std::filesystem::path& folder, bool quick, const std::filesystem::path& cow,
              Progress& progress);

  void section(const std::string& title, const std::string& text);
  void add(const PaperTable& table);
  void add(const LineChart& chart, const std::string& file, const std::string& caption);
  /// Images side by side, all of the first one's proportions; `labels` one each.
  void add(const std::vector<Image>& images, const std::vector<std::string>& labels,
           const std::string& file, const std::string& caption);
  void add(const PaperVerdict& verdict);
  void done(int steps = 1);  ///< for the progress bar
  void write(double seconds);

  const bool quick;
  const std::filesystem::path folder, cow, scenes;

 private:
  Progress& progress_;
  std::string body_;
  std::vector<PaperVerdict> verdicts_;
  int steps_ = 0;
};

// The experiments, in the paper's order.
void paper_ball(PaperReport& report);
void paper_bodies(PaperReport& report);  ///< cubes, cow, torus, rings, finger, muscles, arm
void paper_errors(PaperReport& report);  ///< method.md's: what is wrong in print, shown
/// Steps that these take, for the progress bar.
int paper_steps(bool quick);

std::string number(double value, int digits = 3);

}  // namespace thew
