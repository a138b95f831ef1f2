// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "sim/cache/cache.h"

namespace thew::tests {

/// An empty folder with the test's name, gone at the end of the test.
class CacheTest : public testing::Test {
 protected:
  CacheTest() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("thew_") + test->test_suite_name() + "_" + test->name() + "_" +
               std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~CacheTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void put_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

template <typename Work>
void expect_error(ErrorCode code, const std::string& word, Work work) {
  try {
    work();
    FAIL() << "nothing was thrown, expected: " << word;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

/// Three meshes, not in the order of their names, and frames with a step.
inline BakeInfo small_info(bool double_precision) {
  BakeInfo info;
  info.scene_name = "small";
  info.scene_hash = "0123456789abcdef";
  info.scene_text = "[solver]\niterations = 3\n";
  info.fps = 24.0;
  info.double_precision = double_precision;
  info.frames = {-2, 0, 2, 4};
  const TriMesh tetrahedron{
      {Vec3(0, 0, 0), Vec3(1.0 / 3, 0, 0), Vec3(0, 1.0 / 7, 0), Vec3(0, 0, 0.1)},
      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  info.meshes = {{"ulna", BakeMesh::Kind::kBone, tetrahedron, {}, {}},
                 {"biceps",
                  BakeMesh::Kind::kMuscle,
                  tetrahedron,
                  {0.0, 0.25, 1.0 / 3, 1.0},
                  {{0, 0, 0}, {0.5, 0.1, 1}, {0.5, 3, 1}, {1, 0, 0}}},
                 {"skin", BakeMesh::Kind::kSkin, tetrahedron, {}, {}}};
  info.meshes[2].rest.vertices.push_back(Vec3(2, 2, 2));
  info.character = {"figures/small.glb", 0.5, {BodyFrame{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}};
  info.character.rest.push_back({0, 0, 0.1, 1.0 / 3, 0.1, 0, 0, 2, 0, 0.1, 0, -1.0 / 7});
  info.metric_names = {"volume_error/biceps", "length/biceps", "penetration"};
  return info;
}

/// Some numbers with all their bits in use, different in each place.
inline BakeFrame small_frame(const BakeInfo& info, int frame) {
  BakeFrame result;
  result.frame = frame;
  for (const BakeMesh& mesh : info.meshes) {
    auto& positions = result.positions.emplace_back(mesh.rest.vertices);
    for (Vec3& p : positions) p += Vec3(frame / 3.0, frame / 7.0, p.x() / 11.0);
  }
  result.bodies = info.character.rest;
  for (BodyFrame& body : result.bodies) body[3] += frame / 3.0;
  for (std::size_t k = 0; k < info.metric_names.size(); ++k) {
    result.metrics.push_back((frame + 0.1) / (k + 3.0));
  }
  result.state = {frame / 13.0, 1e300, -0.0};
  return result;
}

/// Bakes what is missing; `most` frames at most, then leaves the parts where they are.
inline std::string bake_small(const std::filesystem::path& folder, const BakeInfo& info,
                              bool resume = false, std::size_t most = 1000) {
  BakeWriter writer(folder, info, resume);
  for (std::size_t i = writer.completed().size(); i < std::min(most, info.frames.size()); ++i) {
    writer.write(small_frame(info, info.frames[i]));
  }
  return most >= info.frames.size() ? writer.pack() : "";
}

}  // namespace thew::tests
