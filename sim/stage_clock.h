// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace thew::sim {

/// Adds the wall seconds of one stage after the other to their totals. The last stage ends with
/// this object, also where an exception ends it.
class StageClock {
 public:
  explicit StageClock(double& total) : total_(&total) {}
  ~StageClock() { stop(); }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;

  /// Ends the present stage and begins the one that `total` belongs to.
  void enter(double& total) {
    stop();
    total_ = &total;
  }

 private:
  using Clock = std::chrono::steady_clock;

  void stop() {
    const Clock::time_point now = Clock::now();
    *total_ += std::chrono::duration<double>(now - begin_).count();
    begin_ = now;
  }

  double* total_;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace thew::sim
