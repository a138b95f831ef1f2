// SPDX-License-Identifier: Apache-2.0
//
// The arm's whole flexion against what is known of it: numbers of the tables are those of OpenSim's
// arm26 (Holzbaur, Murray, Delp 2005) and of published moment-arm regressions.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "muscles/volume.h"
#include "rig/math.h"
#include "sim/bake/bake.h"
#include "sim/fidelity/planner.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tests/property/folds.h"

namespace thew::tests {
namespace {

// Frames a step. Sanitizers take ten times the time, and find in larger steps what they find in
// all.
#ifdef THEW_SANITIZED
constexpr int kStride = 4;
#else
constexpr int kStride = 1;
#endif

struct Flexion {
  Model model;
  std::vector<double> elbow;  // rad, by frame
  std::vector<FrameMeasures> measures;
  std::vector<std::vector<Points>> x;  // [frame][muscle]
  std::vector<Points> skin;            // [frame]
  std::vector<Pose> poses;
};

Flexion flex(const std::vector<std::string>& overrides) {
  Flexion run;
  run.model = build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", overrides));
  Parallel parallel(2);
  State state = initial_state(run.model);
  Measuring measuring = start_measuring(run.model, state);
  const Settled settled = settle(run.model, parallel, state);
  EXPECT_TRUE(settled.converged) << settled.speed << " m/s after " << settled.seconds << " s";
  const int elbow = find_joint(run.model.skeleton, "elbow");
  StageSeconds seconds;
  for (int f = run.model.first_frame; f <= run.model.last_frame; f += kStride) {
    const double time = (f - run.model.first_frame) / run.model.fps;
    if (time > 0.0) step_frame(run.model, time, parallel, state, seconds);
    run.measures.push_back(measure(run.model, measuring, parallel, state));
    run.elbow.push_back(state.joints[elbow]);
    std::vector<Points>& frame = run.x.emplace_back();
    for (const MuscleState& muscle : state.muscles) frame.push_back(muscle.x);
    run.skin.push_back(state.skin.x);
    run.poses.push_back(state.pose);
  }
  return run;
}

const Flexion& arm() {
  static const Flexion run = flex({});
  return run;
}

int index_of(const Model& model, const std::string& name) {
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    if (model.muscles[m].name == name) return static_cast<int>(m);
  }
  ADD_FAILURE() << name << " is not in the scene";
  return 0;
}

// A measure at an elbow angle (degrees) on the way up, linear between frames.
double at_angle(const Flexion& run, double degrees, double (*pick)(const MuscleMeasures&), int m) {
  for (size_t f = 1; f < run.elbow.size(); ++f) {
    const double a = run.elbow[f - 1] / kDegree, b = run.elbow[f] / kDegree;
    if (b < a || degrees > b + 1e-9) continue;
    const double t = b > a ? (degrees - a) / (b - a) : 0.0;
    return (1.0 - t) * pick(run.measures[f - 1].muscles[m]) + t * pick(run.measures[f].muscles[m]);
  }
  ADD_FAILURE() << "the elbow never reaches " << degrees;
  return 0.0;
}
double length_of(const MuscleMeasures& m) { return m.length; }
double area_of(const MuscleMeasures& m) { return m.area_ratio; }

TEST(Arm, HasTheTrianglesOfThePaper) {
  size_t triangles = 0;
  for (const Muscle& muscle : arm().model.muscles) triangles += muscle.rest.triangles.size();
  EXPECT_EQ(arm().model.muscles.size(), 12u);
  EXPECT_EQ(triangles, 8744u);
}

TEST(Arm, VolumeIsHeldToRounding) {
  for (const FrameMeasures& frame : arm().measures) {
    for (const MuscleMeasures& muscle : frame.muscles) {
      EXPECT_LE(muscle.volume_error, 1e-12);
      EXPECT_LE(muscle.substep_volume_error, 1e-12);
    }
    EXPECT_EQ(frame.unreached, 0);
  }
}

TEST(Arm, LengthsFollowTheTable) {
  const std::map<std::string, std::vector<double>> table = {
      {"biceps_long", {421.2, 411.7, 394.0, 370.3, 344.9, 337.3}},
      {"biceps_short", {341.7, 332.2, 314.5, 290.8, 265.4, 257.8}},
      {"triceps_long", {277.6, 289.8, 301.8, 312.3, 322.7, 326.1}}};
  const double angles[] = {0, 30, 60, 90, 120, 130};
  for (const auto& [name, lengths] : table) {
    for (int k = 0; k < 6; ++k) {
      const double length = at_angle(arm(), angles[k], length_of, index_of(arm().model, name));
      EXPECT_NEAR(1e3 * length, lengths[k], 5.0) << name << " at " << angles[k];
    }
  }
}

TEST(Arm, ShorteningFollowsTheRegressions) {
  const std::map<std::string, std::vector<double>> table = {
      {"brachialis", {7.3, 14.4, 24.9, 37.3, 41.3}},
      {"triceps_lateral", {-12.2, -24.2, -34.7, -45.1, -48.5}},
      {"brachioradialis", {11, 27, 52, 84, 96}},
      {"extensor_carpi_radialis_longus", {6, 13, 23, 36, 40}},
      {"pronator_teres", {4, 8, 14, 20, 22}},
      {"flexor_carpi_radialis", {1, 2, 4, 5, 6}},
      {"anconeus", {-6, -12, -18, -22, -22}}};
  const double angles[] = {30, 60, 90, 120, 130};
  for (const auto& [name, shortening] : table) {
    const int m = index_of(arm().model, name);
    const double rest = at_angle(arm(), 0, length_of, m);
    for (int k = 0; k < 5; ++k) {
      EXPECT_NEAR(1e3 * (rest - at_angle(arm(), angles[k], length_of, m)), shortening[k], 5.0)
          << name << " at " << angles[k];
    }
  }
  const int control = index_of(arm().model, "coracobrachialis");
  for (const FrameMeasures& frame : arm().measures) {
    EXPECT_NEAR(frame.muscles[control].length, arm().measures[0].muscles[control].length, 1e-6);
  }
}

// At constant volume the mean section grows as the belly shortens: L / (L - shortening).
TEST(Arm, MeanBellySectionsFollowFromTheVolume) {
  for (const char* name : {"biceps_long", "brachialis", "brachioradialis", "triceps_lateral"}) {
    const int m = index_of(arm().model, name);
    const auto& belly = arm().model.muscles[m].shape.belly;
    const double rest = at_angle(arm(), 0, length_of, m);
    for (const double angle : {90.0, 130.0}) {
      const double shortening = rest - at_angle(arm(), angle, length_of, m);
      const double length = belly[1] - belly[0];
      EXPECT_NEAR(at_angle(arm(), angle, area_of, m) * (length - shortening) / length, 1.0, 0.1)
          << name << " at " << angle;
    }
  }
}

TEST(Arm, PolesStayOnTheirBones) {
  for (const FrameMeasures& frame : arm().measures) {
    for (const MuscleMeasures& muscle : frame.muscles) EXPECT_LE(muscle.attachment_gap, 1e-9);
  }
}

TEST(Arm, NoFoldsAndNoSelfIntersection) {
  for (size_t m = 0; m < arm().model.muscles.size(); ++m) {
    const Muscle& muscle = arm().model.muscles[m];
    const Surface& surface = arm().model.surfaces[m].surface;
    const Points rest = to_points(muscle.rest.vertices);
    const int rest_folds = folds_beyond_90(surface, rest);
    Bvh bvh = build_bvh(surface, rest);
    for (size_t f = 0; f < arm().x.size(); ++f) {
      const Points& x = arm().x[f][m];
      EXPECT_LE(folds_beyond_90(surface, x), rest_folds) << muscle.name << ", frame " << f + 1;
      refit_bvh(surface, x, bvh);
      EXPECT_TRUE(crossing_triangles(surface, bvh, x, surface, bvh, x).empty())
          << muscle.name << ", frame " << f + 1;
    }
  }
}

// No bone and no tendon of the biceps intersects the free part of a muscle, except where a tendon
// enters its own bone.
TEST(Arm, NoBoneAndNoTendonOfTheBicepsCutsABelly) {
  if (kStride > 1) GTEST_SKIP() << "asked of the clip at its own speed, not four times that";
  const Model& model = arm().model;
  const size_t biceps = index_of(model, "biceps_short"), brachialis = index_of(model, "brachialis");
  std::vector<Bvh> trees;  // of muscles and bones, refitted to each frame
  for (size_t i = 0, n = model.muscles.size(); i < n + model.bones.size(); ++i) {
    const TriMesh& rest = i < n ? model.muscles[i].rest : model.bones[i - n].in_body;
    trees.push_back(build_bvh(model.surfaces[i].surface, to_points(rest.vertices)));
  }
  const auto cut = [&](size_t m, const Points& x, size_t other, const Points& y) {
    const Surface &mine = model.surfaces[m].surface, &its = model.surfaces[other].surface;
    const auto pairs = crossing_triangles(mine, trees[m], x, its, trees[other], y);
    return std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) {
      const Triangle& t = mine.triangles[pair[0]];
      constexpr double kEnters = 0.02;  // m
      const auto is_free = [&](int i) { return !model.muscles[m].driven[i]; };
      const auto is_far = [&](int i) {
        return std::min(norm(x[i] - x.front()), norm(x[i] - x.back())) > kEnters;
      };
      return std::any_of(t.begin(), t.end(), is_free) && std::all_of(t.begin(), t.end(), is_far);
    });
  };
  for (size_t f = 0; f < arm().x.size(); ++f) {
    const std::vector<Points>& x = arm().x[f];
    for (size_t m = 0; m < x.size(); ++m) refit_bvh(model.surfaces[m].surface, x[m], trees[m]);
    EXPECT_EQ(cut(brachialis, x[brachialis], biceps, x[biceps]), 0) << "frame " << f + 1;
    for (size_t b = 0; f % 6 == 0 && b < model.bones.size(); ++b) {
      Points y;
      for (const Vec3& p : model.bones[b].in_body.vertices) {
        y.push_back(to_point(arm().poses[f][model.bones[b].body] * p));
      }
      refit_bvh(model.surfaces[x.size() + b].surface, y, trees[x.size() + b]);
      for (size_t m = 0; m < x.size(); ++m) {
        if (model.ignore[m][x.size() + b]) continue;
        EXPECT_EQ(cut(m, x[m], x.size() + b, y), 0)
            << model.muscles[m].name << ", " << model.bones[b].name << ", frame " << f + 1;
      }
    }
  }
}

TEST(Arm, BelliesHaveOneMaximum) {
  for (size_t m = 0; m < arm().model.muscles.size(); ++m) {
    const Muscle& muscle = arm().model.muscles[m];
    for (size_t f = 0; f < arm().x.size(); f += 10) {
      const CarriedPose pose = carry_pose(muscle.shape, arm().poses[f]);
      std::vector<double> radius;  // of the circle of the section's area
      for (int k = 0; k < 12; ++k) {
        radius.push_back(
            std::sqrt(section_area_at(muscle, pose, arm().x[f][m], (k + 1.5) / 14) / kPi));
      }
      const double ripple = 0.03 * *std::max_element(radius.begin(), radius.end());
      int maxima = 0;
      bool rising = true;
      double top = 0.0, bottom = 0.0;  // since the last turn
      for (const double r : radius) {
        top = std::max(top, r);
        bottom = std::min(bottom, r);
        if (rising && r < top - ripple) {
          ++maxima;
          rising = false;
          bottom = r;
        } else if (!rising && r > bottom + ripple) {
          rising = true;
          top = r;
        }
      }
      if (rising) ++maxima;
      EXPECT_EQ(maxima, 1) << muscle.name << ", frame " << f + 1;
    }
  }
}

TEST(Arm, WeightsShiftTheBellysVolume) {
  const std::string name = "biceps_long";
  std::map<std::string, double> centre;
  for (const std::string profile : {"left", "even", "right"}) {
    Model model = build_model(read_scene(
        THEW_SOURCE_DIR "/assets/arm/arm.toml",
        {"muscle." + name + ".weights=" + profile, "contact.enabled=false", "skin.enabled=false"}));
    Parallel parallel(2);
    State state = initial_state(model);
    settle(model, parallel, state);
    StageSeconds seconds;
    const int m = index_of(model, name);
    for (int f = kStride; f < 60; f += kStride) {
      step_frame(model, f / model.fps, parallel, state, seconds);
    }
    const Muscle& muscle = model.muscles[m];
    double sum = 0.0, area = 0.0;
    for (int k = 0; k < 40; ++k) {
      const double u = (k + 0.5) / 40;
      const double a = section_area_at(muscle, state.muscles[m].pose, state.muscles[m].x, u);
      sum += a * u;
      area += a;
    }
    centre[profile] = sum / area;
  }
  EXPECT_LE(centre["left"], centre["even"] - 0.04);
  EXPECT_GE(centre["right"], centre["even"] + 0.04);
}

TEST(Arm, SkinLiesOverAll) {
  for (size_t f = 0; f < arm().measures.size(); ++f) {
    const SkinMetrics& skin = arm().measures[f].skin;
    EXPECT_LE(skin.max_penetration, 1e-6) << "frame " << f + 1;
    EXPECT_LE(skin.max_poke_through, 5e-4) << "frame " << f + 1;
    EXPECT_EQ(skin.intersecting_pairs, 0) << "frame " << f + 1;
    EXPECT_LE(skin.volume_error, 1e-12) << "frame " << f + 1;
  }
}

struct Jumps {
  int nodes = 0;
  double farthest = 0.0;  // m
  std::string where;      // of the farthest
};

// Of the vertices that, relative to the nearest bone, move more in a frame than three times as far
// as in the neighbouring frames, plus 0.2 mm.
template <typename Position>
Jumps find_jumps(size_t nodes, Position&& position) {
  const Flexion& run = arm();
  Jumps jumps;
  for (size_t i = 0; i < nodes; ++i) {
    // The body relative to which the node moves least.
    size_t body = 0;
    double least = 1e30;
    for (size_t b = 0; b < run.poses[0].size(); ++b) {
      double moved = 0.0;
      for (size_t f = 1; f < run.poses.size(); ++f) {
        moved += (run.poses[f][b].inverse() * position(f, i) -
                  run.poses[f - 1][b].inverse() * position(f - 1, i))
                     .norm();
      }
      if (moved < least) least = moved, body = b;
    }
    std::vector<double> step(run.poses.size(), 0.0);
    for (size_t f = 1; f < step.size(); ++f) {
      step[f] = (run.poses[f][body].inverse() * position(f, i) -
                 run.poses[f - 1][body].inverse() * position(f - 1, i))
                    .norm();
    }
    bool jumps_ever = false;
    for (size_t f = 2; f + 1 < step.size(); ++f) {
      if (step[f] <= 3.0 * std::max(step[f - 1], step[f + 1]) + 2e-4) continue;
      jumps_ever = true;
      if (step[f] <= jumps.farthest) continue;
      jumps.farthest = step[f];
      jumps.where = "node " + std::to_string(i) + ", frame " + std::to_string(f + 1);
    }
    jumps.nodes += jumps_ever;
  }
  return jumps;
}

// Only the forearm turns. The muscles touch along their length: a node that lies over an edge of
// its neighbour may be held from either side of it, which makes 0.6 mm; a twist that turns over
// made 7.
TEST(Arm, HalfTheStepTellsTheSame) {
  const auto turn = [](const char* substeps, const std::string& degrees, const std::string& from) {
    Model model = build_model(
        read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml",
                   {"skin.enabled=false", substeps, "muscle.biceps_long.twist_from=" + from,
                    "muscle.biceps_short.twist_from=" + from,
                    "rig.clip={ unit = \"deg\", keys = { forearm_rotation = [[1, 0], [60, " +
                        degrees + "]] } }"}));
    Parallel parallel(2);
    StageSeconds unused;
    State state = initial_state(model);
    settle(model, parallel, state);
    std::vector<std::vector<Points>> frames;  // by muscle
    for (int f = 1; f < 60; f += kStride) {
      step_frame(model, f / model.fps, parallel, state, unused);
      std::vector<Points>& frame = frames.emplace_back();
      for (const MuscleState& muscle : state.muscles) frame.push_back(muscle.x);
    }
    return frames;
  };
  using Case = std::array<const char*, 2>;
  for (const auto& [degrees, from] : {Case{"-30", "0"}, Case{"-30", "0.34"}, Case{"45", "0.34"}}) {
    const auto whole = turn("solver.substeps=1", degrees, from);
    const auto half = turn("solver.substeps=2", degrees, from);
    double most = 0.0;  // m
    for (size_t f = 0; f < whole.size(); ++f) {
      for (size_t m = 0; m < whole[f].size(); ++m) {
        most = std::max(most, largest_distance(whole[f][m], half[f][m]));
      }
    }
    std::printf("%s deg, from %s: %.3f mm\n", degrees, from, 1e3 * most);
    EXPECT_LT(most, 8e-4) << degrees << ", " << from;
  }
}

// The forearm's turn does not reach the muscles that stay above the elbow: none of them needs
// forces. The others touch one another, and what moves one of them by its tendon moves its
// neighbours.
TEST(Arm, AForearmAloneIsCarried) {
  for (const char* degrees : {"-45", "45"}) {
    Scene scene = read_scene(
        THEW_SOURCE_DIR "/assets/arm/arm.toml",
        {"skin.enabled=false", "scene.frames=1-31",
         std::string("rig.clip={ unit = \"deg\", keys = { forearm_rotation = [[1, 0], [31, ") +
             degrees + "]] } }"});
    scene.solver.tolerance.emplace().position = 2e-3;
    const Model model = build_model(scene);
    const FidelityPlan plan = plan_fidelity(model, 2);
    int above = 0;
    for (size_t m = 0; m < plan.muscles.size(); ++m) {
      const std::string& name = model.muscles[m].name;
      if (name.rfind("triceps", 0) != 0 && name != "coracobrachialis") continue;
      ++above;
      const Level level = plan.muscles[m].level;
      EXPECT_TRUE(level == Level::kGeometric || level == Level::kAsleep)
          << degrees << ", " << name << ": " << plan.muscles[m].reason;
    }
    EXPECT_EQ(above, 4);
    EXPECT_LT(plan.work, 0.5 * plan.uniform_work) << degrees;  // counted; thew_bench has times
  }
}

TEST(Arm, NothingJumps) {
  if (kStride > 1) GTEST_SKIP() << "asked of the clip at its own speed, not four times that";
  const Flexion& run = arm();
  for (size_t m = 0; m < run.model.muscles.size(); ++m) {
    const Jumps jumps =
        find_jumps(run.x[0][m].size(), [&](size_t f, size_t i) { return to_vec(run.x[f][m][i]); });
    EXPECT_EQ(jumps.nodes, 0) << run.model.muscles[m].name << ", " << jumps.where;
  }
  // A defect that is known: as the fold opens some of its nodes go by 1.7 mm in a frame, and some
  // of the flat cut of the chest, with nothing close below it, by 0.3.
  const Jumps jumps =
      find_jumps(run.skin[0].size(), [&](size_t f, size_t i) { return to_vec(run.skin[f][i]); });
  std::printf("skin: %d nodes jump, by %.2f mm at most, %s\n", jumps.nodes, 1e3 * jumps.farthest,
              jumps.where.c_str());
  EXPECT_LE(jumps.nodes, 17);
  EXPECT_LT(jumps.farthest, 1.9e-3);
}

TEST(Arm, WithoutTheMultiplierVolumeIsLost) {
  const Flexion none = flex({"solver.volume=none", "skin.enabled=false", "scene.frames=\"1-60\""});
  double worst = 0.0;
  for (const MuscleMeasures& muscle : none.measures.back().muscles) {
    worst = std::max(worst, muscle.volume_error);
  }
  EXPECT_GT(worst, 0.01);
}

}  // namespace
}  // namespace thew::tests
