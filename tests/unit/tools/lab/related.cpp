// SPDX-License-Identifier: Apache-2.0
//
// What the methods of others are measured with: the truth, the runs, and the verdicts.
#include <gtest/gtest.h>

#include <cmath>

#include "tools/base/options.h"
#include "tools/lab/chart/plot.h"
#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/related/claims.h"
#include "tools/lab/related/page.h"

namespace thew::tests {
namespace {

// Where the rim follows an affine map, so does the inside; volumes are of bodies of revolution.
TEST(RoundBody, PassesThePatchTest) {
  for (const bool spindle : {false, true}) {
    RoundBody body = spindle ? round_spindle(0.05, 0.2, 0.18, 3, 6) : round_ellipsoid(0.1, 0.2, 6);
    const double rest = volume_of(body);
    const double ellipsoid = 2.0 / 3.0 * 3.14159265358979 * 0.1 * 0.1 * 0.2;
    EXPECT_TRUE(spindle || std::abs(rest - ellipsoid) < 1e-6) << rest;
    const auto mapped = [](const RoundBody::Place& p) {
      return RoundBody::Place{0.9 * p[0], 1.15 * p[1]};
    };
    for (const int node : body.rim) body.fixed[node] = {1, 1};
    for (size_t i = 0; i < body.x.size(); ++i) {
      if (body.fixed[i][0] && body.fixed[i][1]) body.x[i] = mapped(body.rest[i]);
    }
    ASSERT_TRUE(rest_round({}, 1e-12, body));
    for (size_t i = 0; i < body.x.size(); ++i) {
      const RoundBody::Place to = mapped(body.rest[i]);
      EXPECT_NEAR(body.x[i][0], to[0], 1e-9);
      EXPECT_NEAR(body.x[i][1], to[1], 1e-9);
    }
    EXPECT_NEAR(volume_of(body) / rest, 0.81 * 1.15, 1e-12);
  }
}

TruthScene squeezed_section(int coarsest) {
  TruthScene scene;
  scene.coarsest = coarsest;
  scene.steps = 6;
  scene.round = [](int n) { return round_ellipsoid(0.1, 0.1, n); };
  scene.beyond = [](double share, const Vec3& p) {
    const double depth = p.y() - 0.1 * (1.0 - 0.3 * share);
    return Vec3(0, std::max(depth, 0.0), 0);
  };
  return scene;
}

// Two sequences of meshes come to one limit, as near as they say; and tetrahedra come to it too.
TEST(Truth, TwoSequencesAndTetrahedraAgree) {
  const Truth coarse = find_truth(squeezed_section(2)), fine = find_truth(squeezed_section(4));
  ASSERT_TRUE(coarse.converged && fine.converged);
  EXPECT_LT(fine.error, coarse.error);
  EXPECT_LT(fine.error, 5e-3 * 0.1);
  EXPECT_GT(coarse.order, 1.0);
  std::vector<Vec3> line;
  for (const RoundBody::Place& p : coarse.profile) line.push_back({p[0], p[1], 0.0});
  EXPECT_LT(mean_distance(line, fine), 2.0 * coarse.error);
  FemBody octant = octant_ball(0.1, 3, {.neo_hookean = true, .shear = 1000.0, .penalty = 1e6});
  ASSERT_TRUE(close_planes(0.1, 0.07, 6, {}, octant).converged);
  std::vector<Vec3> nodes;
  for (size_t i = 0; i < octant.x.size(); ++i) {
    if (octant.surface[i]) nodes.push_back(octant.x[i]);
  }
  EXPECT_LT(mean_distance(nodes, fine), 0.015 * 0.1);
}

class RelatedRuns : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scene_ = new RelatedScene(squeezed_ball(own_asset("paper"), 1470, 2691, 0));
  }
  static void TearDownTestSuite() { delete scene_; }
  static const RelatedMethod& method(const std::string& name) {
    static const std::vector<RelatedMethod> kAll = related_methods(false);
    for (const RelatedMethod& one : kAll) {
      if (one.name == name) return one;
    }
    throw std::runtime_error(name);
  }
  static RelatedScene* scene_;
};
RelatedScene* RelatedRuns::scene_ = nullptr;

TEST_F(RelatedRuns, TooFewStepsAreToldAndEnoughKeepTheVolume) {
  const RelatedMethod& ours = method(kOurs);
  EXPECT_EQ(run_rival(*scene_, ours, ours.dials[0], 1, 0, 20.0).failure, "unstable");
  const RelatedRun run = run_rival(*scene_, ours, ours.dials[0], 32, 10, 20.0);
  EXPECT_EQ(run.failure, "");
  EXPECT_LT(run.volume_error, 1e-13);
  EXPECT_EQ(run_rival(*scene_, ours, ours.dials[0], 32, 10, 0.0).failure, "given up");
}

// The paper's figure 8: without anything for the volume half of it is gone, and linear elements
// with a penalty keep most.
TEST_F(RelatedRuns, SpringsAloneLoseTheVolumeAndElementsWithAPenaltyMostlyKeepIt) {
  const RelatedMethod &none = method("conventional"), &linear = method("linear FEM");
  EXPECT_GT(run_rival(*scene_, none, none.dials[0], 32, 0, 20.0).volume_error, 0.3);
  const RelatedRun kept = run_rival(*scene_, linear, linear.dials[0], 1, 10, 20.0);
  EXPECT_LT(kept.volume_error, 0.02);
  EXPECT_GT(kept.volume_error, 1e-5);
}

// Forces inside a body give it no momentum; barycentre springs as printed do not cancel.
TEST_F(RelatedRuns, MomentumAndStiffnessAreThoseOfTheMethod) {
  const RelatedMethod &ours = method(kOurs), &pressure = method("Zordan 2004"),
                      &barycentre = method("Bourguignon 2000");
  EXPECT_LT(momentum_gained(*scene_, pressure, pressure.dials[0]), 1e-12);
  EXPECT_GT(momentum_gained(*scene_, barycentre, barycentre.dials[0]), 1e-3);
  EXPECT_NEAR(stiffening(*scene_, ours, ours.dials[0]), 1.0, 1e-3);
  EXPECT_NEAR(stiffening(*scene_, pressure, pressure.dials[0]), 1.0, 1e-3);
  EXPECT_GT(stiffening(*scene_, barycentre, barycentre.dials[0]), 1.05);
}

// What asks for the volume alone, of the whole or of each element, does not resist a stretch that
// keeps it, with a step or without.
TEST_F(RelatedRuns, ElementsAndALatticeAreNoStifferWhereTheVolumeIsKept) {
  for (const char* name : {"Smith 2018", "Chen 2024", "Hirota 1999"}) {
    const RelatedMethod& one = method(name);
    EXPECT_NEAR(stiffening(*scene_, one, one.dials[0]), 1.0, 1e-2) << name;
  }
  RelatedDial wrong = method("Hirota 1999").dials[0];
  wrong.energy = [&wrong](const RivalBody& body, const Vec3& stretch) {
    return 2.0 * wrong.bare_energy(body, stretch);
  };
  EXPECT_NEAR(stiffening(*scene_, method("Hirota 1999"), wrong), 2.0, 1e-9);
}

// A study of which all is known.
Study made_up(double their_error, double stiffer) {
  Study study;
  study.methods = related_methods(true);
  StudiedScene& in = study.scenes.emplace_back();
  in.scene.key = "ball_1470";
  in.scene.ours =
      ready_scene({own_asset("paper") / "ball.toml", {"scene.frames=1-2"}, 0, {}, false});
  for (const RelatedMethod& one : study.methods) {
    RelatedRun run{one.name, "", 4, "", 2.0, their_error, 0.1, 0.04, {}};
    if (one.name == kOurs) run.volume_error = 1e-15, run.distance = 0.02, run.milliseconds = 1.0;
    RelatedSweep& found = in.sweeps.emplace_back();
    found.runs = {run};
    found.best = found.cheapest = 0;
    study.momentum.push_back(0.0);
    study.stiffening.push_back(one.name == kOurs ? 1.0 : stiffer);
  }
  study.scenes.push_back(in);
  study.scenes.back().scene.key = "flexed";
  return study;
}

std::string verdict_of(const Study& study, const std::string& claim) {
  for (const RelatedClaim& one : judge_claims(study)) {
    if (one.claim.find(claim) != std::string::npos) return one.verdict;
  }
  return "no such claim";
}

TEST(RelatedClaims, VerdictsFollowTheFigures) {
  const Study one = made_up(0.2, 3.0), other = made_up(1e-12, 1.0);
  EXPECT_EQ(verdict_of(one, "stiffen the body"), "true");
  EXPECT_EQ(verdict_of(other, "stiffen the body"), "false");
  EXPECT_EQ(verdict_of(one, "conventional mass-spring system loses"), "true");
  EXPECT_EQ(verdict_of(other, "conventional mass-spring system loses"), "false");
  EXPECT_EQ(verdict_of(one, "Promayon's projection keeps the volume exactly"), "false");
  EXPECT_EQ(verdict_of(other, "Promayon's projection keeps the volume exactly"), "true");
  EXPECT_EQ(verdict_of(one, "none is nearer to a solid"), "true");
  for (const RelatedClaim& claim : judge_claims(one)) EXPECT_NE(claim.source, "") << claim.claim;
  Study beaten = one;
  beaten.scenes[0].sweeps[beaten.method("Hirota 1999")].runs[0].distance = 0.01;
  EXPECT_EQ(verdict_of(beaten, "none is nearer to a solid"), "only among what costs as little");
  beaten.scenes[0].sweeps[beaten.method("Hirota 1999")].runs[0].milliseconds = 0.5;
  EXPECT_EQ(verdict_of(beaten, "none is nearer to a solid"), "false");
}

// Geometric muscles grow as constant volume asks; linear elements lose some under a large
// shortening, and the muscle itself keeps it beside its neighbours.
TEST(RelatedArm, SectionsGrowAsTheBellyShortens) {
  const std::vector<ArmSection> rows = arm_sections(own_asset("arm/arm.toml"), {0.0, 90.0});
  ASSERT_EQ(rows.size(), 24u);
  for (const ArmSection& row : rows) {
    const double constant = 1.0 / (1.0 - row.shortening);
    EXPECT_NEAR(row.ellipsoid.section, constant, 0.05 * constant) << row.muscle;
    EXPECT_NEAR(row.profile.section, constant, 0.05 * constant) << row.muscle;
    EXPECT_LT(row.ellipsoid.volume_error, 1e-12);
    EXPECT_LT(row.profile.volume_error, 1e-3);
    EXPECT_LT(row.ours.volume_error, 1e-12);
    if (row.degrees < 1.0) continue;
    if (row.muscle != "biceps_long") continue;
    EXPECT_GT(constant, 1.3);
    EXPECT_NEAR(row.ours.section, constant, 0.05 * constant);
    EXPECT_GT(row.elements.volume_error, 0.05);
    EXPECT_LT(row.elements.section, row.ours.section);
  }
  EXPECT_EQ(sections_of(rows).rows.size(), 26u);
}

TEST(RelatedPage, EveryMethodHasARowAndAMark) {
  const Study study = made_up(0.2, 3.0);
  const std::string svg = draw_cost(chart_of(study, "ball_1470"), &ChartPoint::percent, "error");
  EXPECT_EQ(summary_of(study).rows.size(), study.methods.size());
  for (const RelatedMethod& one : study.methods) {
    EXPECT_NE(svg.find(one.name), std::string::npos) << one.name;
  }
  for (const auto& row : summary_of(study).rows) {
    EXPECT_EQ(row.size(), summary_of(study).head.size());
  }
}

}  // namespace
}  // namespace thew::tests
