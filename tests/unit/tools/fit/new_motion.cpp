// SPDX-License-Identifier: Apache-2.0
//
// What thew new makes of a character, moved.
#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "rig/import/mesh_import.h"
#include "sim/bake/measure.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/contacts.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tests/property/every.h"
#include "tests/unit/tools/fit/new.h"
#include "tools/base/html_page.h"

namespace thew::tests {
namespace {

// The point of the figure's left arm's line, shoulder to wrist, that is nearest.
Vec3 on_arm(const Vec3& p) {
  const Vec3 joints[] = {{0.17, 1.38, -0.02}, {0.37, 1.21, -0.035}, {0.53, 1.075, 0.02}};
  Vec3 nearest = joints[0];
  for (int k = 0; k < 2; ++k) {
    const Vec3 d = joints[k + 1] - joints[k];
    const Vec3 q = joints[k] + std::clamp(d.dot(p - joints[k]) / d.squaredNorm(), 0.0, 1.0) * d;
    if ((q - p).norm() < (nearest - p).norm()) nearest = q;
  }
  return nearest;
}

// The figure with arms of `share` of their thickness, beyond the shoulders.
void write_slender_figure(double share, const fs::path& out) {
  std::ifstream in(kFigure);
  nlohmann::json json = nlohmann::json::parse(in);
  const std::string uri = json["buffers"][0]["uri"];
  const std::string head = uri.substr(0, uri.find(',') + 1);
  std::string bytes = from_base64(uri.substr(head.size()));
  const int count = json["accessors"][0]["count"];  // its positions, first in the buffer
  for (int i = 0; i < count; ++i) {
    float x[3];
    std::memcpy(x, &bytes[i * sizeof x], sizeof x);
    const double side = x[0] < 0.0f ? -1.0 : 1.0;
    const Vec3 p(side * x[0], x[1], x[2]), middle = on_arm(p);
    const double beyond = smoothstep(0.17, 0.2, p.x());
    const Vec3 thin = p + beyond * (1.0 - share) * (middle - p);
    for (int k = 0; k < 3; ++k) x[k] = static_cast<float>(k == 0 ? side * thin[k] : thin[k]);
    std::memcpy(&bytes[i * sizeof x], x, sizeof x);
  }
  json["buffers"][0]["uri"] = head + base64(bytes);
  std::ofstream(out) << json;
}

// A slender arm's skin goes with the muscles below it and not with those across it: what it felt
// there drew the robot's plates 74 mm off, and left its muscles outside. Up to a right angle:
// beyond it the weights alone put the crook of the elbow into the bones, which it has to leave.
TEST_F(NewScene, TheSkinOfASlenderArmStaysNearItsWeights) {
  const fs::path file = folder / "slender.gltf";
  write_slender_figure(0.35, file);
  constexpr int kRightAngle = 26;  // the last frame before it
  MadeArm arm(asked(file, "right"));
  Measuring measuring = start_measuring(arm.model, initial_state(arm.model));
  double out = 0.0, off = 0.0;
  Points carried;
  for (int frame = 1; frame <= 35; ++frame) {
    arm.step(frame);
    out =
        std::max(out, measure(arm.model, measuring, arm.parallel, arm.state).skin.max_poke_through);
    if (frame > kRightAngle) continue;
    skin_vertices(arm.model.skinned->weights, arm.model.skinned->mesh, arm.state.bodies, carried);
    off = std::max(off, largest_distance(arm.state.skin.x, carried));
  }
  std::printf("%.1f mm outside, skin up to %.1f mm from its weights\n", 1e3 * out, 1e3 * off);
  EXPECT_LT(off, 0.03);
  EXPECT_LT(out, 3.5e-3);
}

// An upper arm a quarter as thick as a person's on a forearm twice as long: in the fold the tendons
// ran straight from one to the other, 22 mm outside of the skin. Muscles that fill the arm's
// outermost surface stand out by 8 mm; by 4 did those of an arm a tenth as thick, mere threads.
TEST_F(NewScene, TheRobotsMusclesStayAtItsElbow) {
  if (!fs::exists(data("robot.glb"))) GTEST_SKIP() << "robot.glb is not there";
  MadeArm arm(asked(data("robot.glb"), "left", 0.4));
  Measuring measuring = start_measuring(arm.model, initial_state(arm.model));
  double most = 0.0;
  for (int frame = 1; frame <= 35; ++frame) {
    arm.step(frame);
    most = std::max(most,
                    measure(arm.model, measuring, arm.parallel, arm.state).skin.max_poke_through);
  }
  std::printf("%.1f mm outside\n", 1e3 * most);
  EXPECT_LT(most, 12e-3);
}

// m, by section of a tube, from node to node across it, in the mean.
std::vector<double> sections(const TriMesh& tube) {
  const auto at_pole = [](const Triangle& t) { return t[0] == 0 || t[1] == 0 || t[2] == 0; };
  const size_t n = std::count_if(tube.triangles.begin(), tube.triangles.end(), at_pole);
  std::vector<double> across;
  for (size_t first = 1; first + n < tube.vertices.size(); first += n) {
    double sum = 0.0;
    for (size_t k = 0; k < n; ++k) {
      sum += (tube.vertices[first + k] - tube.vertices[first + (k + n / 2) % n]).norm();
    }
    across.push_back(sum / n);
  }
  return across;
}

// In Robot_Jump the end of a biceps, 0.8 mm thick, was drawn out on the far side of the brachialis:
// contact looked for a way out up to 1.6 mm deep, the template's 6 by the upper arm's mean girth.
TEST_F(NewScene, ContactLooksAsDeepAsTheThinnestSectionAllows) {
  const NewOptions options = asked(kFigure, "right");
  ASSERT_EQ(new_command(options), ExitCode::kDone);
  const Model model = build_model(read_scene(options.out));
  const fs::path from = fs::path(THEW_SOURCE_DIR) / "assets/arm";
  const double share =
      model.contact.settings.max_depth / read_scene(from / "arm.toml").contact.settings.max_depth;
  double least = 1.0;
  for (const Muscle& muscle : model.muscles) {
    const std::string name = muscle.name.substr(0, muscle.name.rfind('_'));
    const std::vector<double> now = sections(muscle.rest),
                              before =
                                  sections(import_closed_mesh(from / "muscles" / (name + ".obj")));
    for (size_t i = 0; i < now.size(); ++i) least = std::min(least, now[i] / before[i]);
  }
  std::printf("%.3f of the template's depth, thinnest section %.3f\n", share, least);
  EXPECT_NEAR(share, least, 0.1 * least);
}

// m, by which a node's step differs from its last, at most, where the elbows bend from 90 to 120
// degrees by a third of a degree a step.
double largest_change_of_step(const NewOptions& options) {
  MadeArm arm(options, {"rig.clip={ unit = \"deg\", keys = { elbow_right = [[1, 90], [91, 120]], "
                        "elbow_left = [[1, 90], [91, 120]] } }",
                        "skin.enabled=false"});
  const size_t count = arm.model.muscles.size();
  std::vector<Points> before(count), step(count);
  double most = 0.0;
  for (int frame = 1; frame <= 90; ++frame) {
    arm.step(frame);
    for (size_t m = 0; m < count; ++m) {
      Points now = arm.state.muscles[m].x;
      for (size_t i = 0; frame > 1 && i < now.size(); ++i) now[i] -= before[m][i];
      if (frame > 2) most = std::max(most, largest_distance(now, step[m]));
      before[m] = arm.state.muscles[m].x;
      step[m].swap(now);
    }
  }
  std::printf("%.2f mm\n", 1e3 * most);
  return most;
}

// The figure's forearm was bent forward below the elbow, into the end of its brachialis; what
// contact made of that changed by 12 mm from step to step. The man's triceps was carried through
// the back of his humerus: 6 mm.
TEST_F(NewScene, MusclesBendTheElbowInSmallSteps) {
  for (const auto& [file, scale] : characters()) {
    EXPECT_LT(largest_change_of_step(asked(file, "both", scale)), 2e-3) << file;
  }
}

// Its own animations hold its forearms rolled by 89 and 69 degrees against the bind pose, and its
// upper arms are a quarter of a person's: muscles made in the bind pose with a person's contact
// distances were wrung through the bones and drawn out until the solver gave up.
TEST_F(NewScene, TheRobotsOwnAnimationsBake) {
  if (!fs::exists(data("robot.glb"))) GTEST_SKIP() << "robot.glb is not there";
  const NewOptions options = asked(data("robot.glb"), "both", 0.4);
  testing::internal::CaptureStderr();
  ASSERT_EQ(new_command(options), ExitCode::kDone);
  const std::string warned = testing::internal::GetCapturedStderr();
  EXPECT_HAS(warned, "animation \"Robot_Wave\" rolls the right forearm");
  EXPECT_EQ(warned.find("Robot_Walking"), std::string::npos);
  // The wave rolls a forearm by 104 degrees: with the ulna rolled it ended in frame 16. In the
  // jump a biceps was caught on the far side of the brachialis, in frame 15.
  std::vector<std::pair<const char*, int>> animations = {
      {"Robot_Idle", 5}, {"Robot_Wave", 18}, {"Robot_Jump", 17}};
  if (every(2) == 1) {
    animations = {{"Robot_Idle", 10},
                  {"Robot_Walking", 10},
                  {"Robot_Sitting", 10},
                  {"Robot_Wave", 20},
                  {"Robot_Jump", 18}};
  }
  for (const auto& [name, frames] : animations) {
    const Model model = build_model(read_scene(
        options.out,
        {"rig.clip={ animation = \"" + std::string(name) + "\" }", "skin.enabled=false"}));
    Parallel parallel(1);
    State state = initial_state(model);
    StageSeconds seconds;
    settle(model, parallel, state);
    for (int frame = 1; frame <= frames; ++frame) {
      step_frame(model, frame / 24.0, parallel, state, seconds);
      for (const MuscleState& muscle : state.muscles) EXPECT_LE(muscle.volume_error, 1e-12) << name;
    }
  }
}

// Of a body that lies in the bind pose as the world does, whose limb points along `from` there:
// turned to each of the directions in turn, in 2/3 s.
BodyClip swing(int body, const Vec3& from, const std::vector<Vec3>& directions) {
  BodyClip clip;
  BodyTrack& track = clip.tracks.emplace_back();
  track.body = body;
  track.rotation.times = {0.0};
  track.rotation.values = {Eigen::Quaterniond::Identity()};
  for (const Vec3& to : directions) {
    clip.duration += 2.0 / 3.0;
    track.rotation.times.push_back(clip.duration);
    track.rotation.values.push_back(
        Eigen::Quaterniond(least_turn(from.normalized(), to.normalized())));
  }
  return clip;
}

// Down from the bind pose, forward and back.
BodyClip walk_of(const Model& model) {
  return swing(find_body(model.skeleton, "RightArm"), {-0.2, -0.17, -0.015},
               {{-0.1, -0.85, 0.5}, {-0.1, -0.85, -0.5}, {-0.1, -0.85, 0.5}});
}

// The bind pose has the arms out to the sides, a walk has them down: the coracobrachialis, held to
// the shoulder blade beside the upper arm, was carried through humerus and triceps; 6 mm remained.
TEST_F(NewScene, TheArmSwingsAtTheSideAsInAWalk) {
  MadeArm arm(asked(kFigure, "right"), {"skin.enabled=false"});
  Model& model = arm.model;
  Measuring measuring = start_measuring(model, arm.state);
  model.character->clip = walk_of(model);
  double deepest = 0.0;
  for (int frame = 1; frame <= 48; ++frame) {
    arm.step(frame);
    const FrameMeasures now = measure(model, measuring, arm.parallel, arm.state);
    deepest = std::max(deepest, now.contact_penetration);
    for (const MuscleState& muscle : arm.state.muscles) EXPECT_LE(muscle.volume_error, 1e-12);
  }
  std::printf("%.2f mm deep\n", 1e3 * deepest);
  EXPECT_LT(deepest, 1e-3);
}

// m, that flesh stands out of the skin in the walk's first frames.
double most_outside(MadeArm& arm, int frames) {
  Measuring measuring = start_measuring(arm.model, initial_state(arm.model));
  double out = 0.0;
  for (int frame = 1; frame <= frames; ++frame) {
    arm.step(frame);
    const FrameMeasures now = measure(arm.model, measuring, arm.parallel, arm.state);
    out = std::max(out, now.skin.max_poke_through);
    for (const MuscleState& muscle : arm.state.muscles) EXPECT_LE(muscle.volume_error, 1e-12);
  }
  std::printf("%.1f mm outside\n", 1e3 * out);
  return out;
}

// So it was with the man's, whose own walk ended in frame 41.
TEST_F(NewScene, MusclesStayUnderTheSkinOfAWalk) {
  MadeArm figure(asked(kFigure, "right"));
  figure.model.character->clip = walk_of(figure.model);
  EXPECT_LT(most_outside(figure, every(2) == 1 ? 48 : 32), 2e-3);
  if (!fs::exists(data("cesium_man.gltf"))) {
    std::printf("cesium_man.gltf is not there: its walk was not tried\n");
    return;
  }
  MadeArm man(asked(data("cesium_man.gltf"), "both"), {"rig.clip={ animation = \"animation_1\" }"});
  EXPECT_LT(most_outside(man, every(2) == 1 ? 48 : 42), 2e-3);
}

// m, how deep skin inside other skin lies in muscle, by winding numbers and distances of points on
// all triangles.
double deepest_covered(const MadeArm& arm) {
  const SkinnedSkin& skin = *arm.model.skinned;
  const Points& x = arm.state.skin.x;
  TriMesh all{{}, skin.surface.triangles};
  for (const Point& p : x) all.vertices.push_back(to_vec(p));
  double most = 0.0;
  for (size_t m = 0; m < arm.state.muscles.size(); ++m) {
    TriMesh muscle{{}, arm.model.muscles[m].rest.triangles};
    for (const Point& p : arm.state.muscles[m].x) muscle.vertices.push_back(to_vec(p));
    for (size_t i = 0; i < skin.rest.size(); ++i) {
      const Vec3 p = all.vertices[i];
      if (skin.map_back[i] != static_cast<int>(i) || !(winding(muscle, p) > 0.5)) continue;
      const Vec3 normal = node_normal(skin.surface, x, static_cast<int>(i));
      const Vec3 over = p + skin.settings.thickness * normal;
      if (winding(all, over) > 0.5) most = std::max(most, distance(muscle, p));
    }
  }
  return most;
}

// A motion that lays the arm into the trunk puts the trunk's skin into the arm, and so into its
// muscles. That is told by itself.
TEST_F(NewScene, SkinThatTheMotionPutsIntoTheArmIsTold) {
  MadeArm arm(asked(kFigure, "right"));
  arm.model.character->clip =
      swing(find_body(arm.model.skeleton, "RightArm"), {-0.2, -0.17, -0.015}, {{0.5, -0.85, 0.1}});
  Measuring measuring = start_measuring(arm.model, initial_state(arm.model));
  double in = 0.0, covered = 0.0;
  for (int frame = 1; frame <= 16; ++frame) {
    arm.step(frame);
    const SkinMetrics now = measure(arm.model, measuring, arm.parallel, arm.state).skin;
    if (now.max_covered_penetration > covered) {
      EXPECT_NEAR(now.max_covered_penetration, deepest_covered(arm), 5e-4) << frame;
    }
    covered = std::max(covered, now.max_covered_penetration);
    in = std::max(in, now.max_penetration);
  }
  std::printf("%.2f mm in muscle, covered %.2f\n", 1e3 * in, 1e3 * covered);
  EXPECT_GT(covered, 3e-3);
  EXPECT_LT(in, 2e-3);
}

// The same figure with its elbow bent by 140 degrees, where its weights draw the skin in.
TEST_F(NewScene, MusclesStayUnderTheSkinOfABentElbow) {
  MadeArm arm(asked(kFigure, "right"),
              {"rig.clip={ unit = \"deg\", keys = { elbow_right = [[1, 12.6], [36, 140]] } }"});
  const Model& model = arm.model;
  State& state = arm.state;
  for (int frame = 1; frame < 36; ++frame) {
    arm.step(frame);
  }
  Measuring measuring = start_measuring(model, initial_state(model));
  const auto farthest = [&] {
    TriMesh skin = model.character->character.mesh;
    for (size_t i = 0; i < skin.vertices.size(); ++i) skin.vertices[i] = to_vec(state.skin.x[i]);
    double most = 0.0;
    for (const MuscleState& muscle : state.muscles) {
      for (const Point& x : muscle.x) {
        if (winding(skin, to_vec(x)) < 0.5) most = std::max(most, distance(skin, to_vec(x)));
      }
    }
    return most;
  };
  const auto measured = [&] {
    return measure(model, measuring, arm.parallel, state).skin.max_poke_through;
  };
  double far = farthest();
  std::printf("%.2f mm outside\n", 1e3 * far);
  EXPECT_LT(far, 2e-3);
  EXPECT_NEAR(measured(), far, 1e-3);
  // As the weights alone have it.
  skin_vertices(model.skinned->weights, model.skinned->mesh, state.bodies, state.skin.x);
  far = farthest();
  std::printf("%.2f mm outside by its weights alone, %.2f measured\n", 1e3 * far, 1e3 * measured());
  EXPECT_GT(far, 4 * 2e-3);
  EXPECT_NEAR(measured(), far, 1e-3);
}

// The displacement on top of the character's own weights goes with pose and muscles, and does not
// leap: between two frames, of which the muscles are interpolated, it goes in steps as small as
// theirs, also in the fold beyond 90 degrees.
TEST_F(NewScene, SkinMovesContinuouslyIntoTheFold) {
  MadeArm arm(asked(kFigure, "right"));
  auto& [model, parallel, state, seconds] = arm;
  for (int frame = 1; frame <= 26; ++frame) arm.step(frame);
  constexpr int kFine = 64;
  Points carried, before, before_fine;
  double coarse = 0.0, fine = 0.0;  // m, most in 1/8 and in 1/64 of a frame
  for (int frame = 27; frame <= 35; ++frame) {
    State between = state;
    arm.step(frame);
    const std::vector<MuscleState> from = between.muscles;
    for (int k = 1; k <= kFine; ++k) {
      const double share = 1.0 * k / kFine;
      drive_bones(model, (frame - 1 + share) / 24.0, between);
      for (size_t m = 0; m < from.size(); ++m) {
        Points& x = between.muscles[m].x;
        for (size_t i = 0; i < x.size(); ++i) {
          x[i] = (1.0 - share) * from[m].x[i] + share * state.muscles[m].x[i];
        }
      }
      std::vector<Collider> felt;
      set_felt(model, between, felt);
      step_skinned(*model.skinned, between.bodies, felt, {}, between.layer, between.skin);
      skin_vertices(model.skinned->weights, model.skinned->mesh, between.bodies, carried);
      Points now = between.skin.x;
      for (size_t i = 0; i < now.size(); ++i) now[i] -= carried[i];
      if (!before_fine.empty()) fine = std::max(fine, largest_distance(now, before_fine));
      if (k % 8 == 0) {
        if (!before.empty()) coarse = std::max(coarse, largest_distance(now, before));
        before = now;
      }
      before_fine.swap(now);
    }
  }
  std::printf("%.3f mm in 1/8 of a frame, %.3f mm in 1/64\n", 1e3 * coarse, 1e3 * fine);
  // The layer has a memory: each of its steps also brings it nearer to its balance, however small
  // the step of the muscles is.
  EXPECT_LT(fine, 0.004);
  EXPECT_LT(coarse, 0.0025);
}

}  // namespace
}  // namespace thew::tests
