// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tools/base/progress.h"
#include "tools/base/svg_chart.h"
#include "tools/lab/base/table.h"
#include "tools/lab/paper/run.h"
#include "tools/render/renderer.h"

namespace thew::tools {

/// What is to be shown, its bound, and what was found.
struct PaperVerdict {
  std::string what, found, wanted;
  bool met = false;
  std::string reason;  ///< where it is missed
};

/// Gathers what the experiments find; writes tables and figures at once, the report at the end. One
/// thread's, but for done().
class PaperReport {
 public:
  /// `overwrite`: also what Thew did not write.
  PaperReport(const std::filesystem::path& folder, bool quick, const std::filesystem::path& cow,
              bool overwrite, Progress& progress);

  /// What is added goes there from here on; the report has its chapters in order.
  void chapter(int number) { chapter_ = number; }
  void section(const std::string& title, const std::string& text);
  void add(const Table& table);
  void add(const LineChart& chart, const std::string& file, const std::string& caption);
  /// Pictures side by side, all of the first one's proportions; `labels` one each.
  void add(const std::vector<PaperPicture>& pictures, const std::vector<std::string>& labels,
           const std::string& file, const std::string& caption);
  void add(const PaperVerdict& verdict);
  void done(int steps = 1);  ///< for the progress bar
  void write(double seconds);
  /// By chapter; the first of the verdicts'.
  std::vector<Table> tables() const;
  /// folder / name, ours to write.
  std::filesystem::path place(const std::string& name) const;

  const bool quick;
  const std::filesystem::path folder, cow, scenes;

 private:
  struct Chapter {
    std::string html;
    std::vector<Table> tables;
    std::vector<PaperVerdict> verdicts;
  };

  bool overwrite_;
  std::vector<PaperVerdict> verdicts() const;

  std::map<int, Chapter> chapters_;
  int chapter_ = 0;
  std::unique_ptr<Renderer> renderer_;
  std::mutex mutex_;  // of what follows
  Progress& progress_;
  int steps_ = 0;
};

// The experiments but the ball's (paper_ball.h).
void paper_bodies(PaperReport& report);  ///< cubes, cow, torus, rings, finger, muscles, arm
void paper_errors(PaperReport& report);  ///< what is wrong in print, shown
/// Steps that these take, for the progress bar.
int paper_steps(bool quick);

}  // namespace thew::tools
