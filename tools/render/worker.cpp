// SPDX-License-Identifier: Apache-2.0
#include "tools/render/worker.h"

#include <cassert>
#include <system_error>
#include <utility>

namespace thew::tools {

Worker::~Worker() {
  try {
    finish();
  } catch (...) {  // whoever unwinds past finish() has an error of its own
  }
}

void Worker::start() {
  if (std::exchange(started_, true)) return;
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error&) {  // add() works itself
  }
}

void Worker::add(std::function<void()> job) {
  start();
  if (!thread_.joinable()) return job();
  std::unique_lock lock(mutex_);
  assert(!finished_);
  changed_.wait(lock, [this] { return queue_.size() < most_queued_ || error_; });
  if (error_) return;
  queue_.push_back(std::move(job));
  changed_.notify_all();
}

void Worker::check() {
  const std::lock_guard lock(mutex_);
  if (error_) std::rethrow_exception(error_);
}

void Worker::finish() {
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void Worker::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return finished_ || !queue_.empty(); });
    if (queue_.empty()) return;
    std::function<void()> job = std::move(queue_.front());
    queue_.pop_front();
    changed_.notify_all();
    lock.unlock();
    std::exception_ptr error;
    try {
      job();
    } catch (...) {
      error = std::current_exception();
    }
    job = nullptr;  // frees what it holds before another is queued in its place
    lock.lock();
    if (!error) continue;
    error_ = error;
    changed_.notify_all();
    return;
  }
}

}  // namespace thew::tools
