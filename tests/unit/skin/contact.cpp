// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "rig/math.h"
#include "skin/contact/face_contact.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

struct Pair {
  Shape a, b;
  std::vector<char> free_nodes;
  ContactMemory memory;
  std::vector<Contact> contacts;

  Pair(const TriMesh& one, const TriMesh& two)
      : a(make_shape(one)), b(make_shape(two)), free_nodes(one.vertices.size(), 1) {}
  const std::vector<Contact>& find(const ContactSettings& settings, bool ignored = false) {
    const std::vector<Collider> colliders{
        {&a.surface, &a.bvh, &a.x, &free_nodes, nullptr, box_of(a.x)},
        {&b.surface, &b.bvh, &b.x, nullptr, nullptr, box_of(b.x)}};
    CandidatePairs pairs;
    find_candidate_pairs(colliders, settings, pairs);
    find_contacts(colliders, 0, ignored ? std::vector<int>{} : pairs.near[0], settings, {}, memory,
                  contacts);
    return contacts;
  }
};

// The same pairs as by testing all pairs one by one.
TEST(Contact, SweepFindsThePairsWhoseBoxesAreNear) {
  std::vector<Points> points;
  for (int c = 0; c < 60; ++c) {  // boxes of 0.1 to 0.4 m, scattered
    const Vec3 at(std::fmod(0.37 * c, 1.0), std::fmod(0.61 * c, 1.0), std::fmod(1.3 * c, 7.0));
    points.push_back({to_point(at), to_point(at + (0.1 + 0.005 * c) * Vec3(1, 1, 1))});
  }
  std::vector<Collider> colliders(points.size());
  for (size_t c = 0; c < points.size(); ++c) colliders[c].box = box_of(points[c]);
  const ContactSettings settings{0.02, 0.05, 0.0};
  CandidatePairs pairs;
  for (int time = 0; time < 2; ++time) find_candidate_pairs(colliders, settings, pairs);  // anew
  const auto& near = pairs.near;
  size_t found = 0;
  for (int a = 0; a < 60; ++a) {
    std::vector<int> expected;
    for (int b = 0; b < 60; ++b) {
      if (b != a && are_near(colliders[a].box, colliders[b].box, 0.05 + 1e-6))
        expected.push_back(b);
    }
    EXPECT_EQ(near[a], expected);
    found += expected.size();
  }
  EXPECT_GT(found, 20u);
  EXPECT_LT(found, 2000u);
}

TEST(Contact, TwoBallsApartAndPressed) {
  // Radius 1, the gap along x: the margin of 0.1 reaches only what lies nearer.
  Pair apart(ball(1.0, {0, 0, 0}, 32, 15), ball(1.0, {2.3, 0, 0}, 32, 15));
  EXPECT_TRUE(apart.find({0.1, 0.5, 0.0}).empty());

  Pair pressed(ball(1.0, {0, 0, 0}, 32, 15), ball(1.0, {1.9, 0, 0}, 32, 15));
  const auto contacts = pressed.find({0.1, 0.5, 0.0});
  int expected = 0;  // nodes whose distance from the other ball is below the margin
  for (const Vec3& p : pressed.a.mesh.vertices) expected += (p - Vec3(1.9, 0, 0)).norm() < 1.08;
  EXPECT_GE(static_cast<int>(contacts.size()), expected);
  double deepest = 0.0;
  for (const Contact& contact : contacts) {
    const Vec3 p = pressed.a.mesh.vertices[contact.node];
    EXPECT_EQ(contact.other, 1);
    EXPECT_NEAR(contact.distance, (p - Vec3(1.9, 0, 0)).norm() - 1.0, 0.03);  // facets
    EXPECT_LT(contact.normal.x(), -0.7);
    Vec3 q = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      q += contact.barycentric[k] *
           pressed.b.mesh.vertices[pressed.b.mesh.triangles[contact.triangle][k]];
    }
    EXPECT_NEAR(contact.normal.dot(p - q), contact.distance, 1e-12);
    deepest = std::min(deepest, contact.distance);
  }
  EXPECT_NEAR(deepest, -0.1, 0.002);  // on the axis; facets lie a little within
}

TEST(Contact, IgnoredPairsAndHeldNodes) {
  Pair pressed(ball(1.0, {0, 0, 0}, 32, 15), ball(1.0, {1.9, 0, 0}, 32, 15));
  EXPECT_TRUE(pressed.find({0.1, 0.5, 0.0}, true).empty());
  std::fill(pressed.free_nodes.begin(), pressed.free_nodes.end(), 0);
  EXPECT_TRUE(pressed.find({0.1, 0.5, 0.0}).empty());
}

TEST(Contact, SecondSearchFromHintsFindsTheSame) {
  Pair pressed(ball(1.0, {0, 0, 0}, 32, 15), ball(1.0, {1.8, 0.1, 0}, 32, 15));
  const auto first = pressed.find({0.1, 0.5, 0.0});
  const auto second = pressed.find({0.1, 0.5, 0.0});
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].node, second[i].node);
    EXPECT_EQ(first[i].triangle, second[i].triangle);
    EXPECT_EQ(first[i].distance, second[i].distance);
  }
}

TEST(Contact, DeepNodesAreNotPulledThroughTheFarSide) {
  // A thick ball has been pressed through a plate by more than its thickness. For the foremost
  // nodes of the ball the nearest face of the plate is the far one, whose normal points in the same
  // direction as theirs.
  TriMesh plate = cube(1.0);
  for (Vec3& p : plate.vertices) p.x() *= 0.1;
  TriMesh presser = ball(0.5, {-0.45, 0.0, 0.0}, 32, 15);
  Pair pair(presser, plate);
  for (const Contact& contact : pair.find({0.01, 0.5, 0.0})) {
    EXPECT_LE(contact.normal.dot(node_normal(pair.a.surface, pair.a.x, contact.node)), 1e-9)
        << contact.node;
  }
}

// Largest angle (rad) by which the contact normal turns as a node goes around an edge of a cube in
// steps, 1 cm away from it.
double turn_over_an_edge(bool soft) {
  const TriMesh box = cube(1.0);
  const Vec3 edge(1.0, 1.0, 0.1);
  const std::vector<char> is_free(box.vertices.size(), 1);
  Vec3 first = Vec3::Zero();
  double most = 0.0;
  for (int degrees = 0; degrees <= 90; degrees += 15) {
    const SinCos turn = sin_cos(degrees * kDegree);
    // The foremost node of a small ball, whose normal points at the edge.
    const Vec3 node = edge + 0.01 * Vec3(turn.sin, turn.cos, 0.0);
    TriMesh mesh = ball(0.05, {0, 0, 0}, 8, 5);
    const Vec3 diagonal = 0.05 * Vec3(1, 1, 0).normalized();
    for (Vec3& p : mesh.vertices) p += node + diagonal;
    mesh.vertices[0] = node;
    const Shape a = make_shape(mesh), b = make_shape(box);
    const std::vector<char> only_it = [&] {
      std::vector<char> nodes(mesh.vertices.size(), 0);
      nodes[0] = 1;
      return nodes;
    }();
    const std::vector<Collider> colliders{
        {&a.surface, &a.bvh, &a.x, &only_it, nullptr, box_of(a.x)},
        {&b.surface, &b.bvh, &b.x, soft ? &is_free : nullptr, nullptr, box_of(b.x)}};
    ContactMemory memory;
    std::vector<Contact> contacts;
    find_contacts(colliders, 0, {1}, {0.03, 0.1, 0.0}, {}, memory, contacts);
    EXPECT_EQ(contacts.size(), 1u);
    if (degrees == 0) first = contacts[0].normal;
    most = std::max(most, (contacts[0].normal - first).norm());
  }
  return most;
}

// Otherwise a node would change from one side to the other from step to step.
TEST(Contact, NormalsTurnSlowlyOverASoftEdge) {
  EXPECT_LT(turn_over_an_edge(true), 0.02);
  EXPECT_GT(turn_over_an_edge(false), 0.5) << "of bone it is the way to the node";
}

TEST(Contact, HeldPointsOfOneSurfaceHoldANodeAsOne) {
  std::vector<Contact> contacts;
  const auto add = [&](int node, int other, int point) {
    contacts.push_back({.node = node, .other = other, .point = point, .of_face = point >= 0});
  };
  add(3, 1, 7), add(3, 0, -1), add(3, 1, 4), add(2, 1, 4), add(3, 1, -1);
  order_contacts(contacts);
  std::vector<size_t> ends;
  for (size_t c = 0; c < contacts.size(); c = ends.back()) ends.push_back(group_end(contacts, c));
  EXPECT_EQ(ends, (std::vector<size_t>{1, 2, 3, 5}));
  EXPECT_EQ(contacts[3].point, 4);
}

// A fixed ball of 0.1 m over the middle of a face of a free ball, whose nodes are 0.3 m away.
struct BetweenNodes {
  Shape wide = make_shape(ball(1.0, {0, 0, 0}, 16, 7)), thin;
  std::vector<char> all_free = std::vector<char>(wide.x.size(), 1);
  std::vector<SurfacePoint> none, points;
  std::vector<Contact> nodes, faces;

  explicit BetweenNodes(double depth, double spacing = 0.05) {
    const Triangle& t = wide.surface.triangles[wide.surface.triangles.size() / 2];
    const Point middle = (wide.x[t[0]] + wide.x[t[1]] + wide.x[t[2]]) / 3.0;
    const Vec3 out =
        face_normal(wide.surface, wide.x, static_cast<int>(wide.surface.triangles.size() / 2));
    thin = make_shape(ball(0.1, to_vec(middle) + (0.1 - depth) * out, 16, 9));
    points = rigid_points(thin.surface, thin.x, nullptr, spacing);
    std::vector<Collider> colliders{
        {&wide.surface, &wide.bvh, &wide.x, &all_free, nullptr, box_of(wide.x), &none},
        {&thin.surface, &thin.bvh, &thin.x, nullptr, nullptr, box_of(thin.x), &points}};
    const ContactSettings settings{0.03, 0.2, kGap};
    ContactMemory memory, face_memory;
    find_contacts(colliders, 0, {1}, settings, {}, memory, nodes);
    faces = nodes;
    find_face_contacts(colliders, 0, {1}, settings, {}, face_memory, faces);
  }
  // m, of a corner to where it is asked to be; below 0 it is there.
  static double way(const Contact& c) { return kGap + c.offset - c.distance; }
  static constexpr double kGap = 0.002;
};

TEST(FaceContact, WhatSlipsInBetweenNodesIsMet) {
  BetweenNodes in(0.04);
  EXPECT_TRUE(in.nodes.empty()) << "no node sees it";
  ASSERT_FALSE(in.faces.empty());
  for (const Contact& c : in.faces) {
    EXPECT_TRUE(c.of_face);
    if (BetweenNodes::way(c) > 0.0) in.wide.x[c.node] += BetweenNodes::way(c) * to_point(c.normal);
  }
  refit_bvh(in.wide.surface, in.wide.x, in.wide.bvh);
  double nearest = 1.0;
  for (const Point& x : in.thin.x) {
    nearest = std::min(
        nearest, closest_point(in.wide.surface, in.wide.bvh, in.wide.x, to_vec(x), 1).distance);
  }
  EXPECT_GT(nearest, -0.002);  // from -0.04
}

// C = 0.02 - 0.002 > 0: the corners may come as near as that together, and nothing moves now.
TEST(FaceContact, AnOpenOnePullsNothing) {
  const BetweenNodes open(-0.02);
  ASSERT_FALSE(open.faces.empty());
  for (const Contact& c : open.faces) EXPECT_LT(BetweenNodes::way(c), 0.0);
}

// Surfaces with a radius of more than about five spacings have no rigid points; nodes keep out of
// them.
TEST(FaceContact, OnlyWhatIsSharpAndShallow) {
  EXPECT_TRUE(BetweenNodes(0.04, 0.008).points.empty());
  EXPECT_TRUE(BetweenNodes(0.15).faces.empty()) << "deeper than half of max_depth";
  EXPECT_TRUE(BetweenNodes(-0.05).faces.empty()) << "beyond the margin";
}

}  // namespace
}  // namespace thew::tests
