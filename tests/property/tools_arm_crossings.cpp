// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <functional>
#include <map>

#include "rig/math.h"
#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/property/every.h"
#include "tools/author/table.h"
#include "tools/inspect/crossings.h"

namespace thew::tests {
namespace {

// Neither bone and muscle (but where a tendon enters its bone), nor muscles, nor the skin with any
// of them or with itself: by the exact tests of thew inspect, which share nothing with contact and
// take as long as the frame.
using Also = std::function<void(const std::vector<BakeMesh>&, const BakeFrame&)>;

void expect_none(const std::string& scene, int step, const std::vector<std::string>& changes = {},
                 const Also& also = {}) {
  SCOPED_TRACE(scene);
  const Model model = build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/" + scene, changes));
  BakeOptions options;
  options.is_chunk = true;  // nobody reads the cache
  options.folder =
      std::filesystem::path(testing::TempDir()) / ("thew_crossings_" + std::to_string(getpid()));
  for (int f = model.first_frame; f <= model.last_frame; f += step) {
    options.frames.push_back(f);
  }
  const std::vector<BakeMesh> meshes = bake_info(model, options.frames).meshes;
  size_t checked = 0;
  bake(model, options, [&](const BakeFrame& frame) {
    const auto found = count_crossings(meshes, frame.positions);
    for (size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].pairs, 0) << kLayerPairs[k] << ", frame " << frame.frame;
    }
    EXPECT_GT(found[0].attached, 0) << "tendons enter their bones";
    if (also) also(meshes, frame);
    ++checked;
    return true;
  });
  EXPECT_EQ(checked, options.frames.size());
  std::filesystem::remove_all(options.folder);
}

// Of the rings of a muscle's tendon from the wrist on, how far the farthest is from bone (m).
double farthest_from_bone(const std::vector<BakeMesh>& meshes, const BakeFrame& frame, size_t m,
                          int around) {
  constexpr double kWrist = 0.87;                       // of the path, its last 4 cm
  const std::vector<Vec3>& nodes = frame.positions[m];  // a pole, rings, a pole
  std::vector<double> least((nodes.size() - 2) / around, 1.0);
  for (size_t b = 0; b < meshes.size(); ++b) {
    if (meshes[b].kind != BakeMesh::Kind::kBone) continue;
    Points x;
    for (const Vec3& p : frame.positions[b]) x.push_back(to_point(p));
    const Surface surface = make_surface(meshes[b].rest.triangles, static_cast<int>(x.size()));
    const Bvh bvh = build_bvh(surface, x);
    for (size_t i = 0; i + 2 < nodes.size(); ++i) {
      double& of_ring = least[i / around];
      if (meshes[m].coordinates[i + 1][0] < kWrist) continue;
      const ClosestPoint near = closest_point(surface, bvh, x, nodes[i + 1], of_ring);
      if (near.triangle >= 0) of_ring = std::min(of_ring, near.distance);
    }
  }
  double farthest = 0.0;
  for (const double distance : least) {
    if (distance < 1.0) farthest = std::max(farthest, distance);
  }
  return farthest;
}

TEST(ArmCrossings, ThereAreNoneInTheFold) { expect_none("arm.toml", 1); }
TEST(ArmCrossings, ThereAreNoneInACurl) { expect_none("curl.toml", every(2)); }
TEST(ArmCrossings, ThereAreNoneInATurn) { expect_none("turn.toml", every(2)); }
TEST(ArmCrossings, ThereAreNoneInAReach) { expect_none("reach.toml", every(2)); }
TEST(ArmCrossings, ThereAreNoneInAStill) { expect_none("still.toml", every(2)); }

// The hand bends back and forth as far as it goes. A retinaculum and what is under it hold the
// tendons at the wrist: near the bones while the hand is straight, out of them wherever it goes.
TEST(ArmCrossings, ThereAreNoneWhereTheHandBends) {
  const std::vector<std::string> changes = {
      "scene.frames=1-43",
      "rig.clip={ unit = \"deg\", keys = { elbow = [[1, 30]], "
      "wrist_flexion = [[1, 0], [15, -70], [43, 70]] } }"};
  const std::vector<TableMuscle> table =
      read_muscle_table(THEW_SOURCE_DIR "/assets/arm/muscles.csv", arm_skeleton());
  std::map<std::string, double> farthest, straight;
  expect_none("arm.toml", every(2), changes, [&](const auto& meshes, const auto& frame) {
    for (size_t m = 0; m < meshes.size(); ++m) {
      for (const TableMuscle& row : table) {
        if (row.name != meshes[m].name || row.name.find("carpi") == std::string::npos) continue;
        const double far = farthest_from_bone(meshes, frame, m, row.around);
        farthest[row.name] = std::max(farthest[row.name], far);
        if (frame.frame == 1) straight[row.name] = far;
      }
    }
  });
  ASSERT_EQ(straight.size(), 2u);
  for (const auto& [name, far] : straight) EXPECT_LT(far, 5e-3) << name;
  // Where the bend is hollow they bridge the joint.
  for (const auto& [name, far] : farthest) EXPECT_LT(far, 12e-3) << name;
}

}  // namespace
}  // namespace thew::tests
