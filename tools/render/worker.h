// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace thew::tools {

/// Does jobs one after the other on a thread of its own, beside the caller. Where the system gives
/// no more threads, the caller does them itself.
class Worker {
 public:
  /// Waits while so many jobs are queued, which bounds the memory they hold.
  explicit Worker(std::size_t most_queued) : most_queued_(most_queued) {}
  /// Does what is still queued; an error that finish() did not fetch is lost.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// After an error jobs are dropped.
  void add(std::function<void()> job);
  /// Rethrows the first error, if there is one by now.
  void check();
  /// Waits for all jobs; rethrows the first error. No add() after it.
  void finish();

 private:
  void start();
  void run();

  const std::size_t most_queued_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> queue_;
  bool started_ = false, finished_ = false;
  std::exception_ptr error_;
  std::thread thread_;  ///< from the first job on
};

}  // namespace thew::tools
