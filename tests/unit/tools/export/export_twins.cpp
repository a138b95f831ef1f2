// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/unit/tools/export/onto.h"

namespace thew::tests {
namespace {

constexpr std::size_t kArmature = 10;  // node of the file

// The arms of the figure on a skeleton of their own: a copy, as clothes have it, which the file's
// animation does not move.
class TwinsOnto : public OntoTest {
 protected:
  TwinsOnto() {
    json& doc = was_.doc;
    const int more = static_cast<int>(doc["nodes"].size()), first = doc["skins"][0]["joints"][0];
    std::map<int, int> copy_of;
    for (const int joint : doc["skins"][0]["joints"]) {
      copy_of.emplace(joint, more + static_cast<int>(copy_of.size()));
    }
    for (const auto& [joint, copy] : copy_of) {
      json node = doc["nodes"][joint];
      if (node.contains("children")) {
        json children = json::array();
        for (const int child : node["children"]) {
          if (copy_of.contains(child)) children.push_back(copy_of.at(child));
        }
        node["children"] = children;
      }
      doc["nodes"].push_back(node);
    }
    json skin = doc["skins"][0];
    for (json& joint : skin["joints"]) joint = copy_of.at(joint.get<int>());
    skin.erase("skeleton");
    doc["skins"].push_back(skin);
    doc["nodes"][kArms]["skin"] = 1;
    doc["nodes"][kArmature]["children"].push_back(copy_of.at(first));
    put_bytes(character_, doc.dump());
    plain_ = import_character(character_, kScale);
  }
};

TEST_F(TwinsOnto, ClothesWithTheirOwnSkeletonComeBackWhereTheyWereBaked) {
  ASSERT_FALSE(plain_.twins.empty());
  bake_character(arm_);
  for (const bool correctives : {false, true}) {
    const Glb glb = put_onto({"", correctives});
    ASSERT_EQ(glb.doc["nodes"].size(), was_.doc["nodes"].size());
    if (correctives) EXPECT_EQ(glb.doc["skins"].size(), 2u);
    EXPECT_LE(deviation(glb).first, correctives ? 1e-3 : 3e-4);  // mm
  }
}

}  // namespace
}  // namespace thew::tests
