// SPDX-License-Identifier: Apache-2.0
//
// Two exports as glTF: played as the bake is, the same where they are, and told apart where not.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/tools/export/export.h"
#include "tools/compare/compare.h"
#include "tools/compare/played_gltf.h"

namespace thew::tests {
namespace {

using nlohmann::json;

class CompareExports : public ExportTest {
 protected:
  /// A .glb of a bake whose biceps is moved by `by` (m) at its node 2 in frame 2.
  std::filesystem::path export_moved(const std::string& name, double by) {
    std::filesystem::remove_all(folder_ / "bake.parts");
    bake({1, 2, 3}, [&](BakeFrame& frame) {
      if (frame.frame == 2) frame.positions[1][2].y() += by;
    });
    return write(name, {});
  }
  // A .gltf with its numbers in it, as JSON that a test may change.
  json as_text(const std::filesystem::path& glb) const {
    const std::string bytes = bytes_of(glb);
    const std::size_t length = ByteReader{bytes, 12}.take<std::uint32_t>();
    json doc = json::parse(bytes.substr(20, length));
    put_bytes(folder_ / "numbers.bin", bytes.substr(28 + length));
    doc["buffers"][0]["uri"] = "numbers.bin";
    return doc;
  }
  Comparison compared(const std::filesystem::path& a, const std::filesystem::path& b) const {
    return compare(a, b, {});
  }
};

TEST_F(CompareExports, PlaysWhatWasBaked) {
  const PlayedGltf played = play_gltf(export_moved("all.glb", 0.01));
  ASSERT_EQ(played.meshes.size(), 3u);
  ASSERT_EQ(played.times.size(), 3u);
  EXPECT_EQ(played.fps, 24.0);
  for (std::size_t m = 0; m < 3; ++m) {
    EXPECT_EQ(played.meshes[m].name, reader_->info().meshes[m].name);
    for (int i = 0; i < 3; ++i) {
      const std::vector<Vec3> baked = positions(played.meshes[m].name, i);
      const std::vector<Vec3>& read = played.meshes[m].frames[static_cast<std::size_t>(i)];
      ASSERT_EQ(read.size(), baked.size());
      for (std::size_t v = 0; v < baked.size(); ++v) EXPECT_LT((read[v] - baked[v]).norm(), 2e-7);
    }
  }
}

TEST_F(CompareExports, SaysWhichMeshMovedAndWhere) {
  const auto one = export_moved("one.glb", 0.0), same = export_moved("same.glb", 0.0),
             other = export_moved("other.glb", 0.002);
  const Comparison equal = compared(one, same);
  EXPECT_TRUE(equal.same());
  EXPECT_NE(comparison_as_text(equal).find("the same to the bit, 3 frames"), std::string::npos);
  const Comparison moved = compared(one, other);
  EXPECT_FALSE(moved.same());
  ASSERT_TRUE(moved.geometry);
  EXPECT_TRUE(moved.geometry->faults.empty());
  const MeshDistance& worst = moved.geometry->meshes.front();
  EXPECT_EQ(worst.name, "biceps");
  EXPECT_NEAR(worst.largest, 0.002, 1e-6);
  EXPECT_EQ(worst.frame, 2);
  EXPECT_EQ(worst.node, 2);
  EXPECT_NEAR(moved.geometry->meshes[1].largest, 0.0, 1e-12);
  EXPECT_EQ(comparison_as_text(moved).find("scene"), std::string::npos);
}

TEST_F(CompareExports, SaysWhatElseDiffers) {
  const auto one = export_moved("one.glb", 0.0);
  const json doc = as_text(one);
  const auto faults = [&](json changed) {
    put_bytes(folder_ / "changed.gltf", changed.dump());
    std::string all;
    const Comparison comparison = compared(one, folder_ / "changed.gltf");
    for (const std::string& fault : comparison.geometry->faults) {
      all += fault + "\n";
    }
    return all;
  };
  EXPECT_EQ(faults(doc), "");
  json changed = doc;
  changed["materials"][0]["name"] = "gold";
  EXPECT_NE(faults(changed).find("has the material \"gold\""), std::string::npos);
  changed = doc;
  changed["nodes"][0]["name"] = "calf";
  EXPECT_NE(faults(changed).find("\"biceps\" is called \"calf\""), std::string::npos);
  changed = doc;
  changed.erase("animations");
  EXPECT_NE(faults(changed).find("keys at 1 times"), std::string::npos);
  changed = doc;
  changed["nodes"].erase(2);
  changed["scenes"][0]["nodes"].erase(2);
  changed.erase("animations");
  put_bytes(folder_ / "still.gltf", changed.dump());
  json still = doc;
  still.erase("animations");
  put_bytes(folder_ / "whole.gltf", still.dump());
  EXPECT_EQ(compared(folder_ / "whole.gltf", folder_ / "still.gltf").geometry->faults,
            std::vector<std::string>{"2 meshes, expected 3"});
}

TEST_F(CompareExports, RefusesWhatIsNotSound) {
  const auto one = export_moved("one.glb", 0.0);
  const json doc = as_text(one);
  const auto refused = [&](const json& changed) {
    put_bytes(folder_ / "bad.gltf", changed.dump());
    expect_error(ErrorCode::kInput, "bad.gltf", [&] { compared(one, folder_ / "bad.gltf"); });
  };
  json bad = doc;
  bad["nodes"][0]["children"] = {0};
  bad["nodes"].push_back({{"children", {1, 99}}});
  refused(bad);
  bad = doc;
  bad["animations"][0]["samplers"][0]["output"] = bad["animations"][0]["samplers"][0]["input"];
  bad["animations"][0]["channels"][0]["target"]["path"] = "rotation";
  refused(bad);
  bad = doc;
  bad["nodes"][0]["mesh"] = 77;
  refused(bad);
  expect_error(ErrorCode::kUsage, "are not of one kind",
               [&] { compared(one, folder_ / "bake.h5"); });
}

}  // namespace
}  // namespace thew::tests
