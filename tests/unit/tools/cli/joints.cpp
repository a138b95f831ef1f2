// SPDX-License-Identifier: Apache-2.0
//
// Joints of a character that its motion moves, and twist bones between shoulder and elbow.
#include <nlohmann/json.hpp>

#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tests/unit/tools/fit/new.h"
#include "tools/cli/bake_warnings.h"

namespace thew::tests {
namespace {

// The figure with a bone more between its right upper arm and forearm, where the upper arm is.
void write_figure_with_twist_bone(const fs::path& out) {
  std::ifstream in(kFigure);
  nlohmann::json json = nlohmann::json::parse(in);
  nlohmann::json& nodes = json["nodes"];
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].value("name", "") != "RightArm") continue;
    const nlohmann::json below = nodes[i]["children"];
    nodes[i]["children"] = {nodes.size()};
    nodes.push_back({{"name", "RightArmTwist"}, {"children", below}});
    break;
  }
  std::ofstream(out) << json;
}

BodyTrack turned(int body, const Mat3& turn) {
  BodyTrack track;
  track.body = body;
  track.rotation.times = {0.0};
  track.rotation.values.emplace_back(turn);
  return track;
}

// A pose that bends the twist bone by 40 degrees put the elbow 170 mm out of the humerus, which
// hung on the upper arm alone.
TEST_F(NewScene, TheHumerusGoesFromShoulderToElbow) {
  const fs::path file = folder / "twist.gltf";
  write_figure_with_twist_bone(file);
  ASSERT_EQ(new_command(asked(file, "right")), ExitCode::kDone);
  Model model = build_model(read_scene(folder / "character.toml", {"skin.enabled=false"}));
  const int humerus = find_body(model.skeleton, "RightArm"),
            twist = find_body(model.skeleton, "RightArmTwist"),
            ulna = find_body(model.skeleton, "RightForeArm.ulna");
  ASSERT_EQ(model.skeleton.parent[find_body(model.skeleton, "RightForeArm")], twist);
  State state = initial_state(model);
  const Vec3 rest = state.pose[humerus].inverse() * state.pose[ulna].translation();
  model.character->clip.tracks = {turned(twist, rotation_about(Vec3(0, 0, 1), 40.0 * kDegree))};
  drive_bones(model, 0.0, state);
  const Vec3 now = state.pose[humerus].inverse() * state.pose[ulna].translation();
  EXPECT_LT((now - rest).norm(), 1e-6);  // the file's numbers are of single precision
  EXPECT_TRUE(joints_out_of_place(model, {1}).empty());
}

TEST_F(NewScene, AJointOutOfPlaceIsSaid) {
  ASSERT_EQ(new_command(asked(kFigure, "right")), ExitCode::kDone);
  Model model = build_model(read_scene(folder / "character.toml", {"skin.enabled=false"}));
  const int fore = find_body(model.skeleton, "RightForeArm");
  BodyTrack track = turned(fore, Mat3::Identity());
  model.character->clip.tracks = {track};
  EXPECT_TRUE(joints_out_of_place(model, {1, 2}).empty());
  const Vec3 joint = model.skeleton.joint_in_parent[fore].translation();
  track.translation.times = {0.0, 1.0 / 24.0};
  track.translation.values = {joint, joint + Vec3(0.0, 0.02, 0.0)};
  model.character->clip.tracks = {track};
  const std::vector<std::string> lines = joints_out_of_place(model, {1, 2});
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].substr(0, lines[0].find(';')),
            "\"RightForeArm.ulna\" on \"RightArm\" is out of joint by 20.0 mm in frame 2");
}

}  // namespace
}  // namespace thew::tests
