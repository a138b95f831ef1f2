// SPDX-License-Identifier: Apache-2.0
//
// Pose sets: which poses are sampled, and what is written of each.
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>

#include "rig/text.h"
#include "sim/bake/bake.h"
#include "sim/lone_frame.h"
#include "tests/property/every.h"
#include "tests/unit/tools/fit/new.h"
#include "tools/poses/pose_set.h"
#include "tools/poses/ranges.h"

namespace thew::tests {
namespace {

class Poses : public NewScene {
 protected:
  PoseRanges ranges(const std::string& text) {
    std::ofstream(folder / "ranges.toml") << "scene = \"character.toml\"\n" << text;
    return read_ranges(folder / "ranges.toml");
  }
  void refused(const std::string& text, const std::string& word) {
    try {
      const PoseRanges read = ranges(text);
      Scene scene = read_scene(read.scene);
      const rig::Skeleton skeleton = build_model(scene).skeleton;
      set_poses(sample_poses(read, skeleton, scene), skeleton, scene);
      build_model(scene);
      ADD_FAILURE() << "taken: " << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
};

TEST_F(Poses, AreSampledByGridByChanceAndFromTheClip) {
  ASSERT_EQ(new_command(asked(kFigure, "right")), ExitCode::kDone);
  const PoseRanges wanted = ranges(
      "random = 50\nseed = 3\nframes = \"1,36\"\ngrid = { elbow_right = 3, shoulder_right = 2 }\n"
      "[joints]\nshoulder_right = [0, 90]\nelbow_right = [20, 120]\n");
  const Scene scene = read_scene(wanted.scene);
  const rig::Skeleton skeleton = build_model(scene).skeleton;
  const auto poses = sample_poses(wanted, skeleton, scene);
  ASSERT_EQ(poses.size(), 6u + 50u + 2u);
  std::map<std::string, size_t> at;
  for (const int body : moving_joints(skeleton)) at.emplace(skeleton.joint_names[body], at.size());
  const size_t elbow = at.at("elbow_right"), shoulder = at.at("shoulder_right");
  for (int k = 0; k < 6; ++k) {  // the last joint is the fastest
    EXPECT_NEAR(poses[k][shoulder], (k / 3) * 90.0 * kDegree, 1e-12);
    EXPECT_NEAR(poses[k][elbow], (20.0 + 50.0 * (k % 3)) * kDegree, 1e-12);
  }
  double least = 10.0, most = -10.0;
  for (int k = 6; k < 56; ++k) {
    least = std::min(least, poses[k][elbow]);
    most = std::max(most, poses[k][elbow]);
  }
  EXPECT_GE(least, 20.0 * kDegree);
  EXPECT_LE(most, 120.0 * kDegree);
  EXPECT_GT(most - least, 90.0 * kDegree);
  EXPECT_NEAR(poses[57][elbow], 120.0 * kDegree, 1e-12);
  EXPECT_EQ(sample_poses(wanted, skeleton, scene), poses);
  PoseRanges other = wanted;
  other.seed = 4;
  EXPECT_NE(sample_poses(other, skeleton, scene), poses);

  refused("", "no pose");
  refused("random = 2\n[joints]\nelbw_right = [0, 1]\n", "did you mean \"elbow_right\"");
  refused("random = 20\n[joints]\nelbow_right = [0, 170]\n", "elbow_right");  // beyond its range
  refused("random = 2\n[joints]\nelbow_right = [9, 1]\n", "no less than the first");
  refused("grid = { elbow_right = 3 }\n", "[joints]");
  refused("rnadom = 2\n", "rnadom");
  refused(
      "grid = { elbow_right = 99999, shoulder_right = 9 }\n[joints]\n"
      "elbow_right = [0, 1]\nshoulder_right = [0, 1]\n",
      "100,000");
}

// The position of vertex i in a pose of a set, as a user of the set blends it.
Vec3 blended(std::map<std::string, NamedArray>& arrays, size_t pose, size_t i, bool displaced) {
  const size_t vertices = arrays["base"].shape[0], wide = arrays["weights"].shape[1],
               links = arrays["transforms"].shape[1];
  Vec3 x = Vec3::Map(&arrays["base"].values[3 * i]), sum = Vec3::Zero();
  if (displaced) x += Vec3::Map(&arrays["displacement"].values[3 * (pose * vertices + i)]);
  for (size_t k = 0; k < wide; ++k) {
    const auto link = static_cast<size_t>(arrays["influences"].values[wide * i + k]);
    const double* m = &arrays["transforms"].values[12 * (pose * links + link)];
    for (int row = 0; row < 3; ++row) {
      sum[row] +=
          arrays["weights"].values[wide * i + k] * (Vec3::Map(m + 4 * row).dot(x) + m[4 * row + 3]);
    }
  }
  return sum;
}

// Of a set: the displaced base shape, blended, is the skin that was baked; without displacement it
// is what the step of the skin itself has by the weights alone.
TEST_F(Poses, BlendToTheBakedSkin) {
  ASSERT_EQ(new_command(asked(kFigure, "right")), ExitCode::kDone);
  const size_t count = every(2) == 1 ? 3 : 2;
  const PoseRanges wanted =
      ranges("random = " + std::to_string(count) + "\n[joints]\nelbow_right = [30, 110]\n");
  Scene scene = read_scene(wanted.scene);
  const rig::Skeleton skeleton = build_model(scene).skeleton;
  const auto poses = sample_poses(wanted, skeleton, scene);
  set_poses(poses, skeleton, scene);
  const Model model = build_model(scene);
  ASSERT_TRUE(stands_alone(model));
  std::vector<int> frames(count);
  std::iota(frames.begin(), frames.end(), 1);
  bake(model, {folder / "bake", frames, 1, false, {true, ""}},
       [](const BakeFrame&) { return true; });
  const BakeReader reader(folder / "bake/bake.h5");
  const PoseSet set = make_pose_set(model, poses, reader);
  std::map<std::string, NamedArray> arrays;
  for (const NamedArray& array : set.arrays) arrays[array.name] = array;
  const size_t vertices = arrays["base"].shape[0];
  ASSERT_EQ(arrays["displacement"].shape, (std::vector<size_t>{count, vertices, 3}));
  size_t skin = 0;
  while (reader.info().meshes[skin].kind != BakeMesh::Kind::kSkin) ++skin;
  Parallel one(1);
  StageSeconds unused;
  for (size_t pose = 0; pose < count; ++pose) {
    State state;
    solve_lone_frame(model, static_cast<double>(pose) / model.fps, one, state, unused);
    const std::vector<Vec3> baked = reader.read(static_cast<int>(pose)).positions[skin];
    double off = 0.0, off_by_weights = 0.0, moved = 0.0;
    for (size_t i = 0; i < vertices; ++i) {
      const Vec3 by_weights = to_vec(state.skin.skinned.carried[i]);
      off = std::max(off, (blended(arrays, pose, i, true) - baked[i]).norm());
      off_by_weights =
          std::max(off_by_weights, (blended(arrays, pose, i, false) - by_weights).norm());
      moved = std::max(moved, (baked[i] - by_weights).norm());
    }
    EXPECT_LT(off, 1e-9);
    EXPECT_LT(off_by_weights, 1e-9);
    EXPECT_GT(moved, 1e-3);
    EXPECT_EQ(arrays["rungs"].values[pose], 0.0);
  }
  for (const char* name : {"a.npz", "b.npz"}) write_npz(set, folder / name);
  const auto bytes = [&](const char* name) {
    std::ifstream in(folder / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(bytes("a.npz"), bytes("b.npz"));
  EXPECT_GT(bytes("a.npz").size(), 4 * arrays["displacement"].values.size());
}

// An animation of the figure turns its left forearm about y by 0, -70, -30 and -110 degrees at its
// keys, and its chest about x by 35 degrees at once at its end. Nothing is said of still bodies.
TEST_F(Poses, OfAnAnimationOfAllBodiesAreItsFrames) {
  ASSERT_EQ(new_command(asked(kFigure, "right")), ExitCode::kDone);
  const std::vector<std::string> overrides = {"rig.clip={ animation = \"wave\" }",
                                              "scene.frames=\"1-49\""};
  const auto scene_of = [&] { return read_scene(folder / "character.toml", overrides); };
  Scene scene = scene_of();
  ASSERT_TRUE(moves_all_bodies(scene));
  const std::vector<int> frames = take_frames(ranges("frames = \"1,13,31,49\"\n"), scene);
  ASSERT_EQ(frames, (std::vector<int>{1, 13, 31, 49}));
  const Model model = build_model(scene);
  ASSERT_TRUE(stands_alone(model));
  bake(model, {folder / "bake", frames, 1, false, {true, ""}},
       [](const BakeFrame&) { return true; });
  const BakeReader reader(folder / "bake/bake.h5");
  const PoseSet set = make_pose_set(model, {}, reader);
  std::map<std::string, NamedArray> arrays;
  for (const NamedArray& array : set.arrays) arrays[array.name] = array;
  std::map<std::string, size_t> column;
  std::istringstream names(set.texts.back().second);
  for (std::string name; std::getline(names, name);) column.emplace(name, column.size());
  EXPECT_FALSE(column.contains("Head.x"));
  ASSERT_EQ(arrays["joints"].shape, (std::vector<size_t>{4, column.size()}));
  const auto degrees = [&](size_t pose, const char* name) {
    return arrays["joints"].values[pose * column.size() + column.at(name)] / kDegree;
  };
  const double forearm[] = {0, -70, -30, -110}, chest[] = {0, 0, 0, 35};
  for (size_t pose = 0; pose < 4; ++pose) {
    EXPECT_NEAR(degrees(pose, "LeftForeArm.y"), forearm[pose], 1e-4) << pose;
    EXPECT_NEAR(degrees(pose, "LeftForeArm.x"), 0.0, 1e-4) << pose;
    EXPECT_NEAR(degrees(pose, "Chest.x"), chest[pose], 1e-4) << pose;
  }
  size_t skin = 0;
  while (reader.info().meshes[skin].kind != BakeMesh::Kind::kSkin) ++skin;
  double moved = 0.0;
  for (size_t pose = 0; pose < 4; ++pose) {
    const std::vector<Vec3> baked = reader.read(static_cast<int>(pose)).positions[skin];
    for (size_t i = 0; i < baked.size(); ++i) {
      EXPECT_LT((blended(arrays, pose, i, true) - baked[i]).norm(), 1e-9);
      moved = std::max(moved, (blended(arrays, pose, i, false) - baked[i]).norm());
    }
  }
  EXPECT_GT(moved, 1e-3);

  const auto refused_frames = [&](const std::string& text) {
    try {
      Scene again = scene_of();
      take_frames(ranges(text), again);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_HAS(refused_frames("frames = \"1\"\nrandom = 3\n"), "give frames alone");
  EXPECT_HAS(refused_frames("[joints]\nelbow_right = [0, 1]\n"), "give frames alone");
  EXPECT_HAS(refused_frames(""), "give frames of the animation");
  EXPECT_HAS(refused_frames("frames = \"50\"\n"), "50");
}

}  // namespace
}  // namespace thew::tests
