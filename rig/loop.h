// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew::rig {

/// How the indices of a loop are worked on: by the caller alone, or shared among the threads of
/// whoever made it. Each index may write only what is its own, so that results do not depend on the
/// number of threads.
class Loop {
 public:
  using Call = void (*)(const void* work, int index);
  using Share = void (*)(void* threads, int count, Call call, const void* work);
  Loop() = default;
  Loop(void* threads, Share share) : threads_(threads), share_(share) {}

  /// work(i) for i in 0..count-1. Allocates nothing.
  template <typename Work>
  void each(int count, const Work& work) const {
    if (!share_) {
      for (int i = 0; i < count; ++i) work(i);
      return;
    }
    share_(
        threads_, count, [](const void* of, int i) { (*static_cast<const Work*>(of))(i); }, &work);
  }
  /// work(first, last) for ranges of at most `most` indices that make up 0..count-1.
  template <typename Work>
  void ranges(int count, int most, const Work& work) const {
    each((count + most - 1) / most,
         [&](int i) { work(i * most, i * most + most < count ? i * most + most : count); });
  }

 private:
  void* threads_ = nullptr;
  Share share_ = nullptr;
};

}  // namespace thew::rig
