// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace thew::sim {

/// Measures wall seconds of one thread, lap by lap. The end of a lap is the beginning of the next
/// one, so that the laps add up to the whole.
class StopWatch {
 public:
  /// Seconds since the last call, or since this object was made.
  double lap() {
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
