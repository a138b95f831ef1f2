// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "rig/loop.h"

namespace thew::sim {

/// Threads that share the indices of a loop. Each index is worked on by one thread, and its work
/// may write only what belongs to that index, so that results do not depend on the number of
/// threads.
class Parallel {
 public:
  /// As many threads as are asked for, or as many as the system gives; the caller is one of them.
  explicit Parallel(int threads);
  ~Parallel();
  Parallel(const Parallel&) = delete;
  Parallel& operator=(const Parallel&) = delete;

  /// work(i) for i in 0..count-1; rethrows the exception of the lowest index that threw. Allocates
  /// nothing.
  template <typename Work>
  void each(int count, const Work& work) {
    run(
        count, [](const void* of, int i) { (*static_cast<const Work*>(of))(i); }, &work);
  }
  /// The same as an argument for libraries that know no threads.
  rig::Loop loop() {
    return {this, [](void* self, int count, Call call, const void* work) {
              static_cast<Parallel*>(self)->run(count, call, work);
            }};
  }
  int threads() const { return static_cast<int>(workers_.size()) + 1; }
  /// What processors have spent on them, without the caller, s.
  double cpu_seconds() const;

 private:
  using Call = rig::Loop::Call;
  void run(int count, Call call, const void* work);
  void work();
  void run_indices(std::unique_lock<std::mutex>& lock);
  void end();

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable start_, finish_;
  Call call_ = nullptr;
  const void* work_ = nullptr;
  int next_ = 0, count_ = 0, running_ = 0;
  int failed_index_ = 0;
  std::exception_ptr failure_;
  bool stop_ = false;
};

}  // namespace thew::sim
