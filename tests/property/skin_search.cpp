// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "skin/contact/face_contact.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

constexpr double kMargin = 0.0015, kDepth = 0.004;

// A tube of 24 cm that bends in its middle, with the memory of the searches for its contacts.
struct Limb {
  Shape shape;
  Points rest;
  std::vector<char> all_free;
  std::vector<SurfacePoint> points;
  MotionHistory followed;
  ContactMemory memory, face_memory;

  explicit Limb(double radius, const Vec3& at)
      : shape(make_shape(spindle(-0.12, 0.12, 12, 23, [&](double, double) { return radius; }))) {
    for (Point& p : shape.x) p += to_point(at);
    rest = shape.x;
    all_free.assign(rest.size(), 1);
    points = rigid_points(shape.surface, rest, nullptr, 0.005);
  }
  // rad and m, from its rest pose.
  void go_to(double bend, const Vec3& by) {
    shape.x = rest;
    for (Point& p : shape.x) {
      const double angle = bend * std::clamp(0.5 + p[1] / 0.06, 0.0, 1.0);
      const Vec3 turned = Eigen::AngleAxisd(angle, Vec3::UnitX()) * to_vec(p);
      p = to_point(turned + by);
    }
    followed.advance(shape.x);
    refit_bvh(shape.surface, shape.x, shape.bvh);
    note_parts(shape.surface, shape.bvh, shape.x, followed.before, followed.parts);
  }
  Collider collider() const {
    Collider it{&shape.surface, &shape.bvh, &shape.x, &all_free, &followed, box_of(shape.x)};
    it.rigid_points = &points;
    return it;
  }
};

std::vector<Contact> contacts_of(const Limb& limb, const Limb& other, ContactMemory& memory,
                                 ContactMemory& face_memory) {
  const std::vector<Collider> colliders{limb.collider(), other.collider()};
  const ContactSettings settings{kMargin, kDepth, 6e-4};
  std::vector<Contact> contacts;
  find_contacts(colliders, 0, {1}, settings, {}, memory, contacts);
  find_face_contacts(colliders, 0, {1}, settings, {}, face_memory, contacts);
  return contacts;
}

// The nodes that a search without a motion bound finds within the margin or up to twice the depth
// inside.
std::vector<int> nodes_near(const Limb& limb, const Limb& other) {
  std::vector<int> nodes;
  for (size_t i = 0; i < limb.rest.size(); ++i) {
    const ClosestPoint near = closest_point(other.shape.surface, other.shape.bvh, other.shape.x,
                                            to_vec(limb.shape.x[i]), 1e3);
    if (near.distance < kMargin && near.distance > -2.0 * kDepth) {
      nodes.push_back(static_cast<int>(i));
    }
  }
  return nodes;
}

// Two tubes that lie along each other bend, are carried far and now and then jump into each other.
// The memory of the steps before hides no contact and saves nearly all searches.
TEST(Search, KnowsWhatCannotHaveComeNear) {
  Limb a(0.012, {0, 0, 0}), b(0.01, {0.012, 0, -0.025});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  const auto draw = [&] {  // an order of its own, which arguments have not
    Vec3 v;
    for (int k = 0; k < 3; ++k) v[k] = even(random);
    return v;
  };
  double bend = 0.0;
  Vec3 by = Vec3::Zero(), aside = Vec3::Zero();
  std::int64_t anew = 0;
  size_t found = 0, of_faces = 0, deepest = 0;
  for (int step = 0; step < 400; ++step) {
    bend = 0.8 * (1.0 - std::cos(0.05 * step));
    by += 0.01 * Vec3(1, even(random), 0);
    aside += 1e-4 * draw();
    if (step % 40 == 30) aside = (0.012 + 0.008 * even(random)) * (Vec3(0, 0, 1) + 0.4 * draw());
    if (step % 40 == 34) aside = Vec3::Zero();
    a.go_to(bend, by);
    b.go_to(bend + 0.002 * even(random), by + aside);
    ContactMemory fresh, fresh_of_faces;
    const std::vector<Contact> known = contacts_of(a, b, a.memory, a.face_memory);
    const std::vector<Contact> all = contacts_of(a, b, fresh, fresh_of_faces);
    anew += fresh.searches + fresh_of_faces.searches;
    ASSERT_EQ(known.size(), all.size()) << "step " << step;
    std::vector<int> nodes;
    for (size_t c = 0; c < all.size(); ++c) {
      ASSERT_EQ(known[c].node, all[c].node) << "step " << step;
      ASSERT_EQ(known[c].distance, all[c].distance) << "step " << step;
      if (!all[c].of_face) nodes.push_back(all[c].node);
      of_faces += all[c].of_face;
      deepest += all[c].distance < -kDepth;
    }
    ASSERT_EQ(nodes, nodes_near(a, b)) << "step " << step;
    found += nodes.size();
  }
  const std::int64_t searches = a.memory.searches + a.face_memory.searches;
  std::printf("%zu contacts of nodes, %zu of faces, %zu deep; %ld searches, %ld anew\n", found,
              of_faces, deepest, static_cast<long>(searches), static_cast<long>(anew));
  EXPECT_GT(found, 500u);
  EXPECT_GT(of_faces, 100u);
  EXPECT_GT(deepest, 50u);
  EXPECT_LT(2 * searches, anew);
}

}  // namespace
}  // namespace thew::tests
