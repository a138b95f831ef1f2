// SPDX-License-Identifier: Apache-2.0
// One allocation fails in a bake of two frames, each one in turn. The bake ends with an exception,
// the frames that were completed stay, and the next bake goes on from there. THEW_EVERY=1 in the
// environment tries all allocations.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <new>

#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"

namespace {

std::atomic<long> allocations{0}, fails_at{-1};

void* allocate(std::size_t bytes, std::size_t alignment) {
  if (++allocations == fails_at) throw std::bad_alloc();
  void* memory = nullptr;
  if (posix_memalign(&memory, std::max(alignment, sizeof(void*)), bytes) != 0) {
    throw std::bad_alloc();
  }
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) { return allocate(bytes, alignof(std::max_align_t)); }
void* operator new[](std::size_t bytes) { return allocate(bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
// A sanitizer's own would not come here.
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void* operator new[](std::size_t bytes, const std::nothrow_t& nothrow) noexcept {
  return operator new(bytes, nothrow);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

Model two_muscles() {
  return build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml",
                                {"scene.settle=0", "solver.iterations=1"}));
}

std::string bake_two(const Model& model, const fs::path& folder, bool resume, int& frames) {
  const auto count = [&](const BakeFrame&) {
    ++frames;
    return true;
  };
  return bake(model, {folder, {1, 2}, 2, resume}, count).hash;
}

TEST(Memory, AnyAllocationMayFail) {
  const fs::path folder =
      fs::path(testing::TempDir()) / ("thew_memory_" + std::to_string(getpid()));
  fs::remove_all(folder);
  int frames = 0;
  allocations = 0;
  const Model model = two_muscles();
  const long before = allocations;
  const std::string whole = bake_two(model, folder / "whole", false, frames);
  const long count = allocations;
  ASSERT_EQ(frames, 2);
  ASSERT_GT(count, 1000);
  const char* all = std::getenv("THEW_EVERY");
  const auto step_at = [&](long at) {
    return all ? std::atol(all) : std::max(1L, at < before ? before / 15 : (count - before) / 30);
  };
  int failed = 0, resumed = 0;
  for (long at = 1; at <= count && !HasFailure(); at += step_at(at)) {
    SCOPED_TRACE("allocation " + std::to_string(at) + " of " + std::to_string(count));
    const fs::path out = folder / "failed";
    frames = 0;
    allocations = 0;
    fails_at = at;
    std::string hash;
    try {
      hash = bake_two(two_muscles(), out, false, frames);
    } catch (const std::bad_alloc&) {
      ++failed;
    } catch (const Error&) {  // of the child, or of what stands in for it
      ++failed;
    }
    fails_at = -1;
    int again = 0;
    if (hash.empty() && !fs::exists(out / "bake.h5")) hash = bake_two(model, out, true, again);
    if (!hash.empty()) {
      EXPECT_EQ(hash, whole);
    }
    EXPECT_FALSE(fs::exists(out / "bake.h5.tmp"));
    resumed += frames > 0 && again == 2;
    fs::remove_all(out);
  }
  std::printf("%ld allocations, %d of those tried failed the bake, %d of these had a frame\n",
              count, failed, resumed);
  EXPECT_GT(failed, 20);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace thew::tests
