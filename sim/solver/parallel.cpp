// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/parallel.h"

#include <pthread.h>

#include <ctime>
#include <exception>
#include <system_error>

namespace thew::sim {

Parallel::Parallel(int threads) {
  try {
    for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { work(); });
  } catch (const std::system_error&) {  // the system gives no more threads
  } catch (...) {                       // the threads that have started have to be joined
    end();
    throw;
  }
}

Parallel::~Parallel() { end(); }

double Parallel::cpu_seconds() const {
  double sum = 0.0;
  for (const std::thread& worker : workers_) {
    clockid_t clock = 0;
    timespec cpu{};
    // native_handle() is not const, though it changes nothing.
    if (::pthread_getcpuclockid(const_cast<std::thread&>(worker).native_handle(), &clock) != 0 ||
        ::clock_gettime(clock, &cpu) != 0) {
      continue;
    }
    sum += static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec);
  }
  return sum;
}

void Parallel::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    start_.wait(lock, [this] { return stop_ || next_ < count_; });
    if (stop_) return;
    run_indices(lock);
  }
}

void Parallel::end() {
  {
    std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  start_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void Parallel::run_indices(std::unique_lock<std::mutex>& lock) {
  while (next_ < count_) {
    const int index = next_++;
    ++running_;
    lock.unlock();
    std::exception_ptr failure;
    try {
      call_(work_, index);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    --running_;
    if (failure && (!failure_ || index < failed_index_)) {
      failure_ = failure;
      failed_index_ = index;
    }
  }
  if (running_ == 0) finish_.notify_all();
}

void Parallel::run(int count, Call call, const void* work) {
  if (workers_.empty()) {
    for (int i = 0; i < count; ++i) call(work, i);
    return;
  }
  std::unique_lock lock(mutex_);
  call_ = call;
  work_ = work;
  next_ = 0;
  count_ = count;
  failure_ = nullptr;
  start_.notify_all();
  run_indices(lock);
  finish_.wait(lock, [this] { return running_ == 0; });
  count_ = next_ = 0;
  if (failure_) std::rethrow_exception(failure_);
}

}  // namespace thew::sim
