// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

#include "tools/render/image.h"

namespace thew::tools {

/// Encodes PNGs on a thread of its own, since libpng takes as long as drawing.
class FrameWriter {
 public:
  FrameWriter() = default;
  /// Writes what is still queued; an error that finish() did not fetch is lost.
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  /// Queues one image, to be listed as `of`; waits while kQueueLength are queued. After an error
  /// images are dropped.
  void add(const std::filesystem::path& file, Image image, const std::string& of = {});
  /// Waits for all images; rethrows the first error. No add() after it.
  void finish();

  static constexpr std::size_t kQueueLength = 8;

 private:
  void start();
  struct Queued {
    std::filesystem::path file;
    Image image;
    std::string of;
  };
  void run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Queued> queue_;
  bool started_ = false, finished_ = false;
  std::exception_ptr error_;
  std::thread thread_;  ///< from the first image on
};

}  // namespace thew::tools
