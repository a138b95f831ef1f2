// SPDX-License-Identifier: Apache-2.0
//
// What is painted on a skin: a ball of skin around a ball of flesh, where the answers are known.
#include <gtest/gtest.h>

#include "rig/math.h"
#include "skin/skin_layer.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

constexpr double kSkin = 0.05, kFlesh = 0.045;  // m, radii as modelled

struct Painted {
  Shape flesh = make_shape(ball(kFlesh, Vec3::Zero(), 32, 31));
  std::vector<Collider> below = {{&flesh.surface, &flesh.bvh, &flesh.x, nullptr}};
  TriMesh mesh = ball(kSkin, Vec3::Zero(), 32, 31);
  SkinModel model;
  SkinState state;

  explicit Painted(const SkinMaps& maps) {
    Skeleton skeleton;
    skeleton.body_names = {"bone"};
    skeleton.parent = {-1};
    model = bind_skin(mesh, skeleton, {Transform::Identity()}, below, {0},
                      {.thickness = 0.001, .iterations = 12}, maps);
    state = initial_skin(model);
  }

  // The flesh by itself: its bone stays.
  void turn_flesh(double angle) {
    constexpr int kFrames = 20;
    const std::vector<Vec3> rest = flesh.mesh.vertices;
    for (int frame = 1; frame <= 2 * kFrames; ++frame) {  // the second half at rest
      const double share = std::min(frame, kFrames) / double(kFrames);
      const Mat3 turn = rotation_about(Vec3::UnitY(), share * angle);
      for (size_t i = 0; i < rest.size(); ++i) flesh.x[i] = to_point(turn * rest[i]);
      refit_bvh(flesh.surface, flesh.x, flesh.bvh);
      step_skin(model, {Transform::Identity()}, below, {}, state);
    }
  }
};

// Two balls whose thickness is painted: a contact keeps free what lies on both of its points.
TEST(SkinMaps, ContactKeepsFreeWhatIsPaintedOnBothSides) {
  Shape a = make_shape(ball(0.02, Vec3::Zero(), 16, 15));
  Shape b = make_shape(ball(0.02, Vec3(0, 0.0405, 0), 16, 15));
  const std::vector<char> free_nodes(a.x.size(), 1);
  std::vector<double> on_a, on_b;
  for (size_t i = 0; i < a.x.size(); ++i) {
    on_a.push_back(1e-3 + 0.1 * std::abs(a.x[i][0]));
    on_b.push_back(2e-3 + 0.2 * std::abs(b.x[i][2]));
  }
  std::vector<Collider> both = {{&a.surface, &a.bvh, &a.x, &free_nodes},
                                {&b.surface, &b.bvh, &b.x, &free_nodes}};
  both[0].thicknesses = &on_a, both[1].thicknesses = &on_b;
  ContactMemory memory;
  std::vector<Contact> contacts;
  find_contacts(both, 0, {1}, {.margin = 0.006}, {}, memory, contacts);
  ASSERT_GT(contacts.size(), 5u);
  double least = 1.0, most = 0.0;
  for (const Contact& contact : contacts) {
    const Triangle& t = b.mesh.triangles[contact.triangle];
    double theirs = 0.0;
    for (int k = 0; k < 3; ++k) theirs += contact.barycentric[k] * on_b[t[k]];
    EXPECT_DOUBLE_EQ(contact.offset, on_a[contact.node] + theirs);
    least = std::min(least, contact.offset), most = std::max(most, contact.offset);
  }
  EXPECT_GT(most, least + 1e-4);
}

std::vector<double> all(double value) {
  return std::vector<double>(ball(kSkin, Vec3::Zero(), 32, 31).vertices.size(), value);
}

TEST(SkinMaps, TheSkinStandsOffByItsFat) {
  Painted thin({.fat = all(0.002)}), thick({.fat = all(0.008)});
  for (Painted* skin : {&thin, &thick}) skin->turn_flesh(0.0);
  double least = 1.0, most = 0.0;
  for (size_t i = 0; i < thin.state.x.size(); ++i) {
    const double by = norm(thick.state.x[i]) - norm(thin.state.x[i]);
    least = std::min(least, by), most = std::max(most, by);
    EXPECT_NEAR(thin.model.fat[i], 0.002, 2e-6);
    EXPECT_NEAR(thick.model.fat[i], 0.008, 2e-6);
  }
  EXPECT_NEAR(least, 0.006, 3e-5);  // facets of the flesh are up to 0.2 mm below its sphere
  EXPECT_NEAR(most, 0.006, 3e-5);
}

TEST(SkinMaps, FatIsPaintedNodeByNode) {
  SkinMaps maps{.fat = all(0.0)};
  const std::vector<Vec3> rest = ball(kSkin, Vec3::Zero(), 32, 31).vertices;
  for (size_t i = 0; i < rest.size(); ++i) maps.fat[i] = rest[i].y() > 0.0 ? 0.008 : 0.002;
  const Painted skin(maps);
  for (size_t i = 0; i < rest.size(); ++i) EXPECT_NEAR(skin.model.fat[i], maps.fat[i], 2e-6);
}

// Mean angle about y between where nodes are and where they were at rest, over the angle by which
// the flesh has turned. Nodes near the poles have none.
double share_of_turn(const Painted& skin, double angle) {
  double sum = 0.0;
  int count = 0;
  for (size_t i = 0; i < skin.state.x.size(); ++i) {
    const Point &a = skin.model.rest[i], &b = skin.state.x[i];
    if (std::hypot(a[0], a[2]) < 0.5 * kSkin) continue;
    sum += std::atan2(a[2] * b[0] - a[0] * b[2], a[0] * b[0] + a[2] * b[2]);
    ++count;
  }
  return sum / count / angle;
}

TEST(SkinMaps, SkinSticksToItsFleshOrSlidesOverIt) {
  constexpr double kAngle = 0.5;
  Painted sticks({.slide = all(0.0)}), half({.slide = all(0.5)}), slides({.slide = all(1.0)});
  for (Painted* skin : {&sticks, &half, &slides}) skin->turn_flesh(kAngle);
  EXPECT_TRUE(slides.model.stick.empty());  // the default
  const double stuck = share_of_turn(sticks, kAngle), halfway = share_of_turn(half, kAngle);
  EXPECT_NEAR(stuck, 1.0, 0.01);
  EXPECT_NEAR(share_of_turn(slides, kAngle), 0.0, 1e-2);
  // Of one radian, the flesh's pull 1/l^2 (l = 3 cm) against that of the anchors (12 cm) and of the
  // edges, 2/R^2 for a field that turns as a ball does.
  const double pull = 1.0 / (0.03 * 0.03), anchors = 1.0 / (0.12 * 0.12);
  const double edges = 2.0 / (kSkin * kSkin);
  EXPECT_NEAR(halfway, pull / (pull + anchors + edges), 0.05);
  for (size_t i = 0; i < sticks.state.x.size(); ++i) {  // each node is where its flesh takes it
    const Vec3 taken = rotation_about(Vec3::UnitY(), kAngle) * to_vec(sticks.model.rest[i]);
    EXPECT_LT((to_vec(sticks.state.x[i]) - taken).norm(), 4e-4);
  }
}

}  // namespace
}  // namespace thew::tests
