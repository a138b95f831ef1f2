// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <optional>

#include "tests/unit/sim/cache_bake.h"
#include "tools/cli/commands.h"

namespace thew::tests {

/// Numbers one after another, as independent of the writers as can be.
struct ByteReader {
  std::string bytes;
  std::size_t at = 0;

  template <typename T>
  T take(bool big = false) {
    char memory[sizeof(T)];
    EXPECT_LE(at + sizeof(T), bytes.size());
    std::memcpy(memory, bytes.data() + at, sizeof(T));
    if (big) std::reverse(memory, memory + sizeof(T));
    at += sizeof(T);
    T value;
    std::memcpy(&value, memory, sizeof(T));
    return value;
  }
};

/// A bake of three meshes and frames -2, 0, 2, 4, and the command over it.
class ExportTest : public CacheTest {
 protected:
  ExportTest() {
    options_.input = folder_ / "bake.h5";
    options_.progress = "none";
  }
  void bake(bool double_precision) {
    info_ = small_info(double_precision);
    bake_small(folder_, info_);
    // A cache of floats gives back floats.
    reader_.emplace(folder_ / "bake.h5");
  }
  /// A bake of these frames, each as `change` leaves the small bake's.
  template <typename Change>
  void bake(const std::vector<int>& frames, Change change) {
    info_ = small_info(true);
    info_.frames = frames;
    BakeWriter writer(folder_, info_, false);
    for (const int number : frames) {
      BakeFrame frame = small_frame(info_, number);
      change(frame);
      writer.write(frame);
    }
    writer.pack();
    reader_.emplace(folder_ / "bake.h5");
  }
  std::filesystem::path write(const std::string& name, const std::vector<std::string>& meshes,
                              int basis = 0) {
    options_.out = folder_ / name;
    testing::internal::CaptureStdout();
    try {
      EXPECT_EQ(export_command(options_, meshes, basis, choice_), ExitCode::kDone);
    } catch (const Error& error) {
      ADD_FAILURE() << error.what();
    }
    said_ = testing::internal::GetCapturedStdout();
    return options_.out;
  }
  void expect_refused(ErrorCode code, const std::string& word, const std::string& name,
                      const std::vector<std::string>& meshes, int basis = 0) {
    options_.out = folder_ / name;
    expect_error(code, word, [&] { export_command(options_, meshes, basis, choice_); });
    EXPECT_FALSE(std::filesystem::exists(options_.out));
    EXPECT_FALSE(std::filesystem::exists(folder_ / (name + ".tmp")));
  }
  const BakeMesh& mesh(const std::string& name) const {
    return reader_->info().meshes[place(name)];
  }
  std::size_t place(const std::string& name) const {
    const auto& meshes = reader_->info().meshes;
    const auto found = std::find_if(meshes.begin(), meshes.end(),
                                    [&](const BakeMesh& mesh) { return mesh.name == name; });
    return static_cast<std::size_t>(found - meshes.begin());
  }
  /// As baked, at the i-th frame.
  std::vector<Vec3> positions(const std::string& name, int i) const {
    return reader_->read(i).positions[place(name)];
  }

  BakeInfo info_;
  std::optional<BakeReader> reader_;
  CommandOptions options_;
  ExportChoice choice_;
  std::string said_;
};

inline std::vector<float> as_floats(const std::vector<Vec3>& values) {
  std::vector<float> floats;
  for (const Vec3& value : values) {
    for (int axis = 0; axis < 3; ++axis) floats.push_back(static_cast<float>(value[axis]));
  }
  return floats;
}

}  // namespace thew::tests
