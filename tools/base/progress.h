// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

#include "tools/base/options.h"

namespace thew::tools {

/// Tells how far a long job is: a bar that redraws itself, a line at each twentieth for logs, a
/// line of JSON for each step, or what an Open Job Description's worker reads, on standard output.
/// Nothing of it goes into any result.
class Progress {
 public:
  /// `what` is done to `total` steps, "baking"; `out` is stderr in the program.
  Progress(ProgressStyle style, const std::string& what, int total, std::FILE* out);
  /// Leaves the bar's line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Step number `done` of `total` is over; it was `frame`, where steps are frames.
  void step(int done, std::optional<int> frame = std::nullopt);

 private:
  void draw_bar(int done, const std::string& frame, double seconds, double left);

  ProgressStyle style_;
  std::string what_;
  int total_;
  std::FILE* out_;
  std::chrono::steady_clock::time_point begin_;
  int first_done_ = -1;     ///< steps that a resumed job found done cost no time
  int told_ = 0;            ///< twentieths, of plain lines
  bool line_open_ = false;  ///< a bar stands on the line
};

/// "1 h 02 min", "3 min 05 s", "12 s".
std::string duration(double seconds);

}  // namespace thew::tools
