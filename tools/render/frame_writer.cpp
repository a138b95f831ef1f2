// SPDX-License-Identifier: Apache-2.0
#include "tools/render/frame_writer.h"

#include <cassert>
#include <system_error>
#include <utility>

namespace thew::tools {

FrameWriter::~FrameWriter() {
  try {
    finish();
  } catch (...) {  // whoever unwinds past finish() has an error of its own
  }
}

void FrameWriter::start() {
  if (std::exchange(started_, true)) return;
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error&) {  // the system gives no more threads: add() writes itself
  }
}

void FrameWriter::add(const std::filesystem::path& file, Image image, const std::string& of) {
  start();
  if (!thread_.joinable()) return write_png(file, image, 1, of);
  std::unique_lock lock(mutex_);
  assert(!finished_);
  changed_.wait(lock, [this] { return queue_.size() < kQueueLength || error_; });
  if (error_) return;
  queue_.push_back({file, std::move(image), of});
  changed_.notify_all();
}

void FrameWriter::finish() {
  {
    std::lock_guard lock(mutex_);
    finished_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void FrameWriter::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return finished_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const Queued next = std::move(queue_.front());
    queue_.pop_front();
    changed_.notify_all();
    lock.unlock();
    std::exception_ptr error;
    try {
      write_png(next.file, next.image, 1, next.of);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    if (!error) continue;
    error_ = error;
    changed_.notify_all();
    return;
  }
}

}  // namespace thew::tools
