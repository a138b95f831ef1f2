// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <ctime>

namespace thew::sim {

/// Time by the clock on the wall, and the time that processors spent on all threads of this
/// process, s.
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
  /// Since the last call, or since this object was made.
  Seconds lap() {
    const Seconds before = last_;
    last_ = now();
    return {last_.wall - before.wall, last_.cpu - before.cpu};
  }

 private:
  static Seconds now() {
    timespec cpu{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now().time_since_epoch();
    return {wall.count(),
            static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec)};
  }
  Seconds last_ = now();
};

/// Adds the seconds of one stage after the other to their totals. The last stage ends with this
/// object, also where an exception ends it.
class StageClock {
 public:
  explicit StageClock(Seconds& total) : total_(&total) {}
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
