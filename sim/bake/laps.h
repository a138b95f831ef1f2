// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace thew::sim {

/// Wall seconds of one thread's work, lap by lap: what ends one begins the next, so that nothing
/// falls between two.
class Laps {
 public:
  double next() {
    const Clock::time_point now = Clock::now();
    const std::chrono::duration<double> lap = now - last_;
    last_ = now;
    return lap.count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace thew::sim
