// SPDX-License-Identifier: Apache-2.0
//
// Points of a path that take a share of how their body turns against another.
#include <gtest/gtest.h>

#include "rig/math.h"
#include "sim/scene/define_model.h"
#include "sim/scene/model.h"
#include "sim/scene/reader.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

// The point between origin and insertion, on line 8.
std::string with_point(const std::string& point) {
  return "[scene]\nframes = \"1-10\"\n[rig]\nfile = \"rig.urdf\"\n[[muscle]]\n"
         "name = \"tube\"\npath = [[\"blade\", 0, 0, 0],\n  " +
         point +
         ",\n  [\"arm\", 0, -0.2, 0]]\nprofile = { radius = [[0, 0.01]] }\n"
         "[rig.clip]\nkeys = { shoulder = [[1, 0], [10, 1]] }\n";
}

constexpr const char* kRig =
    "<robot name=\"r\"><link name=\"blade\"/><link name=\"arm\"/>"
    "<joint name=\"shoulder\" type=\"revolute\"><parent link=\"blade\"/><child link=\"arm\"/>"
    "<origin xyz=\"0 0.1 0\"/><axis xyz=\"1 0 0\"/>"
    "<limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint></robot>";

constexpr const char* kShared = "{ body = \"arm\", at = [0, -0.05, 0], with = \"blade\", share = ";

class SharedPoint : public TempFolder {
 protected:
  std::filesystem::path scene(const std::string& point) {
    write("rig.urdf", kRig);
    return write("scene.toml", with_point(point));
  }
};

TEST_F(SharedPoint, WrongOnesAreRefusedWithTheirPlace) {
  const std::pair<const char*, const char*> cases[] = {
      {"{ body = \"arm\", at = [0, 0, 0] }", ":8: [muscle.tube.path.1] lacks the key \"with\""},
      {"{ body = \"arm\", with = \"blade\", share = 0.5 }",
       ":8: [muscle.tube.path.1] lacks the key \"at\""},
      {"{ body = \"arm\", at = [0, 0, 0], with = \"blade\", share = 1.5 }",
       ":8: muscle.tube.path.1.share is 1.5; give a number from 0 to 1"},
      {"{ body = \"arm\", at = [0, 0], with = \"blade\", share = 0.5 }",
       ":8: muscle.tube.path.1.at is an array of 2; give"},
      {"{ body = \"arm\", at = [0, 0, 0], with = \"arm\", share = 0.5 }",
       ":8: muscle.tube.path.1.with is \"arm\"; name another body"},
      {"{ body = \"arm\", at = [0, 0, 0], with = \"blade\", share = 0.5, shar = 1 }",
       ":8: unknown key \"shar\" in [muscle.tube.path.1]"}};
  for (const auto& [point, message] : cases) {
    EXPECT_STARTS(usage_error(scene(point)), message) << point;
  }
  std::string text = with_point(kShared + std::string("0.5 }"));
  text.replace(text.find(",\n  [\"arm\""), std::string(",\n  [\"arm\", 0, -0.2, 0]").size(), "");
  EXPECT_STARTS(usage_error(write("end.toml", text)),
                ":8: muscle.tube.path.1.with is \"blade\"; give it to a point between origin and");
  try {
    build_model(
        read_scene(scene("{ body = \"arm\", at = [0, 0, 0], with = \"blad\", share = 1 }")));
    ADD_FAILURE() << "a body that is not there";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(":8: body \"blad\" is not in the rig"),
              std::string::npos)
        << error.what();
  }
}

// The model has it turn by its share, and its hash tells one share from another and from none.
TEST_F(SharedPoint, OfAModelTurnsByItsShareAndIsInItsHash) {
  const Model model = build_model(read_scene(scene(kShared + std::string("0.25 }"))));
  Pose pose;
  forward_kinematics(model.skeleton, {0.0, 1.0}, pose);
  const PathPoint& point = model.muscles[0].shape.path.points[1];
  const Vec3 there = Vec3(0, 0.1, 0) + rotation_about(Vec3::UnitX(), 0.25) * Vec3(0, -0.05, 0);
  EXPECT_LT((frame_of_point(point, pose) * point.position - there).norm(), 1e-15);
  EXPECT_EQ(model.muscles[0].bodies, (std::vector<int>{0, 1}));
  const std::string other = build_model(read_scene(scene(kShared + std::string("0.5 }")))).hash;
  const std::string none = build_model(read_scene(scene("[\"arm\", 0, -0.05, 0]"))).hash;
  EXPECT_NE(model.hash, other);
  EXPECT_NE(model.hash, none);
}

}  // namespace
}  // namespace thew::tests
