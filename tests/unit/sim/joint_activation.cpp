// SPDX-License-Identifier: Apache-2.0
//
// Activation that follows the rig: against keys by frame that say the same, and against statics.
#include <gtest/gtest.h>

#include <cmath>

#include "muscles/activation.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/sim/distance.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

const std::filesystem::path kOneMuscle =
    std::filesystem::path(THEW_SOURCE_DIR) / "tests/scenes/one_muscle/scene.toml";

// The elbow bends by 60 degrees in 23 frames, evenly, from rest.
Model with(const std::string& activation, const Settings& more = {}) {
  Settings settings = {"rig.clip.interpolation=linear", "muscle.flexor.f_max=600",
                       "muscle.flexor.shape=weights", "scene.settle=0",
                       "muscle.flexor.activation=" + activation};
  settings.insert(settings.end(), more.begin(), more.end());
  return build_model(read_scene(kOneMuscle, settings));
}

State run(const Model& model, int frames) {
  Parallel one(1);
  State state = initial_state(model);
  StageSeconds seconds;
  for (int f = 1; f <= frames; ++f) step_frame(model, f / model.fps, one, state, seconds);
  return state;
}

TEST(JointActivation, ACurveOfTheAngleIsThatOfTheFrames) {
  const Model by_angle = with("{ joint = \"elbow\", curve = [[0, 0.1], [30, 0.9], [60, 0.3]] }");
  const Model by_frame = with("[[1, 0.1], [12.5, 0.9], [24, 0.3]]");
  const State a = run(by_angle, 23), b = run(by_frame, 23);
  EXPECT_LT(worst_distance(a, b), 1e-9);
  EXPECT_GT(worst_distance(a, run(with("[[1, 0]]"), 23)), 1e-6);
  EXPECT_NE(by_angle.hash, by_frame.hash);
  EXPECT_NE(by_angle.hash,
            with("{ joint = \"elbow\", curve = [[0, 0.1], [30, 0.9], [60, 0.31]] }").hash);
}

TEST(JointActivation, SpeedIsInDegreesASecond) {
  const double speed = 60.0 * 24.0 / 23.0;
  const std::string curve = "[[0, 0], [" + number_text(2.0 * speed) + ", 0.8]]";
  const Model by_speed = with("{ joint = \"elbow\", speed = " + curve + " }");
  const State a = run(by_speed, 23), b = run(with("[[1, 0], [1.001, 0.4], [24, 0.4]]"), 23);
  EXPECT_LT(worst_distance(a, b), 1e-9);
  try {
    with("{ joint = \"elbow\", speed = " + curve + " }", {"solver.integrator=quasi_static"});
    ADD_FAILURE() << "a pose has no speed";
  } catch (const Error& error) {
    EXPECT_HAS(std::string(error.what()), "speed");
    EXPECT_HAS(std::string(error.what()), "quasi_static");
  }
}

TEST(JointActivation, SeveralAreAddedUpToOne) {
  const Model two =
      with("{ joint = \"elbow\", curve = [[0, 0.7], [60, 0.7]], speed = [[0, 0.6], [1, 0.6]] }");
  EXPECT_LT(worst_distance(run(two, 6), run(with("[[1, 1]]"), 6)), 1e-12);
  const Model preset = with("{ joint = \"elbow\", preset = \"flexor\" }");
  EXPECT_EQ(preset.muscles[0].settings.by_joint->curve, activation_preset("flexor"));
  for (const auto& [angle, a] : activation_preset("flexor")) {
    EXPECT_NEAR(a, 0.05 + 0.45 * std::sin(angle * kDegree), 1e-7);
  }
}

// A load of 2 kg at 0.25 m from the elbow, of which the muscle's path has the moment arm r: a force
// of 2 g 0.25 sin(q) / r holds it, and activation is that over f_max.
TEST(JointActivation, ALoadIsHeldByItsMomentOverTheMomentArm) {
  const std::string load = "load = { mass = 2, body = \"ulna\", at = [0, -0.25, 0] }";
  const Model model = with("{ joint = \"elbow\", " + load + " }");
  Pose pose;
  const int ulna = find_body(model.skeleton, "ulna");
  std::vector<double> joints(model.skeleton.size(), 0.0);
  const auto length_at = [&](double q) {
    joints[ulna] = q;
    forward_kinematics(model.skeleton, joints, pose);
    return (pose[ulna] * Vec3(0.03, -0.05, 0) - Vec3(0.03, -0.03, 0)).norm();
  };
  for (const double degrees : {20.0, 45.0, 58.0}) {
    const double q = degrees * kDegree, h = 1e-5;
    const double arm = (length_at(q - h) - length_at(q + h)) / (2.0 * h);
    const double expected = 2.0 * 9.81 * 0.25 * std::sin(q) / (arm * 600.0);
    ASSERT_GT(expected, 0.02);
    ASSERT_LT(expected, 1.0);
    const std::string clip = "rig.clip.keys={ elbow = [[1, " + number_text(degrees) + "], [24, " +
                             number_text(degrees) + "]] }";
    const State held = run(with("{ joint = \"elbow\", " + load + " }", {clip}), 3);
    const State keyed = run(with("[[1, " + number_text(expected) + "]]", {clip}), 3);
    const State more = run(with("[[1, " + number_text(1.05 * expected) + "]]", {clip}), 3);
    EXPECT_LT(worst_distance(held, keyed), 0.1 * worst_distance(keyed, more)) << degrees;
  }
}

// A forearm and hand of 1.6 kg (de Leva 1996: 2.2 % of 73 kg), 18 cm from the elbow, held by the
// arm's four flexors at 90 degrees: the preset's amount is chosen, and several times that.
TEST(JointActivation, APresetIsFarAboveWhatHoldsAForearm) {
  Settings settings = {"skin.enabled=false", "contact.enabled=false", "scene.settle=0",
                       "rig.clip.keys={ elbow = [[1, 90], [120, 90]] }"};
  for (const std::string name : {"biceps_long", "biceps_short", "brachialis", "brachioradialis"}) {
    settings.push_back("muscle." + name +
                       ".activation={ joint = \"elbow\", load = { mass = 1.6, body = \"ulna\", at "
                       "= [0, -0.18, 0] } }");
  }
  const State state =
      run(build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", settings)), 1);
  EXPECT_GT(state.muscles[0].activation, 0.01);
  EXPECT_LT(state.muscles[0].activation, keyed_value(activation_preset("flexor"), 90.0) / 4.0);
}

// Two muscles with different moment arms and forces pull alike, and together hold it.
TEST(JointActivation, ALoadIsShared) {
  const auto both = [](const std::string& activation) {
    Settings settings = {"scene.settle=0", "contact.enabled=false", "skin.enabled=false",
                         "rig.clip.keys={ elbow = [[1, 50], [16, 50]] }"};
    for (const std::string name : {"front", "side"}) {
      settings.push_back("muscle." + name + ".activation=" + activation);
      settings.push_back("muscle." + name + ".shape=weights");
    }
    settings.insert(settings.end(), {"muscle.side.f_max=500", "muscle.side.path.0.1=0.02"});
    return build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml", settings));
  };
  const std::string load =
      "{ joint = \"elbow\", load = { mass = 1, body = \"ulna\", at = [0, -0.25, 0] } }";
  const Model model = both(load);
  const int ulna = find_body(model.skeleton, "ulna");
  const double q = 50.0 * kDegree, h = 1e-5;
  double capacity = 0.0;
  for (const Muscle& muscle : model.muscles) {
    std::vector<double> joints(model.skeleton.size(), 0.0);
    Pose pose;
    const auto length_at = [&](double value) {
      joints[ulna] = value;
      forward_kinematics(model.skeleton, joints, pose);
      return trace_path(muscle.shape.path, pose).length;
    };
    capacity += muscle.settings.f_max * (length_at(q - h) - length_at(q + h)) / (2.0 * h);
  }
  const double expected = 9.81 * 0.25 * std::sin(q) / capacity;
  ASSERT_GT(expected, 0.02);
  ASSERT_LT(expected, 1.0);
  const auto keyed = [&](double a) { return run(both("[[1, " + number_text(a) + "]]"), 3); };
  EXPECT_LT(worst_distance(run(model, 3), keyed(expected)),
            0.1 * worst_distance(keyed(expected), keyed(1.05 * expected)));
}

TEST(JointActivation, IsAFunctionOfThePoseForPosesByThemselves) {
  const std::string curve = "{ joint = \"elbow\", curve = [[0, 0.1], [60, 0.8]] }";
  EXPECT_NO_THROW(with(curve, {"solver.integrator=quasi_static"}));
}

TEST(JointActivation, MistakesAreToldWithTheirPlace) {
  const auto message = [](const std::string& activation) -> std::string {
    try {
      with(activation);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      return error.what();
    }
    return "";
  };
  EXPECT_HAS(message("{ joint = \"elbw\", preset = \"flexor\" }"), "did you mean \"elbow\"");
  EXPECT_HAS(message("{ joint = \"elbow\" }"), "give a preset, a curve");
  EXPECT_HAS(message("{ joint = \"elbow\", preset = \"flexer\" }"), "flexor");
  EXPECT_HAS(message("{ joint = \"elbow\", load = { mass = 1, body = \"hnd\", at = [0, 0, 0] } }"),
             "hnd");
  EXPECT_HAS(message("{ joint = \"elbow\", curve = [[0, 2]] }"), "curve.0.1");
}

}  // namespace
}  // namespace thew::tests
