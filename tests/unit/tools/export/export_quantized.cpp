// SPDX-License-Identifier: Apache-2.0
//
// glTF with displacements in whole steps: what a reader makes of it, against the stated error.
#include <gtest/gtest.h>

#include "rig/math.h"
#include "tests/unit/tools/export/glb_reader.h"

namespace thew::tests {
namespace {

class QuantizedTest : public ExportTest {
 protected:
  /// Six frames; `turn` moves the biceps, which also swells, so that it is not rigid.
  template <typename Turn>
  void bake_turning(Turn turn) {
    bake({1, 2, 3, 4, 5, 6}, [&](BakeFrame& frame) {
      frame.positions[1] = info_.meshes[1].rest.vertices;
      frame.positions[1][1] *= 1.0 + 0.02 * frame.frame;
      for (Vec3& p : frame.positions[1]) p = turn(frame.frame) * p + Vec3(0.3, 1.2, -0.1);
    });
  }
  Glb read(const std::string& name) {
    choice_.quantized = true;
    return read_glb(write(name, {"biceps"}));
  }
  /// The largest errors of positions (m) and normals (rad) that a reader finds.
  std::pair<double, double> errors(const Glb& glb) const {
    double place = 0.0, normal = 0.0;
    for (std::size_t key = 0; key < 6; ++key) {
      const Shape shape = GlbPlayer(glb, key).shape(0, 0);
      const std::vector<Vec3> baked = positions("biceps", static_cast<int>(key));
      const std::vector<Vec3> normals = vertex_normals({baked, mesh("biceps").rest.triangles});
      for (std::size_t v = 0; v < baked.size(); ++v) {
        place = std::max(place, (shape.positions[v] - baked[v]).norm());
        normal = std::max(normal, std::acos(std::min(1.0, shape.normals[v].dot(normals[v]))));
      }
    }
    return {place, normal};
  }
};

TEST_F(QuantizedTest, ReadersFindNoMoreThanTheStatedError) {
  // By 130 degrees about z: normals beyond 1 of those at rest.
  bake_turning(
      [](int frame) { return Mat3(Eigen::AngleAxisd(0.45 * (frame - 1), Vec3::UnitZ())); });
  const Glb glb = read("steps.glb");
  EXPECT_EQ(glb.doc["extensionsRequired"], json{"KHR_mesh_quantization"});
  const json& target = glb.doc["meshes"][0]["primitives"][0]["targets"][3];
  for (const auto& [name, type, stride] : {std::tuple("POSITION", 5122, 8), {"NORMAL", 5120, 4}}) {
    const json& accessor = glb.accessor(target[name]);
    EXPECT_EQ(accessor["componentType"], type);
    EXPECT_EQ(glb.doc["bufferViews"][accessor["bufferView"].get<int>()]["byteStride"], stride);
  }
  const auto [place, normal] = errors(glb);
  const json& stated = glb.doc["asset"]["extras"];
  const double scale = glb.doc["nodes"][0]["scale"][0];
  EXPECT_LE(1e3 * place, 1.001 * stated["position_error_max_mm"].get<double>() + 1e-4);
  EXPECT_LE(normal / kDegree, 1.001 * stated["normal_error_max_deg"].get<double>() + 1e-3);
  EXPECT_LE(place, std::sqrt(3.0) / 2 * scale / 32767 + 3e-7);
  EXPECT_GT(place, 0.01 * scale / 32767);  // it is rounded
  EXPECT_LT(normal / kDegree, 0.6);
  EXPECT_NE(said_.find("position error"), std::string::npos) << said_;
}

TEST_F(QuantizedTest, NormalsThatNoBaseReachesStayAsTheyAre) {
  // A tumble that turns each normal over in all three axes.
  bake_turning([](int frame) {
    return Mat3(Eigen::AngleAxisd(2.1 * frame, Vec3(1, 1, 1) / std::sqrt(3.0)) *
                Eigen::AngleAxisd(1.7 * frame, Vec3(1, -1, 1) / std::sqrt(3.0)));
  });
  const Glb glb = read("tumble.glb");
  const json& target = glb.doc["meshes"][0]["primitives"][0]["targets"][3];
  EXPECT_EQ(glb.accessor(target["POSITION"])["componentType"], 5122);
  EXPECT_EQ(glb.accessor(target["NORMAL"])["componentType"], 5126);
  const auto [place, normal] = errors(glb);
  EXPECT_LT(place, 1e-4);
  EXPECT_LT(normal, 1e-3);
}

TEST_F(QuantizedTest, IsForTheBakesMeshesAndEachFrame) {
  bake(true);
  choice_.quantized = true;
  expect_refused(ErrorCode::kUsage, "--quantized is for .glb", "all.usdc", {});
  expect_refused(ErrorCode::kUsage, "--quantized is for .glb", "all.glb", {}, 2);
}

TEST_F(ExportTest, GlbWritesFramesInWhichNothingMovesOnce) {
  bake({1, 2, 3, 4, 5}, [&](BakeFrame& frame) {
    frame.positions[1] = info_.meshes[1].rest.vertices;
    frame.positions[1][1].x() += 0.01 * std::min(frame.frame, 3) * (frame.frame > 1);
  });
  const Glb glb = read_glb(write("still.glb", {"biceps"}));
  EXPECT_EQ(glb.doc["meshes"][0]["extras"]["targetNames"], (json{"frame 1", "frame 2", "frame 3"}));
  for (std::size_t key = 0; key < 5; ++key) {
    const Shape shape = GlbPlayer(glb, key).shape(0, 0);
    for (std::size_t v = 0; v < 4; ++v) {
      EXPECT_LT((shape.positions[v] - positions("biceps", static_cast<int>(key))[v]).norm(), 1e-7);
    }
  }
}

}  // namespace
}  // namespace thew::tests
