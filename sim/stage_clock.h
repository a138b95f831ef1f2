// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <ctime>

#include "sim/solver/parallel.h"

namespace thew::sim {

/// Time by the clock on the wall, and the time that processors spent, s.
struct Seconds {
  double wall = 0.0, cpu = 0.0;

  Seconds& operator+=(const Seconds& other) {
    wall += other.wall;
    cpu += other.cpu;
    return *this;
  }
};

/// Measures lap by lap. The end of a lap is the beginning of the next one, so that the laps add up
/// to the whole.
class StopWatch {
 public:
  /// Of all threads of this process.
  StopWatch() = default;
  /// Of the calling thread and these, whatever works beside them. They live longer.
  explicit StopWatch(const Parallel& threads) : threads_(&threads) {}

  /// Since the last call, or since this object was made.
  Seconds lap() {
    const Seconds before = last_;
    last_ = now();
    return {last_.wall - before.wall, last_.cpu - before.cpu};
  }

 private:
  Seconds now() const {
    timespec cpu{};
    ::clock_gettime(threads_ ? CLOCK_THREAD_CPUTIME_ID : CLOCK_PROCESS_CPUTIME_ID, &cpu);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now().time_since_epoch();
    const double others = threads_ ? threads_->cpu_seconds() : 0.0;
    return {wall.count(),
            others + static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec)};
  }
  const Parallel* threads_ = nullptr;
  Seconds last_ = now();
};

/// Adds the seconds of one stage after the other to their totals. The last stage ends with this
/// object, also where an exception ends it.
class StageClock {
 public:
  StageClock(Seconds& total, const Parallel& threads) : total_(&total), watch_(threads) {}
  ~StageClock() { *total_ += watch_.lap(); }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;

  /// Ends the present stage and begins the one that `total` belongs to.
  void enter(Seconds& total) {
    *total_ += watch_.lap();
    total_ = &total;
  }

 private:
  Seconds* total_;
  StopWatch watch_;
};

}  // namespace thew::sim
