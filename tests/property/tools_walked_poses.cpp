// SPDX-License-Identifier: Apache-2.0
//
// The carried shape is a continuous function of the pose of the bones: poses are taken every
// sixteenth of a frame. A shape that jumps could not be followed by any number of substeps.
#include <algorithm>
#include <cstdlib>
#include <random>

#include "rig/text.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tests/property/every.h"
#include "tests/unit/tools/fit/new.h"

namespace thew::tests {
namespace {

constexpr int kParts = 16;           // of a frame
constexpr double kOwn = 1e-3;        // m, that a target may move in a sixteenth by itself ...
constexpr double kOfTheBones = 2.0;  // ... beside so much of what its bones do

struct Walk {
  int steps = 0, jumps = 0;
  double worst = 0.0;  // m, beyond what is allowed
  std::map<std::string, int> of_muscle;
};

struct Walker {
  const Model& model;
  State state;
  std::vector<Points> before, now;
  std::vector<muscles::CarryWork> work;
  muscles::CarriedPose carried;
  bool prints = false;
  Walk walk;

  explicit Walker(const Model& of) : model(of), state(initial_state(of)) {}

  // m, the longest displacement of a surface point of the bones that move this muscle.
  double bones_of(const Muscle& muscle) const {
    double most = 0.0;
    for (size_t b = 0; b < model.bones.size(); ++b) {
      const auto& bodies = muscle.bodies;
      if (std::count(bodies.begin(), bodies.end(), model.bones[b].body) > 0) {
        most = std::max(most, state.bones[b].displacement);
      }
    }
    return most;
  }

  // Sets the targets for the present pose; `at` is only printed.
  void look(double at) {
    const size_t count = model.muscles.size();
    now.resize(count);
    work.resize(count);
    for (size_t m = 0; m < count; ++m) {
      const CarriedShape& shape = model.muscles[m].shape;
      carry_pose(shape, state.pose, work[m], carried);
      carried_positions(shape, carried, true, now[m]);
      if (shape.clear_bones) shape.clear_bones(state.pose, now[m], work[m].cleared);
      if (before.empty()) continue;
      const double moved = largest_distance(now[m], before[m]);
      const double bones = bones_of(model.muscles[m]), over = moved - kOwn - kOfTheBones * bones;
      ++walk.steps;
      walk.worst = std::max(walk.worst, over);
      if (over <= 0.0) continue;
      ++walk.jumps;
      ++walk.of_muscle[model.muscles[m].name];
      if (prints) {
        std::printf("  %.4f %s: %.2f mm, bones %.2f mm\n", at, model.muscles[m].name.c_str(),
                    1e3 * moved, 1e3 * bones);
      }
    }
    before.swap(now);
    now.clear();
  }

  // From the bind pose into the clip's first and through the clip.
  void follow_clip() {
    const int settling = static_cast<int>(model.settle * model.fps) * kParts;
    const int last = (model.last_frame - model.first_frame) * kParts;
    for (int k = -settling; k <= last; ++k) {
      const double time = k / (kParts * model.fps);
      drive_bones(model, time, state);
      look(model.first_frame + time * model.fps);
    }
  }
};

void report(const std::string& what, const Walk& walk) {
  std::printf("%s: %d jumps in %d steps of a muscle, at most %.2f mm beyond the bones'\n",
              what.c_str(), walk.jumps, walk.steps, 1e3 * std::max(walk.worst, 0.0));
  for (const auto& [name, count] : walk.of_muscle) std::printf("  %3d %s\n", count, name.c_str());
}

TEST(WalkedPoses, TheArmsClip) {
  const Model model = build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml"));
  Walker walker(model);
  walker.follow_clip();
  report("arm", walker.walk);
  EXPECT_GT(walker.walk.steps, 10000);
  EXPECT_EQ(walker.walk.jumps, 0);
}

// A key of a random motion: the arm hanging, swung up to 150 degrees forward, outward or across the
// breast and less to the back, turned about its length; the elbow; the forearm rolled. About what a
// person's arm does.
struct ArmAngles {
  double elevation, plane, axial, elbow, roll;  // rad; plane: 0 outward, 90 degrees forward
};
ArmAngles random_angles(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return kDegree * (low + (high - low) * (random() / 4294967296.0));
  };
  ArmAngles angles{};
  angles.plane = between(-60.0, 130.0);
  const double most = angles.plane < 0.0 ? 60.0 : angles.plane < 90.0 * kDegree ? 150.0 : 100.0;
  angles.elevation = between(0.0, most);
  angles.axial = between(-70.0, 80.0);
  angles.elbow = between(0.0, 140.0);
  angles.roll = between(-80.0, 80.0);
  return angles;
}

ArmAngles between(const ArmAngles& a, const ArmAngles& b, double t) {
  const auto mix = [&](double ArmAngles::*angle) { return (1.0 - t) * a.*angle + t * b.*angle; };
  return {mix(&ArmAngles::elevation), mix(&ArmAngles::plane), mix(&ArmAngles::axial),
          mix(&ArmAngles::elbow), mix(&ArmAngles::roll)};
}

// Of the figure's right arm, whose bodies lie in the bind pose as the world does: from one of
// `keys` random poses to the next in half a second.
BodyClip random_motion(const Model& model, const SceneHinge& elbow, unsigned seed, int keys) {
  constexpr int kPieces = 24;  // from key to key, so that angles and not turns are interpolated
  std::mt19937 random(seed);
  BodyClip clip;
  clip.tracks.resize(2);
  BodyTrack &upper = clip.tracks[0], &fore = clip.tracks[1];
  upper.body = find_body(model.skeleton, "RightArm");
  fore.body = find_body(model.skeleton, elbow.body);
  const Vec3 bound = model.skeleton.joint_in_parent[fore.body].translation().normalized();
  const Mat3 hanging = least_turn(bound, -Vec3::UnitY());
  const Vec3 along = elbow.forearm->wrist.normalized();
  ArmAngles from = random_angles(random), to = from;
  for (int k = 0; k <= (keys - 1) * kPieces; ++k) {
    if (k % kPieces == 0) from = to, to = random_angles(random);
    const ArmAngles now = between(from, to, smoothstep(0.0, kPieces, k % kPieces));
    clip.duration = 0.5 * k / kPieces;
    // Seen from above the right arm's outward is -x, forward +z.
    const auto [s, c] = sin_cos(now.plane);
    const Vec3 axis = Vec3(-c, 0.0, s).cross(Vec3::UnitY());
    upper.rotation.times.push_back(clip.duration);
    upper.rotation.values.emplace_back(Mat3(rotation_about(axis, now.elevation) *
                                            rotation_about(Vec3::UnitY(), now.axial) * hanging));
    fore.rotation.times.push_back(clip.duration);
    fore.rotation.values.emplace_back(Mat3(rotation_about(elbow.axis, now.elbow - elbow.at_bind) *
                                           rotation_about(along, now.roll)));
  }
  return clip;
}

TEST_F(NewScene, TargetsOfRandomMotionsDoNotLeap) {
  ASSERT_EQ(new_command(asked(kFigure, "right")), ExitCode::kDone);
  const Scene scene = read_scene(folder / "character.toml", {"skin.enabled=false"});
  Model model = build_model(scene);
  constexpr int kMotions = 40, kKeys = 5;
  Walk all;
  for (unsigned seed = 1; seed <= kMotions; seed += every(4)) {
    model.character->clip = random_motion(model, scene.character.hinges.at(0), seed, kKeys);
    model.last_frame = model.first_frame + (kKeys - 1) * 12;
    Walker walker(model);
    walker.prints = std::getenv("THEW_WALK") != nullptr;
    walker.follow_clip();
    if (walker.prints) report("seed " + std::to_string(seed), walker.walk);
    all.steps += walker.walk.steps;
    all.jumps += walker.walk.jumps;
    all.worst = std::max(all.worst, walker.walk.worst);
    for (const auto& [name, count] : walker.walk.of_muscle) all.of_muscle[name] += count;
  }
  report("random motions", all);
  EXPECT_EQ(all.jumps, 0);
}

// The same for any scene and its clip: THEW_WALK=SCENE.toml, with overrides in THEW_WALK_SET, one
// KEY=VALUE a line.
TEST(WalkedPoses, OfTheSceneThatIsAskedFor) {
  const char* file = std::getenv("THEW_WALK");
  if (!file) GTEST_SKIP() << "THEW_WALK names no scene";
  std::vector<std::string> settings = {"skin.enabled=false"};
  std::istringstream lines(std::getenv("THEW_WALK_SET") ? std::getenv("THEW_WALK_SET") : "");
  for (std::string line; std::getline(lines, line);) settings.push_back(line);
  const Model model = build_model(read_scene(file, settings));
  Walker walker(model);
  walker.prints = true;
  walker.follow_clip();
  report(file, walker.walk);
  EXPECT_EQ(walker.walk.jumps, 0);
}

}  // namespace
}  // namespace thew::tests
