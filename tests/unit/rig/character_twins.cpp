// SPDX-License-Identifier: Apache-2.0
#include "rig/character_twins.h"

#include <gtest/gtest.h>

namespace thew::tests {
namespace {

constexpr int kFirst[] = {0, 1, 2}, kCopy[] = {3, 4, 5};  // hips, spine and arm of either

// A skeleton of three bodies and its copy, which a joint more hangs on. A vertex on each body.
Character dressed(const Vec3& copy_at = Vec3::Zero()) {
  Character c;
  const auto add = [&](const std::string& name, int parent, const Vec3& at) {
    Affine world = Affine::Identity();
    world.translation() = at;
    const int body = c.skeleton.size();
    c.skeleton.body_names.push_back(name);
    c.skeleton.parent.push_back(parent);
    c.bind.push_back(world);
    c.rest.push_back(parent < 0 ? world : c.bind[parent].inverse() * world);
    c.mesh.vertices.push_back(at + Vec3(0.0, 0.1, 0.05));
    c.skin.links.push_back({body, world.inverse()});
    c.skin.first.push_back(body);
    c.skin.link.push_back(body);
    c.skin.weight.push_back(1.0);
    return body;
  };
  const int first = add("Hips", -1, Vec3(0, 1, 0));
  add("Arm", add("Spine", first, Vec3(0, 1.2, 0)), Vec3(0.3, 1.4, 0));
  const int copy = add("Hips_2", -1, Vec3(0, 1, 0) + copy_at);
  const int arm =
      add("Arm_2", add("Spine_2", copy, Vec3(0, 1.2, 0) + copy_at), Vec3(0.3, 1.4, 0) + copy_at);
  add("Sleeve", arm, Vec3(0.35, 1.3, 0));
  c.skin.first.push_back(c.skeleton.size());
  return c;
}

// A quarter turn of a body, in its parent, in one second.
BodyTrack turning(int body, double angle) {
  BodyTrack track;
  track.body = body;
  track.rotation.times = {0.0, 1.0};
  for (const double at : {0.0, angle}) {
    track.rotation.values.emplace_back(Eigen::AngleAxisd(at, Vec3(0.6, 0.0, 0.8)));
  }
  return track;
}

Points at_the_end(const Character& c) {
  std::vector<Affine> world;
  animated_bodies(c, c.animations.at(0), 1.0, world);
  Points x;
  skin_vertices(c.skin, c.mesh, world, x);
  return x;
}

void expect_as_one(const Character& c) {
  ASSERT_EQ(c.twins.size(), 3u);
  EXPECT_EQ(c.skeleton.parent[kCopy[1]], kFirst[1]);
  EXPECT_EQ(c.twins[1].parent_in_file, kCopy[0]);
  EXPECT_EQ(c.warnings.size(), 1u);
  for (const SkinWeights::Link& link : c.skin.links) EXPECT_TRUE(link.body < 3 || link.body == 6);
  const Points x = at_the_end(c);
  for (int k = 0; k < 3; ++k) EXPECT_LT(norm(x[kFirst[k]] - x[kCopy[k]]), 1e-12);
  EXPECT_GT(norm(x[kFirst[2]] - to_point(c.mesh.vertices[kFirst[2]])), 0.1) << "it moves";
  EXPECT_NEAR(norm(x[6] - x[kFirst[2]]), (c.mesh.vertices[6] - c.mesh.vertices[kFirst[2]]).norm(),
              1e-12)
      << "what hangs on the copy goes with it";
}

TEST(JoinTwins, OfTwoSkeletonsTheSecondFollows) {
  for (const bool both : {false, true}) {
    Character c = dressed();
    c.animations.push_back({"Turn", 1.0, {turning(kFirst[1], 1.5)}});
    if (both) c.animations[0].tracks.push_back(turning(kCopy[1], 1.5));
    join_twins(c);
    EXPECT_EQ(c.animations[0].tracks.size(), 1u);
    expect_as_one(c);
  }
}

TEST(JoinTwins, WhereTheSecondAloneIsAnimatedTheFirstFollows) {
  Character c = dressed();
  c.animations.push_back({"Turn", 1.0, {turning(kCopy[1], 1.5)}});
  const Point as_in_the_file = at_the_end(c)[kCopy[2]];
  join_twins(c);
  expect_as_one(c);
  EXPECT_LT(norm(at_the_end(c)[kCopy[2]] - as_in_the_file), 1e-12);
}

// Two people who stand in one another, and two beside one another.
TEST(JoinTwins, WhatMovesApartIsNoTwin) {
  Character c = dressed();
  c.animations.push_back({"Turn", 1.0, {turning(kFirst[0], 0.5), turning(kCopy[0], -0.5)}});
  const Points before = at_the_end(c);
  join_twins(c);
  EXPECT_TRUE(c.twins.empty());
  EXPECT_TRUE(c.warnings.empty());
  EXPECT_EQ(c.animations[0].tracks.size(), 2u);
  EXPECT_EQ(largest_distance(at_the_end(c), before), 0.0);
  Character beside = dressed(Vec3(0.8, 0.0, 0.0));
  join_twins(beside);
  EXPECT_TRUE(beside.twins.empty());
}

// Bodies of a chain, numbered by the file itself, may even lie in one place.
TEST(JoinTwins, WhatHangsOnTheOtherIsNoTwin) {
  Character c = dressed();
  c.skeleton.parent[kCopy[0]] = kFirst[0];
  c.rest[kCopy[0]] = Affine::Identity();
  c.skeleton.body_names[kCopy[1]] = "Waist", c.skeleton.body_names[kCopy[2]] = "Hand";
  join_twins(c);
  EXPECT_TRUE(c.twins.empty());
}

}  // namespace
}  // namespace thew::tests
